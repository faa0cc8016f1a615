"""Live solvers: what they answer, judged by equations; what they claim is not believed."""

from itertools import product

import numpy as np
import pytest

from alloc import DemandError, SolverError, Status, build, catalogue, load_vehicle
from alloc import solvers as found
from alloc.allocation import FloatArray
from alloc.live import WRENCH_TOLERANCE
from alloc.solvers import Answer

VEHICLE = load_vehicle("ukwial")
CELLS = [
    pytest.param(entry.name, start, level, id=f"{entry.name}-{start}-{level}")
    for entry in catalogue()
    if entry.formulation == "hard" and entry.name.startswith("qp/") and not entry.missing
    for start, level in product(entry.starts, entry.levels)
]


def demands(seed: int, n: int) -> FloatArray:
    """Wrenches of thrusts drawn inside the limits: feasible by construction, active or not."""
    rng = np.random.default_rng(seed)
    return rng.uniform(VEHICLE.f_min, VEHICLE.f_max, (n, VEHICLE.n)) @ VEHICLE.T.T


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_solved_means_wrench_met_inside_the_limits(name: str, start: str, level: str) -> None:
    allocate = build(name, VEHICLE, start=start, level=level)
    solved = 0
    for tau in demands(1, 100):
        f, status, _, _ = allocate(tau)
        assert np.isfinite(f).all() == (status in (Status.SOLVED, Status.PARTIAL))
        if np.isfinite(f).all():
            assert (VEHICLE.f_min <= f).all()
            assert (f <= VEHICLE.f_max).all()
        if status == Status.SOLVED:
            assert (np.abs(VEHICLE.T @ f - tau) <= WRENCH_TOLERANCE * VEHICLE.wrench_scale * 1.001).all()
            solved += 1
    if level == "tight":
        assert solved == 100


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_a_demand_just_outside_the_attainable_set_is_never_solved(name: str, start: str, level: str) -> None:
    """0.01 N beyond the largest surge: 4 * 250 N * cos 29 deg."""
    allocate = build(name, VEHICLE, start=start, level=level)
    most = 4 * 250 * np.cos(np.radians(29))
    for _ in range(3):
        assert allocate([most + 0.01, 0, 0]).status != Status.SOLVED
        assert allocate([5 * most, 0, 0]).status in (Status.INFEASIBLE, Status.NOT_CONVERGED)


@pytest.mark.parametrize(("name", "start", "level"), CELLS)
def test_answers_are_fresh_arrays_and_the_demand_is_left_alone(name: str, start: str, level: str) -> None:
    allocate = build(name, VEHICLE, start=start, level=level)
    tau, other = demands(2, 2)
    kept = tau.copy()
    first = allocate(tau).f
    before = first.copy()
    allocate(other)
    assert np.array_equal(first, before)
    assert np.array_equal(tau, kept)


def test_a_flag_nobody_mapped_raises_and_names_the_file() -> None:
    with pytest.raises(SolverError, match=r"alloc/solvers/daqp\.py"):
        found.meaning({1: Status.SOLVED}, 77, "daqp")


@pytest.mark.parametrize(("miss", "status"), [(0, 0), (1e-5, 1), (0.1, 3), (np.nan, 3)])
def test_a_solver_that_claims_too_much_is_found_out(miss: float, status: Status) -> None:
    """A liar in the solver's place: its x is the right one plus a miss, its word always SOLVED."""
    allocate = build("qp/daqp", VEHICLE, level="tight")
    honest = allocate.solve  # type: ignore[attr-defined]  # Live's half, not part of the protocol
    one = np.array([miss, 0, 0, 0])
    allocate.solve = lambda b: Answer(honest(b).x + one, Status.SOLVED)  # type: ignore[attr-defined]
    f, said, _, _ = allocate([10.0, 5.0, 1.0])
    assert said == status
    assert np.isnan(f).all() == (status == Status.NOT_CONVERGED)


def test_bad_demands_never_reach_a_solver() -> None:
    allocate = build("qp/daqp", VEHICLE)
    for tau in ([1.0, 2.0], [np.nan, 0, 0], [np.inf, 0, 0]):
        with pytest.raises(DemandError):
            allocate(tau)
