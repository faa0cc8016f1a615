"""Generated C goes into anybody's program: every standard, C++, one translation unit, every FPU."""

import os
import re
import shutil
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import Vehicle, generate, load_vehicle
from alloc.program.literal import number
from tests.compilers import WARNINGS, needs, run, write
from tests.not_asked import not_asked
from tests.vehicles import made_up

C, CPP = ("c99", "c11", "c17", "gnu11", "gnu17"), ("c++11", "c++14", "c++17", "c++20")
SPAN = {("gcc", "c99"), ("clang", "gnu17"), ("g++", "c++20"), ("clang++", "c++11")}
"""The oldest and the newest standard of both languages; those between are asked with ``-m long``."""
COMPILERS = [
    pytest.param(compiler, standard, marks=() if (compiler, standard) in SPAN else pytest.mark.long)
    for compilers, standards in ((("gcc", "clang"), C), (("g++", "clang++"), CPP))
    for compiler, standard in product(compilers, standards)
]
ALONE = {("gcc", "c99"), ("g++", "c++20")}
"""Compilers that compile each file by itself too; all compilers find the same includes missing."""
METHODS = ("nullspace", "scaled", "redistribute", "pinv")
"""Between them they have all that C can be made of: branches, loops over data, shares, no status."""
SHAPES = [("double", "fixed"), ("float", "call"), ("double", "call"), ("float", "fixed")]


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two vehicles, four methods, two scalars, limits fixed and of the call; all.c includes every source.

    The larger vehicle, slowest to compile, has two methods, each scalar and each kind of limits once.
    """
    folder = tmp_path_factory.mktemp("c")
    for name, made in (
        ("ukwial", product(METHODS, SHAPES)),
        ("bluerov2-heavy", zip(("nullspace", "scaled"), SHAPES[:2], strict=True)),
    ):
        vehicle = load_vehicle(name)
        for method, (scalar, limits) in made:
            write(folder, generate(vehicle, method, scalar=scalar, limits=limits, esc=bool(vehicle.esc)))
    sources = sorted(path.name for path in folder.glob("*.c"))
    assert len(sources) == 20
    write(folder, {"all.c": "".join(f'#include "{name}"\n' for name in sources)})
    return folder


ALIKE = made_up(np.ones((1, 3)), [-4.0, 1.0, -6.0], [5.0, 6.0, 6.0], dof=("heave",), name="alike")


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize(
    ("vehicle", "method", "has"),
    [
        # Clang warns of a & b ? c : d; a vehicle that can't push every axis asks so for its status.
        pytest.param(load_vehicle("bluerov2"), "scaled", ") & (", id="several conditions"),
        # Three that push one axis, with limits of their own: the first of two equal variables was never read.
        pytest.param(ALIKE, "nullspace", "", id="thrusters that a step moves alike"),
    ],
)
def test_what_a_compiler_warned_of_is_clean(
    compiler: str, vehicle: Vehicle, method: str, has: str, tmp_path: Path
) -> None:
    needs(compiler)
    files = generate(vehicle, method)
    assert any(has in text for text in files.values())
    done = run([compiler, "-std=c99", *WARNINGS, "-I.", "-fsyntax-only", *write(tmp_path, files)], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("compiler", "standard"), COMPILERS)
def test_every_file_is_clean_alone_and_all_in_one_translation_unit(compiler, standard, generated) -> None:
    needs(compiler)
    language = ["-x", "c++"] if "+" in compiler else []
    sources = generated.glob("*.c" if (compiler, standard) in ALONE else "all.c")
    units = [path.relative_to(generated).as_posix() for path in (*sources, *generated.glob("test/*.c"))]
    done = run(
        [compiler, f"-std={standard}", *WARNINGS, "-I.", "-fsyntax-only", *language, *units], generated
    )
    assert done.returncode == 0, done.stderr[:2000]


def test_a_globbing_build_finds_no_main(generated) -> None:
    """The folder above ``test`` is what Arduino, PlatformIO and CMake's GLOB take."""
    for path in generated.glob("*.[ch]"):
        assert not re.search(r"\bmain\s*\(", path.read_text(encoding="utf-8")), path


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_fast_math_is_refused_with_the_reason(compiler, flag, generated) -> None:
    needs(compiler)
    done = run([compiler, flag, "-fsyntax-only", "ukwial_nullspace.c"], generated)
    assert done.returncode != 0
    assert "without -ffast-math" in done.stderr


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_every_file_with_a_scalar_of_too_few_digits_is_refused_with_the_reason(compiler, generated) -> None:
    """Kernels, ESCs and self-tests; on AVR a double has 24 bits, and a compiler says nothing."""
    needs(compiler)
    few = {"double": "__DBL_MANT_DIG__=24", "float": "__FLT_MANT_DIG__=11"}
    seen = set()
    for path in (*generated.glob("*_*.c"), *generated.glob("test/*.c")):
        scalar = "float" if "_float" in path.name else "double"
        for changed, macro in few.items():
            options = [f"-U{macro.partition('=')[0]}", f"-D{macro}", "-Wno-builtin-macro-redefined"]
            done = run([compiler, *options, "-I.", "-E", "-o", os.devnull, str(path)], generated)
            assert (f"A {scalar} of this compiler has fewer" in done.stderr) == (changed == scalar), path.name
            seen.add((scalar, changed, "_esc" in path.name, "_test" in path.name))
    assert len(seen) == 16


def test_avr_s_compiler_takes_float_and_refuses_double(generated) -> None:
    if shutil.which("avr-gcc") is None:
        not_asked("avr-gcc is not here; the test above asks the same lines of another compiler")
    for path in (*generated.glob("*_nullspace*.c"), *generated.glob("test/*_nullspace*.c")):
        command = ["avr-gcc", "-mmcu=atmega2560", "-std=c99", "-Os", "-Wall", "-Wextra", "-Werror", "-I."]
        done = run([*command, "-c", str(path), "-o", "avr.o"], generated)
        if "_float" in path.name:
            assert (done.returncode, done.stderr) == (0, "")
        else:
            assert "generate the C with --float" in done.stderr


HARD = ["-mthumb", "-mfloat-abi=hard"]
M7 = ["arm-none-eabi-gcc", "-mcpu=cortex-m7", *HARD]
CLANG = ["clang", "--target=arm-none-eabi", *HARD]
SINGLE, DOUBLE = "-mfpu=fpv5-sp-d16", "-mfpu=fpv5-d16"
CROSS = {
    "Cortex-M4F": (["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", *HARD], "float", None),
    "Cortex-M33": (["arm-none-eabi-gcc", "-mcpu=cortex-m33", SINGLE, *HARD], "float", "vminnm.f32"),
    "Cortex-M7, doubles": ([*M7, DOUBLE], "double", "vminnm.f64"),
    "Cortex-M7, doubles, asked for floats": ([*M7, DOUBLE], "float", "vminnm.f32"),
    "Cortex-M7, floats, GCC not told": ([*M7, SINGLE], "float", None),
    "Cortex-M7, floats, GCC told": ([*M7, SINGLE, "-DTHRUSTBENCH_FPV5"], "float", "vminnm.f32"),
    "Cortex-M7, floats, Clang": ([*CLANG, "-mcpu=cortex-m7", SINGLE], "float", "vminnm.f32"),
    "Cortex-M4F, Clang": ([*CLANG, "-mcpu=cortex-m4"], "float", None),
    "aarch64": (["aarch64-linux-gnu-gcc"], "double", "fminnm"),
    "x86-64": (["gcc"], "double", "minsd"),
}


@pytest.mark.parametrize("target", CROSS)
def test_a_minimum_is_one_instruction_where_the_target_has_it_and_never_a_call(target, generated) -> None:
    command, scalar, instruction = CROSS[target]
    needs(command[0])
    if target == "x86-64" and "x86_64" not in run(["gcc", "-dumpmachine"], generated).stdout:
        pytest.skip("gcc makes no code for x86-64 here")
    name = "ukwial_nullspace.c" if scalar == "double" else "ukwial_nullspace_float.c"
    done = run([*command, "-std=c99", "-O2", "-ffreestanding", "-S", "-o", "-", name], generated)
    assert done.returncode == 0, done.stderr[:2000]
    assert (instruction or "vcmp") in done.stdout
    assert instruction or "minnm" not in done.stdout
    assert not re.search(r"\bf(min|max)f?\b", done.stdout)


SOFT = ["-mthumb", "-mcpu=cortex-m3"]
ASSEMBLER, HEADED = "does not support `vrinta.f32 s0,s0'", "leave it out"
TOLD = {
    "Cortex-M4F": (CROSS["Cortex-M4F"][0], ASSEMBLER),
    "Cortex-M7 with the FPU of a Cortex-M4": ([*M7, "-mfpu=fpv4-sp-d16"], ASSEMBLER),
    "Cortex-M4F, Clang": ([*CLANG, "-mcpu=cortex-m4"], HEADED),
    "Cortex-M3": (["arm-none-eabi-gcc", *SOFT], HEADED),
    "Cortex-M3, Clang": (["clang", "--target=arm-none-eabi", *SOFT], HEADED),
    "this computer": (["gcc"], HEADED),
    "Cortex-M7, floats": ([*M7, SINGLE], ""),
    "Cortex-M7, doubles": ([*M7, DOUBLE], ""),
    "Cortex-M7, floats, Clang": ([*CLANG, "-mcpu=cortex-m7", SINGLE], ""),
    "Cortex-M33": (CROSS["Cortex-M33"][0], ""),
    "aarch64": (["aarch64-linux-gnu-gcc"], ""),
}
"""Compilers that are told THRUSTBENCH_FPV5, and their words where the processor is another."""


@pytest.mark.parametrize("target", TOLD)
def test_float_c_that_is_told_of_an_fpu_compiles_for_that_fpu_only(target: str, generated: Path) -> None:
    """On a Cortex-M4F it called fminf of the mathematical library, without a word."""
    command, words = TOLD[target]
    needs(command[0])
    if target == "this computer" and "x86_64" not in run(["gcc", "-dumpmachine"], generated).stdout:
        pytest.skip("an Arm may have that FPU")
    for name in ("ukwial_nullspace_float.c", "bluerov2_heavy_scaled_call_float_esc.c"):
        options = ["-std=c99", "-O2", "-ffreestanding", "-DTHRUSTBENCH_FPV5", *WARNINGS]
        done = run([*command, *options, "-c", name, "-o", "told.o"], generated)
        assert (done.returncode == 0) == (words == ""), done.stderr[:2000]
        assert words in done.stderr


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_literal_is_decimal_and_read_back_as_the_same_number(x) -> None:
    text = number(x, "double")
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]\d+)?", text)
    assert re.search("[.e]", text)  # else an int
    assert float(text) == x


def test_a_literal_of_a_float_is_the_same_number_read_as_float_or_as_double_first() -> None:
    """Random bits, as one or two numbers in a hundred need the ninth digit."""
    for x in np.random.default_rng(6).integers(0, 0x7F7FFFFF, 20_000, dtype=np.uint32).view(np.float32):
        text = number(float(x), "float")
        assert text.endswith("F")
        assert np.float32(text[:-1]) == np.float32(float(text[:-1])) == x
