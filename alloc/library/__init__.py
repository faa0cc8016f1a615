"""libthrustbench: C that prepares an allocator at boot, for a matrix that is known at run time only."""

import re
from functools import cache
from importlib import resources

from alloc.program import Scalar

NAME = "libthrustbench"
N_MAX, K_MAX = 8, 6
"""Its sizes where nothing says otherwise: thrusters and axes."""


def files(scalar: Scalar = "double", n_max: int = N_MAX, k_max: int = K_MAX) -> dict[str, str]:
    """Its C, by file name; ``libthrustbench.h``, for users, begins with what was chosen."""
    chosen = {"TB_N_MAX": str(n_max), "TB_K_MAX": str(k_max)} | (
        {"TB_FLOAT": ""} if scalar == "float" else {}
    )
    lines = (
        f"#ifndef {name}\n#define {name} {value}".rstrip() + "\n#endif\n" for name, value in chosen.items()
    )
    return _texts() | {f"{NAME}.h": "".join(lines) + _texts()[f"{NAME}.h"]}


def selftest() -> dict[str, str]:
    """A program that holds answers on vehicles drawn at random against their equations, by file name."""
    name = f"test/{NAME}_test.c"
    return {name: (resources.files(__name__) / name).read_text(encoding="utf-8")}


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
