"""Makes a vehicle file from a file of another project, and notes what it had to assume."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError, unknown
from alloc.files.keys import convert
from alloc.files.textfile import read_text
from alloc.files.yaml_tree import YamlTree
from alloc.vehicle.degeneracy import NOTHING
from alloc.vehicle.file import build_vehicle, called, matrices, reaction_torques, suspects
from alloc.vehicle.frame import described
from alloc.vehicle.geometry import DOF, contradictions, refusals
from alloc.vehicle.keys import VehicleFile
from alloc.vehicle.names import unmistakable
from alloc.vehicle.weak import DRAWN, WEAK, axis_scale, doubts
from bench.inputs.draft import Draft, mismatch
from bench.inputs.formats import find_format, readable, tam
from bench.inputs.frames import read_comments

PLANAR = ("surge", "sway", "yaw")
PREFERRED = ("surge", "sway", "heave", "yaw", "roll", "pitch")
"""Axes in the order they are kept in where not all can be controlled: those that a hull rights by itself,
roll and pitch, come last."""
AUTHORITY = 0.1
"""Share of the strongest axis, moments in unit of the rms arm, from which an axis is chosen first."""
INDEPENDENT = 1e-2
"""Least singular value, with rows of unit length, at which axes count as independent: published matrices
have about three digits, so what is independent only in the last digit is rounding."""


@dataclass(frozen=True)
class ImportOptions:
    """Facts from the user that a file does not hold; empty or None where the user gives none.

    Attributes
    ----------
    name : of the vehicle
    dof : names of the rows of T, or the axes to control
    frame : frd or flu
    f_min, f_max : limits of every thruster [N]
    take : T or poses, the one to believe where a file has both
    thruster : a pattern that the names of thrusters' joints or links match, for URDF and SDF
    limits : a parameter file of thruster_manager, for the limits of a URDF or SDF
    suspect : thrusters, by index or name, whose column of T is taken as published though none can make it
    """

    name: str = ""
    dof: tuple[str, ...] = ()
    frame: str = ""
    f_min: float | None = None
    f_max: float | None = None
    take: str = ""
    thruster: str = ""
    limits: Path | None = None
    suspect: tuple[int | str, ...] = ()


def import_vehicle(path: Path, format_name: str = "", options: ImportOptions | None = None) -> VehicleFile:
    """The keys of a vehicle file, read from a file of another project; their ``notes`` say what was assumed.

    Raises FileError, VehicleError (what is missing and which option gives it) or UnknownName.
    """
    options, text = options or ImportOptions(), read_text(path)
    known = readable()
    if format_name and format_name not in known:
        raise unknown("format", format_name, known)
    module = known[format_name] if format_name else find_format(path, text)
    manager = tam.read_options(options.limits) if options.limits else tam.ManagerOptions()
    for option, value in (("--thruster", options.thruster), ("--limits", options.limits)):
        if value and not getattr(module, "PATTERN", False):
            raise VehicleError(f"{path}: {option} is for URDF and SDF, which name joints; leave it out")
    pattern = options.thruster or manager.pattern
    draft = module.read(path, pattern) if pattern else module.read(path)
    if options.limits and manager.f_min is not None and manager.f_max is not None:
        draft.f_min, draft.f_max = manager.f_min, manager.f_max
        draft.limits_assumed = [f"Limits are min_thrust and max_thrust of {options.limits.name}, in N."]
    if options.limits and manager.deadzone:
        draft.assumptions.append(
            f"{options.limits.name}: deadzone {manager.deadzone:g} N is left out: thruster_manager avoids"
            " such thrusts, and a vehicle file has no key for that but the curve in esc."
        )
    keys = _keys(path, _completed(path, draft, text, options), options)
    try:
        build_vehicle(keys)
    except VehicleError as error:
        raise VehicleError(f"{path}: {error}", error.key) from None
    return keys


def _keys(path: Path, draft: Draft, options: ImportOptions) -> VehicleFile:
    """The keys of a draft that has all it needs, with the axes that thrusters control."""
    data = YamlTree(path, _data(path, draft, options), {})
    keys = convert(data, VehicleFile, "docs/your-vehicle.md", VehicleError)
    try:
        T, computed = matrices(keys)
        published = suspects(keys, T.shape[1])
    except VehicleError as error:
        raise VehicleError(f"{path}: {error}") from None
    names = called(keys, T.shape[1])
    for contradiction in contradictions(T, computed, keys.dof, names) if computed is not None else ():
        raise VehicleError(f"{path}: {contradiction}; decide with --take T or --take poses", "T")
    refused = refusals(T, keys.dof, reaction_torques(keys, T.shape[1]), names)
    for refusal in (refusal for i, refusal in refused.items() if i not in published):
        every = ",".join(map(str, refused))
        raise VehicleError(f"{path}: T: {refusal}; to take all such as published: --suspect {every}", "T")
    rows, weak = (list(range(len(keys.dof))), {}) if options.dof else _independent(T, keys.dof)
    keys.notes = draft.assumptions + [
        f"{axis} is left out of dof: {weak.get(axis, 'no thruster moves it independently of the others')}."
        for row, axis in enumerate(keys.dof)
        if row not in rows
    ]
    for key in ("T", "slack_weights", "dof"):
        if (values := getattr(keys, key)) is not None:
            setattr(keys, key, [values[row] for row in rows])
    return keys


def _completed(path: Path, draft: Draft, text: str, options: ImportOptions) -> Draft:
    """The draft with the frame of a comment and the user's options, its assumptions brought up to date."""
    dof, notes = draft.dof, list(draft.assumptions)
    if not dof and draft.T is not None:
        dof = options.dof or {6: DOF, 3: PLANAR}.get(len(draft.T), ())
        if len(dof) != len(draft.T):
            turned = bool(draft.T) and len(draft.T) > len(draft.T[0]) in (3, 6)
            remedy = "write a row for each DOF, not for each thruster" if turned else "name them with --dof"
            raise VehicleError(f"{path}: T has {len(draft.T)} rows without names; {remedy}", "dof")
        if not options.dof:
            notes.append(f"The rows of T have no names: {', '.join(dof)} is taken.")
    frame, why, note = _frame(path, draft, text, options.frame)
    limits = {key: getattr(options, key) for key in ("f_min", "f_max")}
    notes += [] if None not in limits.values() else draft.limits_assumed
    notes.append(note)
    for key, value in limits.items():
        if value is not None:
            notes.append(f"{key} is as told, not from the file.")
        elif getattr(draft, key) is None:
            raise VehicleError(f"{path}: no limits in it; give --f-min and --f-max [N]", key)
    names, remark = unmistakable(draft.names or ())
    notes += [remark] if remark else []
    return replace(
        draft,
        dof=dof or DOF,
        frame=frame,
        frame_assumed=why,
        names=names if any(names) else None,
        assumptions=notes,
        **{key: value for key, value in limits.items() if value is not None},
    )


def _frame(path: Path, draft: Draft, text: str, wanted: str) -> tuple[str, str, str]:
    """The frame by the user, a comment, or the format; why it is assumed, empty where it is not; a note."""
    if wanted:
        return wanted, "", f"The frame is {wanted}, as told."
    frame, why = draft.frame or "frd", draft.frame_assumed
    if why or not draft.frame:
        stated = read_comments(text)
        if stated.refusal:
            raise VehicleError(f"{path}: {stated.refusal}", "frame")
        why = why or f"The file names no frame: {described('frd')} is taken; --frame flu if z is up."
        frame, why = (stated.frame, "") if stated.frame else (frame, why)
    return frame, why, why or f"The frame is {described(frame)}, as the file says."


def _data(path: Path, draft: Draft, options: ImportOptions) -> dict[str, Any]:
    axes = list(options.dof or draft.dof)
    copied = ("source", "f_min", "f_max", "weights", "reaction_torque")
    data = {"name": options.name or path.stem, "dof": axes} | {key: getattr(draft, key) for key in copied}
    data["suspect"] = list(options.suspect) or None
    if not draft.frame_assumed or draft.frame != "frd":  # else `check` shall say that frd is a guess
        data["frame"] = draft.frame
    if draft.positions is not None and draft.directions is not None and options.take != "T":
        poses = zip(draft.positions, draft.directions, strict=True)
        data["thrusters"] = [{"position": p, "direction": e} for p, e in poses]
        for thruster, name in zip(data["thrusters"], draft.names or (), strict=bool(draft.names)):
            thruster["name"] = name
        data["center_of_mass"] = draft.center_of_mass
    elif draft.names:
        data["names"] = draft.names
    for axis in axes:
        if axis not in draft.dof:
            raise mismatch(path, "dof", repr(axis[:40]), f"some of {', '.join(draft.dof)}")
    rows = [draft.dof.index(axis) for axis in axes]
    for key, values in (("T", draft.T), ("slack_weights", draft.slack_weights)):
        if values is None or (key == "T" and options.take == "poses"):
            continue
        if len(values) != len(draft.dof):
            raise mismatch(path, key, f"{len(values)} entries", f"{len(draft.dof)}, one a DOF")
        data[key] = [values[row] for row in rows]
    return {key: value for key, value in data.items() if value is not None}


def _independent(T: FloatArray, dof: Sequence[str]) -> tuple[list[int], dict[str, str]]:
    """Indices of as many rows as T has rank, in the file's order; and why weak axes are left out.

    Axes with AUTHORITY are chosen first, PREFERRED first, then the others, the strongest first: a rotor that
    is tilted by a little gives a multicopter no surge in place of pitch.
    """
    scale, lengths = axis_scale(T, dof), np.linalg.norm(T, axis=1)
    authority = lengths / scale
    best = int(authority.argmax())
    order = [list(dof).index(axis) for axis in PREFERRED if axis in dof]
    order = [i for i in order if lengths[i] > INDEPENDENT * lengths.max()]
    later = sorted(
        (i for i in order if authority[i] < AUTHORITY * authority[best]), key=lambda i: -authority[i]
    )
    kept, weak = list[int](), dict[str, str]()
    for i in [*(i for i in order if i not in later), *later]:
        left, noise = _alone(T / scale[:, None], T, dof, kept, i)
        if NOTHING * authority[best] < left <= WEAK * noise:
            share = f"{100 * left / authority[best]:.1g} % of {dof[best]}"
            weak[dof[i]] = f"{share}, less than a survey of {DRAWN.words} can make"
        elif np.linalg.matrix_rank(T[[*kept, i]] / lengths[[*kept, i], None], tol=INDEPENDENT) > len(kept):
            kept.append(i)
        elif i in later:
            weak[dof[i]] = f"{100 * authority[i] / authority[best]:.2g} % of {dof[best]}, and not independent"
    return sorted(kept), weak


def _alone(
    A: FloatArray, T: FloatArray, dof: Sequence[str], kept: Sequence[int], i: int
) -> tuple[float, float]:
    """Authority of axis i beside others, A with rows in one unit; and what a survey makes of nothing."""
    u = np.zeros(len(T))
    u[i] = 1.0
    if kept:
        u[list(kept)] = -np.linalg.lstsq(A[list(kept)].T, A[i], rcond=None)[0]
    u /= np.linalg.norm(u)
    noise = doubts(T, dof, DRAWN, (u / axis_scale(T, dof))[None])
    return float(np.linalg.norm(u @ A)), float(np.sqrt(noise.sum()))
