"""Gappa's bound on the rounding of the linear part of a kernel, a second way to a part of ``rounding``."""

import re
from pathlib import Path

from alloc import Vehicle
from alloc.program import Node, Program, Scalar, reachable
from bench.proof import tools
from bench.proof.rounding.errors import Errors
from bench.proof.rounding.forms import has_tau, shares_of

FORMATS: dict[Scalar, str] = {"double": "ieee_64", "float": "ieee_32"}
SIGNS = {"add": "+", "sub": "-", "mul": "*"}
KNOWN = {*SIGNS, "neg", "const", "input"}


def before_limits(program: Program, errors: Errors, vehicle: Vehicle, scalar: Scalar) -> float | None:
    """Gappa's bound [N] on |x - G tau| for every thrust before its limits; None where Gappa is not there.

    Each entry of tau goes over its own range, whatever the others are, so this may exceed the bound over
    attainable demands; constants are those of the C.
    """
    if "gappa" in tools.absent():
        return None
    wanted = sorted({x for node in program.outputs.values() for x in _linear(program, errors, node)})
    if not wanted:
        return None
    lines = [f"@rnd = float<{FORMATS[scalar]}, ne>;"]
    for j in range(vehicle.k):
        lines.append(f"t{j} = rnd(T{j});")
    cone = sorted(reachable(program.nodes, tuple(wanted)))
    if any(program.nodes[node][0] not in KNOWN for node in cone):
        return None
    for node in cone:
        lines += _defined(program, node)
    goals = " /\\ ".join(f"n{node} - m{node} in ?" for node in wanted)
    given = " /\\ ".join(f"T{j} in [-{size!r}, {size!r}]" for j, size in enumerate(_reach(vehicle)))
    printed = tools.run(["gappa"], Path.cwd(), "\n".join([*lines, f"{{ {given} -> {goals} }}"]))
    ends = re.findall(r"- m\d+ in \[([^,{]+)(?:\{[^}]*\})?, ([^]{]+)(?:\{[^}]*\})?\]", printed)
    if len(ends) != len(wanted):
        return None
    return max(abs(_number(end)) for pair in ends for end in pair)


def _reach(vehicle: Vehicle) -> list[float]:
    largest = abs(vehicle.TP) @ abs(vehicle.f_max).clip(abs(vehicle.f_min))
    return [float(each) for each in largest]


def _linear(program: Program, errors: Errors, node: Node) -> list[Node]:
    """The nodes linear in tau that a thrust is made of."""
    value = errors.values.get(node)
    if value is not None and value.form and has_tau(value.form) and not shares_of(value.form):
        return [node]
    match program.nodes[node]:
        case ("min" | "max", a, _):
            return _linear(program, errors, a)
        case ("add" | "sub", a, b):
            return _linear(program, errors, a) or _linear(program, errors, b)
    return []


def _defined(program: Program, node: Node) -> list[str]:
    match program.nodes[node]:
        case ("const", value):
            return [f"{name}{node} = {_binary(value)};" for name in "nm"]
        case ("input", _, j):
            return [f"{name}{node} = t{j};" for name in "nm"]
        case ("neg", a):
            return [f"{name}{node} = -{name}{a};" for name in "nm"]
        case (operation, a, b):
            sign = SIGNS[operation]
            return [f"n{node} rnd= n{a} {sign} n{b};", f"m{node} = m{a} {sign} m{b};"]
    raise AssertionError(program.nodes[node])


def _binary(value: float) -> str:
    """A number as Gappa reads it exactly: an integer times a power of two."""
    top, bottom = value.as_integer_ratio()
    return f"{top}b-{bottom.bit_length() - 1}"


def _number(text: str) -> float:
    """Number as Gappa prints it: 123b-45, -1.5e-7 or 0."""
    whole = re.fullmatch(r"(-?\d+)b(-?\d+)", text.strip())
    return float(whole[1]) * 2.0 ** int(whole[2]) if whole else float(text)
