"""``control_allocation_matrix`` of mvp_control: six numbers per thruster, by name, moments first.

The order is roll, pitch, yaw, surge, sway, heave (config/allocation_manual.yaml and docs/parameters.rst of
uri-ocean-robotics/mvp_control @2d56c73). mvp_control uses the matrix where ``generator_type`` is user; with
tf it makes its own. Limits stand in ``thruster_limits``, each thruster's min and max.
"""

from pathlib import Path

from alloc.errors import VehicleError
from alloc.files.yaml_tree import read_yaml
from bench.inputs.draft import Draft, ends, find, has_key, mismatch, numbers

ORDER = ("roll", "pitch", "yaw", "surge", "sway", "heave")
MATRIX = "control_allocation_matrix"


def recognises(path: Path, text: str) -> bool:
    """True if the text has a key ``control_allocation_matrix``."""
    return has_key(text, MATRIX)


def read(path: Path) -> Draft:
    """The Draft of a parameter file; raises FileError or VehicleError."""
    tree = read_yaml(path)
    if find(tree, "generator_type") == "tf":
        raise VehicleError(
            f"{path}: generator_type is 'tf', so mvp_control takes its matrix from the transform tree; import"
            " the URDF, or write generator_type: user"
        )
    columns = find(tree, MATRIX)
    if not isinstance(columns, dict) or not columns:
        raise mismatch(tree, MATRIX, "no table", "each thruster's name and six numbers")
    table = {name: numbers(tree, f"{MATRIX}.{name}", column) for name, column in columns.items()}
    for name, column in table.items():
        if len(column) != len(ORDER):
            where = f"{MATRIX}.{name}"
            raise mismatch(tree, where, f"{len(column)} numbers", f"six: {', '.join(ORDER)}")
    draft = Draft(source=f"{path.name}, {MATRIX} of mvp_control", dof=ORDER, names=list(table))
    draft.T = [list(row) for row in zip(*table.values(), strict=True)]
    draft.assumptions.append(f"Each thruster's numbers are {', '.join(ORDER)}, as in mvp_control.")
    limits = find(tree, "thruster_limits")
    own = [limits.get(name) if isinstance(limits, dict) else None for name in table]
    low, high = (ends(tree, own, end, f"thruster_limits {end}") for end in ("min", "max"))
    draft.set_limits(low, high)
    return draft
