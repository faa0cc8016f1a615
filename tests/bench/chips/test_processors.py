"""A processor is one file: who adds it edits nothing else, and it is found everywhere."""

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc import load_vehicle
from bench.__main__ import cli
from bench.chips import processors as room
from bench.chips.board.project import files, plan
from bench.chips.processors import names, processor, processors
from bench.proof import subject, worst
from bench.record import read
from tests.emulators import available

MADE_UP = """
from bench.chips.processors import cortex_m

PROCESSOR = cortex_m(
    "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", machine="mps2-an386", tick_hz=25_000_000,
    scalars=("float",), cpi=(1.5, 2.5), basis="made up for a test", goal=2.0,
)
"""


@pytest.fixture
def made_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a processor whose file lies beside the others."""
    available("cortex-m4f")
    (tmp_path / "processors").mkdir()
    (tmp_path / "processors/made_up.py").write_text(MADE_UP)
    monkeypatch.setattr(room, "__path__", [*room.__path__, str(tmp_path / "processors")])
    monkeypatch.delitem(sys.modules, f"{room.__name__}.made_up", raising=False)
    return "made-up"


def run(*words: str) -> str:
    result = CliRunner().invoke(cli, list(words), standalone_mode=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_a_made_up_processor_is_counted_listed_reported_and_sized(made_up: str, tmp_path: Path) -> None:
    """Two files of the same core, one of them made up, have the same counts and each its own cycles."""
    assert made_up in run("list")
    out = str(tmp_path / "run")
    asked = ["--vehicle", "ukwial", "--method", "pinv@native", "--float", "--limits", "fixed", "--n", "4"]
    run("emulate", *asked, "--target", made_up, "--target", "cortex-m4f", "--out", out)
    record = read(tmp_path / "run")
    by_target = {name: [r for r in record.emulated if r.target == name] for name in (made_up, "cortex-m4f")}
    assert [r.instructions for r in by_target[made_up]] == [r.instructions for r in by_target["cortex-m4f"]]
    details = (tmp_path / "run/details.md").read_text()
    assert f"### {made_up}" in details
    assert "1.5 to 2.5; made up for a test" in details
    assert f"{made_up} float" in details.partition("### What was asked for")[2]
    sized = run("size", out, "--rate", "100", "--clock", "100")
    assert "- made-up: 1.5 to 2.5; made up for a test." in sized


def test_a_made_up_processor_has_a_worst_path_and_a_board_of_qemu_s(
    made_up: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worst, "processors", lambda: [one for one in processors() if one.name == made_up])
    vehicle = load_vehicle("ukwial")
    paths, refuted, lacking = worst.worst_paths(subject(vehicle, "pinv", "float", "fixed"), {})
    assert not lacking + refuted
    assert [(path.target, path.exact) for path in paths] == [(made_up, True)]
    project = plan(vehicle, ("pinv@native",), ("active",), "float", "fixed", 3, 0)
    ports = files(project)  # both have QEMU's board of the Cortex-M4F, and a makefile each
    assert "PROCESSOR := cortex-m4f\n" in ports["ports/mps2-an386.mk"]
    assert f"PROCESSOR := {made_up}\n" in ports[f"ports/mps2-an386-{made_up}.mk"]


def test_each_file_is_a_processor_that_bears_its_name() -> None:
    stems = {path.stem for path in Path(room.__path__[0]).glob("*.py")} - {"__init__"}
    assert {name.replace("-", "_") for name in names()} == stems
    assert [one.name for one in processors()] == names() == sorted(names())
    assert [one.name for one in processors() if one.callgrind] == ["x86-64"]


def test_a_processor_of_a_record_says_what_reports_ask() -> None:
    """Only the file tells a float FPU with a minimum from one without."""
    facts = processor("cortex-m33").facts
    assert (facts.name, facts.scalars, facts.microcontroller) == ("cortex-m33", ["float"], True)
    assert facts.cpi[0] < facts.cpi[1]
