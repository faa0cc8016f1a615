"""Record of a gate: its cells, and every fact that its verdict is made from, as plain values."""

import fnmatch
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from glob import escape
from typing import Any

import msgspec
import numpy as np

from alloc.errors import UnknownName

SCHEMA = 1

CONTROL = "control"
"""Name of a control cell in place of a vehicle."""


class GateSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Amounts to measure, and bounds of a regression.

    ``docs/gate.md`` has the table of what these settings find, and of their false alarms. Between identical
    trees the mean of ten pairs scatters by 0.6 %, and by 1 % for generated C, which takes 0.1 µs: the
    threshold is three to five such standard deviations, and must be passed again over twice the pairs.

    Attributes
    ----------
    threshold : share by which a cell may get slower [-]
    pairs, blocks : pairs of fresh processes, and blocks in each process of a pair
    block_ms : CPU time of one block [ms]
    budget_s : wall time for everything [s]
    seed : seed of hash seeds, environment sizes and the order of cells
    """

    threshold: float = 0.03
    pairs: int = 10
    blocks: int = 5
    block_ms: float = 2.0
    budget_s: float = 120.0
    seed: int = 2004


class GateCell(msgspec.Struct, omit_defaults=True, kw_only=True):
    """A vehicle, method and start on both sides.

    Attributes
    ----------
    vehicle, method, start : what names the cell
    base_lacks, head_lacks : why that side has no such cell, empty where it has
    base_wrong, head_wrong : what is wrong with that side's answers, empty where nothing is
    turned_wrong : what is wrong with head's answers to demands that base answered right, one set at a time,
        or with all of them where base lacks the cell
    differ : how answers differ, but for those that were wrong and are right now; empty where they don't
    rounds, calls : a block goes ``rounds`` times through the demands and makes ``calls`` calls
    instructions : (base, head) instructions per call, one entry a count
    pairs : [pair][block] = (base, head) CPU time [ns]
    """

    vehicle: str
    method: str
    start: str = "-"
    base_lacks: str = ""
    head_lacks: str = ""
    base_wrong: str = ""
    head_wrong: str = ""
    turned_wrong: str = ""
    differ: str = ""
    rounds: int = 0
    calls: int = 0
    instructions: list[tuple[float, float]] = []
    pairs: list[list[tuple[int, int]]] = []

    @property
    def name(self) -> str:
        """``vehicle:method:start``, which patterns are matched with."""
        return f"{self.vehicle}:{self.method}:{self.start}"

    @property
    def names(self) -> dict[str, Any]:
        """Names by which a worker builds the cell."""
        return {"vehicle": self.vehicle, "method": self.method, "start": self.start}

    def note(self, base: str, head: str) -> None:
        """Keep the first error of each side, and of head where base makes none."""
        self.base_wrong, self.head_wrong = self.base_wrong or base, self.head_wrong or head
        self.turned_wrong = self.turned_wrong or ("" if base else head)

    @property
    def is_control(self) -> bool:
        """True if it is one of the cells that no commit can change."""
        return self.vehicle == CONTROL


class GateRecord(msgspec.Struct, kw_only=True):
    """Measurements of one gate.

    Attributes
    ----------
    base, head : labels of the two sides
    settings : how much was asked to be measured
    schema : version of this record's layout
    commits : one line for each commit that head has and base has not
    machine : the machine as it describes itself
    unchanged : why nothing had to be measured, empty where something was
    cells : all cells of the gate, those that one side lacks included
    crashed : how the head's process ended, empty where it did not
    cut : why less was measured than asked for, empty where all was
    notes : remarks that change no verdict
    seconds : wall time of each stage [s], and of ``all``
    """

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


VEHICLES = ("ukwial", "bluerov2-heavy")

METHODS = (
    *("pinv", "svd", "walsh", "nullspace", "nullspace@native"),
    *("clip", "shrink", "redistribute", "qp/daqp:reused", "qp/piqp:reused"),
)
DEFAULT_CELLS = tuple(f"{vehicle}:{method}" for vehicle in VEHICLES for method in METHODS)
"""Closed forms, the exact method, practical rules and QP paths, on four thrusters and on eight."""

NEAR = 8
"""Most cells that a refusal names."""

Demands = Mapping[str, list[list[float]]]
"""By vehicle, the demands (N, k) [N, N m] that its cells are timed with."""

CONTROL_DEMANDS: list[list[float]] = np.linspace(-1.0, 1.0, 180).reshape(30, 6).tolist()


def matching_cells(cells: Sequence[Sequence[str]], patterns: Sequence[str]) -> list[GateCell]:
    """The cells whose name ``vehicle:method:start`` fits a shell pattern; the start may be left out."""
    named = [GateCell(vehicle=vehicle, method=method, start=start) for vehicle, method, start in cells]
    either = [pattern for each in patterns for pattern in (each, f"{each}:*")]
    return [cell for cell in named if any(fnmatch.fnmatchcase(cell.name, each) for each in either)]


def refuse_pattern(cells: Sequence[Sequence[str]], pattern: str) -> str:
    """The refusal of a pattern that fits no cell, with cells of its method, else like it, or all."""
    vehicle, method, *_ = *pattern.split(":"), ""
    names = list(dict.fromkeys(cell.name for cell in matching_cells(cells, ["*"])))
    of_method = [f"{vehicle}:{method or '*'}", f"*:{method or vehicle}"]
    fitting = ([cell.name for cell in matching_cells(cells, [asked])] for asked in of_method)
    close = get_close_matches(pattern, names, n=3, cutoff=0.8)
    of_vehicle = [cell.name for cell in matching_cells(cells, [f"{vehicle}:*"])]
    near = list(dict.fromkeys(next(filter(None, (*fitting, close, of_vehicle, names)), ["none"])))
    more = f" and {len(near) - NEAR} more" if len(near) > NEAR else ""
    return f"no cell of either side fits {pattern}; there are {', '.join(near[:NEAR])}{more}"


def restrict_patterns(vehicles: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """The patterns, for cells of these vehicles alone; raises UnknownName for one that is for another."""
    found = []
    for pattern in patterns:
        vehicle, _, rest = pattern.partition(":")
        fitting = [name for name in vehicles if fnmatch.fnmatchcase(name, vehicle)]
        if not fitting:
            named = " --vehicle ".join(vehicles)
            raise UnknownName(
                f"--cells {pattern}: is for none of --vehicle {named}; leave one of the two out, or write"
                " '*:METHOD'"
            )
        found += [f"{escape(name)}:{rest or '*'}" for name in fitting]
    return found


def controls() -> list[GateCell]:
    """The cells that no commit can change: a numpy product and a loop in Python."""
    return [GateCell(vehicle=CONTROL, method=method) for method in ("product", "loop")]
