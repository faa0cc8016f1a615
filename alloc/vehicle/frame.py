"""Body frames, frd and flu: what their axes mean, and vectors turned from one into the other."""

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import FloatArray
from alloc.errors import VehicleError

Frame = Literal["frd", "flu"]
FRAMES: tuple[Frame, ...] = get_args(Frame)
AXES: dict[str, str] = {"frd": "x ahead, y to starboard, z down", "flu": "x ahead, y to port, z up"}
"""Axes of each frame, in words."""
TURN = np.array([1.0, -1.0, -1.0])
"""Signs of x, y and z from one frame to the other, a turn by 180 degrees about x, and back again."""

_FORWARD = {
    "frd": {
        "surge": "pushes ahead",
        "sway": "pushes to starboard",
        "heave": "pushes down",
        "roll": "turns the starboard side down",
        "pitch": "turns the bow up",
        "yaw": "turns the bow to starboard",
    },
    "flu": {
        "surge": "pushes ahead",
        "sway": "pushes to port",
        "heave": "pushes up",
        "roll": "turns the starboard side down",
        "pitch": "turns the bow down",
        "yaw": "turns the bow to port",
    },
}
_OPPOSITE = {"ahead": "astern", "starboard": "port", "down": "up", "up": "down", "port": "starboard"}
_LINES = {"surge": "x", "sway": "y", "heave": "z", "roll": "x", "pitch": "y", "yaw": "z"}


def checked_frame(frame: str) -> Frame:
    """The frame of that name; raises VehicleError where there is none."""
    for known in FRAMES:
        if frame == known:
            return known
    raise VehicleError(f"unknown frame {frame[:40]!r}; expected {' or '.join(FRAMES)}", "frame")


def described(frame: str) -> str:
    """A frame's name and axes, as ``flu: x ahead, y to port, z up``."""
    return f"{frame}: {AXES[frame]}"


def axis_line(axis: str, frame: str) -> str:
    """The line along or about which a degree of freedom lies, as ``z down``."""
    return next(words for words in AXES[frame].split(", ") if words.startswith(_LINES[axis]))


def effect(axis: str, frame: str, sign: float = 1.0) -> str:
    """Effect of a positive (or negative) force or moment, as ``pushes down`` or ``turns the bow to port``."""
    words = _FORWARD[frame][axis]
    if sign >= 0:
        return words
    before, _, last = words.rpartition(" ")
    return f"{before} {_OPPOSITE[last]}" if axis != "surge" else "pushes astern"


def signs(dof: Sequence[str]) -> FloatArray:
    """(k,) 1 for the axes that both frames share, surge and roll, and -1 for the others."""
    return np.array([1.0 if axis in ("surge", "roll") else -1.0 for axis in dof])


def turned(rows: ArrayLike, dof: Sequence[str]) -> FloatArray:
    """T (k, n) or a wrench (k,) of one frame in the other; ``dof`` names the rows.

    The axes turn by 180 degrees about x: forces and moments along y or z change sign. Turning twice gives the
    same numbers again.
    """
    array = np.asarray(rows, dtype=float)
    result: FloatArray = (signs(dof) * array.T).T + 0.0  # + 0.0 turns -0 into 0
    return result
