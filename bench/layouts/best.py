"""Layouts written as vehicle files, which every command takes."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from alloc.allocation import FloatArray
from alloc.files.textfile import write_text
from alloc.vehicle.keys import Thruster, VehicleFile
from alloc.vehicle.names import unmistakable
from alloc.vehicle.text import to_yaml
from bench.layouts.space import LayoutSpace, base_order, numbers_of, poses

if TYPE_CHECKING:
    import pyarrow as pa


def layout_name(space: LayoutSpace, row: dict[str, float]) -> str:
    """The name of a layout's vehicle and file: base, round and number."""
    return f"{space.name[:40]}-{int(row['round'])}-{int(row['layout'])}"


def vehicle_file(space: LayoutSpace, row: dict[str, float]) -> VehicleFile:
    """The vehicle file of a layout, from its row in a shard; every number to its last digit."""
    settings = np.array([[row[parameter.name]] for parameter in space.parameters])
    (one,) = poses(space, settings)
    numbers = "".join(
        f"{parameter.name} {row[parameter.name]:.6g}, " for parameter in space.parameters
    ).removesuffix(", ")
    weights = one.weights[:, 0].tolist()
    names, remark = unmistakable(_names(space, settings))  # a thruster that went moves all behind it
    worst = names[int(row["worst_thruster"])] or f"thruster {int(row['worst_thruster'])}"
    return VehicleFile(
        name=layout_name(space, row),
        source=f"thrustbench layouts, round {int(row['round'])}, layout {int(row['layout'])} of {space.name}",
        notes=[
            f"Varied: {numbers}.",
            f"Authority {row['authority']:.4g} of the base's, {row['authority_after_one']:.4g} after"
            f" the worst failure, of {worst}.",
            *([f"Not taken over from {space.name}: {', '.join(space.left_out)}."] if space.left_out else []),
            *([remark] if remark else []),
        ],
        dof=list(space.dof),  # type: ignore[arg-type]  # names that were checked when the study was read
        f_min=one.f_min[:, 0].tolist(),
        f_max=one.f_max[:, 0].tolist(),
        thrusters=[
            Thruster(position=tuple(r), direction=tuple(e), name=name)
            for r, e, name in zip(
                one.position[..., 0].tolist(),
                one.direction[..., 0].tolist(),
                names,
                strict=True,
            )
        ],
        center_of_mass=tuple(one.center[:, 0].tolist()),
        frame=space.frame,
        weights=weights if any(weight != 1 for weight in weights) else None,
    )


def _names(space: LayoutSpace, settings: FloatArray) -> list[str]:
    """The thrusters' names: those of the base, and none for new ones."""
    counts = [int(count) for (count,) in numbers_of(space, settings)]
    names: list[str] = []
    for group, count in zip(space.groups, counts, strict=True):
        names += group.called[:count] or [""] * count
    return [names[i] for i in base_order(space.groups, counts)]


def write_best(space: LayoutSpace, best: "pa.Table", folder: Path) -> list[Path]:
    """Write each row of ``best`` as a vehicle file into a folder, which then holds nothing else."""
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.yaml"):
        old.unlink()
    paths = []
    for row in best.to_pylist():
        path = folder / f"{layout_name(space, row)}.yaml"
        write_text(path, to_yaml(vehicle_file(space, row)))
        paths.append(path)
    return paths
