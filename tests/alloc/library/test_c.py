"""The C of libthrustbench: its self-test under sanitizers, every standard, beside generated C in one unit."""

from functools import cache
from pathlib import Path

import pytest

from alloc import load_vehicle
from alloc.c import Target, sources
from alloc.library import files, selftest
from alloc.methods import recipe
from alloc.program import Scalar
from tests.alloc.c.test_linkable import COMPILERS
from tests.compilers import WARNINGS, needs, run, write

SIZES = [
    ("double", 8, 6),
    *(
        pytest.param(*each, marks=pytest.mark.long)
        for each in (("float", 8, 6), ("double", 4, 3), ("float", 12, 6))
    ),
]
"""Scalars, TB_N_MAX and TB_K_MAX."""
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]


def said_of(folder: Path, made: dict[str, str], *options: str) -> str:
    """Output of this C's self-test, and its exit code; raises where it can't be built."""
    write(folder, made | selftest())
    units = [path.name for path in folder.glob("*.c")]
    command = ["gcc", "-std=c99", "-ffp-contract=off", *options, *WARNINGS, *units, *selftest(), "-o", "t"]
    built = run(command, folder)
    assert built.returncode == 0, built.stderr[:2000]
    done = run(["./t"], folder)
    return done.stdout + done.stderr + f"exit {done.returncode}"


@pytest.mark.parametrize(("scalar", "n_max", "k_max"), SIZES)
def test_the_self_test_finds_nothing_wrong_and_sanitizers_neither(
    scalar: Scalar, n_max: int, k_max: int, tmp_path: Path
) -> None:
    needs("gcc")
    said = said_of(tmp_path, files(scalar, n_max, k_max), "-O1", *SANITIZED)
    assert ", 0 wrong, " in said
    assert said.endswith("exit 0")


SABOTAGED = {
    "a thrust beyond a limit stays there": ("t->x[p] = x < low ? low : high;", ""),
    "z of a block is cut in half": ("low > 0 ? low : high;", "(low > 0 ? low : high) / 2;"),
    "a row is never taken out of the active set": ("r[j] > TB_EPS &&", "r[j] > TB_LARGEST &&"),
    "limits may be missed by a percent": ("4 * TB_EPS * a->scale, &side", "TB_R(0.01) * a->scale, &side"),
    "steps count twice at facets": ("size = tb_abs(along);", "size = 2 * tb_abs(along);"),
    "so do they on a way that has begun": ("slack += a->along[e] *", "slack += TB_R(0.5) * a->along[e] *"),
    "a facet has the room of the other side": ("margin[along > 0 ? 0 : 1]", "margin[along > 0 ? 1 : 0]"),
    "a failed thruster works on": ("!(off >> i & 1UL)", "!(off >> i & 2UL)"),
    "a fault of no thruster is taken": ("mask >> (a->n - 1) >> 1 ?", "mask >> 31 >> 1 ?"),
    "the effort is not weighed": ("share += a->N[p][j] * costs[p];", "share += 0 * costs[p];"),
    "shares of levels are exchanged": ("back[i] * part[l];", "back[i] * part[levels - 1 - l];"),
    "NaN is not looked for": ("a->k) ? status : TB_NOT_FINITE", "a->k) ? status : status"),
}  # fmt: skip


OFTEN = {"a failed thruster works on"}
"""Each takes a compiler seconds; the others are asked with ``-m long``."""


@pytest.mark.parametrize(
    "sabotage", [pytest.param(each, marks=() if each in OFTEN else pytest.mark.long) for each in SABOTAGED]
)
def test_the_self_test_finds_what_is_broken(sabotage: str, tmp_path: Path) -> None:
    needs("gcc")
    before, after = SABOTAGED[sabotage]
    made = {name: text.replace(before, after) for name, text in files().items()}
    assert made != files()
    assert not said_of(tmp_path, made).endswith("exit 0")


@cache
def beside(scalar: Scalar) -> dict[str, str]:
    """Generated C, without its self-test."""
    return sources(Target(vehicle=load_vehicle("ukwial"), method=recipe("scaled"), scalar=scalar))


def compiled(compiler: str, standard: str, units: list[str], folder: Path) -> None:
    """Compile it in both scalars, beside generated C; raises where there is a warning."""
    needs(compiler)
    language = ["-x", "c++"] if "+" in compiler else []
    for scalar in ("double", "float"):
        place = folder / scalar
        write(place, files(scalar) | selftest() | beside(scalar))
        names = sorted(path.name for path in place.glob("*.c"))
        write(place, {"all.c": "".join(f'#include "{name}"\n' for name in names)})
        done = run([compiler, f"-std={standard}", *WARNINGS, *language, *units], place)
        assert done.returncode == 0, done.stderr[:2000]


@pytest.mark.parametrize(("compiler", "standard"), COMPILERS)
def test_it_is_clean_under_every_standard_in_one_unit_with_generated_c(
    compiler: str, standard: str, tmp_path: Path
) -> None:
    compiled(compiler, standard, ["-fsyntax-only", "all.c", *selftest()], tmp_path)


@pytest.mark.long
@pytest.mark.parametrize(
    ("compiler", "standard"), [("gcc", "c17"), ("clang", "c17"), ("g++", "c++20"), ("clang++", "c++20")]
)
def test_optimizers_see_nothing_that_is_never_set(compiler: str, standard: str, tmp_path: Path) -> None:
    """They see it where functions are put into each other, whatever the standard."""
    compiled(
        compiler, standard, ["-O2", "-c", *sorted(name for name in files() if name.endswith(".c"))], tmp_path
    )


def test_fast_math_is_refused_with_the_reason(tmp_path: Path) -> None:
    needs("gcc")
    write(tmp_path, files())
    done = run(["gcc", "-Ofast", "-fsyntax-only", "tb_exact.c"], tmp_path)
    assert "without -ffast-math" in done.stderr


@pytest.mark.parametrize(
    ("scalar", "macro", "remedy"),
    [("double", "__DBL_MANT_DIG__=24", "define TB_FLOAT"), ("float", "__FLT_MANT_DIG__=11", "24 bits")],
)
def test_a_scalar_of_too_few_digits_is_refused_in_every_file(
    scalar: Scalar, macro: str, remedy: str, tmp_path: Path
) -> None:
    needs("gcc")
    made = files(scalar) | selftest()
    write(tmp_path, made)
    options = [f"-U{macro.partition('=')[0]}", f"-D{macro}", "-fsyntax-only"]
    for name in made:
        done = run(["gcc", *options, name], tmp_path)
        assert remedy in done.stderr or name.endswith(".h"), name


def test_sizes_that_it_has_no_room_for_are_refused(tmp_path: Path) -> None:
    needs("gcc")
    write(tmp_path, files(n_max=33))
    done = run(["gcc", "-fsyntax-only", "tb_exact.c"], tmp_path)
    assert "TB_N_MAX" in done.stderr
