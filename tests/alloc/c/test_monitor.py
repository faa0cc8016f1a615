"""C that accuses thrusters: as its equations in Python say, on simulated dives too, whatever it is given."""

import ctypes
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.linalg import eigh, toeplitz
from scipy.stats import norm

from alloc import AllocError, Vehicle, generate, load_vehicle
from alloc.allocation import FloatArray, IndexArray
from alloc.c import Target, accusations, compiled, missing, monitor
from alloc.c.suspicion import ACCUSED, LASTING, MEMORY, NOBODY, TURNS, inflation
from alloc.c.target import NOT_FINITE
from alloc.lint.isolation import assumed_noise
from alloc.methods import recipe
from alloc.program import Scalar
from bench.demands.mission import M, resistance
from tests.compilers import build_program, run
from tests.dives import dive

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")
SANITIZED = ["-O1", "-fsanitize=undefined,float-divide-by-zero", "-fno-sanitize-recover=all"]


def self_test(folder: Path, name: str, single: bool, old: str = "", new: str = "") -> tuple[int, str]:
    """Exit code and output of the self-test of a vehicle's C, edited before."""
    vehicle = load_vehicle(name)
    files = generate(vehicle, "pinv", scalar="float" if single else "double", monitor=assumed_noise(vehicle))
    own = {file: text for file, text in files.items() if "_monitor" in file}
    (source,) = (file for file in own if file.endswith("_monitor.c"))
    assert old in own[source]
    done = run(
        [str(build_program(folder, own | {source: own[source].replace(old, new)}, *SANITIZED))], folder
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize(("name", "single"), [("bluerov2-heavy", True), ("ukwial", False)])
def test_the_self_test_finds_what_python_says_and_nothing_undefined(
    name: str, single: bool, tmp_path: Path
) -> None:
    code, text = self_test(tmp_path, name, single)
    assert (code, "96 cases; 0 wrong" in text) == (0, True), text


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("= score;\n            who", "= score + score;\n            who"),
        ("TB_NOT_FINITE;\n", "TB_SOLVED;\n"),
    ],
)
def test_a_broken_line_is_seen(old: str, new: str, tmp_path: Path) -> None:
    code, text = self_test(tmp_path, "ukwial", True, old, new)
    assert code == 1, text


class Watch:
    """NAME_monitor and NAME_suspect of a vehicle, compiled."""

    def __init__(
        self, vehicle: Vehicle, noise: FloatArray, lasting: float = LASTING, scalar: Scalar = "double"
    ) -> None:
        target = Target(vehicle=vehicle, method=recipe("pinv"), scalar=scalar)
        library = ctypes.CDLL(str(compiled.shared_library(target.name, monitor(target, noise, lasting))))
        self.real = np.float32 if scalar == "float" else np.float64
        array = np.ctypeslib.ndpointer(dtype=self.real)
        size = 3 * vehicle.n + 2 * vehicle.k + 3
        self.state, self.odds = np.zeros(size, dtype=self.real), np.zeros(1, dtype=self.real)
        self.monitor, self.suspect = library[f"{target.name}_monitor"], library[f"{target.name}_suspect"]
        self.monitor.argtypes, self.suspect.argtypes = [array] * 3, [array] * 2

    def all(self, F: FloatArray, wrenches: FloatArray) -> tuple[IndexArray, IndexArray, FloatArray]:
        """Status, thruster and log odds behind each call."""
        rows = []
        for f, wrench in zip(F, wrenches, strict=True):
            status = self.monitor(self.state, f.astype(self.real), wrench.astype(self.real))
            rows.append((status, self.suspect(self.state, self.odds), float(self.odds[0])))
        status, who, odds = zip(*rows, strict=True)
        return np.array(status), np.array(who), np.array(odds)


class Felt(NamedTuple):
    """Thrusts told (N, n) and wrenches felt (N, k) on a dive, with the drag that its operator believes in."""

    f: FloatArray
    wrenches: FloatArray


def stated(vehicle: Vehicle) -> FloatArray:
    """Noise of a wrench that knows drag to a fifth, at the thrusts of these dives: 1 % of the most."""
    return 0.2 * assumed_noise(vehicle)


def felt(vehicle: Vehicle, seed: int, readiness: FloatArray) -> Felt:
    flown = dive(vehicle, np.random.default_rng(seed), readiness, noise=0.05)
    return Felt(flown.f, M * flown.a + np.array([resistance(v) for v in flown.v]))


@pytest.mark.parametrize(("thruster", "readiness"), [(3, 0.0), (6, 0.5), (0, -1.0)])
def test_on_a_simulated_dive_c_and_python_accuse_the_thruster_that_fails(
    thruster: int, readiness: float
) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    weak = np.ones(8)
    weak[thruster] = readiness
    noise, flown = stated(vehicle), felt(vehicle, thruster, weak)
    status, who, odds = Watch(vehicle, noise).all(*flown)
    expected = accusations(vehicle, noise, *flown)
    assert not status.any()
    assert odds == pytest.approx(expected[2], rel=1e-9, abs=1e-9)
    assert (who == expected[1])[odds > 1e-6].all()
    assert who[-1] == thruster
    assert odds[-1] > ACCUSED


def test_noise_that_lasts_four_times_as_long_lowers_odds_by_its_inflation() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    weak = np.where(np.arange(8) == 3, 0.0, 1.0)
    noise, flown = stated(vehicle), felt(vehicle, 3, weak)
    usual = accusations(vehicle, noise, *flown)[2]
    for longer in (
        accusations(vehicle, noise, *flown, 4 * LASTING)[2],
        Watch(vehicle, noise, 4 * LASTING).all(*flown)[2],
    ):
        assert longer * inflation(4 * LASTING) == pytest.approx(
            usual * inflation(LASTING), rel=1e-9, abs=1e-6
        )
    assert inflation(4 * LASTING) > 3.9 * inflation(LASTING)


def test_a_healthy_dive_accuses_nobody() -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    for seed in range(3):
        odds = accusations(vehicle, stated(vehicle), *felt(vehicle, seed, np.ones(8)))[2]
        assert odds.max() < ACCUSED / 2


def test_a_steady_wrench_accuses_nobody_and_hides_no_failure() -> None:
    vehicle, rng = load_vehicle("tiburon"), np.random.default_rng(4)
    F = vehicle.f_scale * (0.3 + 0.2 * rng.uniform(-1, 1, (400, vehicle.n)))
    noise = assumed_noise(vehicle)
    current = 4.0 * noise
    for dead, least, most in ((None, 0.0, 1.0), (5, ACCUSED, np.inf)):
        made = F * np.where(np.arange(vehicle.n) == dead, 0.0, 1.0)
        _, who, odds = Watch(vehicle, noise / 10, 1.0).all(F, made @ vehicle.T.T - current)
        assert least <= odds[-1] <= most
        assert dead is None or who[-1] == dead


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_rounding_of_steady_sums_accuses_nobody_however_fine_the_noise(scalar: Scalar) -> None:
    """Single precision left log odds of 98 of thrusts that did not change, beside a current that did not."""
    vehicle, rng = load_vehicle("bluerov2-heavy"), np.random.default_rng(1)
    noise = np.array([0.05, 0.05, 0.05, 0.01, 0.01, 0.01])
    F = np.tile([-15.0, -15.0, 15.0, 15.0, 8.0, 8.0, 8.0, 8.0], (8000, 1))
    wrenches = F @ vehicle.TP.T - np.array([10.3, 0.0, -5.2, 0.0, 0.0, 0.0])
    wrenches += noise * np.repeat(rng.normal(size=(320, vehicle.k)), LASTING, axis=0)
    _, _, odds = Watch(vehicle, noise, scalar=scalar).all(F, wrenches)
    assert odds.max() < 0.01


def test_what_is_no_number_or_far_too_large_changes_nothing() -> None:
    vehicle = load_vehicle("ukwial")
    watch, f, wrench = Watch(vehicle, assumed_noise(vehicle)), np.ones(4), np.zeros(3)
    watch.all(f[None], wrench[None])
    before = watch.state.copy()
    for at, wrong in ((f, np.nan), (f, 1e200), (wrench, np.nan), (wrench, -np.inf), (wrench, 1e9)):
        kept, at[1] = at[1], wrong
        assert watch.monitor(watch.state, f, wrench) == NOT_FINITE
        at[1] = kept
        assert (watch.state == before).all()


def test_without_a_residual_nobody_is_named() -> None:
    vehicle = load_vehicle("ukwial")
    watch = Watch(vehicle, assumed_noise(vehicle))
    _, who, odds = watch.all(np.zeros((3, 4)), np.zeros((3, 3)))
    assert (who == NOBODY).all()
    assert (odds == 0.0).all()


def test_a_failure_that_is_over_is_forgotten() -> None:
    vehicle, rng = load_vehicle("ukwial"), np.random.default_rng(1)
    F = rng.uniform(-1, 1, (8 * MEMORY, 4)) * vehicle.f_scale
    made = F.copy()
    made[:MEMORY, 2] = 0.0
    odds = accusations(vehicle, stated(vehicle), F, made @ vehicle.TP.T)[2]
    assert odds[MEMORY - 1] > ACCUSED
    assert odds[-1] < 0.01 * odds[MEMORY - 1]


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, np.inf, 1e-9])
def test_noise_that_is_none_or_too_fine_is_refused(wrong: float) -> None:
    with pytest.raises(AllocError, match=r"--noise: sway: got \S+ N, expected more than"):
        generate(load_vehicle("ukwial"), "pinv", monitor=np.array([1.0, wrong, 1.0]))


def test_the_header_says_the_noise() -> None:
    files = generate(load_vehicle("ukwial"), "pinv", monitor=np.array([4.0, 5.0, 6.0]))
    assert re.search(r"surge 4 N, sway 5 N, yaw 6 N m\.", files["ukwial_pinv_monitor.h"])


def test_sums_of_noise_that_lasts_vary_at_most_by_the_inflation() -> None:
    covariance = toeplitz(np.exp(-TURNS * np.arange(1000) / LASTING))
    largest = float(eigh(covariance, eigvals_only=True, subset_by_index=[999, 999])[0])
    assert 0.9 * inflation(LASTING) < largest <= inflation(LASTING)


def test_chance_accuses_less_than_once_in_a_thousand_hours() -> None:
    assert 20 * 100 * 3600 * 1000 * norm.sf(np.sqrt(2 * ACCUSED)) < 1.0


def test_chance_exceeds_low_odds_no_more_often_than_the_formula_that_accusations_rest_on_says() -> None:
    vehicle, lasting, calls, cases = load_vehicle("ukwial"), 5.0, 100, 3_000
    rng, rho, sizes = np.random.default_rng(3), np.exp(-1 / 5.0), assumed_noise(vehicle)
    noise = rng.normal(size=(calls, cases, 3))
    for row in range(1, calls):
        noise[row] = rho * noise[row - 1] + np.sqrt(1 - rho**2) * noise[row]
    # One thruster pushes, in one slow wave: that is the worst. Half the inflation would double log odds.
    wave = np.sin(2 * np.pi * np.arange(calls) / calls)[:, None] * np.array([1.0, 0.0, 0.0, 0.0])
    F = wave * np.sqrt(40 / calls) / np.linalg.norm(vehicle.T[:, 0] / sizes)
    watch, odds = Watch(vehicle, sizes, lasting), np.zeros(cases)
    for case, errors in enumerate(np.swapaxes(noise, 0, 1)):
        watch.state[:] = 0.0
        odds[case] = watch.all(F, F @ vehicle.T.T + sizes * errors)[2][-1]
    assert 0.2 * norm.sf(2.0) < (odds > 2.0).mean() <= norm.sf(2.0)
    assert (2 * odds > 2.0).mean() > norm.sf(2.0)
