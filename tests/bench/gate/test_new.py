"""Cells of head alone are judged by equations: a right answer is new, a wrong one a regression."""

import re
from pathlib import Path

import pytest
from click.testing import Result

import gate_check
from tests.gate_sides import PLUGIN, run_gate

pytestmark = pytest.mark.usefixtures("few_demands")

FEW = ("--pairs", "2", "--no-instructions")
WRONG = PLUGIN.replace("G @ tau", "-G @ tau")
REFUSING = PLUGIN.replace("    G =", "    raise NotApplicable('not this one')\n    G =")
BROKEN = f"import no_such_module\n{PLUGIN}"
CELL = "`ukwial:mine:-`"


def gate(folder: Path, base: str, head: str, *options: str) -> Result:
    """Verdict of the gate on a commit that gives the plug-in mine.py another text; none is no file."""
    gate_check.git(folder, "init", "--quiet")
    (folder / "notes.txt").touch()
    for text in (base, head):
        if text:
            (folder / "mine.py").write_text(text)
        gate_check.commit(folder, "plug-in")
    given = ("--vehicle", "ukwial", "--plugin", str(folder / "mine.py"), *options, *FEW)
    return run_gate("HEAD~1", "HEAD", "--repo", folder, *given)


@pytest.mark.parametrize("base", ["", REFUSING, BROKEN], ids=["none", "refusing", "broken"])
def test_what_head_alone_has_fails_where_it_is_wrong_and_is_new_where_it_is_right(
    tmp_path: Path, base: str
) -> None:
    """The same holds where base has no such plug-in, one that refused the vehicle, or one not imported."""
    for name, head in (("wrong", WRONG), ("right", PLUGIN)):
        (tmp_path / name).mkdir()
        result = gate(tmp_path / name, base, head)
        assert result.exception is None, result.output
        assert result.return_value == (1 if name == "wrong" else 3), result.output
        assert (f"| {CELL} | new, and wrong: " in result.stdout) == (name == "wrong")
        assert (f"new: {CELL}" in result.stdout) == (name == "right")


def test_a_wrong_plug_in_that_is_added_beside_a_right_one_fails(tmp_path: Path) -> None:
    """It passed: what base had was still right."""
    (tmp_path / "old.py").write_text(PLUGIN)
    result = gate(tmp_path, "", WRONG, "--plugin", str(tmp_path / "old.py"))
    assert result.return_value == 1, result.output
    assert "Gate: regression: answers are wrong" in result.stdout
    assert f"| {CELL} | new, and wrong: 500 N from the optimum" in result.stdout
    assert f"new: {CELL}" not in result.stdout
    assert "old" not in result.stdout


def test_a_new_plug_in_that_gives_a_tenth_of_what_is_asked_is_remarked(tmp_path: Path) -> None:
    """Newtons taken for kgf: what promises no more is right, and meets no demand."""
    result = gate(tmp_path, "", PLUGIN.replace("G @ tau", "G @ tau / 9.80665"))
    assert re.search(
        rf"new, and gives less than is asked: {CELL}: SOLVED for \d+ of [\d,]+ demands", result.stdout
    )


def test_a_commit_that_mends_little_and_turns_what_is_beyond_reach_is_a_regression(tmp_path: Path) -> None:
    """Base passed limits by rounding, and then no answer beyond reach counted as evidence."""
    rule = "min(1.0, *(np.where(f > 0, vehicle.f_max, vehicle.f_min) / np.where(f == 0, 1e-300, f)))"
    base = PLUGIN.replace("lambda tau: np.clip(G @ tau, vehicle.f_min, vehicle.f_max)", "allocate").replace(
        "    return",
        f"    def allocate(tau):\n        f = G @ tau\n        s = {rule}\n        return s * f\n    return",
    )
    head = base.replace(
        "return s * f", "return np.clip(f if s == 1 else -s * f, vehicle.f_min, vehicle.f_max)"
    )
    result = gate(tmp_path, base, head)
    assert result.return_value == 1, result.output
    assert f"| {CELL} | another answer: " in result.stdout


def test_a_commit_that_mends_a_sign_is_no_regression(tmp_path: Path) -> None:
    """A PARTIAL answer that is SOLVED now was called another answer, beside the remark that it is mended."""
    result = gate(tmp_path, WRONG, PLUGIN)
    assert result.return_value in (0, 3), result.output  # 3 where this machine is too busy to time calls
    assert f"mended: {CELL}" in result.stdout


def test_a_new_plug_in_that_does_not_cover_the_vehicle_is_named_with_its_reason(tmp_path: Path) -> None:
    result = gate(tmp_path, "", REFUSING)
    assert result.return_value == 3, result.output
    assert f"new, and does not cover the vehicle: {CELL}: NotApplicable: not this one" in result.stdout


@pytest.mark.parametrize(
    ("spoil", "code", "says"),
    [
        ("", 3, "new: `other:nullspace:-`"),
        ("T: 3", 1, "| `other:nullspace:-` | new, and wrong: VehicleError"),
    ],
)
def test_a_new_vehicle_of_the_library_is_judged_by_its_own_numbers(
    tmp_path: Path, spoil: str, code: int, says: str
) -> None:
    tree = tmp_path / "repository"
    gate_check.copy(tree)
    vehicles = tree / "alloc" / "vehicles"
    (vehicles / "other.yaml").write_text(spoil or (vehicles / "ukwial.yaml").read_text())
    gate_check.commit(tree, "head")
    result = run_gate("HEAD~1", "HEAD", "--repo", tree, "--cells", "other:nullspace", *FEW)
    assert result.exception is None, result.output
    assert result.return_value == code, result.output
    assert says in result.stdout
