"""The loads that hold a share below 1, each as a quotient: the form of the load over that of its slack."""

from collections.abc import Callable

from alloc.program import Node
from bench.proof.not_read import NotRead
from bench.proof.rounding.arithmetic import Value, among
from bench.proof.rounding.forms import NOTHING, Form, constant, total
from bench.proof.rounding.loads import Share
from bench.proof.rounding.moved import Gauge


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
