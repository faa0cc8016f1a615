"""Report section on failures that nobody announces: their cost by thruster and by method."""

from bench.record import Capability, FailureCost
from bench.report.pictures import picture
from bench.results.failures import by_failure, shown_method, thruster_names
from bench.results.rows import Run
from bench.results.text import merge_lines, percent, plain, rarity, table, three, wrench_text

UNANNOUNCED = """## What you lose until you know

One thruster at a time fails, and the allocator believes the whole vehicle: it is off, stuck at what it made
of the demand before, at half strength, or reversed. Each cell has the share of a demand that is delivered
along it and the angle by which the wrench is turned, medians, then the share of the worst demand. Demands are
drawn evenly from what the whole vehicle can do. *Announced*: the same failure once `scaled` is told of it; a
thruster that is stuck is then off, and its thrust is taken off the demand. What is delivered can become less
when a failure is announced, for then the direction is kept.
"""


def unannounced(run: Run, drawn: frozenset[str]) -> str:
    """A picture, a table by thruster, one by method and the worst demand, vehicle by vehicle."""
    parts = [part for capability in run.capabilities for part in _vehicle(capability, drawn)]
    return "\n".join([UNANNOUNCED, *parts]) if parts else ""


def _vehicle(capability: Capability, drawn: frozenset[str]) -> list[str]:
    method = shown_method(capability)
    if method is None:
        return []
    name = capability.vehicle
    alt = f"{name}: share of a demand that is delivered after a failure, until it is announced and then"
    return [
        f"### {plain(name)}, failures not announced\n",
        picture(f"unannounced-{name}.svg", alt, drawn),
        _by_thruster(capability, method),
        _worst(capability, method),
        _by_method(capability),
    ]


def _by_thruster(capability: Capability, method: str) -> str:
    costs, known = by_failure(capability, method), by_failure(capability, announced=True)
    headers = [f"failed ({method})"]
    columns = []
    for failure, cost in costs.items():
        headers += [failure, *([f"{failure}, announced"] if failure in known else [])]
        columns += [cost, *([known[failure]] if failure in known else [])]
    names = thruster_names(capability)
    return table(headers, [[name, *(_cell(cost, i) for cost in columns)] for i, name in enumerate(names)])


def _by_method(capability: Capability) -> str:
    """Table by method, each failure on the thruster that it costs most; equal methods share a line."""
    methods = dict.fromkeys(cost.method for cost in capability.failure_costs if not cost.announced)
    by_method = {method: by_failure(capability, method) for method in methods}
    headers = ["method, its costliest thruster", *next(iter(by_method.values()))]
    lines = (
        (method, [_cell(cost, cost.weakest) for cost in costs.values()])
        for method, costs in by_method.items()
    )
    return table(headers, merge_lines(lines))


def _cell(cost: FailureCost, i: int) -> str:
    turned = cost.turned_p50_deg[i]
    angle = "" if turned is None else f", {three(turned)}°"
    return f"{percent(cost.share_p50[i])}{angle}; {percent(cost.share_min[i])}"


def _worst(capability: Capability, method: str) -> str:
    """Sentence on the demand that the failures cost most."""
    costs = by_failure(capability, method).values()
    least, i, cost = min(
        ((share, i, cost) for cost in costs for i, share in enumerate(cost.share_min)),
        key=lambda each: each[0],
    )
    demand = wrench_text(capability.dof, cost.worst[i])
    turned = cost.turned_max_deg[i]
    angle = "" if turned is None else f"; some demand is turned by {three(turned)}°"
    return (
        f"Worst of {cost.n_demands:,} demands drawn evenly, with {plain(thruster_names(capability)[i])}"
        f" {cost.failure} and nobody told: `{method}` delivers {percent(least)} of {demand}{angle}."
        f" Of all such demands {rarity(cost.n_demands)} are worse.\n"
    )
