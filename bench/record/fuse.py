"""Cost of a cap on what all thrusters draw together, by ways to keep it, and the power that demands take."""

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


class Power(msgspec.Struct, kw_only=True):
    """Mean power of demands over time, by least effort and at least current for the same wrenches.

    Attributes
    ----------
    demands : name of the set, or of the log
    n : demands that the means are of
    seconds : time of all demands
    effort_W, least_W : by least effort, and at least current [W]
    """

    demands: str
    n: int
    seconds: float
    effort_W: float
    least_W: float

    @property
    def words(self) -> str:
        """Both energies, and the part of the first that the second saves."""
        effort, least = (watts * self.seconds / 3600.0 for watts in (self.effort_W, self.least_W))
        return (
            f"{effort:.3g} Wh by least effort, {least:.3g} Wh at least current:"
            f" {100 * (1 - self.least_W / self.effort_W):.2g} % less"
        )


class CapExcess(msgspec.Struct, kw_only=True):
    """Way to keep a cap that falls evenly over a mission, and how far it exceeds it.

    Attributes
    ----------
    way : in words
    over_A : largest current above the cap, 0 for none [A]
    over_share : share of the mission above it [-]
    share_p50, share_min : median and least share of a demand that is delivered along it [-]
    """

    way: str
    over_A: float
    over_share: float
    share_p50: float
    share_min: float


class FuseCost(msgspec.Struct, kw_only=True):
    """Cost of a cap by each way to keep it.

    Attributes
    ----------
    amps : what the cap leaves the thrusters [A]
    volts : voltage of the currents [V]; None where nothing says one
    most : current of all thrusters at their limits [A]
    n_demands : directions of demands that the shares are of
    ways : the largest share there is first
    powers : of the missions; empty where nothing says a voltage
    excesses, last_amps : a mission by each way while the cap falls, and what is left of it at the end [A]
    """

    amps: float
    volts: float | None
    most: float
    n_demands: int
    ways: list[FuseWay]
    powers: list[Power] = []
    excesses: list[CapExcess] = []
    last_amps: float = 0.0
