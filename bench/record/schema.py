"""What a run leaves behind: one JSON line a fact, appended as it is measured, read back by reports.

Times are integers in ns. A record holds samples; every statistic is computed on reading.
"""

from typing import Any

import msgspec

from bench.record.capability import Worth

SCHEMA = 1


class Header(msgspec.Struct, tag="header"):
    """First line: what ran where, with what.

    machine: what ``bench.harness.machine`` found (CPU, cores, memory, governor, OS, kernel).
    versions: Python and every package that took part. settings: the run's own options.
    """

    schema: int
    started: str
    commit: str
    seed: int
    machine: dict[str, Any]
    versions: dict[str, str]
    settings: dict[str, Any]


class Problem(msgspec.Struct, tag="problem", omit_defaults=True):
    """One demand set of one vehicle, as it was asked.

    labels: demands by label (inactive, active, boundary, infeasible). reference: the method that
    gave the hard optimum. k, n, rank, nullity, f_scale [N], dof: of the vehicle that must answer.
    left_out: demands of a log that were not asked.
    """

    vehicle: str
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
    """What names a cell: results.csv's key columns plus the repeat (each repeat is a fresh process).

    The canaries belong to no vehicle: theirs, and their demands, are "-".
    """

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


class Judged(msgspec.Struct, omit_defaults=True):
    """What the equations say about the answers that were timed; NaN is stored as null.

    answers: how many were judged. counts: their statuses by name.
    wrench_error_max: largest |T P f - tau| per axis over answers that are finite [N, N m];
    wrench_error_rel_max: the largest over the axes, relative to the vehicle's wrench scale.
    limit_violation_max_N: largest excess over a limit. distance_max_N: largest |f - f*|_inf to the
    reference of the same formulation; distance_rel_max: the same over f_scale. tolerance: what the
    method promises for it. agrees: distance within the promise; None where no reference applies.
    gap_rel_max: largest relative duality gap. failed_after_failure: share of attainable demands that got
    no thrusts, of those right after another such answer. loss: what is lost against the exact answers.
    wrong: why an answer is wrong (SOLVED but not so), empty where none is.
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
    """What else the machine did while something was measured; the verdict is made on reading.

    steal_ticks: time the hypervisor took from this core [1/100 s]; throttled: thermal throttle
    events; load: 1-minute load average; mhz: [lowest, highest] frequency seen. None: not told here.
    """

    steal_ticks: int | None = None
    throttled: int | None = None
    load: float | None = None
    mhz: list[float] | None = None


class Cell(msgspec.Struct, tag="cell", omit_defaults=True):
    """One cell, measured by one process: a method on a vehicle's demand set.

    status: ok, or failed (it raised), crashed, timeout, missing, refused, with ``reason``.
    setup_ns: each ``build``, the first one of a process left out (see Worker.import_ns).
    batches and singles are calls of the allocator; binding_batches calls of the solver's binding
    inside it; solver_singles what the solver itself reports. Singles are [[ns, count], …], sorted,
    in bins 2 % wide (``bench.harness.timing.counted``).
    iterations_max: the solver's own count. allocator_bytes: see ``bench.harness.memory.reachable_bytes``.
    timed_ns: the sum of all timed calls. canary_ns: the canary just after this cell.
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


class Worker(msgspec.Struct, tag="worker", omit_defaults=True):
    """One worker process, written as it ends.

    startup_ns: from the parent's spawn to the first line of work, before the method is imported.
    import_ns: how much longer the first ``build`` took than later ones: the import of the method
    and its solver. peak_rss_bytes: the process's high-water mark; the ``noop`` worker's is that of
    an empty one. canary_ns: the canary before the first cell.
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

    demands: a set's name; ``search`` for the most costly of all that a search ``tried``; "-" where
    nothing was counted. status: ok, or missing, refused, failed, with ``reason``.
    instructions: of single calls, [[count, calls], …], sorted. worst: the demand that took most.
    flash_bytes, ram_static_bytes: growth of the linked image. stack_bytes: deepest that any call wrote.
    agrees: every answer as in Python; distance_rel_max: of any thrust, relative to the largest limit;
    other_verdicts: demands off the boundary that one calls feasible and the other does not.
    tools: versions of compiler and emulator, and this project's commit.
    """

    vehicle: str
    target: str
    method: str
    scalar: str
    demands: str = "-"
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


class Event(msgspec.Struct, tag="event", omit_defaults=True):
    """The run began, was resumed, was interrupted or finished, at a time, after ``wall_s`` in this go.

    timed_s: the sum of all timed calls of this go [s]; wall_s over it is the harness's own price.
    """

    what: str
    at: str
    wall_s: float = 0.0
    timed_s: float = 0.0
    load: float | None = None


Line = Header | Problem | Worth | Cell | Worker | Emulated | Event
