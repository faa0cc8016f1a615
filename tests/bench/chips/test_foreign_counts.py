"""Somebody's C allocator on emulated processors: our own clip behind the interface, and a starter."""

from collections.abc import Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import alloc
from alloc import AllocError, load_vehicle
from alloc.program import Where
from bench.__main__ import cli
from bench.chips.count import count
from bench.chips.foreign import Foreign, agreement, find_sources, kernel
from bench.chips.image import Image, link, without_kernel
from bench.chips.kernels import build_kernel
from bench.chips.toolchain import run
from bench.demands import build_demands
from tests.emulators import available

HEAVY = load_vehicle("bluerov2-heavy")
COST = {"cortex-m4f": 15, "x86-64": 15}
"""Most instructions that the interface costs each call: arguments out of structs, and another call."""
STARTER = resources.files("alloc.foreign") / "starters" / "c" / "my_allocator.c"
WRAPPER = """
#include "thrustbench_allocator.h"
#include "{name}.h"
int tba_interface(void) {{ return TBA_INTERFACE; }}
void *tba_prepare(const struct tba_vehicle *vehicle, const char **reason)
{{
    static int made;
    (void)vehicle, (void)reason;
    return &made;
}}
int tba_call(void *made, const struct tba_input *in, struct tba_output *out)
{{
    (void)made;
    return {name}({arguments}, -1, out->f);
}}
"""


def clip(folder: Path, limits: Where) -> Foreign:
    """Generated clip in single precision, as somebody would put it behind the interface."""
    files = alloc.generate(HEAVY, "clip", scalar="float", limits=limits)
    for name, text in files.items():
        if name.endswith((".c", ".h")) and not name.startswith("test/"):
            (folder / name).write_text(text)
    (name,) = (Path(name).stem for name in files if name.endswith(".h") and "/" not in name)
    arguments = "in->tau" if limits == "fixed" else "in->tau, in->f_min, in->f_max"
    (folder / "wrapper.c").write_text(WRAPPER.format(name=name, arguments=arguments))
    return find_sources([str(folder / "*.c")], [], None, single=True)


def symbols(image: Image, path: Path) -> set[tuple[str, ...]]:
    """Sizes and names of what stands in an image's flash."""
    rows = (line.split() for line in run([f"{image.processor.tools}nm", "-S", str(path)]).splitlines())
    return {(row[1], row[3]) for row in rows if len(row) == 4 and row[2] in "tTrRdDV"}


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("name", ["cortex-m4f", "x86-64"])
def test_clip_behind_the_interface_answers_as_clip_and_costs_a_few_instructions_more(
    name: str, limits: Where, tmp_path: Path
) -> None:
    where = available(name)
    theirs, own = tmp_path / "theirs", tmp_path / "own"
    for folder in (sources := tmp_path / "sources", theirs, own):
        folder.mkdir()
    foreign = link(kernel(clip(sources, limits), HEAVY, limits), where, theirs)
    native = link(build_kernel("clip@native", HEAVY, "float", limits), where, own)
    demands = build_demands("active", HEAVY, 0, 6)
    calls = native.kernel.calls(demands.taus, *demands.limits)
    a, b = count(foreign, calls), count(native, calls)
    np.testing.assert_array_equal(a.F, b.F)
    np.testing.assert_array_equal(a.status, b.status)
    cost = a.instructions - b.instructions
    assert (cost > 0).all()
    assert (cost <= COST[name]).all()
    assert agreement(foreign.kernel, demands, a).wrong == ""
    assert 0 <= foreign.flash_bytes - native.flash_bytes <= 128
    added = symbols(foreign, foreign.path) - symbols(foreign, without_kernel(foreign))
    size = sum(int(bytes_, 16) for bytes_, _ in added)
    assert abs(foreign.flash_bytes - size) <= 0.03 * size  # gaps and names of symbols are in one of them only


def test_flash_has_what_prepares_and_what_that_takes_of_the_c_library(tmp_path: Path) -> None:
    made = kernel(find_sources([str(STARTER)], [], None, single=True), HEAVY, "fixed")
    image = link(made, available("cortex-m4f"), tmp_path)
    added = symbols(image, image.path) - symbols(image, without_kernel(image))
    assert {"tba_prepare", "tba_call"} <= {name for _, name in added}
    assert {name for _, name in added} & {"malloc", "_malloc_r"}
    assert image.flash_bytes >= sum(
        int(bytes_, 16) for bytes_, name in added if "malloc" in name or "tba" in name
    )


def test_answers_of_another_allocator_are_not_agreed_on(tmp_path: Path) -> None:
    text = STARTER.read_text(encoding="utf-8")
    (tmp_path / "half.c").write_text(text.replace("output->f[i] = f;", "output->f[i] = f / 2;"))
    (tmp_path / "right").mkdir()
    made = kernel(find_sources([str(STARTER)], [], None, single=True), HEAVY, "fixed")
    half = find_sources([str(tmp_path / "half.c")], [], None, single=True)
    demands = build_demands("active", HEAVY, 0, 4)
    counted = count(link(made, available("x86-64"), tmp_path / "right"), demands.taus)
    assert agreement(made, demands, counted).agrees
    other = agreement(replace(made, library=half.library), demands, counted)
    assert "answers otherwise than on this machine (4 of 4 demands)" in other.wrong


def test_a_copy_of_the_header_says_the_precision(tmp_path: Path) -> None:
    header = (resources.files("alloc.foreign") / "thrustbench_allocator.h").read_text(encoding="utf-8")
    (tmp_path / "thrustbench_allocator.h").write_text(f"#define TBA_FLOAT\n{header}")
    (tmp_path / "mine.c").write_text(STARTER.read_text(encoding="utf-8"))
    mine = find_sources([str(tmp_path / "*.c")], [], tmp_path / "thrustbench_allocator.h", single=False)
    assert mine.scalar == "float"
    assert find_sources([str(STARTER)], [], None, single=False).scalar == "double"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--sources", "none/*.c"], "none/*.c: matches no C file; name sources as 'src/*.c'"),
        (["--include", "."], "--include and --interface are of --sources"),
        (["--sources", "bad.c"], "bad.c:1:1: error"),
        (["--sources", "bad.c", "--interface", "mine.h"], "mine.h: is no file; name your copy of"),
        (["--sources", "empty.c"], "has no function tba_interface"),
    ],
)
def test_what_can_t_be_counted_is_refused_in_a_line(
    options: Sequence[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.c").write_text("int bad(\n")
    Path("empty.c").write_text("int nothing;\n")
    done = CliRunner().invoke(cli, ["emulate", "--vehicle", "ukwial", *options])
    said = str(done.exception) if isinstance(done.exception, AllocError) else done.output
    assert done.exit_code != 0
    assert says in said
