"""The line of a record that says what a vehicle can do, after a failure too, and which methods serve it."""

import msgspec


class Authority(msgspec.Struct, kw_only=True):
    """What a vehicle can do with one thruster off, or with none.

    Attributes
    ----------
    fault : the thruster, None for the whole vehicle
    vehicle : its name then
    rank : independent directions left
    condition : largest over smallest singular value of T P in rows of unit length, None where rank is
        lost: 10 is ordinary; 1000 says that some direction costs a thousand times the thrust of another
    volume_share : volume of the attainable set, of the whole vehicle's; 0 where rank is lost
    closed_form_share : of the volume attainable in this state, what f = T* tau serves inside the limits;
        None where that volume can't be worked out
    safe_share : every demand up to this share of what is attainable in its direction is served so,
        whatever the direction
    axis_min, axis_max : wrench along each axis alone, in the order of ``Capability.dof`` [N, N m]; None
        where no such wrench is attainable
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
    """How much of the attainable set a method serves: demands uniform in volume, as delivered.

    Attributes
    ----------
    fault : the thruster that is off, None for the whole vehicle
    method : its name
    n_demands : how many were asked
    within_1pct, within_5pct : how many of them are delivered with an error of at most that much
    """

    fault: int | None
    method: str
    n_demands: int
    within_1pct: int
    within_5pct: int


class Unserved(msgspec.Struct, kw_only=True):
    """A method whose share could not be counted.

    Attributes
    ----------
    method : its name
    status, reason : as a cell's
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
    error_p50, error_max : |delivered - tau| / |tau| over the directions tried, one a size
    """

    method: str
    size: list[float]
    error_p50: list[float]
    error_max: list[float]


class Plane(msgspec.Struct, kw_only=True):
    """A section of the attainable set, and what the closed form serves of it: two axes vary.

    Attributes
    ----------
    x, y : the two axes
    held, held_at : a third one, and where it is held [N, N m]; all others are zero
    attainable, closed_form : outlines, the latter empty where nothing is served [N, N m]
    demands : a mission's (x, y, label), where the third is zero; what they ask of other axes is left out
    """

    x: str
    y: str
    held: str
    held_at: float
    attainable: list[tuple[float, float]]
    closed_form: list[tuple[float, float]]
    demands: list[tuple[float, float, str]]


class Capability(msgspec.Struct, tag="capability", kw_only=True, omit_defaults=True):
    """One vehicle: its authority with every thruster and without each, and what methods make of it.

    Attributes
    ----------
    vehicle, dof : which vehicle, and its axes
    authority : whole, then with each working thruster off
    served, unserved : what each method serves, or why that could not be counted
    curves : wrench error over the size of the demand
    planes : sections to draw
    """

    vehicle: str
    dof: list[str]
    authority: list[Authority]
    served: list[Served]
    unserved: list[Unserved] = []
    curves: list[Curve]
    planes: list[Plane]
