"""Escape sequences in other people's texts reach a terminal as letters, whichever command shows them."""

import sys
from pathlib import Path

import pytest
from rich.console import Console

from alloc.files.visible import visible
from bench.__main__ import main
from bench.report.terminal import tell
from tests import made_up

RED = "\x1b[31m"
AWKWARD = f"{RED}\u202ename\x07"
SHOWN = r"\x1b[31m\u202ename\x07"


def printed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, *line: str) -> str:
    """Output of the program on both streams."""
    monkeypatch.setattr(sys, "argv", ["thrustbench", *line])
    with pytest.raises(SystemExit):
        main()
    return "".join(capsys.readouterr())


def test_tables_keep_their_lines_and_letters_of_any_language() -> None:
    assert visible(f"ä\t漢字 µs\n{AWKWARD}\n") == f"ä\t漢字 µs\n{SHOWN}\n"


@pytest.mark.parametrize(
    ("name", "text", "method"),
    [
        ("log.csv", f"surge,sway,yaw,{AWKWARD}\n1,2,3,4\n", "pinv"),
        ("log.csv", f"surge,sway,{AWKWARD}\n1,2,3\n", "pinv"),
        ("odd.py", f"def build(vehicle):\n    raise ValueError({AWKWARD!r})\n", "odd --plugin odd.py"),
    ],
)
def test_a_header_and_an_exception_s_text(
    name: str,
    text: str,
    method: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text("surge,sway,yaw\n1,2,3\n")
    Path(name).write_text(text)
    line = f"allocate log.csv --vehicle ukwial --method {method}"
    said = printed(capsys, monkeypatch, *line.split())
    assert r"\x1b[31m\u202ename" in said
    assert RED not in said


def test_a_machine_s_name_in_a_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    header = made_up.header(machine={"name": AWKWARD})
    made_up.record(tmp_path, header, made_up.problem("ukwial"), made_up.exact_cell("ukwial", "pinv", 1.0))
    said = printed(capsys, monkeypatch, "size", str(tmp_path), "--rate", "50")
    assert f"{SHOWN} was" in said
    assert RED not in said


def test_a_line_of_a_run(capsys: pytest.CaptureFixture[str]) -> None:
    tell(Console(), f"warning: {AWKWARD} [red]")
    assert capsys.readouterr().out == f"warning: {SHOWN} [red]\n"
