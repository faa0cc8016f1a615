"""One side's answers to a question, by equations and against those of the other side."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np

from alloc import Allocation, Label, NotApplicable, Status, Vehicle
from alloc.allocation import BoolArray
from alloc.formulations import list_formulations
from alloc.live.plain import ANY_DISTANCE
from alloc.vehicle.checks import ARRAYS
from bench.demands import DemandSet
from bench.demands.store import Case
from bench.gate.contract import farthest
from bench.gate.record import GateCell
from bench.gate.side import Died, Prober, Refused
from bench.gate.worker import packed, unpacked
from bench.judging.faults import faults, measure_answers, stack_thrusts
from bench.judging.judge import judge
from bench.judging.question import Question, check_promises
from bench.results.text import plural

SECONDS = 2.0
"""Longest time that one cell takes to answer one kind of demands [s]; a slow method is asked fewer."""

HANGS_S = 30.0
"""A method that has not replied to a question after this time hangs [s]; ``many`` replies at its end."""

ROUNDING = 1e-9
"""Distance of two answers, relative to the largest limit, that rounding in another order may make."""

EDGE = 1e-6
"""|alpha* - 1| within which a status may differ between the sides: there rounding decides it."""

LESS = (Status.NOT_CONVERGED, Status.PARTIAL)
"""Statuses that may become SOLVED: its equations show that this is better."""


class SideAnswers(NamedTuple):
    """Promises and answers of one side's cell.

    Attributes
    ----------
    lacks : why the side has no such cell, empty where it has
    promises : formulation, limited and tolerance, by name
    answers : one for each of the first demands of the question
    raised : which calls raised, by demand, and with what
    at_odds : what is wrong with how they were given, empty where nothing is: ``many`` answers otherwise than
        single calls, an answer's memory is another's too, what a call is given is written into
    refused : whether the cell is lacking because the method does not cover the vehicle
    many : whether it has ``many``
    """

    lacks: str
    promises: dict[str, Any]
    answers: Sequence[Allocation]
    raised: Mapping[int, str] = MappingProxyType({})
    at_odds: str = ""
    refused: bool = False
    many: bool = True


def ask_side(side: Prober, cell: GateCell, question: Question) -> SideAnswers:
    """Ask one side for its answers to the question's demands, as many as it gives in SECONDS.

    Thrusts of ``many`` are compared with those of single calls on the cell's own vehicle only: on the nearly
    symmetric one (``bench.gate.questions.nearly_symmetric``) rounding decides how far they lie apart.
    """
    vehicle, build = question.demands.vehicle, cell.names | state(question.demands.vehicle)
    own = build["vehicle"] == cell.vehicle
    if not own:
        build["numbers"] = {"dof": vehicle.dof, "priority": vehicle.priority} | {
            key: getattr(vehicle, key).tolist() for key in ARRAYS
        }
    try:
        promises = check_promises(side.ask("build", cell=cell.name, **build))
        raw = side.ask("answers", cell=cell.name, seconds=SECONDS, timeout=HANGS_S, **calls(question.demands))
    except (Died, Refused, ValueError) as reason:
        refused = isinstance(reason, Refused) and reason.kind == NotApplicable.__name__
        return SideAnswers(str(reason), {}, (), refused=refused)
    return _parse_reply(raw, promises, vehicle, own=own)


def ask_first_built(side: Prober, cell: GateCell, question: Question, now: SideAnswers) -> SideAnswers:
    """Ask the allocator that was built first once more, after others were built for failed thrusters.

    ``now`` is what it answered before.
    """
    try:
        raw = side.ask(
            "answers", cell=cell.name, seconds=SECONDS, early=True, timeout=HANGS_S, **calls(question.demands)
        )
    except (Died, Refused) as reason:
        lost = isinstance(reason, Refused) and reason.kind == KeyError.__name__  # its process ended meanwhile
        return now if lost else SideAnswers(str(reason), {}, ())
    return _parse_reply(raw, now.promises, question.demands.vehicle, own=False)


def _parse_reply(
    raw: Mapping[str, Any], promises: dict[str, Any], vehicle: Vehicle, *, own: bool
) -> SideAnswers:
    """A worker's reply as answers that can be judged."""
    odd = set(raw["odd"])
    # Each f is an array of its own: the judge looks for answers that share memory.
    thrusts = [None if i in odd else f.copy() for i, f in enumerate(unpacked(raw["F"]))]
    # A wrong plug-in's status may be any number, which is for the judge to say.
    answers = [
        Allocation(cast("Any", f), cast("Status", status), share=tuple(share))
        for f, status, share in zip(thrusts, raw["status"], raw["shares"], strict=True)
    ]
    at_odds = "it writes into the demand, or the limits, that it is given" if raw["writes"] else ""
    if raw["shared"]:
        at_odds = "answers share memory: a later call overwrites an earlier result"
    for lot in raw["together"]:
        of = plural(lot["length"], "demand")
        if lot["other"] is not None:
            at_odds = f"many() of {of} gives demand {lot['other']} another status than a call of its own"
        elif own and lot["apart"] > apart_allowed(promises, vehicle):
            at_odds = f"many() of {of} gives thrusts {lot['apart']:.3g} N from those of single calls"
    return SideAnswers("", promises, answers, dict(raw["raised"]), at_odds, many=raw["many"])


def calls(demands: DemandSet | Case) -> dict[str, Any]:
    """The demands, with their limits where they have any, as a worker takes them."""
    limits = () if demands.f_min is None or demands.f_max is None else (demands.f_min, demands.f_max)
    return {"taus": packed(demands.taus), "limits": [packed(side) for side in limits]}


def state(vehicle: Vehicle) -> dict[str, Any]:
    """The vehicle's name, and which of its thrusters are off or weaker, as a worker takes them."""
    weaker = [(i, ready) for i, ready in enumerate(vehicle.readiness.tolist()) if ready < 1]
    return {"vehicle": vehicle.whole or vehicle.name, "weaker": weaker}


def shorten(side: SideAnswers, count: int) -> SideAnswers:
    """The first ``count`` answers of a side."""
    raised = {demand: what for demand, what in side.raised.items() if demand < count}
    return side._replace(answers=side.answers[:count], raised=raised)


def find_error(question: Question, side: SideAnswers) -> str:
    """Errors of one side's answers by the equations, in words; empty for none."""
    if side.lacks:
        return ""
    judged = judge(question, side.answers, **side.promises, thorough=False)
    if judged.wrong or side.at_odds:  # both: memory that answers share explains what is wrong with them
        return "; ".join(filter(None, (judged.wrong, side.at_odds)))
    for demand, what in side.raised.items():
        return f"raises {what}, for demand {demand}"
    if judged.agrees is False:
        promised = side.promises["tolerance"] * question.demands.vehicle.f_scale
        return f"{judged.distance_max_N:.3g} N from the optimum, beyond its promise of {promised:.3g} N"
    return ""


def error_mask(question: Question, side: SideAnswers) -> BoolArray:
    """Mask of one side's answers that are wrong by the equations, or beyond the promised distance, (N,)."""
    seen = measure_answers(question, side.answers, side.promises["formulation"])
    wrong: BoolArray = seen.distance > side.promises["tolerance"] * question.demands.vehicle.f_scale
    for kind in faults(question, seen, **side.promises).values():
        wrong |= kind
    wrong[list(side.raised)] = True
    return wrong


def is_useless(question: Question, base: SideAnswers, head: SideAnswers) -> bool:
    """True if base meets fewer than half of the inactive demands that head meets, as with a reversed sign."""
    inside = np.flatnonzero(question.demands.labels[: len(base.answers)] == Label.INACTIVE).tolist()
    before, now = (sum(side.answers[i].status == Status.SOLVED for i in inside) for side in (base, head))
    return 2 * before < now


def _mended(question: Question, base: SideAnswers, head: SideAnswers, doubted: bool) -> BoolArray:
    """Mask of demands (N,) that head answers rightly, and base wrongly, in part, or not at all.

    What is SOLVED is held to the equations; of PARTIAL nothing says that it is any use. Where base is
    ``doubted`` it is no evidence of what is right where no optimum is known, as of demands beyond reach.
    """
    pairs = zip(base.answers, head.answers, strict=True)
    mended = error_mask(question, base)
    mended |= np.array([a.status in LESS and b.status == Status.SOLVED for a, b in pairs], dtype=bool)
    if doubted:
        now = measure_answers(question, head.answers, head.promises["formulation"])
        beyond = question.demands.labels == Label.INFEASIBLE
        mended |= np.isnan(now.distance) & (now.finite | beyond)
    mended &= ~error_mask(question, head)
    return mended


def find_difference(
    question: Question, base: SideAnswers, head: SideAnswers, *, doubted: bool = False
) -> str:
    """Difference between two sides' answers; empty where there is none, or where wrong or none became right.

    Answers that are wrong on both sides are compared too: a wrong answer may get worse. ``doubted`` says that
    base is ``is_useless`` altogether.
    """
    vehicle, on_edge = question.demands.vehicle, np.abs(question.demands.alpha - 1) <= EDGE
    if less := _less(base, head):
        return less
    mended = _mended(question, base, head, doubted)
    alike = ~mended
    for i, (a, b) in enumerate(zip(base.answers, head.answers, strict=True)):
        if a.status != b.status:
            if not on_edge[i] and not mended[i]:
                return f"status {_name(a.status)} → {_name(b.status)} for demand {i}"
            alike[i] = False
        elif len(b.share) < len(a.share):
            return f"{plural(len(a.share), 'share')} → {len(b.share) or 'none'} for demand {i}"
        elif not (
            mended[i]
            or a.share == b.share[: len(a.share)]  # most are, and this costs less
            or np.allclose(a.share, b.share[: len(a.share)], rtol=0, atol=EDGE)
        ):
            before, now = (" ".join(f"{share:.3g}" for share in side.share) for side in (a, b))
            return f"shares {before} → {now} for demand {i}"
    thrusts = (stack_thrusts([answer.f for answer in side.answers], vehicle.n)[0] for side in (base, head))
    apart = farthest(*(F[alike] for F in thrusts))
    allowed = apart_allowed(base.promises, vehicle)
    if not apart > allowed:
        return ""
    return f"thrusts differ by up to {apart:.3g} N, {allowed:.3g} N allowed by its tolerance"


def _less(base: SideAnswers, head: SideAnswers) -> str:
    """Promises of base that head lacks, in words; empty for none."""
    before, now = base.promises, head.promises
    known = {
        formulation.name for formulation in list_formulations()
    }  # a rule of one's own promises no optimum
    if before["formulation"] != now["formulation"] and before["formulation"] in known:
        return f"formulation {before['formulation']} → {now['formulation']}: less is promised"
    if before["limited"] and not now["limited"]:
        return "limited True → False: less is promised"
    if now["tolerance"] > before["tolerance"]:
        return f"tolerance {before['tolerance']:g} → {now['tolerance']:g}: less is promised"
    return "many() is gone" if base.many and not head.many else ""


def apart_allowed(promises: Mapping[str, Any], vehicle: Vehicle) -> float:
    """Distance by which two answers to one demand may lie apart [N].

    Either may be as far from the optimum as is promised, in opposite directions. A method that promises no
    distance is held to what it answered the other time.
    """
    tolerance: float = promises["tolerance"]
    return 2 * (tolerance if tolerance < ANY_DISTANCE else ROUNDING) * vehicle.f_scale


def _name(status: int) -> str:
    """The status in words; a wrong plug-in may give any number."""
    return Status(status).name if status in set(Status) else str(status)
