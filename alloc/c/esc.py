"""From thrusts to the commands of ESCs in C: the files of NAME_esc and NAME_to_esc.

``esc.c`` is the same for every vehicle. In front of it stand a vehicle's tables, and macros with its numbers.
"""

import textwrap
from collections.abc import Iterable, Iterator
from textwrap import indent

import numpy as np

from alloc.allocation import FloatArray
from alloc.c.esc_tables import CELLS, REACH, Tables, tables
from alloc.c.target import Target
from alloc.c.text import IN_C, definitions, in_comment, refusals, static
from alloc.errors import NotApplicable, VehicleError
from alloc.program import Scalar
from alloc.program.literal import number
from alloc.vehicle import Vehicle
from alloc.vehicle import esc as python

MEANINGS = {
    0: "each thrust is made, to half a step of its command",
    1: "some thrust lies beyond its limit or the end of its curve, or is so small that its command is"
    " neutral;\n *      or nothing was measured at that voltage",
    -2: "some thrust is NaN or infinite: its command is neutral",
}
"""Statuses of NAME_esc."""
TINY = 1e-30
"""Keeps a piece of the curve that does not rise from a division by zero; no other is changed by it [N]."""
SPARE: dict[Scalar, float] = {"double": python.SPARE, "float": 1e-6}
"""``alloc.vehicle.esc.SPARE``, and what rounding makes of it in float."""


def check_escs(target: Target) -> None:
    """Refuse C between a kernel and the ESCs that would say what is not so.

    Raises VehicleError for a vehicle without ``esc``, NotApplicable where the kernel says shares within fixed
    limits that its ESCs do not reach: thrusts that are cut afterwards deliver other shares.
    """
    vehicle = target.vehicle
    if not vehicle.esc:
        raise VehicleError(f"{vehicle.name}: has no ESCs; add 'esc' to its file", "esc")
    if target.limits == "fixed" and target.levels and (short := _short(vehicle)):
        raise NotApplicable(
            f"{vehicle.name}: {short} for shares of {target.method.name} within fixed limits; give --limits"
            " call, which are cut at what each voltage makes"
        )


def command_type(target: Target) -> str:
    """The C type of a command: an integer where neutral, range and step are."""
    escs = target.vehicle.esc
    if not all(esc.whole for esc in escs):
        return target.scalar
    return _integers(max(abs(end) for esc in escs for end in (esc.low, esc.high)))


def command_text(target: Target, value: float) -> str:
    """The literal of a command."""
    return number(value, target.scalar) if command_type(target) == target.scalar else f"{value:.0f}"


def neutral_commands(target: Target) -> list[str]:
    """Command of neutral of each thruster, as literals."""
    return [command_text(target, esc.neutral) for esc in target.vehicle.esc]


def _wire(target: Target) -> dict[str, list[str]]:
    """Command of neutral of each thruster, and the size of a step, as literals."""
    sizes = (-esc.step if esc.reversed else esc.step for esc in target.vehicle.esc)
    return {"neutral": neutral_commands(target), "by": [command_text(target, size) for size in sizes]}


def _parameters(target: Target, *, tau: bool) -> str:
    """The parameters of NAME_to_esc, which begin with tau, or of NAME_esc, which begin with f."""
    n, scalar, levels = target.vehicle.n, target.scalar, target.levels
    sides = ("f_min", "f_max") if target.limits == "call" else ()
    arrays = [f"const {scalar} {f'tau[{target.vehicle.k}]' if tau else f'f[{n}]'}"]
    arrays += [f"const {scalar} {side}[{n}]" for side in sides]
    arrays += ["int fault"] * tau + [f"{scalar} volts"]
    arrays += [f"{command_type(target)} command[{n}]", f"{scalar} f_made[{n}]"]
    return ", ".join([*arrays, *[f"{scalar} share[{levels}]"] * (tau and levels > 0)])


def _short(vehicle: Vehicle) -> str:
    """The first thruster whose ESC does not reach its limits at some voltage, in words; empty for none."""
    volts = np.unique(np.concatenate([esc.volts for esc in vehicle.esc]))
    low, high = vehicle.esc_limits(volts)
    lost = np.maximum(low - vehicle.f_min, vehicle.f_max - high) > python.SPARE * vehicle.f_scale
    if not lost.any():
        return ""
    row, i = np.argwhere(lost)[0].tolist()
    at = "" if np.isnan(volts[row]) else f" at {volts[row]:g} V"
    return (
        f"the ESC of {vehicle.called(i)} makes {low[row, i]:.4g} … {high[row, i]:.4g} N{at}, expected"
        f" {vehicle.f_min[i]:g} … {vehicle.f_max[i]:g} N"
    )


def to_escs(target: Target) -> dict[str, str]:
    """Header and source of NAME_esc and NAME_to_esc, as {file name: text}; raises as ``check_escs``."""
    check_escs(target)
    return {f"{target.name}_esc.h": _header(target), f"{target.name}_esc.c": _source(target)}


def _source(target: Target) -> str:
    """The C source: tables, macros, and what is the same for every vehicle."""
    known, name = tables(target.vehicle.esc), target.name
    macros = {
        macro: f"{value:d}" if isinstance(value, int) else value for macro, value in _macros(target, known)
    }
    return f"""\
{IN_C}
/* Generated by thrustbench for {in_comment(target.vehicle.name)}; do not edit.
 * {name}_esc.h says how to call it. */
#include "{name}_esc.h"

{refusals(target.scalar)}
{definitions(["size", "least"], target.scalar)}
typedef {command_type(target)} {name}_esc_command;
typedef {_small(known.knots)} {name}_esc_piece;
{chr(10).join(_arrays(target, known))}
{chr(10).join(f"#define {name}_esc_{macro} {text}" for macro, text in macros.items())}

{static("esc.c", target.scalar).replace("NAME", name)}"""


def _macros(target: Target, known: Tables) -> Iterator[tuple[str, str | int]]:
    """Names and values of a vehicle's numbers, truth values as 0 and 1; a table where thrusters differ."""
    vehicle, scalar, curves = target.vehicle, target.scalar, known.curves
    own, several = f"{target.name}_esc_", len(curves) > 1
    low, high = vehicle.f_min, vehicle.f_max
    stops = target.limits == "fixed" and bool(((low <= 0) & (high >= 0)).all())
    alike = stops and bool(np.ptp(low) == np.ptp(high) == 0.0)
    inside = alike and all((c.f[:, 0] >= low[0]).all() and (c.f[:, -1] <= high[0]).all() for c in curves)
    rounded = [curve.f.astype(np.float32 if scalar == "float" else np.float64) for curve in curves]
    ahead = np.concatenate([curve.f[:, -1] for curve in curves])
    astern = np.concatenate([-curve.f[:, 0] for curve in curves])
    most = "((ends)->high > -(ends)->low ? (ends)->high : -(ends)->low)"
    if (ahead >= astern).all() or (astern >= ahead).all():
        most = "(ends)->high" if (ahead >= astern).all() else "-(ends)->low"
    yield from {
        "N": vehicle.n,
        "K": vehicle.k,
        "LEVELS": target.levels,
        "AT_CALL": int(target.limits == "call"),
    }.items()
    yield from {"CURVES": len(curves), "KNOTS": known.knots, "LAST_CELL": CELLS - 1}.items()
    yield "FIRST_STEP", min(int(curve.steps[0]) for curve in curves)
    yield "LAST_STEP", max(int(curve.steps[-1]) for curve in curves)
    yield "BY_VOLTS", int(len(known.volts) > 1)
    yield "FLAT", int(any((f[:, [1, -1]] == f[:, [0, -2]]).any() for f in rounded))
    yield "ALIKE", int(alike)  # one pair of limits for all thrusters, with 0 between them
    yield "HOLDS", int(not inside)
    yield "STOPS", int(stops)  # each thruster may stand still in every call
    yield "STAY", int(not all(curve.jump for curve in curves))
    stays = {curve.jump for curve in curves} == {False}
    yield "STAYS(curve)", "1" if stays else f"{own}stays[curve]"
    yield "CURVE(i)", f"{own}curve[i]" if several else "0"
    yield "BEGIN(curve)", f"{own}begin[curve]" if several else "0"
    yield "LAST(curve)", f"({own}begin[(curve) + 1] - 1)" if several else str(known.knots - 1)
    at_call = target.limits == "call"
    for name, values, argument in (("low", low, "f_min"), ("high", high, "f_max")):
        literal = number(float(values[0]), scalar) if alike else f"{own}{name}[i]"
        yield f"{name.upper()}(i)", f"{argument}[i]" if at_call else literal
    for name, literals in _wire(target).items():
        yield f"{name.upper()}(i)", literals[0] if len(set(literals)) == 1 else f"{own}{name}[i]"
    yield "SENT(i, j)", _sent(target, own)
    yield "MOST(ends)", most
    # No voltage between two makes less than both beside it.
    yield "LEAST", number(float(np.maximum(ahead, astern).min()) / 2, scalar)
    yield "REACH", number(REACH, scalar)
    yield "MIDDLE", number(CELLS / 2, scalar)
    yield "TINY", number(TINY, scalar)
    largest = max(float(np.abs(curve.f).max()) for curve in curves)
    yield "SPARE", number(SPARE[scalar] * largest, scalar)
    bottom, top = known.measured
    ends = [number(volts, scalar) for volts in (bottom, top) if np.isfinite(volts)]
    yield "OUTSIDE(volts)", f"!((volts) >= {ends[0]} && (volts) <= {ends[1]})" if ends else "0"
    yield "ROW(volts)", _row(scalar, known.volts, 0, max(len(known.volts) - 2, 0))


def _sent(target: Target, own: str) -> str:
    """The C of the command that is j steps from neutral."""
    whole = command_type(target) != target.scalar
    step = "(j)" if whole else f"({target.scalar})(j)"
    size, *others = sorted(set(_wire(target)["by"]))
    along = f"+ {step} * {own}BY(i)"
    if not others and size in ("1", "-1"):
        along = f"{size.replace('1', '') or '+'} {step}"
    text = f"{own}NEUTRAL(i) {along}"
    return f"({command_type(target)})({text})" if whole else text


def _row(scalar: Scalar, volts: FloatArray, first: int, last: int) -> str:
    """The C of the row for a voltage, halving what is left; NaN takes the last."""
    if first == last:
        return str(first)
    middle = (first + last + 1) // 2
    lower, upper = _row(scalar, volts, first, middle - 1), _row(scalar, volts, middle, last)
    return f"((volts) < {number(float(volts[middle]), scalar)} ? {lower} : {upper})"


def _arrays(target: Target, known: Tables) -> Iterator[str]:
    """All curves, one behind the other, and what has an entry for each thruster."""
    vehicle, curves, scalar = target.vehicle, known.curves, target.scalar

    def array(kind: str, name: str, values: Iterable[str], *shape: int) -> str:
        """A table in lines of a hundred letters."""
        lines = textwrap.wrap(", ".join(values), 100, break_on_hyphens=False)
        sizes = "".join(f"[{size}]" for size in shape or (vehicle.n,))
        text = indent("\n".join(lines), "    ")
        return f"static const {kind} {target.name}_esc_{name}{sizes} = {{\n{text}\n}};"

    def numbers(values: Iterable[float]) -> Iterable[str]:
        return (number(value, scalar) for value in values)

    steps = np.concatenate([curve.steps for curve in curves])
    f = np.concatenate([curve.f for curve in curves], axis=1)
    begin = np.cumsum([0, *(len(curve.steps) for curve in curves)])
    yield array(_integers(float(np.abs(steps).max())), "step", map(str, steps.tolist()), len(steps))
    first = np.stack(
        [each.first() + at for each, at in zip(curves, begin[:-1].tolist(), strict=True)], axis=1
    )
    rows = (
        "{" + ", ".join(f"{{{', '.join(map(str, row))}}}" for row in each) + "}" for each in first.tolist()
    )
    yield array(_small(len(steps)), "first", rows, *first.shape)
    if len(known.volts) > 1:
        yield array(scalar, "volts", numbers(known.volts.tolist()), len(known.volts))
        per = (1.0 / np.diff(known.volts)).tolist()
        yield array(scalar, "per_volt", numbers(per), len(per))
    yield array(scalar, "f", numbers(f.ravel().tolist()), f.size)
    if len(curves) > 1:
        yield array("int", "begin", map(str, begin.tolist()), len(begin))
        yield array("uint8_t", "curve", map(str, known.which))
    if len({curve.jump for curve in curves}) > 1:
        yield array("uint8_t", "stays", (str(int(not curve.jump)) for curve in curves), len(curves))
    for name, values in _wire(target).items():
        if len(set(values)) > 1:
            yield array(command_type(target), name, values)
    low, high = vehicle.f_min, vehicle.f_max
    if target.limits == "fixed" and not (np.ptp(low) == np.ptp(high) == 0.0 and low[0] <= 0 <= high[0]):
        yield array(scalar, "low", numbers(low.tolist()))
        yield array(scalar, "high", numbers(high.tolist()))


def _integers(largest: float) -> str:
    """The C type of integers up to that size."""
    return "int16_t" if largest <= np.iinfo(np.int16).max else "int32_t"


def _small(largest: int) -> str:
    """The C type of a count up to that."""
    return "uint8_t" if largest <= np.iinfo(np.uint8).max else "uint16_t"


def _header(target: Target) -> str:
    guard = f"{target.name.upper()}_ESC_H"
    returns = "\n".join(f" *   {status:2d}  {meaning}" for status, meaning in MEANINGS.items())
    ends = "\n * f_min    lower limit of each thrust in this call [N]\n * f_max    upper limit [N]"
    cut = (
        "\n * It allocates within limits cut at the ends of the curves at volts: what it says is delivered"
        "\n * is made, but for the steps of the commands, which lower no share."
    ) * (target.limits == "call")
    return f"""\
{IN_C}
/* From thrusts to the ESCs of {in_comment(target.vehicle.name)}. Generated by thrustbench; do not edit.
 *
 * f        wanted thrusts [N]{ends * (target.limits == "call")}
 * volts    of the battery [V]
 * command  what goes to the ESCs: {_ranges(target)}
 * f_made   the thrusts that this makes [N]: f_previous of the next call where thrusts may not jump;
 *          if a step of a command makes more than they may change by, keep the f of {target.name} instead,
 *          and call {target.name}_esc with it, else they stand still
 *
 * {target.name}_esc returns
{returns}
 *
 * {target.name}_to_esc allocates first ({target.name}.h), and returns the status of that; 1 where that is
 * 0 and some thrust is not made. Where nothing is allocated each command is neutral.{cut}
 *
 * No heap, no static data that changes, no recursion, no library call, no division by zero; a call takes
 * bounded time and may be interrupted and re-entered. Not for -ffast-math. C99 and later, C++11 and later.
 */
#ifndef {guard}
#define {guard}

#include <stdint.h>

#include "{target.name}.h"

#ifdef __cplusplus
extern "C" {{
#endif

int {target.name}_esc({_parameters(target, tau=False)});

int {target.name}_to_esc({_parameters(target, tau=True)});

#ifdef __cplusplus
}}
#endif

#endif
"""


def _ranges(target: Target) -> str:
    """Ranges of commands of the thrusters, in words."""
    thrusters: dict[str, list[int]] = {}
    for i, esc in enumerate(target.vehicle.esc):
        thrusters.setdefault(f"{esc.low:g} to {esc.high:g}, neutral is {esc.neutral:g}", []).append(i)
    if len(thrusters) == 1:
        return next(iter(thrusters))
    lines = (f"{words}, of {', '.join(map(str, those))}" for words, those in thrusters.items())
    return ";\n *          ".join(lines) + " (thrusters counted from 0)"
