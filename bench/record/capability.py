"""Record lines on what a vehicle can do, and what each method serves of it."""

import msgspec

from bench.record.costs import AxisCost, FailureCost, FuseCost, LastMetre, MixerCost

SERVED_WITHIN = 0.01
"""Relative error of a delivered wrench up to which a demand counts as served, on all pages [-]."""
MISSED_MUCH = 0.25
"""Share of an attainable wrench [-]; a method that misses more of most demands counts as one that refuses
all. Closed forms miss less, even of demands drawn beyond what they serve."""


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
    missed_much : demands of which MISSED_MUCH or more is missed; None in records from before it was kept
    nothing_expected : demands of as many others of which nothing is delivered, by a tail; None like it
    """

    n_demands: int
    n_answers: int
    missed_max: float
    turned_max_deg: float | None
    missed_much: int | None = None
    nothing_expected: float | None = None


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
    missed : a bit for each of these demands that is not delivered within 1 %, to compare methods demand by
        demand; empty after a failure, and in records from before
    """

    fault: int | None
    method: str
    n_demands: int
    within_1pct: int
    within_5pct: int
    sample: Loss | None = None
    corners: Loss | None = None
    missed: bytes = b""


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
