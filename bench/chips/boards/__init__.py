"""Boards: a processor at a clock, behind a flash. Each file holds one as ``BOARD``, and is its name."""

from dataclasses import dataclass, replace

from alloc.files.modules import modules
from bench.chips.flash import Flash
from bench.record import BoardFacts


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
