"""Least weighted sum of missed wrench, at least effort, inside the limits: an exact penalty of the 1-norm.

A price above every multiplier of T f = tau buys no miss that thrusts can avoid, so what can be met is met at
least effort, as in the hard problem. Beyond reach few axes miss much: the 1-norm leaves out, and so turns.
"""

from alloc.formulations import Family, Formulation

FORMULATION = Formulation(
    name="elastic",
    title="the least sum of misses",
    meaning="misses as little as it can, summed over the axes",
    family=Family.SOFT,
    limited=True,
)
