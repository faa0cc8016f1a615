"""The C around the library for one vehicle: its numbers, and calls that look like those of generated C."""

import numpy as np

from alloc.c.target import arguments, function_name, parameters
from alloc.errors import NotApplicable
from alloc.library import K_MAX, N_MAX, NAME, calls, files
from alloc.program import Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle.geometry import DOF
from alloc.vehicle.names import axis_levels
from alloc.vehicle.weak import MOST, omissions, six_rows

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
    ``<name>_ready(tau)`` returns tau, and prepares at its first call. Where a direction counts in part there
    are files for each vehicle of ``Vehicle.mixture``, too. Raises NotApplicable where they can't be told.
    """
    own, shares = name(vehicle, method, scalar), levels(method, vehicle)
    mixture = vehicle.mixture if shares else ((1.0, vehicle),)
    if len(mixture) == 1:
        weak = None if mixture[0][1] is vehicle else vehicle.weak_limit or 0.0
        return _one(own, vehicle, method, scalar, weak)
    made = dict[str, str]()
    for j, weak in enumerate(_largest_weak(vehicle)):
        made |= _one(f"{own}_{j}", vehicle, method, scalar, weak)
    return made | _mixed(own, vehicle, scalar, shares)


def _largest_weak(vehicle: Vehicle) -> list[float]:
    """The sigma / sigma_max up to which directions are left out, of each vehicle of ``Vehicle.mixture``."""
    sigma, found = vehicle.directions.sigma / vehicle.directions.sigma[0], list[float]()
    for _, left_out in omissions(vehicle.counts):
        kept = np.ones(vehicle.k, dtype=bool)
        kept[left_out] = False
        least, most = float(sigma[kept].min()), float(sigma[left_out].max(initial=0.0))
        found.append(min(0.5 * (least + most), MOST))
        if not most < found[-1] < least:
            raise NotApplicable(
                f"{vehicle.name}: {NAME} can't leave out a direction of {100 * most:.2g} % and keep one of"
                f" {100 * least:.2g} %; take generated C"
            )
    return found


def _mixed(own: str, vehicle: Vehicle, scalar: Scalar, shares: int) -> dict[str, str]:
    """The C that mixes the answers of ``<own>_0``, ``<own>_1``, … as ``Vehicle.mixture`` says."""
    n, ws = vehicle.n, [w for w, _ in vehicle.mixture]
    heads = {form: f"int {own}_{form}({parameters(vehicle, scalar, form, shares)})" for form in FORMS}
    prepares, ready = f"int {own}_prepare(void)", f"const {scalar} *{own}_ready(const {scalar} *tau)"
    calls = {form: arguments(form, shares, "fault").replace("f, share", "one, part") for form in FORMS}
    table = {
        side: f"static const {scalar} own_{side}[{n}] = {{{', '.join(number(x, scalar) for x in values)}}};\n"
        for side, values in (("f_min", vehicle.f_min.tolist()), ("f_max", vehicle.f_max.tolist()))
    }
    bodies = ""
    for form, head in heads.items():
        low, high = ("f_min", "f_max") if form == "call" else ("own_f_min", "own_f_max")
        each = ", ".join(f"{own}_{j}_{form}" for j in range(len(ws)))
        bodies += f"""
{head}
{{
    static int (*const of[])({parameters(vehicle, scalar, form, shares)}) = {{{each}}};
    static const {scalar} w[] = {{{", ".join(number(each, scalar) for each in ws)}}};
    {scalar} sum[{n}], before[{n}], one[{n}], said[{shares}], past[{shares}], part[{shares}];
    int worst = TB_SOLVED;
    for (int j = 0; j < {len(ws)}; j++) {{
        const int status = of[j]({calls[form]});
        if (status != TB_SOLVED && status != TB_PARTIAL) {{
            return status;
        }}
        worst = status > worst ? status : worst;
        for (int i = 0; i < {n}; i++) {{
            sum[i] = j ? sum[i] + w[j] * (one[i] - before[i]) : one[i];
            sum[i] = sum[i] < {low}[i] ? {low}[i] : sum[i] > {high}[i] ? {high}[i] : sum[i];
            before[i] = one[i];
        }}
        for (int i = 0; i < {shares}; i++) {{
            said[i] = j ? said[i] + w[j] * (part[i] - past[i]) : part[i];
            past[i] = part[i];
        }}
    }}
    for (int i = 0; i < {n}; i++) {{
        f[i] = sum[i];
    }}
    for (int i = 0; i < {shares}; i++) {{
        share[i] = said[i];
    }}
    return worst;
}}
"""
    prepared = " || ".join(f"(status = {own}_{j}_prepare())" for j in range(len(ws)))
    readied = "".join(f"    {own}_{j}_ready(tau);\n" for j in range(len(ws)))
    return {
        f"{own}.h": "".join(f'#include "{own}_{j}.h"\n' for j in range(len(ws)))
        + f"\n{prepares};\n{ready};\n"
        + "".join(f"{head};\n" for head in heads.values()),
        f"{own}.c": f"""\
#include "{own}.h"

{"".join(table.values())}
{prepares}
{{
    int status;
    (void)({prepared});
    return status;
}}

{ready}
{{
{readied}    return tau;
}}
{bodies}""",
    }


def _one(own: str, vehicle: Vehicle, method: str, scalar: Scalar, weak: float | None) -> dict[str, str]:
    """The C of ``adapter`` for one allocator; ``weak`` as of ``struct tb_survey``, None without a survey."""
    shares = levels(method, vehicle)
    tables = {
        "T": vehicle.T,
        "H": vehicle.H,
        "readiness": vehicle.readiness,
        "f_min": vehicle.f_min,
        "f_max": vehicle.f_max,
    }
    if weak is not None and vehicle.poses is not None:
        tables["poses"] = six_rows(vehicle.T, vehicle.dof, vehicle.poses)
    numbers = "\n".join(
        f"static const {scalar} own_{key}[{values.size}] = "
        f"{{{', '.join(number(value, scalar) for value in values.ravel().tolist())}}};"
        for key, values in tables.items()
    )
    poses, survey = "own_poses" if "poses" in tables else "NULL", vehicle.survey
    strong = ""
    if weak is not None:
        strong = "    status = status ? status : tb_strong(&allocator, 0, &own_survey);\n"
        tolerances = (survey.mm, survey.deg, survey.relative or 0.0, weak)
        axes = ", ".join(str(DOF.index(axis)) for axis in vehicle.dof)
        numbers += f"""
static const int own_axis[{vehicle.k}] = {{{axes}}};
static const struct tb_survey own_survey = {{
    own_T, {poses}, own_axis, {", ".join(number(each, scalar) for each in tolerances)}
}};"""
    level = axis_levels(vehicle.priority, vehicle.dof)
    heads = {form: f"int {own}_{form}({parameters(vehicle, scalar, form, shares)})" for form in FORMS}
    given = {
        form: arguments(form, shares, "" if form == "call" else "NULL, NULL") for form in FORMS
    }  # the limits
    bodies = "\n".join(
        f"{head}\n{{\n    (void)fault;\n    return tb_{method}(&allocator, {given[form]});\n}}\n"
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
static struct tb_allocator allocator;

{prepares}
{{
    {"int" if strong else "const int"} status =
        tb_prepare(&allocator, {vehicle.k}, {vehicle.n}, own_T, own_H, own_readiness, own_f_min, own_f_max);
{strong}    return status ? status : tb_levels(&allocator, own_level);
}}

{ready}
{{
    if (allocator.n == 0) {{
        {own}_prepare();
    }}
    return tau;
}}

{bodies}""",
    }
