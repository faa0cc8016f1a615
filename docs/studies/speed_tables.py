"""The tables of results/studies/native_speed.md, from what ``docs/studies/native_speed.py`` measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from alloc import Vehicle
from bench.harness.machine import cpu
from bench.results.text import table, three

EXACT, PINV, WALSH = "nullspace@native", "pinv@native", "walsh@native"
OSQP, DAQP, DAQP_C = "qp/osqp@generated", "qp/daqp", "qp/daqp in C"
PLAIN, PRODUCT = "plain", "product"


@dataclass(frozen=True, kw_only=True)
class Measured:
    """All figures of one vehicle.

    Attributes
    ----------
    vehicle : the vehicle
    c : time of a call in C [ns], by column
    by_class : the same figures by class of demand, then by column [ns]
    counts : instructions (N,) of each call in C, by column
    calls : time of a call from Python [ns], by label
    solvers : labels of the calls that are live solvers
    per_second : allocations of ``many()`` [1/s]
    """

    vehicle: Vehicle
    c: dict[str, float]
    by_class: dict[str, dict[str, float]]
    counts: dict[str, NDArray[np.int64]]
    calls: dict[str, float]
    solvers: tuple[str, ...]
    per_second: float

    @property
    def label(self) -> str:
        """Name and nullity, as tables show them."""
        return f"{self.vehicle.name}, d = {self.vehicle.nullity}"

    @property
    def solver(self) -> str:
        """Label of the fastest live solver."""
        return min(self.solvers, key=self.calls.__getitem__)


Columns = dict[str, Callable[[Measured], str]]
IN_C: Columns = {
    "vehicle": lambda m: m.label,
    "product as it stands": lambda m: three(m.c[PLAIN]),
    "pinv": lambda m: three(m.c[PINV]),
    "walsh": lambda m: three(m.c.get(WALSH)),
    "nullspace": lambda m: three(m.c[EXACT]),
    "DAQP's own clock": lambda m: three(m.c[DAQP]),
    "DAQP, whole call": lambda m: three(m.c.get(DAQP_C)),
    "nullspace / product": lambda m: ratio(m.c[EXACT], m.c[PLAIN]),
    "nullspace / pinv": lambda m: ratio(m.c[EXACT], m.c[PINV]),
    "nullspace / DAQP": lambda m: ratio(m.c[EXACT], m.c[DAQP]),
}
COUNTS: Columns = {
    "vehicle": lambda m: m.label,
    "pinv": lambda m: str(m.counts[PINV].max()),
    "nullspace, mean": lambda m: str(round(m.counts[EXACT].mean())),
    "nullspace, worst": lambda m: str(m.counts[EXACT].max()),
    "worst / pinv": lambda m: ratio(m.counts[EXACT].max(), m.counts[PINV].max()),
}
CALLS: Columns = {
    "vehicle": lambda m: m.label,
    "`T_pinv @ tau`": lambda m: three(m.calls[PRODUCT]),
    "pinv@native": lambda m: three(m.calls[PINV]),
    "nullspace@native": lambda m: three(m.calls[EXACT]),
    "nullspace": lambda m: three(m.calls["nullspace"]),
    "fastest solver": lambda m: m.solver,
    "its call": lambda m: three(m.calls[m.solver]),
    "native / product": lambda m: ratio(m.calls[EXACT], m.calls[PRODUCT]),
    "native / solver": lambda m: ratio(m.calls[EXACT], m.calls[m.solver]),
    "numpy / product": lambda m: ratio(m.calls["nullspace"], m.calls[PRODUCT]),
    "many(), 10⁶/s": lambda m: f"{m.per_second / 1e6:.0f}",
}


def tables(measured: Sequence[Measured]) -> str:
    """All tables as Markdown."""
    classes = [
        [m.label, kind, *(three(ns.get(column)) for column in (EXACT, DAQP, DAQP_C, OSQP))]
        for m in measured
        for kind, ns in m.by_class.items()
    ]
    heads = ["vehicle", "demands", "nullspace", "DAQP's own clock", "DAQP, whole call", "OSQP's generated C"]
    return "\n".join(
        [
            f"Measured on {cpu()}; gcc -O2, one core, CPU time, the least of several batches.\n",
            "**In C, ns a call.** DAQP's own clock: wall time of its solve alone; the others: whole calls.\n",
            of(IN_C, measured),
            "**In C by class of demand, ns a call**\n",
            table(heads, classes),
            "**Instructions a call** (callgrind, x86-64)\n",
            of(COUNTS, measured),
            "**From Python, ns a call**, and `many()`\n",
            of(CALLS, measured),
        ]
    )


def of(columns: Columns, measured: Sequence[Measured]) -> str:
    """A table with one row for each vehicle."""
    return table(list(columns), [[value(m) for value in columns.values()] for m in measured])


def ratio(time: float, reference: float) -> str:
    """``time`` over ``reference``, two digits."""
    return f"{time / reference:.2g}"
