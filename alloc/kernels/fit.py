"""Thrusts scaled by one factor until they fit their limits."""

from alloc.closed_forms.load import LEAST
from alloc.kernels.margins import margin_share, values
from alloc.kernels.rules import RuleAnswer
from alloc.program import Builder, Expression, Number, most, select


def fit_to_limits(builder: Builder, x: dict[int, Expression], name: str = "share_of_all") -> RuleAnswer:
    """Thrusts x times the largest factor in 0 … 1 that keeps each within its limit on x's side of zero."""
    known = [*builder.faults.values()] or [builder.vehicle]
    least = builder.graph.of_each(LEAST * state.f_scale for state in known)
    far = {i: builder.limits.far(i, least) for i in x}
    load = most(*(_load(x[i], *far[i]) for i in x), 1.0)
    share = (1.0 / load).named(name)
    builder.compute(share)
    within = all(far[i] == builder.limits.ends(i) for i in x)
    return RuleAnswer({i: share * x[i] for i in x}, share if within else None)


def _load(x: Expression, low: Number, high: Number) -> Expression:
    """x over the limit on its side of zero; both limits differ from zero."""
    if values(low) and values(high):
        return margin_share(x, high, -low)
    return x / select(x > 0.0, high, low)
