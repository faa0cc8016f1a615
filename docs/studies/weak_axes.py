"""Cost of a tape measure's errors where axes are nearly lost: drawings, surveys, failures.

``python docs/studies/weak_axes.py [--surveys N] [--demands N]`` prints the three tables of
docs/weak-axes.md: demands on drawings and on surveys of them; sigma / epsilon of lost and of other
directions; and what scaled delivers on 1,005 surveyed vehicles, along demands that the drawing's thrusters
push, of what a linear program on the strong directions delivers and of what the drawing does. Two more tables
are those of each method with a share, and of the C of a mixture (``--only methods`` and ``--only cost``).
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from math import nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from alloc import Vehicle, alpha_max, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c.target import Target
from alloc.formulations import find_formulation, mixed
from alloc.methods import recipe
from alloc.reach.attainable import alpha_max_lp
from alloc.reach.way import KEEP, step_maps
from alloc.vehicle.weak import DRAWN, Survey
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import native_kernel
from bench.chips.processors import processor
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


def strong_part(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Demands (N, k) without weak directions, orthogonally in unit of D: no method's own projection."""
    rows, unit = vehicle.weak * vehicle.directions.scale, vehicle.directions.scale
    strong: FloatArray = (taus / unit - taus / unit @ rows.T @ rows) * unit
    return strong


class Answers(NamedTuple):
    """Answers on surveys of one drawing.

    Attributes
    ----------
    of_program : (N,) what is delivered of what the linear program delivers [-]
    of_drawing, program_of_drawing : (M,) of what a clear drawing delivers, and the program of that [-]
    outside : number of answers with a thrust beyond a limit
    apart : largest difference of the program's shares by facets and by HiGHS [-]
    """

    of_program: FloatArray
    of_drawing: FloatArray
    program_of_drawing: FloatArray
    outside: int
    apart: float


def answer(name: str, survey: Survey, seed: tuple[int, int], surveys: int, demands: int) -> Answers:
    """Answers on surveys of one drawing, with none, one and two thrusters off.

    The linear program goes by facets, and by HiGHS for one demand on the first survey of each.
    """
    drawing, rng = drawings()[name], np.random.default_rng(seed)
    of_program, of_drawing, program_of_drawing = ([np.zeros(0)] for _ in range(3))
    outside, apart = 0, 0.0
    for off in failures(drawing, 2):
        degraded = fail_thrusters(drawing, off)
        sigma = degraded.directions.sigma
        clear = sigma[degraded.rank - 1] >= CLEAR * sigma[0]
        taus = pushable_demands(degraded, demands, rng)
        before = along(degraded, build("scaled", degraded).many(taus)[0], taus)
        for number in range(surveys):
            found = fail_thrusters(move_poses(replace(drawing, survey=survey), survey, rng), off)
            strong, asked = found.strong, strong_part(found, taus)
            F = build("scaled", found).many(taus)[0]
            outside += int(((found.f_min > F) | (found.f_max < F)).any(axis=1).sum())
            best = np.minimum(alpha_max(strong, asked), 1.0)
            if number == 0:
                apart = max(apart, float(abs(min(alpha_max_lp(strong, asked[0]), 1.0) - best[0])))
            of_program.append(along(strong, F, asked) / best)
            if clear:
                of_drawing.append(along(found, F, taus) / before)
                program_of_drawing.append(best / before)
    clear_ones = np.concatenate(of_drawing), np.concatenate(program_of_drawing)
    return Answers(np.concatenate(of_program), *clear_ones, outside, apart)


LEVELS = (("heave", "roll", "pitch"), ("surge", "sway", "yaw"))
"""Levels for ``priority``. The first is compared: what it leaves to the next may be anything, drawn too."""


def delivered(method: str, vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """(N,) what a method makes along each demand; of ``priority`` the share of the first level."""
    if method != "priority":
        return along(vehicle, build(method, vehicle).many(taus)[0], taus)
    parts = find_formulation(method).parts(vehicle)
    limits = vehicle.f_min, vehicle.f_max
    shares = [part.way.towards_many(taus, part.way.departure(*limits))[1] for part in parts]
    return mixed(shares, [part.w for part in parts])[:, 0]


def programs(method: str, vehicle: Vehicle, tau: FloatArray) -> tuple[float, float]:
    """Shares that HiGHS delivers of a demand by a method's first step, and with all other axes free."""
    strong = vehicle.strong
    if method != "priority":
        return min(alpha_max_lp(strong, strong_part(vehicle, tau[None])[0]), 1.0), nan
    first = [vehicle.dof.index(axis) for axis in vehicle.priority[0]]
    step = step_maps(strong, vehicle.priority)[0] @ tau
    T, scale = strong.TP[first], strong.wrench_scale[first]
    free = linprog(
        np.append(np.zeros(vehicle.n), -1.0),
        A_eq=np.hstack([T, -tau[first, None]]) / scale[:, None],
        b_eq=np.zeros(len(first)),
        bounds=[*zip(vehicle.f_min, vehicle.f_max, strict=True), (0.0, None)],
    )
    assert free.x is not None  # no thrust at all is one that it allows
    return min(KEEP * alpha_max_lp(strong, step), 1.0), min(KEEP * float(free.x[-1]), 1.0)


def methods(surveys: int, demands: int) -> None:
    """Print what each method with a share delivers on surveys of clear drawings, of what it does there.

    Where that is less than 0.95 of it two programs tell whether a survey allows more: one of the same step,
    and of levels one that moves all other axes as it likes, which the method keeps at rest.
    """
    names, survey = ("scaled", "scaled-by-group", "priority"), DRAWN
    ratios: dict[str, list[FloatArray]] = {method: [] for method in names}
    allowed: dict[str, list[tuple[float, float]]] = {method: [] for method in names}
    for j, (_, whole) in enumerate(drawings().items()):
        levels = tuple(tuple(axis for axis in level if axis in whole.dof) for level in LEVELS)
        drawing, rng = replace(whole, priority=tuple(filter(None, levels))), np.random.default_rng((9, j))
        for off in failures(drawing, 2):
            degraded = fail_thrusters(drawing, off)
            sigma = degraded.directions.sigma
            if sigma[degraded.rank - 1] < CLEAR * sigma[0]:
                continue
            taus = pushable_demands(degraded, demands, rng)
            before = {method: delivered(method, degraded, taus) for method in names}
            for _ in range(surveys):
                found = fail_thrusters(move_poses(drawing, survey, rng), off)
                for method in names:
                    pushed = before[method] > NOTHING
                    each = delivered(method, found, taus)[pushed] / before[method][pushed]
                    ratios[method].append(each)
                    for i in np.flatnonzero(each < 0.95):
                        own, free = programs(method, found, taus[pushed][i])
                        drawn = before[method][pushed][i]
                        allowed[method].append((own / drawn / each[i], free / drawn))
    print(f"\n| of drawings, at {survey.words} | answers | least | 1 in 1,000 | below 0.95", end=" | ")
    print("program's over these, at most | others free, at least |")
    print("|---" * 7 + "|")
    for method in names:
        each = np.concatenate(ratios[method])
        few = np.quantile(each, 1e-3)
        below = np.count_nonzero(each < 0.95)
        print(f"| {method} | {each.size:,} | {each.min():.3f} | {few:.3f} | {below:,}", end=" | ")
        more, free = np.array(allowed[method] or [(nan, nan)]).T
        print(f"{more.max():.3f} | {free.min():.3f} |".replace("nan", "-"))


NOTHING = 1e-6
"""Share of a demand on a drawing below which a level gets nothing, of which no part can be told."""


def cost() -> None:
    """Print flash and instructions of C where a direction is lost, weak, counts in part and counts wholly.

    A drawing's T has zeros that a survey's has not: a direction is lost with each of them.
    """
    off, far = (4, 5), Survey(20.0, 2.3)
    drawing = load_vehicle("bluerov2-heavy")
    found = fail_thrusters(move_poses(drawing, far, np.random.default_rng(3)), off)
    least = float(found.directions.sigma[-1] / found.directions.sigma[0])
    weak, in_part, whole = (replace(found, weak_limit=least / times) for times in (0.9, 1.5, 2.1))
    states = {
        "lost, on the drawing": fail_thrusters(drawing, off),
        "lost, as surveyed": replace(found, T=weak.strong.T, poses=None, weak_limit=0.0),
        "weak": weak,
        "in part": in_part,
        "whole": whole,
    }
    board, taus = processor("cortex-m4f"), pushable_demands(found, 300, np.random.default_rng(4))
    print("\n| direction (Cortex-M4F, float) | flash [B] | most instructions | flash, priority | most |")
    print("|---" * 5 + "|")
    for words, vehicle in states.items():
        cells = [words]
        for method in ("scaled", "priority"):
            target = Target(vehicle=vehicle, method=recipe(method), scalar="float", faults="none")
            with TemporaryDirectory() as folder:
                image = link(native_kernel(target), board, Path(folder))
                cells += [f"{image.flash_bytes:,}", f"{count(image, taus).instructions.max():,}"]
        print(f"| {' | '.join(cells)} |")


def kept(surveys: int, demands: int) -> None:
    """Print what surveys deliver of a linear program on their strong directions, and of the drawing."""
    print("\n| tolerance | answers | of program, least | below 0.99", end=" | ")
    print("of drawing, least | below 0.95 | program, least |")
    print("|---" * 7 + "|")
    surveyed = (TOLERANCES[0], DRAWN, TOLERANCES[-1])
    with ProcessPoolExecutor(3) as pool:
        asked = [
            [pool.submit(answer, name, survey, (i, j), surveys, demands) for j, name in enumerate(drawings())]
            for i, survey in enumerate(surveyed)
        ]
        found = [[each.result() for each in row] for row in asked]
    for survey, own in zip(surveyed, found, strict=True):
        program = np.concatenate([one.of_program for one in own])
        clear = np.concatenate([one.of_drawing for one in own])
        limit = np.concatenate([one.program_of_drawing for one in own])
        counts = np.count_nonzero(program < 0.99), np.count_nonzero(clear < 0.95)
        print(
            f"| {survey.words} | {program.size:,} | {program.min():.3f} | {counts[0]:,}"
            f" | {clear.min():.3f} | {counts[1]:,} | {limit.min():.3f} |"
        )
    each = [one for own in found for one in own]
    print(
        f"\n{surveys * len(each):,} surveyed vehicles; {sum(one.outside for one in each)} answers beyond a"
        f" limit; HiGHS is {max(one.apart for one in each):.1g} of a share away at most."
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--surveys", type=int, default=67, help="of each of 5 drawings and 3 tolerances")
    parser.add_argument("--demands", type=int, default=20, help="on each, with each set of thrusters off")
    parser.add_argument("--only", choices=("methods", "cost"), help="one of the two tables behind the page's")
    options = parser.parse_args()
    if options.only == "methods":
        methods(options.surveys, options.demands)
    elif options.only == "cost":
        cost()
    else:
        asked()
        apart(min(options.surveys, 40))
        kept(options.surveys, options.demands)


if __name__ == "__main__":
    main()
