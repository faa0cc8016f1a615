"""Remarks of `check` on currents and a cap."""

from pathlib import Path

from alloc.lint.check import check_vehicle

CURVE = "12: [[-100, -30], [0, 0], [100, 40]], 16: [[-100, -40], [0, 0], [100, 50]]"
CONVEX = "[[-100, 8], [0, 0], [50, 2], [100, 9]]"
BENT = "[[-100, 8], [0, 0], [50, 6], [100, 9]]"


def remarks(folder: Path, at_12: str, at_16: str, rest: str = "") -> str:
    path = folder / "mine.yaml"
    current = f"{{12: {at_12}, 16: {at_16}}}"
    esc = f"neutral: 0, range: [-100, 100], volts: 12, curve: {{{CURVE}}}, current: {current}"
    path.write_text(f"name: two\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\nesc: {{{esc}}}\n{rest}\n")
    found = check_vehicle(path).findings
    assert not [finding for finding in found if finding.level == "error"]
    return "\n".join(finding.message for finding in found)


def test_check_says_what_all_draw_at_once_and_what_the_cap_leaves(tmp_path: Path) -> None:
    said = remarks(tmp_path, CONVEX, CONVEX)
    assert "all thrusters at their limits together draw 18 A at 12 V; if a fuse gives less" in said
    said = remarks(tmp_path, CONVEX, CONVEX, "cap: {amps: 12, reserve: 2}")
    assert "together draw 18 A at 12 V; the cap leaves them 10 A" in said


def test_check_says_how_far_the_convex_curve_lies_above(tmp_path: Path) -> None:
    # Of 9 A at 40 N a straight line has 4.5 A at 20 N. There 6 A were measured, so the end is raised to 12.
    assert "lies above, by at most 3 A, at 40 N and 12 V" in remarks(tmp_path, BENT, CONVEX)
    assert "not convex" not in remarks(tmp_path, CONVEX, CONVEX)


def test_check_names_two_voltages_with_the_same_currents(tmp_path: Path) -> None:
    assert "the currents at 12 V and 16 V are the same in all 4 points" in remarks(tmp_path, CONVEX, CONVEX)
    assert "are the same in all" not in remarks(tmp_path, CONVEX, BENT)
