"""The C around the library for one vehicle: its numbers, and calls that look like those of generated C."""

from alloc.c.target import arguments, function_name, parameters
from alloc.library import K_MAX, N_MAX, NAME, calls, files
from alloc.program import Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import refuse_azimuths
from alloc.vehicle.geometry import DOF
from alloc.vehicle.names import axis_levels
from alloc.vehicle.weak import six_rows

NEVER = 1e-30
"""Limit of sigma / sigma_max for a file's ``weak: 0``: nothing is weak by it; in C 0 means by the survey."""
FORMS: tuple[Where, ...] = ("fixed", "call")


def levels(method: str, vehicle: Vehicle) -> int:
    """Number of shares that a method of the library writes for a vehicle."""
    return (len(vehicle.priority) if method == "priority" else 1) if calls()[method] else 0


def name(vehicle: Vehicle, method: str, scalar: Scalar = "double") -> str:
    """Prefix of the names of an adapter's functions and files."""
    return f"{function_name(vehicle, method, scalar)}_library"


def sized(vehicle: Vehicle, scalar: Scalar = "double") -> dict[str, str]:
    """The library with room for this vehicle."""
    return files(scalar, max(N_MAX, vehicle.n), max(K_MAX, vehicle.k))


def adapter(vehicle: Vehicle, method: str, scalar: Scalar = "double") -> dict[str, str]:
    """``<name>.c`` and its header: ``<name>_prepare()``, then ``<name>_fixed`` and ``<name>_call``.

    The last two are called as generated C is, within the vehicle's limits and those of the call; ``fault`` is
    -1 there and not looked at, as what is off is in the numbers of the vehicle.
    ``<name>_ready(tau)`` returns tau, and prepares at its first call.
    """
    refuse_azimuths(vehicle.azimuths, "libthrustbench", "its limits are a box")
    own = name(vehicle, method, scalar)
    shares = levels(method, vehicle)
    tables = {
        "T": vehicle.T,
        "H": vehicle.H,
        "readiness": vehicle.readiness,
        "f_min": vehicle.f_min,
        "f_max": vehicle.f_max,
    }
    mixture = vehicle.mixture if shares else ((1.0, vehicle),)
    surveyed, room = mixture[0][1] is not vehicle, len(mixture) - 1
    if surveyed and vehicle.poses is not None:
        tables["poses"] = six_rows(vehicle.T, vehicle.dof, vehicle.poses)
    numbers = "\n".join(
        f"static const {scalar} own_{key}[{values.size}] = "
        f"{{{', '.join(number(value, scalar) for value in values.ravel().tolist())}}};"
        for key, values in tables.items()
    )
    poses, survey = "own_poses" if "poses" in tables else "NULL", vehicle.survey
    strong = ""
    if surveyed:
        strong = "    status = status ? status : tb_strong(allocator, 0, &own_survey);\n"
        limit = max(vehicle.weak_limit, NEVER) if vehicle.weak_limit is not None else 0.0
        tolerances = (survey.mm, survey.deg, survey.relative or 0.0, limit)
        axes = ", ".join(str(DOF.index(axis)) for axis in vehicle.dof)
        numbers += f"""
static const int own_axis[{vehicle.k}] = {{{axes}}};
static const struct tb_survey own_survey = {{
    own_T, {poses}, own_axis, {", ".join(number(each, scalar) for each in tolerances)}, {room}
}};"""
    level = axis_levels(vehicle.priority, vehicle.dof)
    heads = {form: f"int {own}_{form}({parameters(vehicle, scalar, form, shares)})" for form in FORMS}
    given = {
        form: arguments(form, shares, "" if form == "call" else "NULL, NULL") for form in FORMS
    }  # the limits
    bodies = "\n".join(
        f"{head}\n{{\n    (void)fault;\n    return tb_{method}(allocator, {given[form]});\n}}\n"
        for form, head in heads.items()
    )
    prepares, ready = f"int {own}_prepare(void)", f"const {scalar} *{own}_ready(const {scalar} *tau)"
    return {
        f"{own}.h": f'#include "{NAME}.h"\n\n{prepares};\n{ready};\n'
        + "".join(f"{head};\n" for head in heads.values()),
        f"{own}.c": f"""\
#include "{own}.h"
#include <stddef.h>

{numbers}
static const int own_level[{vehicle.k}] = {{{", ".join(map(str, level))}}};
static struct tb_allocator allocator[{1 + room}];

{prepares}
{{
    {"int" if strong else "const int"} status =
        tb_prepare(allocator, {vehicle.k}, {vehicle.n}, own_T, own_H, own_readiness, own_f_min, own_f_max);
{strong}    return status ? status : tb_levels(allocator, own_level);
}}

{ready}
{{
    if (allocator[0].n == 0) {{
        {own}_prepare();
    }}
    return tau;
}}

{bodies}""",
    }
