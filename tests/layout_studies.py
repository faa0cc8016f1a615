"""Studies of layouts for tests to vary, and the spaces they make."""

from pathlib import Path

from alloc import Vehicle
from bench.layouts.compile import compile_study
from bench.layouts.space import LayoutSpace
from bench.layouts.study import read_study

PLANAR = """\
base: ukwial
groups:
  bow: {thrusters: [0, 1], azimuth_deg: {from: 10, to: 80}, x: {from: 0.1, to: 0.4}}
  stern: {thrusters: [2, 3], azimuth_deg: {from: 100, to: 170}, size: [0.5, 1, 2]}
demands: {n: 16}
"""
"""Four thrusters in the plane, mirrored to both sides; quick."""

HEAVY = """\
base: bluerov2-heavy
groups:
  across:
    thrusters: [0, 1, 2, 3]
    azimuth_deg: {from: 100, to: 170}
    cant_deg: {from: -30, to: 30}
  upright:
    thrusters: [4, 5, 6, 7]
    azimuth_deg: {from: -180, to: 180}
    cant_deg: {from: 60, to: 90}
center_of_mass: {z: {from: -0.02, to: 0.02}}
demands: {n: 32}
"""
"""Eight thrusters in six degrees of freedom."""


def compiled(folder: Path, text: str) -> tuple[LayoutSpace, Vehicle]:
    """The space of a study with this text, and its base."""
    path = folder / "study.yaml"
    path.write_text(text, encoding="utf-8")
    return compile_study(read_study(path))
