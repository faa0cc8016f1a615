"""Cost of a thruster's failure while the allocator believes the whole vehicle, and once it is told."""

import msgspec


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
