"""Answers on nearly symmetric vehicles against their equation: ``python docs/studies/near_degenerate.py F``.

Vehicles are symmetric but for their last digits (``bench.demands.generated``), demands lie on the edges
of what they can do. An answer says which wrench its thrusts make: SOLVED all of the demand, PARTIAL what its
shares make of it. How far T f is from that, in parts of ``wrench_scale``, is counted for methods in Python,
one call at a time and many at once, and for their C: double and float, limits of the vehicle and of the call.
C is calculated operation by operation by ``alloc.program.evaluate``; on every ``--c``-th vehicle it is
compiled too, and must answer with the same bits. What has a loop over data is compiled only, on all vehicles.
File F takes a line for each vehicle, so that a study goes on where F ends.
"""

import ctypes
import json
import subprocess
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray
from tabulate import tabulate

from alloc import NotApplicable, Status, Vehicle, build
from alloc.allocation import FloatArray
from alloc.c.compiled import compiler
from alloc.c.generate import sources
from alloc.c.target import Target
from alloc.formulations import find_formulation
from alloc.kernels.tolerance import WRENCH_ERROR
from alloc.methods import recipe, recipes
from alloc.program import Evaluated, Scalar, Where, evaluate
from bench.demands.generated import edge_demands, numbered

METHODS = ("nullspace", "scaled", "scaled-by-group", "priority", "redistribute", "clip", "shrink")
ROUNDING = 1e-15
"""Share that rounding takes of T f, which this study works out, relative to ``wrench_scale`` [-]."""


def most(scalar: Scalar) -> float:
    """The largest error that is not counted: what SOLVED may miss."""
    return WRENCH_ERROR[scalar] + ROUNDING


def errors(
    vehicle: Vehicle,
    formulation: str,
    taus: FloatArray,
    F: FloatArray,
    status: NDArray[np.integer[Any]],
    shares: FloatArray,
) -> FloatArray:
    """Largest error of a wrench of each answer that says one, relative to ``wrench_scale``."""
    says, made = taus, status == Status.SOLVED
    way_of = find_formulation(formulation).way
    if way_of is not None and shares.size:
        way = way_of(vehicle)
        says = way.delivered(taus, way.departure(vehicle.f_min, vehicle.f_max), shares)
        made |= status == Status.PARTIAL
    off: FloatArray = (np.abs(F @ vehicle.TP.T - says) / vehicle.wrench_scale).max(axis=1)[made]
    return np.nan_to_num(off, nan=np.inf)


def in_python(vehicle: Vehicle, method: str, taus: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Errors of single calls, and of SOLVED answers of many demands at once."""
    allocate = build(method, vehicle)
    answers = [allocate(tau) for tau in taus]
    F = np.array([answer.f for answer in answers])
    status = np.array([answer.status for answer in answers])
    shares = np.array([answer.share for answer in answers])
    yield "Python", errors(vehicle, allocate.formulation, taus, F, status, shares)
    F, status = allocate.many(taus)
    yield "Python, many", errors(vehicle, allocate.formulation, taus, F, status, np.zeros((0, 0)))


def in_c(
    vehicle: Vehicle, method: str, taus: FloatArray, scalar: Scalar, limits: Where, c: bool, folder: Path
) -> FloatArray:
    """Errors of generated C, compiled in the folder where it must be, or shall be too."""
    kernel = recipe(method)
    program = kernel.program(vehicle, limits, scalar)
    kind: Any = np.float32 if scalar == "float" else np.float64
    taus = taus.astype(kind)
    ends = [np.tile(side, (len(taus), 1)).astype(kind) for side in (vehicle.f_min, vehicle.f_max)]
    given = ends if limits == "call" else []
    answers = []
    if not program.loops:
        answers.append(evaluate(program, taus, *given))
    if c or program.loops:
        target = Target(vehicle=vehicle, method=kernel, scalar=scalar, limits=limits, faults="none")
        answers.append(compiled(target, taus, given, folder))
    first, found = answers[0], answers[-1]
    thrusts = first.status < Status.INFEASIBLE
    np.testing.assert_array_equal(first.status, found.status)
    np.testing.assert_array_equal(first.F[thrusts], found.F[thrusts])
    return errors(vehicle, kernel.formulation, taus.astype(float), found.F, found.status, found.share)


def compiled(target: Target, taus: NDArray[Any], ends: list[NDArray[Any]], folder: Path) -> Evaluated:
    """Answers of the C."""
    vehicle, kernel, name = target.vehicle, target.method, target.name
    for file, text in sources(target).items():
        (folder / file).write_text(text)
    # A new file may have the inode of one that is gone, and would be taken for that.
    library = folder / f"{len(list(folder.iterdir()))}.so"
    subprocess.run(
        [*compiler(), "-std=c99", "-O0", "-fPIC", "-shared", f"{folder / name}.c", "-o", str(library)],
        check=True,
    )
    function = getattr(ctypes.CDLL(str(library)), name)

    def at(array: NDArray[Any]) -> Any:
        return array.ctypes.data_as(ctypes.c_void_p)

    F = np.full((len(taus), vehicle.n), np.nan, taus.dtype)
    shares = np.full((len(taus), kernel.levels(vehicle)), np.nan, taus.dtype)
    status = [
        function(at(tau), *(at(side[i]) for side in ends), -1, at(f), *([at(share)] if share.size else []))
        for i, (tau, f, share) in enumerate(zip(taus, F, shares, strict=True))
    ]
    return Evaluated(F.astype(float), np.array(status, dtype=np.int8), shares.astype(float))


def asked(number: int, count: int, c: bool, folder: Path, only: str | None) -> dict[str, list[float]]:
    """By method and where it runs: answers that say a wrench, those that are off, the largest error."""
    vehicle, rng = numbered(number)
    taus, found = edge_demands(vehicle, rng, count), dict[str, list[float]]()

    def count_(method: str, where: str, at_most: float, off: FloatArray) -> None:
        found[f"{method}|{where}"] = [len(off), int((off > at_most).sum()), float(off.max(initial=0.0))]

    for method in METHODS if only != "c" else ():
        try:
            for where, off in in_python(vehicle, method, taus):
                count_(method, where, most("double"), off)
        except NotApplicable:
            found[f"{method}|refused"] = [1, 0, 0.0]
    scalars: tuple[Scalar, ...] = ("double", "float")
    places: tuple[Where, ...] = ("fixed", "call")
    in_c_too = [method for method in METHODS if method in recipes() and only != "python"]
    for method, scalar, limits in product(in_c_too, scalars, places):
        try:
            answered = in_c(vehicle, method, taus, scalar, limits, c, folder)
            count_(method, f"C, {scalar}, {limits}", most(scalar), answered)
        except NotApplicable:
            found[f"{method}|C, {scalar}, {limits}, refused"] = [1, 0, 0.0]
    return found


@click.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--vehicles", default=1000, show_default=True)
@click.option("--demands", default=1000, show_default=True)
@click.option("--c", default=10, show_default=True, help="C is compiled on every so many vehicles.")
@click.option("--thrusters", default=99, help="Vehicles with more are left out.")
@click.option("--only", type=click.Choice(["python", "c"]), help="Leave the other out.")
def main(file: Path, vehicles: int, demands: int, c: int, thrusters: int, only: str | None) -> None:
    """Append what is found to FILE, vehicle by vehicle, and print the table of all of FILE."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    with TemporaryDirectory() as folder, file.open("a", encoding="utf-8") as out:
        for number in range(len(lines), vehicles):
            left_out = numbered(number)[0].n > thrusters
            found = {} if left_out else asked(number, demands, number % c == 0, Path(folder), only)
            lines.append(json.dumps(found))
            out.write(lines[-1] + "\n")
            out.flush()
    total: dict[str, list[list[float]]] = {}
    for line in lines:
        for key, row in json.loads(line).items():
            total.setdefault(key, []).append(row)
    rows = [
        [
            *key.split("|"),
            len(found),
            f"{sum(row[0] for row in found):,.0f}",
            max(row[2] for row in found),
            str(int(sum(row[1] for row in found))),
        ]
        for key, found in sorted(total.items())
    ]
    headers = ["method", "where", "vehicles", "answers", "largest error", "off"]
    click.echo(tabulate(rows, headers, tablefmt="github", floatfmt=".1e"))


if __name__ == "__main__":
    main()
