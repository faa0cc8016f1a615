"""The best of all combinations of convex pieces, against integer programs and a QP solver on each one."""

from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import quadprog
from scipy.optimize import LinearConstraint, milp
from scipy.spatial import ConvexHull

from alloc import Label, Status, Vehicle, alpha_max, build, label, load_vehicle
from alloc.errors import DemandError
from alloc.live.azimuths import EFFORT_MARGIN, SHARE_MARGIN, best_answer, last_combinations
from alloc.reach.attainable import alpha_max_lp
from alloc.reach.way import at_rest
from alloc.vehicle.azimuth import excess
from alloc.vehicle.pieces import combinations
from tests.azimuths import demands_around

FORCES = (
    "{max: 100, min: 15}",
    "{max: 80, sector_deg: [-140, 120]}",
    "{max: 90, forbidden_deg: [[-20, 35], [120, 200]]}",
    "{max: 60}",
    "{max: 70, min: 10, sector_deg: [-60, 75]}",
    "{max: 100, forbidden_deg: [[80, 100]]}",
)


def vehicles(folder: Path, count: int, seed: int) -> Iterator[Vehicle]:
    """Random boats with two or three thrusters that turn and up to one tunnel, most with several pieces."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        places = rng.uniform(-4.0, 4.0, (4, 2)).round(2).tolist()
        turning = 2 if i % 3 else 3
        lines = [
            f"  - {{position: [{x}, {y}, 0], azimuth: {rng.choice(FORCES[3 * (turning > 2) :])}}}"
            for x, y in places[:turning]
        ]
        if i % 2:
            lines.append(f"  - {{position: [{places[3][0]}, 0, 0], direction: [0, 1, 0]}}")
        limits = "f_min: -40\nf_max: 40\n" if i % 2 else ""
        file = folder / f"boat{i}.yaml"
        file.write_text(
            "\n".join([f"name: boat{i}", "dof: [surge, sway, yaw]", "thrusters:", *lines, limits])
        )
        yield load_vehicle(file)


def integer_program(vehicle: Vehicle, tau: np.ndarray) -> float:
    """alpha* with a binary for each piece and a weight for each corner: no combination is gone through."""
    columns, owner, groups = [], [], list[list[int]]()
    for azimuth in vehicle.azimuths:
        groups.append([])
        for part in azimuth.parts:
            groups[-1].append(len(set(owner)))
            owner += [groups[-1][-1]] * len(part.corners)
            columns += [vehicle.T[:, azimuth.components] @ corner for corner in part.corners]
    turning = {i for azimuth in vehicle.azimuths for i in azimuth.components}
    for i in set(range(vehicle.n)) - turning:
        groups.append([len(set(owner))])
        owner += [groups[-1][0]] * 2
        columns += [vehicle.T[:, i] * vehicle.f_min[i], vehicle.T[:, i] * vehicle.f_max[i]]
    m, p, size = len(columns), max(owner) + 1, np.abs(tau / vehicle.wrench_scale).max()
    made = np.column_stack([*columns, *np.zeros((p, vehicle.k)), -tau / size]) / vehicle.wrench_scale[:, None]
    sums, ones = np.zeros((p, m + p + 1)), np.zeros((len(groups), m + p + 1))
    sums[owner, np.arange(m)] = 1.0
    sums[np.arange(p), m + np.arange(p)] = -1.0
    for row, group in zip(ones, groups, strict=True):
        row[[m + j for j in group]] = 1.0
    found = milp(
        np.append(np.zeros(m + p), -1.0),
        integrality=np.concatenate([np.zeros(m), np.ones(p), [0]]),
        bounds=(np.append(np.zeros(m + p), -np.inf), np.full(m + p + 1, np.inf)),
        constraints=[
            LinearConstraint(made, 0, 0),
            LinearConstraint(sums, 0, 0),
            LinearConstraint(ones, 1, 1),
        ],
        options={"mip_rel_gap": 0.0},
    )
    assert found.status == 0, found.message
    return float(found.x[-1] / size)


def least_efforts(vehicle: Vehicle, tau: np.ndarray) -> list[float]:
    """f'Hf of each combination by quadprog, sides by Qhull; infinite where it has no solution."""
    efforts = []
    turning = {i for azimuth in vehicle.azimuths for i in azimuth.components}
    for chosen in product(*(azimuth.parts for azimuth in vehicle.azimuths)):
        rows, far = [], []
        for part in chosen:
            for *normal, offset in ConvexHull(part.corners).equations:
                row = np.zeros(vehicle.n)
                row[part.components] = normal
                rows.append(-row)
                far.append(offset)
        for i in set(range(vehicle.n)) - turning:
            rows += [np.eye(vehicle.n)[i], -np.eye(vehicle.n)[i]]
            far += [vehicle.f_min[i], -vehicle.f_max[i]]
        C = np.vstack([vehicle.T, rows]).T
        try:
            f = quadprog.solve_qp(
                vehicle.H.copy(), np.zeros(vehicle.n), C, np.concatenate([tau, far]), vehicle.k
            )[0]
            efforts.append(float(f @ vehicle.H @ f))
        except ValueError as none:
            if "constraints are inconsistent" not in str(none):
                raise
            efforts.append(np.inf)
    return efforts


def test_the_largest_share_is_that_of_an_integer_program_and_of_the_best_linear_program(
    tmp_path: Path,
) -> None:
    rng, several = np.random.default_rng(4), 0
    for vehicle in vehicles(tmp_path, 12, seed=8):
        several += len(combinations(vehicle)) > 1
        for tau in demands_around(vehicle, rng, 2):
            (far,) = alpha_max(vehicle, [tau])
            assert far == pytest.approx(integer_program(vehicle, tau), rel=1e-6), vehicle.name
            assert far == pytest.approx(alpha_max_lp(vehicle, tau), rel=1e-7), vehicle.name
    assert several >= 8


@pytest.mark.parametrize("method", ["nullspace", "qp/daqp"])
def test_a_hard_answer_is_the_least_effort_of_all_combinations_or_there_is_none(
    method: str, tmp_path: Path
) -> None:
    rng, solved, infeasible = np.random.default_rng(5), 0, 0
    for vehicle in vehicles(tmp_path, 14, seed=9):
        if vehicle.nullity > 3:
            continue
        allocate = build(method, vehicle)
        for tau in demands_around(vehicle, rng, 8) * 0.7:
            least, result = min(least_efforts(vehicle, tau)), allocate(tau)
            known = label(vehicle, [tau]).label[0]
            if known == Label.BOUNDARY:
                continue
            assert (known == Label.INFEASIBLE) == (least == np.inf)
            assert result.status is (Status.INFEASIBLE if least == np.inf else Status.SOLVED)
            infeasible += least == np.inf
            if least < np.inf:
                solved += 1
                assert result.f @ vehicle.H @ result.f == pytest.approx(least, rel=1e-6)
                assert np.abs((vehicle.TP @ result.f - tau) / vehicle.wrench_scale).max() < 1e-6
                assert excess(vehicle.turning, result.f[None], vehicle.f_min, vehicle.f_max, 0.0).max() < 1e-9
    assert min(solved, infeasible) > 15


def test_scaled_delivers_the_largest_share_where_no_force_has_a_least(tmp_path: Path) -> None:
    rng, partial = np.random.default_rng(6), 0
    for vehicle in vehicles(tmp_path, 16, seed=10):
        if any(not (part.reach >= 0.0).all() for azimuth in vehicle.azimuths for part in azimuth.parts):
            continue
        allocate = build("scaled", vehicle)
        for tau in demands_around(vehicle, rng, 4) * 1.5:
            result, far = allocate(tau), alpha_max(vehicle, [tau])[0]
            assert result.share[0] == pytest.approx(min(far, 1.0), abs=1e-8)
            made = vehicle.TP @ result.f
            assert made / vehicle.wrench_scale == pytest.approx(
                result.share[0] * tau / vehicle.wrench_scale, abs=1e-8
            )
            assert excess(vehicle.turning, result.f[None], vehicle.f_min, vehicle.f_max, 0.0).max() < 1e-9
            partial += result.status is Status.PARTIAL
    assert partial > 5


RING = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [2, 0, 0], azimuth: {max: 100, min: 10}, name: bow}
  - {position: [-2, 0, 0], azimuth: {max: 100, min: 10}, name: stern}
"""


def test_thrusters_that_can_t_be_still_push_against_each_other(tmp_path: Path) -> None:
    file = tmp_path / "ring.yaml"
    file.write_text(RING)
    vehicle = load_vehicle(file)
    for method in ("nullspace", "scaled", "priority", "qp/daqp"):
        result = build(method, vehicle)([0.0, 0.0, 0.0])
        assert result.status is Status.SOLVED
        assert result.forces == pytest.approx([10.0, 10.0], abs=1e-6)
        assert abs(vehicle.T @ result.f).max() < 1e-5
    tau = np.array([300.0, 100.0, 50.0])
    result, far = build("scaled", vehicle)(tau), alpha_max(vehicle, [tau])[0]
    assert 0.95 * far < result.share[0] <= far  # shares count from what is made at rest
    rests = [one.T @ at_rest(one) for one in combinations(vehicle)]
    ends = [rest + result.share[0] * (tau - rest) for rest in rests]
    assert min(np.abs(vehicle.T @ result.f - end).max() for end in ends) < 1e-6


def test_what_is_left_when_the_only_ring_fails_is_what_the_other_thruster_gives(tmp_path: Path) -> None:
    """Its pieces are still in the vehicle, and none of them counts."""
    ring, disc = (tmp_path / name for name in ("ring.yaml", "disc.yaml"))
    for file, least in ((ring, 15), (disc, 0)):
        bow = f"  - {{position: [2, 0, 0], azimuth: {{max: 100, min: {least}}}, name: bow}}"
        stern = "  - {position: [-2, 0, 0], azimuth: {max: 80}}"
        file.write_text("\n".join(["name: boat", "dof: [surge, sway]", "thrusters:", bow, stern]))
    left, expected = (load_vehicle(file).with_fault("bow") for file in (ring, disc))
    taus = [[100.0, 0.0], [40.0, 30.0], [0.0, -80.0]]
    assert alpha_max(left, taus).tolist() == alpha_max(expected, taus).tolist()
    assert label(left, taus).label.tolist() == label(expected, taus).label.tolist()
    assert alpha_max_lp(left, taus[0]) == pytest.approx(0.8)


def test_gaps_between_what_combinations_reach_are_labelled_infeasible(tmp_path: Path) -> None:
    """One ring pushes 10 N at least, so 1 N is beyond what is attainable though 50 N are not."""
    file = tmp_path / "one.yaml"
    file.write_text(
        "name: one\ndof: [surge, sway]\nthrusters:\n  - {position: [0, 0, 0], azimuth: {max: 100, min: 10}}\n"
    )
    vehicle = load_vehicle(file)
    taus = [[1.0, 0.0], [50.0, 0.0], [0.0, -5.0], [0.0, 200.0]]
    assert label(vehicle, taus).label.tolist() == [
        Label.INFEASIBLE,
        Label.INACTIVE,
        Label.INFEASIBLE,
        Label.INFEASIBLE,
    ]
    statuses = build("nullspace", vehicle).many(taus)[1]
    assert statuses.tolist() == [Status.INFEASIBLE, Status.SOLVED, Status.INFEASIBLE, Status.INFEASIBLE]


TWO_WAYS = """\
name: boat
dof: [surge, sway]
thrusters:
  - {position: [0, 0, 0], azimuth: {max: 100, forbidden_deg: [[-30, 30], [150, 210]]}, name: pod}
  - {position: [0, 0, 0], direction: [0, 1, 0]}
f_min: -60
f_max: 60
"""


def test_the_last_piece_stays_until_another_saves_more_than_the_margin(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(TWO_WAYS)
    vehicle = load_vehicle(file)
    allocate = build("nullspace", vehicle)
    up, down = allocate([40.0, 3.0]), allocate([40.0, -3.0])
    assert up.f[1] > 0.0 > down.f[1]
    kept = allocate([40.0, -0.3], f_previous=up.f)
    free = allocate([40.0, -0.3])
    assert kept.f[1] > 0.0 > free.f[1]
    assert free.f @ free.f < kept.f @ kept.f <= (1 + EFFORT_MARGIN) * (free.f @ free.f)
    assert allocate([40.0, -30.0], f_previous=up.f).f[1] < 0.0
    assert allocate([40.0, -0.3], f_previous=[np.nan] * 3).f.tolist() == free.f.tolist()
    turns, last = 0, up
    for sway in 0.3 * np.sin(np.arange(40)):
        now = allocate([40.0, sway], f_previous=last.f)
        turns, last = turns + bool(now.f[1] * last.f[1] < 0.0), now
    alone = [allocate([40.0, sway]).f[1] for sway in 0.3 * np.sin(np.arange(40))]
    assert turns == 0
    assert np.count_nonzero(np.diff(np.sign(alone))) > 10


def test_a_last_force_that_lies_in_several_pieces_binds_to_all_of_them(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(TWO_WAYS)
    vehicle = load_vehicle(file)
    assert list(last_combinations(vehicle, np.zeros(3))) == [0, 1]
    assert len(last_combinations(vehicle, np.array([40.0, 60.0, 0.0]))) == 1


def test_a_piece_that_stays_never_turns_a_demand_that_can_be_met_into_one_that_can_t(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(TWO_WAYS)
    vehicle = load_vehicle(file)
    for method in ("nullspace", "scaled"):
        allocate = build(method, vehicle)
        last = allocate([40.0, 20.0]).f
        assert allocate([80.0, -85.0]).status is Status.SOLVED
        assert allocate([80.0, -85.0], f_previous=last).status is Status.SOLVED
    file.write_text(TWO_WAYS.replace("f_min: -60", "f_min: -49.8"))  # the upper piece delivers a little less
    scaled = build("scaled", load_vehicle(file))
    last = scaled([40.0, 20.0]).f
    kept, free = scaled([140.0, 0.0], f_previous=last), scaled([140.0, 0.0])
    assert free.f[1] < 0.0 < kept.f[1]
    assert free.share[0] - SHARE_MARGIN <= kept.share[0] < free.share[0]


def test_many_is_the_single_calls_and_last_thrusts_of_another_shape_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(TWO_WAYS)
    vehicle = load_vehicle(file)
    taus = demands_around(vehicle, np.random.default_rng(1), 20)
    for method in ("nullspace", "scaled", "priority", "clip", "redistribute", "pinv", "qp/daqp"):
        allocate = build(method, vehicle)
        F, status = allocate.many(taus)
        for tau, f, one in zip(taus, F, status, strict=True):
            result = allocate(tau)
            assert result.status == one
            np.testing.assert_allclose(f, result.f, atol=1e-6)
    for wrong in ([1.0, 2.0], [np.inf, 0.0, 0.0]):
        with pytest.raises(DemandError, match=r"f_previous has shape .*; give \(3,\), finite thrusts"):
            build("nullspace", vehicle)([1.0, 2.0], f_previous=wrong)


def test_of_answers_that_deliver_less_the_one_that_misses_least_is_best(tmp_path: Path) -> None:
    file = tmp_path / "two.yaml"
    file.write_text(TWO_WAYS)
    vehicle = load_vehicle(file)
    tau = np.array([100.0, -10.0])
    answers = [build("clip", one)(tau) for one in combinations(vehicle)]
    missed = [float(np.linalg.norm((vehicle.T @ one.f - tau) / vehicle.wrench_scale)) for one in answers]
    assert missed[0] != pytest.approx(missed[1])
    best = best_answer(vehicle, tau, answers, ())
    assert best.f.tolist() == answers[int(np.argmin(missed))].f.tolist()
    assert build("clip", vehicle)(tau).f.tolist() == best.f.tolist()
