"""Generated C, compiled and run as it would be on a vehicle, and as an allocator in Python."""

import ctypes
import re
import shutil
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, load_vehicle
from alloc import generate as files_of
from alloc.c import Target, function_name, missing, page, selftest
from alloc.c import sources as sources_of
from alloc.c.statements import STATUSES
from alloc.errors import DemandError, UnknownName
from alloc.methods import recipe, recipes
from alloc.program import Faults, Scalar, Where
from alloc.vehicle.weak import Survey
from bench.demands import build_demands
from bench.demands.generated import generate_vehicle, numbered
from bench.demands.surveys import move_poses
from tests.compilers import build_program, run
from tests.nullspace_cases import SHAPES, demands_of_known_verdict, random_vehicle
from tests.places import DOCS
from tests.vehicles import made_up, with_autopilot

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

SANITIZE = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
REFUSED = 2
UNKNOWN_FAULT = -1
NOT_FINITE = -2
EVERYWHERE = ("nullspace", pytest.param("priority", marks=pytest.mark.long))
"""Kernels that are compiled for every vehicle here; ``docs/studies/native_selftests.py`` does so with all."""
SMALL = "ukwial"
KERNELS = tuple(recipes())
LIMITED = tuple(name for name, each in recipes().items() if each.limited)


def small() -> Vehicle:
    """The smallest vehicle, which no method refuses."""
    return with_autopilot(load_vehicle(SMALL))


def generate(
    vehicle: Vehicle, method: str, scalar: Scalar = "double", limits: Where = "fixed", faults: Faults = "one"
) -> dict[str, str]:
    """The C files of a method, without the page on them."""
    made = files_of(vehicle, method, scalar=scalar, limits=limits, faults=faults)
    return {name: text for name, text in made.items() if not name.endswith(".md")}


def run_program(program: Path) -> subprocess.CompletedProcess[str]:
    return run([str(program)], program.parent)


def check_itself(
    vehicle: Vehicle, kernel: str, scalar: Scalar, limits: Where, folder: Path, faults: Faults = "one"
) -> None:
    """Compile the kernel with its self-test, UBSan watching; run it, and see that it asked enough."""
    done = run_program(build_program(folder, generate(vehicle, kernel, scalar, limits, faults), *SANITIZE))
    assert done.returncode == 0, done.stdout + done.stderr
    asked = re.search(r"(\d+) cases, (\d+) asked.*; 0 wrong", done.stdout)
    assert asked
    assert int(asked[1]) >= 24 * (vehicle.n + 1)
    assert int(asked[2]) > 20 * (vehicle.n + 1)  # rounding decides the others


@pytest.mark.parametrize("kernel", ["nullspace", "scaled"])
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("undecided", [False, True])
def test_a_self_test_is_red_of_thrusts_two_per_cent_off_whatever_bound_was_derived(
    kernel: str, scalar: Scalar, undecided: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cases = selftest.cases

    def anything_goes(*args: Any) -> selftest.Cases:
        found = cases(*args)
        every = np.ones(len(found.taus))
        return replace(found, allowed=1e9 * every, undecided=every > 1.0 - undecided)

    monkeypatch.setattr(selftest, "cases", anything_goes)
    files = generate(small(), kernel, scalar)
    factor = "1.02F" if scalar == "float" else "1.02"
    broken = {
        name: re.sub(r"f\[0\] = (\w+);", rf"f[0] = \1 * {factor};", text) for name, text in files.items()
    }
    assert broken != files
    assert run_program(build_program(tmp_path, broken)).returncode == 1


@pytest.mark.parametrize(
    ("scalar", "limits"),
    [
        ("double", "call"),
        ("float", "fixed"),
        pytest.param("double", "fixed", marks=pytest.mark.long),
        pytest.param("float", "call", marks=pytest.mark.long),
    ],
)
@pytest.mark.parametrize("kernel", KERNELS)
def test_generated_c_is_clean_and_agrees_with_python_for_every_fault(
    kernel, scalar, limits, tmp_path
) -> None:
    """The self-test holds double to 1e-12 and float to 1e-5 of the largest limit, and what rounding adds."""
    check_itself(small(), kernel, scalar, limits, tmp_path)


@pytest.mark.parametrize(
    ("name", "limits"),
    [
        ("bluerov2", "fixed"),
        ("tiburon", "call"),
        pytest.param("bluerov2", "call", marks=pytest.mark.long),
        pytest.param("tiburon", "fixed", marks=pytest.mark.long),
    ],
)
@pytest.mark.parametrize("kernel", [name for name, each in recipes().items() if each.make_for_all])
def test_one_function_for_all_faults_agrees_with_python_for_each(kernel, name, limits, tmp_path) -> None:
    """Faults that lose a direction are among them; of several levels these have code of their own."""
    check_itself(load_vehicle(name), kernel, "float", limits, tmp_path, "all")


@pytest.mark.parametrize(
    ("kernel", "scalar", "limits"), [("scaled", "float", "call"), ("priority", "double", "fixed")]
)
@pytest.mark.parametrize("name", [str(DOCS / "vehicles/bluerov2-surveyed.yaml"), "bluerov2"])
def test_c_of_a_surveyed_vehicle_leaves_out_what_each_fault_leaves_weak(
    kernel: str, scalar: Scalar, limits: Where, name: str, tmp_path: Path
) -> None:
    vehicle = move_poses(load_vehicle(name), Survey(), np.random.default_rng(2))
    assert any(vehicle.with_fault(i).weak_left.any() for i in range(vehicle.n))
    check_itself(vehicle, kernel, scalar, limits, tmp_path, "all")


@pytest.mark.parametrize("kernel", ["scaled", "nullspace"])
def test_a_thruster_that_could_not_rest_takes_nothing_of_others_when_it_is_off(kernel, tmp_path) -> None:
    """Zero lies outside of its limits, which one function for all faults looks at."""
    T = [[1.0, 0.8, 0.3, -0.5], [0.2, 0.6, 1.0, 0.9]]
    vehicle = made_up(T, [-250.0, 10.0, -250.0, -250.0], 250.0)
    check_itself(vehicle, kernel, "double", "fixed", tmp_path, "all")


def test_a_number_of_one_fault_that_is_wrong_is_told_by_the_self_test(tmp_path) -> None:
    files = generate(small(), "nullspace", faults="all")
    rows = re.search(r"_of\[\d\]\[\d+\] = \{\n(.*?)\n\};", files["ukwial_nullspace.c"], re.S)
    assert rows
    last = rows[1].splitlines()[-1]
    files["ukwial_nullspace.c"] = files["ukwial_nullspace.c"].replace(last, last.replace("250.0", "240.0"))
    done = run_program(build_program(tmp_path, files))
    assert done.returncode == 1
    assert "fault 3" in done.stdout


def test_without_faults_a_fault_is_not_known_and_nothing_else_is_other(tmp_path) -> None:
    vehicle = small()
    kernel = recipe("scaled")
    targets = [Target(vehicle=vehicle, method=kernel, faults=each) for each in ("none", "one")]
    none, one = (sources_of(target)["ukwial_scaled.c"] for target in targets)
    assert "case 0:" in one
    assert "case 0:" not in none
    assert files_of(vehicle, "scaled", faults=False)["ukwial_scaled.c"] == none
    assert files_of(vehicle, "scaled", faults=True)["ukwial_scaled.c"] == one


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("kernel", KERNELS)
def test_header_and_page_list_the_statuses_that_the_source_returns(kernel: str, limits: Where) -> None:
    for vehicle in (small(), load_vehicle("supply-vessel")):
        try:
            target = Target(vehicle=vehicle, method=recipe(kernel), scalar="float", limits=limits)
            header, source = sources_of(target).values()
        except NotApplicable:  # walsh covers no vehicle of another shape
            continue
        text = page(target)
        returned = {status for status, word in STATUSES.items() if re.search(rf"\b{word}\b", source)}
        assert {int(each) for each in re.findall(r"^ \*   ([ -]\d)  ", header, re.M)} == returned
        assert {int(each) for each in re.findall(r"^\| (-?\d) \|", text, re.M)} == returned
        assert (2 in returned) == (kernel == "nullspace" or (limits == "call" and kernel in LIMITED))


@pytest.mark.parametrize("faults", ["none", "one", "all"])
@pytest.mark.parametrize("kernel", ["scaled", "pinv"])
def test_a_fault_of_no_thruster_is_refused_and_leaves_f_alone(
    kernel: str, faults: Faults, tmp_path: Path
) -> None:
    """Bits of a mask as much as numbers that count from 1."""
    vehicle = small()
    solve = kernel_of(vehicle, tmp_path, kernel, faults=faults)
    for fault in (-(2**31), -2, vehicle.n, vehicle.n + 1, 31, 40, 2**31 - 1):
        status, f = solve(np.zeros(vehicle.k), fault=fault)
        assert status == UNKNOWN_FAULT
        assert (f == 7.0).all()


@pytest.mark.parametrize("kernel", EVERYWHERE)
def test_every_vehicle_s_c_with_limits_of_the_call_agrees_with_python(vehicle, kernel, tmp_path) -> None:
    check_itself(vehicle, kernel, "double", "call", tmp_path)


@pytest.mark.parametrize("kernel", ["nullspace", "redistribute", "scaled"])
def test_the_c_of_a_random_vehicle_with_full_h_agrees_with_python(kernel, tmp_path) -> None:
    """Generic T, so nothing is zero or shared; one block of two dimensions; a thruster that always pushes."""
    vehicle = random_vehicle(2, 4, np.random.default_rng(8), diagonal=False)
    check_itself(vehicle, kernel, "double", "call", tmp_path)


def test_where_h_couples_thrusters_that_z_moves_with_others_a_way_still_ends_at_least_effort(
    tmp_path,
) -> None:
    """Two thrusters share the surge, the first always pushes; a third, across, costs more beside them."""
    T, H = [[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], np.array([[3.0, 0, 1], [0, 1, -0.5], [1, -0.5, 2]])
    vehicle = made_up(T, [2.0, -10.0, -10.0], 10.0, H=H)
    allocate = build("scaled@native", vehicle)
    tau = np.array([11.0, 4.0])
    f = build("qp/daqp", vehicle)(tau).f
    np.testing.assert_allclose(allocate(tau).f, f, atol=1e-9)
    check_itself(vehicle, "scaled", "double", "fixed", tmp_path)


@pytest.mark.parametrize(
    ("number", "kernel", "scalar", "limits"),
    [
        pytest.param(20, "pinv", "double", "fixed", id="T nearly lost"),
        pytest.param(40, "shrink", "float", "fixed", id="limit at zero"),
        pytest.param(271, "shrink", "double", "fixed", id="must push, asked for nothing"),
        pytest.param(218, "shrink", "double", "call", id="entries of T* that are rounding"),
        pytest.param(83, "scaled", "float", "fixed", id="a weak thruster ends the way"),
        pytest.param(140, "nullspace", "double", "fixed", id="moved by rounding"),
        pytest.param(100, "redistribute", "double", "call", id="stuck, at its limit but for rounding"),
    ],
)
def test_self_tests_of_vehicles_with_all_that_a_file_may_hold_are_green(
    number, kernel, scalar, limits, tmp_path
) -> None:
    """``python docs/studies/native_selftests.py --plain --odd --random 300`` asks three hundred of them."""
    vehicle = replace(generate_vehicle(number)[0], name=f"odd{number}")
    done = run_program(build_program(tmp_path, generate(vehicle, kernel, scalar, limits=limits), *SANITIZE))
    assert done.returncode == 0, done.stdout + done.stderr


def test_redistribute_is_refused_where_its_factors_lose_too_many_digits() -> None:
    """Python makes its inverses in double and beforehand; C factorises in the call."""
    vehicle = small()
    uneven = replace(vehicle, H=np.diag(np.logspace(0, 4, vehicle.n)))
    assert generate(uneven, "redistribute", "double")
    with pytest.raises(
        NotApplicable, match=r"in float that may cost .* of the largest limit; generate it in"
    ):
        generate(uneven, "redistribute", "float")


def test_the_self_test_notices_a_wrong_constant(tmp_path) -> None:
    files = generate(small(), "nullspace")
    source = files["ukwial_nullspace.c"]
    first = re.search(r" = c\[\d+\] \* t\d", source)  # of the whole vehicle, which stands first
    assert first
    files["ukwial_nullspace.c"] = source.replace(first[0], first[0].replace("= ", "= 1.0000001 * "), 1)
    done = run_program(build_program(tmp_path, files))
    assert done.returncode == 1
    assert "fault -1" in done.stdout


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_self_test_notices_a_thrust_that_is_off_by_a_thousandth_of_a_limit_in_float(
    kernel, tmp_path
) -> None:
    vehicle = small()
    files = generate(vehicle, kernel, "float")
    source = f"{function_name(vehicle, kernel, 'float')}.c"
    broken, written = re.subn(
        r"f\[0\] = (.+);", rf"f[0] = (\1) + {vehicle.f_scale / 1000:.3f}F;", files[source]
    )
    assert written
    assert run_program(build_program(tmp_path, files | {source: broken})).returncode == 1


@pytest.mark.skipif(shutil.which("nm") is None, reason="nm (Debian: apt install binutils) lists symbols")
@pytest.mark.parametrize("kernel", KERNELS)
def test_generated_code_calls_no_library_and_keeps_no_state(kernel, tmp_path) -> None:
    """No undefined symbol: no library, no heap. No writable symbol: no state between calls."""
    made = build_program(
        tmp_path,
        sources_of(Target(vehicle=small(), method=recipe(kernel), limits="call")),
        "-O2",
        "-c",
    )
    symbols = subprocess.run(["nm", str(made)], capture_output=True, text=True, check=True).stdout.split("\n")
    kinds = {line.split()[-2] for line in symbols if line}
    assert kinds <= {"T", "t", "r"}  # code and constants


def kernel_of(
    vehicle: Vehicle,
    folder: Path,
    kernel: str = "nullspace",
    scalar: Scalar = "double",
    limits: Where = "fixed",
    faults: Faults = "one",
):
    """The compiled kernel as a Python function (arrays…, fault) -> (status, f), f filled with 7 before."""
    target = Target(vehicle=vehicle, method=recipe(kernel), scalar=scalar, limits=limits, faults=faults)
    library = ctypes.CDLL(str(build_program(folder, sources_of(target), "-O2", "-fPIC", "-shared")))
    solve = library[target.name]
    dtype = np.float64 if scalar == "double" else np.float32

    def call(*given: np.ndarray, fault: int = -1) -> tuple[int, np.ndarray]:
        arrays = [np.ascontiguousarray(each, dtype) for each in given]
        f, share = np.full(vehicle.n, 7.0, dtype), np.full(vehicle.k, 7.0, dtype)
        pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (*arrays, f, share)]
        status = solve(*pointers[: len(arrays)], fault, *pointers[len(arrays) :])
        assert status in (Status.SOLVED, Status.PARTIAL) or (share == 7.0).all()
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
            status, f_native = solve(degraded.T @ f, fault=fault)
            assert status == Status.SOLVED
            assert f_native[fault] == 0.0
            expected = allocate(degraded.T @ f).f
            np.testing.assert_allclose(f_native, expected, rtol=0, atol=1e-12 * vehicle.f_scale)


def test_a_refused_demand_or_fault_leaves_f_alone(vehicle: Vehicle, tmp_path) -> None:
    solve = kernel_of(vehicle, tmp_path)
    for axis in range(vehicle.k):
        tau = np.zeros(vehicle.k)
        tau[axis] = 1e300
        status, f = solve(tau)
        assert status == REFUSED
        assert (f == 7.0).all()
    huge = 1.7e308 * np.where(np.arange(vehicle.k) % 2, 1.0, -1.0)
    assert solve(huge)[0] == REFUSED  # though sums of it overflow
    for fault in (-2, vehicle.n, 1000):
        status, f = solve(np.zeros(vehicle.k), fault=fault)
        assert status == UNKNOWN_FAULT
        assert (f == 7.0).all()


DOUBLES = {
    "zero": (0x0, 0x0),
    "subnormal": (0x1, 0xFFFFFFFFFFFFF),
    "normal": (0x10000000000000, 0x4030000000000000),
    "infinity": (0x7FF0000000000000, 0x7FF0000000000000),
    "signalling NaN": (0x7FF0000000000001, 0x7FF7FFFFFFFFFFFF),
    "quiet NaN": (0x7FF8000000000000, 0x7FFFFFFFFFFFFFFF),
}
"""Least and greatest bit pattern of each class of doubles, normal ones up to 16; the sign is one bit more."""


@pytest.mark.parametrize("limits", ["call", pytest.param("fixed", marks=pytest.mark.long)])
@pytest.mark.parametrize("kernel", LIMITED)
def test_a_bit_pattern_that_is_no_finite_number_has_a_status_of_its_own(kernel, limits, tmp_path) -> None:
    """In any argument of a thruster that works; every pattern that is a number is answered or infeasible."""
    vehicle = small()
    solve = kernel_of(vehicle, tmp_path, kernel, limits=limits)
    rng = np.random.default_rng(4)
    usual = [np.zeros(vehicle.k), *((vehicle.f_min, vehicle.f_max) if limits == "call" else ())]
    for name, (least, greatest) in DOUBLES.items():
        patterns = [least, greatest, *rng.integers(least, greatest, 10, endpoint=True).tolist()]
        for bits in [sign << 63 | pattern for pattern in patterns for sign in (0, 1)]:
            (value,) = struct.unpack("d", struct.pack("Q", bits))
            for i, array in enumerate(usual):
                for entry in range(len(array)):
                    given = [each.copy() for each in usual]
                    given[i].view(np.uint64)[entry] = bits
                    status, f = solve(*given)
                    assert (status == NOT_FINITE) == (not np.isfinite(value)), (name, hex(bits), i)
                    if status not in (Status.SOLVED, Status.PARTIAL):
                        assert (f == 7.0).all()
                    if i > 0:  # the limits of a thruster that is off are not looked at
                        status, f = solve(*given, fault=entry)
                        assert status == Status.SOLVED
                        assert f[entry] == 0.0


@pytest.mark.parametrize("kernel", LIMITED)
def test_limits_that_cross_by_one_ulp_are_infeasible_and_leave_f_alone(kernel, tmp_path) -> None:
    vehicle = small()
    solve = kernel_of(vehicle, tmp_path, kernel, limits="call")
    tau = vehicle.T @ np.full(vehicle.n, 10.0)
    for i in range(vehicle.n):
        f_min, f_max = vehicle.f_min.copy(), vehicle.f_max.copy()
        f_min[i] = f_max[i] = 10.0
        assert solve(tau, f_min, f_max)[0] in (Status.SOLVED, Status.PARTIAL)
        f_min[i] = np.nextafter(10.0, 11.0)
        status, f = solve(tau, f_min, f_max)
        assert status == REFUSED
        assert (f == 7.0).all()


@pytest.mark.parametrize("diagonal", [pytest.param(True, marks=pytest.mark.long), False])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s[0]}x{s[1]}")
def test_native_and_python_agree_on_random_vehicles_of_every_nullity(shape, diagonal: bool) -> None:
    rng = np.random.default_rng(2)
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


@pytest.mark.parametrize("kernel", KERNELS)
def test_limits_of_the_call_are_taken_as_every_method_takes_them(kernel) -> None:
    """One by one, all at once, one side alone, for all calls or for each: the same answers as in Python."""
    vehicle = load_vehicle("bluerov2-heavy")
    python, native = build(kernel, vehicle), build(f"{kernel}@native", vehicle)
    demands = build_demands("jolts", vehicle, 3, 60)
    low, high = demands.limits
    close = {"rtol": 0, "atol": 1e-11 * vehicle.f_scale}
    for given in ((low, high), (low, None), (None, high), (low[0], high[0]), (None, None)):
        F, status = python.many(demands.taus, *given)
        native_F, native_status = native.many(demands.taus, f_min=given[0], f_max=given[1])
        np.testing.assert_array_equal(native_status, status)
        np.testing.assert_allclose(native_F, F, **close)
    for tau, f_min, f_max in zip(demands.taus, low, high, strict=True):
        expected, answer = python(tau, f_min, f_max), native(tau.tolist(), f_max=f_max, f_min=f_min)
        assert answer.status == expected.status
        np.testing.assert_allclose(answer.f, expected.f, **close)
        if answer.status in (Status.SOLVED, Status.PARTIAL):
            np.testing.assert_allclose(answer.share, expected.share, rtol=0, atol=1e-11)
            assert not native.limited or ((f_min <= answer.f) & (answer.f <= f_max)).all()


def test_axes_that_a_failure_makes_one_get_the_shares_that_they_get_in_python() -> None:
    """Both ask a level's step for the same number then, which each thrust adds up twice."""
    made = replace(
        small(),
        T=np.array([[1.0, 1.0, 2.0, -2.0], [1.0, 1.0, 2.0, 2.0], [2.0, 2.0, 1.0, 1.0]]),
        priority=(("yaw",), ("surge",), ("sway",)),
    )
    vehicle = made.with_fault(3)  # surge is sway then
    assert vehicle.rank == vehicle.k - 1
    python, native = build("priority", vehicle), build("priority@native", vehicle)
    for tau in np.random.default_rng(0).uniform(-1500.0, 1500.0, (50, 3)):
        for limits in ((), (vehicle.f_min, vehicle.f_max)):
            expected, answer = python(tau, *limits), native(tau, *limits)
            np.testing.assert_allclose(answer.share, expected.share, rtol=0, atol=1e-11)
            np.testing.assert_allclose(answer.f, expected.f, rtol=0, atol=1e-11 * vehicle.f_scale)


@pytest.mark.parametrize("kernel", ["scaled", "priority"])
def test_limits_without_any_margin_take_nothing_of_a_demand_but_what_they_make(kernel) -> None:
    """Loads are 0 / 0 there, which must not count, or x / 0, which must; the header says so."""
    vehicle = small()
    native = build(f"{kernel}@native", vehicle)
    fixed = np.full(vehicle.n, 10.0)
    made = vehicle.T @ fixed
    for tau, status, share in (
        (made, Status.SOLVED, 1.0),
        (made + vehicle.wrench_scale, Status.PARTIAL, 0.0),
    ):
        answer = native(tau, fixed, fixed)
        assert (answer.status, set(answer.share)) == (status, {share})
        np.testing.assert_array_equal(answer.f, fixed)
    files = [
        sources_of(Target(vehicle=vehicle, method=recipe(kernel), limits=each)) for each in ("call", "fixed")
    ]
    assert ["divide by zero" in next(iter(each.values())) for each in files] == [True, False]


@pytest.mark.parametrize(
    ("f_min", "says"), [([0.0] * 3, "shape"), ([np.nan] * 4, "NaN"), (["a"] * 4, "f_min"), (1.0, "shape")]
)
def test_limits_that_are_none_are_refused_as_every_method_refuses_them(f_min, says) -> None:
    allocate = build("nullspace@native", small())
    with pytest.raises(DemandError, match=says):
        allocate(np.zeros(3), f_min=f_min)
    with pytest.raises(DemandError, match=says):
        allocate.many(np.zeros((2, 3)), f_min=f_min)


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
    low, high = vehicle.f_min.copy(), vehicle.f_max.tolist()
    held = (tau, listed, low, high, Status.SOLVED)
    before = [sys.getrefcount(each) for each in held]
    for _ in range(1000):
        allocate(tau)
        allocate(listed)
        allocate.many([tau])
        allocate(tau, low, f_max=high)
        with pytest.raises(TypeError, match="takes tau"):
            allocate(tau, low, high, tau)
    assert [sys.getrefcount(each) for each in held] == before


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
    assert run_program(build_program(tmp_path, files)).returncode == 0


def test_a_thruster_that_pushes_no_controlled_axis_gets_the_thrust_nearest_zero(tmp_path) -> None:
    """A heave thruster where only the plane is controlled: its column of T is zero."""
    plane = load_vehicle("ukwial")
    T = np.hstack([plane.T, np.zeros((3, 2))])
    f_min, f_max = np.append(plane.f_min, [-10, 5]), np.append(plane.f_max, [10, 20])
    vehicle = made_up(T, f_min, f_max, name="idle", dof=plane.dof)
    tau = plane.T @ [100, 100, -100, -50]
    for method in ("nullspace", "nullspace@native"):
        np.testing.assert_array_equal(build(method, vehicle)(tau).f[4:], [0, 5])
    assert run_program(build_program(tmp_path, generate(vehicle, "nullspace"))).returncode == 0


def test_the_same_vehicle_gives_the_same_text() -> None:
    first, second = (generate(small(), "nullspace") for _ in range(2))
    assert first == second


def test_a_self_test_is_red_of_thrusts_that_make_the_same_wrench_with_more_effort(tmp_path) -> None:
    """At the end of a way thrusts may differ, with no more effort; here they move along the null space."""
    vehicle = small()
    files = generate(vehicle, "scaled")
    source = f"{function_name(vehicle, 'scaled', 'double')}.c"
    along = 1e-3 * vehicle.f_scale * np.linalg.svd(vehicle.T)[2][-1]
    by = dict(enumerate(along.tolist()))
    broken, written = re.subn(
        r"f\[(\d)\] = (.+);", lambda at: f"f[{at[1]}] = ({at[2]}) + {by[int(at[1])]!r};", files[source]
    )
    assert written >= vehicle.n
    done = run_program(build_program(tmp_path, files | {source: broken}))
    assert done.returncode == 1
    told = re.search(r"; (\d+) wrong", done.stdout)
    assert told
    assert int(told[1]) > 90  # nearly all of 120 cases, SOLVED and PARTIAL


def test_a_self_test_is_green_where_rounding_moves_the_end_of_a_way(tmp_path) -> None:
    """Four cases were red whose thrusts make the same wrench with no more effort, 6e-8 N apart."""
    check_itself(numbered(4)[0], "priority", "double", "call", tmp_path)
