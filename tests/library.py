"""libthrustbench as ctypes calls it: prepared for one vehicle after the other by one library."""

import ctypes
from functools import cache

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.c.compiled import shared_library
from alloc.library import K_MAX, calls, files
from alloc.vehicle.geometry import DOF

ROOM = 1 << 20
"""Bytes that hold an array of ``struct tb_allocator`` with room for all parts."""


@cache
def _library(n_max: int, k_max: int) -> ctypes.CDLL:
    return ctypes.CDLL(str(shared_library("libthrustbench", files(n_max=n_max, k_max=k_max))))


class Survey(ctypes.Structure):
    """One ``struct tb_survey``."""

    _fields_ = (
        *((key, ctypes.c_void_p) for key in ("T", "poses", "axis")),
        *((key, ctypes.c_double) for key in ("mm", "deg", "relative", "weak")),
        ("room", ctypes.c_int),
    )


def survey_of(vehicle: Vehicle) -> tuple[Survey, list[object]]:
    """The survey of a vehicle, and what must live as long."""
    known, axes = vehicle.survey, (ctypes.c_int * vehicle.k)(*map(DOF.index, vehicle.dof))
    poses = None if vehicle.poses is None else np.ascontiguousarray(vehicle.poses)
    arrays = [_pointer(vehicle.T), _pointer(poses), ctypes.cast(axes, ctypes.c_void_p)]
    tolerances = known.mm, known.deg, known.relative or 0.0, vehicle.weak_limit or 0.0
    return Survey(*arrays, *tolerances, vehicle.k - 1), [vehicle, poses, axes]


class Allocator:
    """One ``struct tb_allocator``."""

    def __init__(self, vehicle: Vehicle, n_max: int = 12, k_max: int = K_MAX) -> None:
        """Prepare it for this vehicle; ``status`` is what came back."""
        self.vehicle, self._library = vehicle, _library(n_max, k_max)
        self.memory = ctypes.create_string_buffer(ROOM)
        given = (vehicle.T, vehicle.H, vehicle.readiness, vehicle.f_min, vehicle.f_max)
        self.status = self._library.tb_prepare(self.memory, vehicle.k, vehicle.n, *map(_pointer, given))
        of = [next(i for i, axes in enumerate(vehicle.priority) if axis in axes) for axis in vehicle.dof]
        self.levels((ctypes.c_int * vehicle.k)(*of))

    def levels(self, of: object) -> int:
        """Give each axis its level."""
        return int(self._library.tb_levels(self.memory, of))

    def without(self, *thrusters: int) -> int:
        """Switch these thrusters off, and all others on that were."""
        mask = ctypes.c_ulong(sum(1 << i for i in thrusters))
        return int(self._library.tb_without(self.memory, mask))

    def strong(self, survey: Survey | None, *thrusters: int) -> int:
        """Switch these thrusters off, and leave out what is weak then."""
        mask = ctypes.c_ulong(sum(1 << i for i in thrusters))
        return int(self._library.tb_strong(self.memory, mask, survey and ctypes.byref(survey)))

    def __call__(
        self, method: str, tau: FloatArray, low: FloatArray | None = None, high: FloatArray | None = None
    ) -> tuple[int, FloatArray, FloatArray]:
        """Status, thrusts (n,) and shares of one call; NaN where nothing was written."""
        f = np.full(self.vehicle.n, np.nan)
        share = np.full(len(self.vehicle.priority) if method == "priority" else 1, np.nan)
        arrays = [tau, low, high, f, *([share] if calls()[method] else [])]
        status = self._library[f"tb_{method}"](self.memory, *map(_pointer, arrays))
        return int(status), f, share if calls()[method] else share[:0]


def _pointer(values: FloatArray | None) -> ctypes.c_void_p | None:
    if values is None:
        return None
    assert values.dtype == np.float64
    assert values.flags.c_contiguous
    return values.ctypes.data_as(ctypes.c_void_p)
