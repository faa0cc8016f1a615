"""The tables of docs/exact.md, out of what ``bench.studies.native_speed`` measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from alloc import Vehicle, find
from bench.harness.machine import cpu
from bench.results.text import table, three

EXACT, PINV, WALSH = "nullspace@native", "pinv@native", "walsh@native"
OSQP, DAQP, DAQP_C = "qp/osqp@generated", "qp/daqp", "qp/daqp in C"
PLAIN, PRODUCT = "plain", "product"


@dataclass(frozen=True)
class Measured:
    """One vehicle: C [ns a call] by column and by class, instructions, Python calls [ns], many() [1/s]."""

    vehicle: Vehicle
    c: dict[str, float]
    by_class: dict[str, dict[str, float]]
    counts: dict[str, NDArray[np.int64]]
    calls: dict[str, float]
    per_second: float

    @property
    def label(self) -> str:
        """Name and nullity, as tables show it."""
        return f"{self.vehicle.name}, d = {self.vehicle.nullity}"

    @property
    def solver(self) -> str:
        """The quickest live solver in this run."""
        return min((name for name in self.calls if find(name).solver), key=self.calls.__getitem__)


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


def tables(found: Sequence[Measured]) -> str:
    """Markdown."""
    classes = [
        [m.label, kind, *(three(ns.get(column)) for column in (EXACT, DAQP, DAQP_C, OSQP))]
        for m in found
        for kind, ns in m.by_class.items()
    ]
    heads = ["vehicle", "demands", "nullspace", "DAQP's own clock", "DAQP, whole call", "OSQP's generated C"]
    return "\n".join(
        [
            f"Measured on {cpu()}; gcc -O2, one core, CPU time, the least of several batches.\n",
            "**In C, ns a call.** DAQP's own clock: wall time of its solve alone; the others: whole calls.\n",
            of(IN_C, found),
            "**In C by class of demand, ns a call**\n",
            table(heads, classes),
            "**Instructions a call** (callgrind, x86-64)\n",
            of(COUNTS, found),
            "**From Python, ns a call**, and `many()`\n",
            of(CALLS, found),
        ]
    )


def of(columns: Columns, found: Sequence[Measured]) -> str:
    """A table with one row a vehicle."""
    return table(list(columns), [[value(m) for value in columns.values()] for m in found])


def ratio(one: float, other: float) -> str:
    """One over the other, two digits."""
    return f"{one / other:.2g}"
