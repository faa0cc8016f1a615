"""C for the page of a kernel with limits of the call: f_min and f_max at a battery's voltage."""

from collections.abc import Iterable

from alloc.program import Scalar
from alloc.program.literal import number
from alloc.vehicle import Vehicle


def limits_at(vehicle: Vehicle, scalar: Scalar) -> str:
    """The section of the page: a C function that gives f_min and f_max at a voltage; nothing without a table.

    Linear between the voltages of the vehicle's table, and within the vehicle's own limits, as
    ``Vehicle.limits``; beyond the table's ends, which Python refuses, an end's limits.
    """
    table = vehicle.by_volts
    if table is None:
        return ""
    levels, n = len(table.volts), vehicle.n
    head = f"void limits_at({scalar} volts, {scalar} f_min[{n}], {scalar} f_max[{n}])"

    def row(values: Iterable[float]) -> str:
        return "{" + ", ".join(number(value, scalar) for value in values) + "}"

    low, high = (
        "{\n        " + ",\n        ".join(row(limits) for limits in side.tolist()) + "}"
        for side in (table.f_min, table.f_max)
    )
    return f"""
## Limits at a battery's voltage

Linear between the voltages of the vehicle's table, and never wider than the vehicle's own limits. Beyond the
table the limits of its nearest end hold, where NaN is taken for the lowest voltage.

```c
{head};

{head}
{{
    static const {scalar} at[{levels}] = {row(table.volts.tolist())};
    static const {scalar} low[{levels}][{n}] = {low};
    static const {scalar} high[{levels}][{n}] = {high};
    static const {scalar} own_low[{n}] = {row(vehicle.f_min.tolist())};
    static const {scalar} own_high[{n}] = {row(vehicle.f_max.tolist())};
    int i = 0, j;
    {scalar} part;
    while (i < {levels - 2} && volts > at[i + 1])
        ++i;
    part = (volts - at[i]) / (at[i + 1] - at[i]);
    part = part >= 1 ? 1 : part > 0 ? part : 0;
    for (j = 0; j < {n}; ++j) {{
        f_min[j] = low[i][j] + part * (low[i + 1][j] - low[i][j]);
        f_max[j] = high[i][j] + part * (high[i + 1][j] - high[i][j]);
        f_min[j] = f_min[j] > own_low[j] ? f_min[j] : own_low[j];
        f_max[j] = f_max[j] < own_high[j] ? f_max[j] : own_high[j];
    }}
}}
```
"""
