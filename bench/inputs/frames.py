"""Frames of data that meet a vehicle: what a file states of them, and the sentence on what was turned."""

import re
from collections.abc import Iterable, Sequence, Set
from pathlib import Path
from typing import NamedTuple

from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.frame import AXES, described, turned
from bench.inputs.columns import FRAMES, find_spellings, key

FIXED = ("earth", "map", "odom", "world", "ned", "enu")
"""First words of ROS's frames that stay with the earth (REP 105), not with the vehicle."""
_ROS = re.compile(r"(?:force|torque)\.[yz](?![^\W_])")
"""Keys of geometry_msgs' fields along y and z, whose signs depend on the frame."""
REMEDY = "give --frame frd or flu"
_DOWN = re.compile(r"(\b|_|base|body|link)(ned|frd|fsd)(\b|_)", re.IGNORECASE)
"""A word of a ROS frame with z down: north, east, down; ahead, to the right or to starboard, down."""
_COMMENT = re.compile(r"^[^\S\n]*(?:#|%|//).*", re.MULTILINE)
_FORM = re.compile(r"\bframe(?P<id>_?id)?\s*[:=]\W*(?P<name>[^\W\d][\w/]*)", re.IGNORECASE)
"""The form in which a comment states a frame."""
_WORD = re.compile(
    r"(\b|_|base|body|link)(ned|frd|fsd|flu|enu)(\b|_)|\bbase_link\b"
    r"|(?<![^\W_])(?:z|heave)(?![^\W_])(?:[\W_]|axis|is|points|positive)*(?:down|up)(?:wards?)?\b(?!\s+to\b)"
    r"|\b(?:forward|ahead|north|east)\W+(?:right|starboard|left|port|north|east)\W+(?:down|up)\b"
    rf"|\b(?:{'|'.join(FIXED)})[\W_](?:fixed[\W_])?frame\b",
    re.IGNORECASE,
)
"""Words that are about axes, in whatever form."""


class Stated(NamedTuple):
    """The frame that a file states.

    Attributes
    ----------
    frame : frd or flu; empty where the file states none, or none that is decided
    why : what states it, in words
    refusal : why none can be taken until the user gives one; empty where one can
    ros : a column named as in ROS, where z is up, of a file that states no frame; empty for none
    """

    frame: str = ""
    why: str = ""
    refusal: str = ""
    ros: str = ""


def frame_comment(frame: str) -> str:
    """The line that states a file's frame: ``# frame: flu (x ahead, y to port, z up)``."""
    return f"# frame: {frame} ({AXES[frame]})\n"


def read_comments(text: str) -> Stated:
    """The frame that comments state, as ``# frame: flu``, or with ROS's frame_id.

    Undecided where these name two frames, or another one, or where comments have words about axes only in
    other forms.
    """
    names, unread = set[str](), ""
    for comment in _COMMENT.finditer(text):
        if match := _FORM.search(comment[0]):
            name = match["name"].lower()
            names.add(id_frame(name) if match["id"] and not is_fixed(name) else name)
        elif not unread and _WORD.search(comment[0]):
            unread = f"line {text.count(chr(10), 0, comment.start()) + 1}: {comment[0].strip()[:60]!r}"
    if names:
        said = " and ".join(sorted(names))
        return Stated(said, "its comment") if said in AXES else Stated(refusal=_other("its comment", said))
    return Stated(refusal=_unread(unread)) if unread else Stated()


def _unread(place: str) -> str:
    return f"{place} may state a frame, expected '# frame: frd' or '# frame: flu'; write that, or {REMEDY}"


def _other(place: str, said: str) -> str:
    return f"{place} states frame {said[:60]}, expected frd or flu; {REMEDY}"


def id_frame(frame_id: str) -> str:
    """The frame of a ROS frame_id: z down where it says so by ned (REP 103), frd, fsd or down, else up."""
    down = _DOWN.search(frame_id) or (_WORD.search(frame_id) and "down" in frame_id.lower())
    return "frd" if down else "flu"


def is_fixed(frame_id: str) -> bool:
    """True if a ROS frame_id stays with the earth, so that it does not turn with the vehicle."""
    return frame_id.lower().rpartition("/")[2].partition("_")[0] in FIXED


def ids_frame(ids: Set[str]) -> Stated:
    """The frame of ROS's frame_ids; undecided where z is down in some and up in others, or one is fixed."""
    down = {name for name in ids if id_frame(name) == "frd"}
    if down and down != ids:
        return Stated(refusal=_other("its frame_id", f"{min(down)!r} and {min(ids - down)!r}"))
    if still := sorted(filter(is_fixed, ids)):
        return Stated(
            refusal=f"its frame_id {still[0][:40]!r} does not turn with the vehicle, expected one that does;"
            f" if wrenches are along the vehicle's axes, {REMEDY}"
        )
    if down:
        return Stated("frd", f"its frame_id is {min(down)[:40]!r}")
    named = min(filter(None, ids), default="")
    return Stated("flu", f"as ROS has it, frame_id {named[:40]!r}" if named else "as ROS has it")


def frame_columns(header: Sequence[str], first: Sequence[str], taken: Set[int]) -> dict[int, bool]:
    """Columns that may state the frame, and whether by a known name; others by their ``first`` cells."""
    named = {i: key(name) in FRAMES for i, name in enumerate(header) if i not in taken}
    return {i: known for i, known in named.items() if known or (i < len(first) and _WORD.search(first[i]))}


def table_frame(text: str, header: Sequence[str], cells: dict[int, set[str]], names: Iterable[str]) -> Stated:
    """The frame of a table's demands, by its comments, its column of the frame, or its names.

    Parameters
    ----------
    text, header : all of the file, and its header
    cells : by place, what stands in columns that may state the frame, in small letters
    names : of the demands' columns
    """
    comment = read_comments(text)
    known = {i: said for i, said in cells.items() if key(header[i]) in FRAMES}
    ids = {cell for said in known.values() for cell in said if cell}
    if comment != Stated():
        others = sorted(c for c in ids if _WORD.search(c) and id_frame(c) != comment.frame)
        if comment.refusal or not others:
            return comment
        return Stated(refusal=_other("its comment", f"{comment.frame}, a row of it {others[0]!r}"))
    frames = {cell for i, said in known.items() if key(header[i]) == "frame" for cell in said if cell}
    if odd := sorted(cell for cell in frames if not (_WORD.search(cell) or is_fixed(cell))):
        return Stated(refusal=_other("its column 'frame'", repr(odd[0])))
    if ids:
        return ids_frame(ids)
    for i, said in cells.items():
        if words := sorted(filter(_WORD.search, said)):
            return Stated(refusal=_unread(f"column {header[i][:40]!r} with {words[0][:40]!r}"))
    names = list(names)
    if column := next(filter(_WORD.search, names), ""):
        return Stated(refusal=_unread(f"column {column[:40]!r}"))
    sources = {(wrench.frame, wrench.source) for wrench in find_spellings(names)}
    if len(sources) == 1 and ("flu", "ROS") not in sources:
        frame, source = sources.pop()
        return Stated(frame, f"as {source} has it") if frame else Stated()
    return Stated(ros=next((name for name in names if _ROS.search(key(name))), ""))


def turn_to_frame(
    path: Path, taus: FloatArray, dof: tuple[str, ...], stated: Stated, told: str, wanted: str
) -> tuple[FloatArray, str]:
    """Demands (N, k) in the frame of a vehicle, and a sentence on what was done to them.

    Parameters
    ----------
    taus, dof : the demands and their columns
    stated, told : the frame by the log, and by the user, who is believed
    wanted : the frame of the vehicle, which demands are in where nothing says another one

    Raises DemandError where the log leaves the frame undecided.
    """
    if not told and stated.refusal:
        raise DemandError(f"{path}: {stated.refusal}")
    if stated.ros and not told and wanted == "frd":
        raise DemandError(
            f"{path}: column {stated.ros[:40]!r} is named as in ROS, where z is up, and nothing states its"
            " frame; give --frame flu, or --frame frd if z is down"
        )
    frame, why = (told, "--frame") if told else stated[:2]
    if not frame:
        frame, why = wanted, "the file names none"
    if frame == wanted:
        return taus, f"frame {frame} ({why}), the vehicle's own, nothing turned: {AXES[wanted]}"
    return turned(taus.T, dof).T, f"frame {frame} ({why}), turned into the vehicle's {described(wanted)}"
