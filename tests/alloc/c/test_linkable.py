"""Generated C goes into anybody's program: every standard, C++, one translation unit, every FPU."""

import re
import shutil
import subprocess
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from alloc import build, generate, load_vehicle
from alloc.program.literal import number

WARNINGS = [
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Wundef", "-Werror",
]  # fmt: skip
C, CPP = ("c99", "c11", "c17", "gnu11", "gnu17"), ("c++11", "c++14", "c++17", "c++20")
SPAN = {("gcc", "c99"), ("clang", "gnu17"), ("g++", "c++20"), ("clang++", "c++11")}
"""The oldest and the newest standard of both languages; those between are asked with ``-m long``."""
COMPILERS = [
    pytest.param(compiler, standard, marks=() if (compiler, standard) in SPAN else pytest.mark.long)
    for compilers, standards in ((("gcc", "clang"), C), (("g++", "clang++"), CPP))
    for compiler, standard in product(compilers, standards)
]
ALONE = {("gcc", "c99"), ("g++", "c++20")}
"""Where each file is compiled by itself too; all compilers find the same includes missing."""
METHODS = ("nullspace", "scaled", "redistribute", "pinv")
"""Between them they have all that C can be made of: branches, loops over data, shares, no status."""
SHAPES = [("double", "fixed"), ("float", "call"), ("double", "call"), ("float", "fixed")]


def needs(*commands: str) -> None:
    """Skip where a compiler is missing."""
    for command in commands:
        if shutil.which(command) is None:
            pytest.skip(f"needs {command}")


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two vehicles, four methods, two scalars, limits fixed and of the call; all.c includes every source.

    The larger vehicle, slowest to compile, has two methods, each scalar and each kind of limits once.
    """
    folder = tmp_path_factory.mktemp("c")
    for name, made in (
        ("ukwial", product(METHODS, SHAPES)),
        ("bluerov2-heavy", zip(("nullspace", "scaled"), SHAPES[2:], strict=True)),
    ):
        vehicle = load_vehicle(name)
        for method, (scalar, limits) in made:
            write(folder, generate(vehicle, method, scalar=scalar, limits=limits, esc=bool(vehicle.esc)))
    sources = sorted(path.name for path in folder.glob("*.c"))
    assert len(sources) == 20
    write(folder, {"all.c": "".join(f'#include "{name}"\n' for name in sources)})
    return folder


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_what_is_asked_of_several_conditions_stands_in_brackets(compiler: str, tmp_path: Path) -> None:
    """Clang warns of a & b ? c : d; a vehicle that can't push every axis asks so for its status."""
    needs(compiler)
    files = generate(load_vehicle("bluerov2"), "scaled")
    assert any(") & (" in text for text in files.values())
    write(tmp_path, files)
    sources = [path.name for path in tmp_path.glob("*.c")]
    done = run([compiler, "-std=c99", *WARNINGS, "-I.", "-fsyntax-only", *sources], tmp_path)
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


LOOP = """\
#include <cstdio>
#include "bluerov2_heavy_scaled_float.h"
#include "ukwial_nullspace.h"
#include "ukwial_scaled_call.h"
// Names that the generated files must not take.
enum {{ SOLVED = 7, NOT_FINITE = 8 }};
static int finite(int x) {{ return x; }}
static int least(int x) {{ return x; }}

int main()
{{
    const double tau[3] = {{{tau}}}, low[4] = {{-40, -50, -60, -70}}, high[4] = {{40, 50, 60, 70}};
    const float heavy[6] = {{10, -5, 20, 1, 2, -3}};
    double f[4], share[1];
    float g[8], part[1];
    if (ukwial_nullspace(tau, -1, f) != TB_SOLVED || finite(SOLVED) + least(NOT_FINITE) != 15) return 1;
    for (double each : f) std::printf("%.17g ", each);
    if (ukwial_scaled_call(tau, low, high, 2, f, share) != TB_PARTIAL) return 2;
    for (double each : f) std::printf("%.17g ", each);
    if (bluerov2_heavy_scaled_float(heavy, 3, g, part) != TB_SOLVED) return 3;
    for (float each : g) std::printf("%.9g ", static_cast<double>(each));
    return ukwial_nullspace(tau, 4, f) == TB_NO_SUCH_FAULT ? 0 : 4;
}}
"""


@pytest.mark.parametrize("whole", [False, True], ids=["object by object", "one translation unit"])
@pytest.mark.parametrize(("c", "cpp"), [("gcc", "g++"), ("clang", "clang++")])
def test_a_cpp_program_links_two_vehicles_two_scalars_and_two_methods_and_gets_python_s_thrusts(
    c, cpp, whole, generated, tmp_path
) -> None:
    needs(c, cpp)
    tau = np.array([60.0, 40.0, 20.0])
    write(tmp_path, {"loop.cpp": LOOP.format(tau=", ".join(map(str, tau)))})
    own = [str(generated / f"{name}.c") for name in
           ("ukwial_nullspace", "ukwial_scaled_call", "bluerov2_heavy_scaled_float")]  # fmt: skip
    flags = ["-O1", "-I", str(generated), *WARNINGS]
    units = [str(generated / "all.c")] if whole else own
    # One unit holds what the program does not call too, but nothing that another could see twice.
    for step in (
        [c, "-std=gnu17", *flags, "-c", *units],
        [cpp, "-std=c++11", *flags, "loop.cpp", *[f"{Path(unit).stem}.o" for unit in units], "-o", "loop"],
        ["./loop"],
    ):
        done = run(step, tmp_path)
        assert done.returncode == 0, (step, done.stderr[:2000])
    printed = np.array([float(word) for word in done.stdout.split()])
    ukwial, heavy = load_vehicle("ukwial"), load_vehicle("bluerov2-heavy")
    ends = np.array([40.0, 50.0, 60.0, 70.0])
    expected = [
        build("nullspace", ukwial)(tau).f,
        build("scaled", ukwial.with_fault(2))(tau, -ends, ends).f,
        build("scaled", heavy.with_fault(3))(np.array([10.0, -5, 20, 1, 2, -3])).f,
    ]
    np.testing.assert_allclose(printed[:8], np.concatenate(expected[:2]), rtol=0, atol=1e-10 * ukwial.f_scale)
    # Single precision: a few dozen roundings of 6e-8.
    np.testing.assert_allclose(printed[8:], expected[2], rtol=0, atol=1e-5 * heavy.f_scale)


@pytest.mark.parametrize("flag", ["-ffast-math", "-Ofast", "-ffinite-math-only"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_fast_math_is_refused_with_the_reason(compiler, flag, generated) -> None:
    needs(compiler)
    done = run([compiler, flag, "-fsyntax-only", "ukwial_nullspace.c"], generated)
    assert done.returncode != 0
    assert "without -ffast-math" in done.stderr


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


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_literal_is_decimal_and_read_back_as_the_same_number(x) -> None:
    text = number(x, "double")
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]\d+)?", text)
    assert re.search("[.e]", text)  # else an int
    assert float(text) == x


def test_a_literal_of_a_float_is_the_same_number_read_as_float_or_as_double_first() -> None:
    """Of bits at random, as one or two numbers in a hundred need the ninth digit."""
    for x in np.random.default_rng(6).integers(0, 0x7F7FFFFF, 20_000, dtype=np.uint32).view(np.float32):
        text = number(float(x), "float")
        assert text.endswith("F")
        assert np.float32(text[:-1]) == np.float32(float(text[:-1])) == x
