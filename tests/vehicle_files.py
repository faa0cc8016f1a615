"""A sound vehicle file for tests to spoil, and the refusal of a spoiled one."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from alloc import Vehicle, load_vehicle
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
    assert len(message) < len(str(path)) + 330  # a misspelt key names all there are
    return message


def torpedo() -> Vehicle:
    """Six thrusters whose mains pitch the vehicle by arms of 1 cm: rounding of a wrench asks much of them."""
    T = np.array(
        [
            [1.0, 0.9962, 0.0, 0.0, 0.0, 0.0],
            [0.0, -0.0872, 1.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0, 1.0],
            [-0.01, -0.008, 0.0, 0.0, -0.685, 0.645],
            [0.14, -0.0816, 0.595, -0.555, 0.0, 0.0],
        ]
    )
    return replace(load_vehicle("bluerov2"), T=T)
