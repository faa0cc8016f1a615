"""Cost of a tape measure's errors where axes are nearly lost: drawings, surveys, failures.

``python docs/studies/weak_axes.py [--surveys N] [--demands N]`` prints the three tables of
docs/weak-axes.md: demands on drawings and on surveys of them; sigma / epsilon of lost and of other
directions; and what scaled delivers on surveys of what it delivers on the drawing, along demands that the
drawing's thrusters push.
"""

import argparse
from dataclasses import replace

import numpy as np

from alloc import Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.weak import DRAWN, Survey
from bench.demands.surveys import fail_thrusters, failures, hexarotor, move_poses, pushable_demands

TOLERANCES = (Survey(0.5, 0.05), DRAWN, Survey(5.0, 0.5), Survey(10.0, 0.5))
ASKED: tuple[tuple[str, tuple[int, ...], dict[str, float]], ...] = (
    ("bluerov2-heavy", (4, 5), {"heave": 40.0}),
    ("bluerov2-heavy", (0, 3), {"surge": 30.0, "heave": 20.0}),
    ("hexarotor", (0, 3), {"heave": -20.0, "roll": 0.2}),
)
CLEAR = 0.2
"""Least sigma / sigma_max of the directions that a drawing pushes, for it to count in the goal."""


def drawings() -> dict[str, Vehicle]:
    """The vehicles of the study."""
    names = ("bluerov2", "bluerov2-heavy", "nautilus", "subjugator8")
    return {name: load_vehicle(name) for name in names} | {"hexarotor": hexarotor()}


def asked() -> None:
    """Print what demands get on a drawing, and on a survey with weak directions left out and without."""
    print("| vehicle, thrusters off | demand | drawing | survey, weak: 0 | survey |\n|---|---|---|---|---|")
    rng = np.random.default_rng(2)
    for name, off, demand in ASKED:
        drawing = drawings()[name]
        found = move_poses(drawing, DRAWN, rng)
        tau = np.array([demand.get(axis, 0.0) for axis in drawing.dof])
        cells = []
        for vehicle in (drawing, replace(found, weak_limit=0.0), found):
            degraded = fail_thrusters(vehicle, off)
            f = build("scaled", degraded)(tau).f
            made = degraded.T @ f
            cells.append(", ".join(f"{made[drawing.dof.index(axis)]:.3g}" for axis in demand))
        words = ", ".join(f"{axis} {value:g}" for axis, value in demand.items())
        print(f"| {name}, {' and '.join(map(str, off))} | {words} | {' | '.join(cells)} |")


def apart(surveys: int) -> None:
    """Print sigma / epsilon of directions that the drawing lost, at most, and of all others, at least."""
    names = ("bluerov2", "bluerov2-heavy", "hexarotor")
    print(
        f"\n| tolerance | lost on the drawing, at most: {', '.join(names)} | all others, at least |"
        "\n|---|---|---|"
    )
    rng = np.random.default_rng(1)
    for survey in TOLERANCES[1:3]:
        lost, others = dict.fromkeys(names, 0.0), dict.fromkeys(names, np.inf)
        for name in names:
            drawing = replace(drawings()[name], survey=survey)
            for off in failures(drawing, 2):
                rank = fail_thrusters(drawing, off).rank
                for _ in range(surveys):
                    found = fail_thrusters(move_poses(drawing, survey, rng), off).directions
                    ratio = found.sigma / found.epsilon
                    lost[name] = max(lost[name], ratio[rank:].max(initial=0.0))
                    others[name] = min(others[name], ratio[:rank].min())
        cells = (", ".join(f"{value:.2g}" for value in each.values()) for each in (lost, others))
        print(f"| {survey.words} | {' | '.join(cells)} |")


def along(vehicle: Vehicle, F: FloatArray, taus: FloatArray) -> FloatArray:
    """Share (N,) of each demand that thrusts make along it, moments in unit of the rms arm."""
    made, wanted = F @ vehicle.TP.T / vehicle.directions.scale, taus / vehicle.directions.scale
    share: FloatArray = (made * wanted).sum(axis=1) / (wanted**2).sum(axis=1)
    return share


def kept(surveys: int, demands: int) -> None:
    """Print what surveys deliver of what drawings deliver, with none, one and two thrusters off."""
    print("\n| tolerance | answers | least | least, weak: 0 | below 0.95 | below 0.95, weak: 0 |")
    print("|---|---|---|---|---|---|")
    rng = np.random.default_rng(0)
    for survey in (TOLERANCES[0], DRAWN, TOLERANCES[-1]):
        ratios: dict[str, list[FloatArray]] = {"auto": [], "0": []}
        for drawing in drawings().values():
            for off in failures(drawing, 2):
                degraded = fail_thrusters(drawing, off)
                sigma = degraded.directions.sigma
                if sigma[degraded.rank - 1] < CLEAR * sigma[0]:
                    continue
                taus = pushable_demands(degraded, demands, rng)
                before = along(degraded, build("scaled", degraded).many(taus)[0], taus)
                for _ in range(surveys):
                    found = fail_thrusters(move_poses(replace(drawing, survey=survey), survey, rng), off)
                    for key, vehicle in (("auto", found), ("0", replace(found, weak_limit=0.0))):
                        F = build("scaled", vehicle).many(taus)[0]
                        assert ((vehicle.f_min <= F) & (vehicle.f_max >= F)).all()
                        ratios[key].append(along(vehicle, F, taus) / before)
        auto, never = (np.concatenate(each) for each in ratios.values())
        print(
            f"| {survey.words} | {auto.size:,} | {auto.min():.3f} | {max(never.min(), 0.0):.3f}"
            f" | {np.count_nonzero(auto < 0.95):,} | {np.count_nonzero(never < 0.95):,} |",
            flush=True,
        )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--surveys", type=int, default=4, help="surveys of each vehicle and failure")
    parser.add_argument("--demands", type=int, default=100, help="demands on each")
    options = parser.parse_args()
    asked()
    apart(options.surveys)
    kept(options.surveys, options.demands)


if __name__ == "__main__":
    main()
