"""PX4's allocation: numbers of its public unit tests, a second reading of its text, and its own remainder."""

import math
from dataclasses import replace

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.c import missing
from alloc.closed_forms.balance import balancing_step
from alloc.discovery import find
from alloc.methods.px4 import (
    DOF,
    WEAK,
    Mixing,
    _moved,
    desaturated,
    make_mixing,
    stop_small,
    unallocated,
    unit_outputs,
)
from alloc.program import Builder, evaluate
from alloc.vehicle.autopilot import AIRMODES, make_autopilot, mixer_frame
from alloc.vehicle.frame import turned
from bench.demands.store import pack_vehicle, unpack_vehicle

# roll, pitch, yaw, thrust: four outputs, by MC_AIRMODE: facts of ControlAllocationSequentialDesaturationTest
# at PX4/PX4-Autopilot v1.17.0-beta1, whose quadrotor x has arms, CT and KM of 1 and no scaled moments.
PUBLISHED = {
    0: """
1 0 0 .5: .25 .25 .75 .75 | -1 0 0 .5: .75 .75 .25 .25 | 0 1 0 .5: .75 .25 .25 .75 | 0 0 1 .5: .75 .25 .75 .25
1 0 0 1: .5 .5 1 1 | 0 -1 0 1: .5 1 1 .5 | 0 0 1 1: 1 .7 1 .7 | 0 0 -1 1: .7 1 .7 1 | 0 0 1 0: 0 0 0 0
1 0 0 0: 0 0 0 0 | 0 2 0 3: 1 0 0 1 | 0 0 1 3.2: 1 .7 1 .7 | 0 0 1 .75: 1 .5 1 .5
-.05 0 0 .1: .1125 .1125 .0875 .0875 | -.05 0 0 1: 1 1 .975 .975 | .05 -.05 0 1: .95 .975 1 .975
.05 .05 -.025 0: 0 0 0 0 | .05 .05 -.025 .1: .09375 .08125 .09375 .13125
.05 .05 -.025 1: .9625 .95 .9625 1 | 0 .2 -.025 .1: .14375 .05625 .04375 .15625
0 .2 -.025 1: .9875 .9 .8875 1 | .2 .05 .09 .1: .085 .015 .16 .14 | .2 .05 .09 1: .9225 .8525 .9975 .9775
-.125 .02 .04 .1: .14625 .11625 .07375 .06375 | -.125 .02 .04 1: 1 .97 .9275 .9175
1 0 0 .1: 0 0 .2 .2 | 1 0 0 .45: .2 .2 .7 .7 | 1 0 0 .9: .5 .5 1 1 | 0 -1 0 .1: 0 .2 .2 0
0 0 1 .1: .2 0 .2 0 | 0 0 1 .45: .7 .2 .7 .2 | 0 0 1 .9: 1 .5 1 .5 | 1 1 -1 .1: .2 0 0 .2
1 1 -1 .45: .1 .1 0 1 | 1 1 -1 .9: .2 0 .2 1 | 1 1 -1 1: .2 0 .2 1 | -1 .9 -.9 .1: .2 0 0 .2
-1 .9 -.9 .45: .9 .45 0 .45 | -1 .9 -.9 .9: .95 .6 0 .55 | -1 .9 -.9 1: .95 .6 0 .55
-1 .9 0 .1: .2 0 0 .2 | -1 .9 0 .45: .9 .45 0 .45 | -1 .9 0 .9: 1 .55 .05 .5
""",
    1: """
1 0 0 0: 0 0 .5 .5 | -1 0 0 0: .5 .5 0 0 | 0 1 0 0: .5 0 0 .5 | 0 -1 0 0: 0 .5 .5 0 | 0 0 1 0: 0 0 0 0
0 0 -1 0: 0 0 0 0 | -.05 0 0 0: .025 .025 0 0 | -.05 0 0 .1: .1125 .1125 .0875 .0875
-.05 0 0 1: 1 1 .975 .975 | .05 -.05 0 0: 0 .025 .05 .025 | .05 .05 -.025 0: .01875 .00625 .01875 .05625
.05 .05 -.025 1: .9625 .95 .9625 1 | 0 .2 -.025 0: .1 0 0 .1 | 0 .2 -.025 .1: .14375 .05625 .04375 .15625
.2 .05 .09 0: .025 0 .1 .125 | .2 .05 .09 1: .9225 .8525 .9975 .9775 | -.125 .02 .04 0: .0825 .0525 .01 0
1 0 0 .1: 0 0 .5 .5 | 1 0 0 .45: .2 .2 .7 .7 | 0 0 1 .1: .2 0 .2 0 | 0 0 1 .9: 1 .5 1 .5 | 0 0 1 1: 1 .7 1 .7
1 1 -1 0: .2 0 .2 1 | 1 1 -1 .45: .2 0 .2 1 | -1 .9 -.9 0: .95 .5 0 .45 | -1 .9 -.9 1: .95 .6 0 .55
-1 .9 0 .45: .95 .5 0 .45 | -1 .9 0 .9: 1 .55 .05 .5
""",
    2: """
1 0 0 0: 0 0 .5 .5 | 0 -1 0 0: 0 .5 .5 0 | 0 0 1 0: .5 0 .5 0 | 0 0 -1 0: 0 .5 0 .5
.05 .05 -.025 0: .0125 0 .0125 .05 | .05 .05 -.025 .1: .09375 .08125 .09375 .13125
0 .2 -.025 0: .1 .0125 0 .1125 | .2 .05 .09 0: .07 0 .145 .125 | .2 .05 .09 1: .925 .855 1 .98
-.125 .02 .04 0: .0825 .0525 .01 0 | 0 0 1 .1: .5 0 .5 0 | 0 0 1 .45: .7 .2 .7 .2 | 0 0 1 1: 1 .5 1 .5
1 1 -1 0: 0 0 0 1 | 1 1 -1 1: 0 0 0 1 | -1 .9 -.9 0: .95 .95 0 .9 | -1 .9 -.9 .9: 1 1 .05 .95
-1 .9 0 0: .95 .5 0 .45 | -1 .9 0 1: 1 .55 .05 .5
""",
}
SHIPPED = ("ukwial", "bluerov2", "bluerov2-heavy", "subjugator8", "nautilus", "supply-vessel")


def quadrotor() -> Mixing:
    """The unit tests' quadrotor: positions (1, 1), (-1, 1), (-1, -1), (1, -1), thrust along -z."""
    columns = []
    for x, y, km in ((1, 1, 1), (-1, 1, -1), (-1, -1, 1), (1, -1, -1)):
        columns.append([0, 0, -1, *(np.cross([x, y, 0], [0, 0, -1]) - km * np.array([0, 0, -1]))])
    return make_mixing(np.array(columns, dtype=float).T, normalize=False)


def cases() -> list[tuple[int, list[float], list[float]]]:
    """MC_AIRMODE, setpoints and outputs out of the text."""
    found = []
    for airmode, text in PUBLISHED.items():
        for case in "|".join(text.strip().splitlines()).split("|"):
            asked, _, outputs = case.partition(":")
            found.append((airmode, list(map(float, asked.split())), list(map(float, outputs.split()))))
    return found


@pytest.mark.parametrize(("airmode", "asked", "expected"), cases(), ids=str)
def test_outputs_are_those_of_px4_s_unit_tests(
    airmode: int, asked: list[float], expected: list[float]
) -> None:
    roll, pitch, yaw, thrust = asked
    setpoint = np.array([0, 0, -thrust, roll, pitch, yaw])
    made = desaturated(quadrotor().mix, setpoint, [(0.0, 1.0)] * 4, airmode)
    cut = np.clip(made, 0, 1) if airmode else made  # at 1 1 -1 nothing but the cut keeps them inside
    np.testing.assert_allclose(cut, expected, atol=1e-6)


def gain(u: list[float], column: list[float], low: list[float], high: list[float]) -> float:
    """The step by the text of the firmware, number by number."""
    steps = [0.0]
    for i in range(len(u)):
        if abs(column[i]) < 0.2:
            continue
        if u[i] < low[i]:
            steps.append((low[i] - u[i]) / column[i])
        if u[i] > high[i]:
            steps.append((high[i] - u[i]) / column[i])
    return min(steps) + max(steps)


def second_reading(
    mix: np.ndarray, asked: dict[str, float], low: list[float], high: list[float], airmode: int
) -> list[float]:
    """Outputs by loops over motors and axes named as in the firmware."""
    at = {axis: mix[:, DOF.index(axis)].tolist() for axis in DOF}
    first = [axis for axis in DOF if axis != "yaw" or airmode == 2]
    u = [sum(at[axis][i] * asked[axis] for axis in first) for i in range(len(mix))]

    def give_way(axis: str, top: list[float], reduce_only: bool) -> None:
        first = gain(u, at[axis], low, top)
        if reduce_only and first < 0:
            return
        for i in range(len(u)):
            u[i] += first * at[axis][i]
        half = gain(u, at[axis], low, top) / 2
        for i in range(len(u)):
            u[i] += half * at[axis][i]

    give_way("heave", high, airmode == 0)
    if airmode == 2:
        give_way("yaw", high, False)
        return u
    if airmode == 0:
        give_way("roll", high, False)
        give_way("pitch", high, False)
    for i in range(len(u)):
        u[i] += at["yaw"][i] * asked["yaw"]
    give_way("yaw", [b + 0.15 * (b - a) for a, b in zip(low, high, strict=True)], False)
    give_way("heave", high, True)
    return u


@pytest.mark.parametrize("airmode", AIRMODES)
@pytest.mark.parametrize("n", [4, 6, 8])
def test_outputs_are_those_of_a_second_reading_of_the_firmware(
    n: int, airmode: int, rng: np.random.Generator
) -> None:
    mixing = make_mixing(rng.normal(size=(6, n)))
    low, high = rng.choice([0.0, -1.0], n).tolist(), [1.0] * n
    for asked in rng.normal(size=(2_000, 6)):
        made = desaturated(mixing.mix, asked, list(zip(low, high, strict=True)), airmode)
        second = second_reading(mixing.mix, dict(zip(DOF, asked.tolist(), strict=True)), low, high, airmode)
        np.testing.assert_allclose(made, second, atol=1e-9)


def test_an_output_whose_entry_is_the_threshold_gives_way() -> None:
    """PX4 leaves out what lies below it."""
    u, column, limits = [0.5, 1.1], [1.0, WEAK], [(-1.0, 1.0)] * 2
    step = gain(u, column, [-1.0] * 2, [1.0] * 2)
    assert step == pytest.approx(-0.5)
    assert balancing_step(u, column, limits, WEAK) == step
    assert balancing_step(u, [0.0, 0.0], limits, 0.0) == 0.0
    builder = Builder(load_vehicle("ukwial"))
    made = builder.program(
        _moved(builder, [builder.tau[0], builder.tau[1]], column, limits, only_up=False), 0
    )
    moved = [x + step * c for x, c in zip(u, column, strict=True)]
    np.testing.assert_allclose(evaluate(made, np.array([[*u, 0.0]])).F[0], moved)


def test_an_axis_with_next_to_no_effect_is_given_up_and_noise_of_others_left() -> None:
    """PX4 clears a row whose entries all lie within 0.05: its pseudoinverse then asks nothing of it."""
    rows = np.vstack([np.eye(5, 7) + 0.3, np.full(7, 0.04)])
    assert (make_mixing(rows).mix[:, 5] == 0).all()
    without = np.vstack([rows[:5], np.zeros(7)])
    np.testing.assert_array_equal(make_mixing(rows).mix, make_mixing(without).mix)


def test_a_failure_leaves_the_scales_and_not_the_pseudoinverse() -> None:
    vehicle = with_key("bluerov2-heavy", "automatic")
    assert vehicle.poses is not None
    ready = np.arange(8) != 4
    whole, left = (make_mixing(60 * vehicle.poses, each) for each in (None, ready))
    np.testing.assert_array_equal(whole.scales, left.scales)
    np.testing.assert_allclose(left.mix * left.scales, np.linalg.pinv(60 * vehicle.poses * ready), atol=2e-3)
    asked = np.array([0, 0, 40.0, 0, 0, 0])
    u = stop_small(desaturated(left.mix, asked * left.scales, [(-1.0, 1.0)] * 8), [(-1.0, 1.0)] * 8)
    f = build("px4", vehicle.with_fault(4))(asked).f
    np.testing.assert_allclose(f, u * np.where(u > 0, 60, 40), atol=1e-9)


def test_scales_are_those_of_px4_s_rule() -> None:
    """Roll and pitch share the larger, yaw has its largest entry, forces the mean size of theirs."""
    heavy = load_vehicle("bluerov2-heavy")
    assert heavy.poses is not None
    scaled, plain = make_mixing(40.0 * heavy.poses), np.linalg.pinv(40.0 * heavy.poses)
    roll, pitch = (math.sqrt(sum(x * x for x in plain[:, axis]) / (4 / 2)) for axis in (3, 4))
    assert scaled.scales[3:] == pytest.approx([max(roll, pitch), max(roll, pitch), plain[:, 5].max()])
    for axis in range(3):
        sizes = [abs(x) for x in plain[:, axis] if abs(x) > 2**-23]
        assert scaled.scales[axis] == pytest.approx(sum(sizes) / len(sizes))
    np.testing.assert_allclose(scaled.mix[:, 0], plain[:, 0] / scaled.scales[0], atol=1e-3)


def test_a_scale_too_small_to_divide_by_is_one() -> None:
    """No motor along surge: PX4 divides no force by it, and yaw of one sign has no scale."""
    column = np.array([[0.0, 0.0, -1e9, 0.0, 0.0, -1e9]]).T
    assert make_mixing(column).scales.tolist()[:3] == [1.0, 1.0, 1.0]
    assert make_mixing(column).scales[5] == 1.0


@pytest.mark.parametrize("name", SHIPPED)
def test_within_limits_it_makes_the_wrench_where_thrust_is_alike_on_both_sides(
    name: str, rng: np.random.Generator
) -> None:
    whole = load_vehicle(name)
    most = np.minimum(-whole.f_min, whole.f_max)
    T = whole.T if whole.poses is None else whole.poses[[DOF.index(axis) for axis in whole.dof]]
    vehicle = replace(whole, T=T, f_min=-most, f_max=most, by_volts=None, esc=(), cap=None, slew=None)
    F = 0.3 * rng.uniform(-most, most, (50, vehicle.n))
    made, _ = build("px4", vehicle).many(F @ vehicle.T.T)
    missed = np.abs(made @ vehicle.T.T - F @ vehicle.T.T) / vehicle.wrench_scale
    # What it drops: outputs below 2 %, entries below 1e-3.
    assert missed.max() < vehicle.n * 0.021
    loud = (np.abs(made) > 0).all(axis=1)
    assert missed[loud].max(initial=0.0) < 0.01


def test_a_small_output_is_stopped() -> None:
    limits = [(-1.0, 1.0)] * 3
    assert stop_small(np.array([0.019, -0.021, 7.0]), limits).tolist() == [0.0, -0.021, 1.0]


def test_what_px4_reports_as_unallocated_is_what_linear_thrusts_leave(rng: np.random.Generator) -> None:
    mixing = make_mixing(rng.normal(size=(6, 8)))
    asked = rng.normal(size=6)
    u = stop_small(desaturated(mixing.mix, asked, [(-1.0, 1.0)] * 8), [(-1.0, 1.0)] * 8)
    left = unallocated(mixing, asked, u) / mixing.scales
    np.testing.assert_allclose(left, asked / mixing.scales - mixing.effectiveness @ u, atol=1e-12)


def test_the_same_vehicle_in_the_other_frame_gets_the_same_thrusts(rng: np.random.Generator) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    taus = rng.normal(size=(50, 6)) * vehicle.wrench_scale
    other = taus * np.array([1, -1, -1, 1, -1, -1])
    F, G = build("px4", vehicle).many(taus)[0], build("px4", vehicle.with_frame("flu")).many(other)[0]
    np.testing.assert_allclose(F, G, atol=1e-9)


def test_a_push_down_costs_roll_that_a_push_up_would_not() -> None:
    """Heave gives way towards +z only: less thrust of a multirotor, more of this vehicle's dive."""
    vehicle = load_vehicle("bluerov2-heavy")
    even = replace(vehicle, f_min=-vehicle.f_max, by_volts=None, esc=(), cap=None)
    made = {}
    for heave in (-200.0, 200.0):
        made[heave] = even.T @ build("px4", even)(np.array([0, 0, heave, 25.0, 0, 0])).f
    roll = even.dof.index("roll")
    assert made[-200.0][roll] == pytest.approx(25.0, rel=0.01)
    assert made[200.0][roll] < 0.9 * made[-200.0][roll]


def test_a_thruster_that_is_off_is_out_of_the_effectiveness() -> None:
    heavy = load_vehicle("bluerov2-heavy").with_fault(4)
    answer = build("px4", heavy)(np.array([0, 0, 40.0, 0, 0, 0]))
    assert answer.f[4] == 0.0
    assert (heavy.T @ answer.f)[2] == pytest.approx(40.0, rel=0.01)
    assert answer.status in (Status.SOLVED, Status.PARTIAL)


def test_a_thruster_without_thrust_ahead_has_no_coefficient() -> None:
    vehicle = load_vehicle("ukwial")
    with pytest.raises(NotApplicable, match="has no CT"):
        build("px4", replace(vehicle, f_max=np.array([0.0, 1, 1, 1]), slew=None))


def with_key(name: str, method: str, airmode: int = 0) -> Vehicle:
    vehicle = load_vehicle(name)
    frame, limits = mixer_frame("", method), (vehicle.f_min, vehicle.f_max)
    return replace(vehicle, autopilot=make_autopilot(frame, limits, airmode=airmode))


def test_with_airmode_a_push_up_keeps_the_roll_that_a_push_down_costs_without() -> None:
    """MC_AIRMODE 1 moves heave both ways, so a dive keeps its roll and loses depth."""
    tau, made = np.array([0, 0, 200.0, 25.0, 0, 0]), {}
    for airmode in AIRMODES:
        vehicle = with_key("bluerov2-heavy", "automatic", airmode)
        assert vehicle.autopilot is not None
        there = unpack_vehicle(pack_vehicle(vehicle))
        assert there.autopilot is not None
        assert there.autopilot.airmode == airmode
        made[airmode] = vehicle.T @ build("px4", there)(tau).f
    assert made[1][3] > 1.3 * made[0][3]
    assert made[1][2] < made[0][2]


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize(
    ("method", "airmode"), [*(("automatic", mode) for mode in AIRMODES), ("pseudoinverse", 0)]
)
def test_its_c_answers_as_python_does(method: str, airmode: int, rng: np.random.Generator) -> None:
    whole = with_key("bluerov2", method, airmode)  # in flu, without pitch
    ends = np.sort(rng.uniform(-40, 40, (2, 500, whole.n)), axis=0)
    for vehicle in (whole, whole.with_fault(1)):
        taus = rng.normal(size=(500, 5)) * vehicle.wrench_scale * rng.choice([0.02, 0.3, 1.0], (500, 1))
        for limits in ((), tuple(ends)):
            (F, status), (G, other) = (
                build(name, vehicle).many(taus, *limits) for name in ("px4", "px4@native")
            )
            np.testing.assert_allclose(F, G, rtol=0, atol=1e-11)
            np.testing.assert_array_equal(status, other)


def test_runs_leave_it_and_its_c_out_unless_they_are_named() -> None:
    assert all(find(name).named_only for name in ("px4", "px4@native"))
    assert not find("clip@native").named_only


def test_ca_method_0_cuts_the_pseudoinverse_s_outputs_and_nothing_gives_way() -> None:
    vehicle = with_key("bluerov2-heavy", "pseudoinverse")
    assert vehicle.poses is not None
    tau = np.array([60.0, 40, 150, 12, 9, 20])
    mixing = make_mixing(vehicle.poses * vehicle.f_max)
    u = np.clip(mixing.mix @ (tau * mixing.scales), -1, 1)
    f = build("px4", vehicle)(tau).f
    np.testing.assert_allclose(f, np.where(abs(u) < 0.02, 0, u) * np.where(u > 0, 60, 40), atol=1e-9)
    assert (abs(u) == 1).any()
    assert abs(f - build("px4", with_key("bluerov2-heavy", "automatic"))(tau).f).max() > 1


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2-heavy"])
def test_outputs_of_unit_setpoints_are_those_of_the_wrench_that_such_a_setpoint_stands_for(name: str) -> None:
    vehicle = with_key(name, "automatic")
    outputs, allocate = unit_outputs(vehicle), build("px4", vehicle)
    assert vehicle.poses is not None
    rows = vehicle.poses if vehicle.frame == "frd" else turned(vehicle.poses, DOF)
    scales = make_mixing(rows * vehicle.f_max).scales
    for axis in vehicle.dof:
        j = DOF.index(axis)
        tau = np.zeros(6)
        tau[j] = (-1 if axis == "heave" else 1) / scales[j]
        asked = tau if vehicle.frame == "frd" else turned(tau, DOF)
        f = allocate(asked[[DOF.index(each) for each in vehicle.dof]]).f
        expected = f / np.where(f > 0, vehicle.f_max, -vehicle.f_min)
        np.testing.assert_allclose(outputs[:, j], expected, atol=1e-9)
