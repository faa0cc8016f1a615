"""The keys of a study file: a base vehicle and what varies about it."""

from pathlib import Path
from typing import Literal

import msgspec

from alloc.errors import FileError
from alloc.files.keys import convert
from alloc.files.yaml_tree import YamlTree, read_yaml
from alloc.vehicle.frame import Frame

MOST = 2**30
"""Most layouts of a round: Sobol' points in 30 bits."""


class StudyError(FileError):
    """A study file says something that can't be done; the message names file, line and key."""


class Span(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """All numbers between two.

    Attributes
    ----------
    low, high : the ends, ``from`` and ``to`` in the file
    steps : how many values a grid takes, the ends included
    """

    low: float = msgspec.field(name="from")
    high: float = msgspec.field(name="to")
    steps: int | None = None


Values = float | list[float] | Span
"""One number, a list to choose from, or a span."""


class VariedGroup(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """Thrusters that vary together: the first leads, the others are its images.

    Attributes
    ----------
    thrusters : of the base, by number or name, which are mirrored or turned images of the first
    like : thruster of the base that new thrusters are copies of, in place of ``thrusters``
    mirror : planes in which a new thruster is mirrored
    count : how many new thrusters stand evenly around the vertical axis
    present : whether the group is there at all
    x, y, z : position of the leader, in the base's frame [m]
    azimuth_deg : where the leader pushes, from x (ahead) towards y: to starboard in frd, to port in flu [deg]
    cant_deg : how far it pushes out of the horizontal towards z: down in frd, up in flu [deg]
    size : factor on the limits of all thrusters of the group
    """

    thrusters: list[int | str] | None = None
    like: int | str | None = None
    mirror: list[Literal["xz", "yz", "xy"]] = []
    count: int | list[int] | None = None
    present: bool | list[bool] = True
    x: Values | None = None
    y: Values | None = None
    z: Values | None = None
    azimuth_deg: Values | None = None
    cant_deg: Values | None = None
    size: Values | None = None


class Center(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The centre of mass where it varies [m]."""

    x: Values | None = None
    y: Values | None = None
    z: Values | None = None


class MountingBox(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Box in which thrusters may sit, [least, largest] along each axis [m]."""

    x: tuple[float, float] | None = None
    y: tuple[float, float] | None = None
    z: tuple[float, float] | None = None


class Wake(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The jet of a thruster, in which no other thruster may sit.

    Attributes
    ----------
    length : how far it reaches [m]
    radius : at the thruster, half of the other thruster included [m]
    spread_deg : by how much it widens [deg]
    """

    length: float
    radius: float
    spread_deg: float = 0.0


class Constraints(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Constraints on a layout.

    Attributes
    ----------
    box : where thrusters may sit
    distance : least distance between any two thrusters [m]
    wake : jets that no thruster may sit in
    """

    box: MountingBox = MountingBox()
    distance: float = 0.0
    wake: Wake | None = None


class AskedDemands(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The demands that layouts are asked, made for the base.

    Attributes
    ----------
    source : a demand set's name or a log, ``set`` in the file
    n : how many; the first of a log
    frame, columns, scale : what a log does not say itself, each as the option of that name takes it
    """

    source: str = msgspec.field(name="set", default="uniform")
    n: int = 256
    frame: Frame | None = None
    columns: str = ""
    scale: float | list[float] = []


class Refine(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Rounds of more layouts around the best ones.

    Attributes
    ----------
    rounds : how many
    n : layouts of each
    width : share of each span around a best layout in the first round, half of it in the next, and so on
    """

    rounds: int = 0
    n: int = 8192
    width: float = 0.2


class StudyFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True, kw_only=True):
    """The keys of a study file.

    Attributes
    ----------
    base : a shipped vehicle or the path of a vehicle file, from the study's folder
    groups : thrusters that vary; all others stay as they are
    dof : the degrees of freedom that count; the base's
    center_of_mass : where it varies
    sampling : sobol for points spread evenly over all that varies, grid for all combinations
    n : layouts of a Sobol' sequence; a grid has its own number
    reference_length : arm at which a moment counts as a force [m]; None for the base's own
    seed : of everything that is drawn
    """

    base: str
    groups: dict[str, VariedGroup]
    dof: list[str] | None = None
    center_of_mass: Center = Center()
    constraints: Constraints = Constraints()
    demands: AskedDemands = AskedDemands()
    sampling: Literal["sobol", "grid"] = "sobol"
    n: int = 65536
    reference_length: float | None = None
    seed: int = 0
    refine: Refine = Refine()


class StudyDocument(msgspec.Struct, frozen=True):
    """A study file as read.

    Attributes
    ----------
    keys : the checked keys
    tree : the YAML, with the line of each key
    """

    keys: StudyFile
    tree: YamlTree

    def refusal(self, where: str, why: str) -> StudyError:
        """The error that names file, line and key: ``where`` is a place as ``groups.aft.x``."""
        return StudyError(f"{where}: {why}", path=self.tree.path, line=self.tree.line(where))


def read_study(path: Path) -> StudyDocument:
    """Read a study file and check its form; raises FileError or StudyError."""
    tree = read_yaml(path)
    if not isinstance(tree.data, dict):
        raise StudyError(f"{path}: holds no keys; start with 'base:' and 'groups:'")
    document = StudyDocument(convert(tree, StudyFile, "docs/layouts.md", StudyError), tree)
    _check(document)
    return document


def _check(document: StudyDocument) -> None:
    """Raise StudyError for numbers that make no sense by themselves."""
    keys = document.keys
    for where, number, least in (
        ("n", keys.n, 1),
        ("seed", keys.seed, 0),
        ("demands.n", keys.demands.n, 1),
        ("refine.rounds", keys.refine.rounds, 0),
        ("refine.n", keys.refine.n, 1),
    ):
        if not least <= number <= MOST:
            raise document.refusal(where, f"{number} is out of range; give {least} to {MOST}")
    if keys.reference_length is not None and not 0 < keys.reference_length < float("inf"):
        raise document.refusal("reference_length", "give metres, above 0")
    if not 0 < keys.refine.width <= 1:
        raise document.refusal("refine.width", "give a share of each span, above 0 and up to 1")
    if not keys.groups:
        raise document.refusal("groups", "is empty; name at least one group of thrusters")
    for name in keys.groups:
        if not name.isprintable():
            raise document.refusal("groups", f"{name!r} can't be shown; give names of printable characters")
    for axis in ("x", "y", "z"):
        ends = getattr(keys.constraints.box, axis)
        if ends is not None and not ends[0] <= ends[1]:
            raise document.refusal(f"constraints.box.{axis}", "is empty; give [least, largest]")
    wake = keys.constraints.wake
    if wake is not None and not (wake.length > 0 and wake.radius > 0 and 0 <= wake.spread_deg < 90):
        raise document.refusal("constraints.wake", "give length and radius above 0 m, spread_deg below 90")
    if not keys.constraints.distance >= 0:
        raise document.refusal("constraints.distance", "give metres, 0 or more")
