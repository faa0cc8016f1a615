"""A plain function tau -> f made an allocator, and the declarations of the file that has it."""

import inspect
from collections.abc import Callable
from difflib import get_close_matches
from math import hypot, inf
from numbers import Real
from operator import le
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from alloc.allocation import (
    FLOAT64,
    WRENCH_TOLERANCE,
    Allocation,
    FloatArray,
    Status,
    StatusArray,
    Uncapped,
    answer,
    checked,
    real,
)
from alloc.errors import NotApplicable, PluginError, UnknownName
from alloc.formulations import Family, refuse_misspelt
from alloc.solvers import Level, Start
from alloc.vehicle import Vehicle
from alloc.vehicle.call_limits import at_call, one_by_one

ANY_DISTANCE = 1.0
"""Tolerance of a function that declares no formulation: as far from T* tau as the largest limit."""
EXACT = 1e-6
"""Tolerance of a function that declares a formulation and no tolerance."""


class Plain(Uncapped):
    """The allocator of a function tau (k,) [N, N m] -> f (n,) [N].

    Its answer is SOLVED where T P f misses tau by 1e-6 of ``vehicle.wrench_scale`` at most and, where limits
    are promised, f lies inside them; else PARTIAL. None, and thrusts that are not finite, are NOT_CONVERGED.
    A function that takes ``f_min`` and ``f_max`` gets those of each call, and is not asked where they cross:
    that is INFEASIBLE. Any other function can't know them, so a call with limits is refused. What a function
    gets are copies, which it may write into.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        vehicle: Vehicle,
        formulation: str,
        limited: bool,
        tolerance: float,
    ) -> None:
        """Wrap the function with what its module declares."""
        self.formulation, self.limited, self.tolerance = formulation, limited, tolerance
        self._function, self._vehicle = function, vehicle
        self._limits = at_call(vehicle)
        self._takes_limits = _takes_limits(function)
        self._k, self._n = vehicle.k, vehicle.n
        self._per_scale = 1 / vehicle.wrench_scale
        self._scaled = vehicle.TP * self._per_scale[:, None]

    def allocate(
        self, tau: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> Allocation:
        """Allocate one wrench (k,) [N, N m] within limits (n,) [N], the vehicle's where there are none.

        Raises PluginError where the function gives no n numbers, NotApplicable for limits that it does not
        take.
        """
        wrench = checked(tau, self._k)
        low, high = self._limits(f_min, f_max)
        if f_min is not None or f_max is not None:
            if not self._takes_limits:
                raise NotApplicable("the function takes no limits of each call; add f_min and f_max to tau")
            if not all(map(le, low.tolist(), high.tolist())):
                return answer(np.full(self._n, np.nan), Status.INFEASIBLE)
        if self._takes_limits:
            given = self._function(wrench.copy(), f_min=low.copy(), f_max=high.copy())
        else:
            given = self._function(wrench.copy())
        if given is None:
            return answer(np.full(self._n, np.nan), Status.NOT_CONVERGED)
        f = self._fresh(given)
        # Norms and lists of eight are quicker than numpy's comparisons: this is timed with the function.
        if not hypot(*f.tolist()) < inf:
            return answer(np.full(self._n, np.nan), Status.NOT_CONVERGED)
        met = hypot(*(self._scaled.dot(f) - wrench * self._per_scale).tolist()) <= WRENCH_TOLERANCE
        inside = not self.limited or (min((f - low).tolist()) >= 0 and min((high - f).tolist()) >= 0)
        return answer(f, Status.SOLVED if met and inside else Status.PARTIAL)

    def _fresh(self, given: Any) -> FloatArray:
        """The function's thrusts in an array of their own: the function may keep its."""
        n = self._n
        if type(given) is np.ndarray and given.dtype is FLOAT64:
            f = given.copy()
        elif isinstance(given, Allocation):
            raise PluginError(
                "the function gave an Allocation; return its thrusts alone, or let build return an object"
                " with formulation, limited and tolerance"
            )
        else:
            try:
                f = real(np.asarray(given))
            except (TypeError, ValueError, OverflowError) as error:
                raise PluginError(f"the function gave no numbers ({error}); return {n} thrusts") from None
        if f.shape != (n,):
            raise PluginError(f"the function gave an array of shape {f.shape}; return {n} thrusts, ({n},)")
        return f

    def allocate_many(
        self, taus: ArrayLike, f_min: ArrayLike | None = None, f_max: ArrayLike | None = None
    ) -> tuple[FloatArray, StatusArray]:
        """Allocate (N, k) wrenches one after the other, each within its own limits."""
        return one_by_one(self, self._vehicle, taus, f_min, f_max)


def _takes_limits(function: Callable[..., Any]) -> bool:
    try:
        names = inspect.signature(function).parameters
    except (TypeError, ValueError):  # a function written in C may say nothing of its arguments
        return False
    return {"f_min", "f_max"} <= set(names)


DECLARED: tuple[tuple[str, Any, str], ...] = (
    ("FORMULATION", str, "a name, such as 'hard' or one of your own"),
    ("FAMILY", Family, f"an alloc.plugin.Family: {', '.join(f'Family.{family.name}' for family in Family)}"),
    ("FOREIGN", bool, "True or False"),
    ("SUMMARY", str, "a line of text"),
    ("LIMITED", bool, "True where every thrust lies inside the limits, else False"),
    ("TOLERANCE", Real, "a distance from the right answer, relative to the largest limit"),
)
"""Declarations of a plug-in: name, type, and what to write."""
PROMISED, CLOSE = ("FORMULATION", "LIMITED", "TOLERANCE"), 0.85
"""Names by which answers are held to something, and how like one of them another name may not be: a method
whose file misspells one is held to nothing. LIMIT and LIMITS are less like."""
OFFERED = (("STARTS", "start", get_args(Start)), ("LEVELS", "level", get_args(Level)))
"""Choices that a plug-in may offer: name, argument of ``build``, and the words that a run asks for."""


def check_declared(path: Path, module: ModuleType) -> None:
    """Raise PluginError where a plug-in has no ``build``, or declares what there is not."""
    if not hasattr(module, "build"):
        raise PluginError(f"{path}: has no build(vehicle); add one that returns an allocator")
    for constant, _, known in OFFERED:
        offered = getattr(module, constant, known)
        # A word that no run asks for would leave the method without a row.
        if not isinstance(offered, tuple | list) or not offered or not {*known, "-"}.issuperset(offered):
            raise PluginError(f"{path}: {constant} = {offered!r}; give a tuple of {', '.join(known)}")
    for constant, kind, example in DECLARED:
        value = getattr(module, constant, None)
        if value is not None and not (isinstance(value, kind) and value == value):
            raise PluginError(f"{path}: {constant} = {value!r}; give {example}")
    tolerance = getattr(module, "TOLERANCE", None) or 0.0
    if isinstance(tolerance, bool) or not 0 <= tolerance < inf:
        raise PluginError(f"{path}: TOLERANCE = {tolerance!r}; give a number from 0 on")
    for name in vars(module):
        close = get_close_matches(name.upper(), PROMISED, n=1, cutoff=CLOSE)
        if name not in PROMISED and close and (name.isupper() or name.upper() in PROMISED):
            raise PluginError(f"{path}: {name} declares nothing; write {close[0]}, or another name")
    try:
        refuse_misspelt(getattr(module, "FORMULATION", None) or "")
    except UnknownName as error:
        raise PluginError(f"{path}: {error}") from None
    if not callable(module.build):
        raise PluginError(f"{path}: build is no function; write build(vehicle) that returns an allocator")
    for constant, option, _ in OFFERED:
        if {*getattr(module, constant, "-")} != {"-"} and not _takes(module.build, option):
            raise PluginError(f"{path}: {constant} is declared, but build takes no {option}; let it take one")


def _takes(function: Callable[..., Any], option: str) -> bool:
    """True if a function's signature accepts that option."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # a function written in C may say nothing of its arguments
        return True
    return any(p.name == option or p.kind is p.VAR_KEYWORD for p in parameters)
