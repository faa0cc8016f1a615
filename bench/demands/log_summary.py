"""Summary of a log of demands: rate, gaps, labels, and the time for which it asks too much."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from alloc import Label
from alloc.allocation import BoolArray, FloatArray
from alloc.vehicle.geometry import unit
from bench.demands import DemandSet
from bench.inputs.logs import after_gaps


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


def summarise(demands: DemandSet, t: FloatArray | None) -> Summary:
    """The Summary of a labelled log with times ``t`` (N,) [s] or None.

    Each demand holds until the next one, but over a gap for one median step only: nobody knows what was
    demanded in between.
    """
    steps = None if t is None or len(t) < 2 else np.diff(t)
    held = np.ones(len(demands.taus))
    duration = gaps = longest = None
    if steps is not None and t is not None and np.median(steps) > 0:
        median = float(np.median(steps))
        is_gap = np.isin(np.arange(1, len(t)), after_gaps(t))
        held = np.append(np.where(is_gap, median, steps), median)
        duration, gaps = float(t[-1] - t[0]), int(is_gap.sum())
        longest = float(steps[is_gap].max(initial=0.0))
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


def as_text(summary: Summary, demands: DemandSet) -> str:
    """The Summary as lines of ``what  how much``."""
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
    return aligned(lines)


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
