"""A page on how to call generated C, for whoever puts it on a vehicle."""

from alloc.allocation import BoundedSteps
from alloc.native.code import TOLERANCE, Scalar
from alloc.native.generate import function_name
from alloc.native.recipes import recipe
from alloc.vehicle import Vehicle
from alloc.vehicle.geometry import unit


def page(vehicle: Vehicle, kernel: str, scalar: Scalar = "double") -> str:
    """Markdown: the files, the call, what comes back, what it costs, how to check it."""
    name = function_name(vehicle, kernel, scalar)
    axes = "\n".join(f"| `tau[{i}]` | {axis} | {unit(axis)} |" for i, axis in enumerate(vehicle.dof))
    limits = "\n".join(
        f"| `f[{i}]`{f' {vehicle.names[i]}' if vehicle.names else ''} | {low:g} | {high:g} |"
        for i, (low, high) in enumerate(zip(vehicle.f_min.tolist(), vehicle.f_max.tolist(), strict=True))
    )
    allocator = recipe(kernel).twin(vehicle)
    steps = allocator.worst_case_steps if isinstance(allocator, BoundedSteps) else None
    bound = f": at most {steps} elementary steps" if steps else ""
    rounding = "\nSingle precision rounds every thrust at about 1e-7 of itself." if scalar == "float" else ""
    warning = (
        "" if allocator.limited else "\n**f may lie beyond these limits**: this method does not know them.\n"
    )
    statuses = "\n".join(f"| {status} | {meaning} |" for status, meaning in recipe(kernel).meanings.items())
    return f"""\
# {vehicle.name} by {kernel}, in C99

`{name}.c` and `{name}.h` are all that belongs on the vehicle. They call no
library, allocate nothing, keep nothing between calls and do not recurse. A call takes bounded
time{bound}.

```c
#include "{name}.h"

int allocate(const {scalar} tau[{vehicle.k}], {scalar} f[{vehicle.n}]);

int allocate(const {scalar} tau[{vehicle.k}], {scalar} f[{vehicle.n}])
{{
    const int failed = -1; /* or the index of the thruster that is off */
    return {name}(tau, failed, f);
}}
```

| status | meaning |
|---|---|
{statuses}

A demand counts as met within {TOLERANCE[scalar]:g} of the largest limit ({vehicle.f_scale:g} N).{rounding}

| in | axis | unit |
|---|---|---|
{axes}

| out | lower limit [N] | upper limit [N] |
|---|---|---|
{limits}
{warning}
## Check it where it will run

`{name}_test.c` holds demands for the whole vehicle and for every failed thruster, with the
answers the Python method gives. It prints the largest difference and exits with 0 where all agree:

    cc -std=c99 -O2 {name}.c {name}_test.c -o selftest && ./selftest

Compile without `-ffast-math` (and what implies it): NaN would pass unseen.
"""
