"""Record lines on generated C on other processors: instructions counted under emulation."""

import msgspec


class Emulated(msgspec.Struct, tag="emulated", omit_defaults=True):
    """Generated C on one processor, emulated: instructions of each call over one demand set, never times.

    Attributes
    ----------
    vehicle, target, method, scalar : what ran on which processor, in which precision
    limits : fixed where they stand in the C, call where each call gives them
    faults : which the C knows: none, any one in code of its own, or all in one function
    demands : a set's name; ``search`` for the most costly demand that a search tried; "-" where nothing
        was counted
    solver : the solver whose own generator wrote the C, empty for this project's generator
    status : ok, or missing, refused, failed
    reason : why not ok, in words
    instructions : of single calls, [[count, calls], …], sorted
    cycles : of the costliest call, at least and at most, by published timings at zero wait states; empty
        where none are known
    boards : the same with the waits for a board's flash, by the board's name
    worst : (k,) the demand that took most instructions [N, N m]
    flash_bytes, ram_static_bytes : by how much the kernel makes the linked image grow
    stack_bytes : depth of the stack that any call wrote to
    agrees : whether every answer is as in Python
    distance_rel_max : largest |f - f in Python| of any thrust, relative to the largest limit
    other_verdicts : demands that C and Python answer with different statuses, where rounding does not decide
    within_1pct_share : share of all demands that its thrusts deliver to 1 % [-]
    along_mean : share of a demand that is delivered along it, the mean of those it answered [-]
    direction_error_max_deg : the largest angle between delivered and demanded wrench [deg]
    least : instructions that any exact method takes at least; None where it is none, or not known
    tried : demands that the search tried
    known : of the search, the most instructions of any call: also of those whose demand overflows, or is none
    known_off : of the search, the most of any call with one thruster off; None where none was asked. All else
        is of calls without
    at_most : of the search, what no call exceeds, by the binary's longest path; None where that is not known
    seed : of the demands and of the search
    tools : versions of compiler and emulator, and this project's commit
    """

    vehicle: str
    target: str
    method: str
    scalar: str
    limits: str = "fixed"
    faults: str = "one"
    demands: str = "-"
    solver: str = ""
    status: str = "ok"
    reason: str = ""
    instructions: list[tuple[int, int]] = []
    cycles: list[int] = []
    boards: dict[str, list[int]] = {}
    worst: list[float] = []
    flash_bytes: int | None = None
    ram_static_bytes: int | None = None
    stack_bytes: int | None = None
    agrees: bool | None = None
    distance_rel_max: float | None = None
    other_verdicts: int = 0
    within_1pct_share: float | None = None
    along_mean: float | None = None
    direction_error_max_deg: float | None = None
    least: int | None = None
    tried: int = 0
    known: int | None = None
    known_off: int | None = None
    at_most: int | None = None
    seed: int = 0
    tools: dict[str, str] = {}


class BoardFacts(msgspec.Struct, omit_defaults=True, kw_only=True):
    """A board that cycles were worked out for; ``Emulated.boards`` names it.

    Attributes
    ----------
    name : the board's
    clock_MHz : its clock [MHz]
    basis : its wait states and caches, in words, and where they are from
    """

    name: str
    clock_MHz: float
    basis: str


class Processor(msgspec.Struct, tag="processor", omit_defaults=True, kw_only=True):
    """Facts about a processor that generated C was counted on; ``Emulated.target`` names it.

    Attributes
    ----------
    name : the target's
    scalars : precisions that methods are compared in there: those of its FPU
    cpi : least and most cycles an instruction takes, averaged over a call; empty where nothing is assumed
    basis : why these are assumed
    goal : how many times the goals that this project's C was set it may take; None for none
    microcontroller : whether it runs without an operating system
    boards : those that have it, where cycles with their flash are known
    """

    name: str
    scalars: list[str] = []
    cpi: list[float] = []
    basis: str = ""
    goal: float | None = None
    microcontroller: bool = False
    boards: list[BoardFacts] = []
