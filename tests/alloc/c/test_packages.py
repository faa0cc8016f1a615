"""Packages of generated C are built, installed and linked by the build systems that they are for.

CMake and colcon run where they are installed, PlatformIO and Zephyr's Kconfig in test_platforms.py; here
their files, and Arduino's, are read against what their documents ask for.
"""

import json
import os
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import get_args
from xml.etree import ElementTree

import pytest
import yaml

from alloc import generate, library, load_vehicle
from alloc.c import Package
from tests.compilers import needs, write

NAME = "ukwial_scaled_float"
MAIN = """\
#include <ukwial_scaled_float.h>

int main()
{
    const float tau[3] = {10, 5, 2};
    float f[4], share[1];
    return ukwial_scaled_float(tau, -1, f, share) == TB_SOLVED ? 0 : 1;
}
"""


@cache
def package(kind: Package) -> dict[str, str]:
    """The files of a package."""
    return generate(load_vehicle("ukwial"), "scaled", scalar="float", package=kind)


def unpacked(kind: Package, folder: Path) -> Path:
    """The package on disk."""
    write(folder, package(kind))
    assert [path.name for path in folder.iterdir()] == [NAME]
    return folder / NAME


def do(*command: str, cwd: Path) -> str:
    """Output of a command; skips without it, or without the compiler that CMake then takes."""
    needed = [] if "/" in command[0] else [command[0]]  # a path is of what was built here
    if command[0] in ("cmake", "colcon"):
        needed.append(os.environ.get("CC", "cc"))
    needs(*needed)
    environment = {**os.environ, "CFLAGS": "-Wall -Wextra -Wconversion -Werror"}
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, (command, done.stdout[-2000:] + done.stderr[-2000:])
    return done.stdout


def user(folder: Path, found_by: str) -> Path:
    """A C++ project that takes the package."""
    folder.mkdir()
    (folder / "main.cpp").write_text(MAIN, encoding="utf-8")
    (folder / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.10)\nproject(rov CXX C)\n{found_by}\n"
        "add_executable(rov main.cpp)\n"
        f"target_link_libraries(rov {NAME}::{NAME})\n",
        encoding="utf-8",
    )
    return folder


def build_and_run(project: Path, *options: str) -> None:
    do("cmake", "-S", ".", "-B", "build", *options, cwd=project)
    do("cmake", "--build", "build", cwd=project)
    do("./build/rov", cwd=project)


def test_cmake_builds_it_tests_it_and_installs_what_find_package_finds(tmp_path: Path) -> None:
    place = unpacked("cmake", tmp_path)
    do("cmake", "-S", ".", "-B", "build", f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'there'}", cwd=place)
    do("cmake", "--build", "build", "--target", "install", cwd=place)
    assert "1 tests passed" in do("ctest", cwd=place / "build").replace(
        "100% tests passed, 0 tests failed out of 1", "1 tests passed"
    )
    shutil.rmtree(place)  # what was installed needs nothing of it
    build_and_run(
        user(tmp_path / "rov", f"find_package({NAME} 0.1 REQUIRED)"),
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'there'}",
    )


def test_a_package_with_escs_builds_and_tests_both_sources(tmp_path: Path) -> None:
    files = generate(load_vehicle("bluerov2"), "pinv", scalar="float", esc=True, package="cmake")
    write(tmp_path, files)
    place = tmp_path / "bluerov2_pinv_float"
    do("cmake", "-S", ".", "-B", "build", f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'there'}", cwd=place)
    do("cmake", "--build", "build", "--target", "install", cwd=place)
    assert "0 tests failed out of 2" in do("ctest", cwd=place / "build")
    assert (tmp_path / "there" / "include" / "bluerov2_pinv_float_esc.h").is_file()
    for kind, file in (("zephyr", "zephyr/CMakeLists.txt"), ("arduino", "library.properties")):
        beside = generate(load_vehicle("bluerov2"), "pinv", scalar="float", esc=True, package=kind)
        assert "bluerov2_pinv_float_esc." in beside[f"bluerov2_pinv_float/{file}"]


def test_add_subdirectory_gives_the_same_target_and_no_test_of_its_own(tmp_path: Path) -> None:
    place = unpacked("cmake", tmp_path)
    project = user(tmp_path / "rov", f"add_subdirectory({place} part)")
    build_and_run(project)
    assert not list(project.rglob(f"{NAME}_test*"))


def test_colcon_builds_it_as_plain_cmake(tmp_path: Path) -> None:
    unpacked("ros2", tmp_path / "src")
    assert f"Finished <<< {NAME}" in do("colcon", "build", cwd=tmp_path)
    build_and_run(
        user(tmp_path / "rov", f"find_package({NAME} REQUIRED)"),
        f"-DCMAKE_PREFIX_PATH={tmp_path / 'install' / NAME}",
    )


def test_package_xml_has_what_rep_149_asks_for(tmp_path: Path) -> None:
    root = ElementTree.parse(unpacked("ros2", tmp_path) / "package.xml").getroot()
    assert (root.tag, root.get("format")) == ("package", "3")
    for tag in ("name", "version", "description", "maintainer", "license"):
        assert root.findtext(tag), tag
    assert root.findtext("export/build_type") == "cmake"


def test_platformio_s_and_arduino_s_files_name_a_header_that_is_there(tmp_path: Path) -> None:
    place = unpacked("platformio", tmp_path)
    facts = json.loads((place / "library.json").read_text(encoding="utf-8"))
    assert facts["name"] == NAME
    assert [(place / header).is_file() for header in facts["headers"]] == [True]
    place = unpacked("arduino", tmp_path)
    lines = (place / "library.properties").read_text(encoding="utf-8").splitlines()
    facts = dict(line.split("=", 1) for line in lines)
    for key in (
        "version",
        "author",
        "maintainer",
        "sentence",
        "paragraph",
        "category",
        "url",
        "architectures",
    ):
        assert key in facts, key
    assert (place / facts["includes"]).is_file()
    # Both take every source of the library's root, and none of test/.
    assert {path.name for path in place.glob("*.c")} == {f"{NAME}.c"}


@pytest.mark.parametrize("cpu", ["cortex-m0plus", "cortex-m4", "cortex-m7", "cortex-m33"])
def test_an_arduino_package_names_cores_whose_processors_it_is_built_for(cpu: str, tmp_path: Path) -> None:
    """A double of the core ``avr`` has 4 bytes, and of ``esp32`` and others nothing was built."""
    place = unpacked("arduino", tmp_path)
    named = (place / "library.properties").read_text(encoding="utf-8")
    found = re.search(r"^architectures=(.+)$", named, re.MULTILINE)
    assert found
    assert "stm32" in found[1].split(",")
    assert not {"*", "avr", "esp32"} & set(found[1].split(","))
    double = generate(load_vehicle("ukwial"), "scaled", package="arduino")
    (place / "double.h").write_text(double["ukwial_scaled/ukwial_scaled.h"], encoding="utf-8")
    text = double["ukwial_scaled/ukwial_scaled.c"].replace('"ukwial_scaled.h"', '"double.h"')
    (place / "double.c").write_text(text, encoding="utf-8")
    for source in (f"{NAME}.c", "double.c"):
        command = ["arm-none-eabi-gcc", "-mthumb", f"-mcpu={cpu}", "-std=gnu11", "-Os", "-Wall", "-Werror"]
        do(*command, "-ffreestanding", "-c", source, cwd=place)


def test_zephyr_s_module_names_files_that_are_there(tmp_path: Path) -> None:
    place = unpacked("zephyr", tmp_path)
    module = yaml.safe_load((place / "zephyr" / "module.yml").read_text(encoding="utf-8"))
    # As the schema in Zephyr's scripts/zephyr_module.py wants it; it needs none of the other keys.
    assert module == {"name": NAME, "build": {"cmake": "zephyr", "kconfig": "zephyr/Kconfig"}}
    build = place / module["build"]["cmake"] / "CMakeLists.txt"
    kconfig = (place / module["build"]["kconfig"]).read_text(encoding="utf-8")
    assert f"\nconfig {NAME.upper()}\n" in kconfig
    assert f"if(CONFIG_{NAME.upper()})" in build.read_text(encoding="utf-8")
    assert (build.parent / f"../{NAME}.c").is_file()


@pytest.mark.parametrize("kind", get_args(Package))
def test_every_file_of_a_package_names_its_licence(kind: Package) -> None:
    made = generate(load_vehicle("bluerov2-heavy"), "pinv", esc=True, package=kind)
    for name, text in (made | library.generate(package=kind)).items():
        named = "SPDX-License-Identifier: MIT" if name.endswith((".c", ".h", ".txt", ".yml")) else "MIT"
        assert named in text or name.endswith(".md"), name
