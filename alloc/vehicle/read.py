"""Vehicle files found by name or path, read, and refused with file, line and remedy."""

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from alloc.errors import VehicleError, unknown
from alloc.files.keys import convert
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle import Vehicle
from alloc.vehicle.curve import with_curve_read
from alloc.vehicle.file import build_vehicle
from alloc.vehicle.keys import EscKeys, VehicleFile


@dataclass(frozen=True)
class Document:
    """A vehicle file as read.

    Attributes
    ----------
    keys : the checked keys
    tree : the YAML, with the line of each key
    """

    keys: VehicleFile
    tree: YamlTree

    def located(self, error: VehicleError) -> VehicleError:
        """``error`` with file and line in front of its message."""
        return VehicleError(error.what, error.key, path=self.tree.path, line=self.tree.lines.get(error.key))


def list_vehicles() -> tuple[str, ...]:
    """Names of the shipped vehicles, sorted."""
    folder = resources.files("alloc") / "vehicles"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_vehicle(name: str | Path) -> Vehicle:
    """A shipped vehicle by name, or any vehicle by the path of its YAML file.

    Raises UnknownName if there is neither, FileError where the file is no readable YAML, and VehicleError
    (file, line, key, remedy) where its content describes no vehicle.
    """
    document = read_document(find_file(name))
    try:
        return build_vehicle(document.keys)
    except VehicleError as error:
        raise document.located(error) from None


def find_file(name: str | Path) -> Path:
    """The file behind a shipped name or a path; raises UnknownName."""
    text = str(name)
    if text in list_vehicles():
        return Path(str(resources.files("alloc") / "vehicles" / f"{text}.yaml"))
    path = Path(text)
    if path.suffix in (".yaml", ".yml") or "/" in text or _exists(path):
        return path
    raise unknown("vehicle", text, list_vehicles(), "; or give the path of a .yaml file")


def read_document(path: Path) -> Document:
    """Read one vehicle file and check its form; raises FileError or VehicleError."""
    tree = read_yaml(path)
    if not isinstance(tree.data, dict):
        raise VehicleError("holds no keys; start with 'name:', 'dof:' and a geometry", path=path)
    keys = convert(tree, VehicleFile, "docs/your-vehicle.md", VehicleError)
    if isinstance(keys.esc, EscKeys):
        keys.esc = with_curve_read(keys.esc, path.parent)
    elif keys.esc is not None:
        keys.esc = [with_curve_read(one, path.parent) for one in keys.esc]
    return Document(keys, tree)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # the name is too long for a file, or holds a zero byte
        return False
