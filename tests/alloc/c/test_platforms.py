"""PlatformIO's builder and Zephyr's Kconfig take the packages that are for them.

Both come from PyPI: ``pio`` with SCons, which it runs, and kconfiglib, whose parser Zephyr carries. What
``pio`` would download, and what only a tree of Zephyr has, are stand-ins of ours.
"""

import json
from importlib.metadata import version
from pathlib import Path

import pytest

from alloc import library
from alloc.c import Package
from tests.alloc.c.test_packages import do, package
from tests.compilers import needs, write

pytestmark = pytest.mark.long

NAME = "ukwial_scaled_float"
MAIN = f"""\
#include <{NAME}.h>
#include <{library.NAME}.h>

int main()
{{
    const tb_real T[2] = {{1, 1}}, low[2] = {{-4, -4}}, high[2] = {{4, 4}};
    const float tau[3] = {{10, 5, 2}};
    float f[4], share[1];
    static tb_allocator a;
    if (tb_prepare(&a, 1, 2, T, nullptr, nullptr, low, high) != TB_SOLVED) return 1;
    if (tb_nullspace(&a, tau, nullptr, nullptr, f) != TB_INFEASIBLE) return 2;
    return {NAME}(tau, -1, f, share) != TB_SOLVED;
}}
"""


def packages(kind: Package) -> dict[str, str]:
    """A vehicle's and the library's."""
    return package(kind) | library.generate("float", package=kind)


NATIVE = {
    "platform.json": json.dumps(
        {"name": "native", "title": "Native", "version": "1.0.0", "description": "", "packages": {}}
    ),
    "platform.py": """\
from platformio.public import PlatformBase


class NativePlatform(PlatformBase):
    pass
""",
    "builder/main.py": """\
from SCons.Script import Default, DefaultEnvironment

env = DefaultEnvironment()
env.Replace(PROGNAME="program")
env.Append(CCFLAGS=["-Wall", "-Wextra", "-Wconversion", "-Werror"])
Default([env.BuildProgram()])
""",
}
"""A platform of this machine's compilers; PlatformIO's own comes from its registry."""
SCONS = {
    "package.json": json.dumps(
        {"name": "tool-scons", "version": "4.41101.0", "description": "", "system": "*"}
    ),
    ".piopm": json.dumps(
        {
            "type": "tool",
            "name": "tool-scons",
            "version": "4.41101.0",
            "spec": {
                "owner": "platformio",
                "id": None,
                "name": "tool-scons",
                "requirements": None,
                "uri": None,
            },
        }
    ),
    "scons.py": "from SCons.Script import main\n\nmain()\n",
}
"""SCons of PyPI where PlatformIO 6.2 looks for what it would download."""


@pytest.mark.parametrize("kind", ["platformio", "arduino"])
def test_platformio_finds_both_in_lib_and_links_them(kind: Package, tmp_path: Path) -> None:
    """It reads Arduino's library.properties too, whose own tools are no Python packages."""
    write(tmp_path / "native", NATIVE)
    write(tmp_path / "core/packages/tool-scons", SCONS)
    write(tmp_path / "rov/lib", packages(kind))
    ini = f"[env:native]\nplatform = {tmp_path / 'native'}\n"
    ini += "lib_compat_mode = off\n" * (kind == "arduino")  # else it takes them with Arduino's framework only
    write(tmp_path / "rov", {"platformio.ini": ini, "src/main.cpp": MAIN})
    needs("pio")
    own = f"PLATFORMIO_CORE_DIR={tmp_path / 'core'}", "PLATFORMIO_SETTING_ENABLE_TELEMETRY=no"
    nowhere = [
        f"{name}=http://127.0.0.1:9" for name in ("http_proxy", "https_proxy")
    ]  # nothing is downloaded
    built = do("env", *own, *nowhere, "pio", "run", cwd=tmp_path / "rov")
    for name in (NAME, library.NAME):
        assert f"|-- {name} @ {version('thrustbench')}" in built
    do("./.pio/build/native/program", cwd=tmp_path / "rov")


KCONFIG = """\
config CPU_HAS_FPU
	bool "A processor with an FPU"
config FPU
	bool
	depends on CPU_HAS_FPU
"""
ZEPHYR = """\
cmake_minimum_required(VERSION 3.13)
project(rov C CXX)
add_library(zephyr_interface INTERFACE)
macro(zephyr_library)
  string(MAKE_C_IDENTIFIER "${CMAKE_CURRENT_SOURCE_DIR}" library)
  add_library(${library} STATIC)
  target_link_libraries(zephyr_interface INTERFACE ${library})
endmacro()
macro(zephyr_library_sources)
  target_sources(${library} PRIVATE ${ARGN})
endmacro()
macro(zephyr_library_compile_options)
  target_compile_options(${library} PRIVATE ${ARGN})
endmacro()
macro(zephyr_include_directories)
  target_include_directories(zephyr_interface INTERFACE ${CMAKE_CURRENT_SOURCE_DIR}/${ARGN})
endmacro()
file(STRINGS .config lines REGEX "=y$")
foreach(line ${lines})
  string(REPLACE "=y" "" option ${line})
  set(${option} y)
endforeach()
"""
"""Functions of Zephyr's cmake/modules/extensions.cmake that a module calls."""


@pytest.mark.parametrize(("chosen", "options"), [("allyesconfig", 2), ("allnoconfig", 0)])
def test_zephyr_s_kconfig_switches_both_on_and_off(chosen: str, options: int, tmp_path: Path) -> None:
    write(tmp_path, packages("zephyr"))
    names = (NAME, library.NAME)
    kconfig = KCONFIG + "".join(
        f'menu "{name}"\nosource "{name}/zephyr/Kconfig"\nendmenu\n' for name in names
    )
    cmake = ZEPHYR + "".join(f"add_subdirectory({name}/zephyr)\n" for name in names)
    cmake += "add_executable(rov main.cpp)\ntarget_link_libraries(rov zephyr_interface)\n"
    write(tmp_path, {"Kconfig": kconfig, "CMakeLists.txt": cmake, "main.cpp": MAIN})
    do(chosen, "Kconfig", cwd=tmp_path)
    config = (tmp_path / ".config").read_text(encoding="utf-8").splitlines()
    assert sum(f"CONFIG_{name.upper()}=y" in config for name in names) == options
    assert ("CONFIG_FPU=y" in config) == (options > 0)
    if options:
        do("cmake", "-S", ".", "-B", "build", cwd=tmp_path)
        do("cmake", "--build", "build", cwd=tmp_path)
        do("./build/rov", cwd=tmp_path)
