"""Plug-ins: methods from files outside of the tree."""

from pathlib import Path

from alloc import load_plugin

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
