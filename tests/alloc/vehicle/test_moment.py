"""Sets of a call around the last forces: within what rates allow, and answers within them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.errors import AllocError, DemandError, VehicleError
from alloc.live.azimuths import with_sets
from alloc.reach.way import at_rest
from alloc.vehicle.azimuth import Azimuth, excess
from alloc.vehicle.limits import Interval
from alloc.vehicle.moment import Sets
from tests.alloc.live.test_pieces import least_efforts
from tests.azimuths import FERRY, demands_around

DT = 0.2
BOAT = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [2, 0, 0], azimuth: {max: 100, rate_deg: 40, slew: 60}, name: bow}
  - {position: [-2, 0.3, 0], azimuth: {max: 80, sector_deg: [-140, 120], rate_deg: 25}, name: stern}
  - {position: [1, 0, 0], direction: [0, 1, 0], name: tunnel}
  - {position: [-1, 1, 0], azimuth: {max: 50, min: 8, sides: 8, slew: 90}}
f_min: -40
f_max: 40
slew: 50
"""


def load(text: str, folder: Path) -> Vehicle:
    file = folder / "boat.yaml"
    file.write_text(text)
    return load_vehicle(file)


def last_thrusts(vehicle: Vehicle, rng: np.random.Generator) -> np.ndarray:
    """Thrusts (n,) within the vehicle's sets, some at their edge, some of no force."""
    f: np.ndarray = rng.uniform(vehicle.f_min, vehicle.f_max)
    for azimuth in vehicle.azimuths:
        part = azimuth.parts[rng.integers(len(azimuth.parts))]
        spread = rng.choice([0.05, 1.0])
        f[azimuth.components] = rng.dirichlet(np.full(len(part.corners), spread)) @ part.corners
        if rng.random() < 0.1 and (part.reach >= 0.0).all():
            f[azimuth.components] = 0.0
    return f


def sets_at(vehicle: Vehicle, last: np.ndarray, dt: float = DT) -> Sets:
    found: Interval = vehicle.limits(f_previous=last, dt=dt)
    assert isinstance(found, Sets)
    return found


def turned(f: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Angles (N,) between forces f (N, 2) and a last one (2,) [deg]."""
    cross, dot = last[0] * f[:, 1] - last[1] * f[:, 0], f @ last
    angle: np.ndarray = np.abs(np.degrees(np.arctan2(cross, dot)))
    return angle


def test_no_force_of_a_moment_is_beyond_its_rates_or_the_set_and_the_last_one_is_there(
    tmp_path: Path,
) -> None:
    vehicle, rng, seen = load(BOAT, tmp_path), np.random.default_rng(1), 0
    for dt in (0.002, 0.2, 1.0, 20.0):
        for _ in range(40):
            last = last_thrusts(vehicle, rng)
            low, high = sets = sets_at(vehicle, last, dt)
            assert low[4] == max(-40.0, last[4] - 50 * dt)
            assert high[4] == min(40.0, last[4] + 50 * dt)
            for azimuth, polygons in zip(vehicle.azimuths, sets.polygons, strict=True):
                f0, own = last[azimuth.components], np.array([np.inf])
                for corners in polygons:
                    f = np.vstack([rng.dirichlet(np.full(len(corners), 0.4), 60) @ corners, corners])
                    seen += len(f)
                    if azimuth.slew is not None:
                        assert (np.abs(np.hypot(*f.T) - np.hypot(*f0)) <= azimuth.slew * dt + 1e-7).all()
                    if azimuth.rate_deg is not None and np.hypot(*f0) > 1e-3:
                        moving = f[np.hypot(*f.T) > 1e-4]
                        assert (turned(moving, f0) <= azimuth.rate_deg * dt + 1e-4).all()
                    wide = np.zeros((len(f), vehicle.n))
                    wide[:, azimuth.components] = f
                    most = np.full(vehicle.n, 1e9)
                    assert excess([azimuth], wide, -most, most, 0.0)[:, azimuth.first].max() <= 1e-9
                    part = Azimuth(0, corners)
                    own = np.minimum(own, (part.normals @ f0 - part.reach).max())
                assert own <= 1e-7
    assert seen > 30_000


def test_a_moment_holds_what_rates_allow_but_for_an_inscribed_polygon_s_loss(tmp_path: Path) -> None:
    disc = load(FERRY.replace("{max: 100}", "{max: 100, rate_deg: 40, slew: 60}"), tmp_path)
    angle = np.radians(30.0)
    f0 = 50.0 * np.array([np.cos(angle), np.sin(angle)])
    (corners,) = sets_at(disc, np.concatenate([f0, f0])).polygons[0]
    part = Azimuth(0, corners)
    for size, turn in ((38.001, 0), (61.999, 0), (38.5, 7.99), (38.5, -7.99), (61.4, 7.99), (61.4, -7.99)):
        at = angle + np.radians(turn)
        assert (part.normals @ (size * np.array([np.cos(at), np.sin(at)])) - part.reach).max() <= 0.0
    assert turned(corners, f0).max() == pytest.approx(8.0)
    assert np.hypot(*corners.T).max() == pytest.approx(62.0)


def test_a_thruster_without_a_force_starts_from_the_angle_that_is_given(tmp_path: Path) -> None:
    disc = load(FERRY.replace("{max: 100}", "{max: 100, rate_deg: 40, slew: 60}"), tmp_path)
    for angles, middle in ((None, 0.0), ([90.0, np.nan], 90.0)):
        sets = disc.limits(f_previous=np.zeros(4), dt=DT, angles=angles)
        assert isinstance(sets, Sets)
        f = sets.polygons[0][0].mean(axis=0)
        assert np.degrees(np.arctan2(f[1], f[0])) == pytest.approx(middle)
        assert np.hypot(*sets.polygons[0][0].T).max() == pytest.approx(12.0)
    result = build("scaled", disc)(
        [0.0, 5.0, 9.0], limits=disc.limits(f_previous=np.zeros(4), dt=DT, angles=[90, 0])
    )
    assert result.angles[0] == pytest.approx(90.0, abs=8.0)


def moments(vehicle: Vehicle, count: int, seed: int) -> list[tuple[np.ndarray, Sets, Vehicle, np.ndarray]]:
    """Last thrusts, the sets around them, a vehicle that has these, and a demand near what was made."""
    rng, made = np.random.default_rng(seed), []
    for _ in range(count):
        last = last_thrusts(vehicle, rng)
        sets = sets_at(vehicle, last)
        made.append(
            (
                last,
                sets,
                with_sets(vehicle, sets),
                vehicle.T @ last + 0.06 * demands_around(vehicle, rng, 1)[0],
            )
        )
    return made


def inside(vehicle: Vehicle, f: np.ndarray) -> float:
    return float(excess(vehicle.turning, f[None], vehicle.f_min, vehicle.f_max, 0.0).max())


def test_hard_answers_of_a_call_are_those_of_quadprog_on_its_polygons(tmp_path: Path) -> None:
    text = BOAT.replace("  - {position: [-1, 1, 0], azimuth: {max: 50, min: 8, sides: 8, slew: 90}}\n", "")
    vehicle, solved, none = load(text, tmp_path), 0, 0
    allocators = [build(method, vehicle) for method in ("nullspace", "qp/daqp", "qp/quadprog")]
    for _, sets, moment, tau in moments(vehicle, 30, seed=3):
        least = min(least_efforts(moment, tau))
        for allocate in allocators:
            result = allocate(tau, limits=sets)
            assert result.status is (Status.SOLVED if least < np.inf else Status.INFEASIBLE)
            if least < np.inf:
                assert result.f @ vehicle.H @ result.f == pytest.approx(least, rel=1e-6)
                assert np.abs((vehicle.T @ result.f - tau) / vehicle.wrench_scale).max() <= 1e-6
                assert inside(moment, result.f) <= 1e-7
        solved, none = solved + (least < np.inf), none + (least == np.inf)
    assert min(solved, none) >= 5


def largest_share(moment: Vehicle, start: np.ndarray, tau: np.ndarray) -> float:
    """Largest s up to 1 with start + s (tau - start) made by weights of corners: a linear program."""
    sets = [(azimuth.components, azimuth.corners) for azimuth in moment.azimuths]
    turning = {i for own, _ in sets for i in own}
    sets += [([i], np.array([[moment.f_min[i]], [moment.f_max[i]]])) for i in {*range(moment.n)} - turning]
    columns = np.column_stack([moment.T[:, own] @ corners.T for own, corners in sets])
    ones = np.zeros((len(sets), columns.shape[1] + 1))
    end = 0
    for row, (_, corners) in zip(ones, sets, strict=True):
        row[end : end + len(corners)] = 1.0
        end += len(corners)
    A = np.vstack([np.column_stack([columns, start - tau]) / moment.wrench_scale[:, None], ones])
    b = np.concatenate([start / moment.wrench_scale, np.ones(len(sets))])
    cost = np.append(np.zeros(columns.shape[1]), -1.0)
    found = linprog(cost, A_eq=A, b_eq=b, bounds=[(0, None)] * columns.shape[1] + [(0, 1)])
    assert found.status == 0
    return float(found.x[-1])


def test_scaled_goes_as_far_as_a_linear_program_over_the_corners_of_a_moment(tmp_path: Path) -> None:
    text = BOAT.replace("  - {position: [-1, 1, 0], azimuth: {max: 50, min: 8, sides: 8, slew: 90}}\n", "")
    text = text.replace("sector_deg: [-140, 120], ", "")
    vehicle, partial = load(text, tmp_path), 0
    allocate = build("scaled", vehicle)
    for _, sets, moment, tau in moments(vehicle, 30, seed=4):
        result, none = allocate(tau, limits=sets), np.zeros(3)
        try:
            largest_share(moment, none, none)
            start = none
        except AssertionError:
            start = moment.T @ at_rest(moment)
        share = largest_share(moment, start, tau)
        assert result.share[0] == pytest.approx(share, abs=1e-6)
        made = start + result.share[0] * (tau - start)
        assert np.abs((vehicle.T @ result.f - made) / vehicle.wrench_scale).max() < 1e-7
        assert inside(moment, result.f) <= 1e-7
        partial += result.status is Status.PARTIAL
    assert 5 <= partial < 30


def test_directions_that_a_moment_leaves_little_of_are_not_weak(tmp_path: Path) -> None:
    """Within 2 ms a force ahead turns by 0.07 N abeam, less than 0.3 degrees of its mounting make."""
    vehicle = load(FERRY.replace("{max: 100}", "{max: 100, rate_deg: 40, slew: 60}"), tmp_path)
    last = np.array([50.0, 0.0, 50.0, 0.0])
    tau = vehicle.T @ last + [0.1, 0.05, 0.02]
    result = build("scaled", vehicle)(tau, limits=vehicle.limits(f_previous=last, dt=0.002))
    assert result.status is Status.SOLVED
    assert vehicle.T @ result.f == pytest.approx(tau, abs=1e-9)


@pytest.mark.parametrize("method", ["nullspace", "scaled", "priority", "clip", "redistribute", "qp/daqp"])
def test_no_sequence_of_calls_turns_or_grows_faster_than_the_file_says(method: str, tmp_path: Path) -> None:
    text = FERRY.replace("{max: 100}", "{max: 100, rate_deg: 40, slew: 60}")
    vehicle = load(text, tmp_path)
    allocate, rng = build(method, vehicle), np.random.default_rng(6)
    last, found = np.array([20.0, 5.0, 20.0, -5.0]), 0
    tau = vehicle.T @ last
    for _ in range(25):
        tau = tau + 0.02 * demands_around(vehicle, rng, 1)[0]
        result = allocate(tau, limits=vehicle.limits(f_previous=last, dt=DT), f_previous=last)
        if not result.found:
            tau = vehicle.T @ last
            continue
        found += 1
        for own in map(list, vehicle.actuators):
            assert abs(np.hypot(*result.f[own]) - np.hypot(*last[own])) <= 60 * DT + 1e-6
            if min(np.hypot(*result.f[own]), np.hypot(*last[own])) > 1e-3:
                assert turned(result.f[own][None], last[own])[0] <= 40 * DT + 1e-4
        last = result.f
    assert found >= 10


def test_sets_without_last_thrusts_are_the_vehicle_s_own(tmp_path: Path) -> None:
    vehicle = load(BOAT, tmp_path)
    sets = vehicle.limits()
    assert isinstance(sets, Sets)
    assert [side.tolist() for side in sets] == [vehicle.f_min.tolist(), vehicle.f_max.tolist()]
    assert [len(polygons) for polygons in sets.polygons] == [1, 2, len(vehicle.azimuths[2].parts)]
    tau = [30.0, 10.0, 5.0]
    allocate = build("qp/daqp", vehicle)
    assert allocate(tau, limits=sets).f == pytest.approx(allocate(tau).f, abs=1e-6)


def test_a_failed_thruster_has_no_set_and_one_that_stands_outside_of_its_own_leaves_nothing(
    tmp_path: Path,
) -> None:
    vehicle = load(BOAT, tmp_path)
    last = np.array([20.0, 5.0, 10.0, 10.0, 0.0, 10.0, 0.0])
    failed = vehicle.with_fault("bow")
    sets = failed.limits(f_previous=np.array([0.0, 0.0, *last[2:]]), dt=DT)
    result = build("scaled", failed)([10.0, 0.0, 0.0], limits=sets)
    assert result.f[:2].tolist() == [0.0, 0.0]
    assert result.found
    beyond = last.copy()
    beyond[5:] = [0.0, 5.0]  # a ring of 8 N at least
    slow = replace(vehicle.azimuths[2], slew=1.0)
    held = replace(vehicle, azimuths=(*vehicle.azimuths[:2], slow))
    result = build("qp/daqp", held)([10.0, 0.0, 0.0], limits=held.limits(f_previous=beyond, dt=DT))
    assert result.status is Status.INFEASIBLE
    assert np.isnan(result.f).all()
    assert held.limits(f_previous=np.array([*last[:5], 0.0, 9999.0]), dt=DT).empty


def test_what_makes_no_sets_is_refused_in_one_line(tmp_path: Path) -> None:
    vehicle = load(BOAT, tmp_path)
    last = np.zeros(7)
    for given, said in (
        ({"f_previous": last}, "give both"),
        ({"f_previous": last, "dt": 0.0}, "dt = 0 is no time since the last call"),
        ({"f_previous": last[:3], "dt": DT}, r"f_previous has shape \(3,\)"),
        ({"f_previous": last, "dt": DT, "angles": [1.0]}, r"angles has shape \(1,\); give \(4,\)"),
    ):
        with pytest.raises(DemandError, match=said):
            vehicle.limits(**given)
    with pytest.raises(NotApplicable, match=r"vehicle.limits\(blocked=…\) takes no azimuth thrusters yet"):
        vehicle.limits(blocked=["tunnel"])
    with pytest.raises(VehicleError, match="has no limits by voltage"):
        vehicle.limits(volts=12.0)
    (tmp_path / "plain.yaml").write_text(FERRY)
    with pytest.raises(VehicleError, match="boat: has no rates; add 'rate_deg' or 'slew' to its file"):
        load_vehicle(tmp_path / "plain.yaml").limits(f_previous=np.zeros(4), dt=DT)
    allocate = build("qp/daqp", vehicle)
    for limits in ((vehicle.f_min, vehicle.f_max), load(FERRY, tmp_path).limits()):
        with pytest.raises(DemandError, match=r"give vehicle.limits\(…\)"):
            allocate([1.0, 2.0, 3.0], limits=limits)


def test_c_that_is_compiled_before_the_call_takes_no_sets_of_one(tmp_path: Path) -> None:
    vehicle = load(FERRY.replace("{max: 100}", "{max: 100, rate_deg: 40}"), tmp_path)
    allocate = build("nullspace@native", vehicle)
    assert allocate([10.0, 0.0, 0.0]).status is Status.SOLVED
    with pytest.raises(
        NotApplicable, match=r"nullspace@native: takes no limits= yet, for which .*use nullspace"
    ):
        allocate([10.0, 0.0, 0.0], limits=vehicle.limits(f_previous=[1, 0, 1, 0], dt=DT))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "rate_deg: 25",
            "rate_deg: 0",
            "line 5: thrusters[1].azimuth.rate_deg: is 0; give a rate above 0 [deg/s]",
        ),
        ("slew: 90", "slew: -1", "line 7: thrusters[3].azimuth.slew: is -1; give a rate above 0 [N/s], or"),
        ("slew: 50", "slew: [50]", "line 10: slew: give one number [N/s] for the fixed thrusters beside"),
    ],
)
def test_rates_that_are_none_are_refused_with_their_line(
    old: str, new: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(VehicleError) as refused:
        load(BOAT.replace(old, new), tmp_path)
    assert said in str(refused.value)
    with pytest.raises(AllocError, match="slew: no fixed thruster is there to have it; give it in 'azimuth'"):
        load(FERRY + "slew: 5\n", tmp_path)
