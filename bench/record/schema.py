"""The lines of a record: one JSON object a fact, as it was measured.

Times are integers in ns. A record holds samples; every statistic is computed on reading.
"""

from typing import Any

import msgspec

from bench.record.capability import Capability

SCHEMA = 2

NO_VEHICLE = "-"
"""Stands in a key where a cell belongs to no vehicle, and to none of its demands, as a canary does."""


class Header(msgspec.Struct, tag="header", kw_only=True):
    """First line: what ran where, with what.

    Attributes
    ----------
    schema : SCHEMA of whoever wrote it
    started : date and time, UTC
    commit : of this project's source
    seed : of demands and order
    machine : what ``bench.harness.machine`` found (CPU, cores, memory, governor, OS, kernel)
    versions : Python and every package that took part
    settings : the run's own options
    """

    schema: int
    started: str
    commit: str
    seed: int
    machine: dict[str, Any]
    versions: dict[str, str]
    settings: dict[str, Any]


class Method(msgspec.Struct, tag="method", omit_defaults=True, kw_only=True):
    """A method of the run, as its catalogue entry describes it.

    Attributes
    ----------
    name : label, as in keys
    formulation : which optimum it answers
    family : with which other methods reports show it
    solver : the QP solver it calls, empty for none
    foreign : whether calls run code that is not Python's
    twin : the method whose answers it gives by other means, empty for none
    yardstick : whether it measures the harness or the machine, and allocates nothing
    """

    name: str
    formulation: str = ""
    family: str = ""
    solver: str = ""
    foreign: bool = False
    twin: str = ""
    yardstick: bool = False


class Problem(msgspec.Struct, tag="problem", omit_defaults=True, kw_only=True):
    """One demand set of one vehicle, as it was asked.

    Attributes
    ----------
    vehicle : name of the one that must answer
    whole : its name without its faults; the same where it has none
    faults : each thruster that is off or weakened, with its readiness
    study : the study that it was generated for, empty for a vehicle of its own
    demands : name of the set
    n_demands : how many
    labels : demands by label (inactive, active, boundary, infeasible)
    rate_hz : sampling rate, None where the demands are no sequence in time
    reference : the method that gave the hard optimum
    dof, n, rank, nullity : of the vehicle
    f_scale : its largest limit [N]
    wrench_scale : (k,) size of a wrench on each axis [N, N m]
    left_out : demands of a log that were not asked
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


class Key(msgspec.Struct, frozen=True, order=True):
    """What names a cell: results.csv's key columns plus the repeat (each repeat is a fresh process)."""

    vehicle: str
    demands: str
    method: str
    start: str = "-"
    level: str = "-"
    repeat: int = 0


class Batch(msgspec.Struct, array_like=True):
    """``calls`` calls timed together [ns]: wall clock, CPU clock, involuntary context switches."""

    calls: int
    wall_ns: int
    cpu_ns: int
    switches: int


class Judged(msgspec.Struct, omit_defaults=True, kw_only=True):
    """What the equations say about the answers that were timed; NaN is stored as null.

    Attributes
    ----------
    answers : how many were judged
    counts : their statuses by name
    wrench_error_max : largest |T P f - tau| per axis over answers that are finite [N, N m]
    wrench_error_rel_max : the largest over the axes, relative to the vehicle's wrench scale
    limit_violation_max_N : largest excess over a limit
    distance_max_N : largest |f - f*|_inf to the right answer of the same formulation
    distance_rel_max : the same over f_scale
    gap_rel_max : largest relative duality gap
    failed_after_failure : share of attainable demands without thrusts, of those right after another such
        answer
    tolerance : what the method promises for distance_rel_max
    agrees : distance within the promise; None where there is no right answer to compare with
    wrong : why an answer is wrong (SOLVED but not so), empty where none is
    loss : what is lost against the exact answers
    """

    answers: int
    counts: dict[str, int]
    wrench_error_max: list[float | None] = []
    wrench_error_rel_max: float | None = None
    limit_violation_max_N: float | None = None
    distance_max_N: float | None = None
    distance_rel_max: float | None = None
    gap_rel_max: float | None = None
    failed_after_failure: float | None = None
    tolerance: float | None = None
    agrees: bool | None = None
    wrong: str = ""
    loss: dict[str, float | None] = {}


class Quiet(msgspec.Struct, omit_defaults=True):
    """What else the machine did while something was measured; None: not told here.

    Attributes
    ----------
    steal_ticks : time the hypervisor took from this core [1/100 s]
    throttled : thermal throttle events
    load : 1-minute load average
    mhz : lowest and highest frequency seen
    """

    steal_ticks: int | None = None
    throttled: int | None = None
    load: float | None = None
    mhz: list[float] | None = None


class Cell(msgspec.Struct, tag="cell", omit_defaults=True):
    """One cell, measured by one process: a method on a vehicle's demand set.

    Attributes
    ----------
    key : what names it
    status : ok, or failed (it raised), crashed, timeout, missing, refused
    reason : why not ok, in words
    formulation, limited : as the allocator says
    n_demands : of the set
    setup_ns : each ``build``, the first one of a process left out (see ``Worker.import_ns``)
    batches : calls of the allocator
    binding_batches : calls of the solver's binding inside it
    singles : single calls, [[ns, count], …], sorted, in bins (``bench.harness.timing.counted``)
    solver_singles : what the solver itself reports of each, in the same form
    iterations_max : the solver's own count
    worst_case_steps : a bound that no demand can exceed
    allocator_bytes : see ``bench.harness.memory.reachable_bytes``
    timed_ns : the sum of all timed calls
    canary_ns : the canary just after this cell
    judged, quiet : what the answers are worth, and what else the machine did
    """

    key: Key
    status: str
    reason: str = ""
    formulation: str = ""
    limited: bool = False
    n_demands: int = 0
    setup_ns: list[int] = []
    batches: list[Batch] = []
    binding_batches: list[Batch] = []
    singles: list[tuple[int, int]] = []
    solver_singles: list[tuple[int, int]] = []
    iterations_max: int | None = None
    worst_case_steps: int | None = None
    allocator_bytes: int | None = None
    timed_ns: int = 0
    canary_ns: int | None = None
    judged: Judged | None = None
    quiet: Quiet | None = None


class Worker(msgspec.Struct, tag="worker", omit_defaults=True, kw_only=True):
    """One worker process, written as it ends.

    Attributes
    ----------
    method, start, level, repeat : what it measured
    startup_ns : from the parent's spawn to the first line of work, before the method is imported
    import_ns : how much longer the first ``build`` took than later ones: the import of the method and
        its solver
    peak_rss_bytes : the process's high-water mark; the ``noop`` worker's is that of an empty one
    canary_ns : the canary before the first cell
    core : where it was pinned, None for anywhere
    """

    method: str
    start: str
    level: str
    repeat: int
    startup_ns: int
    import_ns: int | None = None
    peak_rss_bytes: int | None = None
    canary_ns: int | None = None
    core: int | None = None


class Emulated(msgspec.Struct, tag="emulated", omit_defaults=True):
    """Generated C on one processor, emulated: instructions of each call over one demand set, never times.

    Attributes
    ----------
    vehicle, target, method, scalar : what ran where, in which precision
    demands : a set's name; ``search`` for the most costly of all that a search tried; "-" where nothing
        was counted
    solver : whose C it is, empty for this project's own
    status : ok, or missing, refused, failed
    reason : why not ok, in words
    instructions : of single calls, [[count, calls], …], sorted
    worst : the demand that took most
    flash_bytes, ram_static_bytes : by how much the linked image grows
    stack_bytes : deepest that any call wrote
    agrees : every answer as in Python
    distance_rel_max : largest |f - f in Python| of any thrust, relative to the largest limit
    other_verdicts : demands off the boundary that one calls feasible and the other does not
    tried : demands that the search tried
    seed : of demands and search
    tools : versions of compiler and emulator, and this project's commit
    """

    vehicle: str
    target: str
    method: str
    scalar: str
    demands: str = "-"
    solver: str = ""
    status: str = "ok"
    reason: str = ""
    instructions: list[tuple[int, int]] = []
    worst: list[float] = []
    flash_bytes: int | None = None
    ram_static_bytes: int | None = None
    stack_bytes: int | None = None
    agrees: bool | None = None
    distance_rel_max: float | None = None
    other_verdicts: int = 0
    tried: int = 0
    seed: int = 0
    tools: dict[str, str] = {}


class Event(msgspec.Struct, tag="event", omit_defaults=True, kw_only=True):
    """Something happened to the run.

    Attributes
    ----------
    what : began, resumed, interrupted or finished
    at : date and time, UTC
    wall_s : since it was started or resumed [s]
    timed_s : the sum of all timed calls since then [s]; wall_s over it is the harness's own price
    load : 1-minute load average
    """

    what: str
    at: str
    wall_s: float = 0.0
    timed_s: float = 0.0
    load: float | None = None


Line = Header | Method | Problem | Capability | Cell | Worker | Emulated | Event
