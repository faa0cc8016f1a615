"""A vehicle as far as a file of another project tells."""

from dataclasses import dataclass, field

from alloc.vehicle.frame import AXES, described
from alloc.vehicle.keys import Numbers
from bench.inputs.frames import frame_in, undecided


@dataclass(kw_only=True)
class Draft:
    """A vehicle as far as a file tells, in the file's own frame; None or empty where the file does not tell.

    Attributes
    ----------
    source : name and kind of the file, in words
    dof : names of the rows of T, or without T of the controlled axes
    T : (k, n) rows [-], [m]
    positions, directions : (n, 3) poses [m], [-]
    center_of_mass : (3,) [m]
    reaction_torque : (n,) each propeller's own moment along its thrust [m]
    names : (n,) what the thrusters are called
    f_min, f_max : one limit for all thrusters, or one each [N]
    limits_assumed : what of these the file does not say, one sentence each; void once both are told
    weights, slack_weights : (n,) and (k,) diagonals of H and Q
    frame : frd or flu
    frame_assumed : why that frame is taken, in a sentence; empty where the file, its format or the user says
    frame_refused : why no frame can be taken until the user says one; empty where one can
    assumptions : what else the file does not say and is assumed, one sentence each
    """

    source: str
    dof: tuple[str, ...] = ()
    T: list[Numbers] | None = None
    positions: list[Numbers] | None = None
    directions: list[Numbers] | None = None
    center_of_mass: Numbers | None = None
    reaction_torque: Numbers | None = None
    names: list[str] | None = None
    f_min: float | Numbers | None = None
    f_max: float | Numbers | None = None
    weights: Numbers | None = None
    slack_weights: Numbers | None = None
    frame: str = "frd"
    frame_assumed: str = ""
    frame_refused: str = ""
    limits_assumed: list[str] = field(default_factory=list)
    assumptions: list[str] = field(default_factory=list)


def commented(draft: Draft, text: str) -> Draft:
    """The draft in the frame that a comment of its file says; without one in its format's own, else frd."""
    said, why = frame_in(text)
    if said in AXES:
        draft.frame, draft.frame_assumed = said, ""
    elif said:
        draft.frame_refused = undecided(said, why)
    elif not draft.frame_assumed:
        draft.frame_assumed = f"The file names no frame: {described('frd')} is taken; --frame flu if z is up."
    return draft
