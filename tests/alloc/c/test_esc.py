"""C from thrusts to the commands of ESCs: as Python sends them, whatever ESCs there are, for any bits."""

import ctypes
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from alloc import NotApplicable, Status, Vehicle, build, generate, load_vehicle
from alloc.c import Target, compiled, sources, to_escs
from alloc.methods import recipe
from alloc.program import Scalar, Where
from tests.compilers import WARNINGS, run, write

AT_16 = [[1100, -40], [1300, -9], [1470, 0], [1530, 0], [1900, 51]]
CURVE = {"12": [[1100, -20], [1470, 0], [1530, 0], [1900, 25]], "16": AT_16}
USUAL = {"neutral": 1500, "range": [1100, 1900], "curve": CURVE, "dead_band": "jump"}
FLAT = {"14": [[1000, -30], [1520, 0], [1521, 0.3], [1777.7, 30], [1990, 30]]}
OTHER = {"neutral": 1520, "range": [1000, 2000], "step": 7, "dead_band": "neutral", "curve": FLAT}
ONE = {**USUAL, "curve": {"16": AT_16}}
WIDE = {"16": [[-3200, -40], [-160, 0], [160, 0], [3200, 51]]}
AHEAD = {"16": [[1000, 0], [1100, 0], [1800, 50], [2000, 50]]}
KINDS = {
    "the T200's table": {"neutral": 1500, "range": [1100, 1900], "curve": "t200", "volts": 16},
    "one voltage, some reversed": {**ONE, "reversed": [1, 2]},
    "all reversed, to neutral in the dead band": {**USUAL, "reversed": True, "dead_band": "neutral"},
    "DShot 3D in steps": {"neutral": 0, "range": [-3200, 3200], "step": 8, "curve": WIDE},
    "a share of full power": {"neutral": 0, "range": [-1, 1], "step": 0.01},
    "RPM beyond 16 bits": {"neutral": 0, "range": [-60000, 60000], "step": 10},
    "a voltage that is no binary fraction": {**USUAL, "curve": {"14.8": AT_16}},
    "two that are none": {**USUAL, "curve": {"11.1": CURVE["12"], "14.8": AT_16}, "volts": 14.8},
    "ahead only, flat at its end": {"neutral": 1000, "range": [1000, 2000], "curve": AHEAD},
    "each another": [USUAL, ONE, OTHER, {**OTHER, "reversed": True}],
}
REAL = {"double": np.float64, "float": np.float32}
SANITIZED = ["-fsanitize=undefined,float-divide-by-zero,float-cast-overflow", "-fno-sanitize-recover=all"]


def vehicle(folder: Path, esc: object, **keys: object) -> Vehicle:
    """Four thrusters in the plane with these ESCs."""
    usual = {
        "name": "wired",
        "dof": ["surge", "sway", "yaw"],
        "T": [[1, 1, 1, 1], [1, -1, -1, 1], [0.3, 0.3, -0.3, -0.3]],
        "f_min": -40,
        "f_max": 60,
    }
    (folder / "wired.yaml").write_bytes(msgspec.yaml.encode(usual | {"esc": esc} | keys))
    return load_vehicle(folder / "wired.yaml")


def self_test(
    of: Vehicle, folder: Path, *, single: bool, limits: str, method: str = "scaled"
) -> Callable[..., str]:
    """Output of the self-test by what is edited in the C before; the kernel is the same for all edits."""
    files = generate(of, method, scalar="float" if single else "double", limits=limits, esc=True)
    units = write(folder, files)
    (esc,) = (name for name in units if name.endswith("_esc.c"))
    (kernel,) = (name for name in units if not re.search(r"_(esc|test)\.c$", name))
    own = {name: files[name] for name in (kernel, f"{kernel.removesuffix('.c')}.h")}
    once = compiled.shared_library("esc_kernel", own, ["-std=c99", "-O1", *WARNINGS, "-c"], ".o")
    tested = [name for name in units if re.search(r"_esc(_test)?\.c$", name)]
    command = [*compiled.compiler(), "-std=c99", "-O1", *WARNINGS, "-I.", *SANITIZED, *tested, str(once)]

    def output(old: str = "", new: str = "") -> str:
        assert old in files[esc]
        write(folder, {esc: files[esc].replace(old, new)})
        made = run([*command, "-o", "selftest"], folder)
        assert made.returncode == 0, made.stderr
        done = run(["./selftest"], folder)
        assert "wrong" in done.stdout, done.stderr
        assert (done.returncode == 0) == (" 0 wrong" in done.stdout)
        return done.stdout

    return output


def overlooked(output: Callable[..., str], *edits: tuple[str, str]) -> list[tuple[str, str]]:
    """Edits of the C that its self-test does not find."""
    return [edit for edit in edits if " 0 wrong" in output(*edit)]


def loaded(of: Vehicle, method: str, kind: str, scalar: Scalar = "double", limits: Where = "call") -> Any:
    """NAME_esc or NAME_to_esc, compiled and loaded."""
    target = Target(vehicle=of, method=recipe(method), scalar=scalar, limits=limits)
    library = ctypes.CDLL(str(compiled.shared_library(target.name, sources(target) | to_escs(target))))
    send = library[f"{target.name}_{kind}"]
    array = np.ctypeslib.ndpointer(dtype=REAL[scalar])
    number = ctypes.c_double if scalar == "double" else ctypes.c_float
    sides, fault = [array] * 2 * (limits == "call"), [ctypes.c_int] * (kind == "to_esc")
    shares = [array] * (kind == "to_esc" and target.levels > 0)
    send.argtypes = [array, *sides, *fault, number, np.ctypeslib.ndpointer(dtype=np.int16), array, *shares]
    return send


@pytest.mark.parametrize("limits", [pytest.param("fixed", marks=pytest.mark.long), "call"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_self_test_finds_what_python_sends_and_nothing_undefined(kind, limits, tmp_path: Path) -> None:
    single = list(KINDS).index(kind) % 2 == (limits == "call")
    method = "scaled" if limits == "call" else "clip"
    said = self_test(vehicle(tmp_path, KINDS[kind]), tmp_path, single=single, limits=limits, method=method)()
    assert re.search(r"96 cases; 0 wrong", said), said


@pytest.mark.parametrize(
    "keys", [{"f_min": [-40, -5, 0, -40], "f_max": [60, 5, 20, 0]}, {"f_min": 5, "f_max": 5.3}]
)
def test_limits_of_their_own_and_limits_without_zero_hold(keys, tmp_path: Path) -> None:
    of = vehicle(tmp_path, USUAL, **keys)
    said = self_test(of, tmp_path, single=True, limits="fixed", method="clip")()
    assert " 0 wrong" in said, said


BROKEN = [
    ("(int)(along", "1 + (int)(along"),
    ("(along * length", "(0.9F * along * length"),
    ("j = step.j;", "j = -step.j;"),
    ("step->j + by", "step->j"),
    ("made = step.makes;", "made = -step.makes;"),
    ("(x - wish) <=", "(x - wish) >="),
    ("UNKNOWN : tb", "CUT : tb"),
    ("while (above < x", "while (0 && above < x"),
    ("now->up = up <", "now->up = 2 * up <"),
    ("end > 0 ? ends->high", "end < 0 ? ends->high"),
]
CUT = [("cut = least <= most", "cut = 0"), ("low[i] = !cut ?", "low[i] = cut ?")]
ENDS = [
    ("j = end > 0", "j = end < 0"),
    ("end > 0 ? ends->high", "end < 0 ? ends->high"),
    ("(x - wish)", "(x + wish)"),
]


def test_a_broken_line_is_seen(tmp_path: Path) -> None:
    of = vehicle(tmp_path, USUAL, f_min=-25, f_max=30)  # beyond the curve at 12 V, within it at 16 V
    output = self_test(of, tmp_path, single=True, limits="fixed", method="clip")
    assert overlooked(output, *BROKEN) == []


def test_limits_that_are_not_cut_at_the_voltage_s_ends_are_seen(tmp_path: Path) -> None:
    output = self_test(vehicle(tmp_path, USUAL), tmp_path, single=True, limits="call")
    assert overlooked(output, *CUT) == []


def test_shares_within_fixed_limits_that_a_voltage_does_not_reach_are_refused(tmp_path: Path) -> None:
    """They were 1 where the thrusts made at 12 V turned the vehicle the other way."""
    of = vehicle(tmp_path, USUAL)
    says = r"thruster 0 makes -20 … 25 N at 12 V, expected -40 … 60 N .*; give --limits call"
    for method in ("scaled", "priority", "scaled-by-group"):
        with pytest.raises(NotApplicable, match=says):
            generate(of, method, esc=True)
    reached = vehicle(tmp_path, USUAL, f_min=-20, f_max=25)
    assert "wired_scaled_esc.c" in generate(reached, "scaled", esc=True)
    assert "wired_clip_esc.c" in generate(of, "clip", esc=True)  # says no shares


@pytest.mark.parametrize(("single", "limits"), [(True, "fixed"), (False, "call")])
@pytest.mark.parametrize("keys", [{}, {"f_min": [-40, -20, -40, -18], "f_max": [51, 20, 51, 19]}])
def test_a_thruster_at_the_end_of_its_curve_is_asked(single, limits, keys, tmp_path: Path) -> None:
    """Limits that are the ends of the curve, as where a file has none, left out all cases with one there."""
    of = vehicle(tmp_path, ONE, **{"f_min": -40, "f_max": 51} | keys)
    assert overlooked(self_test(of, tmp_path, single=single, limits=limits), *ENDS) == []


def test_any_bits_give_commands_within_the_range_and_thrusts_within_the_limits(tmp_path: Path) -> None:
    """Arguments are bits, so that NaN, infinities, the tiniest and the largest numbers come up often."""
    send = loaded(vehicle(tmp_path, USUAL), "nullspace", "esc", "float")
    rng = np.random.default_rng(5)
    pool = np.array([0, -0.0, 1e-45, 1e-38, 3e38, -3e38, np.nan, np.inf, -np.inf, 5, -5, 40, -40], np.float32)
    for _ in range(3000):
        words = rng.integers(0, 2**32, 13, dtype=np.uint32).view(np.float32)
        words = np.where(rng.random(13) < 0.6, rng.choice(pool, 13), words).astype(np.float32)
        f, low, high = (np.ascontiguousarray(part) for part in words[:12].reshape(3, 4))
        u, made = np.zeros(4, np.int16), np.full(4, 777, np.float32)
        status = send(f, low, high, float(words[12]), u, made)
        assert status in (0, 1, -2)
        assert ((u >= 1100) & (u <= 1900)).all()
        assert (u[~np.isfinite(f)] == 1500).all()
        assert (status == -2) == (not np.isfinite(f).all())
        around = (low <= 0) & (high >= 0)
        assert ((made >= low) & (made <= high))[around].all(), (f, low, high, made)
        assert (made[~(low <= high)] == 0).all()


@pytest.mark.parametrize("scalar", ["double", "float"])
def test_at_the_limits_of_any_voltage_python_and_c_send_the_same_ends(scalar: Scalar, tmp_path: Path) -> None:
    """Limits and curve are interpolated in another order, and last bits between them decide nothing."""
    ends = {12: (-27.459, 35.304), 14: (-33.343, 43.149), 16.8: (-41.188, 53.937)}
    curve = {volts: [[1100, low], [1500, 0], [1900, high]] for volts, (low, high) in ends.items()}
    of = vehicle(tmp_path, {**USUAL, "step": 2, "curve": curve}, f_min=-50)
    send, real = loaded(of, "clip", "esc", scalar), REAL[scalar]
    u, made = np.zeros(4, np.int16), np.zeros(4, real)
    for volts in np.linspace(12.0, 16.8, 401).astype(real).astype(float):
        exact = of.limits(volts=volts)
        low, high = (side.astype(real) for side in exact)
        for side, end in ((0, 1100), (1, 1900)):
            assert send((low, high)[side], low, high, volts, u, made) == Status.SOLVED
            sent = of.commands(exact[side], volts, f_min=exact[0], f_max=exact[1])
            assert set(u.tolist()) == set(sent.u.tolist()) == {end}
            assert ((made >= low) & (made <= high) & (sent.f >= exact[0]) & (sent.f <= exact[1])).all()


def gap(of: Vehicle, f: np.ndarray, volts: float, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The most (n,) that steps of commands take from thrusts f (n,) [N], from all thrusts that can be made.

    Half the way between the two beside f; all of it where the nearer lies beyond a limit, and in a dead band
    whose thrusts go to neutral.
    """
    allowed = np.empty(of.n)
    for i, esc in enumerate(of.esc):
        u = np.arange(esc.low, esc.high + esc.step / 2, esc.step)
        makes = np.unique(of.thrusts(np.tile(u[:, None], (1, of.n)), volts)[:, i])
        at = np.clip(np.searchsorted(makes, f[i]), 1, len(makes) - 1)
        below, above = makes[at - 1], makes[at]
        whole = below < low[i] or above > high[i] or (not esc.jump and 0.0 in (below, above))
        allowed[i] = (above - below) * (1.0 if whole else 0.5)
    return allowed


def random_vehicle(folder: Path, rng: np.random.Generator) -> Vehicle:
    """Four thrusters with curves at two voltages and limits beyond some of them; a level for each axis."""
    curve = {}
    for volts, most in ((12.0, 1.0), (16.0, float(rng.uniform(1.2, 2.5)))):
        astern, ahead = (most * rng.uniform([15.0, 20.0], [25.0, 35.0])).tolist()
        curve[volts] = [[1100, -astern], [1300, -0.3 * astern], [1470, 0], [1530, 0], [1900, ahead]]
    esc = {**USUAL, "curve": curve, "dead_band": rng.choice(["jump", "neutral"]).item()}
    T = rng.uniform(-1.0, 1.0, (3, 4)).round(2).tolist()
    levels = rng.permutation(["surge", "sway", "yaw"])[:, None].tolist()
    ends = {"f_min": rng.uniform(-60.0, -10.0, 4).tolist(), "f_max": rng.uniform(15.0, 90.0, 4).tolist()}
    return vehicle(folder, esc | {"step": rng.choice([1, 4]).item()}, T=T, priority=levels, **ends)


@pytest.mark.parametrize("method", ["scaled", "priority"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(each, marks=pytest.mark.long) for each in (1, 2))])
def test_shares_are_of_what_the_escs_make_at_any_voltage(method: str, seed: int, tmp_path: Path) -> None:
    """With 12 V of a curve that ends lower there, shares were 1 and the thrusts made gave a half or less."""
    rng = np.random.default_rng(seed)
    of = random_vehicle(tmp_path, rng)
    send = loaded(of, method, "to_esc")
    allocate, levels = build(method, of), of.priority if method == "priority" else (of.dof,)
    u, made, share = np.zeros(4, np.int16), np.zeros(4), np.zeros(len(levels))
    below_one = 0
    for volts in rng.uniform(10.0, 18.0, 100).tolist():
        tau = of.T @ rng.uniform(of.f_min, of.f_max) * rng.uniform(0.0, 1.5)
        low, high = of.esc_limits(volts)
        answer = allocate(tau, low, high)
        status = send(tau, of.f_min.copy(), of.f_max.copy(), -1, volts, u, made, share)
        assert share == pytest.approx(answer.share, abs=1e-6)
        sent, allowed = of.commands(answer.f, volts), gap(of, answer.f, volts, low, high) + 1e-6
        assert u.tolist() == sent.u.tolist()
        assert made == pytest.approx(of.thrusts(u, volts), abs=1e-9)
        assert (np.abs(made - answer.f) <= allowed).all()
        wrench, missed = of.TP @ made, np.abs(of.TP) @ allowed
        for axes, delivered in zip(levels, share, strict=True):
            rows = [of.dof.index(axis) for axis in axes]
            assert (np.abs(wrench - delivered * tau)[rows] <= missed[rows]).all()
        assert (wrench * np.sign(tau) >= -missed).all()
        assert status != Status.SOLVED or (np.abs(wrench - tau) <= missed).all()
        assert status == Status.PARTIAL or (share == 1).all()
        below_one += (share < 1).any()
    assert 20 < below_one < 80


def test_a_thruster_that_is_off_and_a_demand_that_is_not_met_are_neutral(tmp_path: Path) -> None:
    send = loaded(vehicle(tmp_path, USUAL), "nullspace", "to_esc", limits="fixed")
    u, made = np.zeros(4, np.int16), np.full(4, 777.0)
    assert send(np.array([60.0, 0.0, 0.0]), 2, 16.0, u, made) == 0
    assert u[2] == 1500
    assert (u != 1500).sum() == 3 or made[2] == 0
    for tau, fault, status in (([900.0, 0, 0], -1, 2), ([np.nan, 0, 0], -1, -2), ([1.0, 0, 0], 7, -1)):
        u[:], made[:] = 1234, 777
        assert send(np.array(tau), fault, 16.0, u, made) == status
        assert (u == 1500).all()
        assert (made == 0).all()


def test_the_header_says_which_commands_go_to_which_thrusters(tmp_path: Path) -> None:
    files = generate(vehicle(tmp_path, [USUAL, ONE, OTHER, OTHER]), "pinv", esc=True)
    assert (
        " * command  what goes to the ESCs: 1100 to 1900, neutral is 1500, of 0, 1;\n"
        " *          1000 to 2000, neutral is 1520, of 2, 3 (thrusters counted from 0)\n"
    ) in files["wired_pinv_esc.h"]
    alone = generate(vehicle(tmp_path, USUAL), "pinv", esc=True)["wired_pinv_esc.h"]
    assert "what goes to the ESCs: 1100 to 1900, neutral is 1500\n" in alone
