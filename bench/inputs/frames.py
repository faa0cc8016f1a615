"""Frames of data that meet a vehicle: a comment in a file, and the line that says what was turned."""

import re

from alloc.allocation import FloatArray
from alloc.vehicle.frame import AXES, described, turned

_COMMENT = re.compile(r"^\s*(?:#|%|//).*?\bframe\s*[:=]\W*([^\W\d]\w*)", re.MULTILINE | re.IGNORECASE)


def frame_comment(frame: str) -> str:
    """The line that says a file's frame: ``# frame: flu (x ahead, y to port, z up)``."""
    return f"# frame: {frame} ({AXES[frame]})\n"


def frame_in(text: str) -> str:
    """What comments as such a line say, ``flu`` or ``enu and flu``; empty where there is none."""
    return " and ".join(sorted({word.lower() for word in _COMMENT.findall(text)}))


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
