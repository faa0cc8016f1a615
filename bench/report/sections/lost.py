"""Report section: what methods lose that ignore the limits or keep them by a rule of thumb."""

from collections.abc import Callable

from alloc.allocation import WRENCH_TOLERANCE
from alloc.formulations.scaled import FORMULATION as SCALED
from bench.results.columns import Row
from bench.results.quantiles import largest
from bench.results.ranking import best_rows
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three

INTRODUCTION = """## What you lose

*Delivered* is the wrench that the thrusters push once each is clipped to its limits, whatever they were
told. *Lost* is the share of the demanded wrench that is not delivered, each axis over the length of its row
of T times the largest limit: median and worst over each set's demands. *Turn* is the largest angle between
the two, *beyond limits* the share of answers that ask for more than a thruster has, *effort* the largest f'Hf
above the optimum's where the wrench is met.
"""


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle; methods that lose nothing on any set are named in a sentence below it."""
    parts = [part for vehicle in run.vehicles for part in _vehicle(run, vehicle)]
    return "\n".join([INTRODUCTION, *parts]) if parts else ""


def _vehicle(run: Run, vehicle: str) -> list[str]:
    asked = run.sets(vehicle)
    by_set = {name: {row.label: row for row in run.of(vehicle, name) if not row.failed} for name in asked}
    # On inactive demands the closed forms are the optimum, so no method loses anything by design.
    hard = [name for name in asked if name != "inactive"] or asked
    leading = [name for name in run.leading(vehicle) if name in hard] or hard[:1]
    rows = [
        row for name in leading for row in best_rows(run, vehicle, name) if row.lost_wrench_max is not None
    ]
    shown = list({row.label: row for row in reversed(rows)}.values())[::-1]

    def kept(label: str, sets: list[str]) -> bool:
        return all(_keeps(by_set[name].get(label)) for name in sets if name != "infeasible")

    keeping = [row.label for row in shown if kept(row.label, asked)]
    # One that gives up on easy demands alone would have a row without a loss.
    sets = asked if any(kept(row.label, hard) and row.label not in keeping for row in shown) else hard
    losing = [row for row in shown if row.label not in keeping or row.formulation == SCALED.name]
    lines: dict[tuple[str, ...], list[Row]] = {}  # methods that lose the same share a line
    for row in losing:
        alike = [other for name in leading if (other := by_set[name].get(row.label))]
        cells = (
            *(_lost(by_set[name].get(row.label)) for name in sets),
            _met(largest(other.direction_error_max_deg for other in alike), three),
            _met(largest(other.limits_violated_share for other in alike), percent),
            _met(largest(other.effort_over_optimum_max for other in alike), percent),
        )
        lines.setdefault(cells, []).append(row)
    if not lines:
        return []
    first = " and ".join(leading)
    headers = (
        "method",
        *(f"{name}: lost, worst" for name in sets),
        *(f"{first}: {what}" for what in ("turn [°]", "beyond limits", "effort")),
    )
    nothing = f"Nothing that is attainable is lost by {plain(', '.join(keeping))}.\n"
    body = [[_together(rows), *cells] for cells, rows in lines.items()]
    return [f"### {plain(vehicle)}\n", table(headers, body), *([nothing] if keeping else [])]


def _together(rows: list[Row]) -> str:
    """Names of several rows: ``clip, pinv``, or for solvers of one family ``soft QP by daqp, osqp``."""
    solvers, families = [row.described.solver for row in rows], {row.family for row in rows}
    if len(rows) == 1 or len(families) > 1 or not all(solvers):
        return ", ".join(row.label for row in rows)
    return f"{families.pop()} by {', '.join(solvers)}"


def _keeps(row: Row | None) -> bool:
    """True if every demand of the row was answered and met inside the limits."""
    if row is None:
        return False
    lost, beyond = row.lost_wrench_max, row.limits_violated_share
    return lost is not None and lost <= WRENCH_TOLERANCE and not beyond and row.answered_share == 1.0


def _lost(row: Row | None) -> str:
    if row is None or row.lost_wrench_max is None:
        return ""
    answered = row.answered_share
    values = [row.lost_wrench_p50, row.lost_wrench_max]
    text = ", ".join(_met(value, percent) for value in values)
    return text if answered == 1.0 else f"{text} ({percent(answered)} answered)"


def _met(value: float | None, show: Callable[[float | None], str]) -> str:
    # A wrench missed by no more than SOLVED allows counts as met; an equally small angle [°] or effort is
    # rounding.
    return show(0.0 if value is not None and abs(value) < WRENCH_TOLERANCE else value)
