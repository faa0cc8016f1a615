"""Every method over random vehicles: ``python -m bench.studies.campaign --minutes 10``.

Each vehicle has something odd (``odd_vehicles``), and its demands lie inside, on the edge of and beyond what
it can do, within its own limits or within others. Of every answer is asked: is SOLVED met inside the limits,
is INFEASIBLE true, did nothing raise or warn, and has one call the status that ``many`` has? Generated C,
which has to be compiled for each vehicle, is left out unless it is named.
"""

import json
import warnings
from collections import Counter
from itertools import count
from time import monotonic

import click
import numpy as np
from tabulate import tabulate

from alloc import (
    WRENCH_TOLERANCE,
    FloatArray,
    NotApplicable,
    Status,
    Vehicle,
    alpha_range,
    build,
    catalogue,
    solvers,
)
from bench.demands.sets.jolts import within
from bench.studies.odd_vehicles import inside, odd_vehicle

SINGLE = 20
"""Demands of a vehicle that are asked in single calls too."""
EDGE = 1e-6
"""Share by which a demand must lie inside the edge to count as attainable."""

Limits = tuple[FloatArray, FloatArray] | None


def judged(vehicle: Vehicle, name: str, taus: FloatArray, limits: Limits) -> Counter[str]:
    """What is wrong with a method's answers, and how many there are."""
    allocate, found = build(name, vehicle), Counter[str]()
    low, high = (vehicle.f_min, vehicle.f_max) if limits is None else limits
    F, status = allocate.many(taus, *(limits or ()))
    found["answers"] = len(taus)
    finite = np.isfinite(F).all(axis=1)
    met = (np.abs(F @ vehicle.TP.T - taus) <= WRENCH_TOLERANCE * 1.01 * vehicle.wrench_scale).all(axis=1)
    kept = ((low <= F) & (high >= F)).all(axis=1)
    solved = status == Status.SOLVED
    found["SOLVED, not met"] = int((solved & ~met).sum()) if allocate.formulation != "soft" else 0
    found["outside limits"] = int((finite & ~kept).sum()) if allocate.limited else 0
    least, most = alpha_range(vehicle, taus, *(limits or ()))
    attainable = (least <= 1 - EDGE) & (most >= 1 + EDGE)
    found["false INFEASIBLE"] = int(((status == Status.INFEASIBLE) & attainable).sum())
    found["not converged, attainable"] = int(((status == Status.NOT_CONVERGED) & attainable).sum())
    for i in range(min(SINGLE, len(taus))):
        answer = allocate(taus[i], *((low[i], high[i]) if limits else ()))
        found["one call, not many"] += int(answer.status != status[i])
    return found


@click.command()
@click.option("--minutes", default=10.0, show_default=True)
@click.option("--demands", default=100, show_default=True, help="Of each vehicle.")
@click.option("--seed", default=0, show_default=True, help="Of the first vehicle.")
@click.option("--method", "only", multiple=True, help="Only these.")
def main(minutes: float, demands: int, seed: int, only: tuple[str, ...]) -> None:
    """Print what is wrong by method, and the first vehicle on which it is."""
    warnings.simplefilter("error")
    names = [e.name for e in catalogue() if not e.missing and (e.name in only if only else not e.twin)]
    total: dict[str, Counter[str]] = {name: Counter() for name in names}
    first: dict[str, str] = {}
    end, vehicles = monotonic() + 60 * minutes, 0
    for number in count(seed):
        if monotonic() > end:
            break
        rng = np.random.default_rng([2004, number])
        vehicle = odd_vehicle(rng)
        vehicles += 1
        taus = inside(vehicle, rng, demands) * rng.choice([1.0, 1 - 1e-5, 0.5, 1 + 1e-5, 2.0], (demands, 1))
        moving = within(vehicle, rng, demands)
        for name in names:
            for kind, (asked, limits) in {"own": (taus, None), "moving": (moving[0], moving[1:])}.items():
                try:
                    found = judged(vehicle, name, asked, limits)
                except NotApplicable:
                    found = Counter({"refused": 1})
                except Exception as error:
                    found = Counter({f"{type(error).__name__}: {str(error)[:60]}": 1})
                total[name] += found
                for what in set(found) - {"answers", "refused", "not converged, attainable"}:
                    if found[what]:
                        first.setdefault(f"{name}: {what}", f"vehicle {number}, {kind} limits")
    wrongs = sorted({what for found in total.values() for what in found if found[what]} - {"answers"})
    rows = [
        [name, f"{found['answers']:,}", *(found[what] for what in wrongs)] for name, found in total.items()
    ]
    click.echo(tabulate(rows, ["method", "answers", *wrongs], tablefmt="github"))
    click.echo(f"{vehicles:,} vehicles, {sum(found['answers'] for found in total.values()):,} answers")
    click.echo(json.dumps(first, indent=1))
    click.echo(json.dumps(solvers.disbelieved, indent=1))


if __name__ == "__main__":
    main()
