"""Ranking: the start and level that represents a method, and rows that are right, complete, exact."""

from collections.abc import Iterable, Sequence

from alloc.allocation import WRENCH_TOLERANCE
from alloc.formulations import EXACT_METHODS, Family, find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from bench.record import FARTHER, Capability
from bench.results.columns import Row
from bench.results.quantiles import largest
from bench.results.rows import Run
from bench.results.text import percent

EXACT_WITHIN = 1e-6
"""Largest measured distance to the optimum, over the most limit, at which answers count as exact, whatever
distance was promised. ``tight`` settings are chosen to reach it."""
ROUNDING = 1e-9
"""Shares that differ by no more than this count as equal: it is the rounding of a ratio of counts."""

ATTAINABLE = ("inactive", "active", "uniform")
"""Demand sets that a perfect method serves whole."""


def is_right(row: Row) -> bool:
    """True if a row was measured and no answer in it is wrong or farther off than promised."""
    return not row.failed and row.agreed is not False and not row.wrong


def has_wrong_answer(row: Row) -> bool:
    """True if an answer of this set, or an untimed one, is wrong or farther off than promised."""
    return bool(row.measured.wrong_elsewhere) or any(judged.objection for judged in row.measured.judged)


def objection(row: Row) -> str:
    """Reason why a row is not right, in words."""
    return row.wrong or FARTHER


def is_complete(row: Row) -> bool:
    """True if as many demands were solved as are attainable, and none was missed of those not timed.

    A log may ask for nothing that is hard. What misses a weak part of a demand only counts as solved.
    """
    solved, by_weak = row.solved_fraction, row.partial_by_weak
    return (
        solved is not None
        and solved + by_weak >= row.measured.attainable - ROUNDING
        and not row.measured.missed_elsewhere
    )


def is_optimal(row: Row) -> bool:
    """True if a row's formulation serves every attainable demand at least effort (eq. 4-5)."""
    return find_formulation(row.formulation).optimal


def is_exact(row: Row) -> bool:
    """True if all of a row's answers are the constrained optimum, within EXACT_WITHIN.

    Without a spare thruster there is one solution, so whoever misses nothing that can be met has found it.
    """
    distance = row.distance_relative
    near = distance is not None and distance <= EXACT_WITHIN and is_optimal(row)
    if row.measured.unique and not is_optimal(row):
        near = (largest_miss([row]) or 0.0) <= EXACT_WITHIN and row.answered_share == 1.0
    return near and is_complete(row) and is_right(row)


def best_rows(run: Run, vehicle: str, demands: str) -> list[Row]:
    """One measured row for each method on that demand set, fastest first.

    A method is represented by the fastest of its starts and levels that are right on all of the vehicle's
    demand sets, exact ones before others. Where none is right on all sets, the fastest represents it.
    """
    wrong = {row.label for row in run.select(vehicle) if not is_right(row)}
    chosen: dict[str, tuple[bool, bool, float, Row]] = {}
    for row in run.select(vehicle, demands):
        time = row.call_p50_us
        allocates = bool(row.measured.cells[0].formulation)  # a yardstick has none
        if row.failed or time is None or not allocates:
            continue
        rank = (row.label in wrong, not is_exact(row), time, row)
        if row.method not in chosen or rank[:3] < chosen[row.method][:3]:
            chosen[row.method] = rank
    return [row for *_, row in sorted(chosen.values(), key=lambda rank: rank[2])]


def pareto_front(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other point beats in both numbers, sorted by the first."""
    kept: list[tuple[float, float]] = []
    for point in sorted(points):
        if not kept or point[1] < kept[-1][1]:
            kept.append(point)
    return kept


def front_rows(rows: Iterable[Row]) -> list[Row]:
    """The rows that no other row beats in time and in the wrench that is lost, fastest first."""
    known = [
        (time, max(lost, WRENCH_TOLERANCE), row)
        for row in rows
        if (time := row.call_p50_us) is not None and (lost := largest_loss(row)) is not None
    ]
    kept = set(pareto_front([point[:2] for point in known]))
    return [row for time, lost, row in known if (time, lost) in kept]


def largest_loss(row: Row) -> float | None:
    """The most share of a demand's wrench that is not delivered: 1 where a demand got no thrusts."""
    answered = row.answered_share
    return row.lost_wrench_max if answered is None or answered == 1.0 else 1.0


def largest_miss(rows: Sequence[Row]) -> float | None:
    """The most share of an attainable wrench that is not delivered, over demand sets; None if not known.

    Older records do not have it: there it is what was lost on sets that can be met whole.
    """
    known = [judged.missed_max for row in rows for judged in row.measured.judged]
    older = [row for row in rows if all(judged.missed_max is None for judged in row.measured.judged)]
    return largest([*known, *(largest_loss(row) for row in older if row.demands in ATTAINABLE)])


def choose_rows(rows: Sequence[Row], most: int) -> list[Row]:
    """Choose ``most`` of one vehicle's rows, fastest first: the user's, the front, then families in turns."""
    own = [row for row in rows if row.described.plugin]
    chosen = [*own, *(row for row in front_rows(rows) if row not in own)][:most]
    queues: dict[str, list[Row]] = {}
    for row in rows:
        if row not in chosen:
            queues.setdefault(row.family, []).append(row)
    while len(chosen) < most and any(queues.values()):
        chosen += [queue.pop(0) for queue in queues.values() if queue][: most - len(chosen)]
    return [row for row in rows if row in chosen]


def representatives(rows: Sequence[Row]) -> dict[str, Row]:
    """The rows that stand for six ways to allocate, as far as there are, of one vehicle's sorted by time.

    Closed forms take the same time within noise, so among them the name decides and the choice stays.
    """
    hard = [row for row in rows if is_exact(row) and row.formulation == HARD.name]
    known = [row for row in rows if row.family == Family.CLOSED_FORM and is_right(row)]
    closed = sorted(known, key=lambda row: row.method)
    ways = {
        "without limits, in C": [row for row in closed if row.described.twin],
        "without limits, in Python": [row for row in closed if not row.described.twin],
        "exact within limits, in C": [row for row in hard if row.described.twin and not row.described.solver],
        "exact within limits, in Python": [row for row in hard if not row.described.foreign],
        "exact, by a solver's own C": [row for row in hard if row.family == Family.GENERATED],
        "exact, by the fastest solver": [
            row for row in hard if row.described.solver and row.family != Family.GENERATED
        ],
    }
    return {way: found[0] for way, found in ways.items() if found}


def shortlist(rows: Sequence[Row], taken: str = "") -> list[Row]:
    """The few rows that a decision needs, of one vehicle's sorted by time.

    The front of time and loss, the ``representatives``, and the rule of practice that loses least. A method
    with a wrong answer is none of them. The method ``taken`` and what the user brought always are.
    """
    everyone, rows = rows, [row for row in rows if is_right(row)]
    rules = [(lost, row) for row in rows if row.family == Family.PRACTICE for lost in _known(row)]
    rule = [row for _, row in sorted(rules, key=lambda pair: pair[0])[:1]]
    chosen = [*front_rows(rows), *representatives(rows).values(), *rule]
    return [row for row in everyone if row in chosen or row.described.plugin or row.method == taken]


def unmeasured_plugins(run: Run, vehicle: str, demands: str) -> list[Row]:
    """Rows of the user's own methods that could not be measured there: each has its line, with the reason."""
    return [row for row in run.select(vehicle, demands) if row.described.plugin and row.failed]


def _known(row: Row) -> list[float]:
    lost = largest_loss(row)
    return [] if lost is None else [max(lost, WRENCH_TOLERANCE)]


def served_share(run: Run, vehicle: str, row: Row) -> float | None:
    """The share of the vehicle's attainable set that a method delivers within 1 % [-]; None if not known.

    The share depends on the answers alone: a native build serves what its twin does, and any exact solver of
    the catalogue what ``nullspace`` does; a plug-in was exact on the demands asked, and is counted itself.
    What was not counted is what the row served of ``uniform``, a demand set that is even over the attainable
    set.
    """
    capability = run.capability(vehicle)
    served = [s for s in capability.served if s.fault is None] if capability else []
    shares = {s.method: s.within_1pct / s.n_demands for s in served}
    as_exact = EXACT_METHODS[:1] * (is_exact(row) and not row.described.plugin)
    names = [*as_exact, row.described.twin, row.method]
    on_uniform = [other for other in run.select(vehicle, "uniform") if other.label == row.label]
    known = [*(shares[name] for name in names if name in shares), *(r.within_1pct_share for r in on_uniform)]
    return next(iter(known), None)


def loss_text(row: Row | None) -> str:
    """The largest share of a demand's wrench that a row loses; 0 where each is met."""
    worst = None if row is None else largest_loss(row)
    return "0" if worst is not None and worst < WRENCH_TOLERANCE else percent(worst)


def served_text(run: Run, vehicle: str, row: Row) -> str:
    """``served_share`` in per cent; empty where it is not known."""
    return percent(served_share(run, vehicle, row))


def uncounted_methods(capability: Capability) -> list[str]:
    """A line for each method whose share of the vehicle could not be had, with the reason."""
    where = f"on {capability.vehicle}, what it serves is not counted"
    return [f"{u.method} {where}: {u.status} {u.reason.rstrip('.')}" for u in capability.unserved]
