"""The columns of results.csv about what answers deliver and what they give away.

They are the last columns, written as those of ``bench.results.columns``: to add one, add a property.
"""

from collections.abc import Callable
from statistics import median

from alloc.vehicle.geometry import DOF, MOMENTS
from bench.results.repeats import Repeats, most


class Given(Repeats):
    """What a row's answers deliver of their demands, and what they give away against the exact ones."""

    @property
    def lost_wrench_p50(self) -> float | None:
        """Median of |delivered - tau| / |tau|, delivered being what thrusts clipped to their limits push."""
        return _loss(self, "lost_wrench_p50")

    @property
    def lost_wrench_p99(self) -> float | None:
        """99 % of demands lose no more of their wrench than this share."""
        return _loss(self, "lost_wrench_p99")

    @property
    def lost_wrench_max(self) -> float | None:
        """Largest share of any demand's wrench that is not delivered."""
        return _loss(self, "lost_wrench_max")

    @property
    def lost_force_max_N(self) -> float | None:
        """Largest |delivered - tau| on any force axis."""
        return _worst_axis(self, moments=False)

    @property
    def lost_moment_max_Nm(self) -> float | None:
        """Largest |delivered - tau| on any moment axis."""
        return _worst_axis(self, moments=True)

    @property
    def answered_share(self) -> float | None:
        """Share of demands (0 to 1) that got a finite f; losses are of these."""
        return _loss(self, "answered_share", min)

    @property
    def within_1pct_share(self) -> float | None:
        """Share of demands (0 to 1) whose wrench is delivered within 1 %."""
        return _loss(self, "within_1pct_share", min)

    @property
    def within_5pct_share(self) -> float | None:
        """Share of demands (0 to 1) whose wrench is delivered within 5 %."""
        return _loss(self, "within_5pct_share", min)

    @property
    def direction_error_p50_deg(self) -> float | None:
        """Median angle between delivered and demanded wrench."""
        return _loss(self, "direction_error_p50_deg")

    @property
    def direction_error_max_deg(self) -> float | None:
        """Largest angle between delivered and demanded wrench."""
        return _loss(self, "direction_error_max_deg")

    @property
    def effort_over_optimum_p50(self) -> float | None:
        """Median of f'Hf / f*'Hf* - 1 where f meets the demand, f* the optimum of eq. 4-5."""
        return _loss(self, "effort_over_optimum_p50")

    @property
    def effort_over_optimum_max(self) -> float | None:
        """Largest f'Hf / f*'Hf* - 1."""
        return _loss(self, "effort_over_optimum_max")

    @property
    def limits_violated_share(self) -> float | None:
        """Share of answers (0 to 1) with a thrust beyond a limit, before clipping."""
        return _loss(self, "limits_violated_share")

    @property
    def thrusters_saturated_mean(self) -> float | None:
        """Mean number of thrusters at or beyond a limit."""
        return _loss(self, "thrusters_saturated_mean")

    @property
    def share_p50(self) -> str:
        """Median share (0 to 1) delivered of each level of a demand; empty where answers say none."""
        return _by_level([j.share_p50 for j in self.judged], median)

    @property
    def share_min(self) -> str:
        """Least share (0 to 1) delivered of each level of any demand, first level first."""
        return _by_level([j.share_min for j in self.judged], min)


def _by_level(repeats: list[list[float]], of: Callable[[list[float]], float]) -> str:
    levels = zip(*(shares for shares in repeats if shares), strict=True)
    return " ".join(f"{of(list(shares)):.6g}" for shares in levels)


def _loss(row: Repeats, key: str, worst: Callable[[list[float]], float] = max) -> float | None:
    values = [value for j in row.judged if (value := j.loss.get(key)) is not None]
    return worst(values) if values else None


def _worst_axis(row: Repeats, moments: bool) -> float | None:
    suffix = "max_Nm" if moments else "max_N"
    axes = [axis for axis in DOF if (axis in MOMENTS) == moments]
    return most(_loss(row, f"wrench_error_{axis}_{suffix}") for axis in axes)
