"""Measurements that `thrustbench gate` asks for."""

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from alloc import AllocError
from alloc.discovery import load_plugin
from bench.commands.gate import command
from bench.gate.record import matching_cells


@pytest.mark.parametrize("name", ["my_pinv", "mine[1]"])
def test_a_plug_in_is_measured_under_its_methods_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    asked: list[str] = []

    def gate(*_: object, patterns: list[str], **__: Any) -> None:
        asked.extend(patterns)
        raise AllocError("nothing is measured in this test")

    monkeypatch.setattr("bench.gate.run.gate", gate)
    plugin = tmp_path / f"{name}.py"
    plugin.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    arguments = ["--base-path", str(tmp_path), "--head-path", str(tmp_path), "--plugin", str(plugin)]
    CliRunner().invoke(command, arguments)
    method = load_plugin(plugin).name
    assert [cell.name for cell in matching_cells([["ukwial", method, "-"]], asked)] == [f"ukwial:{method}:-"]
