"""The exact method, held against equations, constructed demands and two independent solvers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc.nullspace.structure import decompose, split
from tests.nullspace_cases import (
    AXES,
    SHAPES,
    demands_of_known_verdict,
    face_thrusts,
    random_vehicle,
    vertex_thrusts,
)

PER_SHAPE = 20_000 // len(SHAPES) + 1
VEHICLES_PER_SHAPE = 20
EXACT = 1e-9
"""The method's promise, relative to the largest limit [-]."""


@pytest.fixture(params=SHAPES, ids=lambda s: f"{s[0]}x{s[1]}")
def shape(request: pytest.FixtureRequest) -> tuple[int, int]:
    k_n: tuple[int, int] = request.param
    return k_n


def daqp_answer(vehicle: Vehicle, tau: np.ndarray) -> np.ndarray | None:
    import daqp

    n, s = vehicle.n, vehicle.f_scale
    upper = np.concatenate([vehicle.f_max, tau]) / s
    lower = np.concatenate([vehicle.f_min, tau]) / s
    equality = np.array([0] * n + [5] * vehicle.k, dtype=np.int32)
    # DAQP's default lets a limit be broken by 1e-6, which is EDGE.
    x, _, flag, _ = daqp.solve(
        vehicle.H.copy(), np.zeros(n), vehicle.T.copy(), upper, lower, equality, primal_tol=1e-11
    )
    return np.asarray(x) * s if flag > 0 else None


def quadprog_answer(vehicle: Vehicle, tau: np.ndarray) -> np.ndarray | None:
    quadprog = pytest.importorskip("quadprog", reason="GPL: measured only where somebody installs it")
    eye, s = np.eye(vehicle.n), vehicle.f_scale
    rows = np.vstack([vehicle.T, eye, -eye]).T
    bounds = np.concatenate([tau, vehicle.f_min, -vehicle.f_max]) / s
    try:
        x = quadprog.solve_qp(vehicle.H.copy(), np.zeros(vehicle.n), rows, bounds, vehicle.k)[0]
    except ValueError as error:
        if "inconsistent" in str(error):  # quadprog's word for infeasible
            return None
        raise
    return np.asarray(x) * s


@pytest.mark.parametrize("solve", [daqp_answer, quadprog_answer], ids=["daqp", "quadprog"])
def test_solvers_and_construction_give_the_same_verdict_and_the_same_thrusts(solve, shape) -> None:
    rng = np.random.default_rng(5)
    for index in range(VEHICLES_PER_SHAPE):
        vehicle = random_vehicle(*shape, rng, diagonal=index % 2 == 0)
        demands = demands_of_known_verdict(vehicle, PER_SHAPE // VEHICLES_PER_SHAPE + 1, rng)
        F, status = build("nullspace", vehicle).many(demands.taus)
        np.testing.assert_array_equal(status == Status.SOLVED, demands.attainable)
        for i, (tau, f) in enumerate(zip(demands.taus, F, strict=True)):
            answer = solve(vehicle, tau)
            # Exactly on the boundary quadprog, which has no tolerance, sometimes says inconsistent.
            assert (answer is not None) == demands.attainable[i] or (
                solve is quadprog_answer and i % 6 in (1, 2)
            )
            if answer is not None:
                assert np.abs(answer - f).max() <= EXACT * vehicle.f_scale


def test_a_demand_on_the_boundary_gets_the_only_thrust_that_makes_it(shape) -> None:
    rng = np.random.default_rng(6)
    for _ in range(50):
        vehicle = random_vehicle(*shape, rng)
        allocate = build("nullspace", vehicle)
        for f in (face_thrusts(vehicle, rng), vertex_thrusts(vehicle, rng)):
            answer = allocate(vehicle.T @ f)
            assert answer.status is Status.SOLVED
            # Rounding of tau moves f by up to 1e-16 times the condition number of the free columns of T.
            np.testing.assert_allclose(answer.f, f, rtol=0, atol=1e-7 * vehicle.f_scale)


def test_the_wrench_is_met_and_no_limit_exceeded_by_one_ulp(shape) -> None:
    rng = np.random.default_rng(7)
    for _ in range(20):
        vehicle = random_vehicle(*shape, rng)
        demands = demands_of_known_verdict(vehicle, 60, rng)
        F, status = build("nullspace", vehicle).many(demands.taus)
        solved = status == Status.SOLVED
        assert (F[solved] >= vehicle.f_min).all()
        assert (F[solved] <= vehicle.f_max).all()
        error = np.abs(F[solved] @ vehicle.T.T - demands.taus[solved]) / vehicle.wrench_scale
        assert error.max() <= EXACT * np.sqrt(vehicle.n)  # each thrust may be moved by EXACT onto its limit
        assert np.isnan(F[~solved]).all()


@given(seed=st.integers(0, 2**32 - 1), shape=st.sampled_from(SHAPES), diagonal=st.booleans())
@settings(max_examples=150, deadline=None)
def test_no_other_thrust_makes_the_same_wrench_with_less_effort(seed, shape, diagonal) -> None:
    rng = np.random.default_rng(seed)
    vehicle = random_vehicle(*shape, rng, diagonal)
    other = rng.uniform(vehicle.f_min, vehicle.f_max)
    f, status, *_ = build("nullspace", vehicle)(vehicle.T @ other)
    assert status is Status.SOLVED
    assert f @ vehicle.H @ f <= other @ vehicle.H @ other * (1 + 1e-9)  # rounding of either side


def test_single_calls_and_many_give_the_same_answers(shape) -> None:
    rng = np.random.default_rng(8)
    vehicle = random_vehicle(*shape, rng)
    allocate = build("nullspace", vehicle)
    taus = demands_of_known_verdict(vehicle, 120, rng).taus
    F, status = allocate.many(taus)
    for tau, f, s in zip(taus, F, status, strict=True):
        single = allocate(tau)
        assert single.status == s
        assert not (single.f < vehicle.f_min).any()  # NaN is neither below nor above
        assert not (single.f > vehicle.f_max).any()
        np.testing.assert_allclose(single.f, f, rtol=0, atol=1e-11 * vehicle.f_scale)  # sums in another order


def test_no_demand_takes_more_steps_than_the_worst_case(vehicle: Vehicle) -> None:
    rng = np.random.default_rng(9)
    allocate = build("nullspace", vehicle)
    thrusts = rng.uniform(vehicle.f_min, vehicle.f_max, (2000, vehicle.n)) * rng.uniform(0.2, 2, (2000, 1))
    steps = [allocate(tau).iterations for tau in thrusts @ vehicle.T.T]
    assert max(steps) <= allocate.worst_case_steps
    if all(block.N.shape[1] == 1 for block in decompose(vehicle).blocks):
        assert max(steps) == allocate.worst_case_steps  # some demand reaches the bound


@pytest.mark.parametrize(
    ("shape", "bound"),
    [((3, 4), 4 + 4), ((2, 4), 4 + 2 * 4 + 6), ((3, 6), 6 + 2 * (6 + 15) + 20)],
    ids=["d = 1", "d = 2", "d = 3"],
)
def test_the_worst_case_is_the_formula_in_the_documents(shape, bound) -> None:
    """n + C(n, d) + 2 (C(n, 1) + … + C(n, d - 1)) where no two rows of N are parallel."""
    allocate = build("nullspace", random_vehicle(*shape, np.random.default_rng(10)))
    assert allocate.worst_case_steps == bound


@pytest.mark.parametrize(
    ("name", "blocks"),
    [("ukwial", [1]), ("bluerov2-heavy", [1, 1]), ("nautilus", [1, 1]), ("supply-vessel", [3])],
)
def test_each_vehicle_falls_into_its_independent_blocks(name: str, blocks: list[int]) -> None:
    vehicle = load_vehicle(name)
    structure = decompose(vehicle)
    assert [block.N.shape[1] for block in structure.blocks] == blocks
    N = np.zeros((vehicle.n, sum(blocks)))
    for i, block in enumerate(structure.blocks):
        start = sum(blocks[:i])
        N[block.rows, start : start + blocks[i]] = block.N
    np.testing.assert_allclose(vehicle.T @ N, 0, atol=1e-12)
    np.testing.assert_allclose(N.T @ vehicle.H @ N, np.eye(sum(blocks)), atol=1e-12)


@pytest.mark.parametrize(
    ("coupled", "blocks"),
    [([], [[0], [1], [2], [3]]), ([(0, 2)], [[0, 2], [1], [3]]), ([(0, 3), (2, 3)], [[0, 2, 3], [1]])],
    ids=["nothing", "one pair", "a chain"],
)
def test_linked_columns_are_one_block_and_blocks_stand_in_order_of_first_column(
    coupled: list[tuple[int, int]], blocks: list[list[int]]
) -> None:
    H = np.eye(4)
    for i, j in coupled:
        H[i, j] = H[j, i] = 0.3
    assert [sorted(block.rows.tolist()) for block in split(np.eye(4), H, np.zeros((1, 4)))] == blocks


def test_a_thruster_that_the_null_space_moves_by_rounding_only_belongs_to_no_block() -> None:
    """Its limits are looked at where z moves nothing; no step and no line of C could."""
    (block,) = split(
        np.array([[1.0], [1e-13], [-1.0]]), np.eye(3), np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    )
    assert sorted(block.rows.tolist()) == [0, 2]


def test_columns_that_share_thrusters_stay_together_even_where_their_cost_does_not_couple_them() -> None:
    T = np.array([[1.0, 1.0, -1.0, 0.0], [1.0, -1.0, 0.0, -1.0]])
    vehicle = Vehicle(
        name="shared",
        dof=AXES[:2],
        T=T,
        H=np.eye(4),
        f_min=-np.ones(4),
        f_max=np.ones(4),
        readiness=np.ones(4),
        slack_weights=np.ones(2),
    )
    shared = np.array([[1.0, 0.0, 1.0, 1.0], [0.0, 1.0, 1.0, -1.0]])  # null space, orthogonal
    np.testing.assert_array_equal(shared @ T.T, 0)
    np.testing.assert_array_equal(shared @ shared.T, 3 * np.eye(2))
    assert [block.N.shape for block in decompose(vehicle).blocks] == [(4, 2)]


def test_a_cost_that_couples_two_blocks_joins_them() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    H = np.eye(vehicle.n)
    first, second = (block.rows[0] for block in decompose(vehicle).blocks)
    H[first, second] = H[second, first] = 0.3
    assert [block.N.shape[1] for block in decompose(replace(vehicle, H=H)).blocks] == [2]


def test_a_wrench_that_no_thruster_pushes_is_infeasible() -> None:
    vehicle = load_vehicle("ukwial").with_fault(0).with_fault(1)
    allocate = build("nullspace", vehicle)
    reachable = vehicle.TP @ np.array([0, 0, 20.0, -30.0])
    lost = np.linalg.svd(vehicle.TP)[0][:, -1]
    assert allocate(reachable).status is Status.SOLVED
    assert allocate(reachable + 1e-3 * lost).status is Status.INFEASIBLE
    assert allocate.many([reachable, reachable + 1e-3 * lost])[1].tolist() == [0, 2]


def test_a_demand_that_needs_all_of_a_weakened_thruster_is_met(vehicle: Vehicle) -> None:
    weak = vehicle.with_fault(0, readiness=0.4)
    tau = weak.T @ (weak.readiness * weak.f_max)
    f, status, *_ = build("nullspace", weak)(tau)
    assert status is Status.SOLVED
    np.testing.assert_allclose(weak.TP @ f, tau, atol=EXACT * weak.wrench_scale.max())


@pytest.mark.parametrize("size", [1e30, 1e100])
def test_the_largest_demand_is_infeasible(vehicle: Vehicle, size: float) -> None:
    allocate = build("nullspace", vehicle)
    signs = np.sign(vehicle.T.sum(axis=1)) + (vehicle.T.sum(axis=1) == 0)
    for tau in (np.full(vehicle.k, size), size * signs):
        assert allocate(tau).status is Status.INFEASIBLE
        assert allocate.many([tau])[1].tolist() == [Status.INFEASIBLE]


def test_a_null_space_of_too_many_steps_is_refused_with_the_reason() -> None:
    vehicle = random_vehicle(3, 16, np.random.default_rng(11))
    with pytest.raises(NotApplicable, match="13-dimensional null space"):
        build("nullspace", vehicle)
