"""Closed forms as C that one writes by hand in a few minutes: what generated C is compared with.

They do not look whether their arguments are finite, nor say whether the demand is met.
"""

from collections.abc import Callable

import numpy as np

from alloc import Vehicle, build
from alloc.program.literal import number
from bench.chips.kernels import Kernel


def plain_product(vehicle: Vehicle) -> Kernel:
    """f = T* tau written out: one multiplication for each entry that is not zero."""
    return _kernel(vehicle, "plain_product", "pinv", lambda i, product: f"    f[{i}] = {product};\n")


def clip(vehicle: Vehicle) -> Kernel:
    """f = T* tau, each thrust cut at its limits by two compares."""
    ends = [
        [number(end, "double") for end in pair] for pair in zip(vehicle.f_min, vehicle.f_max, strict=True)
    ]

    def thrust(i: int, product: str) -> str:
        low, high = ends[i]
        return (
            f"    const double x{i} = {product};\n"
            f"    f[{i}] = x{i} < {low} ? {low} : x{i} > {high} ? {high} : x{i};\n"
        )

    return _kernel(vehicle, "clip_by_hand", "clip", thrust)


def _kernel(vehicle: Vehicle, name: str, twin: str, thrust: Callable[[int, str], str]) -> Kernel:
    """The kernel whose lines ``thrust`` makes of each thruster's index and its row of T* times tau."""
    G = build("pinv", vehicle).many(np.eye(vehicle.k))[0].T
    keep = np.abs(G) > 1e-14 * np.abs(G).max()  # smaller entries are rounding
    lines = ""
    for i in range(vehicle.n):
        terms = (f"{number(G[i, j], 'double')} * tau[{j}]" for j in np.flatnonzero(keep[i]))
        lines += thrust(i, " + ".join(terms) or "0.0")
    declaration = f"int {name}(const double *tau, double *f)"
    return Kernel(
        method=name,
        twin=twin,
        scalar="double",
        k=vehicle.k,
        n=vehicle.n,
        entry=name,
        declaration=f"{declaration};",
        arguments="tau, f",
        sources={f"{name}.c": f"{declaration};\n{declaration}\n{{\n{lines}    return 0;\n}}\n"},
    )
