"""Columns that are worked out from judgements: how right answers are, what they deliver and give away."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import TYPE_CHECKING, Any

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.record import FARTHER, Judged
from bench.results.repeats import Repeats, calls, most


class Worst(property):
    """A column with the worst number of the judgements of a row's repeats, None where none has it."""

    def __init__(
        self,
        meaning: str,
        of: Callable[[Judged], float | None],
        worst: Callable[[list[float]], float] = max,
    ) -> None:
        """Make the column of what it means, of the number of one judgement, and of what is worse."""

        def column(row: Any) -> float | None:
            values = [value for judged in row.measured.judged if (value := of(judged)) is not None]
            return worst(values) if values else None

        column.__doc__ = meaning  # as ``doc`` of a subclass's property, CPython 3.11 would lose it
        super().__init__(column)

    if TYPE_CHECKING:  # mypy takes the value of a property for Any unless a decorator made it
        # Of a class it would be itself, which nobody asks.
        def __get__(self, row: Any, owner: type | None = None, /) -> float | None: ...  # type: ignore[override]


def by_level(repeats: list[list[float]], of: Callable[[list[float]], float]) -> str:
    """One number of each level of a demand, over the repeats, in a cell; empty without levels."""
    levels = zip(*(shares for shares in repeats if shares), strict=True)
    return " ".join(f"{of(list(shares)):.6g}" for shares in levels)


def worst_axis(judged: Judged, moments: bool) -> float | None:
    """Largest |delivered - tau| on any force axis [N], or on any moment axis [N m]."""
    suffix = "max_Nm" if moments else "max_N"
    axes = [axis for axis in DOF if (axis in MOMENTS) == moments]
    return most(judged.loss.get(f"wrench_error_{axis}_{suffix}") for axis in axes)


@dataclass(frozen=True)
class Judgements:
    """Judgements of a line of results.csv; its properties are columns behind those of ``Row``.

    Attributes
    ----------
    measured : the repeats that the columns are worked out from
    """

    measured: Repeats

    @cached_property
    def agreed(self) -> bool | None:
        """``agrees`` as True or False; None where no right answer is known."""
        verdicts = {judged.agrees for judged in self.measured.judged if judged.agrees is not None}
        return None if not verdicts else verdicts == {True}

    wrench_error_relative = Worst(
        "Largest wrench error over the size of a wrench on its axis (row of T times the largest limit).",
        lambda j: j.wrench_error_rel_max,
    )
    distance_relative = Worst(
        "``distance_max_N`` over the largest thrust limit.", lambda j: j.distance_rel_max
    )
    gap_relative = Worst(
        "Largest relative duality gap: a certificate that needs no reference.", lambda j: j.gap_rel_max
    )
    failed_after_failure_share = Worst(
        "Share (0 to 1) without thrusts, of attainable demands right after an answer without thrusts.",
        lambda j: j.failed_after_failure,
    )

    @property
    def disbelieved(self) -> str:
        """Statuses that were not believed, with calls: false INFEASIBLE, unknown exit flags."""
        counts = sum((Counter(cell.disbelieved) for cell in self.measured.cells), Counter())
        n_calls = sum(map(calls, self.measured.cells))
        return "; ".join(f"{what} ({count:,} of {n_calls:,} calls)" for what, count in counts.items())

    tolerance = Worst("Distance over the largest thrust limit that ``agrees`` allows.", lambda j: j.tolerance)

    @property
    def wrong(self) -> str:
        """Reason why an answer is wrong, of a plug-in one on another set, too; empty where none is."""
        own = next((j.wrong for j in self.measured.judged if j.wrong), "") or self.measured.wrong_elsewhere
        on_others = self.measured.wrong_on_others
        return own or (FARTHER if on_others and self.agreed is False else on_others)

    lost_wrench_p50 = Worst(
        "Median of |delivered - tau| / |tau|, delivered being what thrusts clipped to their limits push.",
        lambda j: j.loss.get("lost_wrench_p50"),
    )
    lost_wrench_p99 = Worst(
        "99 % of demands lose no more of their wrench than this share.",
        lambda j: j.loss.get("lost_wrench_p99"),
    )
    lost_wrench_max = Worst(
        "Largest share of any demand's wrench that is not delivered.", lambda j: j.loss.get("lost_wrench_max")
    )
    lost_force_max_N = Worst(
        "Largest |delivered - tau| on any force axis.", lambda j: worst_axis(j, moments=False)
    )
    lost_moment_max_Nm = Worst(
        "Largest |delivered - tau| on any moment axis.", lambda j: worst_axis(j, moments=True)
    )
    answered_share = Worst(
        "Share of demands (0 to 1) that got a finite f; losses are of these.",
        lambda j: j.loss.get("answered_share"),
        min,
    )
    within_1pct_share = Worst(
        "Share of demands (0 to 1) whose wrench is delivered within 1 %.",
        lambda j: j.loss.get("within_1pct_share"),
        min,
    )
    within_5pct_share = Worst(
        "Share of demands (0 to 1) whose wrench is delivered within 5 %.",
        lambda j: j.loss.get("within_5pct_share"),
        min,
    )
    direction_error_p50_deg = Worst(
        "Median angle between delivered and demanded wrench.", lambda j: j.loss.get("direction_error_p50_deg")
    )
    direction_error_max_deg = Worst(
        "Largest angle between delivered and demanded wrench.",
        lambda j: j.loss.get("direction_error_max_deg"),
    )
    effort_over_optimum_p50 = Worst(
        "Median of f'Hf / f*'Hf* - 1 where f meets the demand, f* the optimum of eq. 4-5.",
        lambda j: j.loss.get("effort_over_optimum_p50"),
    )
    effort_over_optimum_max = Worst(
        "Largest f'Hf / f*'Hf* - 1.", lambda j: j.loss.get("effort_over_optimum_max")
    )
    limits_violated_share = Worst(
        "Share of answers (0 to 1) with a thrust beyond a limit, before clipping.",
        lambda j: j.loss.get("limits_violated_share"),
    )
    thrusters_saturated_mean = Worst(
        "Mean number of thrusters at or beyond a limit.", lambda j: j.loss.get("thrusters_saturated_mean")
    )

    @property
    def share_p50(self) -> str:
        """Median share (0 to 1) delivered of each level of a demand; empty where answers say none."""
        return by_level([j.share_p50 for j in self.measured.judged], median)

    @property
    def share_min(self) -> str:
        """Least share (0 to 1) delivered of each level of any demand, first level first."""
        return by_level([j.share_min for j in self.measured.judged], min)
