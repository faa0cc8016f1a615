"""Every method over random vehicles: ``python docs/studies/campaign.py FILE --vehicles 10000``.

Each vehicle has something odd (``odd_vehicle``), in every fourth a thruster is off, and its demands lie
inside, on the edge of and beyond what it can do, within its own limits or within others. Of every answer is
asked: is SOLVED met inside the limits, is INFEASIBLE true, did nothing raise or warn, is SOLVED as near to
the exact optimum as promised, do shares say what thrusts make, and have calls the status that ``many`` has?
``--near`` takes vehicles that are symmetric but for their last digits (``near_degenerate``). A demand counts
as attainable where it was made of thrusts inside the limits, or where the facets say so. Some calls are made
again after all others: some solvers then give another status. Each vehicle is seeded, and FILE takes a line
for each lot of vehicles, so that a study that was stopped goes on where FILE ends.
"""

import json
import warnings
from collections import Counter
from pathlib import Path

import click
import numpy as np
from tabulate import tabulate

from alloc import Allocation, NotApplicable, Status, Vehicle, build, catalogue, solvers
from alloc.allocation import WRENCH_TOLERANCE, FloatArray
from alloc.discovery import Entry
from alloc.formulations import Family, find_formulation
from bench.demands.generated import DEMANDS, DemandsAsked, drawn_demands, generate_vehicle, numbered

LOT = 50
"""Vehicles of one line; generated C, which has to be compiled, is asked on the first of each lot."""
QUICK, SLOW, ONE_SHOT = 10, 3, 1
"""Demands that are asked of a quick solver, of a slow one, and of one that is built anew for each."""
SLOW_SOLVERS = ("cvxopt", "highs", "osqp", "qtqp", "scs", "sip")
"""These take a millisecond and more where they run to their caps."""
SPARE = 5
"""Slow solvers, and those that are built anew for each call, are asked on one vehicle of so many."""
SINGLE = 3
"""Demands that are asked in single calls too."""
HARMLESS = ("answers", "refused", "not converged, attainable", "another status after other calls")
"""Counts of answers that are not wrong."""


def judged(vehicle: Vehicle, name: str, sets: list[DemandsAsked], count: int) -> dict[str, int]:
    """Faults of answers to the first ``count`` demands of each set, and their number."""
    found = Counter[str]()
    try:
        allocate = build(name, vehicle)
    except NotApplicable:
        return {"refused": 1}
    single, hard = allocate, allocate.formulation == "hard"
    for of in sets:
        if hasattr(allocate, "solve"):  # a solver may carry something over: calls and many begin alike
            allocate, single = build(name, vehicle), build(name, vehicle)
        limits = of.limits(count)
        taus, low, high = of.taus[:count], of.low[:count], of.high[:count]
        F, status = allocate.many(taus, *limits)
        found["answers"] += len(taus)
        finite = np.isfinite(F).all(axis=1)
        miss = np.abs(F @ vehicle.TP.T - taus)
        met = (miss <= WRENCH_TOLERANCE * 1.01 * vehicle.wrench_scale).all(axis=1)
        kept = ((low <= F) & (high >= F)).all(axis=1)
        solved, attainable = status == Status.SOLVED, of.attainable[:count]
        answered = solved | (status == Status.PARTIAL)
        found["SOLVED, not met"] += int((solved & ~met).sum())
        found["finite or not, against its status"] += int((finite != answered).sum())
        found["outside limits"] += int((finite & ~kept).sum()) if allocate.limited else 0
        found["false INFEASIBLE"] += int(((status == Status.INFEASIBLE) & attainable).sum())
        found["not converged, attainable"] += int(((status == Status.NOT_CONVERGED) & attainable).sum())
        if hard:
            distance = np.abs(F - of.optimum[:count]).max(axis=1) / vehicle.f_scale
            found["farther than promised"] += int((solved & (distance > allocate.tolerance + of.doubt)).sum())
        for i in range(min(SINGLE, count)):
            call = taus[i], *(side[i] for side in limits)
            answer = single(*call)
            found["one call, not many"] += int(answer.status != status[i])
            found["shares not delivered"] += int(not delivers(vehicle, allocate.formulation, answer, *call))
            found["another status after other calls"] += int(allocate(*call).status != status[i])
    return {what: number for what, number in found.items() if number}


def delivers(
    vehicle: Vehicle, formulation: str, answer: Allocation, tau: FloatArray, *limits: FloatArray
) -> bool:
    """True if thrusts make what the shares say, where an answer says any."""
    way_of = find_formulation(formulation).way
    if way_of is None or not answer.found:
        return True
    way, ends = way_of(vehicle), limits or (vehicle.f_min, vehicle.f_max)
    says = way.delivered(tau[None], way.departure(*ends), np.array([answer.share]))[0]
    off = np.abs(vehicle.TP @ answer.f - says) / vehicle.wrench_scale
    return bool((off <= WRENCH_TOLERANCE).all())


def demands_of(entry: Entry, number: int) -> int:
    """Number of demands of each set for a method on the vehicle of that number."""
    if (entry.twin or entry.family is Family.GENERATED) and number % LOT:
        return 0
    if not entry.solver:
        return DEMANDS
    slow = entry.solver in SLOW_SOLVERS
    if (slow or entry.family is Family.ONE_SHOT) and number % SPARE:
        return 0
    return ONE_SHOT if entry.family is Family.ONE_SHOT else SLOW if slow else QUICK


def lot(numbers: range, entries: list[Entry], near: bool = False, most: int = DEMANDS) -> dict[str, object]:
    """Results of methods on the vehicles of these numbers, as a line of the file."""
    total: dict[str, Counter[str]] = {}
    first: dict[str, str] = {}
    solvers.disbelieved.clear()
    for number in numbers:
        vehicle, rng = (numbered if near else generate_vehicle)(number)
        sets = drawn_demands(vehicle, rng)
        for entry in entries:
            if not (count := min(demands_of(entry, number), most)):
                continue
            try:
                found = judged(vehicle, entry.name, sets, count)
            except Exception as error:
                found = {f"{type(error).__name__}: {str(error)[:60]}": 1}
            total.setdefault(entry.name, Counter()).update(found)
            for what in set(found) - set(HARMLESS):
                first.setdefault(f"{entry.name}: {what}", f"vehicle {number}")
    return {
        "vehicles": [numbers.start, numbers.stop],
        "found": total,
        "first": first,
        "disbelieved": solvers.disbelieved,
    }


@click.command()
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--vehicles", default=10_000, show_default=True)
@click.option("--method", "only", multiple=True, help="Only these.")
@click.option("--near", is_flag=True, help="Vehicles that are nearly symmetric.")
@click.option("--demands", "most", default=DEMANDS, help="At most so many demands of each set.")
def main(file: Path, vehicles: int, only: tuple[str, ...], near: bool, most: int) -> None:
    """Append to FILE what is wrong, lot by lot; then print all of FILE by method."""
    warnings.simplefilter("error")
    entries = [e for e in catalogue() if not e.missing and (not only or e.name in only)]
    lines = (
        [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []
    )
    for start in range(lines[-1]["vehicles"][1] if lines else 0, vehicles, LOT):
        line = lot(range(start, min(start + LOT, vehicles)), entries, near, most)
        with file.open("a", encoding="utf-8") as out:
            out.write(json.dumps(line) + "\n")
        lines.append(json.loads(json.dumps(line)))
    total: dict[str, Counter[str]] = {}
    disbelieved, first = Counter[str](), dict[str, str]()
    for line in lines:
        for name, found in line["found"].items():
            total.setdefault(name, Counter()).update(found)
        disbelieved.update(line["disbelieved"])
        first = line["first"] | first
    wrongs = sorted({what for found in total.values() for what in found} - {"answers"})
    rows = [
        [name, f"{found['answers']:,}", *(found[what] for what in wrongs)] for name, found in total.items()
    ]
    click.echo(tabulate(rows, ["method", "answers", *wrongs], tablefmt="github"))
    answers = sum(found["answers"] for found in total.values())
    click.echo(f"{lines[-1]['vehicles'][1]:,} vehicles, {answers:,} answers")
    click.echo(json.dumps({"first": first, "disbelieved": disbelieved}, indent=1))


if __name__ == "__main__":
    main()
