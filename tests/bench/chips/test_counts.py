"""Counts are of what a processor would execute: kernels of known cost, and two ways to each number."""

import re
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc.errors import UnknownName
from alloc.program import Scalar
from bench.chips.count import count, count_by_systick
from bench.chips.image import Image, link
from bench.chips.kernels import Kernel
from bench.chips.processors import processor, processors
from bench.chips.toolchain import ToolError, missing
from tests.emulators import available

NAMES = [t.name for t in processors() if not t.callgrind]
BOARDS = [t.name for t in processors() if t.bare_metal]
SEEN = {("cortex-m4f", "double"), ("cortex-m7", "double"), ("cortex-m33", "float")}
"""Doubles by calls and by instructions, and floats; the other three are asked with ``-m long``."""
TAUS = np.random.default_rng(10).uniform(-3.0, 3.0, (7, 3))

# Three gains, clipped, then some waiting: branches, a loop that depends on the demand, and a status.
CLIPPED = """
int kernel(const SCALAR tau[3], SCALAR f[2]) {
    int status = 0;
    f[0] = (SCALAR)0.5 * tau[0] + (SCALAR)0.25 * tau[1];
    f[1] = tau[2] / 3;
    for (int i = 0; i < 2; i++)
        if (f[i] > (SCALAR)0.3) { f[i] = (SCALAR)0.3; status += i + 1; }
    for (volatile int i = 0; i < 5 * status; i++) { }
    return status;
}
"""


def kernel(body: str, scalar: Scalar = "double") -> Kernel:
    signature = f"int kernel(const {scalar} tau[3], {scalar} f[2])"
    sources = {"kernel.c": body.replace("SCALAR", scalar)}
    return Kernel(
        method="test",
        twin="pinv",
        scalar=scalar,
        k=3,
        n=2,
        entry="kernel",
        declaration=signature + ";",
        arguments="tau, f",
        sources=sources,
    )


def saying(statements: str) -> Kernel:
    return kernel(
        f"int kernel(const SCALAR tau[3], SCALAR f[2]) {{ f[0] = tau[0]; {statements} return 0; }}", "float"
    )


@pytest.fixture
def linked(tmp_path: Path) -> Callable[[Kernel, str], Image]:
    def link_one(what: Kernel, name: str) -> Image:
        folder = tmp_path / f"{len(list(tmp_path.iterdir()))}"
        return link(what, available(name), folder)

    return link_one


Linked = Callable[[Kernel, str], Image]


@pytest.mark.parametrize(
    ("board", "scalar"),
    [
        pytest.param(board, scalar, marks=() if (board, scalar) in SEEN else pytest.mark.long)
        for board in BOARDS
        for scalar in ("double", "float")
    ],
)
def test_the_plugin_and_systick_agree_to_the_instruction(linked: Linked, board: str, scalar: Scalar) -> None:
    """On a Cortex-M4F each addition of doubles is a call of a soft-float routine."""
    image = linked(kernel(CLIPPED, scalar), board)
    counted = count(image, TAUS).instructions
    assert len(set(counted.tolist())) > 2
    # A tick is 40 or 50 instructions, read 1,000 times apart: off by 0.1 at most.
    np.testing.assert_allclose(count_by_systick(image, TAUS), counted, atol=0.11)


def test_the_plugin_and_a_single_step_log_agree_on_aarch64(linked: Linked) -> None:
    image = linked(kernel(CLIPPED), "aarch64")
    counted = count(image, TAUS).instructions
    folder = image.path.parent
    (folder / "ticks").unlink()  # nobody counts ticks here, and the driver tells a counter that stands still
    size = 4 * 64  # more than the whole kernel; the driver's next function is not called between its calls
    log = ["-singlestep", "-d", "exec,nochain", "-dfilter", f"{image.entry:#x}+{size:#x}", "-D", "log.txt"]
    subprocess.run(["qemu-aarch64", *log, image.path], cwd=folder, check=True, timeout=60)
    lines = (folder / "log.txt").read_text().splitlines()
    assert sum(line.endswith(" kernel") for line in lines) == counted.sum()


def test_callgrind_and_the_plugin_agree_on_x86(linked: Linked) -> None:
    image = linked(kernel(CLIPPED), "x86-64")
    by_callgrind = count(image, TAUS).instructions
    emulated = replace(image.processor, emulator=("qemu-x86_64",), callgrind=False)
    if reason := missing(emulated):
        pytest.skip(reason)
    by_plugin = count(replace(image, processor=emulated), TAUS).instructions
    np.testing.assert_array_equal(by_callgrind, by_plugin)


@pytest.mark.parametrize("name", [*NAMES, "x86-64"])
def test_a_hundred_instructions_more_are_counted_as_a_hundred(linked: Linked, name: str) -> None:
    some, more = (linked(saying(f'__asm volatile(".rept {m}\\n nop\\n .endr");'), name) for m in (20, 120))
    np.testing.assert_array_equal(count(more, TAUS).instructions - count(some, TAUS).instructions, 100)


@pytest.mark.parametrize("name", NAMES)
def test_a_loop_back_to_the_first_instruction_is_one_call(linked: Linked, name: str) -> None:
    jump = {"aarch64": "sub x0, x0, #1\n cbnz x0, again\n ret"}.get(name, "subs r0, #1\n bne again\n bx lr")
    thumb = "" if name == "aarch64" else ".thumb_func"
    text = f'__asm(".text\\n.global again\\n{thumb}\\nagain: {jump}\\n");'.replace(
        jump, jump.replace("\n", "\\n")
    )
    looping = replace(
        kernel(text),
        entry="again",
        declaration="int again(unsigned long turns);",
        arguments="5 + 0 * sizeof(tau)",
    )
    image = linked(looping, name)
    np.testing.assert_array_equal(count(image, TAUS).instructions, 5 * 2 + 1)


@pytest.mark.parametrize("name", NAMES)
def test_the_answers_come_back_as_the_kernel_gave_them(linked: Linked, name: str) -> None:
    counted = count(linked(kernel(CLIPPED), name), TAUS)
    F = np.column_stack([0.5 * TAUS[:, 0] + 0.25 * TAUS[:, 1], TAUS[:, 2] / 3])
    np.testing.assert_allclose(counted.F, np.minimum(F, 0.3), rtol=1e-15)  # a fused rounding
    np.testing.assert_array_equal(counted.status, (F > 0.3) @ [1, 2])


@pytest.mark.parametrize("name", NAMES)
def test_stack_is_as_deep_as_the_kernel_wrote(linked: Linked, name: str) -> None:
    touching = "volatile char deep[{}]; for (unsigned i = 0; i < sizeof deep; i++) deep[i] = 1;"
    shallow, deep = (
        count(linked(saying(touching.format(size)), name), TAUS).stack_bytes for size in (64, 1088)
    )
    np.testing.assert_array_equal(deep - shallow, 1024)


@pytest.mark.parametrize("name", NAMES)
def test_the_driver_s_own_stack_is_not_counted(linked: Linked, name: str) -> None:
    sixteen = {"aarch64": "stp x19, x20, [sp, #-16]!\\n ldp x19, x20, [sp], #16"}
    pushing = sixteen.get(name, "push {r4-r7}\\n pop {r4-r7}")
    counted = count(linked(saying(f'__asm volatile("{pushing}");'), name), TAUS)
    np.testing.assert_array_equal(counted.stack_bytes, 16)


@pytest.mark.parametrize("name", NAMES)
def test_constants_count_as_flash_and_variables_as_ram(linked: Linked, name: str) -> None:
    plain = linked(saying(""), name)
    table = linked(saying("static const int t[256] = {1}; f[1] = t[(int)tau[1]];"), name)
    state = linked(saying("static volatile int s[256]; s[(int)tau[1] & 1]++;"), name)
    assert 8 <= plain.flash_bytes <= 64  # a load, a store, a return; aligned to a cache line or less
    assert 1024 <= table.flash_bytes - plain.flash_bytes < 1024 + 100  # the table, and the code that reads it
    assert table.ram_static_bytes == plain.ram_static_bytes == 0
    assert state.ram_static_bytes == pytest.approx(1024, abs=8)  # padded to its alignment


def test_a_missing_compiler_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None if name == "arm-none-eabi-gcc" else name)
    reason = missing(processor("cortex-m7"))
    assert re.search(r"cortex-m7 needs arm-none-eabi-gcc: apt-get install .*newlib", reason)


def test_an_unknown_target_is_refused_with_those_there_are() -> None:
    with pytest.raises(UnknownName, match=r"no target 'avr'; there are aarch64, cortex-m33, cortex-m4f"):
        processor("avr")


def test_c_that_does_not_compile_is_an_error_in_the_compilers_words(linked: Linked) -> None:
    with pytest.raises(ToolError, match=r"arm-none-eabi-gcc ended with 1: .*undeclared"):
        linked(saying("f[1] = nobody;"), "cortex-m7")


def test_a_kernel_that_faults_is_an_error_and_not_a_count(linked: Linked) -> None:
    with pytest.raises(ToolError, match="qemu-system-arm ended with"):
        count(linked(saying('__asm volatile("udf #0");'), "cortex-m7"), TAUS)
