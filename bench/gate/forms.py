"""Forms of calls that the contract allows, each held against the usual one.

The process loads this file by its place, as ``given``.
"""

from collections.abc import Callable, Iterator
from typing import Any

Held = dict[str, Any]
"""How a form is answered: ``same``, whether with the same statuses, and how far ``apart`` thrusts lie [N], or
what it ``raises``."""

LEAST = 3.0
"""Largest entry, at least, of a demand in whole numbers: smaller ones would be none."""


def forms(
    allocate: Any, taus: Any, low: Any, high: Any, farthest: Callable[[Any, Any], float]
) -> dict[str, Held]:
    """How an allocator answers demands (N, k) [N, N m] with limits (N, n) [N], by the name of the form.

    Left out is what it does not have: limits of the call, or ``many``.
    """
    found: dict[str, Held] = {}
    for name, ask in (
        ("a list of whole numbers", _whole(allocate, taus)),
        ("limits by name", _by_name(allocate, taus, low, high)),
        ("many() with one row of limits", _one_row(allocate, taus, low[0], high[0])),
        ("many() called again", _again(allocate, taus)),
    ):
        try:
            usual, other = next(ask)
        except StopIteration:
            continue
        except Exception as error:
            found[name] = {"raises": f"{type(error).__name__}: {error}"}
            continue
        same = list(map(int, usual[1])) == list(map(int, other[1]))
        found[name] = {"same": same, "apart": farthest(_array(usual[0]), _array(other[0]))}
    return found


Pair = Iterator[tuple[Any, Any]]
"""Thrusts and statuses in the usual form, and in another; nothing where the usual one is refused."""


def _whole(allocate: Any, taus: Any) -> Pair:
    import numpy as np

    larger = np.maximum(1.0, LEAST / np.maximum(np.abs(taus).max(axis=1, keepdims=True), 1e-300))
    whole = np.rint(np.where(taus.any(axis=1, keepdims=True), larger, 0.0) * taus)
    yield _singly(allocate, whole), _singly(allocate, whole.astype(int).tolist())


def _by_name(allocate: Any, taus: Any, low: Any, high: Any) -> Pair:
    try:
        usual = _singly(allocate, taus, low, high)
    except Exception:
        return  # it takes no limits, or fails with them, which is judged elsewhere
    calls = zip(taus.copy(), low.copy(), high.copy(), strict=True)
    yield usual, _columns([allocate(tau, f_min=a, f_max=b) for tau, a, b in calls])


def _one_row(allocate: Any, taus: Any, low: Any, high: Any) -> Pair:
    if (many := getattr(allocate, "many", None)) is None:
        return
    try:
        usual = _columns([allocate(tau, low.copy(), high.copy()) for tau in taus.copy()])
    except Exception:
        return
    yield usual, many(taus.copy(), low.copy(), high.copy())


def _again(allocate: Any, taus: Any) -> Pair:
    if (many := getattr(allocate, "many", None)) is None:
        return
    F, status = many(taus.copy())
    usual = F.copy(), list(status)
    many(-taus)
    yield usual, (F, status)


def _singly(allocate: Any, *columns: Any) -> tuple[Any, Any]:
    return _columns([allocate(*call) for call in zip(*(each.copy() for each in columns), strict=True)])


def _columns(answers: list[Any]) -> tuple[Any, Any]:
    return [answer[0].copy() for answer in answers], [answer[1] for answer in answers]


def _array(F: Any) -> Any:
    import numpy as np

    return np.array(F, dtype=float)
