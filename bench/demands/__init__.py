"""Named, seeded, labelled demand sets. One file in ``sets``, one set, found by its name.

Such a file has ``demands(vehicle, rng, n) -> taus (N, k)``, and where they apply:

RATE_HZ : the sampling rate of a sequence in time
COUNT : how many demands it makes unless told, and at most where it is a sequence
SEED_NAME : the set with which it shares its random numbers
answering(vehicle) : the vehicle that must answer them, if it is not the one asked for (a failure)
"""

import hashlib
import pkgutil
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import bench.demands.sets
from alloc import FloatArray, UnknownName, Vehicle, label

COUNT = 1000
"""Demands in a set. Enough for a p99 with its interval; a p99.9 comes from several passes."""


@dataclass(frozen=True, eq=False)
class DemandSet:
    """Demands, and where they lie against the limits.

    Attributes
    ----------
    name : the set's name, or a file's stem
    vehicle : the one that must answer: after a failure, the degraded one
    taus : (N, k) wrenches [N, N m], in time order where there is one
    labels : (N,) values of ``alloc.Label``
    alpha : (N,) alpha* of each demand
    rate_hz : sampling rate, None where the demands are no sequence in time
    left_out : how many more a file holds than were asked for
    """

    name: str
    vehicle: Vehicle
    taus: FloatArray
    labels: NDArray[np.int8]
    alpha: FloatArray
    rate_hz: float | None = None
    left_out: int = 0


def list_demands() -> tuple[str, ...]:
    """Names of the sets there are, sorted."""
    return tuple(sorted(_modules()))


def build_demands(name: str | Path, vehicle: Vehicle, seed: int, n: int | None = None) -> DemandSet:
    """The named set for a vehicle, or the demands in a file; always the same for the same seed.

    The generator is derived from (seed, vehicle name, set name), so that no set depends on which
    others were made before it. Raises UnknownName; NotApplicable where the vehicle has no such
    demands, with the reason; FileError or DemandError for a file that can't be read.
    """
    known = _modules()
    if name not in known:  # a set's name means that set, whatever lies in the current folder
        if _is_file(name):
            return _from_file(Path(name), vehicle, n)
        raise UnknownName(
            f"no demand set '{name}'; there are {', '.join(list_demands())}, or give a log (.csv, .bag, .ulg)"
        )
    module = import_module(f"{bench.demands.sets.__name__}.{known[str(name)]}")
    rng = np.random.default_rng(
        [seed, _stable(vehicle.name), _stable(getattr(module, "SEED_NAME", str(name)))]
    )
    count = n if n is not None else getattr(module, "COUNT", COUNT)
    taus = module.demands(vehicle, rng, count)
    answering = module.answering(vehicle) if hasattr(module, "answering") else vehicle
    return labelled(str(name), answering, taus, getattr(module, "RATE_HZ", None))


def labelled(name: str, vehicle: Vehicle, taus: FloatArray, rate_hz: float | None = None) -> DemandSet:
    """A DemandSet of given demands (N, k), with labels and alpha worked out; the arrays are frozen."""
    margins = label(vehicle, taus)
    for array in (taus, margins.label, margins.alpha):
        array.setflags(write=False)
    return DemandSet(name, vehicle, taus, margins.label, margins.alpha, rate_hz)


def _modules() -> dict[str, str]:
    # A file's underscore is a hyphen in the name.
    names = (found.name for found in pkgutil.iter_modules(bench.demands.sets.__path__))
    return {name.replace("_", "-"): name for name in names}


def _is_file(name: str | Path) -> bool:
    return isinstance(name, Path) or "/" in name or bool(Path(name).suffix) or Path(name).is_file()


def _from_file(path: Path, vehicle: Vehicle, n: int | None) -> DemandSet:
    from bench.inputs.logs import rate_hz, read_log  # a user's file is rare: loaded only where one is named

    t, taus = read_log(path, vehicle.dof)
    some = labelled(path.stem, vehicle, np.array(taus[:n]), rate_hz(t))
    return replace(some, left_out=len(taus) - len(some.taus))


def _stable(text: str) -> int:
    # Python's own hash() differs from process to process.
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little")


__all__ = ["COUNT", "DemandSet", "build_demands", "labelled", "list_demands"]
