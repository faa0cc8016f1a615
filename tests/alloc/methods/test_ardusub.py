"""ArduSub's mixer, against a second reading of the firmware's text: a loop over motors, number by number."""

import re
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.errors import VehicleError
from alloc.kernels import rules
from alloc.methods import ardusub, clip
from alloc.methods.ardusub import find_inputs, inputs, outputs, program, thrust
from alloc.program import Builder, Scalar, evaluate, reachable, select
from alloc.program.graph import FOLDED
from alloc.vehicle.autopilot import FRAMES, Autopilot, make_autopilot
from alloc.vehicle.geometry import DOF
from bench.demands.store import pack_vehicle, unpack_vehicle
from tests.vehicles import made_up

N_INPUTS = 10_000
FOLDER = Path(ardusub.__file__).parents[1] / "vehicles"
T200 = FOLDER / "t200.csv"
SHIPPED = ("bluerov2", "bluerov2-heavy")

TABLES = {  # one text a frame, as the source lists them: roll pitch yaw throttle forward lateral
    "BLUEROV1": "0 0 -1 0 1 0 | 0 0 1 0 1 0 | -.5 .5 0 .45 0 0 | .5 .5 0 .45 0 0 | 0 -1 0 1 0 0"
    " | -.25 0 0 0 0 1",
    "VECTORED_6DOF_90DEG": "1 1 0 1 0 0 | 0 0 1 0 1 0 | 1 -1 0 1 0 0 | 0 0 0 0 0 1 | 0 0 0 0 0 1"
    " | -1 1 0 1 0 0 | 0 0 -1 0 1 0 | -1 -1 0 1 0 0",
    "VECTORED_6DOF": "0 0 1 0 -1 1 | 0 0 -1 0 -1 -1 | 0 0 -1 0 1 1 | 0 0 1 0 1 -1 | 1 -1 0 -1 0 0"
    " | -1 -1 0 -1 0 0 | 1 1 0 -1 0 0 | -1 1 0 -1 0 0",
    "VECTORED": "0 0 1 0 -1 1 | 0 0 -1 0 -1 -1 | 0 0 -1 0 1 1 | 0 0 1 0 1 -1 | 1 0 0 -1 0 0 | -1 0 0 -1 0 0",
    "SIMPLEROV_3": "0 0 -1 0 1 0 | 0 0 1 0 1 0 | 0 0 0 -1 0 0",
    "SIMPLEROV_4": "0 0 -1 0 1 0 | 0 0 1 0 1 0 | 1 0 0 -1 0 0 | -1 0 0 -1 0 0",
    "SIMPLEROV_5": "0 0 -1 0 1 0 | 0 0 1 0 1 0 | 1 0 0 -1 0 0 | -1 0 0 -1 0 0 | 0 0 0 0 0 1",
}


def mixed(frame: str, asked: dict[str, float], directions: list[int], k: float) -> list[float]:
    """Outputs of motors 1, 2, … by the text of the firmware."""
    motors = [[float(word) for word in row.split()] for row in TABLES[frame].split("|")]
    found = []
    for number, (roll, pitch, yaw, throttle, forward, lateral) in enumerate(motors, start=1):
        turning = roll * asked["roll"] + pitch * asked["pitch"]
        if frame == "VECTORED_6DOF":
            up = turning + throttle * asked["heave"]
            level = yaw * asked["yaw"] + forward * asked["surge"] + lateral * asked["sway"]
            found.append((up, level))
            continue
        ahead = asked["surge"]
        if frame == "VECTORED":
            left = max(0.0, 1.0 - k * abs(asked["heave"]))
            if ahead < 0 and number in (1, 2):
                ahead = max(ahead, -left)
            if ahead > 0 and number in (3, 4):
                ahead = min(ahead, left)
        turning += yaw * asked["yaw"]
        found.append((turning + throttle * asked["heave"], forward * ahead + lateral * asked["sway"]))
    if frame == "VECTORED_6DOF":
        up_most, level_most = (max(1.0, *(abs(pair[side]) for pair in found)) for side in (0, 1))
        found = [(up / up_most, level / level_most) for up, level in found]
    return [
        min(1.0, max(-1.0, way * (up + level))) for way, (up, level) in zip(directions, found, strict=True)
    ]


def a_mixer(frame: str, rng: np.random.Generator) -> Autopilot:
    """An autopilot with its motors in some order, some of them turned round."""
    n = len(FRAMES[frame])
    turned = np.flatnonzero(rng.random(n) < 0.5).tolist()
    order = rng.permutation(n).tolist()
    return make_autopilot(
        frame, (np.full(n, -40.0), np.full(n, 50.0)), (), order, turned, rng.uniform(0, 1.5)
    )


def test_there_is_a_second_reading_of_every_frame() -> None:
    assert set(FRAMES) == set(TABLES)


@pytest.mark.parametrize("frame", FRAMES)
def test_outputs_are_those_of_a_second_reading_of_the_firmware(frame: str, rng: np.random.Generator) -> None:
    mixer = a_mixer(frame, rng)
    asked = rng.uniform(-1, 1, (N_INPUTS, 6)) * rng.choice([0.0, 0.3, 1.0], (N_INPUTS, 6))
    made = outputs(mixer, asked)
    directions = [mixer.directions[mixer.motors.index(motor + 1)] for motor in range(len(FRAMES[frame]))]
    for row, out in zip(asked.tolist(), made, strict=True):
        second = mixed(frame, dict(zip(DOF, row, strict=True)), directions, mixer.coupling)
        assert out == pytest.approx([second[motor - 1] for motor in mixer.motors], abs=1e-12)


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_axis_alone_gets_what_it_asks_for_up_to_input_one(name: str, sign: float) -> None:
    """Whatever else its thrusters make: that is the factors', and they know no geometry."""
    vehicle = load_vehicle(name)
    allocate, way = build("ardusub", vehicle), find_inputs(vehicle)
    for axis in range(vehicle.k):
        most = 1.0 / abs((way.ahead if sign > 0 else way.astern)[axis])
        for share in (0.25, 1.0, 1.7):
            tau = np.zeros(vehicle.k)
            tau[axis] = sign * share * most
            made = vehicle.T @ allocate(tau).f
            assert made[axis] == pytest.approx(sign * min(share, 1.0) * most)


def test_the_same_vehicle_in_the_other_frame_gets_the_same_thrusts(rng: np.random.Generator) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    turned = vehicle.with_frame("flu")
    signs = np.array([1, -1, -1, 1, -1, -1])
    taus = rng.normal(size=(100, 6)) * vehicle.wrench_scale
    F, G = build("ardusub", vehicle).many(taus)[0], build("ardusub", turned).many(taus * signs)[0]
    np.testing.assert_allclose(F, G, atol=1e-12)


def test_a_gain_of_the_user_s_stands_for_input_one() -> None:
    vehicle = load_vehicle("bluerov2")
    assert vehicle.autopilot is not None
    half = replace(vehicle, autopilot=replace(vehicle.autopilot, gains={"surge": 60.0}))
    asked = inputs(find_inputs(half), np.diag([30.0, 0, 0, 0, 0]))
    assert asked[0] == pytest.approx([0.5, 0, 0, 0, 0, 0])


def test_forward_gives_way_to_throttle_on_the_rear_thrusters_of_vectored_alone() -> None:
    vehicle = load_vehicle("bluerov2")
    assert vehicle.autopilot is not None
    asked = np.zeros((1, 6))
    asked[0, DOF.index("surge")], asked[0, DOF.index("heave")] = 0.9, 0.6
    out = dict(zip(vehicle.autopilot.motors, outputs(vehicle.autopilot, asked)[0], strict=True))
    assert [abs(out[motor]) for motor in (1, 2, 3, 4)] == pytest.approx([0.9, 0.9, 0.4, 0.4])


@pytest.mark.parametrize("name", SHIPPED)
def test_a_failure_is_not_known_to_the_mixer(name: str, rng: np.random.Generator) -> None:
    """The others push as before, and the wrench is off by what is missing."""
    vehicle = load_vehicle(name)
    off = vehicle.with_fault(2)
    taus = rng.normal(size=(50, vehicle.k)) * vehicle.wrench_scale
    F, G = build("ardusub", vehicle).many(taus)[0], build("ardusub", off).many(taus)[0]
    F[:, 2] = 0.0
    np.testing.assert_array_equal(F, G)


@pytest.mark.parametrize("name", SHIPPED)
def test_its_c_answers_as_python_does(name: str, rng: np.random.Generator) -> None:
    vehicle = load_vehicle(name)
    taus = rng.normal(size=(500, vehicle.k)) * vehicle.wrench_scale * rng.choice([0.05, 1.0], (500, 1))
    ends = np.sort(rng.uniform(-60, 60, (2, 500, vehicle.n)), axis=0)
    for limits in ((), tuple(ends)):
        (F, status), (G, other) = (
            build(m, vehicle).many(taus, *limits) for m in ("ardusub", "ardusub@native")
        )
        np.testing.assert_allclose(F, G, rtol=0, atol=1e-11)
        np.testing.assert_array_equal(status, other)


def test_what_fits_its_frame_is_solved_and_what_saturates_is_not() -> None:
    heavy = load_vehicle("bluerov2-heavy")
    allocate = build("ardusub", heavy)
    assert allocate([50.0, 0, 0, 0, 0, 0]).status is Status.SOLVED
    assert allocate([50.0, 90.0, 0, 0, 0, 9.0]).status is Status.PARTIAL


def test_thrust_is_linear_on_either_side_of_zero() -> None:
    heavy = load_vehicle("bluerov2-heavy")
    assert heavy.autopilot is not None
    made = thrust(heavy.autopilot, np.array([[-1.0] * 8, [-0.5] * 8, [0.5] * 8, [1.0] * 8]))
    np.testing.assert_array_equal(made[:, 0], [-40.0, -20.0, 30.0, 60.0])


def read_curve(volts: float) -> np.ndarray:
    """Pulses and thrusts [N] of the maker's table (2, K), read apart from ``alloc.vehicle.esc``."""
    lines = [line for line in T200.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    table = np.array([[float(word) for word in line.split(",")[:3]] for line in lines[1:]])
    pulse, kgf, _ = table[table[:, 2] == volts].T
    return np.array([pulse, 9.80665 * kgf])


def through_curves(vehicle: Vehicle) -> Vehicle:
    assert vehicle.autopilot is not None
    return replace(vehicle, autopilot=replace(vehicle.autopilot, curve=True))


@pytest.mark.parametrize("name", SHIPPED)
def test_outputs_push_by_the_maker_s_table_where_the_esc_s_curve_counts(
    name: str, rng: np.random.Generator
) -> None:
    """Thrusts and gains, with an ESC that runs the other way, whose pulse is mirrored: its thrust is not."""
    vehicle = through_curves(load_vehicle(name))
    vehicle = replace(vehicle, esc=(replace(vehicle.esc[0], reversed=True), *vehicle.esc[1:]))
    mixer, curve = vehicle.autopilot, read_curve(16.0)
    assert mixer is not None

    def pushed(out: np.ndarray) -> np.ndarray:
        return np.interp(1500.0 + 400.0 * out, *curve)

    axes = [DOF.index(axis) for axis in vehicle.dof]
    asked = np.zeros((200, 6))
    asked[:, axes] = rng.uniform(-1.0, 1.0, (200, vehicle.k))
    taus = np.empty((200, vehicle.k))
    for row, axis in enumerate(axes):
        one = np.array([vehicle.T[row] @ pushed(sign * mixer.factors[:, axis]) for sign in (-1.0, 1.0)])
        taus[:, row] = np.abs(asked[:, axis]) * np.where(asked[:, axis] < 0.0, one[0], one[1])
    made = build("ardusub", vehicle).many(taus)[0]
    expected = np.clip(pushed(outputs(mixer, asked)), vehicle.f_min, vehicle.f_max)
    np.testing.assert_allclose(made, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("said", "curve"), [("", True), (", thrust: esc", True), (", thrust: linear", False)]
)
def test_a_file_with_an_esc_has_its_curve_unless_it_says_linear(
    said: str, curve: bool, tmp_path: Path
) -> None:
    text = (FOLDER / "bluerov2.yaml").read_text(encoding="utf-8")
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(", thrust: linear", said), encoding="utf-8")
    mixer = load_vehicle(path).autopilot
    assert mixer is not None
    assert mixer.curve is curve


@pytest.mark.parametrize(
    ("was", "said", "says"),
    [
        ("thrust: linear", "thrust: lineal", "no thrust 'lineal'; did you mean linear"),
        ("esc: #", "notes: #", "autopilot: thrust is esc, and the file has no 'esc'; add it"),
        ("ardusub: VECTORED, reversed: [0, 1, 4]", "px4: automatic", "ardusub alone reads thrust"),
    ],
)
def test_a_thrust_that_is_none_is_refused(was: str, said: str, says: str, tmp_path: Path) -> None:
    text = (FOLDER / "bluerov2.yaml").read_text(encoding="utf-8")
    if was.startswith("esc"):
        text = re.sub(r"^esc: .*\n.*\n", "", text, flags=re.MULTILINE).replace("linear}", "esc}")
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(was, said), encoding="utf-8")
    with pytest.raises(VehicleError, match=re.escape(says)):
        load_vehicle(path)


def test_c_and_curves_without_a_voltage_are_refused_with_what_to_write() -> None:
    vehicle = through_curves(load_vehicle("bluerov2"))
    with pytest.raises(NotApplicable, match="no curve of an ESC; write thrust: linear"):
        build("ardusub@native", vehicle)
    unsure = replace(vehicle, esc=tuple(replace(esc, nominal=np.nan) for esc in vehicle.esc))
    with pytest.raises(NotApplicable, match="several curves; write volts in 'esc', or thrust: linear"):
        build("ardusub", unsure)


def test_a_vehicle_without_the_key_is_refused_with_what_to_write() -> None:
    with pytest.raises(NotApplicable, match=r"ukwial has no key 'autopilot'; write autopilot: \{"):
        build("ardusub", load_vehicle("ukwial"))


def limits_of(vehicle: Vehicle) -> tuple[np.ndarray, np.ndarray]:
    return vehicle.f_min, vehicle.f_max


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        ("VECTRED", "no frame 'VECTRED'; did you mean VECTORED"),
        (
            "VECTORED_6DOF",
            "VECTORED_6DOF has 8 motors, the vehicle 6 thrusters; frames with 6: BLUEROV1, VECTORED",
        ),
    ],
)
def test_a_frame_that_is_none_of_this_vehicle_s_is_refused(frame: str, says: str) -> None:
    with pytest.raises(VehicleError, match=says):
        make_autopilot(frame, limits_of(load_vehicle("bluerov2")))


@pytest.mark.parametrize(
    ("motors", "says"),
    [([0, 1, 2, 3, 4, 4], "names 5 of 6"), ([0, 1], "names 2 of 6"), ([0, 9], "no thruster 9")],
)
def test_each_thruster_is_one_motor(motors: list[int], says: str) -> None:
    with pytest.raises(VehicleError, match=says):
        make_autopilot("VECTORED", limits_of(load_vehicle("bluerov2")), motors=motors)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_worker_gets_the_vehicle_s_autopilot(name: str, rng: np.random.Generator) -> None:
    vehicle = through_curves(load_vehicle(name))
    taus = rng.normal(size=(20, vehicle.k)) * vehicle.wrench_scale
    there = unpack_vehicle(pack_vehicle(vehicle))
    np.testing.assert_array_equal(
        build("ardusub", there).many(taus)[0], build("ardusub", vehicle).many(taus)[0]
    )


@pytest.mark.parametrize("alike", [True, False])
@pytest.mark.parametrize("frame", FRAMES)
def test_its_operations_answer_10_000_demands_of_each_frame_as_python_does(
    frame: str, alike: bool, rng: np.random.Generator
) -> None:
    """Any geometry, order of motors, direction and coupling: what is folded and shared changes no answer."""
    n = len(FRAMES[frame])
    dof = ("surge", "heave", "yaw") if n < 5 else ("surge", "sway", "heave", "roll", "yaw")
    dof = DOF if n == 8 else dof
    limits = (np.full(n, -40.0), np.full(n, 60.0)) if alike else rng.uniform((-50, 20), (-20, 50), (n, 2)).T
    vehicle = made_up(rng.normal(size=(len(dof), n)), limits[0], limits[1], dof=dof)
    mixer = make_autopilot(
        frame,
        (vehicle.f_min, vehicle.f_max),
        (),
        rng.permutation(n).tolist(),
        np.flatnonzero(rng.random(n) < 0.5).tolist(),
        rng.uniform(0.0, 1.5),
        gains={axis: float(rng.uniform(10, 40)) for axis in dof},
    )
    vehicle = replace(vehicle, autopilot=mixer)
    taus = rng.normal(size=(N_INPUTS, len(dof))) * rng.choice([1.0, 20.0], (N_INPUTS, 1))
    made = evaluate(program(vehicle, "fixed", "double"), taus)
    F, status = build("ardusub", vehicle).many(taus)
    np.testing.assert_allclose(made.F, F, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(made.status, status)


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_groups_that_are_fitted_exceed_no_limit_by_rounding(scalar: Scalar, rng: np.random.Generator) -> None:
    """No cut follows in C; of demands along one axis, and of all three of a group, most fill a thruster."""
    heavy = load_vehicle("bluerov2-heavy")
    taus = heavy.wrench_scale * rng.choice([-1.0, 0.0, 1.0], (N_INPUTS, 6)) * rng.uniform(1, 3, (N_INPUTS, 6))
    made = evaluate(program(heavy, "fixed", scalar), taus)
    ends = limits_of(heavy)
    reached = (made.F / np.where(made.F > 0.0, ends[1], ends[0])).max(axis=1)[taus.any(axis=1)]
    assert reached.max() <= 1.0
    assert np.median(reached) > 1.0 - 1e-5


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_a_thruster_that_can_not_be_still_is_cut_in_c_too(scalar: Scalar, rng: np.random.Generator) -> None:
    """Groups that are fitted left it at 0 N, outside of its limits."""
    heavy = load_vehicle("bluerov2-heavy")
    f_min, f_max = heavy.f_min.copy(), heavy.f_max.copy()
    f_min[4], f_max[2] = 5.0, -3.0
    vehicle = replace(heavy, f_min=f_min, f_max=f_max)
    taus = heavy.wrench_scale * rng.uniform(-1, 1, (N_INPUTS, 6))
    made = evaluate(program(vehicle, "fixed", scalar), taus)
    F, _ = build("ardusub", vehicle).many(taus)
    np.testing.assert_allclose(made.F, F, atol=1e-4)
    assert ((f_min <= made.F) & (f_max >= made.F)).all()


@pytest.mark.parametrize("name", SHIPPED)
def test_its_operations_are_as_many_as_it_says_beside_those_of_clip(name: str) -> None:
    def operations(kernel: ModuleType) -> int:
        made = kernel.program(load_vehicle(name), "fixed", "double")
        return sum(made.nodes[node][0] in FOLDED for node in reachable(made.nodes, made.roots))

    said = re.search(rf"(\d+) operations on\s+{name},\s+(\d+) of clip", program.__doc__ or "")
    assert said is not None
    assert (operations(ardusub), operations(clip)) == tuple(map(int, said.groups()))


def test_where_no_working_thruster_pushes_along_an_axis_all_of_it_is_missed() -> None:
    vehicle = made_up([[1.0, 0.0]]).with_fault(0)
    builder = Builder(vehicle)
    met = rules.makes_tau(builder, {1: builder.tau[0]})
    made = builder.program([0.0, 0.0], select(met, Status.SOLVED, Status.PARTIAL))
    assert evaluate(made, np.array([[0.0], [1.0]])).status.tolist() == [Status.SOLVED, Status.PARTIAL]
