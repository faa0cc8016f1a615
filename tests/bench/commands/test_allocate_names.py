"""`thrustbench allocate --names`: columns that are called as a user's thrusters are."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from alloc.errors import DemandError
from alloc.vehicle.file import find_file
from bench.__main__ import cli


def allocate(directory: Path, *options: str, vehicle: str = "ukwial", first: str) -> Result:
    """Thrusts of one demand on a shipped vehicle whose first thruster has this name."""
    text = find_file(vehicle).read_text(encoding="utf-8")
    n, dof = (8, "surge,sway,heave,roll,pitch,yaw") if vehicle != "ukwial" else (4, "surge,sway,yaw")
    others = "".join(f", t{i}" for i in range(1, n))
    mine, log = directory / "mine.yaml", directory / "log.csv"
    mine.write_text(f"{text}\nnames: ['{first}'{others}]\n", encoding="utf-8")
    for curve in find_file(vehicle).parent.glob("*.csv"):
        (directory / curve.name).write_bytes(curve.read_bytes())
    log.write_text(f"{dof}\n{','.join('1' * (dof.count(',') + 1))}\n")
    words = ["allocate", str(log), "--vehicle", str(mine), "--names", *options]
    return CliRunner().invoke(cli, words, standalone_mode=False)


@pytest.mark.parametrize("name", ["=1+1", "+cmd", "-2+3"])
def test_a_spreadsheet_shows_a_name_that_looks_like_a_formula(name: str, tmp_path: Path) -> None:
    printed = allocate(tmp_path, "--method", "pinv", first=name).stdout
    assert printed.splitlines()[0] == f"status,'{name},t1,t2,t3"


@pytest.mark.parametrize(
    ("name", "method", "vehicle", "more"),
    [
        ("status", "pinv", "ukwial", ()),
        ("share0", "scaled", "ukwial", ()),
        ("u0", "clip", "bluerov2-heavy", ("--esc",)),
        ("made_surge", "clip", "bluerov2-heavy", ("--esc",)),
    ],
)
def test_no_two_columns_have_one_name(
    name: str, method: str, vehicle: str, more: tuple[str, ...], tmp_path: Path
) -> None:
    result = allocate(tmp_path, "--method", method, *more, vehicle=vehicle, first=name)
    assert isinstance(result.exception, DemandError)
    assert str(result.exception).startswith(f"--names: two columns would be '{name}'; ")
    assert result.stdout == ""
