"""Axes that an import chooses: by what thrusters do along them, not by their order."""

from pathlib import Path

from alloc.vehicle.file import build_vehicle
from bench.inputs.imported import ImportOptions, import_vehicle
from tests.readers import written

TILTED = """\
param set-default CA_AIRFRAME 0
param set-default CA_ROTOR_COUNT 4
param set-default CA_ROTOR0_PX 0.241
param set-default CA_ROTOR0_PY 0.238
param set-default CA_ROTOR0_KM 0.05
param set-default CA_ROTOR0_AX -0.0612
param set-default CA_ROTOR0_AZ -1.0
param set-default CA_ROTOR1_PX -0.224
param set-default CA_ROTOR1_PY -0.239
param set-default CA_ROTOR1_KM 0.05
param set-default CA_ROTOR2_PX 0.241
param set-default CA_ROTOR2_PY -0.238
param set-default CA_ROTOR2_KM -0.05
param set-default CA_ROTOR3_PX -0.224
param set-default CA_ROTOR3_PY 0.239
param set-default CA_ROTOR3_KM -0.05
"""


def test_a_rotor_tilted_by_three_degrees_gives_no_surge_in_place_of_pitch(tmp_path: Path) -> None:
    path = written(tmp_path / "quad.params", TILTED)
    keys = import_vehicle(path, options=ImportOptions(f_min=0.0, f_max=10.0))
    assert keys.dof == ["heave", "roll", "pitch", "yaw"]
    assert "surge is left out of dof: 3.1 % of heave, and not independent." in keys.notes
    assert build_vehicle(keys).strong.rank == 4
