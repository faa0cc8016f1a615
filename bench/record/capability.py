"""What the record keeps about a vehicle's worth: what it can do, after a failure too, and who serves it.

Plain values; ``bench.judging.capability`` and ``bench.judging.reach`` measure them.
"""

import msgspec


class Authority(msgspec.Struct):
    """What a vehicle can do with one thruster off, or with none.

    fault: the thruster, None for the whole vehicle. rank: independent directions left. condition:
    largest over smallest singular value of T P in rows of unit length, None where rank is lost: 10
    is ordinary; 1000 says that some direction costs a thousand times the thrust of another.
    volume_share: volume of the attainable set, of the whole vehicle's; 0 where rank is lost.
    closed_form_share: of the volume attainable in this state, what f = T* tau serves inside the limits;
    None where that volume can't be worked out. safe_share: every demand up to this share of what is
    attainable in its direction is served so, whatever the direction. axis_min, axis_max: wrench along
    each axis alone, in the order of ``Worth.dof`` [N, N m]; None where no such wrench is attainable.
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


class Served(msgspec.Struct):
    """The share of the attainable set that a method serves: demands uniform in volume, as delivered.

    within_1pct, within_5pct: share of demands whose delivered wrench errs by at most that much, with
    its 95 % interval (Clopper-Pearson): [share, low, high].
    """

    fault: int | None
    method: str
    formulation: str
    n_demands: int
    within_1pct: tuple[float, float, float]
    within_5pct: tuple[float, float, float]


class Curve(msgspec.Struct):
    """Wrench error of a method over the size of the demand; size 1 is the edge of the attainable set.

    error_p50, error_max: |delivered - tau| / |tau| over the directions tried, one a size.
    """

    method: str
    formulation: str
    size: list[float]
    error_p50: list[float]
    error_max: list[float]


class Plane(msgspec.Struct):
    """A section of the attainable set, and what the closed form serves of it: two axes vary.

    x, y: the two axes. held: a third one, ``held_at`` [N, N m]; all others are zero. attainable,
    closed_form: outlines, the latter empty where nothing is served [N, N m]. demands: a mission's,
    where the third is zero; what they ask of other axes is left out: (x, y, label) [N, N m].
    """

    x: str
    y: str
    held: str
    held_at: float
    attainable: list[tuple[float, float]]
    closed_form: list[tuple[float, float]]
    demands: list[tuple[float, float, str]]


class Worth(msgspec.Struct, tag="worth"):
    """One vehicle: its authority with every thruster and without each, and what is made of it."""

    vehicle: str
    dof: list[str]
    authority: list[Authority]
    served: list[Served]
    curves: list[Curve]
    planes: list[Plane]
