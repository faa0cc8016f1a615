"""Frames of data that meet a vehicle: what a file says of them, and the line that says what was turned."""

import re
from collections.abc import Sequence, Set
from pathlib import Path
from typing import NamedTuple

from alloc.allocation import FloatArray
from alloc.errors import DemandError
from alloc.vehicle.frame import AXES, described, turned

FIXED = ("earth", "map", "odom", "world", "ned", "enu")
"""First words of ROS's frames that stay with the earth (REP 105), not with the vehicle."""
_DOWN = re.compile(r"(\b|_|base|body|link)(ned|frd|fsd)(\b|_)", re.IGNORECASE)
"""A word of a ROS frame with z down: north, east, down; ahead, to the right or to starboard, down."""
_ROS = re.compile(r"(force|torque|linear|angular)[./_]+[yz]\b", re.IGNORECASE)
"""Names of geometry_msgs' fields along y and z, whose signs depend on the frame."""
_COMMENT = re.compile(r"^[^\S\n]*(?:#|%|//).*", re.MULTILINE)
_FORM = re.compile(r"\bframe(?P<id>_?id)?\s*[:=]\W*(?P<name>[^\W\d][\w/]*)", re.IGNORECASE)
"""The form in which a comment says a frame."""
_WORD = re.compile(
    r"(\b|_|base|body|link)(ned|frd|fsd|flu|enu)(\b|_)|\bbase_link\b"
    r"|(?<![^\W_])(?:z|heave)(?![^\W_])(?:[\W_]|axis|is|points|positive)*(?:down|up)(?:wards?)?\b(?!\s+to\b)"
    r"|\b(?:forward|ahead|north|east)\W+(?:right|starboard|left|port|north|east)\W+(?:down|up)\b"
    rf"|\b(?:{'|'.join(FIXED)})[\W_](?:fixed[\W_])?frame\b",
    re.IGNORECASE,
)
"""Words that are about axes, in whatever form."""
UNREAD = "unread"
"""In place of a frame where something is about axes, in no form that is read."""


def frame_comment(frame: str) -> str:
    """The line that says a file's frame: ``# frame: flu (x ahead, y to port, z up)``."""
    return f"# frame: {frame} ({AXES[frame]})\n"


def frame_in(text: str) -> tuple[str, str]:
    """The frame that comments as such a line say, ``flu`` or ``enu and flu``, and what says so; else empty.

    A comment with ROS's frame_id says the frame of that, where it turns with the vehicle, else the id. Where
    only comments in other forms have words about axes, it is ``UNREAD``.
    """
    names, unread = set[str](), ""
    for comment in _COMMENT.finditer(text):
        if match := _FORM.search(comment[0]):
            name = match["name"].lower()
            names.add(of_id(name) if match["id"] and not fixed(name) else name)
        elif not unread and _WORD.search(comment[0]):
            unread = f"line {text.count(chr(10), 0, comment.start()) + 1}: {comment[0].strip()[:60]!r}"
    if names:
        return " and ".join(sorted(names)), "its comment"
    return (UNREAD, unread) if unread else ("", "")


def undecided(said: str, why: str) -> str:
    """The refusal of a frame that is neither frd nor flu, as ``frame_in`` says it."""
    if said == UNREAD:
        return (
            f"{why} may say a frame, but not in a form that is read; write the line '# frame: frd' or"
            " '# frame: flu', or give --frame frd or flu"
        )
    return f"{why} says frame {said}; give --frame frd or flu"


def of_id(frame_id: str) -> str:
    """The frame of a ROS frame_id: z down where it says so by ned (REP 103), frd, fsd or down, else up."""
    down = _DOWN.search(frame_id) or (_WORD.search(frame_id) and "down" in frame_id.lower())
    return "frd" if down else "flu"


def fixed(frame_id: str) -> bool:
    """True if a ROS frame_id stays with the earth, so that it does not turn with the vehicle."""
    return frame_id.lower().rpartition("/")[2].partition("_")[0] in FIXED


_ID = re.compile(r"(?P<message>.*?)(?:header[./_])?frame_?id", re.IGNORECASE)
"""A column with ROS's frame_id, behind the name of its message."""
_FRAME = re.compile(
    r"(?:(?:coord\w*|ref|reference|body|vehicle|wrench|demand)[ _.])?frame|axes|coord\w*[ _.]system",
    re.IGNORECASE,
)


class IdColumn(NamedTuple):
    """A column that says the frame of demands.

    Attributes
    ----------
    place : which one it is, from 0; None where there is none
    other : whether it may hold other things too, as one called ``frame`` does a camera's count
    """

    place: int | None = None
    other: bool = False

    def ids(self, cells: Sequence[str]) -> set[str]:
        """The frame_id in a row, in small letters; none where the cell is empty, or says something else."""
        name = "" if self.place is None else cells[self.place].strip().lower()
        return {name} if name and (not self.other or _WORD.search(name) or fixed(name)) else set()

    def read(self, ids: Set[str]) -> int | None:
        """Its place, unless it may hold other things and no row had one of the ``ids``."""
        return None if self.other and not ids else self.place


def id_column(header: Sequence[str], names: Sequence[str]) -> IdColumn:
    """The column of the frame_id of the message that columns of these names belong to, else ``frame``."""
    for i, column in enumerate(header):
        match = _ID.fullmatch(column)
        if match and any(name.startswith(match["message"]) for name in names):
            return IdColumn(i)
    return next(
        (IdColumn(i, other=True) for i, name in enumerate(header) if _FRAME.fullmatch(name)), IdColumn()
    )


def of_ids(path: Path, ids: Set[str]) -> tuple[str, str, str]:
    """The frame that ROS's frame_ids say, what says so, and a doubt, empty for none, that --frame settles.

    Raises DemandError where z is down in some and up in others.
    """
    down = {name for name in ids if of_id(name) == "frd"}
    if down and down != ids:
        both = f"{min(down)[:40]!r} and {min(ids - down)[:40]!r}"
        raise DemandError(f"{path}: frame_id is {both}: z down in some, up in others; make it one")
    still, doubt = sorted(filter(fixed, ids)), ""
    if still:
        doubt = (
            f"{path.name}: its frame_id is {still[0][:40]!r}, which does not turn with the vehicle, but its"
            " wrenches are taken along the vehicle's axes; --frame says that they are"
        )
    if down:
        return "frd", f"its frame_id is {min(down)[:40]!r}", doubt
    named = min(filter(None, ids), default="")
    return "flu", f"as ROS has it, frame_id {named[:40]!r}" if named else "as ROS has it", doubt


def of_table(path: Path, comment: tuple[str, str], ids: Set[str]) -> tuple[str, str, str]:
    """As ``of_ids``, of a table, where its ``comment`` goes before its frame_ids; empty without either.

    An id about other axes than the comment's leaves the frame undecided.
    """
    said, why = comment
    if not said:
        return of_ids(path, ids) if ids else ("", "", "")
    other = min((name for name in ids if _WORD.search(name) and of_id(name) != said), default="")
    if other and said in AXES:
        said = f"{said}, a row of it {other[:40]!r}"
    return said, why, ""


def frame_of(
    path: Path, told: str, said: str, why: str, wanted: str, named: Sequence[str] = ()
) -> tuple[str, str]:
    """The frame of a log's demands, and what says so; raises DemandError where the log leaves it undecided.

    Parameters
    ----------
    told : by the user, else empty
    said, why : by the log, else empty, and where
    wanted : the vehicle's, which is taken where nothing says one
    named : names of the demands' columns
    """
    if told:
        return told, "--frame"
    if not said and (column := next(filter(_WORD.search, named), "")):
        said, why = UNREAD, f"column {column[:40]!r}"
    if said and said not in AXES:
        raise DemandError(f"{path}: {undecided(said, why)}")
    return (said, why) if said else (wanted, "the file names none")


def like_ros(path: Path, names: Sequence[str], wanted: str) -> str:
    """A doubt about columns that are named as ROS names them, on a vehicle with z down; empty for none."""
    named = [name for name in names if _ROS.search(name)]
    if wanted != "frd" or not named:
        return ""
    return (
        f"{path.name}: {named[0]!r} is named as in ROS, where z is up, but is taken as it is, with z down;"
        " if it is ROS's, --frame flu, else --frame frd"
    )


def doubted(path: Path, told: str, said: str, framed: str, named: Sequence[str], wanted: str) -> str:
    """Doubt about the frame of a log's demands, in a line; empty where the user tells it.

    Parameters
    ----------
    told : by the user, else empty
    said, framed : the frame that the log says, else empty, and what may be wrong about that
    named : names of the demands' columns, by which one may be guessed where the log says none
    wanted : the vehicle's
    """
    if told:
        return ""
    return framed if said else like_ros(path, named, wanted)


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
