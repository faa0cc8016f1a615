"""``codegen --library`` writes packages that build systems build, test, install and find."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from alloc.library import NAME, generate
from bench.commands.codegen import command
from tests.alloc.c.test_packages import do
from tests.compilers import WARNINGS, needs, run, write

USER = f"""\
cmake_minimum_required(VERSION 3.10)
project(rov CXX C)
find_package({NAME} REQUIRED)
add_executable(rov main.cpp)
target_link_libraries(rov {NAME}::{NAME})
"""
MAIN = f"""\
#include <{NAME}.h>

int main()
{{
    const tb_real T[2] = {{1, 1}}, low[2] = {{-4, -4}}, high[2] = {{4, 4}}, tau[1] = {{6}};
    static tb_allocator a;
    tb_real f[2];
    if (tb_prepare(&a, 1, 2, T, nullptr, nullptr, low, high) != TB_SOLVED) return 1;
    return tb_nullspace(&a, tau, nullptr, nullptr, f) != TB_SOLVED || f[0] != 3 || f[1] != 3;
}}
"""


def codegen(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(command, arguments)
    return done.exit_code, done.output


@pytest.mark.parametrize("kind", ["cmake", pytest.param("ros2", marks=pytest.mark.long)])
def test_it_is_built_tested_installed_and_found_by_a_cpp_program(kind: str, tmp_path: Path) -> None:
    status, said = codegen("--library", "--float", "--package", kind, "--out", str(tmp_path / "src"))
    assert status == 0
    assert ("--maintainer" in said) == (kind == "ros2")
    if kind == "ros2":
        assert f"Finished <<< {NAME}" in do("colcon", "build", cwd=tmp_path)
        there = tmp_path / "install" / NAME
    else:
        there = tmp_path / "there"
        place = tmp_path / "src" / NAME
        do("cmake", "-S", ".", "-B", "build", f"-DCMAKE_INSTALL_PREFIX={there}", cwd=place)
        do("cmake", "--build", "build", "--target", "install", cwd=place)
        assert "0 tests failed out of 1" in do("ctest", cwd=place / "build")
        assert not list((there / "include").glob("*internal*"))
    write(tmp_path / "rov", {"CMakeLists.txt": USER, "main.cpp": MAIN})
    do("cmake", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={there}", cwd=tmp_path / "rov")
    do("cmake", "--build", "build", cwd=tmp_path / "rov")
    do("./build/rov", cwd=tmp_path / "rov")


def test_package_xml_names_who_was_named(tmp_path: Path) -> None:
    who = "Ann & Bo <ann@rov.example>"
    status, said = codegen("--library", "--package", "ros2", "--maintainer", who, "--out", str(tmp_path))
    maintainer = ElementTree.parse(tmp_path / NAME / "package.xml").getroot().find("maintainer")
    assert maintainer is not None
    assert (maintainer.text, maintainer.get("email")) == ("Ann & Bo", "ann@rov.example")
    assert (status, "--maintainer" in said) == (0, False)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--library", "--method", "scaled"], "--library"),
        (["--library", "--limits", "call"], "--library"),
        (["--method", "scaled"], "--vehicle"),
        (["--vehicle", "ukwial"], "--method"),
    ],
)
def test_what_does_not_go_together_is_refused(arguments: list[str], named: str, tmp_path: Path) -> None:
    status, said = codegen(*arguments, "--out", str(tmp_path / "none"))
    assert status == 2
    assert named in said
    assert not (tmp_path / "none").exists()


def test_a_vehicle_says_for_how_many_there_is_room(tmp_path: Path) -> None:
    assert codegen("--library", "--vehicle", "ukwial", "--out", str(tmp_path))[0] == 0
    header = (tmp_path / f"{NAME}.h").read_text(encoding="utf-8")
    assert "#define TB_N_MAX 4\n" in header
    assert "#define TB_K_MAX 3\n" in header


def test_the_page_s_program_compiles(tmp_path: Path) -> None:
    needs("gcc")
    made = generate()
    (program,) = re.findall(r"```c\n(.*?)```", made[f"{NAME}.md"], flags=re.DOTALL)
    write(tmp_path, made | {"page.c": program})
    done = run(["gcc", "-std=c99", *WARNINGS, "-fsyntax-only", "page.c"], tmp_path)
    assert done.returncode == 0, done.stderr
