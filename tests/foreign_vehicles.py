"""Vehicles imported from files of other projects, for tests of that."""

from pathlib import Path

from alloc import Vehicle, load_vehicle
from alloc.vehicle.keys import VehicleFile, to_yaml
from bench.inputs.imported import ImportOptions, import_vehicle

LIMITS = ImportOptions(f_min=-20, f_max=20)


def imported(
    folder: Path, text: str, options: ImportOptions | None = None, name: str = "theirs.yaml"
) -> VehicleFile:
    """The keys made of a file of that name and text, written into the folder."""
    (folder / name).write_text(text, encoding="utf-8")
    return import_vehicle(folder / name, options=options)


def vehicle_of(keys: VehicleFile, folder: Path) -> Vehicle:
    """The vehicle as it is read back from the file that would be written."""
    path = folder / "ours.yaml"
    path.write_text(to_yaml(keys), encoding="utf-8")
    return load_vehicle(path)
