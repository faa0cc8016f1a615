"""A C++ firmware with generated C and the library builds under every compiler, and answers as Python does."""

import itertools
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from alloc import Status, build, load_vehicle
from alloc.allocation import FloatArray
from alloc.c import Target, sources
from alloc.library import files
from alloc.methods import recipe
from alloc.program import Scalar
from bench.chips.image import FIRMWARE
from bench.chips.toolchain import ended
from bench.chips.toolchain import run as ran
from tests.alloc.c.test_linkable import COMPILERS
from tests.compilers import WARNINGS, needs, write
from tests.emulators import available

PLACE = Path(__file__).parent / "firmware"
OFTEN = {("g++", "c++11")}
"""Asked in ``make test``; the others with ``-m long``."""
CLOSE = {"double": 1e-9, "float": 1e-5}
"""Share of the largest limit. Single precision: some dozen roundings of 6e-8 times a condition of 5."""


class Tools(NamedTuple):
    """Commands that compile C, compile C++, link and run, each with a processor's options."""

    c: list[str]
    cpp: list[str]
    link: list[str]
    emulator: list[str] = []  # noqa: RUF012 (never changed)


@cache
def generated() -> dict[str, str]:
    """C of two vehicles, without self-tests."""
    ukwial, heavy = map(load_vehicle, ("ukwial", "bluerov2-heavy"))
    call = Target(vehicle=heavy, method=recipe("scaled"), scalar="float", limits="call")
    return sources(Target(vehicle=ukwial, method=recipe("nullspace"))) | sources(call)


def printed(tools: Tools, scalar: Scalar, folder: Path, *, whole: bool = False) -> FloatArray:
    """Status, share and eight thrusts of each call, those that are not there 0; raises ToolError."""
    write(folder, generated() | files(scalar))
    units = sorted(path.name for path in folder.glob("*.c"))
    if whole:
        write(folder, {"all.c": "".join(f'#include "{name}"\n' for name in units)})
        units = ["all.c"]
    ran([*tools.c, *WARNINGS, "-c", *units], folder)
    ran([*tools.cpp, *WARNINGS, "-I.", "-c", str(PLACE / "firmware.cpp")], folder)
    objects = [f"{Path(name).stem}.o" for name in units]
    ran([*tools.link, "firmware.o", *objects, "-o", "firmware"], folder)
    at_boot = load_vehicle("tiburon")
    rows = [[at_boot.k, at_boot.n], *at_boot.T.tolist(), at_boot.f_min, at_boot.f_max, ASKED["tiburon"]]
    text = "\n".join(" ".join(map(str, row)) for row in rows)
    done = ended([*tools.emulator, "./firmware"], folder, given=text)
    assert done.returncode == 0, done.stderr
    lines = [[float(word) for word in line.split()] for line in done.stdout.splitlines()]
    return np.array(list(itertools.zip_longest(*lines, fillvalue=0.0))).T


ASKED = {
    "ukwial": [60.0, 40.0, 20.0],
    "bluerov2-heavy": [10.0, -5.0, 20.0, 1.0, 2.0, -3.0],
    "tiburon": [0.2, -0.15, 0.25, 0.05, 0.1, -0.3],  # more than it can do once a second thruster has failed
}
"""Demand of the firmware for each vehicle."""


def compare(lines: FloatArray, scalar: Scalar) -> None:
    """Each line beside Python's answer to the same call."""
    ukwial, heavy, at_boot = map(load_vehicle, ASKED)
    low, high = np.arange(-9.0, -1.0), np.arange(2.0, 10.0)
    calls = [
        *(("nullspace", ukwial, (fault,), (), "double") for fault in range(-1, 4)),
        *(("scaled", heavy, (fault,), (low, high), "float") for fault in range(-1, 8)),
        *(
            (method, at_boot, off, (), scalar)
            for off in ((), (2,), (2, 5))
            for method in ("nullspace", "scaled")
        ),
    ]
    statuses = set()
    for line, (method, whole, off, limits, precision) in zip(lines, calls, strict=True):
        vehicle = whole
        for thruster in off:
            vehicle = vehicle if thruster < 0 else vehicle.with_fault(thruster)
        one = build(method, vehicle)(np.array(ASKED[whole.name]), *limits)
        assert line[0] == one.status
        statuses.add(one.status)
        if one.found:
            np.testing.assert_allclose(line[1], [*one.share, 1.0][0], rtol=0, atol=CLOSE[precision])
            f = line[2 : 2 + vehicle.n]
            np.testing.assert_allclose(f, one.f, rtol=0, atol=CLOSE[precision] * vehicle.f_scale)
    assert statuses == {Status.SOLVED, Status.PARTIAL, Status.INFEASIBLE}


@pytest.mark.parametrize(
    ("compiler", "standard"),
    [
        pytest.param(*each.values, marks=() if each.values in OFTEN else pytest.mark.long)
        for each in COMPILERS
    ],
)
def test_it_builds_without_a_warning_and_answers_as_python_does(
    compiler: str, standard: str, tmp_path: Path
) -> None:
    """A C compiler makes the C, its C++ companion the program; a C++ compiler makes both."""
    cpp = {"gcc": "g++", "clang": "clang++"}.get(compiler, compiler)
    needs(compiler, cpp)
    own, newest = [compiler, f"-std={standard}"], [cpp, f"-std={standard if compiler == cpp else 'c++11'}"]
    tools = Tools([*own, "-x", "c++"] if compiler == cpp else own, newest, [cpp])
    scalar: Scalar = "float" if "clang" in compiler else "double"
    compare(printed(tools, scalar, tmp_path), scalar)


@pytest.mark.long
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_so_does_one_unit_of_all_its_c(compiler: str, tmp_path: Path) -> None:
    needs(compiler, "g++")
    tools = Tools([compiler, "-std=gnu17", "-O1"], ["g++", "-std=c++11"], ["g++"])
    compare(printed(tools, "double", tmp_path, whole=True), "double")


BARE = ["-nostartfiles", "--specs=rdimon.specs", f"-T{FIRMWARE / 'ports/mps2.ld'}", str(PLACE / "start.c")]
PROCESSORS: dict[str, tuple[str, list[str], Scalar]] = {
    "Cortex-M4F": ("cortex-m4f", [], "float"),
    "Cortex-M33": ("cortex-m33", [], "float"),
    "Cortex-M7, doubles": ("cortex-m7", [], "double"),
    "Cortex-M7, floats": ("cortex-m7", ["-mfpu=fpv5-sp-d16", "-DTHRUSTBENCH_FPV5"], "float"),
    "aarch64": ("aarch64", [], "double"),
}
"""Target, options beside its own, and the library's scalar."""


@pytest.mark.long
@pytest.mark.parametrize("processor", PROCESSORS)
def test_so_does_what_is_built_for_other_processors(processor: str, tmp_path: Path) -> None:
    name, options, scalar = PROCESSORS[processor]
    where = available(name)
    gcc = [f"{where.tools}gcc", *where.flags, *options]
    cpp = [f"{where.tools}g++", *where.flags, *options, "-fno-exceptions"]
    if not where.bare_metal:  # Debian's compiler of C++ for it is another package; Clang has all processors
        cpp = ["clang++", "--target=aarch64-linux-gnu", "-isystem", "/usr/aarch64-linux-gnu/include"]
    needs(cpp[0])
    link = [*gcc, *BARE, *where.board] if where.bare_metal else gcc
    tools = Tools([*gcc, "-std=c99", "-O2"], [*cpp, "-std=c++11", "-O2"], link, list(where.emulator))
    compare(printed(tools, scalar, tmp_path), scalar)
