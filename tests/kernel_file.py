"""A method of somebody's own that can be C, as a file in the folder of methods."""

METHOD = '''\
"""T* tau, scaled down twice as far as its worst thrust asks for, then cut at the limits."""

from alloc.closed_forms.saturating import Saturating
from alloc.kernels import rules
from alloc.program import most, select

FORMULATION = "meek"
MEANINGS = rules.MEANINGS
LEAST = 1e-3


def build(vehicle):
    least = LEAST * vehicle.f_scale

    def meek(tau, f, limits):
        ends = [max(high, least) if x > 0 else min(low, -least) for x, (low, high) in zip(f, limits.pairs)]
        load = max(1.0, *(x / end for x, end in zip(f, ends)))
        return [x / load / load for x in f], 1

    return Saturating(vehicle, FORMULATION, meek)


def program(vehicle, limits, scalar):
    return rules.apply_rule(meek, vehicle, limits, scalar)


def meek(builder, x):
    ends = {i: builder.limits.far(i, LEAST * builder.vehicle.f_scale) for i in x}
    load = most(*(x[i] / select(x[i] > 0.0, high, low) for i, (low, high) in ends.items()), 1.0)
    return rules.RuleAnswer({i: x[i] / load / load for i in x})
'''
