"""Cost of the library on a Cortex-M4F in single precision, as its pages give it."""

import re
import subprocess
from collections import defaultdict
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from alloc import load_vehicle
from alloc.library import NAME, files
from alloc.library.adapter import name
from bench.chips.count import count
from bench.chips.cycles import cycles
from bench.chips.image import FLAGS, link
from bench.chips.kernels import build_kernel
from tests.emulators import available
from tests.places import ROOT

PAGE = (ROOT / "docs/at-boot.md").read_text(encoding="utf-8")
OWN_PAGE = (ROOT / f"alloc/library/{NAME}.md").read_text(encoding="utf-8")
ROUNDED = 0.05
"""Pages round, and another compiler of the same kind may take a few bytes or cycles more."""


def said(words: str, page: str = PAGE) -> list[float]:
    """The numbers in a page's words, which stand as groups in a pattern."""
    found = re.search(words, page)
    assert found, words
    return [float(number.replace(",", "")) for number in found.groups()]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its objects with room for eight thrusters, and what GCC says of their stacks and calls."""
    where, folder = available("cortex-m4f"), tmp_path_factory.mktemp("library")
    made = files("float") | {"one.c": f'#include "{NAME}.h"\nstruct tb_allocator one;\n'}
    for file, text in made.items():
        (folder / file).write_text(text)
    sources = [file for file in made if file.endswith(".c")]
    options = [*where.flags, *FLAGS[:1], "-std=c99", "-fno-asynchronous-unwind-tables", "-fcallgraph-info=su"]
    subprocess.run([f"{where.tools}gcc", *options, "-c", *sources], cwd=folder, check=True)
    return folder


def bytes_of(folder: Path, *command: str) -> str:
    return subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout


def test_flash_and_memory_of_a_vehicle_are_what_the_page_says(compiled: Path) -> None:
    flash, memory = said(r"it takes ([\d.]+) kB of flash, ([\d.]+) kB of RAM a vehicle")
    tools = available("cortex-m4f").tools
    objects = [path.name for path in compiled.glob("*.o")]
    sizes = bytes_of(compiled, f"{tools}size", *objects).splitlines()[1:]
    assert sum(int(line.split()[0]) for line in sizes) == pytest.approx(1000 * flash, rel=ROUNDED)
    assert not any(int(line.split()[1]) for line in sizes)  # no data that can change
    size = bytes_of(compiled, f"{tools}nm", "-S", "one.o").split()[1]
    assert int(size, 16) == pytest.approx(1000 * memory, rel=ROUNDED)


def test_each_call_s_stack_is_what_the_page_says(compiled: Path) -> None:
    """GCC's own frames along the deepest way through its graph of calls."""
    text = "\n".join(path.read_text() for path in compiled.glob("*.ci"))
    frames = {
        title.rpartition(":")[2]: int(size)
        for title, size in re.findall(r'title: "([^"]+)" label: "[^"]*\\n(\d+) bytes \(static\)', text)
    }
    called = defaultdict[str, set[str]](set)
    for caller, callee in re.findall(r'sourcename: "([^"]+)" targetname: "([^"]+)"', text):
        called[caller.rpartition(":")[2]].add(callee.rpartition(":")[2])

    def deepest(function: str) -> int:
        return frames.get(function, 0) + max(map(deepest, called[function]), default=0)

    rows = re.findall(r"^\| (`tb_.*?) \|.*\| ([\d,]+) \|$", OWN_PAGE, re.M)
    stated = {
        call: float(size.replace(",", "")) for calls, size in rows for call in re.findall(r"tb_\w+", calls)
    }
    assert len(stated) == 8
    for call, size in stated.items():
        assert deepest(call) <= size * (1 + ROUNDED), call
    for calls, size in rows:  # one number for several calls is that of the deepest
        most = max(deepest(call) for call in re.findall(r"tb_\w+", calls))
        assert most == pytest.approx(float(size.replace(",", "")), rel=ROUNDED)


@pytest.fixture(scope="module")
def eight(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[int]]:
    """Cycles, and cycles from a board's flash, of what prepares eight coupled thrusters, by function."""
    vehicle, where = load_vehicle(str(ROOT / "docs/vehicles/box8.yaml")), available("cortex-m4f")
    kernel, own = build_kernel("nullspace@library", vehicle, "float"), name(vehicle, "nullspace", "float")
    head = f"int {own}_without(const float *mask)"
    body = f"\n{head};\n{head}\n{{\n    return tb_without(allocator, (unsigned long)mask[0]);\n}}\n"
    masks = [sum(1 << i for i in off) for m in range(3) for off in combinations(range(vehicle.n), m)]
    calls = np.zeros((len(masks), vehicle.k))
    calls[:, 0] = masks
    prepare = replace(kernel, entry=f"{own}_prepare", arguments="")
    without = replace(
        kernel,
        entry=f"{own}_without",
        arguments=f"{own}_ready(tau)",
        declaration=f"{kernel.declaration}\n{head};",
        sources={**kernel.sources, f"{own}.c": kernel.sources[f"{own}.c"] + body},
    )
    found = {}
    for function, made, given in (("prepare", prepare, calls[:1]), ("without", without, calls)):
        image = link(made, where, tmp_path_factory.mktemp(function))
        counted = count(image, given)
        assert not counted.status.any()
        found[function] = [end for span in cycles(image, given, counted).values() for end in span]
    return found


@pytest.mark.parametrize("function", ["prepare", "without"])
def test_preparing_eight_coupled_thrusters_takes_what_the_page_says(
    function: str, eight: dict[str, list[int]]
) -> None:
    """A millisecond at 180 MHz is the goal, from flash too; ``tb_without`` leaves out none, one or two."""
    spans = r"([\d,]+) to ([\d,]+)[^(]*\(([\d,]+) to ([\d,]+)"
    stated = said(rf"`tb_{function}` (?:takes|at most) {spans}")
    assert eight[function] == pytest.approx(stated, rel=ROUNDED)
    assert max(eight[function]) <= 180_000
