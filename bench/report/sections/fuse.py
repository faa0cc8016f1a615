"""Report section on a cap of current: the cost of each way to keep it, over all directions and by axis."""

from alloc.vehicle.geometry import unit
from bench.record import Capability, FuseCost, FuseWay
from bench.results.rows import Run
from bench.results.text import percent, plain, rarity, table, three

FUSE = """## What the fuse costs

The vehicle's file has a cap on what all thrusters draw together. *Share* is how much of a demand a way
delivers below the cap, over the largest share there is, median and worst. The demands are drawn evenly from
what the whole vehicle can do. *Current* is what a way draws, over the least for the same wrench. The second
table has the most along each axis alone. By the model: the currents are those of the file, made convex.
"""


def fuse(run: Run, drawn: frozenset[str]) -> str:
    """A table of shares and currents and one by axis, for each vehicle with a cap."""
    parts = [
        part
        for capability in run.capabilities
        if capability.fuse
        for part in _vehicle(capability, capability.fuse)
    ]
    return "\n".join([FUSE, *parts]) if parts else ""


def _vehicle(capability: Capability, cost: FuseCost) -> list[str]:
    at = "" if cost.volts is None else f" at {cost.volts:g} V"
    headers = ["way", *(f"{axis} [{unit(axis)}]" for axis in capability.dof)]
    return [
        f"### {plain(capability.vehicle)}, {three(cost.amps)} A of {three(cost.most)} A{at}\n",
        table(
            ("way", "share", "worst share", "current", "most current"),
            [
                [way.way, *map(percent, (way.share_p50, way.share_min, way.amps_p50, way.amps_max))]
                for way in cost.ways
            ],
        ),
        f"Worst of {cost.n_demands:,} drawn; {rarity(cost.n_demands)} of all such demands are worse.\n",
        table(headers, [[way.way, *_ends(way)] for way in cost.ways]),
        *_mission(cost),
        *(
            f"Energy of {power.demands}, {three(power.seconds)} s,"
            f" by {power.n} of its demands: {power.words}.\n"
            for power in cost.powers
        ),
    ]


def _mission(cost: FuseCost) -> list[str]:
    """A table of a mission while the cap falls; empty where it was not flown."""
    if not cost.excesses:
        return []
    headers = ("mission", "above the cap, at most [A]", "of the time", "delivered", "least")
    lines = [
        [
            excess.way,
            three(excess.over_A),
            *map(percent, (excess.over_share, excess.share_p50, excess.share_min)),
        ]
        for excess in cost.excesses
    ]
    return [
        f"Half a minute under way, while the cap falls from {three(cost.amps)} to"
        f" {three(cost.last_amps)} A. *Delivered* is the share of a demand along it, median and least.\n",
        table(headers, lines),
    ]


def _ends(way: FuseWay) -> list[str]:
    """The most along each axis: its two ends, or one number where they are equal."""
    ends = zip(map(three, way.axis_min), map(three, way.axis_max), strict=True)
    return [f"± {most}" if least == f"-{most}" else f"{least} … {most}" for least, most in ends]
