"""Generated C, compiled and run as it would be on a vehicle, and as an allocator in Python."""

import ctypes
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import (
    NotApplicable,
    Status,
    UnknownName,
    Vehicle,
    build,
    list_vehicles,
    load_vehicle,
)
from alloc.native import RECIPES, compiled, function_name, generate, missing
from tests.nullspace_cases import SHAPES, demands_of_known_verdict, random_vehicle

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"]
SANITIZE = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
REFUSED = 2
UNKNOWN_FAULT = -1


def files_of(vehicle: Vehicle, kernel: str, scalar: str) -> dict[str, str]:
    try:
        return generate(vehicle, kernel, scalar)
    except NotApplicable as reason:
        pytest.skip(f"{kernel} refuses {vehicle.name}: {reason}")


def compile_in(folder: Path, files: dict[str, str], *flags: str) -> Path:
    """The object or program made of the files with every warning an error."""
    for name, text in files.items():
        (folder / name).write_text(text)
    units = [name for name in files if name.endswith(".c")]
    command = [*compiled.compiler(), *STRICT, *flags, *units, "-o", "made"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "made"


def run(program: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(program)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("kernel", RECIPES)
def test_generated_c_is_clean_and_agrees_with_python_for_every_fault(
    vehicle, kernel, scalar, tmp_path
) -> None:
    """The self-test holds double to 1e-12 and float to 1e-5 of the largest limit; UBSan watches."""
    files = files_of(vehicle, kernel, scalar)
    done = run(compile_in(tmp_path, files, *SANITIZE))
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{24 * (vehicle.n + 1)} cases, 0 wrong" in done.stdout


def test_the_self_test_notices_a_wrong_constant(tmp_path) -> None:
    files = files_of(load_vehicle("ukwial"), "nullspace", "double")
    source = files["ukwial_nullspace.c"]
    line = next(line for line in source.splitlines() if "= c[0] * t0" in line)
    files["ukwial_nullspace.c"] = source.replace(line, line.replace("c[0] *", "1.0000001 * c[0] *"), 1)
    done = run(compile_in(tmp_path, files))
    assert done.returncode == 1
    assert "fault -1" in done.stdout


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm (Debian: apt install binutils) lists symbols")
@pytest.mark.parametrize("kernel", RECIPES)
def test_generated_code_calls_no_library_and_keeps_no_state(kernel, tmp_path) -> None:
    """No undefined symbol: no library, no heap. No writable symbol: no state between calls."""
    files = files_of(load_vehicle("bluerov2-heavy"), kernel, "double")
    kept = {name: text for name, text in files.items() if not name.endswith("_test.c")}
    made = compile_in(tmp_path, kept, "-O2", "-c")
    symbols = subprocess.run(["nm", str(made)], capture_output=True, text=True, check=True).stdout.split("\n")
    kinds = {line.split()[-2] for line in symbols if line}
    assert kinds <= {"T", "t", "r"}  # code and constants


def kernel_of(vehicle: Vehicle, folder: Path, scalar: str = "double"):
    """The compiled nullspace kernel as a Python function (tau, fault) -> (status, f)."""
    files = generate(vehicle, "nullspace", scalar)
    kept = {name: text for name, text in files.items() if not name.endswith("_test.c")}
    library = ctypes.CDLL(str(compile_in(folder, kept, "-O2", "-fPIC", "-shared")))
    solve = library[function_name(vehicle, "nullspace", scalar)]
    dtype = np.float64 if scalar == "double" else np.float32

    def call(tau: np.ndarray, fault: int = -1) -> tuple[int, np.ndarray]:
        given, f = np.asarray(tau, dtype), np.full(vehicle.n, 7.0, dtype)
        status = solve(given.ctypes.data_as(ctypes.c_void_p), fault, f.ctypes.data_as(ctypes.c_void_p))
        return status, f

    return call


def test_the_kernel_answers_for_the_failed_thruster_that_is_its_argument(tmp_path) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    solve = kernel_of(vehicle, tmp_path)
    rng = np.random.default_rng(1)
    for fault in range(vehicle.n):
        degraded = vehicle.with_fault(fault)
        allocate = build("nullspace", degraded)
        for f in rng.uniform(degraded.f_min, degraded.f_max, (50, vehicle.n)):
            status, f_native = solve(degraded.T @ f, fault)
            assert status == Status.SOLVED
            assert f_native[fault] == 0.0
            expected = allocate(degraded.T @ f).f
            np.testing.assert_allclose(f_native, expected, rtol=0, atol=1e-12 * vehicle.f_scale)


def test_a_refused_demand_or_fault_leaves_f_alone(vehicle: Vehicle, tmp_path) -> None:
    solve = kernel_of(vehicle, tmp_path)
    huge = 1.7e308 * np.where(np.arange(vehicle.k) % 2, 1.0, -1.0)
    for value in (np.nan, np.inf, -np.inf, 1e300):
        for axis in range(vehicle.k):
            tau = np.zeros(vehicle.k)
            tau[axis] = value
            status, f = solve(tau)
            assert status == REFUSED
            assert (f == 7.0).all()
    assert solve(huge)[0] == REFUSED
    for fault in (-2, vehicle.n, 1000):
        status, f = solve(np.zeros(vehicle.k), fault)
        assert status == UNKNOWN_FAULT
        assert (f == 7.0).all()


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s[0]}x{s[1]}")
def test_native_and_python_agree_on_random_vehicles_of_every_nullity(shape) -> None:
    rng = np.random.default_rng(2)
    for diagonal in (True, False):
        vehicle = random_vehicle(*shape, rng, diagonal)
        taus = demands_of_known_verdict(vehicle, 600, rng).taus
        F, status = build("nullspace", vehicle).many(taus)
        native_F, native_status = build("nullspace@native", vehicle).many(taus)
        np.testing.assert_array_equal(native_status, status)
        interior = np.arange(len(taus)) % 6 == 0  # at the boundary rounding of tau moves f further
        np.testing.assert_allclose(native_F[interior], F[interior], rtol=0, atol=1e-12 * vehicle.f_scale)
        np.testing.assert_allclose(native_F, F, rtol=0, atol=1e-8 * vehicle.f_scale)
        assert not (native_F < vehicle.f_min).any()  # not by one ulp; NaN compares false
        assert not (native_F > vehicle.f_max).any()


def test_a_bound_kernel_promises_what_python_promises() -> None:
    vehicle = load_vehicle("supply-vessel")
    for kernel in ("pinv", "nullspace"):
        python, native = build(kernel, vehicle), build(f"{kernel}@native", vehicle)
        for promise in ("formulation", "limited", "tolerance"):
            assert getattr(native, promise) == getattr(python, promise)
    assert native.worst_case_steps == python.worst_case_steps


def test_the_binding_keeps_no_reference_to_its_arguments() -> None:
    vehicle = load_vehicle("ukwial")
    allocate = build("nullspace@native", vehicle)
    tau, listed = np.zeros(3), [0.0, 0.0, 0.0]
    before = sys.getrefcount(tau), sys.getrefcount(listed), sys.getrefcount(Status.SOLVED)
    for _ in range(1000):
        allocate(tau)
        allocate(listed)
        allocate.many([tau])
        with pytest.raises(TypeError, match="one argument"):
            allocate(tau, tau)
    after = sys.getrefcount(tau), sys.getrefcount(listed), sys.getrefcount(Status.SOLVED)
    assert after == before


def test_an_unknown_kernel_is_refused_with_the_names_of_all_kernels() -> None:
    with pytest.raises(UnknownName, match="nullspace"):
        generate(load_vehicle("ukwial"), "svd")


def test_a_block_too_large_to_write_out_is_refused_with_the_reason() -> None:
    with pytest.raises(NotApplicable, match="written out"):
        generate(random_vehicle(3, 10, np.random.default_rng(3)), "nullspace")


def test_a_vehicle_name_with_any_characters_gives_valid_c(tmp_path) -> None:
    vehicle = replace(load_vehicle("ukwial"), name='7 Weiße */ "Flotte"\n\\')
    files = generate(vehicle, "nullspace")
    assert all(name.isascii() for name in files)
    assert run(compile_in(tmp_path, files)).returncode == 0


def test_a_thruster_that_pushes_no_controlled_axis_gets_the_thrust_nearest_zero(tmp_path) -> None:
    """A heave thruster where only the plane is controlled: its column of T is zero."""
    plane = load_vehicle("ukwial")
    T = np.hstack([plane.T, np.zeros((3, 2))])
    f_min, f_max = np.append(plane.f_min, [-10, 5]), np.append(plane.f_max, [10, 20])
    vehicle = Vehicle(
        name="idle",
        dof=plane.dof,
        T=T,
        H=np.eye(6),
        f_min=f_min,
        f_max=f_max,
        readiness=np.ones(6),
        slack_weights=np.ones(3),
    )
    tau = plane.T @ [100, 100, -100, -50]
    for method in ("nullspace", "nullspace@native"):
        np.testing.assert_array_equal(build(method, vehicle)(tau).f[4:], [0, 5])
    assert run(compile_in(tmp_path, generate(vehicle, "nullspace"))).returncode == 0


def test_the_same_vehicle_gives_the_same_text() -> None:
    for name in list_vehicles():
        vehicle = load_vehicle(name)
        assert generate(vehicle, "nullspace") == generate(vehicle, "nullspace")
