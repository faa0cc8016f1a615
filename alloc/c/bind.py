"""A generated kernel as an allocator: compiled, loaded, and called without Python code in between."""

import ctypes
import importlib.util
import sysconfig
from collections.abc import Callable, Mapping
from functools import cache, partial
from importlib import resources
from importlib.machinery import ExtensionFileLoader
from math import nan
from pathlib import Path
from textwrap import indent
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    LARGEST_DEMAND,
    Allocation,
    Allocator,
    BoundedSteps,
    FloatArray,
    Status,
    checked,
    checked_many,
    no_cap,
)
from alloc.c.compiled import NATIVE, processor, shared_library, unloadable
from alloc.c.generate import sources
from alloc.c.statements import ALONE, Statements
from alloc.c.target import Recipe, Target, function_name, parameters
from alloc.c.text import helpers
from alloc.errors import NotInstalled
from alloc.formulations import Formulation, find_formulation, mixed
from alloc.program import Branch, Exit, Fence, Node, Where, Write
from alloc.vehicle import Vehicle
from alloc.vehicle.azimuth import NOTHING, polar
from alloc.vehicle.call_limits import at_call, limits_of
from alloc.vehicle.limits import thrusts

FORMS: tuple[Where, ...] = ("fixed", "call")
COUNT = 64
"""Demands that a call answers."""
TOGETHER = 8
"""Demands that are read, answered and written before the next ones: two registers of numbers or more."""
AGAIN = -1
"""Status of a demand that the kernel for one demand must answer: what it sums up is not finite."""
FETCH = f"""
/* Asks for what the next call reads or writes at this place, while this one calculates: it comes from far. */
#ifdef __GNUC__
#define fetch(x, size, b, step) \\
    for (long at = 0; at < {TOGETHER} * size; at += 8) \\
        __builtin_prefetch(x + ({COUNT} + b) * (step) + at)
#else
#define fetch(x, size, b, step) ((void)0)
#endif
"""
ABREAST_FLAGS = ("-std=c99", "-ffp-contract=off", "-O3", *NATIVE)
"""For this processor alone; with the same rounding as the kernel for one demand has."""


def bound(kernel: Recipe, vehicle: Vehicle) -> Allocator:
    """The kernel for this vehicle as an allocator; raises NotApplicable or NotInstalled.

    Calls that give no limits are answered by the C that holds the vehicle's as constants, others by the C
    that takes them; one library has both. Where thrusters turn no call has limits but the vehicle's own.
    """
    twin = kernel.build(vehicle)  # states the promises, and refuses what the C would not cover
    forms = {
        limits: Target(vehicle=vehicle, method=kernel, faults="none", limits=limits)
        for limits in (FORMS[:1] if vehicle.azimuths else FORMS)
    }
    fixed = forms["fixed"]
    second = function_name(vehicle, kernel.name, limits="call")
    taking = sources(forms["call"]) if "call" in forms else _call_adapter(fixed, second)
    return native(
        shared_library(kernel.name, sources(fixed) | taking),
        (fixed.name, second),
        vehicle,
        formulation=twin.formulation,
        limited=twin.limited,
        tolerance=twin.tolerance,
        worst_case_steps=twin.worst_case_steps if isinstance(twin, BoundedSteps) else None,
        levels=fixed.levels,
        together=_Together(forms),
    )


def _call_adapter(target: Target, name: str) -> dict[str, str]:
    """A function of that name with limits of the call, which are checked to be the vehicle's own."""
    given = parameters(target.vehicle, target.scalar, "call", target.levels)
    return {
        f"{name}.c": f"""\
#include "{target.name}.h"

int {name}({given});

int {name}({given})
{{
    (void)f_min;
    (void)f_max;
    return {target.name}({target.arguments("fault")});
}}
"""
    }


def native(
    path: Path,
    functions: tuple[str, str],
    vehicle: Vehicle,
    *,
    context: int = 0,
    more: int = 0,
    supply: Callable[[float | None, float | None], tuple[float, float]] | None = None,
    stated_residual: FloatArray | None = None,
    needs: object = None,
    formulation: str,
    limited: bool,
    tolerance: float,
    worst_case_steps: int | None = None,
    levels: int = 0,
    state: bool = False,
    together: Callable[[Where], int] | None = None,
) -> Allocator:
    """An allocator that a compiled library answers; raises NotInstalled where that can't be loaded.

    Parameters
    ----------
    path : the library
    functions : names of its functions that answer within the vehicle's limits, and within those of the call,
        which take the arguments of a kernel for double precision
    vehicle : whose demands they answer
    context : an address that the second function is called with before all others, for both forms of limits;
        0 where there is none
    more : the address of a function that also takes what a call may have more; 0 where there is none
    supply : the cap [A] and the voltage [V] of such a call, checked, 0 for None; raises DemandError
    stated_residual : (k,) numbers that hold T P f - tau as the last call stated it
    needs : what must live as long as the allocator
    formulation, limited, tolerance, worst_case_steps : the allocator's promises
    levels : how many shares the functions write behind f
    state : whether a call changes data of the library, so that only one may run at a time
    together : gives the address of the C function that answers many demands side by side, 0 where there is
        none; asked at the first call that it can answer
    """
    library = _loaded(path)
    seen = find_formulation(formulation).subject(vehicle)
    nothing = np.zeros(vehicle.k)
    nothing.setflags(write=False)
    addresses = [ctypes.cast(library[name], ctypes.c_void_p).value for name in functions]
    objects = {
        "allocation": Allocation,
        "checked": checked,
        "checked_many": checked_many,
        "limits": at_call(seen, held=True),
        "limits_many": partial(limits_of, seen, held=True),
        "f_min": np.array(vehicle.f_min),  # copies: somebody's library may write into what it gets
        "f_max": np.array(vehicle.f_max),
        "statuses": tuple(Status),
        "iterations": 0,
        "solver_s": nan,
        "no_share": (),
        "residual": nothing if levels else (),
        "formulation": formulation,
        "limited": limited,
        "tolerance": tolerance,
        "worst_case_steps": worst_case_steps,
        "library": (library, needs),
        "together": together or _apart,
        "thrusts": thrusts,
        "supply": supply,
        "stated_residual": stated_residual,
        **_turning(vehicle),
    }
    numbers = (vehicle.k, vehicle.n, levels, state, NOTHING * vehicle.f_scale)
    made = cast(Allocator, _binding().Native(*addresses, context, more, *numbers, objects))
    return _WithResidual(made, vehicle, find_formulation(formulation)) if seen is not vehicle else made


def _turning(vehicle: Vehicle) -> dict[str, Any]:
    """Numbers out of which a call says forces and angles; None where no thruster turns."""
    if not vehicle.azimuths:
        return dict.fromkeys(("places", "rests", "middles"))
    _, rests, middles = polar(vehicle.azimuths, vehicle.actuators, [0.0] * vehicle.n, vehicle.f_scale)
    places = np.array([(*parts, -1)[:2] for parts in vehicle.actuators], dtype=np.intc)
    own = np.array(middles)
    own.setflags(write=False)
    return {"places": places, "rests": np.array(rests), "middles": own}


class _WithResidual:
    """A bound allocator that leaves out weak directions: its answers state what thrusts make along them."""

    def __init__(self, made: Allocator, vehicle: Vehicle, formulation: Formulation) -> None:
        """Wrap an allocator for a vehicle, of a formulation with a way."""
        self._made, self._vehicle = made, vehicle
        self._across = vehicle.TP - formulation.subject(vehicle).TP
        self._parts = formulation.parts(vehicle) if len(vehicle.mixture) > 1 else ()
        self.formulation, self.limited, self.tolerance = made.formulation, made.limited, made.tolerance
        self.worst_case_steps = made.worst_case_steps if isinstance(made, BoundedSteps) else None
        self.many = made.many
        self.stated_residual = getattr(made, "stated_residual", None)
        self._limits = at_call(vehicle.strong, held=True)

    def __call__(
        self,
        tau: ArrayLike,
        f_min: ArrayLike | None = None,
        f_max: ArrayLike | None = None,
        *more: ArrayLike,
        cap: float | None = None,
        **named: Any,
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within the limits of the call (n,) [N]."""
        if cap is not None:
            if self.stated_residual is None:
                raise no_cap(self.formulation)
            named["cap"] = cap
        found = self._made(tau, f_min, f_max, *more, **named)
        if not found.found:
            return found
        if not self._parts:
            return found._replace(residual=self._across @ found.f)
        wrench, limits = checked(tau, self._vehicle.k), self._limits(f_min, f_max)
        ends = [part.way.towards(wrench, part.way.departure(*limits))[0] for part in self._parts]
        end = mixed(ends, [part.w for part in self._parts])
        return found._replace(residual=self._vehicle.TP @ found.f - end)


def _loaded(path: Path) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise unloadable(path, error) from None


def _apart(limits: Where) -> int:
    """No function that answers demands side by side."""
    return 0


class _Together:
    """The libraries that answer demands side by side, each made at its first use."""

    def __init__(self, forms: Mapping[Where, Target]) -> None:
        """Bind a kernel for a vehicle, in both forms of limits."""
        self._forms = forms
        self._libraries: list[ctypes.CDLL] = []  # which must live as long as their functions

    def __call__(self, limits: Where) -> int:
        """The address of the function; 0 where there is none for this kernel or compiler."""
        target = self._forms.get(limits)
        made = side_by_side(target) if target and processor() else {}
        if not target or not made:
            return 0
        try:
            library = _loaded(shared_library(f"{target.method.name}_abreast", made, ABREAST_FLAGS))
        except NotInstalled:  # one demand after the other has the same answers
            return 0
        self._libraries.append(library)
        return ctypes.cast(library[f"{target.name}_abreast"], ctypes.c_void_p).value or 0


@cache
def _binding() -> Any:
    """The extension module of ``binding.c``, compiled for this Python and this numpy."""
    text = (resources.files("alloc.c") / "binding.c").read_text(encoding="utf-8")
    includes = [f"-I{folder}" for folder in (sysconfig.get_path("include"), np.get_include())]
    flags = [*includes, "-O3", f"-DLARGEST_DEMAND={LARGEST_DEMAND!r}", f"-DABREAST={COUNT}"]
    flags += NATIVE if processor() else ()
    suffix = f"-numpy{np.__version__}{sysconfig.get_config_var('EXT_SUFFIX')}"
    path = shared_library("thrustbench_binding", {"binding.c": text}, flags, suffix)
    loader = ExtensionFileLoader("thrustbench_binding", str(path))
    spec = importlib.util.spec_from_loader("thrustbench_binding", loader)
    assert spec is not None  # a loader was given
    try:
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
    except ImportError as error:
        raise unloadable(path, error) from None
    return module


def side_by_side(target: Target) -> dict[str, str]:
    """The C file of ``void <name>_abreast(…)``, as {file name: text}; none where a kernel is not straight.

    ``<name>_abreast(tau, f_min, f_max, step, f, status)`` answers COUNT demands that lie one behind the other
    as the kernel does; from one demand's limits to the next's are ``step`` numbers. Refused ones get AGAIN.
    """
    vehicle, limits = target.vehicle, target.limits
    program = target.method.program(vehicle, limits)
    if not program.straight:
        return {}
    k, n = vehicle.k, vehicle.n
    name = f"{target.name}_abreast"
    written = _Each(program, f"{name}_")
    given = [("tau", k, str(k))]
    if limits == "call":
        given += [("f_min", n, "step"), ("f_max", n, "step")]
    arrays = "".join(f"    double {array}_[{size}][{TOGETHER}];\n" for array, size, _ in given)
    soon = "".join(
        f"        fetch({array}, {size}, b, {step});\n" for array, size, step in [*given, ("f", n, str(n))]
    )
    moves = "".join(
        f"            {array}_[{j}][i] = {array}[(b + i) * {step} + {j}];\n"
        for array, size, step in given
        for j in range(size)
    )
    declaration = (
        f"void {name}(const double *tau, const double *f_min, const double *f_max, long step,\n"
        f"    double *f, signed char *status)"
    )
    out = "".join(f"f[(b + i) * {n} + {j}] = good ? f_[{j}][i] : (double)NAN;\n" for j in range(n))
    each = f"    for (int i = 0; i < {TOGETHER}; i++) {{\n"
    table, body = "\n".join([*written.table.define(), ""]), "\n".join(written.lines)
    return {
        f"{name}.c": f"""\
/* Generated by thrustbench: {COUNT} demands side by side. */
#include <math.h>
{helpers([program], "double")}{FETCH}
{declaration};

{declaration}
{{
{indent(table, "    ")}
{arrays}\
    double f_[{n}][{TOGETHER}], said[{TOGETHER}];

    (void)f_min;
    (void)f_max;
    (void)step;
    for (int b = 0; b < {COUNT}; b += {TOGETHER}) {{
{soon}\
    {each}{moves}        }}
    {each}{indent(body, " " * 12)}
        }}
    {each}\
            const int good = said[i] >= 0.0 && said[i] < {Status.INFEASIBLE}.0;
{indent(out, " " * 12)}\
            status[b + i] = (signed char)said[i];
        }}
    }}
}}
"""
    }


class _Each(Statements):
    """The statements for demand i of many: no branch, and what is refused is told by its status alone."""

    def argument(self, array: str, index: int) -> str:
        """An entry of demand i's argument."""
        return f"{array}_[{index}][i]"

    def status(self, node: Node) -> str:
        """The expression of a status, a number as all others."""
        match self.program.nodes[node]:
            case ("const", float(value)):
                return f"{value}"
            case ("choose", int(condition), int(a), int(b)):
                return f"(({self.expression(condition)}) ? {self.status(a)} : {self.status(b)})"
        raise AssertionError(self.program.nodes[node])

    def fence(self, step: Fence) -> None:
        """None: the order is the compiler's."""

    def write(self, step: Write) -> None:
        """Thrusts alone are asked for."""
        if step.array == "f":
            value = self.expression(self.program.outputs[step.array, step.index])
            self.lines.append(f"f_[{step.index}][i] = {value};")

    def leave(self, step: Exit) -> None:
        """Exit on a refusal, and whether it is known without a second look at all arguments."""
        cases = "".join(
            f"{known} ? {status}.0 : " for case, status in step.cases if (known := self._told(case))
        )
        self.refused += f"({self.expression(step.condition)}) ? ({cases}{AGAIN}.0) : "

    def branch(self, step: Branch) -> None:
        """Leave unlikely calls to the kernel for one demand."""
        self.refused += f"({self.expression(step.condition)}) ? {AGAIN}.0 : "
        for node in step.merged:
            self._names[node] = self.expression(self.program.nodes[node][3], ALONE)

    def _told(self, case: Node) -> str:
        """The part of a condition that looks at no array; empty where there is none."""
        match self.program.nodes[case]:
            case ("or", int(a), int(b)):
                return " || ".join(filter(None, (self._told(a), self._told(b))))
            case _:
                return "" if self.looks(case) else f"({self.expression(case)})"

    def finish(self) -> None:
        """The status, of a refused demand its reason's."""
        self.lines.append(f"said[i] = {self.refused}{self.status(self.program.status)};")
