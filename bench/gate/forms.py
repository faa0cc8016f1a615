"""Forms of calls that the contract allows, each held against the usual one.

The process loads this file by its place, as ``given``.
"""

from collections.abc import Callable
from time import monotonic
from typing import Any

Held = dict[str, Any]
"""How a form is answered: ``same``, whether with the same statuses, and how far ``apart`` thrusts lie [N], or
what it ``raises``."""
Pair = tuple[Any, Any]
"""Thrusts and statuses in the usual form, and in another."""

LEAST = 3.0
"""Largest entry, at least, of a demand in whole numbers: smaller ones would be none."""
NEAR = 1e-4
"""How far a demand moves that hardly does, relative to it."""

PASSES, LONGEST_S, PROBED = 40, 5.0, 3
"""How often all forms together go through the demands, how long they may take [s], and how many demands say
how long a call is."""


def forms(
    allocate: Any, taus: Any, low: Any, high: Any, farthest: Callable[[Any, Any], float]
) -> dict[str, Held]:
    """How an allocator answers demands (N, k) [N, N m] with limits (N, n) [N], by the name of the form.

    Left out is what it does not have: limits of the call, or ``many``. A slow one is asked fewer demands, and
    none at all where one would take too long.
    """
    count = _affordable(allocate, taus)
    taus, low, high = taus[:count], low[:count], high[:count]
    if not count:
        return {}
    many, usual = getattr(allocate, "many", None), _singly(allocate, taus)
    wanted: dict[str, tuple[Callable[..., Pair], tuple[Any, ...]]]
    wanted = {name: (form, (allocate, taus)) for name, form in OF_DEMANDS.items()}
    if (limited := _limited(allocate, taus, low, high)) is not None:
        wanted |= {
            name: (form, (allocate, usual, limited, taus, low, high)) for name, form in OF_LIMITS.items()
        }
    if many is not None:
        wanted |= {name: (form, (allocate, many, taus)) for name, form in OF_MANY.items()}
    if many is not None and limited is not None:
        wanted |= {name: (form, (allocate, many, taus, low, high)) for name, form in OF_BOTH.items()}
    found: dict[str, Held] = {}
    for name, (form, given) in wanted.items():
        try:
            one, other = form(*given)
        except Exception as error:
            found[name] = {"raises": f"{type(error).__name__}: {error}"}
            continue
        same = list(map(int, one[1])) == list(map(int, other[1]))
        found[name] = {"same": same, "apart": farthest(_array(one[0]), _array(other[0]))}
    return found


def _affordable(allocate: Any, taus: Any) -> int:
    """How many of the demands all forms together can be asked in LONGEST_S."""
    start = monotonic()
    _singly(allocate, taus[:PROBED])
    each = (monotonic() - start) / len(taus[:PROBED])
    return min(len(taus), int(LONGEST_S / (PASSES * max(each, 1e-9))))


def _whole(taus: Any) -> Any:
    import numpy as np

    larger = np.maximum(1.0, LEAST / np.maximum(np.abs(taus).max(axis=1, keepdims=True), 1e-300))
    return np.rint(np.where(taus.any(axis=1, keepdims=True), larger, 0.0) * taus).astype(int)


def _columnwise(array: Any) -> Any:
    """A table that was put together from columns: no row of it lies in one piece of memory."""
    import numpy as np

    return np.asfortranarray(array)


def _rows(convert: Callable[[Any], Any]) -> Callable[[Any, Any], Pair]:
    """The form of calls whose demands are the rows of what ``convert`` makes of (N, k) demands."""

    def form(allocate: Any, taus: Any) -> Pair:
        made = convert(taus)
        return _singly(allocate, _usual(made)), _columns([allocate(row) for row in made])

    return form


def _tables(convert: Callable[[Any], Any]) -> Callable[[Any, Any, Any], Pair]:
    """The form of ``many`` that is given what ``convert`` makes of (N, k) demands."""

    def form(allocate: Any, many: Any, taus: Any) -> Pair:
        made = convert(taus)
        return _singly(allocate, _usual(made)), many(made)

    return form


def _usual(array: Any) -> Any:
    import numpy as np

    return np.ascontiguousarray(array, dtype=float)


def _used_again(allocate: Any, taus: Any) -> Pair:
    """An autopilot has one array, and writes each demand into it."""
    usual, array, answers = _singly(allocate, taus), taus[0].copy(), []
    for tau in taus:
        array[:] = tau
        answers.append(allocate(array))
    return usual, _columns(answers)


def _next_to(allocate: Any, taus: Any) -> Pair:
    """A vehicle's demands hardly move from call to call; here each is another than the one before."""
    near = (1.0 + NEAR) * taus
    return _singly(allocate, near), _second(allocate, zip(taus), zip(near))


def _inside(allocate: Any, _: Any, limited: Any, taus: Any, low: Any, high: Any) -> Pair:
    """Answers of a cache by demand: those of its call without limits, which came first."""
    import numpy as np

    if not allocate.limited:  # it promises no limits, and takes none into account
        return limited, limited
    F = _array(limited[0])
    return (np.clip(F, low, high), limited[1]), (F, limited[1])


def _by_name(allocate: Any, _: Any, limited: Any, *columns: Any) -> Pair:
    return limited, _columns([allocate(tau, f_min=low, f_max=high) for tau, low, high in _calls(*columns)])


def _behind_none(allocate: Any, _: Any, limited: Any, *columns: Any) -> Pair:
    return limited, _second(allocate, zip(columns[0]), _calls(*columns))


def _before_none(allocate: Any, usual: Any, _: Any, *columns: Any) -> Pair:
    return usual, _second(allocate, _calls(*columns), zip(columns[0]))


def _limits(convert: Callable[[Any], Any]) -> Callable[..., Pair]:
    """The form of calls that are given the rows of what ``convert`` makes of demands and limits."""

    def form(allocate: Any, _: Any, limited: Any, *columns: Any) -> Pair:
        return limited, _columns([allocate(*call) for call in zip(*map(convert, columns), strict=True)])

    return form


def _again(_: Any, many: Any, taus: Any) -> Pair:
    F, status = many(taus.copy())
    usual = F.copy(), list(status)
    many(-taus)
    return usual, (F, status)


def _sides(first: Callable[[Any], Any], second: Callable[[Any], Any]) -> Callable[..., Pair]:
    """The form of ``many`` whose f_min and f_max are what these make of (N, n) limits."""

    def form(allocate: Any, many: Any, taus: Any, low: Any, high: Any) -> Pair:
        import numpy as np

        given = first(low), second(high)
        each = [
            [None] * len(taus) if side is None else np.broadcast_to(side, low.shape).copy() for side in given
        ]
        usual = _columns([allocate(*call) for call in zip(taus.copy(), *each, strict=True)])
        return usual, many(taus.copy(), *(None if side is None else side.copy() for side in given))

    return form


def _row(side: Any) -> Any:
    return side[0]


def _none(_: Any) -> None:
    return None


def _each(side: Any) -> Any:
    return side


def _columnwise_many(allocate: Any, many: Any, *columns: Any) -> Pair:
    return _singly(allocate, *columns), many(*map(_columnwise, columns))


def _untouched(_: Any, many: Any, *columns: Any) -> Pair:
    """Arguments of ``many``, before and after, in place of thrusts."""
    import numpy as np

    given = [each.copy() for each in columns]
    many(*given)
    return (np.hstack(columns), []), (np.hstack(given), [])


ARRAYS: dict[str, Callable[[Any], Any]] = {
    "a list of whole numbers": lambda taus: _whole(taus).tolist(),
    "an array of whole numbers": _whole,
    "an array made of columns": _columnwise,
    "an array in single precision": lambda taus: taus.astype("float32"),
}
OF_DEMANDS: dict[str, Callable[..., Pair]] = {
    **{name: _rows(convert) for name, convert in ARRAYS.items()},
    "an array that is used again": _used_again,
    "a demand next to the last": _next_to,
}
OF_LIMITS: dict[str, Callable[..., Pair]] = {
    "limits of a demand asked before without": _inside,
    "limits by name": _by_name,
    "limits in lists": _limits(lambda columns: columns.tolist()),
    "limits in an array made of columns": _limits(_columnwise),
    "limits behind a call without": _behind_none,
    "no limits behind a call with": _before_none,
}
OF_MANY: dict[str, Callable[..., Pair]] = {
    **{f"many() of {name}": _tables(convert) for name, convert in ARRAYS.items()},
    "many() called again": _again,
}
OF_BOTH: dict[str, Callable[..., Pair]] = {
    "many() with one row of limits": _sides(_row, _row),
    "many() with one row of f_min alone": _sides(_row, _none),
    "many() with one row of f_max alone": _sides(_none, _row),
    "many() with one row of f_min, f_max of each": _sides(_row, _each),
    "many() with one row of f_max, f_min of each": _sides(_each, _row),
    "many() with limits in an array made of columns": _columnwise_many,
    "what many() is given": _untouched,
}


def _limited(allocate: Any, *columns: Any) -> Any:
    """Usual calls with limits; None where it takes none, or fails with them, which is judged elsewhere."""
    try:
        return _singly(allocate, *columns)
    except Exception:
        return None


def _singly(allocate: Any, *columns: Any) -> tuple[Any, Any]:
    return _columns([allocate(*call) for call in _calls(*columns)])


def _second(allocate: Any, calls: Any, others: Any) -> tuple[Any, Any]:
    """Answers to calls that each follow another call."""
    answers = []
    for call, other in zip(calls, others, strict=True):
        allocate(*(each.copy() for each in call))
        answers.append(allocate(*(each.copy() for each in other)))
    return _columns(answers)


def _calls(*columns: Any) -> Any:
    return zip(*(each.copy() for each in columns), strict=True)


def _columns(answers: list[Any]) -> tuple[Any, Any]:
    return [answer[0].copy() for answer in answers], [answer[1] for answer in answers]


def _array(F: Any) -> Any:
    import numpy as np

    return np.array(F, dtype=float)
