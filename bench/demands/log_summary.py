"""Summaries of logs: of demands, what they ask and for how long too much; of outputs, the wrench made."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alloc import AllocError, Label, Vehicle, alpha_max, build
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.vehicle.geometry import unit
from alloc.vehicle.limits import Interval
from bench.demands import ATTAINED, DemandSet
from bench.demands.strong import axis_maxima, strong_demands, strong_vehicle
from bench.inputs.columns import VOLTS
from bench.inputs.logs import after_gaps
from bench.inputs.outputs import Outputs

EXACT = "scaled"
"""Method that delivers as much of each demand as thrusters can along it."""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Numbers about one log; times are None where the log has none.

    Attributes
    ----------
    n : number of demands
    duration_s, rate_hz : of the log, gaps included; the rate is one over the median step
    under_demand_s : time for which demands hold, gaps left out: the base of shares and of time outside
    gaps, longest_gap_s : number of steps longer than three median ones, and the longest
    share : share of ``under_demand_s`` under each label, or of demands where the log has no times
    closed_form : share for which a closed form stays within the limits: that of the inactive demands
    outside_s, longest_outside_s : time outside the attainable set, and its longest stretch
    alpha_min : smallest alpha*, the factor by which the worst demand must be scaled down
    largest : (k,) largest |demand| on each axis [N, N m]
    """

    n: int
    duration_s: float | None
    under_demand_s: float | None
    rate_hz: float | None
    gaps: int | None
    longest_gap_s: float | None
    share: dict[Label, float]
    closed_form: float
    outside_s: float | None
    longest_outside_s: float | None
    alpha_min: float
    largest: FloatArray


def hold_times(t: FloatArray | None) -> FloatArray | None:
    """Time (N,) for which each demand of times ``t`` (N,) holds [s]; None for a log without times.

    A demand holds until the next one, but over a gap for one median step only: nobody knows what was demanded
    in between.
    """
    if t is None or len(t) < 2:
        return None
    steps = np.diff(t)
    median = float(np.median(steps))
    if not median > 0:
        return None
    steps[[i - 1 for i in after_gaps(t)]] = median
    return np.append(steps, median)


def summarise(demands: DemandSet, t: FloatArray | None) -> Summary:
    """The Summary of a labelled log with times ``t`` (N,) [s] or None."""
    times = hold_times(t)
    held = np.ones(len(demands.taus)) if times is None else times
    duration = gaps = longest = None
    if times is not None and t is not None:
        jumps = np.diff(t)[[i - 1 for i in after_gaps(t)]]
        duration, gaps, longest = float(t[-1] - t[0]), len(jumps), float(jumps.max(initial=0.0))
    share = {label: float(held[demands.labels == label].sum() / held.sum()) for label in Label}
    outside = demands.unmet
    timed = duration is not None
    return Summary(
        n=len(demands.taus),
        duration_s=duration,
        under_demand_s=float(held.sum()) if timed else None,
        rate_hz=demands.rate_hz,
        gaps=gaps,
        longest_gap_s=longest,
        share=share,
        closed_form=share[Label.INACTIVE],
        outside_s=float(held[outside].sum()) if timed else None,
        longest_outside_s=_longest_stretch(outside, held, set(after_gaps(t))) if timed else None,
        alpha_min=float(demands.alpha.min()),
        largest=np.abs(demands.taus).max(axis=0),
    )


def demands_text(summary: Summary, demands: DemandSet, more: Sequence[tuple[str, str]] = ()) -> str:
    """The Summary, and ``more``, as lines of ``what  how much``."""
    s, vehicle = summary, demands.vehicle
    lines, base = [("demands", str(s.n))], "demands"
    if s.duration_s is not None and s.rate_hz is not None:
        base = f"{s.under_demand_s:.2f} s"
        lines += [("duration", f"{s.duration_s:.2f} s, gaps included"), ("rate", f"{s.rate_hz:.4g} Hz")]
        lines.append(("gaps", f"{s.gaps}, the longest {s.longest_gap_s:.3g} s" if s.gaps else "none"))
        lines.append(("time under demands", f"{base}; a gap counts one step"))
    for label, share in s.share.items():
        lines.append((label.name.lower(), f"{100 * share:.2f} % of {base}"))
    lines.append(("closed form within limits", f"{100 * s.closed_form:.2f} % of {base}"))
    if s.outside_s is not None:
        stretch = f"at a stretch {s.longest_outside_s:.2f} s"
        lines.append(("outside the attainable set", f"{s.outside_s:.2f} s of {base}, {stretch}"))
    lines.append(("smallest alpha*", f"{s.alpha_min:.3g}"))
    for axis, largest in zip(vehicle.dof, s.largest, strict=True):
        lines.append((f"largest {axis}", f"{largest:.4g} {unit(axis)}"))
    return aligned([*lines, *more])


def aligned(lines: Sequence[tuple[str, str]]) -> str:
    """Lines of ``what  how much``, the second parts below each other."""
    width = max(len(what) for what, _ in lines)
    return "\n".join(f"{what:{width}}  {value}" for what, value in lines)


def _longest_stretch(outside: BoolArray, held: FloatArray, gaps: set[int]) -> float:
    longest = current = 0.0
    for i, (is_outside, seconds) in enumerate(zip(outside.tolist(), held.tolist(), strict=True)):
        before = 0.0 if i in gaps else current
        current = before + seconds if is_outside else 0.0
        longest = max(longest, current)
    return longest


class Undone(NamedTuple):
    """Part of the demands that was not made.

    Attributes
    ----------
    axes : (m,) of which the log has demands
    mean, most : (m,) |demanded - made| on average and at most [N, N m]
    attainable : share of the demands that thrusters meet within limits, at each row's voltage where it has
        one; NaN where axes are missing
    lost : (m,) mean of |demanded - made| over those that could have been met [N, N m]
    exact : (2, m) mean and largest part of the demands that EXACT leaves undone within the same limits, asked
        on missing axes for what was made [N, N m]; NaN where it refuses the vehicle
    """

    axes: tuple[str, ...]
    mean: FloatArray
    most: FloatArray
    attainable: float
    lost: FloatArray
    exact: FloatArray


class Delivered(NamedTuple):
    """Wrenches that N rows of outputs made.

    Attributes
    ----------
    f, taus : (N, n) thrusts [N]; (N, k) wrenches T P f [N, N m]
    at_end, in_dead_band : (n,) share of rows with the command at an end of its range; not neutral, and still
        making nothing
    outside : share of rows whose voltage the curve does not cover; NaN where it says no voltage
    undone : what of the demands was not made; None where the log has none in newtons
    """

    f: FloatArray
    taus: FloatArray
    at_end: FloatArray
    in_dead_band: FloatArray
    outside: float
    undone: Undone | None


def made_by(outputs: Outputs, vehicle: Vehicle, scale: tuple[float, ...] = ()) -> Delivered:
    """Wrenches made by outputs, by the curve in the vehicle's ``esc`` at the voltage of each row.

    ``scale`` are factors of all DOF, or of each, over the log's demands [N, N m]; left out, a share of 1 is
    the ``full_authority`` of its axis, where the log is known to have shares.
    """
    u, volts = outputs.u, outputs.volts
    f = vehicle.thrusts(u, volts)
    taus = f @ vehicle.TP.T
    neutral, low, high, step = (
        np.array([getattr(esc, key) for esc in vehicle.esc]) for key in ("neutral", "low", "high", "step")
    )
    at_end = (u <= low + step / 2) | (u >= high - step / 2)
    dead = (f == 0) & (np.abs(u - neutral) >= step / 2)
    measured = [esc for esc in vehicle.esc if not np.isnan(esc.volts[0])]
    outside = np.nan
    if volts is not None and measured:
        outside = float(np.mean([esc.outside(volts) for esc in measured]))
    undone = None
    if outputs.taus is not None:
        alone = full_authority(vehicle) if outputs.shares and not scale else 1.0
        factors = np.broadcast_to(scale or alone, (vehicle.k,))
        undone = _undone(vehicle, outputs.taus * factors, taus, _limits(vehicle, volts, len(u)))
    return Delivered(f, taus, at_end.mean(axis=0), dead.mean(axis=0), outside, undone)


def extra_columns(volts: FloatArray | None, vehicle: Vehicle) -> tuple[dict[str, FloatArray], str]:
    """The columns beside made wrenches that a log of demands for the vehicle has, and what is to be said.

    Voltages (N,) beyond the vehicle's table become its nearest, whose curve was taken: limits stop there too.
    """
    if volts is None:
        return {}, ""
    if vehicle.by_volts is None:
        return {}, f"volts are left out, as {vehicle.name} has no limits by voltage"
    least, most = vehicle.by_volts.volts[[0, -1]]
    held = np.clip(volts, least, most)
    moved = np.count_nonzero(held != volts)
    said = f"volts of {moved} of {len(volts)} rows lie beyond the vehicle's table, {least:g} to {most:g} V"
    return {VOLTS: held}, f"{said}, and are written as its nearest" if moved else ""


def full_authority(vehicle: Vehicle) -> FloatArray:
    """(k,) the smaller of the largest wrenches both ways on each axis alone [N, N m]."""
    backward, forward = axis_maxima(vehicle)
    smaller: FloatArray = np.minimum(-backward, forward)
    return smaller


def _limits(vehicle: Vehicle, volts: FloatArray | None, count: int) -> Interval:
    """Limits that ESCs make at each voltage (count, n) [N]; beyond the table those of its end."""
    low, high = (np.tile(side, (count, 1)) for side in (vehicle.f_min, vehicle.f_max))
    if volts is not None and vehicle.by_volts is not None:
        at_least, at_most = vehicle.by_volts.between(volts)
        low, high = np.fmax(at_least, low), np.fmin(at_most, high)  # of NaN volts the vehicle's own
    return vehicle.esc_limits(volts, low, high)


def _undone(
    vehicle: Vehicle,
    asked: FloatArray,
    made: FloatArray,
    limits: Interval,
) -> Undone | None:
    known = np.array([np.isfinite(column).any() for column in asked.T])
    if not known.any():
        return None
    rows = np.isfinite(asked[:, known]).all(axis=1)
    if not rows.any():
        return None
    asked, made = asked[rows], made[rows]
    low, high = (side[rows] for side in limits)
    missed = np.abs(asked - made)[:, known]
    axes = tuple(axis for axis, there in zip(vehicle.dof, known.tolist(), strict=True) if there)
    attainable: BoolArray = np.ones(len(asked), dtype=bool)
    share = np.nan
    if known.all():
        attainable = alpha_max(strong_vehicle(vehicle), strong_demands(vehicle, asked), low, high) >= ATTAINED
        share = float(attainable.mean())
    lost = missed[attainable].mean(axis=0) if attainable.any() else np.zeros(len(axes))
    exact = np.full((2, len(axes)), np.nan)
    with suppress(AllocError):  # too many facets, or all that is left is weak
        whole = np.where(known, asked, made)
        F, _ = build(EXACT, vehicle).many(whole, f_min=low, f_max=high)
        left = np.abs(whole - F @ vehicle.TP.T)
        left[left <= WRENCH_TOLERANCE * vehicle.wrench_scale] = 0.0
        left = left[:, known]
        exact = np.array([left.mean(axis=0), left.max(axis=0)])
    return Undone(axes, missed.mean(axis=0), missed.max(axis=0), share, lost, exact)


def outputs_text(
    made: Delivered, outputs: Outputs, vehicle: Vehicle, more: Sequence[tuple[str, str]] = ()
) -> str:
    """The numbers, and ``more``, as lines of ``what  how much``."""
    lines = [("rows", f"{len(outputs.u)}")]
    if outputs.t is not None:
        lines.append(("duration", f"{outputs.t[-1] - outputs.t[0]:.4g} s, gaps included"))
    if outputs.volts is not None:
        lines.append(("battery", f"{outputs.volts.min():.4g} … {outputs.volts.max():.4g} V"))
        alike = "not known: thrusts are taken as alike at every voltage"
        lines.append(
            (
                "voltage outside of the curve",
                alike if np.isnan(made.outside) else f"{100 * made.outside:.2f} % of rows",
            )
        )
    for axis, row in zip(vehicle.dof, made.taus.T, strict=True):
        lines.append((f"made {axis}", f"{row.min():.4g} … {row.max():.4g} {unit(axis)}"))
    for i in range(vehicle.n):
        shares = (
            f"{100 * made.at_end[i]:.2f} % of rows at its end,"
            f" {100 * made.in_dead_band[i]:.2f} % in its dead band, not at neutral"
        )
        lines.append((vehicle.called(i), shares))
    if (undone := made.undone) is None:
        lines.append(("left undone", "not known: no row has commands and a demand"))
    else:
        if not np.isnan(undone.attainable):
            lines.append(("demands that could be met", f"{100 * undone.attainable:.2f} % of rows with one"))
        columns = undone.axes, undone.mean, undone.most, undone.lost, undone.exact.T
        for axis, mean, most, lost, exact in zip(*columns, strict=True):
            said = f"{mean:.4g} {unit(axis)} on average, {most:.4g} at most"
            if not np.isnan(undone.attainable):
                said += f", {lost:.4g} {unit(axis)} of those that could be met"
            if not np.isnan(exact).any():
                said += f"; {EXACT} leaves {exact[0]:.4g} {unit(axis)} on average, {exact[1]:.4g} at most"
            lines.append((f"left undone, {axis}", said))
    return aligned([*lines, *more])
