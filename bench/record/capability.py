"""Record line on a vehicle's capability, whole and after failures, and on the share served."""

import msgspec

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


class Served(msgspec.Struct, kw_only=True):
    """How much of the attainable set a method serves, counted on demands that are uniform in volume.

    Attributes
    ----------
    fault : the thruster that is off, None for the whole vehicle
    method : its name
    n_demands : demands asked
    within_1pct, within_5pct : demands delivered with a relative wrench error of at most that much
    """

    fault: int | None
    method: str
    n_demands: int
    within_1pct: int
    within_5pct: int


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

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where an axis lacks its ends."""
        ends = [end for a in self.authority for end in (a.axis_min, a.axis_max)]
        if any(len(end) != len(self.dof) for end in ends):
            raise ValueError(f"axis_min and axis_max need {len(self.dof)} numbers, one for each of dof")
