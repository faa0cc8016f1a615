"""SDF, gz-sim's description of a model: thruster joints or links, their poses composed to the model's frame.

Read as sdformat 12.3 reads it, which converts formats before 1.9 by its files ``*/*.convert``: up to 1.6 a
pose's attribute ``frame`` is its ``relative_to``, and ``<use_parent_model_frame>`` puts an axis into the
model's frame, as formats before 1.5 do where they have none. From 1.7 on both are unknown and ignored.
Nested models, ``<frame>``, ``relative_to`` and ``expressed_in`` are followed; ``placement_frame`` of a
nested model is refused, and ``<include>`` is left out: it names a file or a place on the network.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from alloc.allocation import FloatArray
from alloc.errors import VehicleError
from bench.inputs.columns import listed
from bench.inputs.description import (
    SHORTEST,
    Mass,
    Mount,
    along,
    has_thrusters,
    make_draft,
    make_pose,
    motors,
    numbers,
    pose,
    read_xml,
)
from bench.inputs.draft import Draft, mismatch

PATTERN = True
"""``read`` takes a pattern of thrusters' names."""
MODEL = "__model__"
DEEPEST = 100
"""Frames that may refer to each other in a chain; a vehicle has five."""


def recognises(path: Path, text: str) -> bool:
    """True if the text is XML of gz-sim."""
    return "<sdf" in text


def read(path: Path, pattern: str = "") -> Draft:
    """The Draft of the model of a file that has thrusters; raises FileError, NotInstalled or VehicleError."""
    root = read_xml(path)
    model = _vehicle(path, root, pattern)
    things: dict[str, Element] = {}
    for name, thing in _things(model, ""):
        if things.setdefault(name, thing) is not thing:
            raise VehicleError(
                f"{path}: <{things[name].tag}> and <{thing.tag}> are both called {name[:40]!r}; rename one"
            )
    frames = Frames(path, things, _minor(path, root))
    joints = [(name, thing) for name, thing in things.items() if thing.tag == "joint"]
    masses = [frames.mass(name, link) for name, link in things.items() if link.tag == "link"]
    draft = make_draft(
        path,
        "SDF",
        f"model {model.get('name', '')!r}",
        [frames.mount(name, joint) for name, joint in joints],
        masses,
        motors(path, model),
        pattern,
        frames.angles,
    )
    draft.assumptions += frames.remarks()
    if included := [include.findtext("uri") or "?" for include in model.iter("include")]:
        draft.assumptions.append(
            f"Left out, since it is another file: <include> of {', '.join(included)[:80]}."
        )
    return draft


def _vehicle(path: Path, root: Element, pattern: str) -> Element:
    """The model with thrusters, as a world has others: the ground, a buoy; the first where none has any."""
    models = list(_models(root))
    if not models:
        raise VehicleError(f"{path}: holds no <model>; give the description of a vehicle")
    driven = [motors(path, model) for model in models]
    vehicles = [
        model
        for model, own in zip(models, driven, strict=True)
        if has_thrusters(_joints(model), own, pattern)
    ]
    if not pattern:  # plug-ins say what a thruster is; a name, such as propeller, may be scenery's too
        vehicles = [model for model, own in zip(models, driven, strict=True) if own] or vehicles
    if len(vehicles) > 1:
        names = listed([model.get("name", "") for model in vehicles])
        raise VehicleError(f"{path}: models {names} have thrusters; keep one of them in the file")
    return (vehicles or models)[0]


def _models(element: Element) -> Iterator[Element]:
    """The models of a file, but for those within another."""
    for child in element:
        if child.tag == "model":
            yield child
        else:
            yield from _models(child)


def _joints(model: Element) -> Iterator[str]:
    """Names of a model's joints and of the links that they carry."""
    for joint in model.iter("joint"):
        yield joint.get("name", "")
        yield (joint.findtext("child") or "").strip()


def _minor(path: Path, root: Element) -> int:
    """The 9 of format 1.9; raises VehicleError where it is none that sdformat converts."""
    said = root.get("version", "")
    version = re.fullmatch(r"1\.(\d{1,3})", said)
    if version is None or int(version[1]) < 2:
        raise VehicleError(f"{path}: <sdf version={said[:20]!r}>: expected 1.2 or later, as in version='1.9'")
    return int(version[1])


def _things(model: Element, scope: str) -> Iterator[tuple[str, Element]]:
    """Links, joints, frames and models of a model by their scoped names, as ``arm::hand``; and itself."""
    yield scope + MODEL, model
    for child in model:
        name = scope + child.get("name", "")
        if child.tag in ("link", "joint", "frame"):
            yield name, child
        elif child.tag == "model":
            yield name, child
            yield from _things(child, f"{name}::")


class Frames:
    """Poses of a model's links, joints and frames, each worked out once from the frame that it refers to.

    Attributes
    ----------
    path : the file, for messages
    things : elements by scoped name
    minor : the 9 of format 1.9
    angles : of the poses that were worked out, as they are written [rad]
    weightless : links that say no mass
    ignored : what has a pose with ``frame``, or an axis with ``use_parent_model_frame``, since 1.7
    """

    def __init__(self, path: Path, things: dict[str, Element], minor: int) -> None:
        self.path, self.things, self.minor = path, things, minor
        self.angles: list[float] = []
        self.weightless: list[str] = []
        self.ignored: dict[str, list[str]] = {"frame= of a pose": [], "use_parent_model_frame": []}
        self._known: dict[str, FloatArray] = {MODEL: np.eye(4)}
        self._asked: list[str] = []

    def place(self, name: str) -> FloatArray:
        """(4, 4) of a frame from the model; raises VehicleError where it is not there, or hangs on itself."""
        if name in self._known:
            return self._known[name]
        scope = name[: name.rfind("::") + 2] if "::" in name else ""
        if name == scope + MODEL:
            self._known[name] = self.place(scope.removesuffix("::"))
            return self._known[name]
        thing = self.things.get(name)
        if thing is None:
            raise VehicleError(
                f"{self.path}: frame {name[:40]!r} is named but not there; mend the description"
            )
        if name in self._asked or len(self._asked) > DEEPEST:
            raise VehicleError(
                f"{self.path}: the pose of {name[:40]!r} refers to itself; mend the description"
            )
        self._asked.append(name)
        self._known[name] = self._reference(name, scope, thing) @ self._pose(name, thing.find("pose"))
        self._asked.pop()
        return self._known[name]

    def mount(self, name: str, joint: Element) -> Mount:
        """A joint as what may be a thruster: its place, and its axis in the model's frame."""
        here = self.place(name)
        xyz = joint.find("axis/xyz")
        given = [0.0, 0, 1] if xyz is None else numbers(self.path, f"axis of {name}", xyz.text, 3)
        scope = name[: name.rfind("::") + 2] if "::" in name else ""
        within = "" if xyz is None else xyz.get("expressed_in", "")
        if self._of_model(name, joint, scope):
            if xyz is None:
                raise VehicleError(f"{self.path}: <axis> of joint {name[:40]!r} has no <xyz>; give x y z")
            within = MODEL
        turn = (self.place(scope + within) if within else here)[:3, :3]
        turns = joint.get("type") in ("continuous", "revolute")
        remark = (
            "" if joint.find("axis") is not None else "A joint without <axis> is taken to push along its z"
        )
        axis = turn @ along(self.path, name, given)
        return Mount(name, self._child(joint, scope), here[:3, 3], axis, turns, remark)

    def _of_model(self, name: str, joint: Element, scope: str) -> bool:
        """True if ``<use_parent_model_frame>``, or its default, goes before ``expressed_in``."""
        said = joint.find("axis/use_parent_model_frame")
        if said is None:  # 1_4.convert does not descend into nested models
            return self.minor < 5 and not scope and joint.find("axis") is not None
        if self.minor > 6:
            self.ignored["use_parent_model_frame"].append(name)
            return False
        return (said.text or "").strip() in ("true", "True", "TRUE", "1")

    def remarks(self) -> list[str]:
        """Sentences on what sdformat ignores of the file, and adds to it."""
        lines = [
            f"SDF 1.{self.minor} knows no {key}: sdformat ignores it, of {listed(names)}."
            for key, names in self.ignored.items()
            if names
        ]
        if self.weightless:
            lines.append(f"Links without a mass weigh 1 kg, as in sdformat: {listed(self.weightless)}.")
        return lines

    def mass(self, name: str, link: Element) -> Mass:
        """A link's mass, 1 kg where it says none, and where it is."""
        text = link.findtext("inertial/mass")
        if text is None:
            self.weightless.append(name)
        mass = 1.0 if text is None else numbers(self.path, f"mass of {name}", text, 1)[0]
        if mass < 0:
            raise mismatch(self.path, f"mass of {name[:40]}", f"{mass:g}", "kg")
        return Mass(mass, (self.place(name) @ self._pose(name, link.find("inertial/pose")))[:3, 3])

    def _reference(self, name: str, scope: str, thing: Element) -> FloatArray:
        """The frame that a thing's pose is given in: named, or that of its kind."""
        given = Element("pose") if (found := thing.find("pose")) is None else found
        old, relative = given.get("frame", ""), given.get("relative_to", "")
        if old and self.minor > 6:
            self.ignored["frame= of a pose"].append(name)
        elif old:
            relative = old
        if thing.get("placement_frame"):
            raise VehicleError(
                f"{self.path}: placement_frame of model {name[:40]!r} is not read; give its own frame's pose"
            )
        if relative:
            return self.place(scope + relative)
        if thing.tag == "joint":
            return self.place(self._child(thing, scope))
        if thing.tag == "frame" and thing.get("attached_to"):
            return self.place(scope + thing.get("attached_to", ""))
        return self.place(scope + MODEL)

    def _child(self, joint: Element, scope: str) -> str:
        return scope + (joint.findtext("child") or "").strip()

    def _pose(self, name: str, given: Element | None) -> FloatArray:
        if given is None or not (given.text or "").strip():
            return np.eye(4)
        degrees = given.get("degrees", "").strip().lower() in ("true", "1")
        form = given.get("rotation_format", "") or "euler_rpy"
        if form not in ("euler_rpy", "quat_xyzw") or (degrees and form == "quat_xyzw"):
            got = f"{form[:20]!r}{' and degrees' * degrees}"
            raise mismatch(self.path, f"pose of {name}", got, "euler_rpy, or quat_xyzw without degrees")
        if form == "quat_xyzw":
            values = numbers(self.path, f"pose of {name}", given.text, 7)
            if not np.linalg.norm(values[3:]) > SHORTEST:
                raise mismatch(self.path, f"quaternion of {name[:40]}", "0, 0, 0, 0", "length 1")
            return make_pose(values[:3], Rotation.from_quat(values[3:]).as_matrix())
        values = numbers(self.path, f"pose of {name}", given.text, 6)
        turn = np.radians(values[3:]) if degrees else values[3:]
        self.angles += list(turn)
        return pose(values[:3], list(turn))
