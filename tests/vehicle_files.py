"""A sound vehicle file for tests to spoil, and the refusal of a spoiled one."""

from pathlib import Path

from alloc import load_vehicle
from tests.readers import refused

GOOD = """\
name: cross
dof: [surge, sway, yaw]
T:
  - [1, 1, 0, 0]
  - [0, 0, 1, 1]
  - [-0.5, 0.5, 1, -1]
f_min: -10
f_max: 20
"""


def refusal(path: Path) -> str:
    """The message with which a vehicle file is refused; it is one short line."""
    message = refused(lambda: load_vehicle(path), path)
    assert len(message) < len(str(path)) + 300
    return message
