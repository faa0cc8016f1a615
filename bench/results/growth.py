"""What the growth study found: times and bytes over the number of thrusters, and their exponents."""

from collections.abc import Mapping
from dataclasses import dataclass

from bench.results.columns import Row
from bench.results.ranking import exact
from bench.results.rows import Run

STUDY = "growth"
"""As a problem of the study names it."""
FITTED_FROM = 12
"""Exponents are fitted from so many thrusters on: below, what a call costs anyway hides the growth."""


@dataclass(frozen=True)
class Series:
    """One method on the generated vehicles with k degrees of freedom.

    rows: by number of thrusters, those that failed included. d: n - rank T of each.
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
    found: dict[tuple[int, str], dict[int, Row]] = {}
    for row in run.rows:
        if row.vehicle in shapes and not row.described.yardstick:
            k, n = shapes[row.vehicle]
            found.setdefault((k, row.label), {})[n] = row
    return [Series(k, label, dict(sorted(rows.items()))) for (k, label), rows in sorted(found.items())]


def exponent(values: dict[int, float]) -> tuple[float, float] | None:
    """p of value ~ n^p with its standard error, by least squares of logarithms; None below three points."""
    from math import log

    from scipy.stats import linregress

    points = [(log(n), log(value)) for n, value in values.items() if n >= FITTED_FROM and value > 0]
    if len(points) < 3:
        return None
    if len({y for _, y in points}) == 1:  # linregress has no error for what does not change
        return 0.0, 0.0
    fit = linregress([x for x, _ in points], [y for _, y in points])
    return float(fit.slope), float(fit.stderr)


def pays_up_to(found: list[Series]) -> tuple[int | None, list[int]]:
    """Of the series of one k: the largest n up to which an exact closed form beats every exact solver.

    Also the sizes from which on no exact closed form was measured any more.
    """
    sizes = sorted({n for one in found for n in one.rows})
    best: int | None = None
    without: list[int] = []
    ahead = True
    for n in sizes:
        here = [(one.times_us().get(n), one) for one in found if n in one.rows and exact(one.rows[n])]
        closed = min((t for t, one in here if t and not one.solver), default=None)
        solver = min((t for t, one in here if t and one.solver), default=None)
        without = [*without, n] if closed is None else []
        ahead = ahead and closed is not None and (solver is None or closed < solver)
        best = n if ahead else best
    return best, without


def _known(values: Mapping[int, float | None]) -> dict[int, float]:
    return {n: value for n, value in values.items() if value is not None}
