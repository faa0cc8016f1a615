"""Boards, each a file here with its ``BOARD``: a processor at a clock, behind a slow flash.

Flash is read a line at a time, and small caches keep some lines of code, and of tables and literals. While a
line executes the next one is read ahead. How long a wait is nobody publishes for each case, so it is an
interval: a line that is read ahead may be there in time; a line that is not has ``waits`` cycles to come, and
as many once more, and one, where it comes behind a line that is being read.

Where the linker puts a call, and which lines the rest of the program leaves in the caches, belongs to that
program. So the least is of a call that follows an equal one, at the best of the places that lines allow, and
the most of one that finds empty caches, at the worst.
"""

from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from alloc.allocation import IndexArray
from alloc.files.modules import modules
from bench.chips.instructions import Cycles
from bench.record import BoardFacts

WORD = 4
"""Functions and tables begin at such multiples [bytes]."""


@dataclass(frozen=True, kw_only=True)
class Flash:
    """A flash and what is in front of it.

    Attributes
    ----------
    line : what one read brings [bytes]
    waits : cycles that a read takes beyond the first, at the board's clock
    code_lines, data_lines : how many lines of code, and of tables and literals, are kept; of both the ones
        that were used last
    """

    line: int
    waits: int
    code_lines: int
    data_lines: int

    @property
    def queued_wait(self) -> int:
        """Cycles to wait at most for a line that comes behind another."""
        return 2 * self.waits + 1


class Touched(NamedTuple):
    """Lines that a call has to read, as no cache has them.

    Attributes
    ----------
    ahead : of code, each next to the one before, which is read ahead
    jumped : of code, each reached by a branch
    data : of tables and literals
    """

    ahead: int
    jumped: int
    data: int


def waiting(flash: Flash, warm: Touched, cold: Touched) -> Cycles:
    """Cycles that a call waits: at least with the caches ``warm``, at most with them ``cold``."""
    low = flash.waits * (warm.jumped + warm.data)
    return Cycles(low, flash.waits * cold.ahead + flash.queued_wait * (cold.jumped + cold.data))


def touched(flash: Flash, code: IndexArray, data: IndexArray) -> tuple[Touched, Touched]:
    """Addresses that a call reads, warm and cold: of its instructions and of its data, in order."""
    moved = range(0, flash.line, WORD)
    of_code = [_lines(code, flash.line, by) for by in moved]
    of_data = [_lines(data, flash.line, by) for by in moved]
    warm_code = min((_code(lines, flash, again=True) for lines in of_code), key=lambda found: found[1])
    cold_code = max(_code(lines, flash, again=False) for lines in of_code)
    warm_data = min(sum(_missed(lines, flash.data_lines, again=True)) for lines in of_data)
    cold_data = max(sum(_missed(lines, flash.data_lines, again=False)) for lines in of_data)
    return Touched(*warm_code, warm_data), Touched(*cold_code, cold_data)


def _lines(addresses: IndexArray, line: int, moved: int) -> list[int]:
    """The lines that are asked for, one after another: a line in use is not asked for again."""
    lines = (addresses + moved) // line
    changed = np.r_[True, np.diff(lines) != 0] if len(lines) else np.zeros(0, dtype=bool)
    return [int(one) for one in lines[changed]]


def _code(lines: list[int], flash: Flash, *, again: bool) -> tuple[int, int]:
    """Numbers of missed lines of code that follow the one before, and that do not."""
    ahead = jumped = 0
    before = None
    for one, missed in zip(lines, _missed(lines, flash.code_lines, again=again), strict=True):
        ahead += missed and before is not None and one == before + 1
        jumped += missed and (before is None or one != before + 1)
        before = one
    return ahead, jumped


def _missed(lines: list[int], room: int, *, again: bool) -> Iterable[bool]:
    """Mask of lines that are not among the ``room`` used last; ``again`` the second time."""
    kept: OrderedDict[int, None] = OrderedDict()
    found = []
    for one in [*lines, *lines] if again else lines:
        found.append(one not in kept)
        kept[one] = None
        kept.move_to_end(one)
        if len(kept) > room:
            kept.popitem(last=False)
    return found[len(lines) :] if again else found


@dataclass(frozen=True, kw_only=True)
class Board:
    """A board, or the microcontroller on it.

    Attributes
    ----------
    name : the file's
    processor : its processor's name in ``bench.chips.processors``
    clock_MHz : clock that the flash is set up for [MHz]
    flash : the flash, and what is in front of it
    basis : where the numbers come from
    """

    name: str = ""
    processor: str
    clock_MHz: float
    flash: Flash
    basis: str

    @property
    def facts(self) -> BoardFacts:
        """Facts for reports: a part of its processor's line in a record."""
        return BoardFacts(name=self.name, clock_MHz=self.clock_MHz, basis=self.basis)


def boards(processor: str) -> list[Board]:
    """All boards that have this processor, by name."""
    found = [replace(module.BOARD, name=name) for name, module in modules(__name__).items()]
    return [board for board in found if board.processor == processor]
