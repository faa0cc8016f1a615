"""Refusals, in one line, of what takes no thrusters that turn: nothing answers by their boxes."""

import re
from pathlib import Path

import pytest

from alloc import NotApplicable, Vehicle, build, catalogue, generate, load_vehicle
from alloc.discovery import load_plugin, prepare
from bench.__main__ import main
from tests.azimuths import FERRY, boats

COMMANDS = (
    "board --vehicle boat.yaml --method nullspace --out out",
    "check boat.yaml --probe",
    "check boat.yaml --failures",
    "check boat.yaml --autopilot px4",
    "codegen --vehicle boat.yaml --method clip --out out",
    "codegen --vehicle boat.yaml --method nullspace --faults all --out out",
    "codegen --vehicle boat.yaml --method nullspace --limits call --out out",
    "codegen --vehicle boat.yaml --method nullspace --monitor --out out",
    "demands limited.csv --vehicle boat.yaml",
    "demands asked.csv --vehicle boat.yaml --from-outputs",
    "export boat.yaml --format px4",
    "gate HEAD HEAD --vehicle boat.yaml",
    "init mine --like boat.yaml --language c",
    "layouts study.yaml --out out",
    "allocate --vehicle boat.yaml --method nullspace --names asked.csv",
    "allocate --vehicle boat.yaml --method nullspace limited.csv",
    "allocate --vehicle boat.yaml --method walsh asked.csv",
    "allocate --vehicle boat.yaml --method qp-soft/daqp asked.csv",
    "allocate --vehicle boat.yaml --method qp/sip asked.csv",
    "allocate --vehicle boat.yaml --method nullspace --esc asked.csv",
    "allocate --vehicle boat.yaml --method scaled --cap 20 asked.csv",
    "codegen --vehicle boat.yaml --library --out out",
    "prove --vehicle boat.yaml --method nullspace --out out",
)


@pytest.mark.parametrize("line", COMMANDS)
def test_a_command_that_takes_no_azimuths_says_so_in_one_line(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "boat.yaml").write_text(FERRY)
    (tmp_path / "asked.csv").write_text("surge,sway,yaw\n1,2,3\n")
    (tmp_path / "limited.csv").write_text("surge,sway,yaw,f0_max\n1,2,3,50\n")
    (tmp_path / "study.yaml").write_text(
        "base: boat.yaml\ngroups: {bow: {thrusters: [0], azimuth_deg: [1, 9]}}\n"
    )
    monkeypatch.setattr("sys.argv", ["thrustbench", *line.split()])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    place = "study.yaml, line 1: base: thrusters[0]" if "study" in line else "boat.yaml, line 4: thrusters[0]"
    assert said[0].startswith(f"thrustbench: {place}")
    assert "azimuth" in said[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", [entry.name for entry in catalogue() if not entry.azimuths])
def test_a_method_that_takes_no_azimuths_says_so_with_its_name(name: str) -> None:
    entry = next(entry for entry in catalogue() if entry.name == name)
    if entry.missing:
        pytest.skip(entry.missing)
    with pytest.raises(
        NotApplicable, match=f"^{name} takes no azimuth thrusters yet: .*; see docs/azimuth.md$"
    ):
        build(name, boat())


@pytest.mark.parametrize("method", ["clip", "scaled", "pinv", "soft"])
def test_methods_whose_c_knows_boxes_alone_write_none_for_azimuths(method: str) -> None:
    with pytest.raises(NotApplicable, match="in C takes no azimuth thrusters yet"):
        generate(boat(), method)


def test_a_plug_in_takes_azimuths_only_where_it_says_so(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    with pytest.raises(NotApplicable, match="mine takes no azimuth thrusters yet"):
        prepare(load_plugin(file), boat())
    file.write_text("from alloc.methods.pinv import FORMULATION, build\nAZIMUTHS = True\n")
    assert prepare(load_plugin(file), boat())([1.0, 0.0, 0.0]).found


def boat() -> Vehicle:
    return boats(1)[0]


def test_a_method_that_refuses_a_file_s_polygons_names_file_and_key(tmp_path: Path) -> None:
    """Red before: of a null space too large for steps only the method was named."""
    file = tmp_path / "boat.yaml"
    more = "".join(f"  - {{position: [{x}, 1, 0], azimuth: {{max: 100}}}}\n" for x in (0, 1))
    file.write_text(FERRY + more)
    place = re.escape(f"{file}, line 4: thrusters[0].azimuth: ")
    with pytest.raises(NotApplicable, match=f"^{place}nullspace: 4 thrusters"):
        build("nullspace", load_vehicle(file))
    with pytest.raises(NotApplicable, match=f"^{place}shrink takes no azimuth thrusters yet"):
        build("shrink", load_vehicle(file))
