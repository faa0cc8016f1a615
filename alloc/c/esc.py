"""From thrusts to the commands of ESCs in C: the files of NAME_esc and NAME_to_esc.

``esc.c`` is the same for every vehicle. In front of it stand a vehicle's tables, and macros with its numbers.
"""

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import resources
from textwrap import indent

import numpy as np

from alloc.allocation import FloatArray
from alloc.c.call import function_name, in_comment
from alloc.c.esc_tables import CELLS, REACH, Tables, tables
from alloc.c.helpers import definitions, in_scalar, refusals
from alloc.c.license import IN_C
from alloc.c.recipe import Recipe
from alloc.errors import NotApplicable, VehicleError
from alloc.program import Scalar, Where
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


@dataclass(frozen=True, eq=False)
class EscCode:
    """Parts of the C between a kernel and the ESCs.

    Attributes
    ----------
    vehicle, scalar, limits : as of the kernel that it stands behind
    levels : how many shares that writes
    name : of the kernel
    """

    vehicle: Vehicle
    scalar: Scalar
    limits: Where
    levels: int
    name: str

    @property
    def command(self) -> str:
        """The C type of a command: an integer where neutral, range and step are."""
        escs = self.vehicle.esc
        if not all(esc.whole for esc in escs):
            return self.scalar
        return _integers(max(abs(end) for esc in escs for end in (esc.low, esc.high)))

    def parameters(self, *, tau: bool) -> str:
        """The parameters of NAME_to_esc, which begin with tau, or of NAME_esc, which begin with f."""
        n, scalar = self.vehicle.n, self.scalar
        sides = ("f_min", "f_max") if self.limits == "call" else ()
        arrays = [f"const {scalar} {f'tau[{self.vehicle.k}]' if tau else f'f[{n}]'}"]
        arrays += [f"const {scalar} {side}[{n}]" for side in sides]
        arrays += ["int fault"] * tau + [f"{scalar} volts"]
        arrays += [f"{self.command} command[{n}]", f"{scalar} f_made[{n}]"]
        return ", ".join([*arrays, *[f"{scalar} share[{self.levels}]"] * (tau and self.levels > 0)])

    @property
    def wire(self) -> dict[str, list[str]]:
        """Command of neutral of each thruster, and the size of a step, as literals."""
        columns = {
            "neutral": [esc.neutral for esc in self.vehicle.esc],
            "by": [-esc.step if esc.reversed else esc.step for esc in self.vehicle.esc],
        }
        return {
            name: [self(x) if self.command == self.scalar else f"{x:.0f}" for x in values]
            for name, values in columns.items()
        }

    def __call__(self, value: float) -> str:
        """The literal of a number."""
        return number(value, self.scalar)


def last_metre(vehicle: Vehicle, kernel: Recipe, scalar: Scalar, limits: Where) -> EscCode:
    """Parts of the C behind a kernel.

    Raises VehicleError for a vehicle without ``esc``, NotApplicable where the kernel says shares within fixed
    limits that its ESCs do not reach: thrusts that are cut afterwards deliver other shares.
    """
    if not vehicle.esc:
        raise VehicleError(f"{vehicle.name}: has no ESCs; add 'esc' to its file", "esc")
    levels = kernel.levels(vehicle)
    if limits == "fixed" and levels and (short := _short(vehicle)):
        raise NotApplicable(
            f"{vehicle.name}: {short} for shares of {kernel.name} within fixed limits; give --limits call,"
            " which are cut at what each voltage makes"
        )
    return EscCode(vehicle, scalar, limits, levels, function_name(vehicle, kernel.name, scalar, limits))


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


def to_escs(of: EscCode) -> dict[str, str]:
    """Header and source of NAME_esc and NAME_to_esc, as {file name: text}."""
    return {f"{of.name}_esc.h": _header(of), f"{of.name}_esc.c": _source(of)}


def _source(of: EscCode) -> str:
    """The C source: tables, macros, and what is the same for every vehicle."""
    known = tables(of.vehicle.esc)
    macros = {name: f"{value:d}" if isinstance(value, int) else value for name, value in _macros(of, known)}
    static = (resources.files("alloc.c") / "esc.c").read_text(encoding="utf-8")
    return f"""\
{IN_C}
/* Generated by thrustbench for {in_comment(of.vehicle.name)}; do not edit.
 * {of.name}_esc.h says how to call it. */
#include "{of.name}_esc.h"

{refusals(of.scalar)}
{definitions(["size", "least"], of.scalar)}
typedef {of.command} {of.name}_esc_command;
typedef {_small(known.knots)} {of.name}_esc_piece;
{chr(10).join(_arrays(of, known))}
{chr(10).join(f"#define {of.name}_esc_{name} {text}" for name, text in macros.items())}

{in_scalar(static, of.scalar).replace("NAME", of.name)}"""


def _macros(of: EscCode, known: Tables) -> Iterator[tuple[str, str | int]]:
    """Names and values of a vehicle's numbers, truth values as 0 and 1; a table where thrusters differ."""
    vehicle, curves = of.vehicle, known.curves
    own, several = f"{of.name}_esc_", len(curves) > 1
    low, high = vehicle.f_min, vehicle.f_max
    stops = of.limits == "fixed" and bool(((low <= 0) & (high >= 0)).all())
    alike = stops and bool(np.ptp(low) == np.ptp(high) == 0.0)
    inside = alike and all((c.f[:, 0] >= low[0]).all() and (c.f[:, -1] <= high[0]).all() for c in curves)
    rounded = [curve.f.astype(np.float32 if of.scalar == "float" else np.float64) for curve in curves]
    ahead = np.concatenate([curve.f[:, -1] for curve in curves])
    astern = np.concatenate([-curve.f[:, 0] for curve in curves])
    most = "((ends)->high > -(ends)->low ? (ends)->high : -(ends)->low)"
    if (ahead >= astern).all() or (astern >= ahead).all():
        most = "(ends)->high" if (ahead >= astern).all() else "-(ends)->low"
    yield from {
        "N": vehicle.n,
        "K": vehicle.k,
        "LEVELS": of.levels,
        "AT_CALL": int(of.limits == "call"),
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
    at_call = of.limits == "call"
    for name, values, argument in (("low", low, "f_min"), ("high", high, "f_max")):
        literal = of(float(values[0])) if alike else f"{own}{name}[i]"
        yield f"{name.upper()}(i)", f"{argument}[i]" if at_call else literal
    for name, literals in of.wire.items():
        yield f"{name.upper()}(i)", literals[0] if len(set(literals)) == 1 else f"{own}{name}[i]"
    yield "SENT(i, j)", _sent(of, own)
    yield "MOST(ends)", most
    # No voltage between two makes less than both beside it.
    yield "LEAST", of(float(np.maximum(ahead, astern).min()) / 2)
    yield "REACH", of(REACH)
    yield "MIDDLE", of(CELLS / 2)
    yield "TINY", of(TINY)
    yield "SPARE", of(SPARE[of.scalar] * max(float(np.abs(curve.f).max()) for curve in curves))
    bottom, top = known.measured
    outside = f"!((volts) >= {of(bottom)} && (volts) <= {of(top)})" if np.isfinite(bottom) else "0"
    yield "OUTSIDE(volts)", outside
    yield "ROW(volts)", _row(of, known.volts, 0, max(len(known.volts) - 2, 0))


def _sent(of: EscCode, own: str) -> str:
    """The C of the command that is j steps from neutral."""
    whole = of.command != of.scalar
    step = "(j)" if whole else f"({of.scalar})(j)"
    size, *others = sorted(set(of.wire["by"]))
    along = f"+ {step} * {own}BY(i)"
    if not others and size in ("1", "-1"):
        along = f"{size.replace('1', '') or '+'} {step}"
    text = f"{own}NEUTRAL(i) {along}"
    return f"({of.command})({text})" if whole else text


def _row(of: EscCode, volts: FloatArray, first: int, last: int) -> str:
    """The C of the row for a voltage, halving what is left; NaN takes the last."""
    if first == last:
        return str(first)
    middle = (first + last + 1) // 2
    lower, upper = _row(of, volts, first, middle - 1), _row(of, volts, middle, last)
    return f"((volts) < {of(float(volts[middle]))} ? {lower} : {upper})"


def _arrays(of: EscCode, known: Tables) -> Iterator[str]:
    """All curves, one behind the other, and what has an entry for each thruster."""
    vehicle, curves, scalar = of.vehicle, known.curves, of.scalar

    def array(kind: str, name: str, values: Iterable[str], *shape: int) -> str:
        """A table in lines of a hundred letters."""
        lines = textwrap.wrap(", ".join(values), 100, break_on_hyphens=False)
        sizes = "".join(f"[{size}]" for size in shape or (vehicle.n,))
        text = indent("\n".join(lines), "    ")
        return f"static const {kind} {of.name}_esc_{name}{sizes} = {{\n{text}\n}};"

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
        yield array(scalar, "volts", map(of, known.volts.tolist()), len(known.volts))
        per = (1.0 / np.diff(known.volts)).tolist()
        yield array(scalar, "per_volt", map(of, per), len(per))
    yield array(scalar, "f", map(of, f.ravel().tolist()), f.size)
    if len(curves) > 1:
        yield array("int", "begin", map(str, begin.tolist()), len(begin))
        yield array("uint8_t", "curve", map(str, known.which))
    if len({curve.jump for curve in curves}) > 1:
        yield array("uint8_t", "stays", (str(int(not curve.jump)) for curve in curves), len(curves))
    for name, values in of.wire.items():
        if len(set(values)) > 1:
            yield array(of.command, name, values)
    low, high = vehicle.f_min, vehicle.f_max
    if of.limits == "fixed" and not (np.ptp(low) == np.ptp(high) == 0.0 and low[0] <= 0 <= high[0]):
        yield array(scalar, "low", map(of, low.tolist()))
        yield array(scalar, "high", map(of, high.tolist()))


def _integers(largest: float) -> str:
    """The C type of integers up to that size."""
    return "int16_t" if largest <= np.iinfo(np.int16).max else "int32_t"


def _small(largest: int) -> str:
    """The C type of a count up to that."""
    return "uint8_t" if largest <= np.iinfo(np.uint8).max else "uint16_t"


def _header(of: EscCode) -> str:
    guard = f"{of.name.upper()}_ESC_H"
    returns = "\n".join(f" *   {status:2d}  {meaning}" for status, meaning in MEANINGS.items())
    ends = "\n * f_min    lower limit of each thrust in this call [N]\n * f_max    upper limit [N]"
    cut = (
        "\n * It allocates within limits cut at the ends of the curves at volts: what it says is delivered"
        "\n * is made, but for the steps of the commands, which lower no share."
    ) * (of.limits == "call")
    return f"""\
{IN_C}
/* From thrusts to the ESCs of {in_comment(of.vehicle.name)}. Generated by thrustbench; do not edit.
 *
 * f        wanted thrusts [N]{ends * (of.limits == "call")}
 * volts    of the battery [V]
 * command  what goes to the ESCs: {_ranges(of)}
 * f_made   the thrusts that this makes [N]: f_previous of the next call where thrusts may not jump;
 *          if a step of a command makes more than they may change by, keep the f of {of.name} instead,
 *          and call {of.name}_esc with it, else they stand still
 *
 * {of.name}_esc returns
{returns}
 *
 * {of.name}_to_esc allocates first ({of.name}.h), and returns the status of that; 1 where that is
 * 0 and some thrust is not made. Where nothing is allocated each command is neutral.{cut}
 *
 * No heap, no static data that changes, no recursion, no library call, no division by zero; a call takes
 * bounded time and may be interrupted and re-entered. Not for -ffast-math. C99 and later, C++11 and later.
 */
#ifndef {guard}
#define {guard}

#include <stdint.h>

#include "{of.name}.h"

#ifdef __cplusplus
extern "C" {{
#endif

int {of.name}_esc({of.parameters(tau=False)});

int {of.name}_to_esc({of.parameters(tau=True)});

#ifdef __cplusplus
}}
#endif

#endif
"""


def _ranges(of: EscCode) -> str:
    """Ranges of commands of the thrusters, in words."""
    thrusters: dict[str, list[int]] = {}
    for i, esc in enumerate(of.vehicle.esc):
        thrusters.setdefault(f"{esc.low:g} to {esc.high:g}, neutral is {esc.neutral:g}", []).append(i)
    if len(thrusters) == 1:
        return next(iter(thrusters))
    lines = (f"{words}, of {', '.join(map(str, those))}" for words, those in thrusters.items())
    return ";\n *          ".join(lines) + " (thrusters counted from 0)"
