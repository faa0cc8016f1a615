"""A shared library that exports ``thrustbench_allocator.h``, called as generated C is, on copies in walls."""

import ctypes
from functools import partial
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np

from alloc.allocation import Allocator
from alloc.c.bind import native
from alloc.c.compiled import STANDARD, missing, shared_library
from alloc.errors import NotApplicable, NotInstalled, PluginError
from alloc.formulations import find_formulation
from alloc.live.plain import ANY_DISTANCE
from alloc.vehicle import Vehicle
from alloc.vehicle.names import axis_levels

HEADER = "thrustbench_allocator.h"
VERSION = 1
SCALARS: dict[int, type[np.floating]] = {0x100 * VERSION + 8: np.float64, 0x100 * VERSION + 4: np.float32}
"""Type of a library's numbers by what its ``tba_interface`` returns."""
WALL, STONE = 4, -1.2345678e30
"""Count and value of the guard numbers around each array that a library gets."""
MOST = 200
"""Most characters of a library's own text that are repeated."""


class _Vehicle(ctypes.Structure):
    _fields_ = (
        ("size", ctypes.c_size_t),
        ("k", ctypes.c_int),
        ("n", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in ("T", "H", "readiness", "f_min", "f_max", "level")),
        ("dof", ctypes.POINTER(ctypes.c_char_p)),
        ("frame", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
    )


class _Promise(ctypes.Structure):
    _fields_ = (
        ("size", ctypes.c_size_t),
        ("formulation", ctypes.c_char_p),
        ("limited", ctypes.c_int),
        ("tolerance", ctypes.c_double),
    )


class _Context(ctypes.Structure):
    _fields_ = (
        ("call", ctypes.c_void_p),
        ("allocator", ctypes.c_void_p),
        ("reset", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        *((name, ctypes.c_int) for name in ("k", "n", "shares")),
        ("room", ctypes.c_void_p),
    )


class LibraryPromise(NamedTuple):
    """Promises of an allocator: the formulation, whether thrusts lie inside the limits, and the tolerance."""

    formulation: str
    limited: bool
    tolerance: float


def plugin(path: Path, rule: str) -> ModuleType:
    """The library as a plug-in's module: ``build``, and its promises as a Python file would declare them.

    ``rule`` is the formulation of a library that promises none. Raises PluginError for one that can't be
    loaded, lacks a function, or is of another version.
    """
    library = _opened(path)
    promise = _promised(library, rule)
    module = ModuleType(f"thrustbench_library_{path.stem}", f"{path.name}, by {HEADER}.")
    declared = {
        "FORMULATION": promise.formulation,
        "LIMITED": promise.limited,
        "TOLERANCE": promise.tolerance,
    }
    build = partial(bound, path, library, promise)
    if hasattr(library, "tba_reset"):
        declared["STARTS"] = ("cold", "warm")
        build = partial(build, start="warm")
    vars(module).update(
        declared,
        FOREIGN=True,
        build=build,
        idle_call=partial(bound, path, library, promise, is_idle=True),
    )
    return module


def bound(
    path: Path,
    library: ctypes.CDLL,
    promise: LibraryPromise,
    vehicle: Vehicle,
    *,
    start: str = "-",
    is_idle: bool = False,
) -> Allocator:
    """The library's allocator for a vehicle; raises NotApplicable, NotInstalled.

    With the start ``cold`` it forgets all earlier calls before each.
    With ``is_idle`` a function that does nothing stands in place of the library's: its calls are the way in.
    """
    if lacking := missing():
        raise NotInstalled(f"{path}: {lacking}")
    scalar = SCALARS[library.tba_interface()]
    way = find_formulation(promise.formulation).way
    shares = len(way(vehicle).keep) if way else 0
    numbers, room = (
        vehicle_numbers(vehicle, scalar),
        np.full(vehicle.k + 3 * vehicle.n + shares + 6 * WALL, STONE, dtype=scalar),
    )
    dof = (ctypes.c_char_p * vehicle.k)(*(axis.encode() for axis in vehicle.dof))
    subject = _Vehicle(
        ctypes.sizeof(_Vehicle), vehicle.k, vehicle.n,
        *(values.ctypes.data for values in numbers),
        dof, vehicle.frame.encode(), vehicle.name.encode(),
    )  # fmt: skip
    library.tba_prepare.restype = ctypes.c_void_p
    reason = ctypes.c_char_p()
    allocator = library.tba_prepare(ctypes.byref(subject), ctypes.byref(reason))
    if not allocator:
        raise NotApplicable(
            f"{vehicle.name}: {path.name} refuses it: {_text(reason.value) or 'no reason given'}"
        )
    caller = _caller(scalar is np.float32)
    function = ctypes.CDLL(str(caller)).foreign_nothing if is_idle else library.tba_call
    call = ctypes.cast(function, ctypes.c_void_p).value
    sizes = (vehicle.k, vehicle.n, shares)
    reset = ctypes.cast(library.tba_reset, ctypes.c_void_p).value if start == "cold" else None
    context = _Context(call, allocator, reset, path.name.encode(), *sizes, room.ctypes.data)
    return native(
        caller,
        ("foreign_call", "foreign_call"),
        vehicle,
        context=ctypes.addressof(context),
        needs=(library, subject, numbers, dof, room, context),
        formulation=promise.formulation,
        limited=promise.limited,
        tolerance=promise.tolerance,
        levels=shares,
        state=True,
    )


def _opened(path: Path) -> ctypes.CDLL:
    """The library; raises PluginError."""
    try:
        library = ctypes.CDLL(str(path.absolute()))
    except OSError as error:
        said = " ".join(str(error).split())[:MOST]
        raise PluginError(
            f"{path}: can't be loaded ({said}); build it for this machine, as {HEADER} says"
        ) from None
    if np.float64(np.finfo(float).tiny) * 0.5 == 0.0:
        raise PluginError(
            f"{path}: turns subnormal numbers off in the whole process as it is loaded;"
            " link it without -ffast-math"
        )
    for function in ("tba_interface", "tba_prepare", "tba_call"):
        if not hasattr(library, function):
            raise PluginError(f"{path}: has no function {function}; export what {HEADER} declares")
    if (version := library.tba_interface()) not in SCALARS:
        raise PluginError(
            f"{path}: tba_interface() is {version:#x}, expected {' or '.join(map(hex, SCALARS))};"
            f" return TBA_INTERFACE of this version's {HEADER}"
        )
    return library


def _promised(library: ctypes.CDLL, rule: str) -> LibraryPromise:
    """The library's promises; of one without, no more than a plain function in Python promises."""
    promise = None
    if hasattr(library, "tba_promises"):
        library.tba_promises.restype = ctypes.POINTER(_Promise)
        promise = library.tba_promises()
    if not promise:
        return LibraryPromise(rule, limited=False, tolerance=ANY_DISTANCE)
    made = promise.contents
    return LibraryPromise(_text(made.formulation) or rule, bool(made.limited), made.tolerance)


def vehicle_numbers(vehicle: Vehicle, scalar: type[np.floating]) -> tuple[np.ndarray, ...]:
    """T, H, readiness, f_min, f_max and levels as the library reads them; rounding widens no limit."""
    low, high = vehicle.f_min.astype(scalar), vehicle.f_max.astype(scalar)
    low = np.where(low < vehicle.f_min, np.nextafter(low, scalar(0)), low)
    high = np.where(high > vehicle.f_max, np.nextafter(high, scalar(0)), high)
    floats = (vehicle.T, vehicle.H, vehicle.readiness)
    return (
        *(np.ascontiguousarray(values, dtype=scalar) for values in floats),
        low,
        high,
        np.array(axis_levels(vehicle.priority, vehicle.dof), np.intc),
    )


def _caller(single: bool) -> Path:
    """The library with ``foreign_call``, compiled once for each scalar."""
    texts = {
        name: (resources.files("alloc.foreign") / name).read_text(encoding="utf-8")
        for name in ("call.c", HEADER)
    }
    flags = [
        *STANDARD,
        f"-DWALL={WALL}",
        f"-DSTONES={','.join([f'(tba_real){STONE!r}'] * WALL)}",
        *(["-DTBA_FLOAT"] if single else []),
    ]
    return shared_library("thrustbench_foreign", texts, flags)


def _text(said: bytes | None) -> str:
    """A library's text on one line; empty for none."""
    return " ".join((said or b"").decode(errors="replace").split())[:MOST]
