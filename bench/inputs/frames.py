"""Frames of data that meet a vehicle: what a file says of them, and the line that says what was turned."""

import re

from alloc.allocation import FloatArray
from alloc.vehicle.frame import AXES, described, turned

FIXED = ("earth", "map", "odom", "world", "ned", "enu")
"""First words of ROS's frames that stay with the earth (REP 105), not with the vehicle."""
_COMMENT = re.compile(
    r"^\s*(?:#|%|//).*?\bframe(?P<id>_?id)?\s*[:=]\W*(?P<name>[^\W\d][\w/]*)", re.MULTILINE | re.IGNORECASE
)


def frame_comment(frame: str) -> str:
    """The line that says a file's frame: ``# frame: flu (x ahead, y to port, z up)``."""
    return f"# frame: {frame} ({AXES[frame]})\n"


def frame_in(text: str) -> str:
    """What comments as such a line say, ``flu`` or ``enu and flu``; empty where there is none.

    A comment with ROS's frame_id says the frame of that, where it turns with the vehicle, else the id.
    """
    found = [(match["id"], match["name"].lower()) for match in _COMMENT.finditer(text)]
    return " and ".join(sorted({of_id(name) if is_id and not fixed(name) else name for is_id, name in found}))


def of_id(frame_id: str) -> str:
    """The frame of a ROS frame_id: z down where its name ends in ned (REP 103) or frd, else up."""
    return "frd" if frame_id.lower().endswith(("frd", "ned")) else "flu"


def fixed(frame_id: str) -> bool:
    """Whether a ROS frame_id stays with the earth, so that it does not turn with the vehicle."""
    return frame_id.lower().rpartition("/")[2].partition("_")[0] in FIXED


def met(taus: FloatArray, dof: tuple[str, ...], given: str, why: str, wanted: str) -> tuple[FloatArray, str]:
    """Demands (N, k) in the frame of a vehicle, and what was done to them, in words.

    Parameters
    ----------
    taus, dof : the demands and their columns
    given, why : the frame that they are in, and what says so
    wanted : the frame of the vehicle
    """
    if given == wanted:
        return taus, f"frame {given} ({why}), the vehicle's own, nothing turned: {AXES[wanted]}"
    return turned(taus.T, dof).T, f"frame {given} ({why}), turned into the vehicle's {described(wanted)}"
