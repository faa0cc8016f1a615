"""Record lines on a cell: its times, its verdict, and what else the machine did."""

from functools import cache
from math import log
from typing import Annotated

import msgspec

Count = Annotated[int, msgspec.Meta(ge=0, le=2**53)]
"""A number of calls or of ns, up to where doubles count one by one; another one is a damaged file's."""
FARTHER = "farther from the optimum than promised"
"""Fault of an answer that breaks no equation."""


class Key(msgspec.Struct, frozen=True, order=True):
    """The name of a cell: results.csv's key columns and the repeat.

    Attributes
    ----------
    vehicle, demands, method : names
    start, level : of the solver, "-" for a method that has none
    repeat : number of the fresh process that measured the cell
    """

    vehicle: str
    demands: str
    method: str
    start: str = "-"
    level: str = "-"
    repeat: int = 0


class Batch(msgspec.Struct, array_like=True):
    """Calls timed together.

    Attributes
    ----------
    calls : how many
    wall_ns, cpu_ns : wall clock and CPU clock for all of them [ns]
    switches : involuntary context switches
    """

    calls: Annotated[int, msgspec.Meta(ge=1)]
    wall_ns: Count
    cpu_ns: Count
    switches: int


class Judged(msgspec.Struct, omit_defaults=True, kw_only=True):
    """Verdict of the equations on the answers that were timed; NaN is stored as null.

    Attributes
    ----------
    answers : number of answers
    counts : number of answers by the name of their status
    wrench_error_max : (k,) largest |T P f - tau| on each axis, of the finite answers [N, N m]
    wrench_error_rel_max : largest |T P f - tau| over the vehicle's wrench scale, of all axes [-]
    limit_violation_max_N : largest excess over a limit
    distance_max_N : largest |f - f*|_inf to the right answer of the same formulation
    distance_rel_max : distance_max_N over the vehicle's f_scale [-]
    gap_rel_max : largest duality gap over the cost [-]
    failed_after_failure : of the attainable demands that follow an answer without thrusts, the share that
        got no thrusts either
    tolerance : what the method promises for distance_rel_max
    agrees : whether the distance is within the promise; None where no right answer is known, or none promised
    wrong : which answers are wrong, such as SOLVED with a violated limit; empty where none is
    loss : ``bench.judging.loss.loss``, what the answers give away against the exact ones
    missed_max : largest share of an attainable demand's wrench that is not delivered, 1 where there are no
        thrusts; None where no demand is inactive or active, and in records from before it was worked out
    missed_p50 : median of that share, over attainable demands that are not next to nothing; None where there
        is none, and in records from before it was worked out
    nothing_share : share of demands that got a wrench of nothing, as ``bench.judging.loss.gets_nothing``
        has it [-]; 0 in records from before it was counted
    refused_longest : longest run of demands, one after another, without thrusts or a wrench; 0 in records
        from before it was counted
    share_p50, share_min : median and least of what was delivered of each level of a demand, as the answers
        say; empty for a method that says nothing of shares, and in records from before they were kept
    partial_by_weak : number of answers that are PARTIAL, and deliver all but a weak part of the demand
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
    missed_max: float | None = None
    missed_p50: float | None = None
    nothing_share: float = 0.0
    refused_longest: int = 0
    share_p50: list[float] = []
    share_min: list[float] = []
    partial_by_weak: int = 0

    @property
    def objection(self) -> str:
        """Reason why the answers are wrong, an equation or the promised distance; empty if they are right."""
        return self.wrong or (FARTHER if self.agrees is False else "")


class Quiet(msgspec.Struct, omit_defaults=True):
    """Other activity of the machine during a measurement; None where this machine does not tell.

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
    key : the cell's name
    status : ok, or failed (it raised), crashed, timeout, missing, refused
    reason : why the status is not ok, in words
    formulation, limited : as the allocator says
    n_demands : demands in the set
    setup_ns : time of each ``build`` but the process's first (see ``Worker.import_ns``)
    batches : calls of the allocator
    binding_batches : calls of the solver's binding alone, b -> x over prepared b's
    way_in_batches : idle calls by the way to somebody's library or program
    singles : single calls, [[ns, count], …], sorted, in bins (``bench.harness.timing.tally``)
    solver_singles : times that the solver itself reports for single calls, in the same bins
    iterations_max : most iterations of a call, as the solver counts them
    worst_case_steps : a bound on the steps that no demand can exceed
    allocator_bytes : see ``bench.harness.worker.reachable_bytes``
    timed_ns : the sum of all timed calls
    judging_ns : time of asking and judging what was not timed, as the rest of a mission is
    canary_ns : time of the canary just after this cell
    disbelieved : what the solver said in so many of the timed calls and was not believed
        (``alloc.solvers.disbelieved``)
    worst : (k,) the demand of the slowest call, where it is known, as on a board [N, N m]
    judged, quiet : what the equations say of the answers, and what else the machine did
    """

    key: Key
    status: str
    reason: str = ""
    formulation: str = ""
    limited: bool = False
    n_demands: Count = 0
    setup_ns: list[Count] = []
    batches: list[Batch] = []
    binding_batches: list[Batch] = []
    way_in_batches: list[Batch] = []
    singles: list[tuple[Count, Count]] = []
    solver_singles: list[tuple[int, Count]] = []
    iterations_max: int | None = None
    worst_case_steps: int | None = None
    allocator_bytes: int | None = None
    timed_ns: int = 0
    judging_ns: int = 0
    canary_ns: int | None = None
    disbelieved: dict[str, int] = {}
    worst: list[float] = []
    judged: Judged | None = None
    quiet: Quiet | None = None


BIN = 1.02
"""Bins are 2 % wide, so a time is at most 1 % off; the median of single calls repeats only within 1-3 %
(docs/method.md). Counting in bins keeps a run's record small enough to be committed."""


@cache
def binned(ns: int) -> int:
    """The middle of the bin that ``ns`` falls into [ns]: the nearest power of BIN, as a whole number."""
    return ns if ns < 1 else round(BIN ** round(log(ns) / log(BIN)))
