"""Every kernel's self-test, compiled by GCC and Clang with sanitizers: all shipped vehicles and random ones.

``python docs/studies/native_selftests.py [--random 40] [--vehicle V …]`` generates each kernel with fixed
limits and with limits of the call, in double and in float, compiles it with its self-test, every warning
an error, AddressSanitizer and UBSan watching, and runs it. It prints what fails, and at the end how many
programs ran and how far the worst answer lay from Python's, relative to the largest limit. Exit code 1 where
one failed. ``--plain --odd --random 300`` asks whether answers agree, on vehicles of every kind: no shipped
ones, one compiler, neither sanitizers nor optimization. ``--from 20`` begins at that random vehicle and
leaves the shipped ones out, so that a long trial can be made in pieces, as ``--limits call`` and others do.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice, product
from pathlib import Path

import numpy as np

from alloc import NotApplicable, Vehicle, generate, list_vehicles, load_vehicle
from alloc.methods import recipes
from alloc.program import Scalar, Where
from bench.demands.generated import generate_vehicle, numbered

COMPILERS = ("gcc", "clang")
FLAGS = (
    *("-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror"),
    *("-fsanitize=undefined,address", "-fno-sanitize-recover=all"),
)
PLAIN = ("-std=c99", "-O0", "-pipe")
SCALARS: tuple[Scalar, ...] = ("double", "float")
LIMITS: tuple[Where, ...] = ("fixed", "call")
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
SHAPES = ((1, 2), (2, 3), (2, 4), (3, 3), (3, 4), (3, 5), (4, 5), (6, 7), (6, 8))
"""(k, n) of random vehicles, in turn."""


def random_vehicles(count: int) -> Iterator[Vehicle]:
    """Seeded vehicles of generic T, H full in every third, some with a thruster that always pushes."""
    rng = np.random.default_rng(2004)
    for i in range(count):
        k, n = SHAPES[i % len(SHAPES)]
        f_min, f_max = -rng.uniform(10, 100, n), rng.uniform(10, 100, n)
        f_min[0] *= rng.choice([1.0, -0.05])
        root = rng.normal(size=(n, n))
        yield Vehicle(
            name=f"random{i}",
            dof=AXES[:k],
            T=rng.normal(size=(k, n)),
            H=root @ root.T + np.eye(n) if i % 3 == 0 else np.diag(rng.uniform(0.5, 2.0, n)),
            f_min=f_min,
            f_max=f_max,
            readiness=np.ones(n),
            slack_weights=np.ones(k),
        )


def odd_vehicles(count: int) -> Iterator[Vehicle]:
    """The first vehicles of the campaign."""
    return (replace(generate_vehicle(i)[0], name=f"odd{i}") for i in range(count))


def near_vehicles(count: int) -> Iterator[Vehicle]:
    """Vehicles that are symmetric but for their last digits."""
    return (replace(numbered(i)[0], name=f"near{i}") for i in range(count))


def errors(
    vehicle: Vehicle,
    kernels: Sequence[str],
    compilers: tuple[str, ...],
    flags: tuple[str, ...],
    where: Sequence[Where],
) -> Iterator[tuple[str, float]]:
    """Name of each program of a vehicle that failed, else none, and its worst error [-]."""
    for kernel, limits, scalar in product(kernels, where, SCALARS):
        try:
            files = generate(vehicle, kernel, scalar=scalar, limits=limits)
        except NotApplicable:
            continue
        for compiler in compilers:
            name = f"{vehicle.name} {kernel} {limits} {scalar} {compiler}"
            size = vehicle.f_scale if scalar == "double" else np.inf
            yield checked(files, (compiler, *flags), name, size)


def checked(files: dict[str, str], command: tuple[str, ...], name: str, size: float) -> tuple[str, float]:
    """Compile and run one self-test; prints what is wrong."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in files.items():
            (Path(folder) / file).parent.mkdir(exist_ok=True)
            (Path(folder) / file).write_text(text, encoding="utf-8")
        units = [file for file in files if file.endswith(".c")]
        for step in ([*command, "-I.", *units, "-o", "selftest"], ["./selftest"]):
            done = subprocess.run(step, cwd=folder, capture_output=True, text=True, check=False)
            if done.returncode:
                print(name, (done.stdout + done.stderr)[:500], flush=True)
                return name, 0.0
        worst = re.search(r"largest error (\S+) N", done.stdout)
        assert worst  # the program ends with it
        return "", float(worst[1]) / size


def main() -> int:
    """Run all, print the sum; 1 where one failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicle", action="append", help="shipped vehicles alone, these")
    parser.add_argument("--kernel", action="append", choices=list(recipes()), help="these alone")
    parser.add_argument("--random", type=int, default=40)
    parser.add_argument(
        "--from", type=int, dest="first", metavar="I", help="random vehicles alone, from there"
    )
    parser.add_argument("--odd", action="store_true", help="random vehicles of the campaign")
    parser.add_argument("--near", action="store_true", help="random vehicles that are nearly symmetric")
    parser.add_argument("--plain", action="store_true", help="one compiler, no sanitizers")
    parser.add_argument("--limits", action="append", choices=LIMITS, help="these alone")
    arguments = parser.parse_args()
    plain: bool = arguments.plain
    compilers = tuple(compiler for compiler in COMPILERS if shutil.which(compiler))[: 1 if plain else None]
    without = plain or arguments.first is not None
    shipped = [] if without else [load_vehicle(name) for name in arguments.vehicle or list_vehicles()]
    kind = near_vehicles if arguments.near else odd_vehicles if arguments.odd else random_vehicles
    made_up = kind(arguments.random)
    results = [
        result
        for vehicle in (*shipped, *islice(made_up, arguments.first or 0, None))
        for result in errors(
            vehicle,
            arguments.kernel or list(recipes()),
            compilers,
            PLAIN if plain else FLAGS,
            arguments.limits or LIMITS,
        )
    ]
    failed = [name for name, _ in results if name]
    print(
        f"{len(results)} programs by {', '.join(compilers)}: {len(failed)} failed; in double the largest"
        f" error is {max(error for _, error in results):.1e} of the largest limit"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
