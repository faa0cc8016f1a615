"""The tables of a vehicle's ESCs as C."""

import textwrap
from collections.abc import Iterable, Iterator
from textwrap import indent

import numpy as np

from alloc.c.esc_code import EscCode, integers
from alloc.c.esc_tables import Tables


def small(largest: int) -> str:
    """The C type of a count up to that."""
    return "uint8_t" if largest <= np.iinfo(np.uint8).max else "uint16_t"


def arrays(of: EscCode, known: Tables) -> Iterator[str]:
    """All curves, one behind the other, and what has an entry for each thruster."""
    vehicle, curves = of.vehicle, known.curves
    steps = np.concatenate([curve.steps for curve in curves])
    f = np.concatenate([curve.f for curve in curves], axis=1)
    begin = np.cumsum([0, *(len(curve.steps) for curve in curves)])
    yield _array(integers(float(np.abs(steps).max())), f"step[{len(steps)}]", map(str, steps.tolist()))
    first = np.stack(
        [each.first() + at for each, at in zip(curves, begin[:-1].tolist(), strict=True)], axis=1
    )
    rows = (
        "{" + ", ".join(f"{{{', '.join(map(str, row))}}}" for row in each) + "}" for each in first.tolist()
    )
    yield _array(small(len(steps)), "first" + "".join(f"[{size}]" for size in first.shape), rows)
    if of.by_volts:
        yield _array(of.scalar, f"volts[{len(known.volts)}]", map(of, known.volts.tolist()))
        per = (1.0 / np.diff(known.volts)).tolist()
        yield _array(of.scalar, f"per_volt[{len(per)}]", map(of, per))
    yield _array(of.scalar, f"f[{f.size}]", map(of, f.ravel().tolist()))
    if len(curves) > 1:
        yield _array("int", f"begin[{len(begin)}]", map(str, begin.tolist()))
        yield _array("uint8_t", f"curve[{vehicle.n}]", map(str, known.which))
    if len({curve.jump for curve in curves}) > 1:
        yield _array("uint8_t", f"stays[{len(curves)}]", (str(int(not curve.jump)) for curve in curves))
    for name, values in of.wire.items():
        if len(set(values)) > 1:
            yield _array(of.command, f"{name}[{vehicle.n}]", values)
    if of.limits == "fixed" and not of.alike:
        yield _array(of.scalar, f"low[{vehicle.n}]", map(of, vehicle.f_min.tolist()))
        yield _array(of.scalar, f"high[{vehicle.n}]", map(of, vehicle.f_max.tolist()))


def _array(kind: str, name: str, values: Iterable[str]) -> str:
    """A table in lines of a hundred letters."""
    lines = textwrap.wrap(", ".join(values), 100, break_on_hyphens=False)
    return f"static const {kind} OWN_{name} = {{\n{indent(chr(10).join(lines), '    ')}\n}};"
