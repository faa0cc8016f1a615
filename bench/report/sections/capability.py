"""Report sections on vehicles: what each can do, who serves it, and what its ESCs lose."""

from alloc.vehicle.geometry import unit
from bench.record import Authority, Capability, LastMetre, Served
from bench.report.pictures import picture
from bench.report.verdict import flat_sets, name_of_state
from bench.results.quantiles import share
from bench.results.ranking import uncounted_methods
from bench.results.rows import Run
from bench.results.text import merge_lines, percent, plain, table, three

NEARLY_SINGULAR = 100.0
"""Condition above which a warning is given: some wrench costs a hundred times the thrust of another, so full
rank no longer means that the vehicle can be controlled. Ordinary layouts stay below 10."""

CAPABILITY = """## What each vehicle can do, and who serves it

*Volume left* is the exact volume of what the thrusters can push inside their limits, over the whole
vehicle's. *Closed form* is the exact share of it for which f = T* τ breaks no limit. *Safe up to* says how
small a demand must be, of what can be done in its direction, for that to hold in every direction. *Served*
counts demands drawn evenly from the volume whose delivered wrench errs by at most 1 % or 5 %, with the 95 %
interval. In the pictures a demand stands where two of its axes put it. What it asks of the others is left
out, so it may be infeasible though it lies inside.
"""


def capability(run: Run, drawn: frozenset[str]) -> str:
    """Authority after each failure, shares served, and the two pictures, vehicle by vehicle."""
    parts = [part for capability in run.capabilities for part in _vehicle(capability, drawn)]
    return "\n".join([CAPABILITY, *parts]) if parts else ""


def _vehicle(capability: Capability, drawn: frozenset[str]) -> list[str]:
    name = capability.vehicle
    return [
        f"### {plain(name)}\n",
        _authority(capability),
        *_warnings(capability),
        *_flat(capability),
        _served(capability),
        *(f"{plain(line)}.\n" for line in uncounted_methods(capability)),
        picture(
            f"reach-{name}.svg", f"Attainable set of {name} and where the closed form keeps the limits", drawn
        ),
        picture(f"error-{name}.svg", f"Wrench error over the size of the demand, {name}", drawn),
    ]


def _authority(capability: Capability) -> str:
    """Table of authority; failures that leave the same share a line."""
    lines = ((name_of_state(capability, a.fault), _state(a)) for a in capability.authority)
    units = [f"{axis} [{unit(axis)}]" for axis in capability.dof]
    headers = ("off", "rank", "volume left", "closed form", "safe up to", "condition", *units)
    return table(headers, merge_lines(lines))


def _state(a: Authority) -> tuple[str, ...]:
    ends = zip(a.axis_min, a.axis_max, strict=True)
    return (
        str(a.rank),
        percent(a.volume_share),
        percent(a.closed_form_share),
        percent(a.safe_share),
        three(a.condition),
        *("-" if low is None or high is None else f"{three(low)} … {three(high)}" for low, high in ends),
    )


def _warnings(capability: Capability) -> list[str]:
    rank = max((a.rank for a in capability.authority), default=0)  # the whole vehicle's
    lost = [name_of_state(capability, a.fault) for a in capability.authority if a.rank < rank]
    weak = [
        name_of_state(capability, a.fault)
        for a in capability.authority
        if (a.condition or 0.0) > NEARLY_SINGULAR
    ]
    warnings = []
    if lost:
        names = plain(" or ".join(lost))
        warnings.append(f"**Lost rank**: without thruster {names} some direction can't be pushed at all.\n")
    if weak:
        names = plain(" or ".join(weak))
        warnings.append(
            f"**Nearly singular** with thruster {names} off: full rank on paper, hardly any thrust in it.\n"
        )
    return warnings


def _flat(capability: Capability) -> list[str]:
    """A sentence for each rank below the number of axes: of what closed form and served are shares."""
    return [
        f"*Closed form*, *safe* and *served* {plain(when)}".rstrip()
        + f" are shares of {what}: no more can be pushed.\n"
        for what, when in flat_sets(capability)
    ]


def _served(capability: Capability) -> str:
    """Table of shares served, most first; methods with equal shares share a line."""
    by_method: dict[str, dict[int | None, Served]] = {}
    for served in capability.served:
        by_method.setdefault(served.method, {})[served.fault] = served
    states = list(dict.fromkeys(served.fault for served in capability.served))
    lines = (
        (method, [cell for fault in states for cell in _shares(by_fault.get(fault))])
        for method, by_fault in sorted(by_method.items(), key=_most_first)
    )
    headers = ["method"]
    for fault in states:
        where = "all thrusters" if fault is None else f"{name_of_state(capability, fault)} off"
        headers += [f"served within 1 %, {where}", f"within 5 %, {where}"]
    return table(headers, merge_lines(lines))


def _most_first(item: tuple[str, dict[int | None, Served]]) -> tuple[int, str]:
    method, by_fault = item
    return -next(iter(by_fault.values())).within_1pct, method


def _shares(served: Served | None) -> tuple[str, str]:
    if served is None:
        return "", ""
    return _share(served.within_1pct, served.n_demands), _share(served.within_5pct, served.n_demands)


def _share(hits: int, n: int) -> str:
    middle, low, high = share(hits, n)
    return f"{percent(middle)} ({three(100 * low)} … {three(100 * high)})"


LAST_METRE = """## What the last metre costs

No ESC takes newtons. Each line is a way from thrusts to commands; thrusters make what the vehicle's curve
says. *Missed* is the share of a small demand (so much of what is attainable in its direction) that they do
not make, median and 95 %. *By steps alone* is what the wire's resolution explains of the median: better takes
finer steps. In flight the vehicle keeps station in a current: what is missed, how far off it is, and how
often a thruster starts, stops or turns round. Each axis is taken over the length of its row of T times the
largest limit. The linear map knows no curve: neutral is 0 N, the ends are the limits.
"""


def last_metre(run: Run, drawn: frozenset[str]) -> str:
    """A table and a picture for each vehicle with ESCs."""
    parts = []
    for capability in run.record.capabilities:
        if capability.last_metre:
            name = capability.vehicle
            alt = f"{name}: share of small demands that is missed, by the way from thrusts to commands"
            parts += [
                f"### {plain(name)}\n",
                picture(f"last-metre-{name}.svg", alt, drawn),
                _ways(capability.last_metre),
            ]
    return "\n".join([LAST_METRE, *parts]) if parts else ""


def _ways(ways: list[LastMetre]) -> str:
    headers = [
        "way",
        *(f"{percent(share)}: missed, 95 %" for share in ways[0].share),
        "in flight: missed",
        "off [m]",
        "starts and turns [1/s]",
    ]
    rows = [
        [
            each.way,
            *(
                f"{percent(p50)}, {percent(p95)}"
                for p50, p95 in zip(each.error_p50, each.error_p95, strict=True)
            ),
            percent(each.missed),
            three(each.off_m),
            three(each.turns_hz),
        ]
        for each in ways
    ]
    steps = ["by steps alone", *(percent(step) for step in ways[-1].step_p50), "", "", ""]
    return table(headers, [*rows, steps])
