"""QP solvers on thrusters that turn: the sides of polygons are rows of their problem, or are refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import BoundedSteps, TwoStage
from alloc.discovery import catalogue
from alloc.errors import DemandError
from alloc.live.azimuths import with_angles
from alloc.qp import pose_hard
from alloc.qp.certificate import certify
from alloc.solvers import default_level, load, missing, names, slow
from tests.azimuths import FERRY, boats, corners_lp, demands_around, excess, stationarity
from tests.places import ROOT

SHARES = (0.1, 0.7, 0.98, 1.02, 2.0)
LIMIT = 1e-14
REFUSES = {"sip"}


def asked(vehicle: Vehicle, rng: np.random.Generator) -> list[tuple[np.ndarray, float]]:
    (tau,) = demands_around(vehicle, rng, 1)
    (far,) = alpha_max(vehicle, [tau])
    return [(share * far * tau, 1.0 / share) for share in SHARES] if far > 1e-3 else []


def held(vehicle: Vehicle, name: str, rng: np.random.Generator) -> tuple[int, int]:
    """Answers, and those that the solver did not find; raises where one is wrong."""
    allocate, given, lost = build(f"qp/{name}", vehicle), 0, 0
    for tau, alpha in asked(vehicle, rng):
        result = allocate(tau)
        given += 1
        if alpha < 1.0:
            assert result.status in (Status.INFEASIBLE, Status.NOT_CONVERGED), (name, alpha)
            continue
        assert result.status is not Status.INFEASIBLE, (name, alpha)
        if result.status is not Status.SOLVED:
            lost += 1
            continue
        assert np.abs((vehicle.TP @ result.f - tau) / vehicle.wrench_scale).max() <= 1e-6
        assert excess(vehicle, result.f) <= LIMIT
        right = build("qp/daqp", vehicle)(tau).f
        assert np.abs(result.f - right).max() <= (allocate.tolerance + 1e-9) * vehicle.f_scale, name
    return given, lost


def test_daqp_gives_the_least_effort_of_120_boats_or_says_that_there_is_none() -> None:
    rng, verdicts = np.random.default_rng(11), 0
    for vehicle in boats(120, seed=5):
        allocate = build("qp/daqp", vehicle)
        for tau, alpha in asked(vehicle, rng):
            result = allocate(tau)
            verdicts += 1
            expected = Status.SOLVED if alpha > 1.0 else Status.INFEASIBLE
            assert result.status is expected, (vehicle.name, alpha)
            if alpha > 1.0:
                assert excess(vehicle, result.f) <= LIMIT
                assert stationarity(vehicle, result.f) <= 1e-6
    assert verdicts > 500


@pytest.mark.parametrize("name", sorted({*names()} - REFUSES - {*slow()}))
def test_a_solver_takes_the_sides_as_rows(name: str) -> None:
    if said := missing(name):
        pytest.skip(said)
    rng, given, lost = np.random.default_rng(12), 0, 0
    for vehicle in boats(12, seed=6):
        counts = held(vehicle, name, rng)
        given, lost = given + counts[0], lost + counts[1]
    assert given >= 50
    assert lost <= 0.1 * given, (name, lost, default_level(load(name)))


@pytest.mark.parametrize("name", sorted(REFUSES))
def test_a_solver_that_is_asked_with_bounds_alone_refuses_sides(name: str) -> None:
    if said := missing(name):
        pytest.skip(said)
    with pytest.raises(NotApplicable, match=f"{name}: is asked here with bounds alone, not with sides"):
        build(f"qp/{name}", boats(1)[0])


@pytest.mark.parametrize("page", ["README.md", "CHANGELOG.md"])
def test_pages_say_how_many_methods_take_azimuths(page: str) -> None:
    """Red before: both said most methods, of which three in four refuse."""
    takes = [entry.name for entry in catalogue() if entry.azimuths and entry.solver not in REFUSES]
    (line,) = (
        row
        for row in (ROOT / page).read_text(encoding="utf-8").splitlines()
        if "`demands`, `allocate`" in row
    )
    assert f" {len(takes)} methods" in line


def test_a_certificate_of_bounds_alone_refuses_sides() -> None:
    qp = pose_hard(boats(1)[0]).qp
    with pytest.raises(NotApplicable, match="tries multipliers of bounds alone"):
        certify(qp, np.zeros(3), np.zeros(len(qp.g)))


@pytest.mark.parametrize("method", ["nullspace", "scaled", "pinv", "qp/daqp"])
def test_an_answer_says_force_and_angle_of_each_thruster(method: str) -> None:
    rng = np.random.default_rng(14)
    for vehicle in boats(8):
        try:
            allocate = build(method, vehicle)
        except NotApplicable:
            continue
        for tau in demands_around(vehicle, rng, 3) * 0.1:
            result = allocate(tau)
            assert len(result.forces) == len(result.angles) == len(vehicle.actuators)
            for at, force, angle in zip(vehicle.actuators, result.forces, result.angles, strict=True):
                own = result.f[list(at)]
                if len(at) == 1:
                    assert np.isnan(angle)
                    assert force == pytest.approx(own[0], nan_ok=True)
                elif result.found:
                    made = force * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
                    assert made == pytest.approx(own, abs=1e-8 * vehicle.f_scale)
                else:
                    assert np.isnan([force, angle]).all()


def test_a_force_that_rounding_leaves_has_no_angle() -> None:
    ferry = load_vehicle("double-ended-ferry")
    result = build("pinv", ferry)([1e-13, 1e-13, 0.0])
    assert [*result.forces, *result.angles] == [0.0] * 4


def test_angles_go_the_shortest_way_round_and_stay_where_there_is_no_force_or_answer() -> None:
    """In closed form: the ferry's thrusters push along the demand, which goes round twice in steps of 40."""
    allocate = build("nullspace", load_vehicle("double-ended-ferry"))
    angles = np.full(2, np.nan)
    for asked_deg in range(0, 720, 40):
        radians = np.radians(asked_deg)
        angles = allocate([300.0 * np.cos(radians), 300.0 * np.sin(radians), 0.0]).nearest_angles(angles)
        assert angles == pytest.approx([asked_deg, asked_deg], abs=1e-9)
        for nothing in ([0.0, 0.0, 0.0], [1e6, 0.0, 0.0]):
            assert (allocate(nothing).nearest_angles(angles) == angles).all()
    assert allocate([0.0, 0.0, 0.0]).nearest_angles([np.nan, 7.0]).tolist() == [0.0, 7.0]
    for wrong in ([0.0], [0.0, np.inf]):
        with pytest.raises(DemandError, match=r"give \(2,\), a finite angle a thruster \[deg\]$"):
            allocate([1.0, 0.0, 0.0]).nearest_angles(wrong)


@pytest.mark.parametrize(
    ("sector", "taken", "rest"),
    [
        ("[-90, 90]", (-90.0, 90.0), 0.0),
        ("[100, 260]", (100.0, 260.0), 100.0),
        ("[-260, -100]", (100.0, 260.0), 100.0),
        ("[100, 280]", (100.0, 280.0), -80.0),
        ("[170, 260]", (170.0, 260.0), -100.0),
        ("[-120, -40]", (-120.0, -40.0), -40.0),
        ("[0, 45]", (0.0, 45.0), 0.0),
        ("[300, 420]", (-60.0, 60.0), 0.0),
    ],
)
def test_a_thruster_turns_through_its_sector_and_rests_within_it(
    sector: str, taken: tuple[float, float], rest: float, tmp_path: Path
) -> None:
    """Red before: half a turn went by -180, so -90, 90, -90 became -90, -270, -450; each rested at 0."""
    file = tmp_path / "boat.yaml"
    file.write_text(FERRY.replace("max: 100}, name: stern", f"max: 100, sector_deg: {sector}}}, name: stern"))
    boat, (low, high) = load_vehicle(file), taken
    assert [one.sector for one in boat.azimuths] == [None, taken]
    allocate, last = build("redistribute", boat), np.full(2, np.nan)
    for asked_deg in (low, high, low, (low + high) / 2.0, high, low):
        x, y = 50.0 * np.cos(np.radians(asked_deg)), 50.0 * np.sin(np.radians(asked_deg))
        result = with_angles(boat, allocate([x, y, -1.8 * y])._replace(f=np.array([0.0, 0.0, x, y])))
        last = result.nearest_angles(last)
        assert last == pytest.approx([0.0, asked_deg], abs=1e-9)
        assert (result.nearest_angles([0.0, asked_deg - 720.0]) + 720.0)[1] == pytest.approx(asked_deg)
    still = allocate([0.0, 0.0, 0.0])
    assert still.angles == pytest.approx([0.0, rest], abs=1e-9)
    assert still.nearest_angles(last) == pytest.approx(last)
    (begun,) = still.nearest_angles(np.full(2, np.nan))[1:]
    assert low <= begun <= high
    assert (begun - rest) % 360.0 == 0.0


def test_angles_of_boats_stay_within_their_sectors() -> None:
    rng, turned = np.random.default_rng(15), 0
    for vehicle in boats(20, seed=8):
        parts = [at[0] for at in vehicle.actuators]
        sectors = [(parts.index(one.first), one.sector) for one in vehicle.azimuths if one.sector]
        allocate, last = build("qp/daqp", vehicle), np.full(len(parts), np.nan)
        for tau, _ in [asked_for for _ in range(4) for asked_for in asked(vehicle, rng)] if sectors else []:
            result = allocate(tau)
            last = result.nearest_angles(last)
            for i, (low, high) in sectors if result.found else []:
                assert low - 1e-6 <= last[i] <= high + 1e-6
                assert result.forces[i] == 0.0 or abs((last[i] - result.angles[i] + 180) % 360 - 180) < 1e-9
                turned += 1
    assert turned > 50


def test_a_vehicle_of_fixed_thrusters_has_neither_forces_nor_angles() -> None:
    result = build("nullspace", load_vehicle("ukwial"))([1.0, 0.0, 0.0])
    assert (result.forces, result.angles) == ((), ())


def test_what_an_allocator_is_told_by_stays_where_answers_have_angles() -> None:
    ferry = load_vehicle("double-ended-ferry")
    assert isinstance(build("qp/daqp", ferry), TwoStage)
    assert isinstance(build("nullspace", ferry), BoundedSteps)
    assert not isinstance(build("pinv", ferry), TwoStage | BoundedSteps)


def test_beyond_three_dimensions_scaled_is_right_by_a_linear_program_and_multipliers() -> None:
    """Red before: a vessel with four azimuths had no method that gives way."""
    rng, stopped = np.random.default_rng(15), 0
    large = [vehicle for vehicle in boats(32) if vehicle.nullity > 3]
    assert len(large) > 10
    for vehicle in large:
        allocate = build("scaled", vehicle)
        taus = demands_around(vehicle, rng, 3) * rng.choice([0.1, 0.5, 3.0], (3, 1))
        F, status = allocate.many(taus)
        for tau, f, given in zip(taus, F, status, strict=True):
            result, share = allocate(tau), min(1.0, corners_lp(vehicle, tau))
            assert result.share == (pytest.approx(share, abs=1e-8),)
            assert (
                np.abs((vehicle.TP @ result.f - result.share[0] * tau) / vehicle.wrench_scale).max() <= 1e-9
            )
            assert excess(vehicle, result.f) <= LIMIT
            assert stationarity(vehicle, result.f) <= 1e-6
            assert (result.status is Status.SOLVED) == (share == 1.0)
            assert f == pytest.approx(result.f, abs=1e-7 * vehicle.f_scale)
            assert given == result.status
            stopped += share < 1.0
    assert stopped > 10


def test_beyond_three_dimensions_priority_keeps_a_heading_first() -> None:
    large = next(vehicle for vehicle in boats(32) if vehicle.nullity > 4)
    vessel = replace(large, priority=(("yaw",), ("surge", "sway")))
    far = alpha_max(vessel, np.diag(vessel.wrench_scale)) * vessel.wrench_scale
    result = build("priority", vessel)([3.0 * far[0], 0.0, 0.5 * far[2]])
    assert result.status is Status.PARTIAL
    assert result.share[0] == 1.0 > result.share[1] > 0.0
    made = vessel.TP @ result.f
    assert made == pytest.approx([result.share[1] * 3.0 * far[0], 0.0, 0.5 * far[2]], abs=1e-6 * far.max())
