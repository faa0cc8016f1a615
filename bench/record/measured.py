"""Record lines on what was measured: the times and verdict of a cell, the capability of a vehicle."""

from functools import cache
from math import log
from typing import Annotated

import msgspec

from bench.record.fuse import FuseCost
from bench.record.mixer import MixerCost
from bench.record.unannounced import FailureCost

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


SERVED_WITHIN = 0.01
"""Relative error of a delivered wrench up to which a demand counts as served, on all pages [-]."""


class Authority(msgspec.Struct, kw_only=True):
    """Capability of a vehicle with one thruster off, or with none.

    Attributes
    ----------
    fault : the thruster that is off, None for the whole vehicle
    vehicle : name of the vehicle with that fault
    rank : independent directions left
    condition : largest over smallest singular value of T P in rows of unit length, None where rank is
        lost: 10 is ordinary; 1000 says that some direction costs a thousand times the thrust of another
    volume_share : volume of the attainable set over that of the whole vehicle; 0 where rank is lost [-]
    closed_form_share : share of the attainable volume with this fault that f = T* tau serves inside the
        limits; None where the volume can't be worked out [-]
    safe_share : f = T* tau serves every demand up to this share of what is attainable in the demand's
        direction, whatever the direction [-]
    axis_min, axis_max : (k,) wrench along each axis alone, in the order of ``Capability.dof`` [N, N m];
        None where no such wrench is attainable
    """

    fault: int | None
    vehicle: str
    rank: int
    condition: float | None
    volume_share: float
    closed_form_share: float | None
    safe_share: float
    axis_min: list[float | None]
    axis_max: list[float | None]


class Loss(msgspec.Struct, kw_only=True):
    """Worst of a method over a set of demands that can be met.

    Attributes
    ----------
    n_demands, n_answers : demands asked, and those that got thrusts
    missed_max : largest share of a demand's wrench that is not delivered, 1 without thrusts [-]
    turned_max_deg : largest angle between delivered and demanded wrench; None where none has a direction
    """

    n_demands: int
    n_answers: int
    missed_max: float
    turned_max_deg: float | None


class Served(msgspec.Struct, kw_only=True, omit_defaults=True):
    """Part of the attainable set that a method serves, counted on demands that are uniform in volume.

    Attributes
    ----------
    fault : the thruster that is off, None for the whole vehicle
    method : its name
    n_demands : demands asked
    within_1pct, within_5pct : demands delivered with a relative wrench error of at most that much
    sample : the worst of these demands; None in records from before it was kept
    corners : the worst wrench of thrusters that all stand at a limit, the corners of the attainable set among
        them; None after a failure, where they are too many to go through, and in records from before
    """

    fault: int | None
    method: str
    n_demands: int
    within_1pct: int
    within_5pct: int
    sample: Loss | None = None
    corners: Loss | None = None


class Unserved(msgspec.Struct, kw_only=True):
    """A method whose answers could not be had, and why.

    Attributes
    ----------
    method : its name
    status, reason : as in ``Cell``
    """

    method: str
    status: str
    reason: str


class Curve(msgspec.Struct, kw_only=True):
    """Wrench error of a method over the size of the demand.

    Attributes
    ----------
    method : its name
    size : demand over the edge of the attainable set in its direction [-]
    error_p50, error_max : median and largest |delivered - tau| / |tau| of all directions at each size [-]
    """

    method: str
    size: list[float]
    error_p50: list[float]
    error_max: list[float]

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where a size lacks its errors."""
        if not len(self.size) == len(self.error_p50) == len(self.error_max):
            raise ValueError("size, error_p50 and error_max need as many numbers each")


class Plane(msgspec.Struct, kw_only=True):
    """A section of the attainable set, and what the closed form serves of it: two axes vary.

    Attributes
    ----------
    x, y : the two axes that vary
    held, held_at : a third axis, and the wrench at which it is held [N, N m]; all others are zero
    attainable, closed_form : corners of the two outlines [N, N m]; the closed form's has none where it
        serves nothing
    demands : (x, y, label) of a mission's demands, empty unless held_at is zero; what a demand asks of
        other axes is left out
    """

    x: str
    y: str
    held: str
    held_at: float
    attainable: list[tuple[float, float]]
    closed_form: list[tuple[float, float]]
    demands: list[tuple[float, float, str]]


class LastMetre(msgspec.Struct, kw_only=True):
    """Cost of one way from thrusts to the commands of ESCs.

    Attributes
    ----------
    way : in words
    share : sizes of demands, of what is attainable in their direction [-]
    error_p50, error_p95 : at each size, |made - tau| / |tau| over all directions [-]
    step_p50 : median of that error which the steps of the wire alone explain [-]
    missed : median of |made - tau| in a flight, each axis in units of the vehicle's ``wrench_scale`` [-];
        None where the vehicle can't fly it
    off_m : root mean square distance from where the vehicle should be [m]
    turns_hz : how often a thruster starts, stops or turns round, mean of all [1/s]
    """

    way: str
    share: list[float]
    error_p50: list[float]
    error_p95: list[float]
    step_p50: list[float]
    missed: float | None
    off_m: float | None
    turns_hz: float | None

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where a size lacks its errors."""
        lengths = {len(each) for each in (self.share, self.error_p50, self.error_p95, self.step_p50)}
        if len(lengths) != 1:
            raise ValueError("share, error_p50, error_p95 and step_p50 need as many numbers each")


class AxisCost(msgspec.Struct, kw_only=True):
    """Answers to a demand along one axis on a vehicle with weak directions, of which it asks nothing.

    Attributes
    ----------
    axis : its axis
    demand : half of the most that the strong part makes along it [N, N m]
    wrench : by method, what its thrusts make along the axis; None where it refuses
    thrust_N : by method, its largest thrust [N]
    hard_most : the most along the axis under eq. 4-5 [N, N m]
    hard_thrust_N : largest thrust at that; None where it is not known [N]
    """

    axis: str
    demand: float
    hard_most: float
    hard_thrust_N: float | None = None
    wrench: dict[str, float | None] = {}
    thrust_N: dict[str, float | None] = {}

    def words(self, method: str, unit: str) -> str:
        """One method's answer in words: ``29.1 N, thrusts up to 10.3 N``."""
        wrench, thrust = self.wrench.get(method), self.thrust_N.get(method)
        if wrench is not None and thrust is not None:
            return f"{wrench:.3g} {unit}, thrusts up to {thrust:.3g} N"
        most = f"refused; at most {self.hard_most:.3g} {unit}"
        return most if self.hard_thrust_N is None else f"{most}, thrusts up to {self.hard_thrust_N:.3g} N"


class Capability(msgspec.Struct, tag="capability", kw_only=True, omit_defaults=True):
    """Capability of one vehicle, whole and after each failure, and the share of it that each method serves.

    Attributes
    ----------
    vehicle, dof : which vehicle, and its axes
    names : of its thrusters, empty where they have none
    last_metre : what each way to its ESCs costs, empty for a vehicle without
    authority : of the whole vehicle, then with each working thruster off
    served, unserved : what each method serves, or why its answers could not be had
    wrong : by method, what is wrong with those answers
    curves : wrench error over the size of the demand
    planes : sections to draw
    weak_costs : what methods make along each axis; empty for a vehicle without weak directions
    failure_costs : of failures, announced and not; empty for a vehicle with one thruster
    fuse : what the cap costs; None for a vehicle without
    mixer : what the vehicle's own mixer delivers; None for a vehicle without
    """

    vehicle: str
    dof: list[str]
    authority: list[Authority]
    served: list[Served]
    unserved: list[Unserved] = []
    wrong: dict[str, str] = {}
    curves: list[Curve]
    planes: list[Plane]
    names: list[str] = []
    last_metre: list[LastMetre] = []
    weak_costs: list[AxisCost] = []
    failure_costs: list[FailureCost] = []
    fuse: FuseCost | None = None
    mixer: MixerCost | None = None

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where an axis lacks its ends."""
        ends = [end for a in self.authority for end in (a.axis_min, a.axis_max)]
        if any(len(end) != len(self.dof) for end in ends):
            raise ValueError(f"axis_min and axis_max need {len(self.dof)} numbers, one for each of dof")
