"""Cost of a cap on what all thrusters draw together: shares, currents and wrenches of ways to keep it."""

import msgspec


class FuseWay(msgspec.Struct, kw_only=True):
    """Cost of one way to keep below a cap.

    Attributes
    ----------
    way : in words
    share_p50, share_min : median and least share of a demand, over the largest that the cap allows [-]
    amps_p50, amps_max : median and largest current, over the least for the same wrench [-]
    axis_min, axis_max : (k,) wrench along each axis alone, in the order of ``Capability.dof`` [N, N m]
    """

    way: str
    share_p50: float
    share_min: float
    amps_p50: float
    amps_max: float
    axis_min: list[float]
    axis_max: list[float]


class FuseCost(msgspec.Struct, kw_only=True):
    """Cost of a cap by each way to keep it.

    Attributes
    ----------
    amps : what the cap leaves the thrusters [A]
    volts : voltage of the currents [V]; None where nothing says one
    most : current of all thrusters at their limits [A]
    n_demands : directions of demands that the shares are of
    ways : the largest share there is first
    """

    amps: float
    volts: float | None
    most: float
    n_demands: int
    ways: list[FuseWay]
