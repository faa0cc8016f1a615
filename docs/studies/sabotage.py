"""How many breaks of generated C a proof finds: ``python docs/studies/sabotage.py [VEHICLE]...``.

All of ``sabotages.py``, for these vehicles, else for every shipped one, in double and float.
Numbers of docs/proof.md; ``make prove`` runs it. Exit code 1 where one was not found.
"""

import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from os import cpu_count
from pathlib import Path

from alloc import list_vehicles, load_vehicle
from alloc.program import Scalar
from bench.proof import subject
from sabotages import SABOTAGES, Sabotage, noticed, sabotaged

SCALARS: tuple[Scalar, ...] = ("double", "float")


def found(sabotage: Sabotage, vehicle: str, scalar: Scalar) -> bool | None:
    """True if a proof notices; None where the C has nothing of the kind to break."""
    try:
        of = sabotaged(subject(load_vehicle(vehicle), sabotage.kernel, scalar, sabotage.limits), sabotage)
    except ValueError:
        return None
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        return bool(noticed(of, Path(folder)))


def main(vehicles: list[str]) -> int:
    """Print a line a sabotage."""
    missed = total = 0
    cases = [(vehicle, scalar) for vehicle in vehicles or list_vehicles() for scalar in SCALARS]
    with ProcessPoolExecutor(cpu_count()) as pool:
        for sabotage in SABOTAGES:
            results = list(pool.map(partial(found, sabotage), *zip(*cases, strict=True)))
            tried = [result for result in results if result is not None]
            print(
                f"{sum(tried):3d} of {len(tried):3d}  {sabotage.kernel}, {sabotage.limits}: {sabotage.name}",
                flush=True,
            )
            missed, total = missed + tried.count(False), total + len(tried)
    print(f"{total - missed} of {total} found")
    return int(missed > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
