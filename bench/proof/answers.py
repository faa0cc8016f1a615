"""Answers of the compiled C to many demands, in this process, against equations: tested, not proven."""

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import Label, NotApplicable, Status, Vehicle, build
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray, StatusArray
from alloc.c import arguments, known_faults
from alloc.c.compiled import shared_library
from alloc.c.selftest import AGREEMENT
from alloc.errors import NotInstalled
from alloc.formulations import Formulation, find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from alloc.kernels.tolerance import DOUBLE, SINGLE, WRENCH_ERROR
from alloc.methods import recipe
from alloc.program import Scalar
from alloc.reach.edge import start
from alloc.reach.way import step_maps
from bench.demands import build_demands, labelled
from bench.demands.corners import attainable
from bench.judging.judge import largest_gap
from bench.judging.question import Question
from bench.proof.proof import Claim, unproved
from bench.proof.source import ANSWERED, Subject

DEMANDS, SEED = 2_000, 2004
"""Number of demands for each fault unless another is asked for, and the seed."""
MOVING = "jolts"
"""Demands with limits of their own, thrusters that are stuck and limits that cross among them: every other
one where the C takes limits of the call."""
SIZES = (0.1, 0.5, 0.9, 0.99, 1.0, 1 + 1e-7, 1 + 1e-5, 1.0003, 1.0009, 1.01, 2.0)
"""Demands are as many times as large as those of thrusts within the limits, many of which lie on the edge."""
PROCESSORS = (
    "#undef __ARM_FP\n",
    "#undef __ARM_FP\n#define __ARM_FP 12\n"
    "#undef __ARM_FEATURE_NUMERIC_MAXMIN\n#define __ARM_FEATURE_NUMERIC_MAXMIN 1\n",
)
"""Lines before the C that compile it as for an FPU without an instruction for a minimum, and with one."""
PROGRAMS = 12
"""Demands of each fault whose shares linear programs tell."""
SHARE: dict[Scalar, float] = {"double": 1e-6, "float": 1e-4}
"""Distance of a share from the linear program's: HiGHS keeps its rows to 1e-7; in float some hundred
roundings, times the condition of the way."""
GAP: dict[Scalar, float] = {"double": 1e-6, "float": 1e-3}
"""Largest duality gap of least effort, relative to the effort [-]. Twice the square root of it bounds how far
thrusts are from the optimum, relative to their size."""

OTHER: dict[Scalar, float] = {"double": 1e-3, "float": 1e-2}
"""Share of answers that may be others than in Python: where two thrusters reach their limits at once,
rounding decides which one a rule looks at first."""

SOLVED = "Demands that can be met are SOLVED: {which}."
MADE = "SOLVED means that the wrench is made, T f = τ, inside and beyond the edge of what can be met."
REFUSED = "A demand with α* below 0.999 is not SOLVED."
EFFORT = "A SOLVED demand is met with least effort, by the duality gap."
SHARES = "Each share is the linear program's: as far along the way as the thrusters reach."
DELIVERED = "An answer makes the part of the wrench that its shares say, with least effort."
TWIN = "Answers are those of the method in Python, up to rounding."
STRONG = " Directions that are weak are left out of T and τ."
MIX = (
    "Where a direction counts in part, thrusts are Python's f_0 + w (f_1 - f_0), up to rounding; nothing is"
    " claimed of their wrench and shares."
)
SAME = "FPUs with an instruction for a minimum, and those without, give the same answers."
ATTAINABLE, INSIDE = "those with α* above 1.001", "those whose T* τ lies inside the limits"
UNSTOPPED = "those with α* above 1.001 that no level stops on the way to 1.001 τ"
FARTHER = 1.001
NARROW = 10.0
"""Times GAP for floats with limits of the call: where these are narrow, a gap counts what single precision
misses of a wrench many times over. On tiburon it is 5e-3 of the effort of thrusts 2e-4 from the optimum."""
BY = "seeded demands, answered by the compiled C"
UNIT: dict[Scalar, float] = {"double": DOUBLE, "float": SINGLE}
"""Rounding of a number [-]."""


class FaultAnswers(NamedTuple):
    """Answers of the C to N demands of one fault.

    Attributes
    ----------
    vehicle : with that fault, without its weak directions
    question : the demands, labelled, of the vehicle with them
    F, status, share : (N, n) thrusts [N], zero where there are none, (N,) statuses and (N, levels) shares
    differ : (N,) which are answered otherwise where the FPU has an instruction for a minimum
    """

    vehicle: Vehicle
    question: Question
    F: FloatArray
    status: StatusArray
    share: FloatArray
    differ: BoolArray

    @property
    def whole(self) -> Vehicle:
        """The vehicle with its weak directions."""
        return self.question.demands.vehicle


def answer_claims(of: Subject, demands: int = DEMANDS) -> list[Claim]:
    """Claims that many answers show; a claim that no answer bears on is not shown.

    Runs the C in this process, so memory must be known to be safe.
    """
    try:
        answers = {
            fault: fault_answers(of, fault, demands)
            for fault in (-1, *known_faults(of.vehicle, of.faults).tolist())
        }
    except NotInstalled as lacking:
        return [unproved(MADE, [str(lacking)])]
    formulation = find_formulation(recipe(of.kernel).formulation)
    optimal = formulation.optimal_for(of.vehicle)
    which = ATTAINABLE if optimal else UNSTOPPED if formulation.way else INSIDE
    checks: list[tuple[str, Callable[[FaultAnswers], tuple[int, str]]]] = [
        (MADE, lambda each: _made(each, of))
    ]
    if formulation.keeps_inside:
        checks.insert(0, (SOLVED.format(which=which), lambda each: _solved(each, which, formulation)))
    checks.append((SAME, _same))
    checks += [(REFUSED, lambda each: _refused(each, of))] if of.limited else []
    checks += [(EFFORT, lambda each: _effort(each, of))] if optimal else []
    if not optimal and not formulation.way:  # a rule's answer is what the rule says, which no optimum tells
        checks.append((TWIN, lambda each: _as_in_python(each, of)))
    if of.levels:
        checks += [(SHARES, lambda each: _shares(each, of)), (DELIVERED, lambda each: _delivered(each, of))]
    if not formulation.way:
        return [_claim(sentence, answers, check) for sentence, check in checks]
    mixes = {fault: each for fault, each in answers.items() if formulation.mixes(each.whole)}
    alone = {fault: each for fault, each in answers.items() if fault not in mixes}
    weak = any(each.whole.weak_left.any() for each in alone.values())
    claims = []
    for sentence, check in checks:
        if sentence not in (MADE, EFFORT, SHARES, DELIVERED):
            claims.append(_claim(sentence, answers, check))
        elif alone:
            claims.append(_claim(sentence + STRONG * weak, alone, check))
    if mixes:
        claims.append(_claim(MIX, mixes, lambda each: _as_in_python(each, of)))
    return claims


def _claim(
    sentence: str, answers: dict[int, FaultAnswers], check: Callable[[FaultAnswers], tuple[int, str]]
) -> Claim:
    count, words = 0, list[str]()
    for fault, each in answers.items():
        held, wrong = check(each)
        count += held
        if wrong:
            words.append(f"fault {fault}: {wrong}")
    if not count and not words:
        words = ["no answer that it speaks of was seen"]
    if words:
        return unproved(sentence, words)
    return Claim(claim=sentence, verdict="tested", by=BY, words=[f"{count:,} answers"])


def _solved(answers: FaultAnswers, which: str, formulation: Formulation) -> tuple[int, str]:
    demands = answers.question.demands
    asked = np.isin(demands.labels, (Label.INACTIVE,) if which == INSIDE else (Label.INACTIVE, Label.ACTIVE))
    if which == UNSTOPPED and formulation.way is not None:
        way = formulation.parts(answers.whole)[0].way
        low, high = demands.limits
        begin = way.departure(low, np.maximum(low, high))  # where limits cross, nothing is asked
        farther = begin.wrench + FARTHER * (demands.taus - begin.wrench)
        _, share = way.towards_many(farther, begin)
        asked &= (share == 1).all(axis=1)
    wrong = asked & (answers.status != Status.SOLVED)
    return int(asked.sum()), _first(answers, wrong, asked)


def _made(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    demands = answers.question.demands
    asked = answers.status == Status.SOLVED
    if not of.limited:
        asked &= demands.labels != Label.INFEASIBLE
    wrong = asked & ~_makes(answers, _wanted(answers, of), of)
    return int(asked.sum()), _first(answers, wrong, asked)


def _wanted(answers: FaultAnswers, of: Subject) -> FloatArray:
    """Wrenches (N, k) of which SOLVED speaks: the demands, without what they ask along weak directions."""
    taus, formulation = answers.question.demands.taus, find_formulation(recipe(of.kernel).formulation)
    if formulation.way is None or not answers.whole.weak_left.any():
        return taus
    levels = formulation.parts(answers.whole)[0].way.levels
    return _way_ends(answers, step_maps(answers.vehicle, levels), np.ones((len(taus), len(levels))))


def _way_ends(answers: FaultAnswers, maps: FloatArray, share: FloatArray) -> FloatArray:
    """Wrenches (N, k) behind all levels, of each the share (N, L)."""
    taus = answers.question.demands.taus
    at = np.broadcast_to(start(*answers.question.demands.limits) @ answers.vehicle.TP.T, taus.shape)
    for level, D in enumerate(maps):
        at = at + share[:, level, None] * ((taus - at) @ D.T)
    return at


def _makes(answers: FaultAnswers, wrenches: FloatArray, of: Subject) -> BoolArray:
    """Mask of answers (N,) that make these wrenches (N, k) [N, N m]."""
    vehicle = answers.vehicle
    miss = np.abs(answers.F @ vehicle.TP.T - wrenches)
    # A kernel holds T f - tau against MET in its own scalar: each of its sums may be off by this much.
    terms = np.abs(answers.F) @ np.abs(vehicle.TP.T) + np.abs(answers.question.demands.taus)
    rounding = (vehicle.n + 2) * UNIT[of.scalar] * terms
    makes: BoolArray = np.all(miss <= WRENCH_ERROR[of.scalar] * vehicle.wrench_scale + rounding, axis=1)
    return makes


def _same(answers: FaultAnswers) -> tuple[int, str]:
    asked = np.ones(len(answers.differ), bool)
    return len(asked), _first(answers, answers.differ, asked)


def _refused(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    demands = answers.question.demands
    asked = demands.labels == Label.INFEASIBLE
    if of.limits == "call":  # narrow limits without zero: α* may be small of what is next to attainable
        asked &= ~_makes(answers, _wanted(answers, of), of)
    wrong = asked & (answers.status == Status.SOLVED)
    return int(asked.sum()), _first(answers, wrong, asked)


def _as_in_python(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    vehicle, demands = answers.whole, answers.question.demands
    F, status = build(of.kernel, vehicle).many(demands.taus, demands.f_min, demands.f_max)
    apart = np.abs(answers.F - F).max(axis=1) / np.maximum(np.abs(F).max(axis=1), vehicle.f_scale)
    asked = demands.labels != Label.BOUNDARY
    wrong = asked & (answers.status != status)
    wrong |= asked & np.isin(status, ANSWERED) & ~(apart <= AGREEMENT[of.scalar])
    few = wrong.sum() <= OTHER[of.scalar] * asked.sum()
    return int(asked.sum()), "" if few else _first(answers, wrong, asked)


def _effort(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    return _least(answers, _wanted(answers, of), answers.status == Status.SOLVED, of)


def _least(answers: FaultAnswers, wrenches: FloatArray, asked: BoolArray, of: Subject) -> tuple[int, str]:
    """True if those answers that are selected make their wrenches (N, k) with least effort."""
    demands = replace(answers.question.demands, vehicle=answers.vehicle, taus=wrenches)
    question = replace(answers.question, demands=demands)
    F = np.where(asked[:, None], answers.F, np.nan)
    gap = largest_gap(question, F, np.where(asked, Status.SOLVED, answers.status), HARD.name)
    if gap is None:
        return 0, ""
    narrow = NARROW if of.scalar == "float" and of.limits == "call" else 1.0
    wrong = not gap <= narrow * GAP[of.scalar]
    return int(asked.sum()), f"a gap of {gap:.2g} of the effort" if wrong else ""


def _delivered(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    """True if thrusts and shares of an answer belong together, also where a demand is met in part."""
    way = find_formulation(recipe(of.kernel).formulation).way
    assert way is not None  # a kernel that writes shares has levels
    try:
        maps = step_maps(answers.vehicle, way(answers.whole).levels)
    except NotApplicable as refusal:
        return 0, str(refusal)
    at = _way_ends(answers, maps, answers.share)
    asked = np.isin(answers.status, ANSWERED)
    wrong = asked & ~_makes(answers, at, of)
    if wrong.any():
        return int(asked.sum()), _first(answers, wrong, asked)
    return _least(answers, at, asked, of)


def _shares(answers: FaultAnswers, of: Subject) -> tuple[int, str]:
    vehicle, demands = answers.vehicle, answers.question.demands
    try:
        through = find_formulation(recipe(of.kernel).formulation).parts(answers.whole)[0].way
    except NotApplicable as refusal:
        return 0, str(refusal)
    maps, count = step_maps(vehicle, through.levels, together=through.together), 0
    low, high = (np.broadcast_to(side, answers.F.shape) for side in demands.limits)
    partly, given = (answers.share < 1).any(axis=1), np.isin(answers.status, ANSWERED)
    some = [np.flatnonzero(given & which)[:PROGRAMS] for which in (partly, ~partly)]
    for i in np.concatenate(some).tolist():
        tau, limits, shares = demands.taus[i], (low[i], high[i]), answers.share[i].tolist()
        at, best = vehicle.TP @ start(*limits), list[float]()
        if through.together:
            steps = maps @ (tau - at)
            alone = [min(1.0, _reach(vehicle, at, step, limits)) for step in steps]
            best = (min(1.0, _reach(vehicle, at, alone @ steps, limits)) * np.array(alone)).tolist()
        else:
            for D, keep, share in zip(maps, through.keep, shares, strict=True):
                step = D @ (tau - at)
                best.append(min(1.0, keep * _reach(vehicle, at, step, limits)))
                at = at + share * step
        for level, (share, largest) in enumerate(zip(shares, best, strict=True)):
            count += 1
            if not abs(share - largest) <= SHARE[of.scalar]:
                return count, f"share {level} of τ = {tau.tolist()} is {share:.9g}, not {largest:.9g}"
    return count, ""


def _reach(
    vehicle: Vehicle, at: FloatArray, step: FloatArray, limits: tuple[FloatArray, FloatArray]
) -> float:
    """The largest t with T f = at + t step within the limits, by a linear program; infinite for no step."""
    from scipy.optimize import linprog

    scale = vehicle.wrench_scale
    if not np.abs(step / scale).max() > WRENCH_TOLERANCE:
        return np.inf
    within = [*zip(*limits, strict=True)]
    T, begin, moved = vehicle.TP / scale[:, None], at / scale, (step / scale)[:, None]
    aim = np.append(np.zeros(vehicle.n), -1.0)
    optimum = linprog(aim, A_eq=np.hstack([T, -moved]), b_eq=begin, bounds=[*within, (0.0, None)])
    if optimum.x is None:  # rounding of earlier shares led out of the set: the nearest point of it
        off = np.ones((vehicle.k, 1))
        rows = np.vstack([np.hstack([T, -off]), np.hstack([-T, -off])])
        nearest = linprog(-aim, A_ub=rows, b_ub=np.append(begin, -begin), bounds=[*within, (0.0, None)])
        if nearest.x is None or nearest.x[-1] > WRENCH_ERROR["float"]:
            return 0.0
        begin = T @ nearest.x[:-1]
        optimum = linprog(aim, A_eq=np.hstack([T, -moved]), b_eq=begin, bounds=[*within, (0.0, None)])
    return float(optimum.x[-1]) if optimum.x is not None else 0.0


def _first(answers: FaultAnswers, wrong: BoolArray, asked: BoolArray) -> str:
    if not wrong.any():
        return ""
    i, demands = int(wrong.argmax()), answers.question.demands
    own = (
        f" within {low[i].tolist()} … {high[i].tolist()}" for low, high in [demands.limits] if low.ndim > 1
    )
    tau = f"{demands.taus[i].tolist()}{''.join(own)}"
    return f"not so of {int(wrong.sum())} of {int(asked.sum())}, first τ = {tau}"


def fault_answers(of: Subject, fault: int, count: int) -> FaultAnswers:
    """Answers of the C to so many seeded demands of a fault; raises NotInstalled without a compiler."""
    vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
    rng = np.random.default_rng(SEED)
    scalar = np.float32 if of.scalar == "float" else np.float64
    wanted = (attainable(vehicle, rng, count) * rng.choice(SIZES, count)).T
    limits: list[FloatArray] = []
    if of.limits == "call":
        limits = [np.tile(side, (count, 1)) for side in (vehicle.f_min, vehicle.f_max)]
        moved = build_demands(MOVING, vehicle, SEED, count // 2)
        for whole, part in zip((wanted, *limits), (moved.taus, *moved.limits), strict=True):
            whole[::2] = part
        limits = [side.astype(scalar) for side in limits]
    # Demands are labelled before they are rounded: that may leave what thrusters span.
    demands = labelled(
        "proof", vehicle, np.ascontiguousarray(wanted), *(side.astype(float) for side in limits)
    )
    taus = np.ascontiguousarray(wanted.astype(scalar))
    given, other = (_run(of, fault, [taus, *limits], before) for before in PROCESSORS)
    differ = (np.hstack(given) != np.hstack(other)).any(axis=1)
    F, share, status = given
    held = find_formulation(recipe(of.kernel).formulation).subject(vehicle)
    return FaultAnswers(
        held, Question(demands, {}, {}), F.astype(float), status[:, 0], share.astype(float), differ
    )


def _run(
    of: Subject, fault: int, arrays: Sequence[FloatArray], before: str
) -> tuple[FloatArray, FloatArray, StatusArray]:
    """Thrusts (N, n), shares (N, levels) and statuses (N, 1) of the C with some text before it.

    ``arrays`` are demands (N, k), and their limits (N, n) where the C takes these.
    """
    count, n, levels, scalar = len(arrays[0]), of.vehicle.n, of.levels, arrays[0].dtype
    F, share = np.zeros((count, n), scalar), np.zeros((count, max(levels, 1)), scalar)
    status = np.zeros((count, 1), np.intc)
    source, name = f"{of.name}.c", f"{of.name}_many"
    files = {**of.files, source: before + of.files[source], f"{name}.c": _many(of, name)}
    library = ctypes.CDLL(str(shared_library("proof", files)))
    filled: list[NDArray[Any]] = [F, *([share] if levels else []), status]
    given = [array.ctypes for array in (*arrays, *filled)]
    library[name](count, fault, *given)
    return F, share[:, :levels], status.astype(np.int8)


def _many(of: Subject, name: str) -> str:
    """C that answers many demands of one fault, one after the other."""
    n, k, levels, real = of.vehicle.n, of.vehicle.k, of.levels, of.scalar
    ends = f"const {real} *f_min, const {real} *f_max, " if of.limits == "call" else ""
    share = f"{real} *share, " if levels else ""
    further = f"tau += {k}, f += {n}" + (f", share += {levels}" if levels else "")
    further += f", f_min += {n}, f_max += {n}" if of.limits == "call" else ""
    return f"""\
#include "{of.name}.h"

void {name}(int count, int fault, const {real} *tau, {ends}{real} *f, {share}int *status)
{{
    for (int i = 0; i < count; i++, {further}) {{
        status[i] = {of.name}({arguments(of.limits, levels, "fault")});
    }}
}}
"""
