"""Somebody's C allocator behind ``thrustbench_allocator.h``, counted on processors that are emulated.

The same sources are compiled for this machine too: what the emulated calls answer must be what that answers.
"""

import ctypes
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from glob import glob
from importlib import resources
from pathlib import Path

import numpy as np

from alloc import Vehicle, build
from alloc.c.selftest import AGREEMENT
from alloc.errors import FileError
from alloc.foreign.bind import HEADER, SCALARS, plugin, vehicle_numbers
from alloc.formulations import find_formulation
from alloc.program import Scalar, Where
from alloc.program.literal import number
from bench.chips.agreement import ANSWERED, Agreement
from bench.chips.count import CallCounts
from bench.chips.kernels import Kernel
from bench.chips.toolchain import run, scratch
from bench.demands import DemandSet

NUMBERS = ("T", "H", "readiness", "f_min", "f_max", "level")
"""Arrays of ``struct tba_vehicle``."""


@dataclass(frozen=True, kw_only=True)
class Foreign:
    """An allocator's C files, and how they are compiled.

    Attributes
    ----------
    name : label in tables
    sources : the files, each compiled by itself
    options : the compiler's, besides those of all C here
    """

    name: str
    sources: tuple[Path, ...]
    options: tuple[str, ...]

    @cached_property
    def library(self) -> Path:
        """The same C for this machine; raises ToolError."""
        made = Path(tempfile.mkdtemp(dir=scratch())) / "allocator.so"
        flags = ("-std=c99", "-O2", "-shared", "-fPIC", *self.options)
        run(["gcc", *flags, *map(str, self.sources), "-lm", "-o", str(made)])
        return made

    @cached_property
    def scalar(self) -> Scalar:
        """Type of its numbers, as it says it; raises PluginError of a library that does not."""
        plugin(self.library, "")
        said = SCALARS[ctypes.CDLL(str(self.library)).tba_interface()]
        return "float" if said is np.float32 else "double"


def find_sources(
    patterns: Sequence[str], include: Sequence[Path], interface: Path | None, *, single: bool
) -> Foreign:
    """The allocator whose files match the patterns; raises FileError.

    ``interface`` is its copy of the header, this project's where there is none; ``single`` defines TBA_FLOAT.
    """
    sources = [
        Path(name).absolute() for pattern in patterns for name in sorted(glob(pattern, recursive=True))
    ]
    sources = [path for path in dict.fromkeys(sources) if path.suffix == ".c" and path.is_file()]
    if not sources:
        raise FileError("matches no C file; name sources as 'src/*.c'", path=Path(patterns[0]))
    for path in sources:
        if any(other.name == path.name for other in sources if other != path):
            raise FileError("has the name of another source; give each its own", path=path)
    header = interface.absolute() if interface else Path(str(resources.files("alloc.foreign") / HEADER))
    if not header.is_file():
        raise FileError(f"is no file; name your copy of {HEADER}", path=header)
    for folder in include:
        if not folder.is_dir():
            raise FileError("is no folder; name one with headers", path=folder)
    places = dict.fromkeys([header.parent, *(folder.absolute() for folder in include)])
    options = (*(f"-I{place}" for place in places), f'-DTBA_HEADER="{header}"', *["-DTBA_FLOAT"] * single)
    return Foreign(name=patterns[0], sources=tuple(sources), options=options)


def kernel(foreign: Foreign, vehicle: Vehicle, limits: Where) -> Kernel:
    """``tba_call`` as a kernel, prepared before its first call; raises NotApplicable where it refuses to.

    In the image without it an allocator of no code stands, so that flash and RAM are all that its sources
    take, with what they call of the C library, but neither the vehicle's numbers nor the heap.
    """
    allocator = build(str(foreign.library), vehicle)
    way = find_formulation(allocator.formulation).way
    shares, scalar = len(way(vehicle).keep) if way else 0, foreign.scalar
    kind = np.float32 if scalar == "float" else np.float64
    tables, names = "", ", ".join(f"own_{key}" for key in NUMBERS)
    for key, values in zip(NUMBERS, vehicle_numbers(vehicle, kind), strict=True):
        type_, literal = ("int", str) if key == "level" else ("tba_real", partial(number, scalar=scalar))
        tables += (
            f"static const {type_} own_{key}[] = {{{', '.join(map(literal, values.ravel().tolist()))}}};\n"
        )
    dof = ", ".join(f'"{axis}"' for axis in vehicle.dof)
    k, n = vehicle.k, vehicle.n
    sides = f"tau + {k}, tau + {k + n}" if limits == "call" else "NULL, NULL"
    text = f"""\
#include TBA_HEADER
#include <stddef.h>
{tables}static const char *const own_dof[] = {{{dof}}};
static const struct tba_vehicle vehicle = {{sizeof vehicle, {k}, {n}, {names},
                                           own_dof, "{vehicle.frame}", "vehicle"}};
static struct tba_input input;
static struct tba_output output;
static void *ready(const scalar *tau, scalar *f)
{{
    static void *allocator;
    if (allocator == NULL) {{
        static const char *reason;
        allocator = PREPARED;
    }}
    input = (struct tba_input){{sizeof input, tau, {sides}}};
    output = (struct tba_output){{sizeof output, f, {f"f + {n}" if shares else "NULL"}}};
    return allocator;
}}"""
    return Kernel(
        method=foreign.name,
        twin="",
        scalar=scalar,
        k=k,
        n=n,
        entry="tba_call",
        declaration=text.replace("PREPARED", "tba_prepare(&vehicle, &reason)"),
        idle=text.replace("PREPARED", "(reason = NULL, (void *)&vehicle)"),
        before="void *const allocator = ready(tau, f);",
        arguments="allocator, &input, &output",
        sources={
            path.name: path.read_text(encoding="utf-8", errors="surrogateescape") for path in foreign.sources
        },
        options=(*foreign.options, *(f"-I{path.parent}" for path in foreign.sources)),
        limits=limits,
        levels=shares,
        prepared=True,
        library=foreign.library,
    )


def agreement(made: Kernel, demands: DemandSet, counted: CallCounts) -> Agreement:
    """Compare emulated answers with those of the same C on this machine.

    Both answer or neither does, and thrusts differ by rounding.
    """
    given = demands.limits if made.limits == "call" else ()
    F, status = build(str(made.library), demands.vehicle).many(demands.taus, *given)
    here, there = np.isin(status, ANSWERED), np.isin(counted.status, ANSWERED)
    both = here & there
    size = np.maximum(np.abs(F[both]).max(axis=1, initial=0.0), demands.vehicle.f_scale)
    apart = np.abs(counted.F[both] - F[both]).max(axis=1, initial=0.0) / size
    far, other = int((apart > AGREEMENT[made.scalar]).sum()), int((here != there).sum())
    wrong = f"answers otherwise than on this machine ({far + other} of {len(F)} demands)"
    return Agreement(float(apart.max(initial=0.0)), other, wrong=wrong * bool(far + other))
