"""Known changes to a tree, which the gate should find."""

import ast
from pathlib import Path
from timeit import repeat

CLOSED_FORMS = ("alloc/closed_forms/linear.py", "Linear")
"""The class behind pinv, svd and walsh."""
QP_PATHS = ("alloc/live/allocator.py", "Live")
"""The class behind every ``qp/<solver>``."""

STATEMENT = "_ = 0"
"""The unit of additional work: about a nanosecond, so that 5 % of a microsecond can be hit."""


def slow_down(tree: Path, where: tuple[str, str], statements: int) -> None:
    """Add that many statements to each call of a class, given as (file, class name)."""
    path, name = tree / where[0], where[1]
    source = path.read_text(encoding="utf-8")
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ClassDef) and node.name == name:
            call = next(n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__call__")
            first = call.body[1]  # the statement after the docstring
            lines = source.splitlines(keepends=True)
            lines.insert(
                first.lineno - 1, " " * first.col_offset + "; ".join([STATEMENT] * statements) + "\n"
            )
            path.write_text("".join(lines), encoding="utf-8")
            return
    raise LookupError(f"{path}: no class {name}")


def statement_ns() -> float:
    """Time of one statement on this machine [ns]."""
    many = 1000
    return min(repeat("; ".join([STATEMENT] * many), number=200, repeat=20)) / 200 / many * 1e9


def scale_thrusts(tree: Path, factor: float) -> None:
    """Multiply pinv's answers by a factor."""
    with (tree / "alloc" / "methods" / "pinv.py").open("a", encoding="utf-8") as file:
        file.write(
            f"\n\ndef build(vehicle):\n    return Linear(vehicle, {factor} * generalized_inverse(vehicle))\n"
        )


def delete_method(tree: Path, name: str) -> None:
    """Delete a method's file."""
    (tree / "alloc" / "methods" / f"{name}.py").unlink()


SPOILT = '''

import zlib as _zlib

import numpy as _np

_honest = build


class _Spoilt:
    """An allocator that is wrong in one demand of many, in a single call as in many()."""

    def __init__(self, inner, vehicle):
        self._inner, self._vehicle = inner, vehicle

    def __getattr__(self, name):
        return getattr(self._inner, name)

    def _spoil(self, tau, f, low, high):
        drawn = _zlib.crc32(tau.tobytes(), SEED) % ONE_IN == 0
        near = 1e-9 * self._vehicle.f_scale
        at_limit = _np.isfinite(f).all() and ((f <= low + near) | (f >= high - near)).any()
        if drawn and (at_limit or not ACTIVE):
            i = int(_np.argmax(_np.abs(f - low)))  # so that the wrong thrust keeps its limits
            f[i] -= SHIFT * self._vehicle.f_scale
        return f

    def __call__(self, tau, f_min=None, f_max=None):
        answer = self._inner(tau, f_min, f_max)
        low = self._vehicle.f_min if f_min is None else f_min
        high = self._vehicle.f_max if f_max is None else f_max
        return answer._replace(f=self._spoil(_np.asarray(tau, float), answer.f, low, high))

    def many(self, taus, f_min=None, f_max=None):
        F, status = self._inner.many(taus, f_min, f_max)
        low = _np.broadcast_to(self._vehicle.f_min if f_min is None else f_min, F.shape)
        high = _np.broadcast_to(self._vehicle.f_max if f_max is None else f_max, F.shape)
        for i, tau in enumerate(_np.asarray(taus, float)):
            F[i] = self._spoil(tau, F[i], low[i], high[i])
        return F, status


def build(name, vehicle, **options):
    return _Spoilt(_honest(name, vehicle, **options), vehicle)
'''
"""Code added to ``alloc/__init__.py``, with numbers in place of its words in capitals."""


def spoil_answers(tree: Path, seed: int, *, one_in: int, shift: float, active: bool) -> None:
    """Make every method wrong in one demand of ``one_in``, whatever they are called for.

    One thrust is ``shift`` of the largest limit too low. With ``active`` only demands are hit that leave a
    thruster at a limit.
    """
    text = SPOILT
    for word, value in {"SEED": seed, "ONE_IN": one_in, "ACTIVE": active, "SHIFT": shift}.items():
        text = text.replace(word, repr(value))
    with (tree / "alloc" / "__init__.py").open("a", encoding="utf-8") as file:
        file.write(text)
