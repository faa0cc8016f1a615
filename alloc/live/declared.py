"""Check the declarations of a plug-in's file before anything is built."""

import inspect
from collections.abc import Callable
from difflib import get_close_matches
from math import inf
from numbers import Real
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

from alloc.errors import UnknownName
from alloc.formulations import Family, refuse_misspelt
from alloc.solvers import Level, Start

DECLARED: tuple[tuple[str, Any, str], ...] = (
    ("FORMULATION", str, "a name, such as 'hard' or one of your own"),
    ("FAMILY", Family, f"an alloc.plugin.Family: {', '.join(f'Family.{family.name}' for family in Family)}"),
    ("FOREIGN", bool, "True or False"),
    ("SUMMARY", str, "a line of text"),
    ("LIMITED", bool, "True where every thrust lies inside the limits, else False"),
    ("TOLERANCE", Real, "a distance from the right answer, relative to the largest limit"),
)
"""What a plug-in may declare, its type, and what to write."""
PROMISED, CLOSE = ("FORMULATION", "LIMITED", "TOLERANCE"), 0.85
"""Names by which answers are held to something, and how like one of them another name may not be: a method
whose file misspells one is held to nothing. LIMIT and LIMITS are less like."""
OFFERED = (("STARTS", "start", get_args(Start)), ("LEVELS", "level", get_args(Level)))
"""What it may offer a choice of: its name, the argument of ``build``, and the words that a run asks for."""


def check_declared(path: Path, module: ModuleType) -> None:
    """Raise UnknownName where a plug-in has no ``build``, or declares what there is not."""
    if not hasattr(module, "build"):
        raise UnknownName(f"{path}: has no build(vehicle); add one that returns an allocator")
    for constant, _, known in OFFERED:
        offered = getattr(module, constant, known)
        # A word that no run asks for would leave the method without a row.
        if not isinstance(offered, tuple | list) or not offered or not {*known, "-"}.issuperset(offered):
            raise UnknownName(f"{path}: {constant} = {offered!r}; give a tuple of {', '.join(known)}")
    for constant, kind, example in DECLARED:
        value = getattr(module, constant, None)
        if value is not None and not (isinstance(value, kind) and value == value):
            raise UnknownName(f"{path}: {constant} = {value!r}; give {example}")
    tolerance = getattr(module, "TOLERANCE", None) or 0.0
    if isinstance(tolerance, bool) or not 0 <= tolerance < inf:
        raise UnknownName(f"{path}: TOLERANCE = {tolerance!r}; give a number from 0 on")
    for name in vars(module):
        close = get_close_matches(name.upper(), PROMISED, n=1, cutoff=CLOSE)
        if name not in PROMISED and close and (name.isupper() or name.upper() in PROMISED):
            raise UnknownName(f"{path}: {name} declares nothing; write {close[0]}, or another name")
    try:
        refuse_misspelt(getattr(module, "FORMULATION", None) or "")
    except UnknownName as error:
        raise UnknownName(f"{path}: {error}") from None
    if not callable(module.build):
        raise UnknownName(f"{path}: build is no function; write build(vehicle) that returns an allocator")
    for constant, option, _ in OFFERED:
        if {*getattr(module, constant, "-")} != {"-"} and not _takes(module.build, option):
            raise UnknownName(f"{path}: {constant} is declared, but build takes no {option}; let it take one")


def _takes(function: Callable[..., Any], option: str) -> bool:
    """True if a function's signature accepts that option."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # a function written in C may say nothing of its arguments
        return True
    return any(p.name == option or p.kind is p.VAR_KEYWORD for p in parameters)
