"""Record lines on what costs a vehicle: its ESCs, weak axes, failures, a cap, and its own mixer."""

import msgspec


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


class FailureCost(msgspec.Struct, kw_only=True):
    """Cost of one kind of failure on each working thruster in turn, with one method.

    Lists have an entry for each of ``thrusters``. Wrenches count in the vehicle's ``wrench_scale``.

    Attributes
    ----------
    failure : off, stuck, half or reversed
    method : its name
    announced : True if the allocator is told of the failure
    n_demands : answers that the numbers are of
    thrusters : indices of the working thrusters
    share_p50, share_min : median and least share of a demand that is delivered along it [-]
    turned_p50_deg, turned_max_deg : angle between delivered and demanded wrench [deg]; None where nothing
        is delivered
    worst : (k,) the demand of each ``share_min`` [N, N m]
    """

    failure: str
    method: str
    announced: bool = False
    n_demands: int
    thrusters: list[int]
    share_p50: list[float]
    share_min: list[float]
    turned_p50_deg: list[float | None]
    turned_max_deg: list[float | None]
    worst: list[list[float]]

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where a thruster lacks its numbers."""
        columns = (self.share_p50, self.share_min, self.turned_p50_deg, self.turned_max_deg, self.worst)
        if {len(self.thrusters)} != {len(each) for each in columns}:
            raise ValueError("thrusters, share_*, turned_* and worst need as many entries each")

    @property
    def weakest(self) -> int:
        """Place in the lists of the thruster whose failure leaves the least median share."""
        return min(range(len(self.thrusters)), key=lambda i: self.share_p50[i])


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


class Move(msgspec.Struct, kw_only=True):
    """A simulated move along one axis, the worse of both ways, with the mixer and the exact answer in turn.

    Attributes
    ----------
    axis : that of the move
    off_m : (2,) largest distance from the straight line [m]
    turned_deg : (2,) largest angle of roll, pitch or yaw, up to 180 [deg]
    """

    axis: str
    off_m: tuple[float, float]
    turned_deg: tuple[float, float]


class MixerCost(msgspec.Struct, kw_only=True):
    """Part of the demands that thrusters can meet which a vehicle's autopilot delivers.

    Attributes
    ----------
    method, frame : the mixer, and its frame
    exact : the method that is asked the same
    n_demands : demands drawn evenly from what the vehicle can do
    served, exact_served : those that each delivers within 1 %
    missed_p50 : share of a demand's wrench that the mixer does not deliver, median [-]
    demands, wrenches : (m, k) the demands that cost the mixer most, the costliest first, and what it makes of
        them [N, N m]
    missed : (m,) share of each demand's wrench that is not delivered [-]
    moves : moves of ``move_m`` metres; empty in older records
    own_inertia : whether the moved body has the vehicle's inertia, else a BlueROV2 Heavy's
    """

    method: str
    frame: str
    exact: str
    n_demands: int
    served: int
    exact_served: int
    missed_p50: float
    demands: list[list[float]]
    wrenches: list[list[float]]
    missed: list[float]
    moves: list[Move] = []
    move_m: float = 3.0
    own_inertia: bool = False

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where a demand lacks its wrench."""
        if not len(self.demands) == len(self.wrenches) == len(self.missed):
            raise ValueError("demands, wrenches and missed need as many entries each")
        if self.n_demands < 1 or not all(map(len, self.demands)):
            raise ValueError("n_demands and each of demands must not be empty")
