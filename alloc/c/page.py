"""A page on how to call generated C, for whoever puts it on a vehicle."""

from alloc.allocation import BoundedSteps
from alloc.c.call import arguments, function_name, parameters
from alloc.c.esc import EscCode
from alloc.c.generate import known_faults, programs, returned
from alloc.c.recipe import Recipe
from alloc.c.volts import limits_at
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import MET
from alloc.program import Faults, Scalar, Where
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
{moving}{shares}{warning}{limits_at(vehicle, scalar) if limits == "call" else ""}{_esc(last) if last else ""}
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
