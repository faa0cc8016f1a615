"""Report sections on how it was measured and judged: agreement, machine, memory, frames, method, limits."""

from collections import defaultdict
from operator import attrgetter
from statistics import median

from alloc.vehicle.frame import FRAMES, described
from bench.report.verdict import NOISY_SHARE, cut_log_notes
from bench.results.columns import Row
from bench.results.quantiles import group, largest
from bench.results.ranking import has_wrong_answer, objection
from bench.results.rows import Run, count_answers
from bench.results.text import percent, plain, table, three


def frames(run: Run, drawn: frozenset[str]) -> str:
    """One sentence for each frame: its vehicles and its axes."""
    whole: dict[str, list[str]] = {frame: [] for frame in FRAMES}
    for problem in run.record.problems:
        if not problem.study and problem.whole not in whole[problem.frame]:
            whole[problem.frame].append(problem.whole)
    sentences = [
        f"Demands of {plain(', '.join(sorted(vehicles)))} are in {described(frame)}."
        for frame, vehicles in whole.items()
        if vehicles
    ]
    return " ".join(sentences) + "\n" if sentences else ""


def logs(run: Run, drawn: frozenset[str]) -> str:
    """A line for each remark on how the logs were read; empty without logs."""
    lines = [f"- {plain(line)}\n" for line in run.record.notes]
    return "\n".join(["How the logs were understood:\n", "".join(lines)]) if lines else ""


def slowest(run: Run, drawn: frozenset[str]) -> str:
    """Table of the slowest call of each method on each demand set, with its demand."""
    lines = []
    for row in run.rows:
        known = [cell for cell in row.measured.cells if cell.worst and cell.singles]
        if known:
            slowest = max(known, key=lambda cell: cell.singles[-1][0])
            demand = ", ".join(three(value) for value in slowest.worst)
            lines.append([row.vehicle, row.demands, row.method, three(row.call_max_us), demand])
    if not lines:
        return ""
    headers = ("vehicle", "demands", "method", "slowest call [µs]", "its demand [N, N m]")
    return "\n".join(["## The slowest calls, and what was asked in them\n", table(headers, lines)])


def memory(run: Run, drawn: frozenset[str]) -> str:
    """Table of the peak memory of each method's process, also over an empty one's, and its import time."""
    by_method = group(run.rows, attrgetter("method"))
    peaks = {
        name: largest(row.peak_rss_MB for row in by_method[name])
        for name in sorted({row.method for row in run.measured})
    }
    empty = peaks.get("noop")
    lines = []
    for name, peak in sorted(peaks.items(), key=lambda item: item[1] or 0.0):
        over = None if peak is None or empty is None else peak - empty
        workers = [w for w in run.record.workers if w.method == name != "noop"]
        imports = [w.import_ns for w in workers if w.import_ns is not None]
        # Without anything to import, a first build may be quicker than later ones: that counts as zero.
        import_ms = max(median(imports), 0.0) / 1e6 if imports else None
        size = largest(row.allocator_bytes for row in by_method[name])
        lines.append([name, three(peak), three(over), three(size and size / 1000), three(import_ms)])
    headers = ("method", "peak [MB]", "over an empty worker [MB]", "allocator [kB]", "import [ms]")
    text = (
        "Peak resident memory of a process that runs this method and nothing else, numpy included, the"
        " largest over its starts and levels; an empty worker is `noop`'s. *Allocator* is the largest over"
        " vehicles, as Python sees it: what a solver holds outside Python is only in the peak. *Import* is"
        " what a process's first build takes longer than later ones.\n"
    )
    known = any(number for _, *numbers in lines for number in numbers)
    return f"## Memory\n\n{text}\n{table(headers, lines)}" if known else ""


def machine(run: Run, drawn: frozenset[str]) -> str:
    """The machine as it described itself, what disturbed it, and the versions of what ran."""
    header = run.record.header
    facts = [[key.replace("_", " "), str(value)] for key, value in header.machine.items() if value != ""]
    facts += [[f"the C's {key}", value] for key, value in run.form.items()]
    facts += [["started", header.started], ["commit", header.commit or "unknown"], ["seed", str(header.seed)]]
    versions = ", ".join(plain(f"{name} {version}") for name, version in sorted(header.versions.items()))
    return "\n".join(
        [
            "## The machine, and how quiet it was\n",
            table(("what", "value"), facts),
            *([] if run.by_driver else [_quiet(run)]),
            versions + ".\n",
        ]
    )


def _quiet(run: Run) -> str:
    cells = (cell for row in run.measured for cell in row.measured.cells)
    steal = sum((cell.quiet.steal_ticks or 0) for cell in cells if cell.quiet) / 100
    n = len(run.measured)
    text = f"Disturbed rows: {run.disturbed} of {n} ({percent(run.disturbed / n if n else 0.0)})"
    if run.disturbances:
        text += ", by " + ", ".join(f"{what} ({count})" for what, count in sorted(run.disturbances.items()))
    text += f". Time stolen by the hypervisor: {three(steal)} s."
    done = [event for event in run.record.events if event.timed_s]
    if done:
        wall, timed = sum(e.wall_s for e in done), sum(e.timed_s for e in done)
        text += f" The run took {three(wall)} s, {three(wall / timed)} times the calls it timed."
    return text + "\n"


METHOD_PYTHON = """\
- Each method, start and level ran in a process of its own, pinned to one core, with one BLAS thread and
  without garbage collection, {repeats}, in seeded random order.
- Medians come from batches of about 2 ms, tails from single calls. Setting up is not solving and is timed
  apart. Nothing is subtracted; what the timing loop itself takes is the row `noop`.
"""
METHOD_DRIVER = """\
- One program in C called one method after the other: each demand once with cold caches, then singly for
  the tail, and as often in passes for the median. Nothing is subtracted; the row `noop` is what timing takes.
"""
METHOD = """\
- Every answer that was timed was judged from the vehicle's equations. A row with a wrong answer is a failure,
  not a time, and is never called exact.
- A quantile is printed only where ten calls lie beyond it. Its 95 % interval is from order statistics, as
  if calls were independent (*Tails* says how far that goes).
- `inactive` demands lie where the pseudoinverse keeps within the limits; `active` ones are attainable but
  need the limits; `infeasible` ones are not attainable.
- Pictures and the lines *exact* show a method by its fastest start and level that is right everywhere, exact
  ones before others. All of them are in `results.csv`. So are vehicles after a failure, of which the report
  shows one line each (`-f2`: thruster 2, counted from 0, is off). A picture without room for all methods
  says so: it has yours, those that none beats in time and loss, then of each family in turns.
"""


def method(run: Run, drawn: frozenset[str]) -> str:
    """The rules of measuring, with this run's number of repeats."""
    repeats = max((len(row.measured.cells) for row in run.rows), default=1)
    ran = METHOD_PYTHON.format(repeats="once" if repeats == 1 else f"{repeats} times afresh")
    return "## How it was measured\n\n" + (METHOD_DRIVER if run.by_driver else ran) + METHOD


LIMITS_PYTHON = """\
- Times are of Python on this machine. Another processor moves them all, and not all alike: run it there, or
  transfer it with `thrustbench size --canary` and take the band seriously.
"""
LIMITS_DRIVER = """\
- Times are of C on this board, with this compiler, these flags, caches and wait states; another moves them.
"""
LIMITS = """\
- A slowest call is the slowest of those made, on a machine that does other things too; it is no bound.
- Demand sets are drawn, not flown. Give your own log as a demand set before you decide.
- Static allocation: no thruster dynamics, no power model. Slew rates and voltage act in `slew`, in `sag`
  and in logs that bring limits; other sets have fixed limits.
"""
VIRTUAL = """- This was a virtual machine: p99.9 and slowest calls include what its host did.
"""
NOISY = """- More than one row in ten was measured while the machine was disturbed: look at column `quiet`.
"""


def limits(run: Run, drawn: frozenset[str]) -> str:
    """Limits of validity, of every run and of this one."""
    noisy = run.disturbed > NOISY_SHARE * len(run.measured)
    virtual = run.record.header.machine.get("virtual")
    cut = "".join(f"- {sentence}\n" for sentence in cut_log_notes(run, plain))
    times = LIMITS_DRIVER if run.by_driver else LIMITS_PYTHON
    return "## Limits\n\n" + times + LIMITS + cut + (VIRTUAL if virtual else "") + (NOISY if noisy else "")


def agreement(run: Run, drawn: frozenset[str]) -> str:
    """Distance of each method from the optimum, wrong answers by name, and what was not measured."""
    parts = [
        "## Agreement and failures\n",
        "Every timed answer is judged from T, H, limits and demand alone; a solver's status is not believed."
        " Distances are to the optimum of the same formulation, over the largest thrust limit"
        f"{'; where they matter, less what rounding of a demand explains' if run.by_driver else ''}.\n",
        _agreement([row for row in run.rows if not row.failed]),
        _wrong_rows([row for row in run.rows if has_wrong_answer(row)]),
        _unmeasured_rows([row for row in run.rows if row.failed]),
    ]
    return "\n".join(part for part in parts if part)


def _agreement(rows: list[Row]) -> str:
    asked = group(rows, attrgetter("label"))
    by_label = group((row for row in rows if row.agreed is not None), attrgetter("label"))
    lines = []
    for label, own in sorted(by_label.items()):
        agreeing = f"{sum(row.agreed is True for row in own)} of {len(own)}"
        columns = ("distance_relative", "tolerance", "gap_relative")
        worst = [three(largest(map(attrgetter(name), own))) for name in columns]
        lines.append([label, own[0].formulation, agreeing, count_answers(asked[label]), *worst])
    headers = (
        "method",
        "answers",
        "rows that agree",
        "demands answered",
        "largest distance",
        "promised",
        "largest duality gap",
    )
    return table(headers, lines) if lines else ""


def _wrong_rows(rows: list[Row]) -> str:
    if not rows:
        return "No row disagrees, and no answer is wrong.\n"
    where: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for row in rows:
        where[row.label, row.demands, objection(row)].append(f"{row.vehicle} ({_distance(row)})")
    lines = [[*key[:2], ", ".join(sorted(places)), key[2]] for key, places in sorted(where.items())]
    headers = ("method", "demands", "vehicle (distance found, promised)", "what is wrong")
    return "### Wrong\n\n" + table(headers, lines)


def _distance(row: Row) -> str:
    return f"{three(row.distance_relative) or '-'}, {three(row.tolerance) or '-'}"


def _unmeasured_rows(rows: list[Row]) -> str:
    if not rows:
        return "No row is without a measurement.\n"
    where: dict[tuple[str, str, str], dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    absent, reasons = [row for row in rows if row.status == "missing"], dict[tuple[str, str, str], str]()
    for row in rows:
        if row.status != "missing":
            reason = row.reason.removeprefix(f"{row.method}: ")
            where[row.label, row.status, reason][row.vehicle].append(row.demands)
            reasons[row.label, row.status, reason] = row.reason
    alike: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for (label, status, reason), places in where.items():
        place = "; ".join(f"{vehicle}: {', '.join(sets)}" for vehicle, sets in places.items())
        alike[place, status, reason].append(label)
    lines = [
        [", ".join(labels), place, status, reason if labels[1:] else reasons[labels[0], status, reason]]
        for (place, status, reason), labels in alike.items()
    ]
    if absent:  # one line says how to get all of them
        methods = ", ".join(dict.fromkeys(row.method for row in absent))
        lines.append(
            [methods, "everywhere", "missing", "; ".join(dict.fromkeys(row.reason for row in absent))]
        )
    return "### Not measured\n\n" + table(("method", "where", "status", "reason"), lines)
