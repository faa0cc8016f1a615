"""Every kind of wrong answer is found, and right answers are not called wrong."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from alloc import Allocation, Label, Status, build, load_vehicle
from alloc.allocation import FloatArray
from bench.demands import build_demands, labelled, longest
from bench.demands.generated import growth_vehicle
from bench.demands.store import Case
from bench.judging.faults import find_shared_memory
from bench.judging.judge import after_failure, judge
from bench.judging.question import Answers, Question, Unanswered, ask_here, questions
from bench.record import Judged
from saturation import limits

PROMISES = {"formulation": "hard", "limited": True, "tolerance": 1e-9}


@pytest.fixture(scope="module")
def asked() -> dict[str, Question]:
    sets = ("inactive", "active", "infeasible")
    vehicle = load_vehicle("ukwial")
    made = questions([build_demands(name, vehicle, seed=1, n=5) for name in sets], ask_here)
    return {question.demands.name: question for question in made}


def exact(question: Question) -> list[Allocation]:
    allocate = build("nullspace", question.demands.vehicle)
    return [allocate(tau) for tau in question.demands.taus]


def verdict(question: Question, answers: list[Allocation], **promises: object) -> Judged:
    return judge(question, answers, **{**PROMISES, **promises})  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["inactive", "active"])
def test_exact_answers_are_right_over_several_passes(asked: dict[str, Question], name: str) -> None:
    judged = verdict(asked[name], exact(asked[name]) + exact(asked[name]))
    assert judged.wrong == ""
    assert judged.agrees is True
    assert judged.counts == {"SOLVED": 10}
    assert judged.answers == 10
    assert judged.gap_rel_max is not None
    assert judged.gap_rel_max < 1e-12  # rounding


def test_infeasible_is_a_right_answer_to_an_infeasible_demand(asked: dict[str, Question]) -> None:
    judged = verdict(asked["infeasible"], exact(asked["infeasible"]))
    assert judged.wrong == ""
    assert judged.agrees is None
    assert judged.counts == {"INFEASIBLE": 5}


def replaced(question: Question, f: FloatArray, status: int) -> list[Allocation]:
    return [Allocation(f, status), *exact(question)[1:]]  # type: ignore[arg-type] - status may be no Status


def test_each_kind_of_wrong_answer_is_named_with_its_demand(asked: dict[str, Question]) -> None:
    active, vehicle = asked["active"], asked["active"].demands.vehicle
    right = exact(active)[0].f
    nothing = np.full(vehicle.n, np.nan)
    over = np.where(right == right.max(), np.nextafter(vehicle.f_max, np.inf), right)
    cases = {
        "although it says SOLVED": (nothing, Status.SOLVED),
        "although it says that there is none": (right.copy(), Status.INFEASIBLE),
        "the wrench is not met": (right * 0.999, Status.SOLVED),
        "PARTIAL, but its thrusts make all of the wrench": (right.copy(), Status.PARTIAL),
        "a limit is violated": (over, Status.PARTIAL),  # by one unit in the last place
        "says INFEASIBLE, but": (nothing, Status.INFEASIBLE),
        "not an array of n thrusts": (right[:-1], Status.SOLVED),
        "a status that is none": (right.copy(), 7),
    }
    for words, (f, status) in cases.items():
        wrong = verdict(active, replaced(active, f, status)).wrong
        assert words in wrong
        assert "first for demand 0" in wrong
        assert ("demand 0, by 2.8e-14 N at most)" in wrong) == (f is over)


@pytest.mark.parametrize(
    ("missed", "share", "promises"),
    [
        (1e-10, (), {}),  # a rule may draw its line there, and a solver's C at 1e-6
        (0.0, (1.0 - 1e-15,), {"formulation": "scaled"}),
        (0.0, (), {"formulation": "soft"}),
    ],
)
def test_who_says_partial_of_what_is_nearly_met_may_be_right(
    missed: float, share: tuple[float, ...], promises: dict[str, str], asked: dict[str, Question]
) -> None:
    active = asked["active"]
    answers = [
        answer._replace(f=answer.f * (1.0 - missed), status=Status.PARTIAL, share=share)
        for answer in exact(active)
    ]
    told = "PARTIAL, but its thrusts make all of the wrench"
    assert told not in verdict(active, answers, **promises).wrong
    fully = [answer._replace(status=Status.PARTIAL, share=(1.0,) * len(share)) for answer in exact(active)]
    assert (told in verdict(active, fully, **promises).wrong) == (promises.get("formulation") != "soft")


def test_a_mask_hides_no_thrust_from_the_judge(asked: dict[str, Question]) -> None:
    active = asked["active"]
    masked = np.ma.masked_array(0.9 * exact(active)[0].f, mask=True)
    wrong = verdict(active, replaced(active, masked, Status.SOLVED)).wrong
    assert "the wrench is not met (1 of 5 answers, first for demand 0)" in wrong


@pytest.mark.parametrize(
    "kind", [list, lambda f: f + 1j, lambda f: f.astype(str), lambda f: f.astype(object)]
)
def test_thrusts_that_are_no_array_of_real_numbers_are_wrong(
    asked: dict[str, Question], kind: Callable[[FloatArray], Any]
) -> None:
    active = asked["active"]
    wrong = verdict(active, replaced(active, kind(exact(active)[0].f), Status.SOLVED)).wrong
    assert "not an array of n thrusts (1 of 5 answers, first for demand 0)" in wrong


def test_solved_is_a_wrong_answer_to_an_infeasible_demand(asked: dict[str, Question]) -> None:
    question = asked["infeasible"]
    assert (question.demands.labels == Label.INFEASIBLE).all()
    f = np.clip(
        question.right["unlimited"][0], question.demands.vehicle.f_min, question.demands.vehicle.f_max
    )
    assert "no thrust inside the limits" in verdict(question, replaced(question, f, Status.SOLVED)).wrong


def test_not_converged_is_counted_and_is_no_wrong_answer(asked: dict[str, Question]) -> None:
    nothing = np.full(asked["active"].demands.vehicle.n, np.nan)
    judged = verdict(asked["active"], replaced(asked["active"], nothing, Status.NOT_CONVERGED))
    assert judged.wrong == ""
    assert judged.agrees is True  # the four that are answered agree
    assert judged.counts == {"NOT_CONVERGED": 1, "SOLVED": 4}


def test_an_answer_off_by_more_than_is_promised_disagrees(asked: dict[str, Question]) -> None:
    inactive, vehicle = asked["inactive"], asked["inactive"].demands.vehicle
    f = exact(inactive)[0].f
    off = f + 1e-6 * vehicle.f_scale * np.linalg.svd(vehicle.T)[2][-1]  # the wrench stays met
    answers = replaced(inactive, off, Status.SOLVED)
    assert verdict(inactive, answers).agrees is False
    assert verdict(inactive, answers).wrong == ""
    assert verdict(inactive, answers, tolerance=1e-5).agrees is True
    assert verdict(inactive, answers, tolerance=1.0).agrees is None  # as far as a limit: that is no promise


def test_closed_forms_and_qps_are_held_against_the_same_numbers_on_inactive_demands(
    asked: dict[str, Question],
) -> None:
    right = asked["inactive"].right
    np.testing.assert_array_equal(right["hard"], right["unlimited"])
    second = np.array([answer.f for answer in exact(asked["inactive"])])  # by another method
    np.testing.assert_allclose(second, right["hard"], atol=1e-9)


def test_a_rule_of_practice_has_right_answers_to_inactive_demands_only(asked: dict[str, Question]) -> None:
    for name, compared in (("inactive", True), ("active", None)):
        clip = build("clip", asked[name].demands.vehicle)
        answers = [clip(tau) for tau in asked[name].demands.taus]
        assert verdict(asked[name], answers, formulation="clip").agrees is compared


def test_answers_that_overlap_in_memory_are_found_and_neighbours_are_not() -> None:
    block = np.zeros(12)
    assert list(find_shared_memory([block[:4], block[4:8], block[8:]])) == [False, False, False]
    assert list(find_shared_memory([block[:4], block[2:6], np.zeros(4)])) == [False, True, False]
    assert find_shared_memory([block[:4], np.zeros(4), block[:4]]).sum() == 1
    ring = np.zeros((300, 4))
    assert find_shared_memory([ring[i % 300] for i in range(700)]).sum() == 400


def test_giving_up_on_a_demand_below_what_must_be_pushed_is_no_failure(tmp_path: Path) -> None:
    file = tmp_path / "eager.yaml"
    file.write_text(
        "name: eager\nsource: made up\ndof: [surge]\nT: [[1, 1]]\nf_min: 1\nf_max: 2\n", encoding="utf-8"
    )
    log = tmp_path / "log.csv"
    log.write_text("surge\n1\n1\n1.5\n", encoding="utf-8")  # it pushes 2 to 4 N
    (question,) = questions([build_demands(log, load_vehicle(file), seed=1, n=3)], ask_here)
    assert (question.demands.alpha > 1).all()
    nothing = [Allocation(np.full(2, np.nan), Status.INFEASIBLE) for _ in range(3)]
    judged = verdict(question, nothing)
    assert judged.wrong == ""
    assert judged.failed_after_failure is None


@pytest.mark.parametrize("fault", [0, 1])
def test_scaled_is_judged_by_what_the_remaining_thrusters_can_push(fault: int) -> None:
    # Two of four thrusters are off: part of each demand can't be pushed, and the optimum is that of the rest.
    degraded = load_vehicle("ukwial").with_fault(fault)
    (question,) = questions([build_demands("mission-fault", degraded, seed=0, n=30)], ask_here)
    assert question.demands.vehicle.rank < question.demands.vehicle.k
    allocate = build("scaled", question.demands.vehicle)
    judged = verdict(question, [allocate(tau) for tau in question.demands.taus], formulation="scaled")
    assert judged.agrees
    assert judged.wrong == ""
    assert np.abs(question.right["scaled"]).max() > 1.0


@pytest.mark.parametrize("method", ["scaled", "scaled-by-group", "priority"])
def test_an_answer_within_the_limits_of_each_call_is_judged_by_them(
    method: str, rng: np.random.Generator
) -> None:
    """Right answers come from nullspace, at the wrench that the way towards the demand reaches."""
    vehicle = load_vehicle("bluerov2-heavy")
    low, high = limits(vehicle, rng, 20)
    low[0] = high[0] + 1.0  # nothing is right where limits contradict themselves
    demands = labelled(
        "made", vehicle, 2 * rng.normal(size=(20, 6)) * vehicle.wrench_scale, f_min=low, f_max=high
    )
    (question,) = questions([demands], ask_here)
    assert np.isnan(question.right[method][0]).all()
    allocate = build(method, vehicle)
    answers = [allocate(tau, *ends) for tau, *ends in zip(demands.taus, low, high, strict=True)]
    judged = verdict(question, answers, formulation=method)
    assert judged.wrong == ""
    assert judged.agrees
    assert np.isfinite(question.right[method][1:]).all()
    said = np.array([answer.share for answer in answers if answer.share])
    assert judged.share_min == pytest.approx(said.min(axis=0), rel=1e-5)  # records keep six digits
    assert judged.share_p50 == pytest.approx(np.median(said, axis=0), rel=1e-5)
    for share in ((0.5,) * len(answers[1].share), (2.0,) * len(answers[1].share), (1.0,) * 9, (np.nan,)):
        answers[1] = answers[1]._replace(share=share)
        judged = verdict(question, answers, formulation=method)
        assert judged.wrong.startswith(
            "shares of its levels that its thrusts do not deliver (1 of 20 answers"
        )


def test_where_a_vehicle_has_too_many_facets_nothing_is_known_of_its_right_answers() -> None:
    vehicle = growth_vehicle(6, 32)
    tau = np.ones((2, 6))
    (question,) = questions(
        [labelled("made", vehicle, tau)], lambda method, cases: [Unanswered("refused", "")] * len(cases)
    )
    for name in ("hard", "scaled", "scaled-by-group", "priority"):
        assert question.right[name].shape == (2, 32)
        assert np.isnan(question.right[name]).all()


def test_a_failure_after_a_failure_is_counted_among_demands_that_can_be_met() -> None:
    gave_up = np.array([True, True, False, True, True, True])
    attainable = np.array([False, True, True, True, False, True])
    # Demands 1, 2 and 5 are attainable and follow a failure; of these only demand 2 got thrusts.
    assert after_failure(gave_up, attainable) == pytest.approx(2 / 3)
    assert after_failure(~gave_up[:2], attainable[:2]) is None


def test_what_a_mixed_log_misses_is_counted_on_the_demands_that_can_be_met() -> None:
    """A tenth less thrust on one attainable demand misses a tenth of it; infeasible ones don't count."""
    vehicle = load_vehicle("ukwial")
    sets = [build_demands(name, vehicle, seed=1, n=4).taus for name in ("inactive", "active", "infeasible")]
    (question,) = questions([labelled("dive", vehicle, np.concatenate(sets))], ask_here)
    right = exact(question)
    assert verdict(question, right).missed_max == pytest.approx(0.0, abs=1e-9)
    weak = [right[0]._replace(f=0.9 * right[0].f, status=Status.PARTIAL), *right[1:]]
    assert verdict(question, weak).missed_max == pytest.approx(0.1)
    assert verdict(question, weak).missed_p50 == pytest.approx(0.0, abs=1e-9)
    limp = [answer._replace(f=0.02 * answer.f, status=Status.PARTIAL) for answer in right]
    assert verdict(question, limp).missed_p50 == pytest.approx(0.98)
    silent = [right[0], Allocation(np.full(vehicle.n, np.nan), Status.NOT_CONVERGED), *right[2:]]
    assert verdict(question, silent).missed_max == 1.0
    (beyond,) = questions([build_demands("infeasible", vehicle, seed=1, n=4)], ask_here)
    assert verdict(beyond, exact(beyond)).missed_max is None


def test_demands_of_which_a_method_makes_nothing_are_counted_with_their_longest_run() -> None:
    """The main can't reverse: ``scaled`` gives up on all axes of a demand a little astern, groups do not."""
    ukwial = load_vehicle("ukwial")
    ahead = replace(ukwial, f_min=np.zeros(ukwial.n), T=np.eye(3, ukwial.n), name="ahead")
    taus = 50 * np.array([[2.0, 1.0, 0.5], [-0.1, 1.0, 0.5], [-0.1, 1.0, 0.5], [2.0, 1.0, 0.5]])
    (question,) = questions([labelled("dive", ahead, taus)], ask_here)
    seen = [
        judge(question, list(map(built, taus)), formulation=name, limited=True, tolerance=1e-6)
        for name in ("scaled", "clip")
        for built in [build(name, ahead)]
    ]
    assert [(each.nothing_share, each.refused_longest) for each in seen] == [(0.5, 2), (0.0, 0)]


def test_what_is_missed_of_a_demand_just_inside_of_what_can_be_met_counts_too() -> None:
    vehicle = load_vehicle("ukwial")
    edge = build_demands("active", vehicle, seed=1, n=8)
    taus = edge.taus * (edge.alpha / 1.0002)[:, None]  # alpha 1.0002: the label says boundary
    (question,) = questions([labelled("edge", vehicle, taus)], ask_here)
    assert (question.demands.labels == Label.BOUNDARY).all()
    right = exact(question)
    weak = [right[0]._replace(f=0.9 * right[0].f, status=Status.PARTIAL), *right[1:]]
    assert verdict(question, weak).missed_max == pytest.approx(0.1)


def test_demands_for_next_to_nothing_do_not_hide_that_most_of_the_others_is_missed() -> None:
    vehicle = load_vehicle("ukwial")
    taus = np.vstack([np.zeros((60, 3)), build_demands("inactive", vehicle, seed=1, n=40).taus])
    (question,) = questions([labelled("dive", vehicle, taus)], ask_here)
    limp = [answer._replace(f=0.5 * answer.f, status=Status.PARTIAL) for answer in exact(question)]
    assert verdict(question, limp).missed_p50 == pytest.approx(0.5)


@pytest.mark.parametrize("limited", [True, False])
def test_a_thrust_on_a_thruster_that_is_off_is_wrong_whatever_is_promised(limited: bool) -> None:
    vehicle = load_vehicle("ukwial").with_fault(2)
    (question,) = questions([build_demands("inactive", vehicle, seed=1, n=4)], ask_here)
    right = exact(question)
    assert verdict(question, right, limited=limited).wrong == ""
    moved = [right[0]._replace(f=right[0].f + 1e-3 * np.eye(4)[2]), *right[1:]]
    assert "a thrust on a thruster that is off (1 of 4" in verdict(question, moved, limited=limited).wrong


@pytest.mark.parametrize("share", [(7.0,), (-0.1,), (float("nan"),)])
def test_shares_lie_between_nothing_and_all_also_of_a_formulation_of_one_s_own(
    asked: dict[str, Question], share: tuple[float, ...]
) -> None:
    right = exact(asked["inactive"])
    wrong = [right[0]._replace(share=share), *right[1:]]
    assert "shares of its levels" in verdict(asked["inactive"], wrong, formulation="mine").wrong
    half = [right[0]._replace(share=(0.5, 1.0)), *right[1:]]
    assert verdict(asked["inactive"], half, formulation="mine").wrong == ""


def test_references_are_asked_only_for_what_somebody_answers_and_for_the_hard_optimum(tmp_path: Path) -> None:
    vehicle, names = load_vehicle("ukwial"), list[str]()

    def ask(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
        names.append(method)
        return ask_here(method, cases)

    demands = [build_demands("active", vehicle, seed=1, n=5)]
    (few,) = questions(demands, ask, {"soft"})
    assert set(few.right) == set(few.reference) | {"unlimited"} == {"unlimited", "hard", "soft"}
    assert len(names) == 2
    (every,) = questions(demands, ask_here)
    few.save(tmp_path / "few.npz")
    for name, F in Question.load(tmp_path / "few.npz")[0].right.items():
        np.testing.assert_array_equal(F, every.right[name])


@pytest.mark.parametrize(
    ("marked", "run"), [([], 0), ([0, 0], 0), ([1], 1), ([1, 1, 0, 1], 2), ([0, 1, 0, 1, 1, 1], 3)]
)
def test_the_longest_run_is_counted_also_at_the_ends(marked: list[int], run: int) -> None:
    assert longest(np.array(marked, dtype=bool)) == run
