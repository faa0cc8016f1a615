"""Regions in which a condition holds, as ranges of the numbers that it compares."""

from collections.abc import Mapping, Sequence
from math import inf

from alloc.program import Node, Operation

Region = dict[Node, tuple[float, float]]
"""Ranges of some numbers; of all others nothing is said."""
OPPOSITE = {"lt": "ge", "le": "gt", "gt": "le", "ge": "lt", "eq": "ne", "ne": "eq"}


def regions(
    nodes: Sequence[Operation], ranges: Mapping[Node, tuple[float, float]], condition: Node, holds: bool
) -> list[Region]:
    """Regions that together hold all numbers for which a condition holds, or does not."""
    match nodes[condition]:
        case ("const", value):
            return [{}] if bool(value) == holds else []
        case ("not", inner):
            return regions(nodes, ranges, inner, not holds)
        case ("and" | "or" as operation, a, b):
            if (operation == "and") == holds:
                return _both(regions(nodes, ranges, a, holds), regions(nodes, ranges, b, holds))
            return regions(nodes, ranges, a, holds) + regions(nodes, ranges, b, holds)
        case ("choose", asked, then, other):
            first = _both(regions(nodes, ranges, asked, True), regions(nodes, ranges, then, holds))
            return first + _both(regions(nodes, ranges, asked, False), regions(nodes, ranges, other, holds))
        case (operation, a, b) if operation in OPPOSITE:
            return _compared(ranges, operation if holds else OPPOSITE[operation], a, b)
    return [{}]


def compared(nodes: Sequence[Operation], condition: Node) -> set[tuple[Node, Node]]:
    """The pairs of numbers that a condition compares."""
    match nodes[condition]:
        case (operation, a, b) if operation in OPPOSITE:
            return {(a, b)}
        case ("not" | "and" | "or" | "choose", *inner):
            return set().union(*(compared(nodes, each) for each in inner))
    return set()


def both(a: Region, b: Region) -> Region | None:
    """Intersection of two regions; None where it is empty."""
    found = dict(a)
    for node, (low, high) in b.items():
        before = found.get(node, (-inf, inf))
        found[node] = (max(low, before[0]), min(high, before[1]))
        if found[node][0] > found[node][1]:
            return None
    return found


def _both(some: list[Region], others: list[Region]) -> list[Region]:
    found = [both(a, b) for a in some for b in others]
    return [each for each in found if each is not None]


def _compared(ranges: Mapping[Node, tuple[float, float]], operation: str, a: Node, b: Node) -> list[Region]:
    region: Region = {}
    if operation in ("lt", "le", "eq"):
        region[a] = (-inf, ranges[b][1]) if b in ranges else (-inf, inf)
        region[b] = (ranges[a][0], inf) if a in ranges else (-inf, inf)
    if operation in ("gt", "ge", "eq"):
        above = both(region, {a: (ranges[b][0], inf) if b in ranges else (-inf, inf)})
        above = above and both(above, {b: (-inf, ranges[a][1]) if a in ranges else (-inf, inf)})
        return [] if above is None else [above]
    return [region]
