"""Ways from Python into a generated kernel: ctypes, cffi in API mode, this project's extension.

``python docs/studies/call_path.py`` prints a Markdown table of the CPU time of a call [ns], the least of
several batches. ctypes and cffi are shown bare (no check of tau, a raw status) and as allocators; the
extension is shown as an allocator only.
"""

import ctypes
import importlib.util
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cffi
import numpy as np

from alloc import Allocation, Status, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray, answer, checked
from alloc.c import function_name, sources
from alloc.c.compiled import shared_library
from alloc.methods import recipe
from bench.results.text import table, three
from native_speed import demands, interleaved, python_calls
from speed_tables import PRODUCT

VEHICLES = ("ukwial", "bluerov2-heavy")
KERNEL = "nullspace"
Bare = Callable[[FloatArray, FloatArray], int]


def by_ctypes(vehicle: Vehicle) -> Bare:
    """The library's function by ctypes; arrays go as buffers, at half the price of ``array.ctypes.data``."""
    library = ctypes.CDLL(str(shared_library(KERNEL, sources(vehicle, recipe(KERNEL), faults="none"))))
    solve = library[function_name(vehicle, KERNEL)]
    # The type is Any, because a type checker takes an array for a buffer from Python 3.12 on only.
    wrench: Any = ctypes.c_double * vehicle.k
    thrusts: Any = ctypes.c_double * vehicle.n

    def call(tau: FloatArray, f: FloatArray) -> int:
        status: int = solve(wrench.from_buffer(tau), -1, thrusts.from_buffer(f))
        return status

    return call


def by_cffi(vehicle: Vehicle, folder: Path) -> Bare:
    """A module that cffi generates and compiles (API mode); arrays go as buffers."""
    name = function_name(vehicle, KERNEL)
    files = sources(vehicle, recipe(KERNEL), faults="none")
    ffi = cffi.FFI()
    ffi.cdef(f"int {name}(const double *tau, int fault, double *f);")
    source = files[f"{name}.c"].replace(f'#include "{name}.h"', files[f"{name}.h"])
    ffi.set_source(f"_{name}", source)
    path = ffi.compile(tmpdir=str(folder))
    spec = importlib.util.spec_from_file_location(f"_{name}", path)
    assert spec is not None  # cffi has just made the file
    assert spec.loader is not None
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    solve, view = getattr(module.lib, name), module.ffi.from_buffer

    def call(tau: FloatArray, f: FloatArray) -> int:
        status: int = solve(view("double[]", tau), -1, view("double[]", f))
        return status

    return call


def bare(call: Bare, n: int) -> Callable[[FloatArray], object]:
    """The call and a fresh array for its answer, nothing else."""
    return lambda tau: call(tau, np.empty(n))


def as_allocator(call: Bare, vehicle: Vehicle) -> Callable[[FloatArray], Allocation]:
    """The call with tau checked and an Allocation as its answer."""
    statuses = tuple(Status)

    def allocate(tau: FloatArray) -> Allocation:
        f = np.empty(vehicle.n)
        status = call(checked(tau, vehicle.k), f)
        if status >= Status.INFEASIBLE:
            f.fill(np.nan)
        return answer(f, statuses[status])

    return allocate


def measure(name: str, folder: Path) -> list[str]:
    """One row of the table: a vehicle, and the time of every way [ns]."""
    vehicle = load_vehicle(name)
    ways = {"ctypes": by_ctypes(vehicle), "cffi": by_cffi(vehicle, folder)}
    calls: dict[str, Callable[[FloatArray], object]] = {PRODUCT: python_calls(vehicle)[PRODUCT]}
    for label, call in ways.items():
        calls[f"{label}, bare"] = bare(call, vehicle.n)
        calls[label] = as_allocator(call, vehicle)
    calls["extension"] = build(f"{KERNEL}@native", vehicle)
    ns = interleaved(calls, demands(vehicle))
    return [name, *(three(ns[label]) for label in calls)]


def main() -> None:
    """Print the table."""
    headers = ["vehicle", "`T_pinv @ tau`", "ctypes, bare", "ctypes", "cffi, bare", "cffi", "extension"]
    with tempfile.TemporaryDirectory() as folder:
        print(table(headers, [measure(name, Path(folder)) for name in VEHICLES]))


if __name__ == "__main__":
    main()
