"""The C around a kernel for the analyser: a call with any arguments at all, and what must hold after it."""

import re
from collections.abc import Collection

import numpy as np

from alloc.c import arguments, covering, known_faults
from alloc.methods import recipe
from alloc.program import Scalar
from bench.proof.source import ANSWERED, Subject

MAIN = "main.c"


ARRAY = re.compile(r"\b(static )?(const )?(double |float )(?=(\w+)\[|\*x\b)")
STRUCT = re.compile(r"^struct (\w+) \{(.*?)^\};", re.MULTILINE | re.DOTALL)
REAL = re.compile(r"^ +(?:double|float) ([\w, ]+);", re.MULTILINE)
CONSTANT = ("of", "low", "high")
"""Arrays of constants, where limits are the vehicle's: ``of`` points at a table."""


def harness(of: Subject) -> dict[str, str]:
    """The files to analyse: the C with the covering form of minimum and maximum, and a main that calls it."""
    read = {**of.files, f"{of.name}.c": covering(of.source, of.scalar)}
    known = CONSTANT if of.limits == "fixed" else CONSTANT[:1]
    return {name: any_bits(text, known) for name, text in read.items()} | {MAIN: _main(of)}


def any_bits(text: str, known: Collection[str] = ()) -> str:
    """The C whose arrays give any bits at each read, and whose other memory is asserted to hold numbers.

    EVA 25 takes for unreachable what follows where a comparison leaves an entry of an array, or what a
    pointer points at, nothing but NaN. Volatile arrays avoid that: they give more than any call can see.
    Members of structures and the arrays that are ``known`` keep their values, so that each is asserted to be
    finite where it is written. Tables, and what scalars hold, are as they are.
    """
    text = "".join(_volatile(part, known) for part in re.split(r"(?<=^}\n)", text, flags=re.MULTILINE))
    for name, body in STRUCT.findall(text):
        text = _numbers(text, name, [each for line in REAL.findall(body) for each in line.split(", ")])
    for name in known:
        text = _entries(text, name)
    return text


def _volatile(function: str, known: Collection[str]) -> str:
    """The C of one function, with arrays volatile that it reads; tables and what it only writes stay."""

    def one(found: re.Match[str]) -> str:
        static, const, number, name = found.groups(default="")
        if static or name in known:
            return found[0]
        read = const or not name or re.search(rf"\b{name}(\[\w+\])+(?!\[| = )", body)
        return f"{const}volatile {number}" if read else found[0]

    body = re.sub(r"/\*.*?\*/", "", function.partition("\n{\n")[2])
    return ARRAY.sub(one, function)


def _entries(text: str, array: str) -> str:
    """The C with an assertion behind each statement that writes entries of this array."""
    begun = re.compile(rf"^ +(?:const )?(?:double|float) {array}\[(\d+)\] = \{{.*\}};$", re.MULTILINE)
    one = re.compile(rf"^ +({array}\[\w+\]) = [^;]*;", re.MULTILINE)
    text = begun.sub(lambda at: at[0] + "".join(_finite(f"{array}[{i}]") for i in range(int(at[1]))), text)
    return one.sub(lambda at: at[0] + _finite(at[1]), text)


def _numbers(text: str, struct: str, members: list[str]) -> str:
    """The C with an assertion behind each statement that writes these members, or a whole structure."""
    if not members:
        return text
    whole = re.compile(rf"^ +(?:const )?struct {struct} (\w+) = \{{.*\}};$", re.MULTILINE)
    one = re.compile(rf"^ +([\w>.-]+(?:->|\.)(?:{'|'.join(members)})) = [^;]*;", re.MULTILINE)
    text = whole.sub(lambda at: at[0] + "".join(_finite(f"{at[1]}.{each}") for each in members), text)
    return one.sub(lambda at: at[0] + _finite(at[1]), text)


def _finite(place: str) -> str:
    return f" /*@ assert number: \\is_finite({place}); */"


def _main(of: Subject) -> str:
    n, k, levels, call = of.vehicle.n, of.vehicle.k, of.levels, of.limits == "call"
    inputs = [("tau", k), *([("f_min", n), ("f_max", n)] if call else [])]
    outputs = [("f", n), *([("share", levels)] if levels else [])]
    declared = "\n".join(f"    {of.scalar} {name}[{size}];" for name, size in [*inputs, *outputs])
    filled = "\n".join(_loop(size, f"{name}[i] = any;") for name, size in inputs)
    statuses = sorted(recipe(of.kernel).meanings)
    known = [-1, *known_faults(of.vehicle, of.faults).tolist()]
    answered = [status for status in statuses if status in ANSWERED]
    holds = [_each(name, size, "written", f"\\initialized(&{name}[i])") for name, size in outputs]
    if of.limited:
        numbers = outputs[1:] if call else outputs  # bench.proof.safety.limits shows the rest
        holds += [_each(name, size, "number", f"\\is_finite({name}[i])") for name, size in numbers]
        holds += [_each("share", levels, "share", "0 <= share[i] <= 1")] if levels else []
        holds += [] if call else [_limit(of, i) for i in range(n)]
    refused = [_each(name, size, "untouched", f"!\\initialized(&{name}[i])") for name, size in outputs]
    return f"""\
#include "{of.name}.c"

extern volatile {of.scalar} any;
extern volatile int any_int;

int main(void)
{{
{declared}
    int fault, other, status;
{filled}
    fault = -1; /* each fault apart from the others, and all that are none */
    for (int i = 0; i < {n} && any_int; i++) {{
        fault = i;
    }}
    other = any_int;
    if (other < -1 || other >= {n}) {{
        fault = other;
    }}
    status = {of.name}({arguments(of.limits, levels, "fault")});
    /*@ assert status: {" || ".join(f"status == {each}" for each in statuses)}; */
    /*@ assert status: status == -1 || {" || ".join(f"fault == {each}" for each in known)}; */
    if ({" || ".join(f"status == {each}" for each in answered)}) {{
{chr(10).join(holds)}
    }} else {{
{chr(10).join(refused)}
    }}
    return status;
}}
"""


def _loop(size: int, statement: str) -> str:
    return f"    for (int i = 0; i < {size}; i++) {{\n        {statement}\n    }}"


def _each(name: str, size: int, label: str, holds: str) -> str:
    return _loop(size, f"/*@ assert {label}_{name}: {holds}; */")


def _limit(of: Subject, i: int) -> str:
    low, high = (_exactly(side[i], of.scalar) for side in (of.vehicle.f_min, of.vehicle.f_max))
    off = "" if of.vehicle.readiness[i] == 0 else f"        /*@ assert off: fault != {i} || f[{i}] == 0; */\n"
    # Zero may lie outside of the limits of a thruster that works.
    rests = "" if of.vehicle.f_min[i] <= 0 <= of.vehicle.f_max[i] else f"fault == {i} || "
    return (
        f"        /*@ assert low: {rests}f[{i}] >= {low}; */\n"
        f"        /*@ assert high: {rests}f[{i}] <= {high}; */\n{off}"
    ).rstrip("\n")


def _exactly(value: float, scalar: Scalar) -> str:
    """The real that C's literal of the limit is rounded to: of a decimal ACSL takes the real itself."""
    return float(np.float32(value) if scalar == "float" else value).hex()
