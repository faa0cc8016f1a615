"""C99, and C++, for one vehicle and one method: header, source, self-test."""

from collections.abc import Mapping
from functools import lru_cache
from hashlib import sha256
from textwrap import indent

from alloc.allocation import IndexArray
from alloc.c.call import arguments, function_name, in_comment, parameters
from alloc.c.helpers import digits, helpers, refusals
from alloc.c.license import IN_C
from alloc.c.recipe import Recipe
from alloc.c.selftest import selftest
from alloc.c.statements import NO_SUCH_FAULT, STATUSES, Statements
from alloc.program import OWN, Faults, Program, Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle.frame import axis_of, described, effect
from alloc.vehicle.geometry import unit


def generate(
    vehicle: Vehicle,
    kernel: Recipe,
    scalar: Scalar = "double",
    faults: Faults = "one",
    limits: Where = "fixed",
) -> dict[str, str]:
    """The C99 files of one method for one vehicle, as {file name: text}.

    ``<name>.h`` declares ``int <name>(const double tau[k], int fault, double f[n])``, ``<name>.c`` defines
    it and ``test/<name>_test.c`` is a program that checks it against answers computed here; <name> is
    ``<vehicle>_<kernel>``, with ``_call`` where the ``limits`` are arguments of the call, f_min[n] and
    f_max[n] behind tau, and ``_float`` where the scalar is float. Where the method goes level by level, it
    writes behind f what of each level is delivered. ``fault`` is -1, or the index of the one thruster that is
    off; of ``faults`` "none" it is -1, and of "all" one function answers for all. Raises NotApplicable where
    the method does not cover the vehicle, or those faults.
    """
    name = function_name(vehicle, kernel.name, scalar, limits)
    made = sources(vehicle, kernel, scalar, faults, limits)  # refuses what C can't cover, and quickly
    printed, known = digest(name, made), known_faults(vehicle, faults)
    return made | {f"test/{name}_test.c": selftest(vehicle, name, kernel, scalar, known, limits, printed)}


def digest(name: str, files: Mapping[str, str]) -> str:
    """SHA-256 of header and source, hexadecimal, as ``cat <name>.h <name>.c | sha256sum`` prints it."""
    return sha256((files[f"{name}.h"] + files[f"{name}.c"]).encode()).hexdigest()


def sources(
    vehicle: Vehicle,
    kernel: Recipe,
    scalar: Scalar = "double",
    faults: Faults = "one",
    limits: Where = "fixed",
) -> dict[str, str]:
    """Header and source as in ``generate``, without the self-test."""
    return printed(vehicle, kernel, programs(vehicle, kernel, scalar, faults, limits), scalar, limits)


def printed(
    vehicle: Vehicle,
    kernel: Recipe,
    made: Mapping[int, Program],
    scalar: Scalar = "double",
    limits: Where = "fixed",
) -> dict[str, str]:
    """Header and source that do what programs say, by the thruster that is off; see ``sources``."""
    name = function_name(vehicle, kernel.name, scalar, limits)
    return {
        f"{name}.h": _header(vehicle, name, kernel, scalar, limits, made),
        f"{name}.c": _source(vehicle, name, scalar, limits, made),
    }


def returned(kernel: Recipe, made: Mapping[int, Program]) -> dict[int, str]:
    """The statuses that the C of these programs may return, with the kernel's words for each."""
    known = {NO_SUCH_FAULT}.union(*(program.statuses for program in made.values()))
    return {status: meaning for status, meaning in kernel.meanings.items() if status in known}


def programs(
    vehicle: Vehicle,
    kernel: Recipe,
    scalar: Scalar = "double",
    faults: Faults = "one",
    limits: Where = "fixed",
) -> Mapping[int, Program]:
    """Programs of the whole vehicle, -1, and with each one thruster off.

    Of ``faults`` "all" one program is that of many; each has its own after which a direction is lost.
    """
    return _programs(vehicle, kernel, scalar, faults, limits)


@lru_cache(maxsize=2)  # header, source and page ask one after the other
def _programs(
    vehicle: Vehicle, kernel: Recipe, scalar: Scalar, faults: Faults, limits: Where
) -> Mapping[int, Program]:
    variants = {-1: vehicle} | {i: vehicle.with_fault(i) for i in known_faults(vehicle, faults).tolist()}
    one = kernel.program_for_all(vehicle, limits, scalar) if faults == "all" else None
    together = one.faults if one and len(one.faults) > 1 else ()
    return {
        fault: one if one and fault in together else kernel.program(variant, limits, scalar)
        for fault, variant in variants.items()
    }


def known_faults(vehicle: Vehicle, faults: Faults) -> IndexArray:
    """The thrusters whose failure the C answers for; none where nothing would be left."""
    return vehicle.working if faults != "none" and len(vehicle.working) > 1 else vehicle.working[:0]


def _header(
    vehicle: Vehicle,
    name: str,
    kernel: Recipe,
    scalar: Scalar,
    limits: Where,
    made: Mapping[int, Program],
) -> str:
    guard, levels = f"{name.upper()}_H", made[-1].size("share")
    known = "-1, or the index of the one thruster that is off" if len(made) > 1 else "-1"
    ends = (
        "\n * f_min  lower limit of each thrust in this call [N]\n * f_max  upper limit [N]"
        if limits == "call"
        else ""
    )
    shares = _SHARES if levels else ""
    divided = _DIVIDED if limits == "call" and levels else ""
    signs = "\n".join(
        f" *        tau[{i}] {axis} [{unit(axis)}], {axis_of(axis, vehicle.frame)}: positive"
        f" {effect(axis, vehicle.frame)}"
        for i, axis in enumerate(vehicle.dof)
    )
    returns = "\n".join(f" *   {status:2d}  {meaning}" for status, meaning in returned(kernel, made).items())
    return f"""\
{IN_C}
/* Thrust allocation for {in_comment(vehicle.name)} by {kernel.name}. {_by(made)}; do not edit.
 *
 * tau    wanted wrench, in the frame {described(vehicle.frame)}
{signs}{ends}
 * fault  {known}
 * f      thrusts [N]{_named(vehicle)}{shares}
 *
 * Returns
{returns}
 *
 * No heap, no static data that changes, no recursion, no library call; a call takes bounded time and
 * may be interrupted and re-entered. Not for -ffast-math. C99 and later, C++11 and later.{divided}
 */
#ifndef {guard}
#define {guard}

{digits(scalar)}

{_STATUSES}

#ifdef __cplusplus
extern "C" {{
#endif

int {name}({parameters(vehicle, scalar, limits, levels)});

#ifdef __cplusplus
}}
#endif

#endif
"""


def _by(made: Mapping[int, Program]) -> str:
    """Origin of the C, and its faults where it is not for one: all these forms go by one name."""
    other = "none" if len(made) == 1 else "all" if any(program.faults for program in made.values()) else ""
    return "Generated by thrustbench" + (f" --faults {other}" if other else "")


_SHARES = """
 * share  per level, the fraction of the demand delivered, 0 to 1, counting only axes that working
 *        thrusters can push"""

_DIVIDED = """
 *
 * Limits that leave no margin divide by zero, as IEEE 754 has it: x / 0 is infinite and the share 0, and
 * 0 / 0 is NaN, which the maximum leaves out. So the FPU may not trap these two."""
"""What -fsanitize=float-divide-by-zero tells of; to keep it from zero would cost an operation a facet."""

_STATUSES = f"""\
#ifndef THRUSTBENCH_STATUSES
#define THRUSTBENCH_STATUSES
enum {{ {", ".join(f"{word} = {value}" for value, word in STATUSES.items())} }};
#endif"""
"""What all functions return, once in a translation unit."""


def _source(
    vehicle: Vehicle,
    name: str,
    scalar: Scalar,
    limits: Where,
    made: Mapping[int, Program],
) -> str:
    levels = made[-1].size("share")
    parts, cases = _functions(vehicle, f"{name}_", scalar, limits, made)
    return f"""\
{IN_C}
/* Generated by thrustbench for {in_comment(vehicle.name)}; do not edit. {name}.h says how to call it. */
#include "{name}.h"

{refusals(scalar)}
{helpers(made.values(), scalar)}
{chr(10).join(parts)}
int {name}({parameters(vehicle, scalar, limits, levels)})
{{
    switch (fault) {{
{chr(10).join(cases)}
    default:
        return {STATUSES[NO_SUCH_FAULT]};
    }}
}}
"""


def _named(vehicle: Vehicle) -> str:
    """The thrusters' names, each on a line of a comment; empty where they have none."""
    return "".join(f"\n *        f[{i}] {in_comment(name)}" for i, name in enumerate(vehicle.names) if name)


def _functions(
    vehicle: Vehicle, own: str, scalar: Scalar, limits: Where, made: Mapping[int, Program]
) -> tuple[list[str], list[str]]:
    """Definitions, whose names begin with ``own``, and the cases of a switch over faults that calls them.

    ``made`` has the program of each fault, several of which may share one.
    """
    levels = made[-1].size("share")
    # Loops are told which thrusters work, and have the numbers of the whole vehicle.
    parts, cases = [loop.text.replace(OWN, own) for loop in made[-1].loops.values()], list[str]()
    tables: dict[Program, int] = {}
    for fault, program in made.items():
        if program not in tables:
            one = _one(own, fault, program)
            written, tables[program] = Statements(program, own), 0
            if rows := written.table.rows:
                tables[program] = len(rows[0])
                lines = ",\n".join(f"    {{{', '.join(row)}}}" for row in rows)
                parts.append(
                    f"static const {scalar} {own}of[{len(rows)}][{len(rows[0])}] = {{\n{lines}\n}};\n"
                )
            row = f"const {scalar} of[{tables[program]}]" if rows else ""
            given = parameters(vehicle, scalar, limits, levels, row)
            parts.append(f"static int {one}({given})\n{{\n{_body(program, written, limits)}}}\n")
            if _limited(program, limits):
                parts.append(_without(vehicle, own, one, scalar, levels, row))
        cases.append(
            f"    case {fault}:\n        return {_call(own, fault, program, limits, levels, tables)};"
        )
    return parts, cases


def _one(own: str, fault: int, program: Program) -> str:
    return f"{own}all" if program.faults else f"{own}whole" if fault < 0 else f"{own}fault{fault}"


def _call(
    own: str, fault: int, program: Program, limits: Where, levels: int, tables: Mapping[Program, int]
) -> str:
    row = ""
    if tables[program]:
        at = program.faults.index(fault)
        # Faults get the same text where possible, so that a compiler makes one call of them all.
        row = f"{own}of[{'fault + 1' if at == fault + 1 else at}]"
    if _limited(program, limits) and fault >= 0:
        return f"{own}without({arguments(limits, levels, ', '.join(filter(None, ('fault', row))))})"
    return f"{_one(own, fault, program)}({arguments(limits, levels, row)})"


def _limited(program: Program, limits: Where) -> bool:
    """True if the program is for many faults and takes limits of the call."""
    return bool(program.faults) and limits == "call" and not _read(program).isdisjoint(("f_min", "f_max"))


def _read(program: Program) -> set[str]:
    """The arguments that it looks at."""
    return {array for kind, array, *_ in program.nodes if kind in ("input", "finite")}


def _without(vehicle: Vehicle, own: str, one: str, scalar: Scalar, levels: int, row: str) -> str:
    """The function that calls the one for all with limits of zero for the thruster that is off."""
    given = parameters(vehicle, scalar, "call", levels, ", ".join(filter(None, ("int off", row))))
    passed = arguments("call", levels, "of" if row else "").replace("f_min", "low").replace("f_max", "high")
    return f"""\
static int {own}without({given})
{{
    {scalar} low[{vehicle.n}];
    {scalar} high[{vehicle.n}];
    for (int i = 0; i < {vehicle.n}; i++) {{
        low[i] = f_min[i];
        high[i] = f_max[i];
    }}
    low[off] = {number(0.0, scalar)};
    high[off] = {number(0.0, scalar)};
    return {one}({passed});
}}
"""


def _body(program: Program, written: Statements, limits: Where) -> str:
    arrays = ("tau", "f_min", "f_max") if limits == "call" else ("tau",)
    unread = [f"(void){array};" for array in arrays if array not in _read(program)]
    return indent("\n".join([*written.table.define(), "", *unread, *written.lines]), "    ") + "\n"
