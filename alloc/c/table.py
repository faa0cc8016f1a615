"""The constants of a C function."""

from alloc.program import Scalar
from alloc.program.literal import number


class Table:
    """The constants of one function, each held once; the C refers to them as ``c[i]``."""

    def __init__(self, scalar: Scalar) -> None:
        """An empty table of that type."""
        self.scalar = scalar
        self._index: dict[str, int] = {}
        self._columns: dict[tuple[str, ...], int] = {}

    def __call__(self, value: float) -> str:
        """The C expression for a constant; its sign stands in front, so that +-x share an entry."""
        if value == 0.0:
            return number(0.0, self.scalar)
        entry = self._index.setdefault(number(abs(value), self.scalar), len(self._index))
        return f"{'-' if value < 0 else ''}c[{entry}]"

    def by_fault(self, values: tuple[float, ...]) -> str:
        """The C expression for a constant that each fault has its own of, in the row of the fault."""
        column = tuple(number(value, self.scalar) for value in values)
        return f"of[{self._columns.setdefault(column, len(self._columns))}]"

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Constants that differ between faults, a row a fault; empty where nothing differs."""
        return list(zip(*self._columns, strict=True))

    def define(self) -> list[str]:
        """The lines that define the table; none where it is empty."""
        values = ",\n    ".join(self._index)
        return [f"static const {self.scalar} c[] = {{\n    {values}\n}};"] if values else []
