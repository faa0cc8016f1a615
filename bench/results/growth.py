"""The growth study's results: times and bytes over the number of thrusters, and their exponents."""

from collections.abc import Mapping
from dataclasses import dataclass

from bench.results.columns import Row
from bench.results.quantiles import group
from bench.results.ranking import is_exact
from bench.results.rows import Run

STUDY = "growth"
"""The name that the study's problems carry in a record."""
FITTED_FROM = 12
"""Fewest thrusters that an exponent is fitted to: with fewer, the fixed cost of a call hides the growth."""


@dataclass(frozen=True)
class Series:
    """One method on the generated vehicles with k degrees of freedom.

    Attributes
    ----------
    k : degrees of freedom
    label : method, start and level
    rows : by number of thrusters, failed ones included
    """

    k: int
    label: str
    rows: dict[int, Row]

    @property
    def solver(self) -> str:
        """The QP solver that the method calls, empty for none."""
        return next(iter(self.rows.values())).described.solver

    def times_us(self) -> dict[int, float]:
        """Median call [us] by number of thrusters, where it was measured."""
        return _known({n: row.call_p50_us for n, row in self.rows.items() if not row.failed})

    def kilobytes(self) -> dict[int, float]:
        """Size of the allocator [kB] by number of thrusters, where it was measured."""
        sizes = _known({n: row.allocator_bytes for n, row in self.rows.items() if not row.failed})
        return {n: size / 1000 for n, size in sizes.items()}


def series(run: Run) -> list[Series]:
    """Every method on every family of generated vehicles, by k and label; [] without a study."""
    shapes = {p.vehicle: (len(p.dof), p.n) for p in run.record.problems if p.study == STUDY}
    rows = (row for row in run.rows if row.vehicle in shapes and not row.described.yardstick)
    by_size = sorted(rows, key=lambda row: shapes[row.vehicle])
    by_method = group(by_size, lambda row: (shapes[row.vehicle][0], row.label))
    return [
        Series(k, label, {shapes[row.vehicle][1]: row for row in own})
        for (k, label), own in sorted(by_method.items())
    ]


def exponent(values: dict[int, float]) -> tuple[float, float] | None:
    """Exponent p of value ~ n^p and its standard error, from logarithms; None below three points."""
    from math import log

    from scipy.stats import linregress

    points = [(log(n), log(value)) for n, value in values.items() if n >= FITTED_FROM and value > 0]
    if len(points) < 3:
        return None
    if len({y for _, y in points}) == 1:  # linregress gives no standard error for equal values
        return 0.0, 0.0
    fit = linregress([x for x, _ in points], [y for _, y in points])
    return float(fit.slope), float(fit.stderr)


def pays_up_to(family: list[Series]) -> tuple[int | None, list[int]]:
    """The largest n up to which an exact closed form beats every exact solver, None where it never does.

    ``family`` holds the series of one k. Also returned are the sizes at the upper end for which no exact
    closed form was measured.
    """
    sizes = sorted({n for s in family for n in s.rows})
    best: int | None = None
    without: list[int] = []
    ahead = True
    for n in sizes:
        times = [(s.times_us().get(n), s.solver) for s in family if n in s.rows and is_exact(s.rows[n])]
        closed = min((us for us, solver in times if us and not solver), default=None)
        by_solver = min((us for us, solver in times if us and solver), default=None)
        without = [*without, n] if closed is None else []
        ahead = ahead and closed is not None and (by_solver is None or closed < by_solver)
        best = n if ahead else best
    return best, without


def _known(values: Mapping[int, float | None]) -> dict[int, float]:
    return {n: value for n, value in values.items() if value is not None}
