"""libthrustbench: C that prepares an allocator at boot, for a matrix that is known at run time only."""

import re
from functools import cache
from importlib import resources

from alloc.c import Package, packaged
from alloc.c.text import IN_C
from alloc.program import Scalar
from alloc.vehicle import Vehicle

NAME = "libthrustbench"
N_MAX, K_MAX = 8, 6
"""Its sizes where nothing says otherwise: thrusters and axes."""


def generate(
    scalar: Scalar = "double",
    vehicle: Vehicle | None = None,
    package: Package | None = None,
    maintainer: str = "",
) -> dict[str, str]:
    """The library as ``thrustbench codegen --library`` writes it: its C, a self-test, a page, by file name.

    Parameters
    ----------
    scalar : ``double`` or ``float``, the type of all numbers
    vehicle : the largest that it shall have room for; left out, N_MAX thrusters and K_MAX axes
    package, maintainer : as of ``alloc.generate``
    """
    made = files(scalar, *room(vehicle)) | selftest() | {f"{NAME}.md": _text(f"{NAME}.md")}
    about = "Thrust allocation for matrices that are known at run time"
    return packaged(package, NAME, made, about, maintainer) if package else made


def room(vehicle: Vehicle | None) -> tuple[int, int]:
    """Most thrusters and axes that it has room for, with a vehicle as the largest or with none given."""
    return (N_MAX, K_MAX) if vehicle is None else (max(vehicle.n, vehicle.k, 2), vehicle.k)


def files(scalar: Scalar = "double", n_max: int = N_MAX, k_max: int = K_MAX) -> dict[str, str]:
    """Its C, by file name; ``libthrustbench.h``, for users, begins with what was chosen."""
    chosen = {"TB_N_MAX": str(n_max), "TB_K_MAX": str(k_max)} | (
        {"TB_FLOAT": ""} if scalar == "float" else {}
    )
    lines = (
        f"#ifndef {name}\n#define {name} {value}".rstrip() + "\n#endif\n" for name, value in chosen.items()
    )
    chosen_first = {f"{NAME}.h": "".join(lines) + _texts()[f"{NAME}.h"]}
    return {name: f"{IN_C}\n{text}" for name, text in (_texts() | chosen_first).items()}


def selftest() -> dict[str, str]:
    """A program that holds answers on vehicles drawn at random against their equations, by file name."""
    name = f"test/{NAME}_test.c"
    return {name: f"{IN_C}\n{_text(name)}"}


def _text(name: str) -> str:
    return (resources.files(__name__) / name).read_text(encoding="utf-8")


@cache
def _texts() -> dict[str, str]:
    found = sorted(resources.files(__name__).iterdir(), key=lambda file: file.name)
    return {file.name: file.read_text(encoding="utf-8") for file in found if file.name.endswith((".c", ".h"))}


@cache
def calls() -> dict[str, bool]:
    """The methods that it answers, as its header declares them, and whether they write shares."""
    declared = re.findall(
        r"int tb_(\w+)\(const struct tb_allocator ([^;]*)\);", _texts()[f"{NAME}.h"], flags=re.DOTALL
    )
    return {name: "share" in parameters for name, parameters in declared}
