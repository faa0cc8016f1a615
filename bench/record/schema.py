"""Lines of a record and the names in it: each line is one JSON object and holds one fact.

Times are integers in ns. A record holds samples; whoever reads it works out the statistics.
"""

import re
from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from bench.record.capability import Capability
from bench.record.measured import Cell

SCHEMA = 2

NO_VEHICLE = "-"
"""Vehicle and demands in the key of a cell that has neither, such as a canary's."""


class Header(msgspec.Struct, tag="header", kw_only=True):
    """The first line of a record: what ran, where, with which versions and options.

    Attributes
    ----------
    schema : SCHEMA of the program that wrote the record
    started : date and time, UTC
    commit : of this project's source
    seed : of the demands and of the order of cells
    machine : what ``bench.harness.machine`` says of it (CPU, cores, memory, governor, OS, kernel)
    versions : Python and every package that took part
    settings : the run's own options
    files : SHA-256 of the users' files that took part (plug-ins, vehicles, logs), by path
    """

    schema: int
    started: str
    commit: str
    seed: int
    machine: dict[str, Any]
    versions: dict[str, str]
    settings: dict[str, Any]
    files: dict[str, str] = {}


class Method(msgspec.Struct, tag="method", omit_defaults=True, kw_only=True):
    """A method of the run, as its catalogue entry describes it.

    Attributes
    ----------
    name : as in keys
    formulation : what a right answer of the method is
    family : the methods that reports show it with
    solver : the QP solver it calls, empty for none
    foreign : whether calls run code that is not Python's
    twin : the method in Python whose answers generated C must give, empty for all else
    yardstick : whether it allocates nothing: it measures the harness, the machine, or the way to the ESCs
    plugin : whether a user brought it in a file
    """

    name: str
    formulation: str = ""
    family: str = ""
    solver: str = ""
    foreign: bool = False
    twin: str = ""
    yardstick: bool = False
    plugin: bool = False

    def __post_init__(self) -> None:
        """Give the family of version 0.1 in ``results`` its present name."""
        self.family = RENAMED_FAMILIES.get(self.family, self.family)

    @property
    def base(self) -> str:
        """Name of the method in Python that gives these answers, or its own: of scaled@library, scaled."""
        return self.name if self.plugin else self.twin or self.name.partition("@")[0]


RENAMED_FAMILIES = {"exact closed form": "for an optimum, no QP solver"}
"""Families as version 0.1 wrote them, and their names now: not each of their methods is exact."""


class Problem(msgspec.Struct, tag="problem", omit_defaults=True, kw_only=True):
    """One demand set of one vehicle, as it was asked.

    Attributes
    ----------
    vehicle : name of the vehicle that must answer, with its faults
    whole : name of that vehicle without its faults
    faults : each thruster that is off or weakened, with its readiness
    study : the study that the vehicle was generated for, empty for any other vehicle
    demands : name of the set
    n_demands : demands in the set
    labels : number of demands by label (inactive, active, boundary, infeasible)
    rate_hz : sampling rate, None where the demands are no sequence in time
    reference : the method that gave the hard optimum, empty where none did
    dof, n, rank, nullity : of the vehicle, rank and nullity without weak directions
    f_scale : the vehicle's largest limit [N]
    wrench_scale : (k,) size of a wrench on each axis [N, N m]
    left_out : demands of a log, or of a mission, that were not asked
    beyond, beyond_longest : of all demands of a log, these included, how many can't be met, and how many of
        them follow one another at most
    crossed, crossed_asked : of all demands of a log, and of those asked, how many had limits that cross;
        nobody can keep them, and ``beyond`` is without them
    moving : whether each demand had limits of its own
    cap_A, volts : cap of each call on the sum of currents, and the voltage of these; ``labels`` are of what
        it leaves. None where calls had none
    said : how a log was understood, and what is doubtful about it
    names : of the vehicle's thrusters, empty where they have none
    given : whether a user brought the demands in a file
    frame : frd or flu, of the demands and of every wrench; records without it are of a time that turned all
        vehicles into frd
    numbers : of the vehicle, by which another one of its name is known: T by rows, f_min, f_max, the diagonal
        of H, readiness; empty in older records
    sums : of a user's demands and their limits, by which another log of the name is known: each column's
        positive and negative entries times their place, from 1/N to 1 [N, N m]
    weak : directions that are weak or count in part, not lost, in words; ``labels`` are without weak ones,
        and with what counts in part. Empty in older records
    weak_bound_N : the most that thrusts within limits make along each, moments over the rms arm [N]
    alpha_hard : median of alpha* of eq. 4-5 [-], which holds weak directions at the demand, else None
    """

    vehicle: str
    whole: str
    faults: list[tuple[int, float]] = []
    study: str = ""
    demands: str
    n_demands: int
    labels: dict[str, int]
    rate_hz: float | None
    reference: str
    dof: list[str]
    n: int
    rank: int
    nullity: int
    f_scale: float
    wrench_scale: list[float]
    left_out: int = 0
    beyond: int = 0
    beyond_longest: int = 0
    crossed: int = 0
    crossed_asked: int = 0
    moving: bool = False
    cap_A: float | None = None
    volts: float | None = None
    said: list[str] = []
    names: list[str] = []
    given: bool = False
    frame: Literal["frd", "flu"] = "frd"
    numbers: list[float] = []
    sums: list[float] = []
    weak: list[str] = []
    weak_bound_N: list[float] = []
    alpha_hard: float | None = None


class Worker(msgspec.Struct, tag="worker", omit_defaults=True, kw_only=True):
    """One worker process, written as it ends.

    Attributes
    ----------
    method, start, level, repeat : what the worker measured
    import_ns : how much longer the first ``build`` took than later ones: the import of the method and
        its solver
    peak_rss_bytes : largest memory of the process; that of the ``noop`` worker is an empty process's
    canary_ns : time of the canary before the first cell
    core : the core it was pinned to, None where it was free
    """

    method: str
    start: str
    level: str
    repeat: int
    import_ns: int | None = None
    peak_rss_bytes: int | None = None
    canary_ns: int | None = None
    core: int | None = None


class Event(msgspec.Struct, tag="event", omit_defaults=True, kw_only=True):
    """Something happened to the run.

    Attributes
    ----------
    what : began, resumed, interrupted or finished
    at : date and time, UTC
    wall_s : time since the run was started or resumed [s]
    timed_s : the sum of all timed calls in that time [s]; wall_s over timed_s is the harness's own price
    load : 1-minute load average
    """

    what: str
    at: str
    wall_s: float = 0.0
    timed_s: float = 0.0
    load: float | None = None


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


class ProcessorFacts(msgspec.Struct, tag="processor", omit_defaults=True, kw_only=True):
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


Line = Header | Method | Problem | Capability | Cell | Worker | Emulated | ProcessorFacts | Event


def machine_name(facts: Mapping[str, Any]) -> str:
    """A name such as ``amd-epyc-2-cores``: what the facts call ``name``, else made of processor and cores."""
    if name := facts.get("name"):
        return str(name)
    cores = facts.get("cores")
    return slug(f"{facts.get('cpu') or ''} {f'{cores} cores' if cores else ''}")


def slug(text: str) -> str:
    """The text as a folder's name: lower case, with hyphens; ``machine`` where nothing is left of it."""
    return re.sub(r"[^a-z0-9.]+", "-", re.sub(r"\((r|tm)\)", "", text.lower())).strip("-.") or "machine"


LONGEST = 100
"""Letters of a name at most; a vehicle's file has up to 60, to which each fault adds some."""


def unusable(vehicle: str) -> str:
    """Reason why a vehicle can't go by that name, which pictures and pages are named after; else empty."""
    if 0 < len(vehicle) <= LONGEST and vehicle.isprintable():
        return ""
    shown = f"{vehicle[:40]!r}{' …' if len(vehicle) > 40 else ''}"
    return f"vehicle {shown} is no name of 1 to {LONGEST} printable characters"
