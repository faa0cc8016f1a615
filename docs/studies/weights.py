"""What uneven weights cost each solver: ``python docs/studies/weights.py``, the table of docs/solvers.md.

Random vehicles, whose H is diagonal or full with weights from 1 up to 1e8 apart, are asked demands that
random thrusts inside their limits push. Each answer is held against the exact method's.
"""

import click
import numpy as np
from tabulate import tabulate

from alloc import Status, build, catalogue, solvers
from alloc.formulations import Family
from bench.demands.odd_vehicles import inside, odd_vehicle, weighted

SPREADS = (0, 2, 4, 6, 8)
"""Decimal powers by which the largest weight exceeds the least."""


@click.command()
@click.option("--vehicles", default=20, show_default=True)
@click.option("--demands", default=100, show_default=True)
@click.option("--full", is_flag=True, help="Full H, not diagonal.")
@click.option("--only", default="", help="Only this method.")
@click.option("--shared", type=float, help="In place of SHARED, for all solvers.")
def main(vehicles: int, demands: int, full: bool, only: str, shared: float | None) -> None:
    """Print by solver and spread: not solved, called infeasible, farther than promised; the farthest."""
    if shared is not None:
        for solver in solvers.all_solvers().values():
            setattr(solver, "SHARED", shared)  # noqa: B010 - most solvers state none
    rows = []
    names = [e.name for e in catalogue() if e.family is Family.LIVE and not e.missing]
    for name in [only] if only else names:
        row: list[str] = [name]
        for decades in SPREADS:
            failed = false = far = 0
            farthest = 0.0
            solvers.disbelieved.clear()
            for seed in range(vehicles):
                rng = np.random.default_rng([seed, decades, full])
                vehicle = weighted(odd_vehicle(rng), rng, decades, full)
                taus = inside(vehicle, rng, demands)
                exact, known = build("nullspace", vehicle).many(taus)
                allocate = build(name, vehicle)
                F, status = allocate.many(taus)
                failed += int(np.count_nonzero(status != Status.SOLVED))
                compared = (status == Status.SOLVED) & (known == Status.SOLVED)
                distance = np.abs(F - exact)[compared].max(axis=1, initial=0.0) / vehicle.f_scale
                far += int(np.count_nonzero(distance > allocate.tolerance))
                farthest = max(farthest, float(distance.max(initial=0.0)))
            false = sum(count for what, count in solvers.disbelieved.items() if "INFEASIBLE" in what)
            row.append(f"{failed}, {false}, {far}; {farthest:.0e}")
        rows.append(row)
        click.echo(tabulate(rows[-1:], tablefmt="plain"))
    headers = ["method", *(f"1e{decades}" for decades in SPREADS)]
    click.echo(tabulate(rows, headers, tablefmt="github"))


if __name__ == "__main__":
    main()
