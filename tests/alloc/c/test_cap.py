"""C under a cap on current: shares are those of a bisection on the path, and no call draws more."""

import ctypes
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, Status, Vehicle, build, generate, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import Target, capped, compiled, missing, sources
from alloc.methods import recipe
from alloc.program import Scalar
from alloc.reach.edge import start
from alloc.vehicle.current import PowerLaw
from tests.compilers import build_program, run

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")
SANITIZED = ["-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all", "-ffp-contract=off"]
HEAVY = load_vehicle("bluerov2-heavy")
LAW = replace(HEAVY, esc=(replace(HEAVY.esc[0], current=PowerLaw(0.076, 0.11, 1.5)),) * 8)
UNEVEN = replace(
    HEAVY,
    esc=tuple(replace(HEAVY.esc[0], current=PowerLaw(0.07 + i / 99, 0.11, 1.3 + i / 20)) for i in range(8)),
)
TURNS = (("yaw",), ("surge", "sway"), ("heave", "roll"))
SHARING = replace(load_vehicle("bluerov2"), groups=TURNS)
CASES: dict[str, tuple[Vehicle, Scalar]] = {
    "groups": (HEAVY, "double"),
    "groups in float": (LAW, "float"),
    "a table": (HEAVY, "double"),
    "a table in float": (HEAVY, "float"),
    "a law": (LAW, "double"),
    "a law in float": (LAW, "float"),
    "uneven laws": (UNEVEN, "double"),
    "T without full rank": (load_vehicle("bluerov2"), "double"),
    "no thruster stands still": (replace(HEAVY, f_min=np.full(8, 1.0)), "double"),
}
NEAR: dict[Scalar, float] = {"double": 1e-6, "float": 1e-4}
REAL = {"double": np.float64, "float": np.float32}
OVER: dict[Scalar, float] = {"double": 1e-9, "float": 1e-5}
Call = Callable[..., tuple[int, FloatArray, FloatArray]]


def bound(vehicle: Vehicle, scalar: Scalar, method: str = "scaled") -> tuple[Call, Call]:
    """NAME, and NAME_cap, with limits of the call: each returns status, f and share."""
    target = Target(vehicle=vehicle, method=recipe(method), scalar=scalar, limits="call")
    library = ctypes.CDLL(str(compiled.shared_library(target.name, sources(target) | capped(target))))
    real, number = REAL[scalar], ctypes.c_float if scalar == "float" else ctypes.c_double
    array = np.ctypeslib.ndpointer(dtype=real)
    plain, under = library[target.name], library[f"{target.name}_cap"]
    plain.argtypes = [array, array, array, ctypes.c_int, array, array]
    under.argtypes = [array, array, array, ctypes.c_int, number, number, array, array]

    def call(function: Callable[..., int]) -> Call:
        def asked(
            tau: FloatArray, low: FloatArray, high: FloatArray, fault: int, *supply: float
        ) -> tuple[int, FloatArray, FloatArray]:
            f, share = np.full(vehicle.n, np.nan, real), np.full(target.levels, np.nan, real)
            status = function(*(np.asarray(x, real) for x in (tau, low, high)), fault, *supply, f, share)
            return status, f.astype(np.float64), share.astype(np.float64)

        return asked

    return call(plain), call(under)


@pytest.mark.parametrize("count", [150, pytest.param(2_000, marks=pytest.mark.long)])
@pytest.mark.parametrize("case", CASES)
def test_shares_are_those_of_a_bisection_on_the_path_and_no_call_draws_more_than_the_cap(
    case: str, count: int, rng: np.random.Generator
) -> None:
    vehicle, scalar = CASES[case]
    method = "scaled-by-group" if "groups" in case else "scaled"
    (plain, under), stopped = bound(vehicle, scalar, method), 0
    for _ in range(count):
        fault = int(rng.integers(-1, vehicle.n))
        tau = rng.uniform(0.1, 3.0) * vehicle.TP @ rng.uniform(vehicle.f_min, vehicle.f_max)
        narrower = rng.uniform(0.3, 1.0, (2, vehicle.n)) ** rng.integers(2)
        low = np.where(vehicle.f_min < 0, narrower[0] * vehicle.f_min, vehicle.f_min)
        high, volts = narrower[1] * vehicle.f_max, float(rng.uniform(9, 21))
        tau, low, high = (np.asarray(x, REAL[scalar]).astype(np.float64) for x in (tau, low, high))
        draw, cap = vehicle.draw(volts), float(rng.choice([1.0, 3.0, 10.0, 20.0, 60.0, 300.0]))
        status, f, share = under(tau, low, high, fault, cap, volts)
        on = np.arange(vehicle.n) != fault
        begin = start(np.where(on, low, 0.0), np.where(on, high, 0.0))
        if draw.amps(begin).sum() > cap:
            assert status == Status.INFEASIBLE
            continue
        assert draw.amps(f).sum() <= cap * (1 + OVER[scalar])
        assert ((f >= low) & (f <= high) | ~on).all()
        whole, reached, all_of_it = plain(tau, low, high, fault)
        if draw.amps(reached).sum() <= cap:
            assert status == whole
            assert share.tolist() == all_of_it.tolist()
            continue
        stopped, least, most, expected = stopped + 1, 0.0, max(all_of_it), 0.0 * all_of_it
        rest = vehicle.TP @ begin
        for _ in range(45):
            middle = (least + most) / 2
            _, there, part = plain(rest + middle * (tau - rest), low, high, fault)
            if draw.amps(there).sum() <= cap:
                least, expected = middle, middle * part
            else:
                most = middle
        assert status == Status.PARTIAL
        np.testing.assert_allclose(share, expected, atol=NEAR[scalar])
    assert stopped > 20


def test_of_groups_that_take_turns_the_answer_is_that_of_python(rng: np.random.Generator) -> None:
    """The current of such a path may fall, too, so that a bisection may find another share."""
    under, stopped = bound(SHARING, "double", "scaled-by-group")[1], 0
    python = {fault: build("scaled-by-group", SHARING.with_fault(fault)) for fault in range(SHARING.n)}
    python[-1] = build("scaled-by-group", SHARING)
    for _ in range(250):
        tau = rng.uniform(0.1, 3.0) * SHARING.TP @ rng.uniform(SHARING.f_min, SHARING.f_max)
        tau *= rng.random(SHARING.k) < 0.7
        fault, cap, volts = (
            int(rng.integers(-1, SHARING.n)),
            float(rng.uniform(1, 60)),
            float(rng.uniform(9, 21)),
        )
        expected = python[fault](tau, cap=cap, volts=volts)
        status, f, share = under(tau, SHARING.f_min, SHARING.f_max, fault, cap, volts)
        stopped += status == expected.status == Status.PARTIAL
        assert status == expected.status
        np.testing.assert_allclose(share, expected.share, atol=1e-6)
        np.testing.assert_allclose(f, expected.f, atol=1e-5 * SHARING.f_scale)
    assert stopped > 20


def test_a_cap_below_rest_leaves_each_group_a_share_of_nothing() -> None:
    nothing = build("scaled-by-group", SHARING)(np.ones(5), cap=0.0, volts=12.0)
    groups = build("scaled-by-group", CASES["no thruster stands still"][0])(np.ones(6), cap=0.1, volts=12.0)
    assert (nothing.found, len(nothing.share)) == (True, 3)
    assert (groups.status, groups.share) == (Status.INFEASIBLE, (0.0, 0.0))


def test_a_thrust_that_rounding_leaves_just_inside_its_limit_counts_as_at_it() -> None:
    tau = [-168.48341664855872, -18.9370205612833, -3.8612736892905275]
    tau += [9.344930833932295, 10.370022415412496, -32.82811952102266]
    low = [-27.61543871487403, -17.707660939222, -28.379755540830928, -12.522185702348034]
    low += [-12.669922095931499, -37.23352437382677, -18.06057282119941, -28.798155916060082]
    high = [27.706777439296307, 57.062962504234385, 32.29892320889127, 25.42632660088539]
    high += [36.843338293142494, 30.30302517723795, 56.37279447952808, 51.94381456354744]
    call = np.array(tau), np.array(low), np.array(high)
    expected = build("scaled", HEAVY)(*call, cap=3.8742315466775694, volts=10.0)
    share = bound(HEAVY, "double")[1](*call, -1, 3.8742315466775694, 10.0)[2]
    assert share[0] == pytest.approx(expected.share[0], abs=1e-6)


def test_an_argument_that_is_not_finite_is_refused() -> None:
    _, under = bound(HEAVY, "double")
    tau, limits = np.full(6, 5.0), (HEAVY.f_min, HEAVY.f_max)
    for cap, volts in ((np.nan, 12.0), (np.inf, 12.0), (20.0, np.nan), (20.0, np.inf)):
        assert under(tau, *limits, -1, cap, volts)[0] == -2
    assert under(np.full(6, np.nan), *limits, -1, 20.0, 12.0)[0] == -2
    assert under(tau, *limits, -1, -1.0, 12.0)[0] == Status.INFEASIBLE


def self_test(
    folder: Path, vehicle: Vehicle, single: bool, old: str = "", new: str = "", method: str = "scaled"
) -> tuple[int, str]:
    """Exit code and output of the self-test of a vehicle's C, edited before."""
    files = generate(vehicle, method, scalar="float" if single else "double", cap=True)
    files = {file: text for file, text in files.items() if "/" not in file or "_cap_test" in file}
    (source,) = (file for file in files if file.endswith("_cap.c"))
    assert old in files[source]
    files[source] = files[source].replace(old, new)
    done = run([str(build_program(folder, files, *SANITIZED, "-lm"))], folder)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("method", ["scaled", "scaled-by-group"])
@pytest.mark.parametrize("single", [True, False])
@pytest.mark.parametrize("vehicle", [HEAVY, LAW], ids=["a table", "a law"])
def test_the_self_test_finds_what_python_says(
    vehicle: Vehicle, single: bool, method: str, tmp_path: Path
) -> None:
    code, text = self_test(tmp_path, vehicle, single, method=method)
    assert (code, "108 cases; 0 wrong" in text) == (0, True), text


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("cap - 0.5F * near", "0.999F * cap"),
        ("up * (piece->amps", "0.9F * up * (piece->amps"),
        ("return TB_PARTIAL;", "return TB_SOLVED;"),
        ("k < STEPS", "k < 1"),
    ],
)
def test_a_broken_line_is_seen(old: str, new: str, tmp_path: Path) -> None:
    code, text = self_test(tmp_path, HEAVY, True, old, new)
    assert code == 1, text


@pytest.mark.parametrize(
    ("method", "vehicle", "package", "message"),
    [
        ("pinv", HEAVY, None, "cap: methods for .* take none; use scaled"),
        ("scaled", load_vehicle("ukwial"), None, "has no currents; add 'current' to 'esc'"),
        ("scaled", LAW, "cmake", "links no mathematical library, which a law of current needs"),
    ],
)
def test_what_has_no_c_with_a_cap_is_refused(
    method: str, vehicle: Vehicle, package: str, message: str
) -> None:
    with pytest.raises(AllocError, match=message):
        generate(vehicle, method, cap=True, package=package)
