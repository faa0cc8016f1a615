"""Contract of calls that every method and plug-in passes: a call in another form has the usual answer.

The measured process loads this file by its path, so it imports nothing of this project; tests ask it of every
method in the catalogue.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from time import monotonic
from typing import Any

import numpy as np

Comparison = dict[str, Any]
"""Answers to a form of calls: ``same``, True for the same statuses, and how far ``apart`` thrusts lie [N], or
what it ``raises``."""
Pair = tuple[Any, Any]
"""Thrusts and statuses of some calls."""
Form = tuple[str, Callable[[], Pair], Callable[[], Pair]]
"""Name of a form, the usual calls, and the same in that form."""

LEAST = 3.0
"""Largest entry, at least, of a demand in whole numbers: smaller ones would be none."""
NEAR = 1e-4
"""Step of a demand that hardly moves, relative to it."""

PASSES, LONGEST_S, PROBED = 40, 5.0, 3
"""Passes of all forms together through the demands, their longest time [s], and the demands that show
how long a call is."""


def forms(allocate: Any, taus: Any, low: Any, high: Any) -> dict[str, Comparison]:
    """Answers of an allocator to demands (N, k) [N, N m] with limits (N, n) [N], by the name of the form.

    Left out is what it does not have: limits of the call, or ``many``. A slow one is asked fewer demands, and
    none at all where one would take too long.
    """
    count = _affordable_count(allocate, taus)
    found: dict[str, Comparison] = {}
    for name, usual, other in _all_forms(allocate, taus[:count], low[:count], high[:count]) if count else ():
        try:
            (F, status), (others, verdicts) = usual(), other()
        except Exception as error:
            found[name] = {"raises": f"{type(error).__name__}: {error}"}
            continue
        same = list(map(int, status)) == list(map(int, verdicts))
        found[name] = {"same": same, "apart": farthest(np.array(F, float), np.array(others, float))}
    return found


def farthest(F: Any, other: Any) -> float:
    """The largest difference of two arrays of thrusts [N], infinite where NaN stands in one alone."""
    same = (other == F) | (np.isnan(F) & np.isnan(other))
    return float(np.nan_to_num(np.abs(F - other)[~same], nan=np.inf).max(initial=0.0))


def _affordable_count(allocate: Any, taus: Any) -> int:
    """Number of demands that all forms together can be asked in LONGEST_S."""
    start = monotonic()
    _single_calls(allocate, taus[:PROBED])
    each = (monotonic() - start) / len(taus[:PROBED])
    return min(len(taus), int(LONGEST_S / (PASSES * max(each, 1e-9))))


def _whole_numbers(taus: Any) -> Any:
    larger = np.maximum(1.0, LEAST / np.maximum(np.abs(taus).max(axis=1, keepdims=True), 1e-300))
    return np.rint(np.where(taus.any(axis=1, keepdims=True), larger, 0.0) * taus).astype(int)


CONVERSIONS: dict[str, Callable[[Any], Any]] = {
    "a list of whole numbers": lambda taus: _whole_numbers(taus).tolist(),
    "an array of whole numbers": _whole_numbers,
    "an array made of columns": np.asfortranarray,  # no row of it lies in one piece of memory
    "an array in single precision": lambda taus: taus.astype("float32"),
}
SIDES: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any]]] = {
    "limits": (lambda low: low[0], lambda high: high[0]),
    "f_min alone": (lambda low: low[0], lambda high: None),
    "f_max alone": (lambda low: None, lambda high: high[0]),
    "f_min, f_max of each": (lambda low: low[0], lambda high: high),
    "f_max, f_min of each": (lambda low: low, lambda high: high[0]),
}
"""By name, f_min and f_max that ``many`` is given, made of (N, n) limits."""


def _all_forms(allocate: Any, taus: Any, low: Any, high: Any) -> Iterator[Form]:
    """All forms of calls that the allocator has."""
    usual, many, columns = _single_calls(allocate, taus), getattr(allocate, "many", None), (taus, low, high)
    yield from _demand_forms(allocate, taus)
    limited: Pair | None
    try:
        limited = _single_calls(allocate, *columns)
    except Exception:  # it takes no limits, or fails with them, which is judged elsewhere
        limited = None
    if limited is not None:
        yield from _limit_forms(allocate, usual, limited, columns)
    if many is None:
        return
    for name, convert in CONVERSIONS.items():
        made = convert(taus)
        yield f"many() of {name}", partial(_single_calls, allocate, _floats(made)), partial(many, made)
    yield (
        "many() called again",
        lambda: (np.copy((made := many(taus.copy()))[0]), np.copy(made[1])),
        lambda: (many(taus.copy()), many(-taus))[0],
    )
    if limited is None:
        return
    for name, (first, second) in SIDES.items():
        sides = [None if side is None else side.copy() for side in (first(low), second(high))]
        each = ([None] * len(taus) if side is None else np.resize(side, low.shape) for side in sides)
        calls = zip(taus.copy(), *each, strict=True)
        yield (
            f"many() with one row of {name}",
            partial(_answers_of, allocate, calls),
            partial(many, taus.copy(), *sides),
        )
    striped = map(np.asfortranarray, columns)
    yield (
        "many() with limits in an array made of columns",
        partial(_single_calls, allocate, *columns),
        partial(many, *striped),
    )
    given = [each.copy() for each in columns]
    yield (
        "what many() is given",  # its arguments, before and after, in place of thrusts
        lambda: (np.hstack(columns), []),
        lambda: (many(*given), (np.hstack(given), []))[1],
    )


def _demand_forms(allocate: Any, taus: Any) -> Iterator[Form]:
    """Forms of calls without limits."""
    for name, convert in CONVERSIONS.items():
        made = convert(taus)
        yield (
            name,
            partial(_single_calls, allocate, _floats(made)),
            partial(_answers_of, allocate, zip(made)),
        )
    usual = partial(_single_calls, allocate, taus)
    yield "an array that is used again", usual, partial(_calls_with_one_array, allocate, taus)
    near = (1.0 + NEAR) * taus  # a vehicle's demands hardly move from call to call
    after = partial(_calls_after, allocate, zip(taus), zip(near))
    yield "a demand next to the last", partial(_single_calls, allocate, near), after


def _limit_forms(allocate: Any, usual: Pair, limited: Pair, columns: tuple[Any, Any, Any]) -> Iterator[Form]:
    """Forms of calls with limits."""
    taus, low, high = columns
    F = np.array(limited[0], dtype=float)
    inside = np.clip(F, low, high) if allocate.limited else F
    # A cache by demand alone would give what it answered without limits, which was asked first.
    yield "limits of a demand asked before without", lambda: (inside, limited[1]), lambda: limited
    named = (allocate(tau, f_min=low, f_max=high) for tau, low, high in _copied_rows(*columns))
    yield "limits by name", lambda: limited, lambda: _columns_of(named)
    for name, convert in (
        ("limits in lists", lambda column: column.tolist()),
        ("limits in an array made of columns", np.asfortranarray),
    ):
        yield name, lambda: limited, partial(_answers_of, allocate, zip(*map(convert, columns), strict=True))
    without = [(tau,) for tau in taus]
    yield (
        "limits behind a call without",
        lambda: limited,
        partial(_calls_after, allocate, without, _copied_rows(*columns)),
    )
    yield (
        "no limits behind a call with",
        lambda: usual,
        partial(_calls_after, allocate, _copied_rows(*columns), without),
    )


def _floats(array: Any) -> Any:
    return np.ascontiguousarray(array, dtype=float)


def _copied_rows(*columns: Any) -> Iterable[tuple[Any, ...]]:
    """Arguments of calls, row by row, in memory of their own."""
    return zip(*(each.copy() for each in columns), strict=True)


def _columns_of(answers: Iterable[Any]) -> Pair:
    rows = [(answer[0].copy(), answer[1]) for answer in answers]
    return [f for f, _ in rows], [status for _, status in rows]


def _answers_of(allocate: Any, calls: Iterable[tuple[Any, ...]]) -> Pair:
    return _columns_of([allocate(*call) for call in calls])


def _single_calls(allocate: Any, *columns: Any) -> Pair:
    return _answers_of(allocate, _copied_rows(*columns))


def _calls_with_one_array(allocate: Any, taus: Any) -> Pair:
    """Answers where a caller, as an autopilot, has one array and writes each demand into it."""
    array, answers = taus[0].copy(), []
    for tau in taus:
        array[:] = tau
        answers.append(allocate(array))
    return _columns_of(answers)


def _calls_after(allocate: Any, calls: Iterable[Any], others: Iterable[Any]) -> Pair:
    """Answers to ``others``, each of which follows another call."""
    answers = []
    for call, other in zip(calls, others, strict=True):
        allocate(*(each.copy() for each in call))
        answers.append(allocate(*(each.copy() for each in other)))
    return _columns_of(answers)
