"""C99 of the closed forms: f = G tau with zero entries dropped, and Walsh's sums as butterflies."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.linear import exactly, usual
from alloc.closed_forms.walsh import walsh_inverse
from alloc.native.bounds import CLimits
from alloc.native.code import Table, butterflies, placed, product, reached, signed_sum
from alloc.native.entry import read
from alloc.nullspace.structure import decompose
from alloc.vehicle import Vehicle

FAR = 1e3
"""Demands up to so many times what the limits allow are usual, or their thrusts are looked at [-]."""


def pinv(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements of f = T* tau (eq. 8-10); limits are not looked at."""
    return _product(vehicle, generalized_inverse(vehicle), c)


def walsh(vehicle: Vehicle, bounds: CLimits, c: Table) -> list[str]:
    """Statements of f = 1/m W [0; Q^-1 tau] (eq. 25) or, with a thruster off, eq. 27; raises NotApplicable.

    They take one multiplication an axis, then additions that rows share: the fast Walsh transform. Limits are
    not looked at.
    """
    return _product(vehicle, walsh_inverse(vehicle), c)


def _product(vehicle: Vehicle, G: FloatArray, c: Table) -> list[str]:
    products, rows, _ = product(G, "t", c)
    sums, rows = butterflies(rows, c)
    lines = [f"f[{i}] = {signed_sum(row, c.scalar)};" for i, row in enumerate(rows)]
    more, conditions = reached(decompose(vehicle).unreachable, c)
    if c.scalar == "double":  # float promises no wrench to 1e-6
        most = usual(vehicle, G)
        if most > FAR * float(np.linalg.norm(vehicle.wrench_scale)):
            squares, largest = [f"t{r} * t{r}" for r in range(vehicle.k)], most
        else:  # a weak direction makes that too little: what counts is the thrusts, as in Python
            squares, largest = [f"f[{i}] * f[{i}]" for i in vehicle.working.tolist()], exactly(vehicle)
        conditions.append(f"({' + '.join(squares)} <= {c(largest**2)})")
    status = f"({' & '.join(conditions)}) ? SOLVED : PARTIAL" if conditions else "SOLVED"
    # All of tau is read before f is written: they may be the same array.
    return [*placed(read(vehicle, c), [*products, *sums, *more, *lines]), f"return {status};"]
