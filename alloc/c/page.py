"""A page on how to call generated C, for whoever puts it on a vehicle."""

from collections.abc import Iterable

from alloc.allocation import BoundedSteps
from alloc.c.call import arguments, function_name, parameters
from alloc.c.esc import EscCode
from alloc.c.generate import known_faults, programs, returned
from alloc.c.recipe import Recipe
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import MET
from alloc.program import Faults, Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle.frame import described, effect
from alloc.vehicle.geometry import unit


def page(
    vehicle: Vehicle,
    kernel: Recipe,
    scalar: Scalar = "double",
    limits: Where = "fixed",
    faults: Faults = "one",
    last: EscCode | None = None,
) -> str:
    """Markdown: the files, the call, what comes back, what it costs, how to check it; ``last`` with ESCs."""
    off = known_faults(vehicle, faults).size > 0
    failed = "or the index of the thruster that is off" if off else "all others are refused"
    cases = "the whole vehicle and for every failed thruster" if off else "the vehicle"
    name = function_name(vehicle, kernel.name, scalar, limits)
    axes = "\n".join(
        f"| `tau[{i}]` | {axis} | {unit(axis)} | {effect(axis, vehicle.frame)} |"
        for i, axis in enumerate(vehicle.dof)
    )
    own = "\n".join(
        f"| `f[{i}]`{f' {vehicle.names[i]}' if vehicle.names else ''} | {low:g} | {high:g} |"
        for i, (low, high) in enumerate(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
    )
    levels = kernel.levels(vehicle)
    given = parameters(vehicle, scalar, limits, levels, fault="")
    shares = (
        f"\n`share[i]` is the part of level i that was delivered, 0 … 1: {_levels(vehicle, kernel)}. What no"
        " working thruster pushes does not count in it.\n"
        if levels
        else ""
    )
    moving = (
        "\n`f_min` and `f_max` are the limits of this call; those of a thruster that is off are not looked"
        " at. The table has the vehicle's own.\n"
        if limits == "call"
        else ""
    )
    allocator = kernel.build(vehicle)
    steps = allocator.worst_case_steps if isinstance(allocator, BoundedSteps) else None
    bound = f": at most {steps} elementary steps" if steps else ""
    rounding = "\nSingle precision rounds every thrust at about 1e-7 of itself." if scalar == "float" else ""
    warning = (
        "" if allocator.limited else "\n**f may lie beyond these limits**: this method does not know them.\n"
    )
    codes = returned(kernel, programs(vehicle, kernel, scalar, faults, limits))
    statuses = "\n".join(f"| {status} | {meaning} |" for status, meaning in codes.items())
    return f"""\
# {vehicle.name} by {kernel.name}, in C99

`{name}.c` and `{name}.h` are all that belongs on the vehicle. They call no
library, allocate nothing, keep nothing between calls and do not recurse. A call takes bounded
time{bound}.

```c
#include "{name}.h"

int allocate({given});

int allocate({given})
{{
    const int failed = -1; /* {failed} */
    return {name}({arguments(limits, levels, "failed")});
}}
```

| status | meaning |
|---|---|
{statuses}

A demand counts as met where f misses no axis by more than {MET[scalar]:g} of the length of its row of T
times the largest limit ({vehicle.f_scale:g} N).{rounding}

`tau` is in the vehicle's frame, {described(vehicle.frame)}.

| in | axis | unit | a positive one |
|---|---|---|---|
{axes}

| out | lower limit [N] | upper limit [N] |
|---|---|---|
{own}
{moving}{shares}{warning}{_limits_at(vehicle, scalar) if limits == "call" else ""}{_esc(last) if last else ""}
## Check it where it will run

`test/{name}_test.c` holds demands for {cases}, with the
answers the Python method gives. It prints the largest difference and exits with 0 where all agree.
On a board compile it with `-Dmain=selftest`, and call that:

    cc -std=c99 -O2 -ffp-contract=off -I. {name}.c test/{name}_test.c -o selftest && ./selftest

Compile with `-ffp-contract=off`: C++ and some C compilers fuse a * b + c, which rounds otherwise. Compile
without `-ffast-math` (and what implies it), which `{name}.c` refuses: NaN would pass unseen. C++ takes the
files as they are. On a Cortex-M7 with a single-precision FPU give GCC `-DTHRUSTBENCH_FPV5`:
it does not say itself that the FPU has a minimum and a maximum.
"""


def _esc(last: EscCode) -> str:
    name, n = last.name, last.vehicle.n
    limits = "f_min, f_max, " * (last.limits == "call")
    share = f"    {last.scalar} share[{last.levels}];\n" * (last.levels > 0)
    ends = f"const {last.scalar} f_min[{n}], const {last.scalar} f_max[{n}], " * (last.limits == "call")
    call = f"{name}_to_esc(tau, {limits}-1, volts, command, f_made{', share' * (last.levels > 0)})"
    send = f"int send(const {last.scalar} tau[{last.vehicle.k}], {ends}{last.scalar} volts)"
    return f"""
## From a wrench to {n} commands

`{name}_esc.c` and `.h` beside them go on to what the ESCs take:

```c
#include "{name}_esc.h"

{send};

{send}
{{
    {last.command} command[{n}]; /* what goes to the ESCs */
    {last.scalar} f_made[{n}];
{share}    const int status = {call};
    /* set_pulse_width(i, command[i]) for each thruster */
    return status;
}}
```

A command makes what is nearest to its thrust within the limits; NaN, and what nothing is allocated for, is
neutral.{" Limits are cut at the ends of the curves at `volts` before." * bool(limits)}
`{name}_esc(f, {limits}volts, command, f_made)` takes thrusts. The self-test:

    cc -std=c99 -O2 -I. {name}.c {name}_esc.c test/{name}_esc_test.c -o esc_test && ./esc_test
"""


def _levels(vehicle: Vehicle, kernel: Recipe) -> str:
    way = find_formulation(kernel.formulation).way
    named = way(vehicle).levels if way else (vehicle.dof,)
    return "; ".join(", ".join(axes) for axes in named)


def _limits_at(vehicle: Vehicle, scalar: Scalar) -> str:
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
