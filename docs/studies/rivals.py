"""Answers of solvers' own C, checked and unchecked: ``python docs/studies/rivals.py fixed|call [N] [V]…``.

N demands a class (1,000) on each shipped vehicle, double and float, in C compiled for this machine. With
``call`` the limits are arguments: the same classes, and those whose demands have limits of their own. Beside
the answers that the check lets through stand the solver's own claims about the same demands, and thrusts as
it left them. Last comes, with ``fixed``, what the check costs on a Cortex-M7, counted; ``thrustbench
emulate`` counts the rest. The study prints tables of docs/rivals.md.
"""

import ctypes
import re
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from alloc import Label, NotApplicable, Status, Vehicle, build, list_vehicles, load_vehicle, rivals
from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.c.compiled import shared_library
from alloc.program import Scalar, Where
from alloc.rivals import Files
from alloc.rivals.generators import qoco
from alloc.rivals.wrapper import rival
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import SCALARS, build_kernel, unchecked
from bench.chips.processors import Processor, processor
from bench.chips.toolchain import missing
from bench.demands import build_demands
from bench.results.text import table, three

SETS: dict[Where, tuple[str, ...]] = {
    "fixed": ("inactive", "active", "infeasible"),
    "call": ("inactive", "active", "infeasible", "jolts", "sag", "slew"),
}
SEED = 16
FAR = 1e-2
"""Distance from the optimum beyond which an answer is a wrong one, relative to the largest limit [-]."""
OUTSIDE = 1e-4
"""Excess over a limit that counts, relative to the largest limit [-]: a thousand roundings of a float."""


class Outcomes(NamedTuple):
    """Results for demands off the boundary of the attainable set.

    Attributes
    ----------
    asked : demands
    unanswered : that can be met and get no thrusts
    met : that can't be met and are called met
    outside : answered with a thrust outside the limits, or one that is not finite
    far : other answers further than FAR from the optimum
    distance : largest distance of the rest from the optimum, relative to the largest limit [-]
    refused : that can't be met and are called infeasible; the others of these get no verdict
    """

    asked: int
    unanswered: int
    met: int
    outside: int
    far: int
    distance: float
    refused: int


def answers(
    solver: str, vehicle: Vehicle, scalar: Scalar, calls: FloatArray, limits: Where, *, checked: bool
) -> tuple[FloatArray, IndexArray]:
    """Thrusts (N, n) and statuses (N,) of a solver's C for calls (N, width), compiled for this machine.

    A call is a demand, with its limits where these are arguments.
    """
    made = rival(solver, vehicle, scalar, limits, checked=checked)
    k, n = vehicle.k, vehicle.n
    sides = f"call + {k}, call + {k + n}, " if limits == "call" else ""
    loop = f"""\
{made.declaration}
void ask(const {scalar} *call, {scalar} *F, int *status, long count);
void ask(const {scalar} *call, {scalar} *F, int *status, long count)
{{
    for (long i = 0; i < count; i++, call += {calls.shape[1]})
        status[i] = {made.entry}(call, {sides}F + i * {n});
}}
"""
    library = ctypes.CDLL(str(shared_library(solver, made.own | {"ask.c": loop}, shared=made.shared)))
    given = np.ascontiguousarray(calls, dtype=SCALARS[scalar])
    F = np.full((len(calls), vehicle.n), np.nan, dtype=given.dtype)
    status = np.empty(len(calls), dtype=np.intc)
    pointers = (array.ctypes.data_as(ctypes.c_void_p) for array in (given, F, status))
    library["ask"](*pointers, ctypes.c_long(len(calls)))
    return F.astype(np.float64), status.astype(np.intp)


def asked(vehicle: Vehicle, n: int, limits: Where) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Demands off the boundary, n of each class, with their limits, and which of them can be met."""
    parts = []
    for name in SETS[limits]:
        try:
            demands = build_demands(name, vehicle, SEED, n)
        except NotApplicable:  # no demand of this class exists for this vehicle
            continue
        sides = (np.broadcast_to(side, (len(demands.taus), vehicle.n)) for side in demands.limits)
        clear = demands.labels != Label.BOUNDARY
        each = (demands.taus, *sides, demands.labels != Label.INFEASIBLE)
        parts.append(tuple(array[clear] for array in each))
    taus, low, high, able = (np.concatenate(column) for column in zip(*parts, strict=True))
    return taus, low, high, able.astype(bool)


def tally(solver: str, vehicle: Vehicle, scalar: Scalar, n: int, limits: Where, *, checked: bool) -> Outcomes:
    """Ask n demands of each class, and hold the answers to the exact ones."""
    taus, low, high, able = asked(vehicle, n, limits)
    calls = np.hstack([taus, low, high]) if limits == "call" else taus
    F, status = answers(solver, vehicle, scalar, calls, limits, checked=checked)
    return outcomes(vehicle, taus, low, high, able, F, status)


def outcomes(
    vehicle: Vehicle,
    taus: FloatArray,
    low: FloatArray,
    high: FloatArray,
    able: BoolArray,
    F: FloatArray,
    status: IndexArray,
) -> Outcomes:
    """Thrusts (N, n) and statuses (N,) that answer what ``asked`` returns, held to the exact ones."""
    exact, _ = build("nullspace", vehicle).many(taus, low, high)
    answered = np.isin(status, (Status.SOLVED, Status.PARTIAL))
    beyond = np.maximum(F - high, low - F).max(axis=1) / vehicle.f_scale
    inside = beyond <= OUTSIDE  # NaN is not
    distance = np.abs(F - exact).max(axis=1) / vehicle.f_scale
    compared = answered & able & inside
    near = distance <= FAR
    return Outcomes(
        asked=len(taus),
        unanswered=int((able & ~answered).sum()),
        met=int((~able & (status == Status.SOLVED)).sum()),
        outside=int((answered & ~inside).sum()),
        far=int((compared & ~near).sum()),
        distance=float(distance[compared & near].max(initial=0.0)),
        refused=int((~able & (status == Status.INFEASIBLE)).sum()),
    )


def price(method: str, vehicle: Vehicle, board: Processor, scalar: Scalar) -> list[str]:
    """Cost of the check: instructions of a call that is answered and of one that is not, flash, stack."""
    sets = [build_demands(name, vehicle, SEED, 20) for name in ("active", "infeasible")]
    sizes: list[FloatArray] = []
    for kernel in (build_kernel(method, vehicle, scalar), unchecked(method, vehicle, scalar)):
        with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
            image = link(kernel, board, Path(folder))
            counts = [count(image, demands.taus) for demands in sets]
            means = [float(counted.instructions.mean()) for counted in counts]
            stack = max(int(counted.stack_bytes.max()) for counted in counts)
            sizes.append(np.array([*means, image.flash_bytes, stack]))
    checked, claimed = sizes
    return [three(size) for size in (checked - claimed).tolist()]


def stops(vehicle: Vehicle, n: int) -> list[list[str]]:
    """The share of n demands of a class that QOCO gives up on the later it stops; how near the others are."""
    generate, lines = qoco.generate, []
    for stop, kind in product(("1e-7", "1e-8", "1e-9"), ("inactive", "active")):
        taus = build_demands(kind, vehicle, SEED, n).taus
        with patch.object(qoco, "generate", lambda *given, stop=stop: _stopped(generate(*given), stop)):
            F, status = answers("qoco", vehicle, "double", taus, "fixed", checked=True)
        exact, _ = build("nullspace", vehicle).many(taus)
        there = np.isin(status, (Status.SOLVED, Status.PARTIAL))
        farthest = float(np.abs(F - exact)[there].max(initial=0.0)) / vehicle.f_scale
        lines.append([vehicle.name, kind, stop, f"{1 - there.mean():.0%}", three(farthest)])
    return lines


def _stopped(files: Files, stop: str) -> Files:
    text, found = re.subn(r"(settings\.(?:abs|rel)tol = )[^;]+", rf"\g<1>{stop}", files.own["utils.c"])
    assert found == 2
    return Files({**files.own, "utils.c": text}, files.shared)


def main(arguments: list[str]) -> None:
    """Print a table of answers that were checked, one of what the solvers claim, and one of the price."""
    limits: Where = "call" if arguments[0] == "call" else "fixed"
    n = int(arguments[1]) if arguments[1:] else 1000
    vehicles = [load_vehicle(name) for name in arguments[2:] or list_vehicles()]
    there = [name for name in rivals.names() if not rivals.load(name).missing()]
    scalars: tuple[Scalar, ...] = ("double", "float")
    for checked in (True, False):
        print("\nChecked:\n" if checked else "\nAs the solver claims:\n")
        lines = []
        for solver, scalar in product(there, scalars):
            own = [tally(solver, vehicle, scalar, n, limits, checked=checked) for vehicle in vehicles]
            *numbers, distance, refused = zip(*own, strict=True)
            sums = [str(sum(each)) for each in (*numbers, refused)]
            worst = int(np.argmax(distance))
            lines.append([solver, scalar, *sums, three(distance[worst]), vehicles[worst].name])
        *fields, distance_field, refused_field = Outcomes._fields
        headers = ("solver", "scalar", *fields, refused_field, distance_field, "on")
        print(table(headers, lines), flush=True)
    if "qoco" in there and limits == "fixed":
        told = [line for vehicle in vehicles for line in stops(vehicle, n)]
        headers = ("vehicle", "demands", "told to stop at", "given up", "farthest")
        print(f"\nQOCO:\n\n{table(headers, told)}", flush=True)
    board = processor("cortex-m7")
    if limits == "call" or missing(board):
        return
    headers = ("vehicle", "scalar", "answered", "refused", "flash [B]", "stack [B]")
    lines = [
        [vehicle.name, scalar, *price("qp/daqp@generated", vehicle, board, scalar)]
        for vehicle, scalar in product(vehicles, scalars)
    ]
    print(f"\nWhat the check around DAQP adds to a call on a {board.name}:\n\n{table(headers, lines)}")


if __name__ == "__main__":
    main(sys.argv[1:])
