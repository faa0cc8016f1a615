"""The C functions that answer for faults: one for each, or one for many and a table of their numbers."""

from collections.abc import Mapping
from textwrap import indent

from alloc.c.call import arguments, parameters
from alloc.c.statements import Statements
from alloc.program import OWN, Program, Scalar, Where
from alloc.program.literal import number
from alloc.vehicle import Vehicle


def functions(
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
            one = _named(own, fault, program)
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


def _named(own: str, fault: int, program: Program) -> str:
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
    return f"{_named(own, fault, program)}({arguments(limits, levels, row)})"


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
