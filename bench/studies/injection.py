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
