"""The C that is counted: one function that answers the demands of one vehicle, and the files it needs."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from alloc.allocation import FloatArray
from alloc.files.textfile import write_folder
from alloc.program import Scalar, Where

SCALARS: dict[Scalar, str] = {"double": "<f8", "float": "<f4"}
"""C's name of a scalar to numpy's; every target here is little-endian."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Kernel:
    """A C function int entry(…) and its sources.

    Attributes
    ----------
    method : label in tables, e.g. ``nullspace@native``
    twin : the method in Python whose answers it must give
    solver : whose C it is, empty for this project's own
    scalar : ``double`` or ``float``
    k, n : length of tau and of f
    limits : whether the limits stand in the C, or f_min and f_max are arguments of each call
    entry : the function's name
    declaration : C text that declares it
    arguments : how it is called, with ``tau``, ``f_min``, ``f_max``, ``f`` and ``share``, e.g. ``tau, f``
    sources : text by file name; every .c is compiled, other files are included by these
    levels : how many shares it writes, which the driver finds behind f
    prepared : whether its first call prepares what others use, as firmware does at boot; loops over what it
        prepares go round more often than there are axes or thrusters
    """

    method: str
    twin: str
    scalar: Scalar
    k: int
    n: int
    entry: str
    declaration: str
    arguments: str
    sources: Mapping[str, str]
    solver: str = ""
    limits: Where = "fixed"
    levels: int = 0
    prepared: bool = False

    @property
    def width(self) -> int:
        """How many numbers a call takes: tau, and f_min and f_max where they are arguments."""
        return self.k + 2 * self.n if self.limits == "call" else self.k

    def calls(self, taus: FloatArray, f_min: FloatArray, f_max: FloatArray) -> FloatArray:
        """(N, width) what is given to each call: demands (N, k), with limits where they are arguments."""
        if self.limits == "fixed":
            return taus
        return np.hstack([taus, *(np.broadcast_to(side, (len(taus), self.n)) for side in (f_min, f_max))])

    @property
    def adapter(self) -> str:
        """C of ``ask_<entry>``, which the driver calls; behind tau lie limits, behind f shares."""
        places = {
            "f_min": f"(tau + {self.k})",
            "f_max": f"(tau + {self.k + self.n})",
            "share": f"(f + {self.n})",
        }
        arguments = re.sub("|".join(places), lambda name: places[name[0]], self.arguments)
        return (
            f'#include "board.h"\n#include "call.h"\n{self.declaration}\n\n'
            f"int ask_{self.entry}(const scalar *tau, scalar *f);\n"
            f"int ask_{self.entry}(const scalar *tau, scalar *f)\n"
            f"{{\n    CALL({self.entry}, ({arguments}));\n}}\n"
        )

    def write(self, folder: Path) -> list[Path]:
        """Write the kernel's own sources into ``folder``; returns those to compile."""
        write_folder(folder, self.sources)
        return sorted(folder / name for name in self.sources if name.endswith(".c"))


def shapes(kernels: Sequence[Kernel]) -> str:
    """project.h, which tells the driver what calls take and answer: all kernels of one vehicle and scalar."""
    first = kernels[0]
    bits = {"double": "uint64_t", "float": "uint32_t"}[first.scalar]
    sizes = {"WIDTH": first.width, "N": first.n, "SHARES": max(kernel.levels for kernel in kernels)}
    return (
        f"typedef {first.scalar} scalar;\ntypedef {bits} scalar_bits;\n"
        f"enum {{ {', '.join(f'BOARD_{name} = {size}' for name, size in sizes.items())} }};\n"
    )


def braced(values: FloatArray) -> str:
    """A C initialiser of all values, row by row."""
    return f"{{{', '.join(repr(value) for value in values.ravel().tolist())}}}"
