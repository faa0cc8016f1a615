"""Remarks of `check` on curves, currents and a cap: a slip gives its remark, and a sound file gives none."""

import re
from pathlib import Path

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.lint.check import check_vehicle

SOUND = "neutral: 0, range: [-100, 100], curve: {16: [[-100, -30], [-9, 0], [9, 0], [100, 40]]}"


def remarks(folder: Path, esc: str, rest: str = "") -> str:
    (folder / "mine.csv").write_text("command,N\n-100,-30\n-9,0\n9,0\n100,40\n")
    path = folder / "mine.yaml"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\nesc: {{{esc}}}\n{rest}\n")
    found = check_vehicle(path).findings
    assert not [finding for finding in found if finding.level == "error"]
    return "\n".join(finding.message for finding in found)


SLIPS = {
    "no 'volts', and the curve has 12 to 16 V, so each call must say the voltage": (
        SOUND.replace("curve: {", "curve: {12: [[-100, -20], [0, 0], [100, 30]], "),
        "f_min: -30\nf_max: 40",
    ),
    "the curves at 10 V and 16 V are the same in all 4 points": (
        SOUND.replace("curve: {", "curve: {10: [[-100, -30], [-9, 0], [9, 0], [100, 40]], "),
        "f_min: -30\nf_max: 40",
    ),
    "is not monotone": (SOUND.replace("[9, 0]", "[9, 0], [50, 30], [60, 20]"), ""),
    "makes 18 N at neutral, 50": (SOUND.replace("neutral: 0", "neutral: 50"), ""),
    "astern is stronger than ahead": (SOUND.replace("-30]", "-60]"), ""),
    "is one of them in kgf?": (SOUND, "f_min: -3.06\nf_max: 4.08"),
    "35 N is less than the 40 N of the curve at 16 V": (SOUND, "f_min: -30\nf_max: 35"),
    "45 N is more than the 40 N of the curve at 16 V: the ESC can't": (SOUND, "f_min: -30\nf_max: 45"),
    "35 N is less than the 40 N of the curve": (
        f"{SOUND[: SOUND.index('curve')]}curve: mine.csv",
        "f_min: -30\nf_max: 35",
    ),
    "thruster 1: 45 N is more than the 40 N": (SOUND, "f_min: -30\nf_max: [40, 45]"),
    "-30 N, but the curve has no thrust that way": (
        "neutral: 0, range: [0, 100], curve: {16: [[0, 0], [100, 40]]}",
        "f_min: -30\nf_max: 40",
    ),
    "'volts' is 12 V": (f"{SOUND}, volts: 12", ""),
    "of the range -100 … 100 the curve has -100 … 80 alone": (SOUND.replace("[100, 40]", "[80, 33]"), ""),
    "coarser than the dead band": (f"{SOUND}, step: 25", ""),
    "a step of 1 is coarser than the dead band, 0.6": (SOUND.replace("9, 0]", "0.3, 0]"), ""),
    "if the range is of DShot 3D": ("neutral: 1048, range: [48, 2047]", "f_min: -30\nf_max: 40"),
    "no 'curve'": ("neutral: 0, range: [-100, 100]", "f_min: -30\nf_max: 40"),
}


@pytest.mark.parametrize("said", SLIPS)
def test_a_slip_gives_its_remark_and_a_sound_file_does_not(tmp_path: Path, said: str) -> None:
    assert said in remarks(tmp_path, *SLIPS[said])
    assert said not in remarks(tmp_path, SOUND)


@pytest.mark.parametrize(
    ("esc", "told"),
    [
        ("neutral: 0, range: [-100, 100], curve: {16: [[-90, -30], [0, 0], [90, 40]]}", []),  # 5 %
        ("neutral: 0, range: [-1, 1], step: 0.01, curve: {16: [[-1, -30], [0, 0], [0.89, 40]]}", ["-1 … 1"]),
        ("neutral: 1000, range: [1000, 2000], curve: {16: [[1000, 0], [1200, 0], [2000, 40]]}", []),
        ("neutral: 0, range: [-50, 100], curve: {16: [[-100, -30], [0, 0], [100, 40]]}", []),
        # A curve is given as if the ESC were not reversed, and the range is what goes over the wire.
        ("neutral: 0, range: [-50, 100], reversed: true, curve: {16: [[-100, -30], [0, 0], [50, 40]]}", []),
        (
            "neutral: 0, range: [-50, 100], reversed: [1], curve: {16: [[-50, -30], [0, 0], [100, 40]]}",
            ["-100 … 50 (mirrored, for 'reversed')"],
        ),
        (
            "neutral: 0, range: [-100, 100], reversed: [1], curve: {16: [[-80, -30], [0, 0], [80, 40]]}",
            ["-100 … 100"],
        ),
    ],
)
def test_a_curve_that_ends_before_the_range_is_remarked_once(
    tmp_path: Path, esc: str, told: list[str]
) -> None:
    assert re.findall(r"of the range (.*) the curve has", remarks(tmp_path, esc)) == told


def test_curves_of_one_voltage_say_that_no_other_was_measured(tmp_path: Path) -> None:
    """A curve without a voltage gets no remark: it stands for all."""
    assert "all curves share 16 V alone; at another one thrusts count" in remarks(tmp_path, SOUND)
    assert "alone" not in remarks(tmp_path, "neutral: 0, range: [-100, 100], curve: mine.csv")


CURVE = (
    "{{neutral: 0, range: [-100, 100], volts: {volts}, curve: {{{volts}: [[-100, -30], [0, 0], [100, 40]]}}}}"
)


def test_curves_of_two_supplies_have_no_voltage_in_common(tmp_path: Path) -> None:
    """The C asked whether a voltage was at least 48 and at most 16, and its status was 1 at every call."""
    path = tmp_path / "mine.yaml"
    both = f"[{CURVE.format(volts=48)}, {CURVE.format(volts=16)}]"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\nesc: {both}\n")
    said = [finding.message for finding in check_vehicle(path).findings if finding.level == "warning"]
    assert any(line.startswith("no voltage lies in all curves; at another one") for line in said)


@pytest.mark.parametrize(("slew", "warned"), [(200, True), (1000, False)])
def test_a_step_that_is_coarser_than_slew_rates_allow_between_calls_is_warned_of(
    tmp_path: Path, slew: int, warned: bool
) -> None:
    """Thrusts that started from what the ESC made stood still for ever: each change was rounded away."""
    esc = "neutral: 0, range: [-100, 100]"
    said = remarks(tmp_path, esc, f"f_min: -250\nf_max: 250\nslew: {slew}")
    assert ("above 80 Hz thruster 0 may change by less between two calls than a step" in said) == warned
    vehicle = load_vehicle(tmp_path / "mine.yaml")
    allocate, kept = build("scaled", vehicle), {"made": np.zeros(2), "allocated": np.zeros(2)}
    for _ in range(200):
        for which, f in kept.items():
            f = allocate([300, 0], *vehicle.limits(f_previous=f, dt=0.01)).f
            kept[which] = vehicle.commands(f).f if which == "made" else f
    assert (kept["made"].sum() == pytest.approx(300, rel=0.02)) != warned
    assert kept["allocated"].sum() == pytest.approx(300)


@pytest.mark.parametrize(
    ("volts", "rest", "noted"), [(14, "", True), (16, "", False), (14, "f_min: -30\nf_max: 40", False)]
)
def test_limits_that_were_left_out_are_those_at_the_usual_voltage_and_check_says_so(
    tmp_path: Path, volts: int, rest: str, noted: bool
) -> None:
    """A full battery was held to them without a word: what the ESC made "could not be met"."""
    curve = "curve: {12: [[-100, -20], [0, 0], [100, 30]], 16: [[-100, -30], [0, 0], [100, 40]]}"
    said = remarks(tmp_path, f"neutral: 0, range: [-100, 100], volts: {volts}, {curve}", rest)
    assert ("limits were left out, so those at 'volts', 14 V, hold at more, too: at 16 V" in said) == noted
    vehicle = load_vehicle(tmp_path / "mine.yaml")
    assert (vehicle.limits(volts=16.0)[1] == (35 if noted else 40)).all()


CONVEX, BENT = "[[-100, 8], [0, 0], [50, 2], [100, 9]]", "[[-100, 8], [0, 0], [50, 6], [100, 9]]"


def currents(at_12: str, at_16: str) -> str:
    """An ESC with currents at two voltages."""
    curve = "12: [[-100, -30], [0, 0], [100, 40]], 16: [[-100, -40], [0, 0], [100, 50]]"
    current = f"{{12: {at_12}, 16: {at_16}}}"
    return f"neutral: 0, range: [-100, 100], volts: 12, curve: {{{curve}}}, current: {current}"


def test_check_says_what_all_draw_at_once_and_what_the_cap_leaves(tmp_path: Path) -> None:
    said = remarks(tmp_path, currents(CONVEX, CONVEX))
    assert "all thrusters at their limits together draw 18 A at 12 V; if a fuse gives less" in said
    said = remarks(tmp_path, currents(CONVEX, CONVEX), "cap: {amps: 12, reserve: 2}")
    assert "together draw 18 A at 12 V; the cap leaves them 10 A" in said


def test_check_says_how_far_the_convex_curve_lies_above(tmp_path: Path) -> None:
    # Of 9 A at 40 N a straight line has 4.5 A at 20 N. There 6 A were measured, so the end is raised to 12.
    assert "lies above, by at most 3 A, at 40 N and 12 V" in remarks(tmp_path, currents(BENT, CONVEX))
    assert "not convex" not in remarks(tmp_path, currents(CONVEX, CONVEX))


def test_check_names_two_voltages_with_the_same_currents(tmp_path: Path) -> None:
    assert "the currents at 12 V and 16 V are the same in all 4 points" in remarks(
        tmp_path, currents(CONVEX, CONVEX)
    )
    assert "are the same in all" not in remarks(tmp_path, currents(CONVEX, BENT))


def test_a_law_of_the_current_is_no_error_and_says_what_all_draw(tmp_path: Path) -> None:
    law = "current: {ahead: 0.1, astern: 0.2, power: 1.5}"
    said = remarks(tmp_path, f"{SOUND}, {law}", "f_min: -25\nf_max: 25\ncap: {amps: 20}")
    assert "all thrusters at their limits together draw 50 A; the cap leaves them 20 A" in said
