"""C99 of the closed forms: f = G tau with zero entries dropped, and Walsh's sums as butterflies."""

from alloc.closed_forms.inverse import generalized_inverse
from alloc.closed_forms.walsh import walsh_inverse
from alloc.native.bounds import Bounds
from alloc.native.code import Table, Terms, butterflies, placed, product, reached, signed_sum
from alloc.native.entry import read
from alloc.nullspace.structure import decompose
from alloc.vehicle import Vehicle


def pinv(vehicle: Vehicle, _: Bounds, c: Table) -> list[str]:
    """Statements of f = T* tau (eq. 8-10)."""
    lines, rows, _ = product(generalized_inverse(vehicle), "t", c)
    sums, rows = butterflies(rows, c)
    return _finish(vehicle, [*lines, *sums], rows, c)


def walsh(vehicle: Vehicle, _: Bounds, c: Table) -> list[str]:
    """Statements of f = 1/m W [0; Q^-1 tau] (eq. 25) or, with a thruster off, eq. 27; raises NotApplicable.

    They take one multiplication an axis, then additions that rows share: the fast Walsh transform.
    """
    lines, rows, _ = product(walsh_inverse(vehicle), "t", c)
    sums, rows = butterflies(rows, c)
    return _finish(vehicle, [*lines, *sums], rows, c)


def _finish(vehicle: Vehicle, products: list[str], rows: list[Terms], c: Table) -> list[str]:
    lines = [f"f[{i}] = {signed_sum(row, c.scalar)};" for i, row in enumerate(rows)]
    more, conditions = reached(decompose(vehicle).unreachable, c)
    status = f"({' & '.join(conditions)}) ? SOLVED : PARTIAL" if conditions else "SOLVED"
    # All of tau is read before f is written: they may be the same array.
    return [*placed(read(vehicle, c), [*products, *more, *lines]), f"return {status};"]
