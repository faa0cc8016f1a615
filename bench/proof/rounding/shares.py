"""Shares in a program: k / max(k, loads), how much of a step can be taken before a slack is used up.

Each load is the size of what is taken, over a slack. That a share times what is taken is at most k times the
slack says more than ranges of single numbers do: what a step leaves of a slack is never negative.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from alloc.program import Node, Operation
from bench.proof.rounding.arithmetic import Value, among
from bench.proof.rounding.products import NOTHING, Form, constant, total
from bench.proof.rounding.sensitivity import Gauge
from bench.proof.source import NotRead


class Load(NamedTuple):
    """Part of a slack that is used up.

    Attributes
    ----------
    along : what is taken
    ahead, astern : the slack where that is positive, and the slack for its opposite; None for a slack of 1
    both : whether the opposite is taken at all
    tiny : what is no larger than this counts as zero; None where all counts
    """

    along: Node
    ahead: Node | None
    astern: Node | None
    both: bool
    tiny: Node | None


class Share(NamedTuple):
    """One share.

    Attributes
    ----------
    keep : the node of k above the line
    least : that of k below it
    loads : the others below it
    inner : nodes between these and the share
    """

    keep: Node
    least: Node
    loads: list[Load]
    inner: set[Node]


def shares(nodes: Sequence[Operation]) -> dict[Node, Share]:
    """All shares of a program, by node."""
    found = {}
    for node, operation in enumerate(nodes):
        if operation[0] == "div" and (share := _share(nodes, operation[1], operation[2])):
            found[node] = share
    return found


def _share(nodes: Sequence[Operation], keep: Node, below: Node) -> Share | None:
    if nodes[keep][0] != "const" or not nodes[keep][1] > 0.0:
        return None
    leaves, within, waiting = list[Node](), set[Node](), [below]
    while waiting:
        node = waiting.pop()
        if nodes[node][0] == "max":
            within.add(node)
            waiting += nodes[node][1:]
        else:
            leaves.append(node)
    same = [node for node in leaves if nodes[node] == nodes[keep]]
    if not within or not same:
        return None
    loads = []
    for leaf in leaves:
        if leaf not in same:
            load, inner = _load(nodes, leaf)
            loads.append(load)
            within |= inner
    return Share(keep, same[0], loads, within)


def _load(nodes: Sequence[Operation], leaf: Node) -> tuple[Load, set[Node]]:
    match nodes[leaf]:
        case ("abs", along):
            return Load(along, None, None, True, None), {leaf}
        case ("div", over, below):
            match nodes[below]:
                case ("choose", asked, ahead, astern) if (taken := _size(nodes, over)) is not None:
                    along, tiny, inner = taken
                    if nodes[asked][0] == "gt" and nodes[asked][1] == along and _zero(nodes, nodes[asked][2]):
                        return Load(along, ahead, astern, True, tiny), {leaf, over, below, *inner}
    return Load(leaf, None, None, False, None), set()


def _size(nodes: Sequence[Operation], node: Node) -> tuple[Node, Node | None, set[Node]] | None:
    """The number whose size a node is, and what is tiny of it; None where it is no such thing."""
    match nodes[node]:
        case ("abs", along):
            return along, None, set()
        case ("max", size, tiny) if nodes[size][0] == "abs" and _zero(nodes, tiny):
            # Nothing but zero is tiny.
            return nodes[size][1], tiny, {size}
        case ("choose", asked, size, other) if nodes[size][0] == "abs" and _zero(nodes, other):
            match nodes[asked]:
                case ("gt", compared, tiny) if nodes[compared] == nodes[size]:
                    return nodes[size][1], tiny, {size, compared}
    return None


def _zero(nodes: Sequence[Operation], node: Node) -> bool:
    return nodes[node] == ("const", 0.0)


def gauges(share: Share, number: Callable[[Node], Value]) -> tuple[list[Gauge], float]:
    """The gauges of a share, and how many relative roundings any of its loads has at most.

    ``number`` gives a node's value. Raises NotRead where a load or a slack is no sum.
    """
    found, roundings = [], 1.0
    for load in share.loads:
        taken, extra = _before_rounding(number(load.along))
        tiny = 0.0 if load.tiny is None else number(load.tiny).size
        for sign, slack in ((1.0, load.ahead), (-1.0, load.astern))[: 1 + load.both]:
            if slack is None:
                found.append(Gauge(total((sign, taken)), constant(1.0), 0.0))
                roundings = max(roundings, 1.0 + extra)
                continue
            for each in _alternatives(number(slack)):
                left, more = _before_rounding(each)
                found.append(Gauge(total((sign, taken)), left, tiny))
                roundings = max(roundings, 2.0 + extra + more)
    return found, roundings


def _before_rounding(value: Value) -> tuple[Form, float]:
    """A value's form before its own rounding, and how many relative roundings that is."""
    if value.form is None:
        raise NotRead("a share of what is no sum")
    form = dict(value.form)
    return (form, 0.0) if form.pop((NOTHING, value.own), None) is None else (form, 1.0)


def _alternatives(value: Value) -> tuple[Value, ...]:
    """Values with a form, the least of which this is; raises NotRead where they are not known."""
    found = among(value)
    if not found or not value.least:
        raise NotRead("a slack that is no sum")
    return found
