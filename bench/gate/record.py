"""What a gate leaves behind: every fact its verdict is made from, as plain values."""

from typing import Any

import msgspec

SCHEMA = 1

CONTROL = "control"
"""Stands where other cells have their vehicle."""


class GateSettings(msgspec.Struct, frozen=True):
    """How much is measured, and what counts as a regression.

    ``docs/gate.md`` has the table of what these figures find, and of what they call in vain. Between
    identical trees the mean of ten pairs scatters by 0.6 %, and by 1 % for generated C, which takes 0.1 µs:
    the threshold is three to five such standard deviations, and must be passed again over twice the pairs.

    Attributes
    ----------
    threshold : share by which a cell may get slower
    pairs, blocks : pairs of fresh processes, and blocks in each of a pair
    block_ms : CPU time of one block
    budget_s : wall time for everything
    seed : of hash seeds, environment sizes, cell order
    """

    threshold: float = 0.03
    pairs: int = 10
    blocks: int = 5
    block_ms: float = 2.0
    budget_s: float = 120.0
    seed: int = 2004


class GateCell(msgspec.Struct, omit_defaults=True):
    """A vehicle, method and start on both sides. An empty string means that nothing is the matter.

    base_lacks, head_lacks : why that side has no such cell
    base_wrong, head_wrong : what the equations say against that side's answers
    differ : how answers that are right on both sides differ
    rounds, calls : a block goes ``rounds`` times through the demands, ``calls`` calls in all
    instructions : per call, (base, head), once and again where it was confirmed
    pairs : [pair][block] = (base, head) CPU time [ns]
    """

    vehicle: str
    method: str
    start: str = "-"
    base_lacks: str = ""
    head_lacks: str = ""
    base_wrong: str = ""
    head_wrong: str = ""
    differ: str = ""
    rounds: int = 0
    calls: int = 0
    instructions: list[tuple[float, float]] = []
    pairs: list[list[tuple[int, int]]] = []

    @property
    def name(self) -> str:
        """``vehicle:method:start``, which patterns are held against."""
        return f"{self.vehicle}:{self.method}:{self.start}"

    @property
    def is_control(self) -> bool:
        """Whether it is one of the cells that no commit can change."""
        return self.vehicle == CONTROL


class GateRecord(msgspec.Struct):
    """One gate. ``unchanged`` says why nothing had to be measured; ``cut`` why less was than asked for."""

    base: str
    head: str
    settings: GateSettings
    schema: int = SCHEMA
    commits: list[str] = []
    machine: dict[str, Any] = {}
    unchanged: str = ""
    cells: list[GateCell] = []
    crashed: str = ""
    cut: str = ""
    notes: list[str] = []
    seconds: dict[str, float] = {}
