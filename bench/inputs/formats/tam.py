"""``TAM.yaml`` of uuv_simulator: the thruster allocation matrix, six rows in the frame of base_link."""

from pathlib import Path

from alloc.errors import VehicleError
from alloc.files.yaml_tree import read_yaml
from alloc.vehicle.geometry import DOF
from bench.inputs.formats import Draft
from bench.inputs.parameters import find, numbers, rows


def recognises(path: Path, text: str) -> bool:
    """Whether the text has a key ``tam``."""
    return any(line.strip().startswith("tam:") for line in text.splitlines())


def read(path: Path) -> Draft:
    """The Draft of a TAM file; raises FileError or VehicleError."""
    tree = read_yaml(path)
    T = rows(tree, "tam", find(tree, "tam"))
    if len(T) != len(DOF):
        raise VehicleError(f"{path}: tam has {len(T)} rows; give six, surge to yaw")
    draft = Draft(
        source=f"{path.name}, thruster allocation matrix of uuv_simulator", dof=DOF, T=T, frame="flu"
    )
    draft.frame_assumed = "The frame is base_link, flu: x ahead, y to port, z up."
    if (limit := find(tree, "max_thrust")) is not None:
        draft.f_max = numbers(tree, "max_thrust", [limit])[0]
        draft.f_min = -draft.f_max
        draft.assumptions.append("max_thrust holds both ways.")
    return draft
