"""The numbers of ``bench.layouts`` against the library's functions, one layout at a time, and what they cost.

``python docs/studies/layouts.py [STUDY.yaml …] [--n 1000]`` prints, for each column, by how much the numbers
of so many layouts of each study differ at most from those of ``alloc`` for the same layout as a vehicle file,
and the CPU time of each step, the least of several passes. Without a study it takes
docs/layouts/bluerov2-heavy.yaml. Qhull can't work out every closed form's volume; where it gives up, that
number is left out and counted.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np

from alloc import Vehicle, build, load_vehicle
from alloc.errors import SolverError
from alloc.files.textfile import write_text
from alloc.reach.attainable import single_axis_maxima
from alloc.reach.volumes import attainable_volume, closed_form_volume, safe_share, worst_fault
from alloc.reach.zonotope import zonotope
from alloc.vehicle.geometry import unit
from alloc.vehicle.text import to_yaml
from bench.judging.capability import remaining_authority
from bench.judging.loss import loss
from bench.layouts.authority import reach, safe_shares, volumes, worst_faults
from bench.layouts.best import vehicle_file
from bench.layouts.compile import compile_study
from bench.layouts.measure import measure
from bench.layouts.memory import keep_freed_memory
from bench.layouts.sampling import tasks, values
from bench.layouts.section import closed_form_volumes
from bench.layouts.served import shares
from bench.layouts.space import LayoutSpace, poses
from bench.layouts.spaces import spaces
from bench.layouts.study import read_study

STUDY = Path("docs/layouts/bluerov2-heavy.yaml")


def one_by_one(vehicle: Vehicle, space: LayoutSpace) -> dict[str, float]:
    """The numbers of a layout by the library's functions; NaN where rank or Qhull is lost."""
    whole, *_ = remaining_authority(vehicle)
    per_volume = (
        vehicle.row_lengths.prod() / space.volume
    )  # the library's volumes are over its own row lengths
    worst = vehicle.with_fault(worst_fault(vehicle))
    pairs = [vehicle.with_fault(i).with_fault(j) for i, j in combinations(range(vehicle.n), 2)]
    sizes = [attainable_volume(pair) if pair.rank == vehicle.k else 0.0 for pair in pairs]
    rank_after_two, after_two = min(zip((pair.rank for pair in pairs), sizes, strict=True))
    z = zonotope(vehicle)
    normals = z.facets / z.scale * space.scale
    closed, exact = build("pinv", vehicle), build("nullspace", vehicle)
    F, best = closed.many(space.taus)[0], exact.many(space.taus)[0]
    served, least = loss(vehicle, space.taus, F, best), loss(vehicle, space.taus, best, best)
    try:
        form = closed_form_volume(vehicle) / attainable_volume(vehicle)
    except SolverError:
        form = np.nan
    effort = np.einsum("ij,jk,ik->i", best, vehicle.H, best)
    numbers = {
        "authority": attainable_volume(vehicle) * per_volume,
        "authority_after_one": attainable_volume(worst) * per_volume if worst.rank == vehicle.k else 0.0,
        "rank_after_one": worst.rank,
        "authority_after_two": after_two * per_volume,
        "rank_after_two": rank_after_two,
        "condition": whole.condition or np.nan,
        "safe_share": safe_share(vehicle),
        "any_direction_N": float((z.support / np.linalg.norm(normals, axis=1)).min()),
        "closed_form_volume_share": form,
        "closed_form_served_share": served["within_1pct_share"] or 0.0,
        "exact_served_share": least["within_1pct_share"] or 0.0,
        "exact_effort_N2": float(np.nanmean(effort)) if np.isfinite(effort).any() else np.nan,
        "worst_case_steps": float(getattr(exact, "worst_case_steps", np.nan)),
    }
    for axis, low, high in zip(vehicle.dof, *single_axis_maxima(vehicle), strict=True):
        numbers |= {f"{axis}_min_{unit(axis).replace(' ', '')}": low}
        numbers |= {f"{axis}_max_{unit(axis).replace(' ', '')}": high}
    return numbers


def differences(space: LayoutSpace, n: int) -> tuple[dict[str, float], int, int]:
    """Largest relative difference of each column over n layouts; where Qhull gave up; how many there were."""
    parameters = values(space, tasks(0, n, "sobol", 1)[0])[:, :n]
    counted = measure(space, parameters)
    worst: dict[str, float] = {}
    lost = 0
    with tempfile.TemporaryDirectory() as folder:
        for row, column in enumerate(counted.kept):
            settings = {
                p.name: float(v) for p, v in zip(space.parameters, parameters[:, column], strict=True)
            }
            numbers = {name: float(entries[row]) for name, entries in counted.columns.items()}
            path = Path(folder) / "layout.yaml"
            write_text(
                path, to_yaml(vehicle_file(space, {**settings, **numbers, "round": 0, "layout": column}))
            )
            for name, alone in one_by_one(load_vehicle(path), space).items():
                if np.isnan(alone):
                    lost += name == "closed_form_volume_share"
                    continue
                off = abs(numbers[name] - alone) / max(abs(alone), 1e-300) if numbers[name] != alone else 0.0
                worst[name] = max(worst.get(name, 0.0), off)
    return worst, lost, len(counted.kept)


def times(space: LayoutSpace, n: int = 2048, passes: int = 7) -> dict[str, float]:
    """CPU time of each step [us a layout]: of 512 layouts at a time, the least of several passes."""
    (group,) = poses(space, values(space, tasks(0, n, "sobol", 1)[0]))
    every = group.layouts(space.dof)
    spent: dict[str, list[float]] = {}

    for _ in range(passes):
        for first in range(0, n, 512):
            some = every.take(slice(first, first + 512))
            full, found = spaces(some)
            assert full.all()
            sizes = volumes(some, found)
            steps: dict[str, Callable[[], object]] = {
                "rank, condition, T*, null space": partial(spaces, some),
                "volume, whole and after each failure": partial(volumes, some, found),
                "worst single and double failure": partial(worst_faults, some, found, sizes),
                "maxima": partial(reach, some, found, space.scale),
                "safe share": partial(safe_shares, some, found),
                f"shares of {len(space.taus)} demands": partial(shares, some, found, space.taus),
                "closed form's volume": partial(closed_form_volumes, some, found),
            }
            for name, step in steps.items():
                began = time.process_time()
                step()
                spent.setdefault(name, []).append(time.process_time() - began)
    parts = n // 512
    return {
        name: float(np.array(seconds).reshape(passes, parts).sum(axis=1).min()) / n * 1e6
        for name, seconds in spent.items()
    }


def main() -> None:
    """Print both tables of each study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("studies", nargs="*", type=Path, default=[STUDY])
    parser.add_argument("--n", type=int, default=1000)
    asked = parser.parse_args()
    for path in asked.studies:
        space, _ = compile_study(read_study(path))
        keep_freed_memory()
        worst, lost, kept = differences(space, asked.n)
        print(f"\n{path}: {kept} layouts, largest relative difference from one by one ({lost} without Qhull)")
        for name, off in worst.items():
            print(f"  {name:28s} {off:.1e}")
        print(f"{path}: CPU time [µs a layout]")
        spent = times(space)
        for name, us in spent.items():
            print(f"  {name:40s} {us:6.1f}")
        print(f"  {'together':40s} {sum(spent.values()):6.1f}")


if __name__ == "__main__":
    main()
