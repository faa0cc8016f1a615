"""A shared library that exports ``thrustbench_allocator.h``, called as generated C is, on copies in walls."""

import ctypes
import weakref
from dataclasses import replace
from functools import partial
from importlib import resources
from math import inf
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from alloc.allocation import Allocator, IndexArray
from alloc.c.bind import COUNT, native
from alloc.c.compiled import STANDARD, missing, shared_library
from alloc.errors import DemandError, NotApplicable, NotInstalled, PluginError
from alloc.formulations import find_formulation
from alloc.live.plain import ANY_DISTANCE
from alloc.vehicle import Vehicle
from alloc.vehicle.current import checked_cap
from alloc.vehicle.names import axis_levels

HEADER = "thrustbench_allocator.h"
VERSION = 1
SCALARS: dict[int, type[np.floating]] = {0x100 * VERSION + 8: np.float64, 0x100 * VERSION + 4: np.float32}
"""Type of a library's numbers by what its ``tba_interface`` returns."""
RESIDUAL = 9
"""Place of the residual among the arrays of a call."""
WALL, STONE = 4, -1.2345678e30
"""Count and value of the guard numbers around each array that a library gets."""
EACH = 256
"""Calls that are guarded at first; then one of so many is."""
SINGLY = ("-O3", "-fno-tree-vectorize", "-fno-tree-slp-vectorize")
"""Flags by which numbers are moved one by one: a vector of what was just stored singly waits for it."""
MOST = 200
"""Most characters of a library's own text that are repeated."""


PLACES = ctypes.c_void_p * 12
"""Addresses of the arrays that a call reads and writes, and of what follows the wall behind the last."""


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
        ("capped", ctypes.c_int),
    )


class _Context(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("call", "many", "allocator", "reset")),
        ("name", ctypes.c_char_p),
        ("shares", ctypes.c_int),
        *((name, ctypes.c_uint) for name in ("calls", "unguarded")),
        *((name, PLACES) for name in ("one", "several")),
    )


class LibraryPromise(NamedTuple):
    """Promises of an allocator: formulation, tolerance, and whether thrusts keep limits and a cap."""

    formulation: str
    limited: bool
    tolerance: float
    capped: bool = False


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
    A library that takes faults gets a vehicle as it was before them; the limits of a thruster that is off are
    no longer known, and the largest of all stand there.
    """
    if lacking := missing():
        raise NotInstalled(f"{path}: {lacking}")
    scalar = SCALARS[library.tba_interface()]
    way = find_formulation(promise.formulation).way
    shares = len(way(vehicle).keep) if way else 0
    numbers = vehicle_numbers(vehicle, scalar)
    if told := bool(vehicle.faults) and hasattr(library, "tba_fault"):
        readiness, numbers = numbers[2], vehicle_numbers(_whole(vehicle), scalar)
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
    context = _Context(allocator=allocator, name=path.name.encode(), shares=shares)
    needs = (library, subject, numbers, dof)
    if told and library.tba_fault(ctypes.c_void_p(allocator), ctypes.c_void_p(readiness.ctypes.data)):
        raise NotApplicable(f"{vehicle.name}: {path.name} refuses it: tba_fault takes no such failure")
    caller = _caller(scalar is np.float32, vehicle)
    own = ctypes.CDLL(str(caller))
    context.call = _address(own.foreign_nothing if is_idle else library.tba_call)
    context.reset = _address(library.tba_reset) if start == "cold" else None
    rooms = [_room(vehicle, shares, count, scalar) for count in (1, COUNT)]
    context.one, context.several = (places for _, places in rooms)
    by_many = start != "cold" and not is_idle and hasattr(library, "tba_many")
    context.many = _address(library.tba_many) if by_many else None
    residual = rooms[0][0][_starts(vehicle, shares, 1, scalar)[RESIDUAL] :][: vehicle.k]
    life = _Life()
    weakref.finalize(life, _end, own, context, rooms, *needs)
    return native(
        caller,
        ("foreign_call", "foreign_call"),
        vehicle,
        context=ctypes.addressof(context),
        more=_address(own.foreign_more),
        supply=partial(_supply, path.name, promise.capped),
        stated_residual=residual,
        needs=life,
        formulation=promise.formulation,
        limited=promise.limited,
        tolerance=promise.tolerance,
        levels=shares,
        state=True,
        together=(lambda _: _address(own.foreign_many)) if by_many else None,
    )


def _whole(vehicle: Vehicle) -> Vehicle:
    """A vehicle as if all its thrusters were ready."""
    off, most = vehicle.readiness == 0, vehicle.f_scale
    low, high = np.where(off, -most, vehicle.f_min), np.where(off, most, vehicle.f_max)
    return replace(vehicle, readiness=np.ones(vehicle.n), f_min=low, f_max=high)


class _Life:
    """The time in which an allocator may be called."""


def _end(own: ctypes.CDLL, context: _Context, _: object, library: ctypes.CDLL, *__: object) -> None:
    """Look at what the last calls left behind, and free the allocator."""
    own.foreign_end(ctypes.byref(context))
    if hasattr(library, "tba_free"):
        library.tba_free(ctypes.c_void_p(context.allocator))


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def _room(
    vehicle: Vehicle, shares: int, count: int, scalar: type[np.floating]
) -> tuple[np.ndarray, ctypes.Array[Any]]:
    """Room for what ``count`` calls read and write, with walls around each array, and where these lie.

    The arrays are tau, f_min, f_max, f_previous, f_desired, cap, volts, f, share, residual and, as integers,
    status.
    """
    size, starts = np.dtype(scalar).itemsize, _starts(vehicle, shares, count, scalar)
    room = np.full(int(starts[-1]), STONE, dtype=scalar)
    return room, PLACES(*(room.ctypes.data + size * starts).tolist())


def _starts(vehicle: Vehicle, shares: int, count: int, scalar: type[np.floating]) -> IndexArray:
    """Places in a room at which each array begins, and that of what follows the last wall."""
    k, n = vehicle.k, vehicle.n
    each = [count * one for one in (k, n, n, n, n, 1, 1, n, shares, k)]
    each.append(count * np.dtype(np.intc).itemsize // np.dtype(scalar).itemsize)
    starts: IndexArray = WALL + np.concatenate([[0], np.cumsum(np.array(each) + WALL)])
    return starts


def _supply(name: str, capped: bool, cap: float | None, volts: float | None) -> tuple[float, float]:
    """The cap [A] and the voltage [V] of a call, 0 for None; raises DemandError."""
    if cap is not None and not capped:
        raise DemandError(f"cap: {name} keeps none; say so by 'capped' in tba_promises, or use frugal")
    if volts is not None and not 0.0 < volts < inf:
        raise DemandError(f"volts: got {volts}, expected a finite number above 0 [V]")
    return 0.0 if cap is None else checked_cap(cap), volts or 0.0


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
    capped = made.size >= ctypes.sizeof(_Promise) and bool(made.capped)
    return LibraryPromise(_text(made.formulation) or rule, bool(made.limited), made.tolerance, capped)


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


def _caller(single: bool, vehicle: Vehicle) -> Path:
    """The library with ``foreign_call``, compiled once for each scalar and size of a vehicle."""
    texts = {
        name: (resources.files("alloc.foreign") / name).read_text(encoding="utf-8")
        for name in ("call.c", HEADER)
    }
    flags = [
        *STANDARD,
        *SINGLY,
        f"-DWALL={WALL}",
        f"-DCOUNT={COUNT}",
        f"-DEACH={EACH}",
        f"-DK={vehicle.k}",
        f"-DN={vehicle.n}",
        f"-DSTONES={','.join([f'(tba_real){STONE!r}'] * WALL)}",
        *(["-DTBA_FLOAT"] if single else []),
    ]
    return shared_library("thrustbench_foreign", texts, flags)


def _text(said: bytes | None) -> str:
    """A library's text on one line; empty for none."""
    return " ".join((said or b"").decode(errors="replace").split())[:MOST]
