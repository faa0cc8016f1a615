"""One program for many faults: with the numbers of one fault it answers as the vehicle with that fault."""

from dataclasses import replace

import numpy as np
import pytest

from alloc import Status, Vehicle, build, load_vehicle
from alloc.c import Target
from alloc.methods import recipe, recipes
from alloc.program import Builder, Program, Where, at_fault, evaluate, least, most, size, states
from bench.demands.generated import generate_vehicle
from tests.vehicles import made_up

UKWIAL = load_vehicle("ukwial")
LOOPS = ("redistribute", "soft")
"""Methods whose loop over data their C alone calculates: tests/alloc/c/test_generated.py."""
TOGETHER = [name for name, each in recipes().items() if each.make_for_all and name not in LOOPS]


def test_what_is_known_of_each_fault_is_calculated_beforehand() -> None:
    builder = Builder(UKWIAL)
    graph = builder.graph
    a, b = graph.by_fault([1.0, -2.0]), graph.by_fault([3.0, 4.0])
    before = len(graph.nodes)
    assert graph.fixed_values((2.0 * a + b).node) == (5.0, 0.0)
    assert graph.fixed_values(least(size(a), b).node) == (1.0, 2.0)
    assert graph.fixed_values(most(-a, 0.0).node) == (0.0, 2.0)
    assert graph.by_fault([7.0, 7.0]) == graph.constant(7.0)
    assert not [each for each in graph.nodes[before:] if each[0] not in ("const", "by_fault")]
    assert not graph.fixed_values((a * builder.tau[0]).node)


def test_what_is_asked_here_are_vehicles_that_lose_a_direction_by_no_by_one_and_by_many_thrusters() -> None:
    lost = {
        name: [state.rank < vehicle.rank for fault, state in states(vehicle).items() if fault >= 0]
        for name, vehicle in ((each, load_vehicle(each)) for each in ("ukwial", "bluerov2", "tiburon"))
    }
    assert not any(lost["ukwial"])
    assert sum(lost["tiburon"]) == 1
    assert sum(lost["bluerov2"]) > 1


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("method", TOGETHER)
@pytest.mark.parametrize("name", ["ukwial", "bluerov2", "tiburon", "supply-vessel"])
def test_each_fault_is_answered_as_by_the_vehicle_with_that_fault(
    name: str, method: str, limits: Where
) -> None:
    vehicle = load_vehicle(name)
    program = recipe(method).program_for_all(vehicle, limits, "double")
    assert program.faults[0] == -1
    for fault in program.faults:
        _agrees(vehicle, method, limits, fault, program)


def test_limits_that_exclude_zero_begin_a_way_elsewhere_for_each_fault() -> None:
    pushing = replace(UKWIAL, name="pushing", f_min=np.array([20.0, -250.0, -250.0, -250.0]))
    program = recipe("scaled").program_for_all(pushing, "fixed", "double")
    for fault in program.faults:
        _agrees(pushing, "scaled", "fixed", fault, program)


@pytest.mark.parametrize("method", ["pinv", "clip", "shrink"])
def test_what_takes_over_from_a_thruster_is_of_rank_one_where_h_is_full_and_where_a_limit_excludes_zero(
    method: str,
) -> None:
    H = UKWIAL.H + 0.3
    pushing = replace(UKWIAL, name="pushing", H=H, f_min=np.array([20.0, -250.0, -250.0, -250.0]))
    program = recipe(method).program_for_all(pushing, "fixed", "double")
    assert len(program.faults) == UKWIAL.n + 1
    for fault in program.faults:
        _agrees(pushing, method, "fixed", fault, program)


@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_how_far_a_limit_is_from_zero_at_least_hangs_on_the_thrusters_that_are_left(limits: Where) -> None:
    """The strongest fails, and one that can't reverse is asked to: four times as much was left of tau."""
    uneven = replace(
        UKWIAL,
        name="uneven",
        f_min=np.array([-250.0, 0.0, -60.0, -60.0]),
        f_max=np.array([250.0, 60.0, 60.0, 60.0]),
    )
    program = recipe("shrink").program_for_all(uneven, limits, "double")
    assert 0 in program.faults
    for fault in program.faults:
        _agrees(uneven, "shrink", limits, fault, program)


@pytest.mark.parametrize(
    ("method", "fault", "T", "f_min", "f_max", "levels"),
    [
        pytest.param(  # facets without a margin are passed by the last bits of a sum
            "priority",
            0,
            [
                [-1, 1, -1, -1, -1, -1],
                [0, 1, 1, 1, 0, -1],
                [-1, 1, 0, 0, -1, 0],
                [-1, 1, 0, -1, 0, 1],
                [-1, 1, 0, -1, 0, 1],
            ],
            [-25, 0, 0, -50, 0, -25],
            [50, 50, 30, 50, 100, 50],
            [["surge", "roll"], ["heave"], ["pitch"], ["sway"]],
            id="no margin",
        ),
        pytest.param(  # what is left of a sum that cancels is no step
            "scaled",
            2,
            [[1, 2, -2], [-1, 0, 0], [2, 1, 1]],
            [0, -30, -25],
            [30, 30, 50],
            [],
            id="nothing lost",
        ),
    ],
)
def test_thrusters_that_do_not_reverse_take_nothing_of_a_demand_by_rounding(
    method: str,
    fault: int,
    T: list[list[float]],
    f_min: list[float],
    f_max: list[float],
    levels: list[list[str]],
) -> None:
    """The first C's shares differed from f by a sixth, the second's were zero where all can be had."""
    vehicle = made_up(T, f_min, f_max, priority=tuple(map(tuple, levels)))
    state, rng = vehicle.with_fault(fault), np.random.default_rng(0)
    corners = np.where(rng.random((400, vehicle.n)) < 0.5, state.f_min, state.f_max)
    taus = corners @ state.TP.T * rng.choice([0.3, 0.999, 1.3, 2.5], (400, 1))
    taus[rng.random(taus.shape) < 0.1] = 0.0
    program = at_fault(recipe(method).program_for_all(vehicle, "fixed", "double"), fault)
    expected = [build(method, state)(tau).share for tau in taus]
    np.testing.assert_allclose(evaluate(program, taus).share, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", [*TOGETHER, *LOOPS])
def test_a_vehicle_with_one_thruster_has_no_fault_to_answer_together(method: str) -> None:
    alone = made_up([[1.0]])
    assert recipe(method).program_for_all(alone, "fixed", "double").faults in ((), (-1,))


def _agrees(vehicle: Vehicle, method: str, limits: Where, fault: int, program: Program) -> None:
    """Verdicts are the twin's, thrusts its within rounding, and a thruster that is off gets none."""
    state = vehicle if fault < 0 else vehicle.with_fault(fault)
    rng = np.random.default_rng(33)
    f = rng.uniform(vehicle.f_min, vehicle.f_max, (45, vehicle.n)) * np.repeat([0.3, 1.0, 3.0], 15)[:, None]
    f[::2, fault] = 0.0  # the others ask for a direction that may be lost
    taus = f @ vehicle.TP.T
    low, high = (np.tile(side, (len(taus), 1)) for side in (vehicle.f_min, vehicle.f_max))
    if fault >= 0:
        low[:, fault] = high[:, fault] = np.nan  # nobody looks there
    given = (low, high) if limits == "call" else ()
    F, status, _ = evaluate(at_fault(program, fault), taus, *given)
    expected, verdict = build(method, state).many(taus)
    np.testing.assert_array_equal(status, verdict)
    answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
    # Two ways to the same optimum: some hundred roundings, magnified by the condition of the worst vehicle.
    np.testing.assert_allclose(F[answered], expected[answered], atol=1e-9 * vehicle.f_scale)
    if fault >= 0:
        assert not F[answered, fault].any()


def test_a_thruster_that_takes_others_far_with_it_has_code_of_its_own() -> None:
    """Thrusts of odd vehicle 35 lost three more digits where one of them was moved to zero."""
    vehicle, _ = generate_vehicle(35)
    together = recipe("nullspace").program_for_all(vehicle, "fixed", "double").faults
    made = Target(vehicle=vehicle, method=recipe("nullspace"), faults="all").programs
    assert -1 in together
    assert {fault for fault, program in made.items() if program.faults} == {*together}
    assert made.keys() - {*together}
