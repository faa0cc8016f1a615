"""Plug-ins: methods from files outside of the tree."""

from pathlib import Path

import pytest

from alloc import UnknownName, load_plugin

DATACLASS = '''\
"""Postponed annotations, which dataclasses resolve through the module that a class is in."""
from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Gains:
    gain: float


def build(vehicle):
    return Gains(1.0)
'''


def test_a_plugin_may_hold_a_dataclass_with_postponed_annotations(tmp_path: Path) -> None:
    (tmp_path / "with_gains.py").write_text(DATACLASS, encoding="utf-8")
    assert load_plugin(tmp_path / "with_gains.py").name == "with-gains"


@pytest.mark.parametrize(
    "line", ["STARTS = 'cold'", "STARTS = ()", "STARTS = ('lukewarm',)", "LEVELS = ['sloppy']", "LEVELS = 3"]
)
def test_starts_and_levels_that_no_run_would_ask_for_are_refused(tmp_path: Path, line: str) -> None:
    (tmp_path / "mine.py").write_text(f"from alloc.methods.pinv import build\n{line}\n")
    with pytest.raises(UnknownName, match=f"mine.py: {line[:6]} = .*; give a tuple of"):
        load_plugin(tmp_path / "mine.py")


@pytest.mark.parametrize(
    ("line", "starts"), [("STARTS = ['cold', 'warm']", ("cold", "warm")), ("STARTS = ('-',)", ("-",))]
)
def test_starts_may_be_a_list_or_no_choice(tmp_path: Path, line: str, starts: tuple[str, ...]) -> None:
    (tmp_path / "mine.py").write_text(f"from alloc.methods.pinv import build\n{line}\n")
    assert load_plugin(tmp_path / "mine.py").starts == starts
