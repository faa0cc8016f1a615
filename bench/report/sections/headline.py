"""Report sections at its beginning: method to take, cost of exactness and limits, methods to compare."""

from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context

from alloc.formulations import EXACT_METHODS, Family
from bench.record import SERVED_WITHIN, Served
from bench.record.schema import machine_name
from bench.report.pictures import picture
from bench.report.verdict import (
    cut_log_notes,
    first_methods,
    fuse_notes,
    opening_loop,
    opening_sizes,
    rank_notes,
    rate_note,
    trust_note,
    usual_verdicts,
    way_in_notes,
    weak_notes,
    weak_words,
)
from bench.results.columns import Row
from bench.results.failures import failure_sentence
from bench.results.quantiles import Repeats, ratio_interval
from bench.results.ranking import (
    best_rows,
    has_wrong_answer,
    is_complete,
    is_exact,
    is_optimal,
    is_right,
    loss_text,
    objection,
    served_share,
    served_text,
    shortlist,
    uncounted_methods,
    unmeasured_plugins,
)
from bench.results.rows import Run, served_count
from bench.results.sizing import sized_methods
from bench.results.text import number_range, plain, plural, rarity, table, three


def opening(run: Run, drawn: frozenset[str]) -> str:
    """The verdicts at the usual control rate, the machine's noise, and the picture of both sides."""
    sentences = usual_verdicts(run)
    if not sentences:
        return ""
    name = machine_name(run.record.header.machine)
    cut = "".join(f" {sentence}" for sentence in cut_log_notes(run, plain))
    sentences += [*weak_notes(run), *rank_notes(run), *fuse_notes(run), *rate_note(run)]
    return "\n".join(
        [
            "\n".join(f"- {plain(sentence)}" for sentence in sentences) + "\n",
            f"How sure: {plain(name)} was {plain(trust_note(run))}"
            f" Another rate than {opening_loop(run).rate_hz:g} Hz: `thrustbench size DIR --rate HZ`.{cut}\n",
            picture("overview.svg", "what a call costs, and what is lost without limits", drawn),
        ]
    )


CLOSED_FORMS = {"pinv@native": "f = T* τ in generated C", "pinv": "f = T* τ in numpy"}
"""Closed forms beside the exact answer: generated C beside C, and what most people call from Python."""


def headline(run: Run, drawn: frozenset[str]) -> str:
    """The cost of exactness, the loss without limits and by a failure, and how far to trust them."""
    said = _cost(run), _loss(run), failure_sentence(run), _trust(run)
    sentences = [sentence for sentence in said if sentence]
    return " ".join(sentences) + "\n" if run.vehicles else ""


def exact_row(rows: list[Row]) -> Row | None:
    """Exact row for the headline, of rows sorted by time; None without any.

    C of ``nullspace``, else ``nullspace``, else the first: of several that are equally fast within
    noise, the fastest is the luckiest.
    """
    exact = [row for row in rows if is_exact(row) and not row.unlimited]
    usual = EXACT_METHODS[0]
    return min(exact, key=lambda row: (row.described.twin != usual, row.method != usual), default=None)


def fastest_solver(rows: list[Row], *, as_c: bool = False) -> Row | None:
    """First exact row that calls a QP solver (``as_c``: its generated C), of rows sorted by time."""
    called = (row for row in rows if row.described.solver and (row.family == Family.GENERATED) == as_c)
    return next((row for row in called if is_exact(row)), None)


def row_of_method(rows: list[Row], method: str) -> Row | None:
    """The first row of that method."""
    return next((row for row in rows if row.method == method), None)


def _main_rows(run: Run) -> list[list[Row]]:
    return [best_rows(run, *each) for each in run.main_sets]


Pairs = list[tuple[Repeats, Repeats]]
INTERVALS = "95 % intervals over the repeats of this run"


def _cost(run: Run) -> str:
    exact_us, own_clock, names, vehicles = [], [], [], set()
    over: dict[str, Pairs] = {method: [] for method in CLOSED_FORMS}
    over_solver: Pairs = []
    over_c: Pairs = []
    for rows in _main_rows(run):
        row, solver = exact_row(rows), fastest_solver(rows)
        time, solver_us = _us(row), _us(solver)
        if row is None or time is None:
            continue
        exact_us.append(time)
        names.append(row.label)
        vehicles.add(row.vehicle)
        for method, pairs in over.items():
            pairs += [(row.measured, other.measured) for other in [row_of_method(rows, method)] if other]
        over_c += [(c.measured, row.measured) for c in [fastest_solver(rows, as_c=True)] if c]
        if solver is not None and solver_us and solver is not row:
            over_solver.append((solver.measured, row.measured))
            own_clock += [100 * own / solver_us for own in _numbers(solver.solver_p50_us)]
    if not exact_us:
        return ""
    text = (
        "The exact constrained allocation (eq. 4-5) takes"
        f" {number_range(exact_us)} µs a call on {plural(len(vehicles), 'vehicle')}"
        f" ({_code(max(set(names), key=names.count))}, medians)"
    )
    comparisons = [_ratio_sentence(over[m], words) for m, words in CLOSED_FORMS.items() if over[m]]
    if comparisons:
        text += f". That is {'. It is '.join(comparisons)}. f = T* τ knows no limits"
    if over_solver:
        text += f". The fastest QP solver that is as exact {_factor_text(over_solver)}, called through Python"
    if own_clock:
        text += f" ({number_range(own_clock)} % of it by its own clock)"
    if over_c:
        text += f". A solver's own C that is as exact {_factor_text(over_c)}"
    found = [ends for pairs in (*over.values(), over_solver, over_c) if (ends := ratio_interval(pairs))]
    if not found:
        return f"{text}."
    is_confident = all(ends.is_confident for ends in found)
    return f"{text}. Ratios are {INTERVALS if is_confident else 'extremes of batches, for repeats are few'}."


def ratio_text(pairs: Pairs) -> str:
    """``1.2 to 1.4``, the ends of ``ratio_interval``; empty where 1 lies between them.

    Ends have two digits, the lower one rounded down and the upper one up.
    """
    ends = ratio_interval(pairs)
    if ends is None or ends.low <= 1.0 <= ends.high:
        return ""
    shown = [
        f"{Context(prec=2, rounding=way).create_decimal(f'{end:.9g}'):f}"
        for end, way in zip(ends[:2], (ROUND_FLOOR, ROUND_CEILING), strict=True)
    ]
    return " to ".join(dict.fromkeys(shown))


def _ratio_sentence(pairs: Pairs, other: str) -> str:
    ratio = ratio_text(pairs)
    return f"{ratio} times the time of {other}" if ratio else f"as fast as {other}, within noise"


def _factor_text(pairs: Pairs) -> str:
    ratio = ratio_text(pairs)
    return f"takes {ratio} times as long" if ratio else "is as fast, within noise"


def _loss(run: Run) -> str:
    served, lost, turned, asked, hopeless = [], [], [], 0, False
    counts: list[Served] = []
    for rows in _main_rows(run):
        pinv = row_of_method(rows, "pinv")
        if pinv is not None:
            served += [100 * share for share in _numbers(served_share(run, pinv.vehicle, pinv))]
            counts += [count for count in [served_count(run, pinv)] if count]
            lost += _numbers(pinv.lost_wrench_max)
            turned += _numbers(pinv.direction_error_max_deg)
            problem = run.problem_by_set.get((pinv.vehicle, pinv.demands))
            asked += pinv.n_demands
            hopeless = hopeless or bool(problem and problem.labels.get("infeasible"))
    parts = []
    if served:
        parts.append(
            f"Without limits, f = T* τ serves {number_range(served)} % of what a vehicle can do: that much is"
            " delivered within 1 %."
        )
    some = ", some of which no thrusts meet," if hopeless else ""
    where, beyond = f"On the {asked} demands asked{some}", ""
    worst = [loss for count in counts for loss in (count.sample, count.corners) if loss]
    logs = any(run.is_log(*each) for each in run.main_sets)  # a log's demands matter more than drawn ones
    if not logs and 0 < len(served) == len(counts) and all(count.sample for count in counts):
        lost = [loss.missed_max for loss in worst]
        turned = [loss.turned_max_deg for loss in worst if loss.turned_max_deg is not None]
        where = _drawn_demands_text(counts)
        beyond = (
            f"; each is exceeded by {rarity(min(count.n_demands for count in counts))} of all such demands"
        )
    if turned and max(lost, default=0.0) > SERVED_WITHIN:  # else every demand that was asked is served
        who = "it" if served else "f = T* τ"
        parts.append(
            f"{where} {who} misses up to {three(100 * max(lost))} % of the wrench and points up to"
            f" {three(max(turned))}° away. Thrusts are cut at the limits{beyond}."
        )
    return " ".join(parts)


def _drawn_demands_text(counts: Sequence[Served]) -> str:
    """Name of the demands whose worst loss a sentence gives."""
    n = max(count.n_demands for count in counts)
    corners = [count.corners for count in counts if count.corners]
    if not corners:
        return f"At the worst of {n:,} demands drawn evenly from that (its corners are too many)"
    which = "its corners" if len(corners) == len(counts) else "its corners, where these are few,"
    return f"At the worst of {which} and of {n:,} demands drawn evenly"


def _trust(run: Run) -> str:
    rows = [row for own in sized_methods(run) for row in own]
    failed = sum(row.failed is not None for row in rows)
    wrong = sum(row.failed is None and has_wrong_answer(row) for row in rows)
    # A solver that gives up, or stops early with the status for it, breaks no promise and still serves less
    # than it could.
    short = sum(is_right(row) and is_optimal(row) and not is_complete(row) for row in rows)
    text = f"Every timed answer was judged. Of {len(rows)} rows {len(rows) - failed - wrong} are right"
    if short:
        text += f" ({short} of them of optimising methods that stop short of some demand that can be met)"
    return f"{text}, {wrong} wrong, {failed} not measured.{_stop_note(run)}"


def _stop_note(run: Run) -> str:
    events = run.record.events
    stopped = events and events[-1].what != "finished"
    return (
        " **This run was stopped before its end**; `thrustbench run --resume` with the same options goes on."
        if stopped
        else ""
    )


def _code(name: str) -> str:
    return plain(name) if "`" in name else f"`{name}`"


def _us(row: Row | None) -> float | None:
    return None if row is None else row.call_p50_us


def _numbers(value: float | None) -> list[float]:
    return [] if value is None else [value]


HEADERS = ("method", "answers", "median [µs]", "p99.9 [µs]", "wrench lost, worst", "served", "memory [MB]")

MEDIANS = " A median is over batches of calls: on a log, whose calls differ, it is near their mean."


def candidates(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle and log: methods that no other beats in time and loss, and references."""
    parts = []
    first = first_methods(opening_sizes(run))
    for vehicle in run.vehicles:
        for demands in run.leading_sets(vehicle):
            measured = best_rows(run, vehicle, demands)
            rows = shortlist(measured, first.get(vehicle, ""))
            unmeasured = unmeasured_plugins(run, vehicle, demands)
            lines = [*(_candidate(run, row) for row in rows), *map(_unmeasured_line, unmeasured)]
            if lines:
                words = weak_words(run, vehicle)
                weak = [f"weak: {plain(words)}; labels and losses are of all that counts.\n"] if words else []
                parts += [f"### {plain(vehicle)}, {plain(demands)} demands\n", *weak, table(HEADERS, lines)]
                parts += omission_note(len(measured) - len(rows))
        if capability := run.capability(vehicle):
            parts += [f"{plain(line)}.\n" for line in uncounted_methods(capability)]
    if not parts:
        return ""
    parts += [f"{plain(line)}\n" for line in way_in_notes(run)]
    own = any(method.plugin for method in run.record.methods)
    logs = any(run.is_log(*each) for each in run.main_sets)
    which = (
        "Listed are the method to take first and the methods that no other beats in both time and loss. Then"
        " come the fastest exact method in plain Python and the fastest by a solver, for comparison the"
        " closed form and the rule of practice. *Served* is the share of what the vehicle can do that is"
        " delivered within 1 %. Memory is the process's peak."
        f"{' Your own methods are always listed.' if own else ''}"
        f"{MEDIANS if logs else ''}\n"
    )
    return "\n".join(["## Methods worth considering\n", which, *parts])


def answers(row: Row) -> str:
    """Words for a row's answers; ``near`` an optimum if only a solver's tolerance keeps it away."""
    title = row.title
    if not is_right(row):
        return f"wrong: {objection(row)}"
    if not is_optimal(row) or is_exact(row):
        return title
    return f"near {title}" if is_complete(row) else f"aims at {title}, misses some that can be met"


def omission_note(n: int) -> list[str]:
    """A line below a table of report.md that lacks ``n`` methods; none where it has all."""
    return [f"Not shown: {plural(n, 'method')}, in `details.md`.\n"] if n else []


def _unmeasured_line(row: Row) -> list[str]:
    also = f"; wrong: {row.wrong}" if row.wrong else ""  # on another set
    return [row.label, f"{row.status}: {row.reason}{also}", *[""] * (len(HEADERS) - 2)]


def _candidate(run: Run, row: Row) -> list[str]:
    times = [three(row.call_p50_us), three(run.tail_us(row, 0.999))]
    return [
        row.label,
        answers(row),
        *times,
        loss_text(row),
        served_text(run, row.vehicle, row),
        three(row.peak_rss_MB),
    ]
