"""Solvers' own C, and the check around it: what it lets through, and what it is built of."""

import ctypes
import re
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from types import SimpleNamespace

import numpy as np
import pytest

from alloc import Label, Status, Vehicle, build, catalogue, label, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.c import missing
from alloc.c.compiled import shared_library
from alloc.errors import NotInstalled
from alloc.program import Scalar
from alloc.qp import pose_hard
from alloc.rivals import Files, download, load, names, wrapper
from alloc.rivals.c import single
from alloc.rivals.wrapper import bound, library
from tests.vehicles import made_up

UNTOUCHED = 12345.0
FULL_AHEAD = np.array([250.0, 250.0, -250.0, -250.0])
"""Ukwial's thrusts for most surge [N]: each at a limit."""

needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing())


@pytest.fixture(params=names())
def name(request: pytest.FixtureRequest) -> str:
    """Each rival whose C can be generated here."""
    if reason := load(request.param).missing():
        pytest.skip(reason)
    return str(request.param)


Answered = Callable[[FloatArray], tuple[int, FloatArray]]


def claimed(monkeypatch: pytest.MonkeyPatch, body: str, vehicle: Vehicle) -> Answered:
    """The wrapper around C that claims whatever ``body`` writes into x and y and returns."""
    text = (
        '#include "rival.h"\n'
        "int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y)\n"
        f"{{\n    (void)b, (void)lb, (void)ub;\n    {body}\n}}\n"
    )
    fake = SimpleNamespace(missing=lambda: "", generate=lambda qp, scalar, level: Files({"fake.c": text}, {}))
    monkeypatch.setattr(wrapper, "load", lambda name: fake)
    made = wrapper.rival("fake", vehicle)
    function = ctypes.CDLL(str(shared_library("fake", made.own)))[made.entry]

    def answered(tau: FloatArray) -> tuple[int, FloatArray]:
        f = np.full(vehicle.n, UNTOUCHED)
        pointers = (array.ctypes.data_as(ctypes.c_void_p) for array in (tau, f))
        return function(*pointers), f

    return answered


@pytest.fixture
def vehicle() -> Vehicle:
    return load_vehicle("ukwial")


@pytest.fixture
def attainable(vehicle: Vehicle) -> FloatArray:
    """Half of the most surge."""
    tau: FloatArray = vehicle.TP @ (FULL_AHEAD / 2)
    return tau


@needs_compiler
@pytest.mark.parametrize("value", ["0.0", "-1e300", "0.0 / 0.0", "1.0 / 0.0"])
def test_thrusts_that_do_not_make_the_wrench_are_no_answer_whatever_a_solver_claims(
    value: str, vehicle: Vehicle, attainable: FloatArray, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = f"for (int i = 0; i < 4; i++) x[i] = {value}; y[0] = y[1] = y[2] = 0; return 0;"
    status, f = claimed(monkeypatch, body, vehicle)(attainable)
    assert status == Status.NOT_CONVERGED
    assert (f == UNTOUCHED).all()


@needs_compiler
@pytest.mark.parametrize("value", ["0.0 / 0.0", "-0.0 / 0.0"])
def test_an_x_that_is_no_number_is_no_answer_also_where_a_limit_in_its_place_would_make_the_wrench(
    value: str, vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Clipping NaN gives a limit, and Ukwial's thrusters all at f_max push against one another: no wrench."""
    assert vehicle.TP @ vehicle.f_max == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    body = f"for (int i = 0; i < 4; i++) x[i] = {value}; y[0] = y[1] = y[2] = 0; return 0;"
    status, f = claimed(monkeypatch, body, vehicle)(np.zeros(3))
    assert status == Status.NOT_CONVERGED
    assert (f == UNTOUCHED).all()


@needs_compiler
def test_thrusts_beyond_the_limits_are_clipped(vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch) -> None:
    """x beyond the limits by 0.005 in their unit: once clipped, the thrusts make the demand of most surge."""
    body = "for (int i = 0; i < 4; i++) x[i] = i < 2 ? 1.005 : -1.005; return 2;"
    status, f = claimed(monkeypatch, body, vehicle)(vehicle.TP @ FULL_AHEAD)
    assert status == Status.SOLVED
    np.testing.assert_array_equal(f, FULL_AHEAD)


@needs_compiler
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_infeasible_is_said_where_the_multipliers_prove_it_and_only_there(
    sign: float, vehicle: Vehicle, attainable: FloatArray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """y = b, or -b, separates a demand of three times the most surge from all that is attainable."""
    body = f"for (int i = 0; i < 4; i++) x[i] = 0;for (int i = 0; i < 3; i++) y[i] = {sign} * b[i]; return 0;"
    answered = claimed(monkeypatch, body, vehicle)
    assert answered(6.0 * attainable)[0] == Status.INFEASIBLE
    assert answered(attainable)[0] == Status.NOT_CONVERGED


@needs_compiler
def test_a_demand_that_is_not_finite_is_told_before_the_solver_sees_it(
    vehicle: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered = claimed(monkeypatch, "__builtin_trap();", vehicle)
    for odd in (np.nan, np.inf, -np.inf):
        assert answered(np.array([0.0, odd, 0.0]))[0] == -2


@needs_compiler
def test_every_rival_finds_the_optimum_where_efforts_differ_and_belong_together(name: str) -> None:
    """H with all entries, and limits that are not alike."""
    rng = np.random.default_rng(16)
    made = rng.standard_normal((5, 5))
    H = np.diag([1.0, 2.0, 3.0, 4.0, 5.0]) + 0.1 * made @ made.T
    ends = [-1.0, -2.0, -3.0, -1.0, -2.0], [2.0, 1.0, 2.0, 3.0, 1.0]
    vehicle = made_up(rng.standard_normal((3, 5)), *ends, H=H)
    taus = 0.8 * rng.uniform(vehicle.f_min, vehicle.f_max, (30, 5)) @ vehicle.TP.T
    exact, right = build("nullspace", vehicle).many(taus)
    allocate = bound(name, vehicle)
    F, status = allocate.many(taus)
    assert (right == Status.SOLVED).all()
    assert np.isin(status, (Status.SOLVED, Status.PARTIAL)).all()
    assert np.abs(F - exact).max() <= allocate.tolerance * vehicle.f_scale


@needs_compiler
@pytest.mark.parametrize("model", ["ukwial", "nautilus"])
def test_every_rival_at_its_most_accurate_meets_what_can_be_met_as_its_binding_does(
    name: str, model: str
) -> None:
    """Demands near the limits. QOCO gives up on a fourth of Nautilus's; what it answers is right."""
    vehicle = load_vehicle(model)
    rng = np.random.default_rng(5)
    taus = 0.95 * rng.uniform(vehicle.f_min, vehicle.f_max, (200, vehicle.n)) @ vehicle.TP.T
    exact, _ = build("nullspace", vehicle).many(taus)
    allocate = bound(name, vehicle)
    F, status = allocate.many(taus)
    answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
    assert np.abs(F - exact)[answered].max() <= allocate.tolerance * vehicle.f_scale
    if name == "qoco":
        assert answered.mean() > 0.6
    else:
        assert (status == Status.SOLVED).all()
        assert allocate.tolerance <= 1e-5


@needs_compiler
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_an_answer_does_not_depend_on_the_calls_before_it(name: str, scalar: Scalar) -> None:
    """Demands far beyond reach drive OSQP's step size away; each demand is asked first, after it and last."""
    vehicle = load_vehicle("bluerov2-heavy")
    made = wrapper.rival(name, vehicle, scalar, checked=False)
    function = ctypes.CDLL(str(shared_library(name, made.own, shared=made.shared)))[made.entry]
    number = np.float64 if scalar == "double" else np.float32

    def answered(tau: FloatArray) -> bytes:
        f = np.full(vehicle.n, UNTOUCHED, dtype=number)
        pointers = (array.ctypes.data_as(ctypes.c_void_p) for array in (tau.astype(number), f))
        return bytes([function(*pointers) & 0xFF]) + f.tobytes()

    F = np.random.default_rng(5).uniform(vehicle.f_min, vehicle.f_max, (20, vehicle.n))
    taus = np.repeat([0.3, 0.95, 0.95, 4.0], 5)[:, None] * F @ vehicle.TP.T
    forwards = [answered(tau) for tau in taus]
    assert [answered(tau) for tau in taus[::-1]][::-1] == forwards
    assert [answered(tau) for tau in taus] == forwards


@needs_compiler
@pytest.mark.skipif(not shutil.which("nm"), reason="needs nm of the binutils")
def test_no_rival_asks_for_memory_or_the_time(name: str) -> None:
    """Imports of its C: mathematics, and copying within memory that it has."""
    listing = ["nm", "-D", "--undefined-only", library(name, load_vehicle("ukwial"))]
    listed = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
    needed = {line.split()[1].split("@")[0] for line in listed.splitlines() if line.split()[0] == "U"}
    assert needed <= {"fmax", "fmin", "sqrt", "memcpy", "memmove", "memset"}


def test_every_rival_that_is_not_accurate_by_default_has_a_level_that_is() -> None:
    entries = {entry.name: entry for entry in catalogue()}
    for name in names():
        tolerances = load(name).TOLERANCE
        assert entries[f"qp/{name}@generated"].levels == tuple(tolerances)
        if name != "qoco":  # whose page says why it has none
            assert list(tolerances.values())[-1]["double"] <= 5e-6


@needs_compiler
def test_with_limits_that_jump_from_call_to_call_no_rival_leaves_them_or_claims_too_much(name: str) -> None:
    """Judged by alpha*, a linear program over the limits of each call; on the boundary anything goes."""
    vehicle = load_vehicle("ukwial")
    rng = np.random.default_rng(16)
    low, high = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, 60, vehicle.n)), axis=0)
    taus = rng.uniform(0.2, 1.5, (60, 1)) * rng.uniform(low, high) @ vehicle.TP.T
    F, status = bound(name, vehicle).many(taus, low, high)
    labels = label(vehicle, taus, f_min=low, f_max=high).label
    answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
    assert (np.clip(F, low, high) == F)[answered].all()
    assert answered[(labels == Label.ACTIVE) | (labels == Label.INACTIVE)].mean() > 0.9
    assert not (status[labels == Label.INFEASIBLE] == Status.SOLVED).any()
    assert (labels == Label.INFEASIBLE).sum() > 9
    solved = status == Status.SOLVED
    missed = np.abs(F[solved] @ vehicle.TP.T - taus[solved]) / vehicle.wrench_scale
    assert missed.max() <= WRENCH_TOLERANCE


@needs_compiler
@pytest.mark.skipif("osqp" not in names() or bool(load("osqp").missing()), reason="needs OSQP")
def test_osqp_proves_what_it_calls_infeasible(vehicle: Vehicle) -> None:
    """Its C leaves the field for certificates as it was; the last step of the multipliers is one."""
    allocate = bound("osqp", vehicle)
    F = np.random.default_rng(3).uniform(vehicle.f_min, vehicle.f_max, (40, vehicle.n))
    _, status = allocate.many(4.0 * F @ vehicle.TP.T)
    labels = label(vehicle, 4.0 * F @ vehicle.TP.T).label
    assert (labels == Label.INFEASIBLE).sum() > 20
    assert set(status[labels == Label.INFEASIBLE]) == {Status.INFEASIBLE}


@needs_compiler
@pytest.mark.skipif(not shutil.which("nm"), reason="needs nm of the binutils")
def test_c_that_is_written_in_two_threads_leaves_standard_output_as_it_was(vehicle: Vehicle) -> None:
    """qocogen prints, which is caught; the second thread put the first one's catch back for good."""
    pytest.importorskip("qocogen")
    before, begin = sys.stdout, Barrier(2)

    def written(_: int) -> None:
        begin.wait()
        for _ in range(3):
            load("qoco").generate(pose_hard(vehicle).qp, "double", "default")

    with ThreadPoolExecutor(2) as threads:
        list(threads.map(written, range(2)))
    assert sys.stdout is before


def test_no_two_rivals_define_the_same_function() -> None:
    """An image for a board may hold them all; what a generator calls ``ldl`` or ``Gx`` is anybody's."""
    defined: list[str] = []
    for name in (name for name in names() if not load(name).missing()):
        listing = ["nm", "-D", "--defined-only", library(name, load_vehicle("ukwial"))]
        listed = subprocess.run(listing, capture_output=True, text=True, check=True)
        defined += {line.split()[-1] for line in listed.stdout.splitlines()}
    common = {"__bss_start", "_edata", "_end", "_init", "_fini", "answer_fixed", "answer_call"}
    assert not [name for name, times in Counter(defined).items() if times > 1 and name not in common]


def test_double_precision_becomes_single_in_types_constants_and_functions() -> None:
    text = "double a = sqrt(1e-8 * x[10]) + 0.5 - 3; float b = 2.f; int i = 0x10; /* v1.2 */"
    assert single(text) == (
        "float a = sqrtf(1e-8F * x[10]) + 0.5F - 3; float b = 2.f; int i = 0x10; /* v1.2 */"
    )


def test_a_constant_that_single_precision_cannot_hold_becomes_the_nearest_it_can() -> None:
    """Zero would be another thing: CasADi marks a bound as active by the smallest number above zero."""
    smallest, largest = (float(literal[:-1]) for literal in single("2.2e-308, 1.7e308").split(", "))
    assert 0 < np.float32(smallest) < 1.2e-38
    assert np.isfinite(np.float32(largest))
    assert largest > 3.4e38


def test_c_that_is_not_there_or_was_changed_is_told_with_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(tmp_path))
    daqp = download.source("daqp")
    assert daqp.missing().endswith("python -m alloc.rivals.download")
    with pytest.raises(NotInstalled, match=re.escape(download.REMEDY)):
        bound("daqp", load_vehicle("ukwial"))
    daqp.path.write_bytes(b"something else")
    assert "is not the file that was asked for" in daqp.missing()
