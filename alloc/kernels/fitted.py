"""Thrusts scaled by one factor until they fit their limits."""

from alloc.kernels.margins import taken
from alloc.program import Builder, Expression, Number, most, select

LEAST = 1e-5
"""A limit nearer to zero than this share of the largest one counts as that far away. Rounding asks a thruster
that can't reverse (f_min = 0) for -1e-15 N, or in single precision for -1e-6 N, which must not stop all the
others; and the nearer, the more of the others' thrusts a rounding error decides."""


def fitted(builder: Builder, x: dict[int, Expression], name: str = "share_of_all") -> dict[int, Expression]:
    """Thrusts x times the largest factor in 0 … 1 that brings each to its limit on x's side of zero."""
    least = LEAST * builder.vehicle.f_scale
    load = most(*(_load(x[i], *builder.limits.far(i, least)) for i in x), 1.0)
    share = (1.0 / load).named(name)
    builder.compute(share)
    return {i: share * x[i] for i in x}


def _load(x: Expression, low: Number, high: Number) -> Expression:
    """x over the limit on its side of zero, of which neither is zero."""
    if isinstance(low, float) and isinstance(high, float):
        return taken(x, high, -low)
    return x / select(x > 0.0, high, low)
