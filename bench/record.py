"""What a run leaves behind: one JSON line a fact, appended as it is measured, read back by reports.

Times are integers in ns. A record holds raw samples; every statistic is computed on reading.
"""

from typing import Any

import msgspec

SCHEMA = 1


class Header(msgspec.Struct, tag="header", forbid_unknown_fields=False):
    """First line: what ran where, with what.

    machine: what ``bench.machine`` found (CPU, cores, memory, governor, OS, kernel).
    versions: Python and every package that took part. settings: the run's own options.
    """

    schema: int
    started: str
    commit: str
    seed: int
    machine: dict[str, Any]
    versions: dict[str, str]
    settings: dict[str, Any]


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


class Judged(msgspec.Struct, omit_defaults=True):
    """What the equations say about the answers that were timed; NaN is stored as null.

    wrench_error_max: largest |T P f - tau| per axis, over answers that are finite [N, N m].
    limit_violation_max_N: largest excess over a limit. distance_max_N: largest |f - f*|_inf to the
    reference of the same formulation. agrees: distance within the method's promise; None where no
    reference applies. certificate: largest relative duality gap. counts: statuses by name.
    wrong: why an answer is wrong (SOLVED but not so), empty where none is.
    """

    counts: dict[str, int]
    wrench_error_max: list[float | None]
    wrench_error_rel_max: float | None = None
    limit_violation_max_N: float | None = None
    distance_max_N: float | None = None
    distance_rel_max: float | None = None
    gap_rel_max: float | None = None
    tolerance: float | None = None
    agrees: bool | None = None
    wrong: str = ""
    loss: dict[str, float | None] = {}


class Cell(msgspec.Struct, tag="cell", omit_defaults=True):
    """One cell, measured by one process: a method on a vehicle's demand set.

    status: ok, or failed, crashed, timeout, missing, refused, with ``reason``.
    batches and singles are calls of the allocator; binding_singles calls of the solver's binding
    inside it; solver_singles what the solver itself reports. Singles are [[ns, count], …], sorted:
    a lossless multiset.
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
    binding_singles: list[tuple[int, int]] = []
    solver_singles: list[tuple[int, int]] = []
    iterations_max: int | None = None
    worst_case_steps: int | None = None
    allocator_bytes: int | None = None
    judged: Judged | None = None
    quiet: dict[str, Any] = {}


class Worker(msgspec.Struct, tag="worker", omit_defaults=True):
    """One worker process: how long it took to start and import, its memory, how quiet its core was."""

    method: str
    repeat: int
    startup_ns: int
    import_ns: int
    peak_rss_bytes: int
    canary_ns: list[int] = []
    quiet: dict[str, Any] = {}


Line = Header | Cell | Worker
