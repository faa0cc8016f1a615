"""Report section: the price of each method as C, and what it delivers of demands that can be met or not."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from alloc.allocation import WRENCH_TOLERANCE
from bench.results.columns import Row
from bench.results.ranking import best_rows, is_right, largest_loss
from bench.results.rows import Run
from bench.results.text import number_range, percent, plain, plural, table, three

MET, BEYOND, MIXED = "attainable", "not attainable", "some attainable"
CLIP = "clip"
"""What practice does anyway: a method that delivers less than this is named with the number."""

INTRODUCTION = """## On board: the price in C, and what is delivered

Over {vehicles}; demands {sets}. Times are medians of a call of the
generated C {caller}. *Delivered* is the share of the demanded wrench that arrives, each thruster clipped to
its limits: in the median, and of the worst demand; it is negative where thrusters push more than was asked,
as some must that can't stop. *Turned* is the largest angle between the two wrenches. *Below clip* is how much
less is delivered than by `clip`, the largest of three differences: in the median, at 99 % and at worst, which
may be of another demand.
"""


class Priced(NamedTuple):
    """A row, the kind of its demands, and the row of ``clip`` on the same demands, if there is one."""

    kind: str
    row: Row
    clip: Row | None


def onboard(run: Run, drawn: frozenset[str]) -> str:
    """A line for each method that is C, over all vehicles; empty where nothing was compiled."""
    priced = [one for vehicle in run.vehicles for one in _priced(run, vehicle)]
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
        cells = [cell for kind in kinds for cell in _cells([one for one in own if one.kind == kind], kind)]
        lines.append([method, own[0].row.title, *cells, _below_clip(own)])
    vehicles = plural(len({one.row.vehicle for one in priced}), "vehicle")
    sets = ", ".join(f"{kind}: {_names(run, priced, kind)}" for kind in kinds)
    caller = "from the board's driver" if run.by_driver else "from Python"
    said = INTRODUCTION.format(vehicles=vehicles, sets=sets, caller=caller)
    return said + "\n" + table([*headers, "below clip"], lines)


def set_kind(run: Run, vehicle: str, demands: str) -> str:
    """Kind of a set: all, none or some of its demands can be met; empty where the record does not say."""
    problem = run.problem_by_set.get((vehicle, demands))
    if problem is None or not problem.labels:
        return ""
    beyond = problem.labels.get("infeasible", 0)
    return BEYOND if beyond == problem.n_demands else MIXED if beyond else MET


def _priced(run: Run, vehicle: str) -> Iterable[Priced]:
    """The rows of C on the vehicle's first set of each kind and on each log, without those that are wrong."""
    shown: set[str] = set()
    for demands in run.sets(vehicle):
        kind = set_kind(run, vehicle, demands)
        rows = best_rows(run, vehicle, demands)
        if not kind or not rows or (kind in shown and not run.is_log(vehicle, demands)):
            continue
        shown.add(kind)
        clip = next((row for row in rows if CLIP in (row.method, row.described.twin)), None)
        yield from (Priced(kind, row, clip) for row in rows if row.described.twin and is_right(row))


def _cells(own: list[Priced], kind: str) -> list[str]:
    """One method on all sets of one kind: time, least share that half of the demands and all get, turn."""
    rows = [one.row for one in own]
    cells = [number_range(row.call_p50_us for row in rows)]
    if rows and not any(row.answered_share for row in rows):
        cells += ["refused", ""]
    elif refused := [1 - share for row in rows if (share := row.answered_share) is not None and share < 1.0]:
        cells += [f"refused {percent(max(refused))}", _left(map(largest_loss, rows))]
    else:
        cells += [_left(row.lost_wrench_p50 for row in rows), _left(map(largest_loss, rows))]
    turned = [angle for row in rows if (angle := row.direction_error_max_deg) is not None]
    return cells if kind == MET else [*cells, _angle(turned)]


def _angle(turned: list[float]) -> str:
    # An angle as small as the wrench that SOLVED may miss is rounding.
    return three(max(turned) if max(turned) > WRENCH_TOLERANCE else 0.0) if turned else ""


def _left(losses: Iterable[float | None]) -> str:
    known = [loss for loss in losses if loss is not None]
    if not known:
        return ""
    lost = max(known)
    shown = percent(1 - lost)
    return "> 99.9 %" if lost > WRENCH_TOLERANCE and shown == percent(1.0) else shown


def _below_clip(own: list[Priced]) -> str:
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


def _by_time(one: Priced) -> float:
    return one.row.call_p50_us or 0.0


def _names(run: Run, priced: list[Priced], kind: str) -> str:
    """The sets of a kind, and of a log how much of it was asked: the rest may be of another kind."""
    asked = {one.row.demands: (one.row.vehicle, one.row.demands) for one in priced if one.kind == kind}
    names = []
    for demands, key in sorted(asked.items()):
        problem = run.problem_by_set[key]
        names.append(f"the first {problem.n_demands} of {demands}" if problem.left_out else demands)
    return plain(" and ".join(names))
