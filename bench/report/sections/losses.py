"""Report sections on wrenches lost: by rules and closed forms, within moving limits, after a failure."""

from collections.abc import Sequence

from alloc.allocation import WRENCH_TOLERANCE
from bench.record import Problem, Served
from bench.results.columns import Row
from bench.results.quantiles import largest
from bench.results.ranking import best_rows, largest_loss
from bench.results.rows import Run, count_answers, served_count
from bench.results.text import drop_rounding, percent, plain, rarity, table, three

LOSSES = """## What you lose

*Answered* is how many of all demands asked here got thrusts. *Delivered* is the wrench that the thrusters
push once each is clipped to its limits, whatever they were told. *Lost* is the share of the demanded wrench
that is not delivered, each axis over the length of its row of T times the largest limit. It is median and
worst over each set's demands, and worst over those *drawn* evenly from what the vehicle can do. *Turn* is the
largest angle between the two, *beyond limits* the share of answers that ask for more than a thruster has.
*Effort* is the largest f'Hf above the optimum's where the wrench is met.
"""


MOST = 6
"""Most names in a table's cell; more stand below the table."""


def losses(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle, a line for every method; below it those that lose nothing, and of what."""
    parts = [part for vehicle in run.vehicles for part in _vehicle(run, vehicle)]
    return "\n".join([LOSSES, *parts]) if parts else ""


def _vehicle(run: Run, vehicle: str) -> list[str]:
    asked = run.sets(vehicle)
    by_set = {name: {row.label: row for row in run.select(vehicle, name) if not row.failed} for name in asked}
    # On inactive demands the closed forms are the optimum, so no method loses anything there.
    hard = [name for name in asked if name != "inactive"] or asked
    leading = [name for name in run.leading_sets(vehicle) if name in hard] or hard[:1]
    shown: dict[str, Row] = {}
    for name in leading:
        shown.update({row.label: row for row in best_rows(run, vehicle, name) if row.label not in shown})
    for name in asked:  # a method may have no time on the first
        known = {row.method for row in shown.values()}
        shown.update({row.label: row for row in best_rows(run, vehicle, name) if row.method not in known})

    def is_lossless(label: str, sets: list[str]) -> bool:
        return all(_is_lossless(by_set[name].get(label)) for name in sets if name != "infeasible")

    lossless = [row for row in shown.values() if is_lossless(row.label, asked)]
    # Else a method that gives up on easy demands alone has a line in which it loses nothing.
    sets = (
        asked if any(is_lossless(row.label, hard) and row not in lossless for row in shown.values()) else hard
    )
    counted = {row.label: served_count(run, row) for row in shown.values()}
    n_drawn = max(
        (served.sample.n_demands for served in counted.values() if served and served.sample), default=0
    )
    lines: dict[tuple[str, ...], list[Row]] = {}  # methods that lose the same share a line
    for row in shown.values():
        alike = [other for name in leading if (other := by_set[name].get(row.label))]
        cells = (
            count_answers(own for name in asked if (own := by_set[name].get(row.label))),
            *(_loss_text(by_set[name].get(row.label)) for name in sets),
            *([_drawn_loss_text(counted[row.label])] if n_drawn else []),
            three(drop_rounding(largest(other.direction_error_max_deg for other in alike))),
            percent(drop_rounding(largest(other.limits_violated_share for other in alike))),
            percent(drop_rounding(largest(other.effort_over_optimum_max for other in alike))),
        )
        if any(cells):
            lines.setdefault(cells, []).append(row)
    if not lines:
        return []
    first = " and ".join(leading)
    headers = (
        "method",
        "answered",
        *(f"{name}: lost, worst" for name in sets),
        *([f"{n_drawn:,} drawn: lost, worst"] if n_drawn else []),
        *(f"{first}: {what}" for what in ("turn [°]", "beyond limits", "effort")),
    )
    body: list[list[str]] = []
    notes: list[str] = []
    for cells, rows in lines.items():
        names = _names_text(rows)
        if len(rows) > MOST:  # a cell that long makes a table nobody can read
            notes.append(f"({len(notes) + 1}) {plain(names)}.\n")
            names = f"{len(rows)} methods ({len(notes)})"
        body.append([names, *cells])
    return [f"### {plain(vehicle)}\n", table(headers, body), *notes, *lossless_notes(run, vehicle, lossless)]


def lossless_notes(run: Run, vehicle: str, lossless: Sequence[Row]) -> list[str]:
    """Sentences that name the methods without a loss on attainable demands, by the demands asked.

    A method that lost part of a demand drawn evenly is left out.
    """
    counted = {row.label: served_count(run, row) for row in lossless}
    problems = [p for p in run.record.problems if p.vehicle == vehicle]
    n = sum(p.labels.get("inactive", 0) + p.labels.get("active", 0) for p in problems)
    here = f"the {n:,} attainable demands above" if n else "all attainable demands above"
    texts: dict[str, list[str]] = {}
    for label, served in counted.items():
        if served is None:
            text = f"Of {here}, the only ones asked, nothing is lost by {{}}."
        elif served.sample is None:  # of an older record
            drawn = f"of {served.n_demands:,} drawn evenly from what {vehicle} can do at most 1 %"
            text = f"Of {here} nothing is lost, and {drawn}, by {{}}."
        else:
            drawn = f"of {served.sample.n_demands:,} drawn evenly from what {vehicle} can do"
            text = (
                f"Of {here} and {drawn}, nothing is lost by {{}}."
                f" They lose part of {rarity(served.sample.n_demands)} of all such demands."
            )
        if served is None or not has_loss(served):
            texts.setdefault(text, []).append(label)
    return [f"{plain(text.format(', '.join(labels)))}\n" for text, labels in texts.items()]


def has_loss(served: Served) -> bool:
    """True if part of a drawn demand was not delivered; in an older record, more than 1 % of one."""
    if served.sample is None:
        return served.within_1pct < served.n_demands
    return served.sample.missed_max > WRENCH_TOLERANCE


def _drawn_loss_text(served: Served | None) -> str:
    if served is None or served.sample is None:
        return "not asked"
    return percent(drop_rounding(served.sample.missed_max))


def _names_text(rows: list[Row]) -> str:
    """Names of several rows: ``clip, pinv``, or for solvers of one family ``soft QP by daqp, osqp``."""
    solvers, families = [row.described.solver for row in rows], {row.family for row in rows}
    if len(rows) == 1 or len(families) > 1 or not all(solvers):
        return ", ".join(row.label for row in rows)
    return f"{families.pop()} by {', '.join(solvers)}"


def _is_lossless(row: Row | None) -> bool:
    """True if every attainable demand of the row was answered and met inside the limits."""
    if row is None or row.limits_violated_share:
        return False
    missed = [judged.missed_max for judged in row.measured.judged if judged.missed_max is not None]
    if missed:
        return max(missed) <= WRENCH_TOLERANCE
    lost = row.lost_wrench_max  # older records and sets without attainable demands
    return lost is not None and lost <= WRENCH_TOLERANCE and row.answered_share == 1.0


def _loss_text(row: Row | None) -> str:
    if row is None or row.answered_share is None:
        return ""
    if not row.answered_share:
        return "none answered"
    answered = row.answered_share
    values = [row.lost_wrench_p50, row.lost_wrench_max]
    text = ", ".join(percent(drop_rounding(value)) for value in values)
    return text if answered == 1.0 else f"{text} ({percent(answered)} answered)"


MOVING = """## Demands in a row, and limits that move

Each demand follows the one before it in time. Where limits move each has limits of its own: what slew rates
leave around the last thrusts, or what a battery's voltage gives. *Cold* and *warm* are median calls over that
of the same object without a guess. Cold has a new solver object each time, warm the last answer as first
guess. *Lost* is the largest share of a demanded wrench that is not delivered by thrusts cut at
their limits, over all demands: also of those that no thrusts meet.
"""

MOVING_HEADERS = (
    "method",
    "p50 [µs]",
    "cold",
    "warm",
    "p99 [µs]",
    "within 1 %",
    "lost, worst",
    "solved",
    "beyond limits",
)


def moving(run: Run, drawn: frozenset[str]) -> str:
    """A table for each set of a vehicle whose demands are a sequence or have limits of their own."""
    asked = sequences(run)
    parts = [part for one in asked for part in (f"### {plain(title(one))}\n", sequence_table(run, one))]
    return "\n".join([MOVING, *parts]) if parts else ""


def sequences(run: Run) -> list[Problem]:
    """Problems whose demands are a sequence or have limits of their own, by vehicle and set."""
    wanted = [p for p in run.record.problems if p.moving or p.rate_hz is not None]
    return [p for p in wanted if p.vehicle in run.by_vehicle and run.select(p.vehicle, p.demands)]


def title(problem: Problem) -> str:
    """Title with vehicle, set, number of demands of each kind, and limits that move."""
    kinds = ", ".join(f"{count} {name}" for name, count in problem.labels.items())
    limits = "limits of each" if problem.moving else "fixed limits"
    if problem.cap_A is not None:
        limits += f", at most {three(problem.cap_A)} A together"
    whole = f" of {problem.n_demands + problem.left_out}" if problem.left_out else ""
    return f"{problem.vehicle}, {problem.demands}: {problem.n_demands}{whole} demands ({kinds}), {limits}"


def sequence_table(run: Run, problem: Problem) -> str:
    """The table of one problem: a line for each method and level, fastest first."""
    starts: dict[tuple[str, str], dict[str, Row]] = {}
    for row in run.select(problem.vehicle, problem.demands):
        if not row.failed and row.measured.cells[0].formulation and row.call_p50_us is not None:
            starts.setdefault((row.method, row.measured.key.level), {})[row.start] = row
    lines = [(by.get("reused") or next(iter(by.values())), by) for by in starts.values()]
    lines.sort(key=lambda line: line[0].call_p50_us or 0.0)
    return table(MOVING_HEADERS, [_line(row, by_start) for row, by_start in lines])


def _line(row: Row, by_start: dict[str, Row]) -> list[str]:
    level = f" ({row.measured.key.level})" if row.measured.key.level not in ("-", "tight") else ""
    return [
        row.method + level,
        three(row.call_p50_us),
        *(_ratio(by_start.get(start), row) for start in ("cold", "warm")),
        three(row.call_p99_us),
        percent(row.within_1pct_share),
        percent(largest_loss(row)),
        percent(row.solved_fraction),
        percent(row.limits_violated_share),
    ]


def _ratio(other: Row | None, row: Row) -> str:
    if other is None or other is row or other.call_p50_us is None or row.call_p50_us is None:
        return ""
    return three(other.call_p50_us / row.call_p50_us)


BEFORE, AFTER = "mission", "mission-fault"

ROUNDING_DEG = 1e-4
"""Largest turn [deg] of a wrench that is met within WRENCH_TOLERANCE: 1e-6 rad."""

MISSION_HEADERS = (
    "method",
    "within 1 %, before",
    "after",
    "wrench lost, worst, before",
    "after",
    "worst turn [°], before",
    "after",
)


def mission(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle whose flight was measured before and after a failure."""
    parts = []
    for vehicle in run.vehicles:
        before = {row.method: row for row in best_rows(run, vehicle, BEFORE)}
        for degraded in _degraded_vehicles(run, vehicle):
            after = {row.method: row for row in best_rows(run, degraded, AFTER)}
            lines = [[name, *_changes(row, after[name])] for name, row in before.items() if name in after]
            if lines:
                parts += [f"### {plain(vehicle)}, then {plain(degraded)}\n", table(MISSION_HEADERS, lines)]
    if not parts:
        return ""
    title = (
        "## Through a failure\n\n"
        f"{_flight_length(run)} of waypoints in a current, then as many after a failure. The thruster that"
        " fails is the one whose loss costs most (and no rank, where that can be had). Each method answers"
        " the same demands; one without an answer is lost whole.\n"
    )
    return "\n".join([title, *parts])


def _flight_length(run: Run) -> str:
    """Number of the flight's demands that were asked, out of how many, and their duration."""
    halves = [p for p in run.record.problems if p.demands in (BEFORE, AFTER)]
    if not halves:
        return "0 demands"
    most = max(halves, key=lambda p: p.n_demands)
    n, total = most.n_demands, most.n_demands + most.left_out
    demands = f"{n:,} of {total:,}" if total > n else f"{n:,}"
    if not most.rate_hz:
        return f"{demands} demands"
    seconds = [three(count / most.rate_hz) for count in ((n, total) if total > n else (n,))]
    return f"{demands} demands ({' of '.join(seconds)} s)"


def _degraded_vehicles(run: Run, vehicle: str) -> list[str]:
    """Names of this vehicle's versions with a single fault that have a mission."""
    flown = {row.vehicle for row in run.rows if row.demands == AFTER}
    return sorted(
        name for name in flown if run.whole(name) == vehicle and len(run.problems[name].faults) == 1
    )


def _changes(before: Row, after: Row) -> list[str]:
    within = [percent(row.within_1pct_share) for row in (before, after)]
    lost = [percent(_mission_loss(row)) for row in (before, after)]
    turned = [three(drop_rounding(row.direction_error_max_deg, ROUNDING_DEG)) for row in (before, after)]
    return [*within, *lost, *turned]


def _mission_loss(row: Row) -> float | None:
    # A demand without an answer counts as lost whole.
    if (row.answered_share or 0.0) < 1.0:
        return 1.0
    return drop_rounding(row.lost_wrench_max)
