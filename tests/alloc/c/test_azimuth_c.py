"""C of the exact answer where thrusters turn, against linear programs, multipliers and Python."""

import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, alpha_max, build, generate, load_vehicle
from alloc.allocation import EXACT_TOLERANCE
from alloc.c.compiled import missing
from alloc.c.selftest import SIDES
from alloc.errors import DemandError
from alloc.kernels.tolerance import WRENCH_ERROR
from alloc.methods import recipe
from alloc.program import Scalar
from alloc.program.evaluate import evaluate
from alloc.vehicle.azimuth import Azimuth
from tests.azimuths import boats, corners_lp, demands_around, excess, stationarity

compiles = pytest.mark.skipif(bool(missing()), reason=missing())
BOATS = boats(64, most=2)
FEW = 300
"""Steps up to which C is compiled in a second."""
SHARES = (0.02, 0.6, 0.97, 1.0 - 1e-6, 1.0 - 1e-12, 1.0 + 1e-12, 1.0 + 1e-6, 1.02, 3.0)
"""Shares of alpha* that are asked for: inside, at the edge within rounding, beyond it."""
EDGE: dict[Scalar, float] = {"double": 1e-9, "float": 1e-4}
"""Distance of a share from 1 up to which either verdict is right [-]."""


@cache
def covered(scalar: Scalar) -> list[Vehicle]:
    """Boats with C that few steps take, six of each number of dimensions."""
    taken: dict[int, list[Vehicle]] = {d: [] for d in range(4)}
    for vehicle in BOATS:
        if len(taken.get(vehicle.nullity, BOATS)) >= 6:
            continue
        try:
            if build("nullspace", vehicle).worst_case_steps < FEW:
                recipe("nullspace").program(vehicle, scalar=scalar)
                taken[vehicle.nullity].append(vehicle)
        except NotApplicable:
            continue
    return sorted((vehicle for each in taken.values() for vehicle in each), key=lambda one: one.nullity)


def asked(vehicle: Vehicle, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Demands (N, k), and by how much each could be larger (N,)."""
    taus = demands_around(vehicle, rng, 4)
    edge = alpha_max(vehicle, taus)
    pairs = [
        (s * far * tau, 1.0 / s) for tau, far in zip(taus, edge, strict=True) if far > 1e-6 for s in SHARES
    ]
    return np.array([tau for tau, _ in pairs]).reshape(-1, vehicle.k), np.array([alpha for _, alpha in pairs])


@pytest.mark.parametrize("scalar", ["double", "float"])
def test_a_program_answers_what_can_be_met_within_polygons_at_least_effort(scalar: Scalar) -> None:
    """Steps up to the very sides left forces outside of them by rounding."""
    rng, seen = np.random.default_rng(21), set[int]()
    for vehicle in covered(scalar):
        taus, alpha = asked(vehicle, rng)
        found = evaluate(recipe("nullspace").program(vehicle, scalar=scalar), taus)
        solved = found.status == Status.SOLVED
        clear = np.abs(alpha - 1.0) > EDGE[scalar]
        assert (solved == (alpha > 1.0))[clear].all()
        assert set(found.status.tolist()) <= {Status.SOLVED, Status.INFEASIBLE}
        missed = (found.F @ vehicle.TP.T - taus) / vehicle.wrench_scale
        assert np.abs(missed[solved]).max(initial=0.0) <= WRENCH_ERROR[scalar]
        for f, least in zip(found.F[solved], alpha[solved], strict=True):
            assert excess(vehicle, f) <= SIDES[scalar]
            if scalar == "double" and least >= 1.0:
                assert stationarity(vehicle, f) <= 1e-6
        seen.add(vehicle.nullity)
        for tau, share in zip(taus[::9], alpha[::9], strict=True):
            assert corners_lp(vehicle, tau) == pytest.approx(share, rel=1e-8)
    assert seen >= {0, 1, 2}


@compiles
def test_compiled_c_gives_the_answers_of_python_and_of_a_qp_solver() -> None:
    rng, compared = np.random.default_rng(22), 0
    for vehicle in covered("double")[::2]:
        native, python, solver = (
            build(name, vehicle) for name in ("nullspace@native", "nullspace", "qp/daqp")
        )
        taus, alpha = asked(vehicle, rng)
        F, status = native.many(taus)
        for tau, share, f, given in zip(taus, alpha, F, status, strict=True):
            one, other = native(tau), python(tau)
            assert one.status == given
            assert one.f == pytest.approx(f, rel=0, abs=1e-12 * vehicle.f_scale, nan_ok=True)
            if abs(share - 1.0) <= EDGE["double"]:
                continue
            assert one.status == other.status
            assert one.f == pytest.approx(other.f, rel=0, abs=1e-9 * vehicle.f_scale, nan_ok=True)
            assert one.forces == pytest.approx(other.forces, rel=0, abs=1e-9 * vehicle.f_scale, nan_ok=True)
            if share > 1.01:
                compared += 1
                assert one.f == pytest.approx(solver(tau).f, rel=0, abs=1e-4 * vehicle.f_scale)
    assert compared > 60


@compiles
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("name", ["double-ended-ferry", "sector"])
def test_the_self_test_passes_and_fails_for_c_of_another_polygon(
    name: str, scalar: Scalar, tmp_path: Path
) -> None:
    vehicle = load_vehicle(name) if name != "sector" else next(v for v in covered(scalar) if v.nullity == 2)
    files = generate(vehicle, "nullspace", scalar=scalar)
    assert run_selftest(files, tmp_path / "own") == 0
    larger = [Azimuth(one.first, 1.001 * one.corners) for one in vehicle.azimuths]
    other = generate(replace(vehicle, azimuths=tuple(larger)), "nullspace", scalar=scalar)
    kept = {name: text for name, text in files.items() if name.startswith("test/")}
    assert run_selftest(other | kept, tmp_path / "other") == 1


def run_selftest(files: dict[str, str], folder: Path) -> int:
    (folder / "test").mkdir(parents=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    sources = [name for name in files if name.endswith(".c")]
    line = ["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off", "-I.", *sources]
    subprocess.run([*line, "-lm", "-o", "selftest"], cwd=folder, check=True)
    return subprocess.run(["./selftest"], cwd=folder, check=False, capture_output=True).returncode


def test_a_header_says_thruster_and_axis_of_each_component_and_counts_failures_by_thruster() -> None:
    files = generate(load_vehicle("double-ended-ferry"), "nullspace")
    header, source = (files[f"double_ended_ferry_nullspace.{end}"] for end in "hc")
    for i, said in enumerate(("bow along x", "bow along y", "stern along x", "stern along y")):
        assert f"f[{i}] {said}\n" in header
    assert "case 1:" in source
    assert "case 2:" not in source


def test_thrusts_that_miss_the_wrench_once_they_are_moved_inside_are_no_answer() -> None:
    """Demands beyond the edge by up to what counts as touching: each is refused, or makes its wrench."""
    rng, solved = np.random.default_rng(23), 0
    for vehicle in covered("double"):
        taus = demands_around(vehicle, rng, 8)
        far = alpha_max(vehicle, taus)
        taus = ((1.0 + 10.0 ** rng.uniform(-13, -8, 8)) * far)[:, None] * taus
        found = evaluate(recipe("nullspace").program(vehicle), taus)
        good = found.status == Status.SOLVED
        solved += good.sum()
        missed = np.abs((found.F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
        assert (missed[good] <= EXACT_TOLERANCE).all()
        assert all(excess(vehicle, f) <= SIDES["double"] for f in found.F[good])
    assert solved > 20


@compiles
def test_compiled_c_says_forces_and_angles_of_fixed_and_turning_thrusters_itself() -> None:
    """Python had worked them out behind each call, for five times what that took."""
    plain = next(vehicle for vehicle in covered("double") if len(vehicle.azimuths) < len(vehicle.actuators))
    turns = Azimuth(plain.azimuths[0].first, np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]]))
    vehicle = replace(plain, azimuths=(turns, *plain.azimuths[1:]))
    native, python = build("nullspace@native", vehicle), build("nullspace", vehicle)
    rng = np.random.default_rng(24)
    within = np.zeros((20, vehicle.n))
    within[:, turns.components] = rng.dirichlet(np.ones(3), 20) @ turns.corners
    for f in (*within, np.zeros(vehicle.n), np.full(vehicle.n, 1e4)):
        tau = vehicle.TP @ f
        given, other = native(tau, f_previous=f), python(tau, f_previous=f)  # type: ignore[call-arg]
        assert given.status == other.status
        for key in ("forces", "angles", "middles"):
            assert getattr(given, key) == pytest.approx(getattr(other, key), abs=1e-5, nan_ok=True), key
    with pytest.raises(DemandError, match="f_previous has shape"):
        native(np.zeros(3), f_previous=[1.0])  # type: ignore[call-arg]
