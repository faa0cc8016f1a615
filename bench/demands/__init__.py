"""Named, seeded, labelled demand sets. Each file in ``sets`` is one set, named after the file.

Such a file has ``demands(vehicle, rng, n) -> taus (N, k)``, or where every demand comes with limits of its
own ``limited_demands(vehicle, rng, n) -> CallDemands``; and where they apply:

RATE_HZ : the sampling rate of a sequence in time
COUNT : how many demands the set has by default; where it is a sequence, also the most it can have
SEED_NAME : the set with which it shares its random numbers
supply(vehicle) : the cap and the voltage of each call, as a Supply
answering(vehicle) : the vehicle that must answer the demands, where that is a degraded one
start(vehicle, taus, n) : of a sequence that is judged whole, the first of the n demands that are timed
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import Label, NotApplicable, Vehicle, alpha_max, label
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import unknown
from alloc.files import modules
from alloc.vehicle.azimuth import refuse_azimuths
from alloc.vehicle.call_limits import limits_of
from bench.demands.strong import strong_demands, strong_vehicle, unasked_weak_axes

if TYPE_CHECKING:
    from bench.inputs.logs import LogOptions

SETS = "bench.demands.sets"
COUNT = 1000
"""Demands in a set by default: enough for a p99 with its interval; a p99.9 comes from several passes."""


ATTAINED = 1 - 1e-9
"""alpha* from which a demand counts as one that can be met: 1 but for rounding. The labels' band is wider."""


class CallDemands(NamedTuple):
    """Demands with the limits of the call that each is made in.

    Attributes
    ----------
    taus : (N, k) wrenches [N, N m]
    f_min, f_max : (N, n) limits [N]
    f_previous : (N, n) thrusts of the call before [N]; None where nobody knows them
    """

    taus: FloatArray
    f_min: FloatArray
    f_max: FloatArray
    f_previous: FloatArray | None = None


class Supply(NamedTuple):
    """Arguments of a call beside its demand and limits.

    Attributes
    ----------
    cap : most current of all thrusters together [A]; None where calls have none
    volts : voltage of the currents [V]; None for the nominal one
    """

    cap: float | None = None
    volts: float | None = None

    @property
    def arguments(self) -> dict[str, float]:
        """The keyword arguments: none without a cap."""
        pairs = self._asdict().items() if self.cap is not None else ()
        return {key: value for key, value in pairs if value is not None}


NO_SUPPLY = Supply()
"""The supply of calls without a cap."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DemandSet:
    """Demands on a vehicle, and where they lie against its limits.

    Attributes
    ----------
    name : the set's name, or a file's stem
    vehicle : the vehicle that must answer; after a failure, the degraded one
    taus : (N, k) wrenches [N, N m], in time order where there is one
    labels : (N,) values of ``alloc.Label``
    alpha : (N,) alpha* of each demand
    hard_labels, hard_alpha : the same of eq. 4-5, which holds weak directions at the demand; None where no
        direction is weak but those that are lost. There ``labels`` and ``alpha`` are of the strong part
    rate_hz : sampling rate, None where the demands are no sequence in time
    left_out : demands of a file, or of a sequence, that are beyond the number asked for
    part : of a sequence that is judged whole, the first demand that is timed and the one after the last; None
        where all are timed
    beyond, beyond_longest : of all demands of a file, these included, how many can't be met, and how many of
        them follow one another at most
    crossed : of all demands of a file, how many have limits that cross; ``beyond`` is without them
    notes : how a file was understood, and what is doubtful about it, one line each
    given : whether they come from a file
    gaps : which of them follow a gap in time
    f_min, f_max : (N, n) limits of each demand [N]; None where all have the vehicle's
    f_previous : (N, n) thrusts of the call before [N], which such limits lie around; None where unknown
    supply : cap and voltage of each call; ``labels`` and ``alpha`` are of what is left under the cap
    """

    name: str
    vehicle: Vehicle
    taus: FloatArray
    labels: NDArray[np.int8]
    alpha: FloatArray
    hard_labels: NDArray[np.int8] | None = None
    hard_alpha: FloatArray | None = None
    rate_hz: float | None = None
    left_out: int = 0
    part: tuple[int, int] | None = None
    beyond: int = 0
    beyond_longest: int = 0
    crossed: int = 0
    notes: tuple[str, ...] = ()
    given: bool = False
    gaps: tuple[int, ...] = ()
    f_min: FloatArray | None = None
    f_max: FloatArray | None = None
    f_previous: FloatArray | None = None
    supply: Supply = NO_SUPPLY

    def labels_for(self, *, strong: bool) -> NDArray[np.int8]:
        """``labels`` (N,) of the strong part, or of eq. 4-5."""
        return self.labels if strong or self.hard_labels is None else self.hard_labels

    @cached_property
    def strong(self) -> tuple[Vehicle, FloatArray]:
        """The vehicle without weak directions, and what demands (N, k) ask of it [N, N m]."""
        return strong_vehicle(self.vehicle), strong_demands(self.vehicle, self.taus)

    @property
    def unmet(self) -> BoolArray:
        """(N,) whether each demand can't be met."""
        return _unmet(self.labels, self.alpha)

    @property
    def crossing(self) -> BoolArray:
        """(N,) whether each demand has limits that cross: nobody can keep them."""
        return crossing(len(self.taus), self.f_min, self.f_max)

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """f_min and f_max of each demand (N, n), or of all (n,) [N]."""
        if self.f_min is None or self.f_max is None:
            return self.vehicle.f_min, self.vehicle.f_max
        return self.f_min, self.f_max


def list_demands() -> tuple[str, ...]:
    """Names of all sets, sorted."""
    return tuple(modules.names(SETS))


def build_demands(
    name: str | Path,
    vehicle: Vehicle,
    seed: int,
    n: int | None = None,
    log: "LogOptions | None" = None,
    *,
    whole: bool = False,
) -> DemandSet:
    """The named set for a vehicle, or the demands in a file; always the same for the same seed.

    ``log`` says what a file does not say itself. ``whole`` asks for all of a mission, of which n demands are
    timed: what is attainable in half a second of it tells nothing of its half-minute.

    The generator is derived from (seed, vehicle name, set name), so that no set depends on which
    others were made before it. Raises UnknownName; NotApplicable where the vehicle has no such
    demands, with the reason; FileError or DemandError for a file that can't be read.
    """
    if name not in list_demands():  # a set's name means the set, even beside a file of that name
        if _is_file(name):
            return _from_file(Path(name), vehicle, n, log)
        raise unknown("demand set", str(name), list_demands(), "; or give a log (.csv, .bag, .mcap, .ulg)")
    module = modules.module(SETS, str(name))
    rng = np.random.default_rng(
        [seed, _stable(vehicle.name), _stable(getattr(module, "SEED_NAME", str(name)))]
    )
    count = n if n is not None else getattr(module, "COUNT", COUNT)
    answering = module.answering(vehicle) if hasattr(module, "answering") else vehicle
    rate_hz = getattr(module, "RATE_HZ", None)
    if hasattr(module, "limited_demands"):
        refuse_azimuths(vehicle.azimuths, f"demand set '{name}'", "limits of a call are boxes")
        taus, *limits, f_previous = module.limited_demands(vehicle, rng, count)
        part = None
    else:
        judged_whole = whole and hasattr(module, "start") and count < module.COUNT
        taus, limits = module.demands(vehicle, rng, module.COUNT if judged_whole else count), []
        f_previous = None
        first = module.start(vehicle, taus, count) if judged_whole else 0
        part = (first, first + count) if judged_whole else None
    supply = module.supply(answering) if hasattr(module, "supply") else NO_SUPPLY
    wrenches = unasked_weak_axes(answering, taus)
    made = labelled(str(name), answering, wrenches, *limits, rate_hz=rate_hz, supply=supply)
    cut = max(0, module.COUNT - count) if rate_hz is not None and part is None else 0
    return replace(made, part=part, left_out=cut, f_previous=f_previous)


def along_axes(vehicle: Vehicle, n: int) -> FloatArray:
    """No demand at all, n along each axis alone, beyond its ends too, then on two axes each: (N, k) [N, N m].

    None along one alone where the limits do not let the wrench be zero, since the axes meet there. On two
    axes there are demands of half of what the vehicle can do, with every pair of signs.
    """
    rest = np.zeros((1, vehicle.k))
    unit = np.diag(vehicle.wrench_scale)
    pairs = [
        a + b for i, one in enumerate(unit) for a in (one, -one) for two in unit[:i] for b in (two, -two)
    ]
    two = np.reshape(pairs, (-1, vehicle.k))
    reached = alpha_max(strong_vehicle(vehicle), strong_demands(vehicle, two)) if len(two) else np.zeros(0)
    two = two * np.where((reached > 0) & np.isfinite(reached), 0.5 * reached, 0.5)[:, None]
    try:
        return np.vstack([rest, build_demands("axes", vehicle, 0, n).taus, two])
    except NotApplicable:
        return np.vstack([rest, two])


def labelled(
    name: str,
    vehicle: Vehicle,
    taus: FloatArray,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
    *,
    rate_hz: float | None = None,
    supply: Supply = NO_SUPPLY,
) -> DemandSet:
    """A DemandSet of given demands (N, k), maybe with limits of each (N, n); labels and alpha are worked out.

    The arrays are frozen.
    """
    if f_min is not None or f_max is not None:
        f_min, f_max = limits_of(vehicle, len(taus), f_min, f_max)
    hard = label(vehicle, taus, f_min=f_min, f_max=f_max, **supply.arguments)
    strong = strong_vehicle(vehicle)
    whole = strong is vehicle
    margins = hard
    if not whole:
        part = strong_demands(vehicle, taus)
        margins = label(strong, part, f_min=f_min, f_max=f_max, **supply.arguments)
    for array in (taus, *margins[:2], *hard[:2], f_min, f_max):
        if array is not None:
            array.setflags(write=False)
    return DemandSet(
        name=name,
        vehicle=vehicle,
        taus=taus,
        labels=margins.label,
        alpha=margins.alpha,
        hard_labels=None if whole else hard.label,
        hard_alpha=None if whole else hard.alpha,
        rate_hz=rate_hz,
        f_min=f_min,
        f_max=f_max,
        supply=supply,
    )


def _is_file(name: str | Path) -> bool:
    return isinstance(name, Path) or "/" in name or bool(Path(name).suffix) or Path(name).exists()


def _from_file(path: Path, vehicle: Vehicle, n: int | None, options: "LogOptions | None") -> DemandSet:
    from bench.inputs.log_limits import row_limits
    from bench.inputs.logs import (  # imported only where a file is named, which is rare
        after_gaps,
        log_for,
        rate_hz,
    )

    log = log_for(vehicle, path, options)
    low, high = row_limits(path, log.columns, vehicle)
    strong = strong_vehicle(vehicle), strong_demands(vehicle, log.taus)
    margins = label(*strong, f_min=low, f_max=high)
    crossed = crossing(len(log.taus), low, high)
    unmet = _unmet(margins.label, margins.alpha) & ~crossed
    low, high = (None if side is None else side[:n] for side in (low, high))
    demands = labelled(path.stem, vehicle, np.array(log.taus[:n]), low, high, rate_hz=rate_hz(log.t))
    gaps = after_gaps(log.t)
    return replace(
        demands,
        gaps=tuple(i for i in gaps if i < len(demands.taus)),
        left_out=len(log.taus) - len(demands.taus),
        beyond=int(unmet.sum()),
        beyond_longest=longest(unmet, gaps),
        crossed=int(crossed.sum()),
        notes=tuple(filter(None, (log.notes, log.doubt, of_limits(demands.name, crossed)))),
        given=True,
    )


def crossing(N: int, low: FloatArray | None, high: FloatArray | None) -> BoolArray:
    """(N,) whether some limits (N, n) of each demand cross; nowhere without limits."""
    if low is None or high is None:
        return np.zeros(N, dtype=bool)
    crosses: BoolArray = np.any(low > high, axis=1)
    return crosses


def of_limits(log: str, crosses: BoolArray) -> str:
    """A line where limits of demands cross; empty where none do."""
    if not crosses.any():
        return ""
    return (
        f"{log}: limits cross in {np.count_nonzero(crosses):,} of {len(crosses):,} demands, first in demand"
        f" {crosses.argmax()} (counted from 0); no thrust lies within them, so no method can keep them"
    )


def _unmet(labels: NDArray[np.int8], alpha: FloatArray) -> BoolArray:
    """Mask of demands that can't be met, by alpha* at the boundary too, by labels for those too small."""
    unmet: BoolArray = (alpha < ATTAINED) | (labels == Label.INFEASIBLE)
    return unmet


def longest(marked: BoolArray, gaps: Sequence[int] = ()) -> int:
    """The longest run of marked entries, one after another and none of ``gaps`` but the first."""
    apart = np.insert(marked, list(gaps), False)  # nobody knows what was between
    ends = np.flatnonzero(np.diff(np.concatenate([[0], apart.astype(np.int8), [0]])))
    return int((ends[1::2] - ends[::2]).max(initial=0))


def _stable(text: str) -> int:
    # Python's own hash() differs from process to process.
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little")


__all__ = [
    "ATTAINED",
    "COUNT",
    "CallDemands",
    "DemandSet",
    "Supply",
    "build_demands",
    "labelled",
    "list_demands",
    "longest",
]
