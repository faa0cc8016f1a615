"""Report sections on time: a call of each method, as C and from Python, how late it can be, and growth."""

from collections import defaultdict
from collections.abc import Callable, Iterable
from typing import NamedTuple

from alloc.allocation import WRENCH_TOLERANCE
from alloc.formulations import list_formulations
from bench.record import NO_VEHICLE
from bench.record.measured import BIN
from bench.report.pictures import picture
from bench.results.columns import Row
from bench.results.growth import FITTED_FROM, Series, exponent, pays_up_to, series
from bench.results.quantiles import group, interval, largest
from bench.results.ranking import best_rows, is_right, largest_loss
from bench.results.rows import Run
from bench.results.text import drop_rounding, number_range, percent, plain, plural, table, three


def cost(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle: set-up, median on each demand set, tail, and the solver's part of it."""
    answered = {row.formulation for row in run.rows}
    meanings = [f"*{f.name}* {f.meaning}" for f in list_formulations() if f.name in answered]
    caller = "the board's driver" if run.by_driver else "Python"
    parts = [
        "## What a call costs\n",
        f"Medians of one call from {caller} on each demand set; p99.9 of single calls on all sets together."
        " *Binding* is the solver's own Python call inside it, *own clock* what the solver reports of itself;"
        " the rest is posing the problem and checking the answer. A start is *cold* (new solver object each"
        " call), *reused* (same object) or *warm* (last answer as first guess). *Answers* names the question."
        f" {'. '.join([*meanings, 'Other names are rules of practice'])}.\n",
    ]
    for vehicle in run.vehicles:
        parts.append(f"### {plain(vehicle)}\n")
        for kind, alt in (
            ("cost", "median, p99.9 and slowest call by method"),
            ("pareto", "wrench lost over time by method"),
            ("period", "share of the control period at 50, 100 and 400 Hz"),
        ):
            parts.append(picture(f"{kind}-{vehicle}.svg", f"{vehicle}: {alt}", drawn))
        parts.append(_costs(run, vehicle))
    return "\n".join(part for part in parts if part) if run.vehicles else ""


def _costs(run: Run, vehicle: str) -> str:
    sets = run.sets(vehicle)
    timed = [row for row in run.select(vehicle) if not row.failed and row.call_p50_us is not None]
    variants = {
        label: {row.demands: row for row in rows}
        for label, rows in group(timed, lambda row: row.label).items()
    }
    pinv = variants.get("pinv", {}).get(sets[0])
    base = pinv.call_p50_us if pinv else None
    lines = []
    for label, by_set in variants.items():
        first = by_set.get(sets[0]) or next(iter(by_set.values()))
        time = first.call_p50_us
        ratio = time / base if time is not None and base and first.demands == sets[0] else None
        medians = [three(_median(by_set.get(name))) for name in sets]
        inside = [three(first.binding_p50_us), three(first.solver_p50_us)]
        tail = three(run.tail_us(first, 0.999))
        setup = three(first.setup_us)
        answers = first.formulation or "-"
        lines.append((time or 0.0, [label, answers, setup, *medians, tail, three(ratio), *inside]))
    headers = ("method", "answers", "set-up [µs]", *(f"{name} [µs]" for name in sets), "p99.9 [µs]")
    ordered = [cells for _, cells in sorted(lines, key=lambda line: line[0])]
    return table((*headers, "over pinv", "binding [µs]", "own clock [µs]"), ordered)


def _median(row: Row | None) -> float | None:
    return None if row is None else row.call_p50_us


def tails(run: Run, drawn: frozenset[str]) -> str:
    """Quantiles of single calls with their intervals, the slowest call, and the method's own worst case."""
    parts = [
        "## Tails\n",
        "Quantiles of single calls with 95 % intervals, given only where ten calls lie beyond them. The"
        " slowest call belongs to the machine as much as to the method; *iterations* and *steps* belong to"
        " the method alone (steps: a bound known before the first call).\n",
        _process_note(run),
    ]
    canaries = [row for row in run.rows if row.vehicle == NO_VEHICLE and row.measured.singles]
    if canaries:
        parts += ["What this machine does to fixed work, in the same run:\n", _tails(canaries)]
    for vehicle, demands in run.main_sets:
        rows = [row for row in best_rows(run, vehicle, demands) if row.measured.singles]
        if rows:
            alt = f"{vehicle}: share of calls slower than a time, by method"
            parts += [
                f"### {plain(vehicle)}, {plain(demands)}\n",
                picture(f"tails-{vehicle}.svg", alt, drawn) if demands == run.sets(vehicle)[0] else "",
                _tails(rows),
            ]
    return "\n".join(part for part in parts if part) if len(parts) > 3 else ""


def count_disjoint(rows: Iterable[Row]) -> tuple[int, int]:
    """Number of rows whose repeats' intervals of p99 do not all meet, of how many with two or more."""
    by_row = [[ends for cell in row.measured.cells if (ends := interval(cell.singles, 0.99))] for row in rows]
    several = [intervals for intervals in by_row if len(intervals) > 1]
    gaps = [max(low for low, _ in ends) / min(high for _, high in ends) for ends in several]
    return sum(gap > BIN for gap in gaps), len(gaps)  # a bin is the resolution of an interval's end


def _process_note(run: Run) -> str:
    apart, several = count_disjoint(run.rows)
    if not several:
        return ""
    return (
        "The intervals are what chance leaves open among these calls, as if each were independent of the one"
        " before. Another process, some time later, adds more: in"
        f" {apart} of {several} rows where two repeats have such an interval of p99, these do not meet.\n"
    )


def _tails(rows: list[Row]) -> str:
    headers = ("method", "calls", "p99 [µs]", "p99.9 [µs]", "slowest [µs]", "iterations", "steps, at most")
    lines = []
    for row in rows:
        p99 = (row.call_p99_us, row.call_p99_low_us, row.call_p99_high_us)
        p999 = (row.call_p999_us, row.call_p999_low_us, row.call_p999_high_us)
        counts = [str(v or "") for v in (row.iterations_max, row.worst_case_steps)]
        slowest = three(row.call_max_us)
        calls = str(row.n_single_calls)
        lines.append([row.label, calls, _interval_text(p99), _interval_text(p999), slowest, *counts])
    return table(headers, lines)


def _interval_text(values: tuple[float | None, float | None, float | None]) -> str:
    middle, low, high = (three(value) for value in values)
    return f"{middle} ({low} … {high})" if middle else ""


def growth(run: Run, drawn: frozenset[str]) -> str:
    """Time and allocator size by number of thrusters, with fitted exponents; only for a growth study."""
    measured = series(run)
    if not measured:
        return ""
    parts = [
        "## How it grows with the number of thrusters\n",
        f"Generated vehicles, active demands. Exponent: p of time ~ nᵖ fitted from n = {FITTED_FROM} on, with"
        " its standard error. Allocators are as large as Python sees them: what a solver holds outside is not"
        " in it.\n",
        picture(
            "growth.svg", "median call and allocator size of each method over the number of thrusters", drawn
        ),
    ]
    for k in sorted({s.k for s in measured}):
        family = [s for s in measured if s.k == k]
        parts += [
            f"### {k} degrees of freedom\n",
            _where_it_pays(family) + "\n",
            _table("median [µs], n =", family, Series.times_us),
            _table("allocator [kB], n =", family, Series.kilobytes),
            _refusals(family),
        ]
    return "\n".join(part for part in parts if part)


def _where_it_pays(family: list[Series]) -> str:
    best, without = pays_up_to(family)
    if best is None:
        return "No exact closed form beats the exact QP solvers here."
    text = f"An exact closed form is faster than every exact QP solver up to n = {best}"
    return f"{text}; from n = {min(without)} on none is offered." if without else f"{text}."


def _table(title: str, family: list[Series], of: Callable[[Series], dict[int, float]]) -> str:
    sizes = sorted({n for s in family for n in s.rows})
    lines = []
    for s in family:
        values = of(s)
        fit = exponent(values)
        power = "" if fit is None else f"{fit[0]:.2f} ± {fit[1]:.2f}"
        if values:
            lines.append([s.label, *(three(values.get(n)) for n in sizes), power])
    return table((title, *map(str, sizes), "exponent"), lines)


def _refusals(family: list[Series]) -> str:
    reasons: dict[tuple[str, str], list[int]] = defaultdict(list)
    for s in family:
        for n, row in s.rows.items():
            if row.failed:
                reasons[s.label, row.status].append(n)
    rows = {s.label: s.rows for s in family}
    lines = []
    for (label, status), sizes in reasons.items():
        why = str(rows[label][sizes[0]].reason)
        at = ", ".join(map(str, sizes))
        lines.append(f"- {plain(f'{label}, n = {at}: {status}; at n = {sizes[0]}: {why}')}")
    return "\n".join(lines) + "\n" if lines else ""


MET, BEYOND, MIXED = "attainable", "not attainable", "some attainable"
CLIP = "clip"
"""Rule of practice to compare with: the last column says how much less than it a method delivers."""

ON_BOARD = """## On board: the price in C, and what is delivered

Over {vehicles}; demands {sets}. Times are medians of a call of the
generated C {caller}. *Delivered* is the share of the demanded wrench that thrusters make within their limits,
in the median (half) and for the worst demand (all). It is negative where thrusters that can't stop push more
than was asked. *Turned* is the largest angle between demanded and delivered wrench. *Below clip* is how much
less a method delivers than `clip`: the largest difference of their medians, 99 % quantiles and worst losses;
the two worst demands may differ.
"""


class PricedRow(NamedTuple):
    """A row, the kind of its demands, and the row of ``clip`` on the same demands, if there is one."""

    kind: str
    row: Row
    clip: Row | None


def onboard(run: Run, drawn: frozenset[str]) -> str:
    """A line for each method that is C, over all vehicles; empty where nothing was compiled."""
    priced = [one for vehicle in run.vehicles for one in _priced_rows(run, vehicle)]
    kinds = [kind for kind in (MET, BEYOND, MIXED) if any(one.kind == kind for one in priced)]
    methods = list(dict.fromkeys(one.row.method for one in sorted(priced, key=_by_time)))
    if not methods:
        return ""
    headers = ["method", "answers"]
    for kind in kinds:
        headers += [f"{kind} [µs]", "delivered, half", "delivered, all"]
        headers += [] if kind == MET else ["turned [°]"]
    lines = []
    for method in methods:
        own = [one for one in priced if one.row.method == method]
        cells = [
            cell for kind in kinds for cell in _delivery_cells([one for one in own if one.kind == kind], kind)
        ]
        lines.append([method, own[0].row.title, *cells, _below_clip(own)])
    vehicles = plural(len({one.row.vehicle for one in priced}), "vehicle")
    sets = ", ".join(f"{kind}: {_set_names(run, priced, kind)}" for kind in kinds)
    caller = "from the board's driver" if run.by_driver else "from Python"
    text = ON_BOARD.format(vehicles=vehicles, sets=sets, caller=caller)
    return text + "\n" + table([*headers, "below clip"], lines)


def set_kind(run: Run, vehicle: str, demands: str) -> str:
    """Kind of a set: all, none or some of its demands can be met; empty where the record does not say."""
    problem = run.problem_by_set.get((vehicle, demands))
    if problem is None or not problem.labels:
        return ""
    beyond = problem.labels.get("infeasible", 0)
    return BEYOND if beyond == problem.n_demands else MIXED if beyond else MET


def _priced_rows(run: Run, vehicle: str) -> Iterable[PricedRow]:
    """Correct rows of generated C on the vehicle's first set of each kind and on each log."""
    shown: set[str] = set()
    for demands in run.sets(vehicle):
        kind = set_kind(run, vehicle, demands)
        rows = best_rows(run, vehicle, demands)
        if not kind or not rows or (kind in shown and not run.is_log(vehicle, demands)):
            continue
        shown.add(kind)
        clip = next((row for row in rows if CLIP in (row.method, row.described.twin)), None)
        yield from (PricedRow(kind, row, clip) for row in rows if row.described.twin and is_right(row))


def _delivery_cells(own: list[PricedRow], kind: str) -> list[str]:
    """Cells of one method on all sets of a kind: time, share that half and all demands get, angle."""
    rows = [one.row for one in own]
    cells = [number_range(row.call_p50_us for row in rows)]
    if rows and not any(row.answered_share for row in rows):
        cells += ["refused", ""]
    elif refused := [1 - share for row in rows if (share := row.answered_share) is not None and share < 1.0]:
        cells += [f"refused {percent(max(refused))}", _delivered_share(map(largest_loss, rows))]
    else:
        cells += [
            _delivered_share(row.lost_wrench_p50 for row in rows),
            _delivered_share(map(largest_loss, rows)),
        ]
    turned = [angle for row in rows if (angle := row.direction_error_max_deg) is not None]
    return cells if kind == MET else [*cells, _turn_text(turned)]


def _turn_text(turned: list[float]) -> str:
    return three(drop_rounding(largest(turned)))


def _delivered_share(losses: Iterable[float | None]) -> str:
    known = [loss for loss in losses if loss is not None]
    if not known:
        return ""
    lost = max(known)
    shown = percent(1 - lost)
    return "> 99.9 %" if lost > WRENCH_TOLERANCE and shown == percent(1.0) else shown


def _below_clip(own: list[PricedRow]) -> str:
    below = [
        mine - clips
        for one in own
        if one.clip is not None and one.row.answered_share == 1.0
        for quantile in QUANTILES
        if (mine := quantile(one.row)) is not None and (clips := quantile(one.clip)) is not None
    ]
    return percent(max(below)) if below and max(below) > WRENCH_TOLERANCE else ""


QUANTILES: tuple[Callable[[Row], float | None], ...] = (
    lambda row: row.lost_wrench_p50,
    lambda row: row.lost_wrench_p99,
    lambda row: row.lost_wrench_max,
)


def _by_time(one: PricedRow) -> float:
    return one.row.call_p50_us or 0.0


def _set_names(run: Run, priced: list[PricedRow], kind: str) -> str:
    """Names of the sets of a kind; of a log or mission, also the number of demands that were asked."""
    asked = {one.row.demands: (one.row.vehicle, one.row.demands) for one in priced if one.kind == kind}
    names = []
    for demands, key in sorted(asked.items()):
        problem = run.problem_by_set[key]
        first = "the first " if problem.given else ""
        names.append(f"{first}{problem.n_demands} of {demands}" if problem.left_out else demands)
    return plain(" and ".join(names))
