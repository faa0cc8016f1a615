"""The end of a run on the terminal: what to take, a line for each method, and which answers are wrong."""

from collections import Counter
from collections.abc import Iterable
from functools import partial
from itertools import groupby
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from alloc.allocation import WRENCH_TOLERANCE
from alloc.files.visible import visible
from alloc.formulations import Family
from bench.record import FARTHER
from bench.record.schema import machine_name
from bench.report.sections.losses import sequence_table, sequences, title
from bench.report.verdict import (
    cut_log_notes,
    fuse_notes,
    opening_loop,
    rank_notes,
    rate_note,
    trust_note,
    verdicts,
    way_in_notes,
    weak_notes,
)
from bench.results.columns import Row
from bench.results.quantiles import largest
from bench.results.ranking import ROUNDING, largest_miss, served_share, uncounted_methods
from bench.results.rows import Run, count_answers, read_run, sort_sets
from bench.results.size import best_of_each, rank_labels
from bench.results.sizing import sizes
from bench.results.text import number_range, three

CAPTION = """p50, p99: a call \\[us]; p99 of all sets, where there are calls enough.
serves: share of what a vehicle can do, within 1 %.
misses: largest share of an attainable wrench not delivered, of the demands of these sets.
Over vehicles and demand sets: p50 least … largest, the others the worst."""


KEPT = "{folder}: the earlier run's record is kept beside the new one"
WIDE = 1000
"""Width for tables that go to a file or a pipe."""


def objections(rows: Iterable[Row]) -> list[str]:
    """One line for each row whose answers are wrong or disagree with the reference, with the row's name."""
    lines = []
    for row in rows:
        judged = next((j for j in row.measured.judged if j.objection), None)
        if judged is None:
            if elsewhere := row.measured.wrong_elsewhere:
                lines.append(f"{row.label} on {row.vehicle}, {elsewhere}")
            continue
        what = judged.wrong or (
            f"{_two_digits(judged.distance_rel_max)} of the largest limit away from the reference, "
            f"where {_two_digits(judged.tolerance)} is promised"
        )
        lines.append(f"{row.label} on {row.vehicle}, {row.demands} demands: {what}")
    return list(dict.fromkeys(lines))  # a method's rows repeat what is wrong with it


def _two_digits(value: float | None) -> str:
    return "-" if value is None else f"{value:.2g}"


def tell(console: Console, line: str, style: str | None = None) -> None:
    """Print a line as it is, but for what would move the cursor: names and reasons are other people's."""
    console.print(visible(line), style=style, highlight=False, markup=False, soft_wrap=True)


def show(directory: Path, console: Console) -> bool:
    """Print the summary of the run in ``directory``; True where every answer is good.

    That a rival is farther off than it promises is said, and makes no run a bad one.
    """
    say = partial(tell, console)
    run = read_run(directory)
    loop = opening_loop(run)
    sized = sizes(run, loop)
    first = [size for size in best_of_each(sized) if size.vehicle in run.vehicles]
    notes = [*weak_notes(run), *rank_notes(run), *fuse_notes(run), *rate_note(run)]
    for line in [*verdicts(first, loop), *notes, ""]:
        say(line)
    usefulness = {label: i for i, label in enumerate(rank_labels(sized, loop.period_us))}
    absent = {row.method: row.reason for row in run.rows if row.status == "missing"}
    rows = sorted(
        (row for row in run.rows if row.method not in absent),
        key=lambda row: (usefulness.get(row.label, len(usefulness)), row.label),
    )
    table = Table(box=None, pad_edge=False, caption=CAPTION)
    for heading in ("method", "p50", "p99", "serves", "misses", "agrees"):
        table.add_column(heading, no_wrap=True, min_width=len(heading))
    for label, same in groupby(rows, key=lambda row: row.label):
        table.add_row(escape(visible(label)), *_method(run, list(same)))
    # A file or a pipe has no edge that lines must fit into, so nothing is cut there.
    width = console.width
    console.width = width if console.is_terminal else max(width, WIDE)
    console.print(table)
    console.width = width
    for line in way_in_notes(run):
        say(line)
    if run.vehicles:
        say(f"{machine_name(run.record.header.machine)} was {trust_note(run)}")
    for problem in sequences(run):
        if problem.moving:
            say(f"{title(problem)}\n")
            say(sequence_table(run, problem))
    for line in cut_log_notes(run):
        say(line)
    if absent:
        say(f"not installed: {', '.join(absent)}; `thrustbench list` says how to get them")
    for line in (said for capability in run.record.capabilities for said in uncounted_methods(capability)):
        say(line)
    plugins = {method.name for method in run.record.methods if method.plugin}
    for row in rows:
        if row.method in plugins and row.status == "refused":
            say(f"{row.label} on {row.vehicle}, {row.demands} demands: refused: {row.reason}")
    for line in objections(rows):
        say(f"{line}.", style="red")
    return not objections(row for row in rows if not _is_rival(row))


def _is_rival(row: Row) -> bool:
    """True if a row is a solver's C without a wrong answer: its distance from the optimum is its own affair.

    Its answers are checked before they are given, so a wrong one is this project's.
    """
    return row.family == Family.GENERATED and not row.wrong


def _method(run: Run, rows: list[Row]) -> tuple[str, ...]:
    return (
        number_range((row.call_p50_us for row in rows), "…"),
        three(_worst_p99(run, rows)),
        _least([100 * share for share in served_shares(run, rows)]),
        miss_text(rows),
        _verdict(rows),
    )


def _worst_p99(run: Run, rows: list[Row]) -> float | None:
    """The largest p99 of all vehicles [us]; None where one has too few calls, or none that the median has."""
    timed = {row.vehicle: row for row in rows if not row.failed}
    tails = [run.tail_us(row, 0.99) for row in timed.values()]
    return None if None in tails else largest(tails)


def _verdict(rows: list[Row]) -> str:
    """Agreement of the answers with the reference: which are wrong, and which could not be measured."""
    verdicts = [judged.agrees for row in rows for judged in row.measured.judged if judged.agrees is not None]
    agreement = "-" if not verdicts else "yes" if all(verdicts) else f"no, {verdicts.count(False)}x"
    known = [row for row in rows if not row.failed and row.answered_share is not None]
    if verdicts and any((row.answered_share or 0.0) < row.measured.attainable - ROUNDING for row in known):
        agreement += f" of {count_answers(known)} answered"
    failures = Counter(row.failed.status for row in rows if row.failed)
    # What is wrong on another set is counted there, and what is too far off is no agreement.
    counted = (row for row in rows if row.wrong not in ("", FARTHER, row.measured.wrong_on_others))
    failures.update("wrong" for row in counted if not row.failed)
    return ", ".join([agreement, *(f"{count} {status}" for status, count in failures.items())])


def served_shares(run: Run, rows: list[Row]) -> list[float]:
    """``served_share`` of a method on each vehicle where it is known, by its first set of tables."""
    shares: dict[str, float] = {}
    for demands in sort_sets({row.demands for row in rows}):
        for row in rows:
            known = row.demands == demands and not row.failed
            if known and (share := served_share(run, row.vehicle, row)) is not None:
                shares.setdefault(row.vehicle, share)
    return list(shares.values())


def miss_text(rows: list[Row]) -> str:
    """The largest share of an attainable wrench that is not delivered, in per cent; empty where not known.

    That is also where a method failed on some of a vehicle's demands and was measured on others.
    """
    worst = largest_miss(rows)
    failed = {row.vehicle for row in rows if row.failed}
    if worst is None or any(row.vehicle in failed for row in rows if not row.failed):
        return ""
    # Two digits; .2g alone would write 100 with an exponent.
    return f"{float(f'{100 * worst:.2g}'):g}%" if worst > WRENCH_TOLERANCE else "0%"


def _least(shares: list[float]) -> str:
    return f"{three(min(shares))}%" if shares else ""
