"""The record of a vehicle's own mixer beside the exact answer."""

import msgspec


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

    def __post_init__(self) -> None:
        """Raise ValueError, which the reader names with its line, where a demand lacks its wrench."""
        if not len(self.demands) == len(self.wrenches) == len(self.missed):
            raise ValueError("demands, wrenches and missed need as many entries each")
        if self.n_demands < 1 or not all(map(len, self.demands)):
            raise ValueError("n_demands and each of demands must not be empty")
