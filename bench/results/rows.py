"""A run as reports see it: the record's cells gathered into rows, one a line of results.csv."""

import re
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import median

from bench.record import Batch, Cell, Judged, Record, Worker, read
from bench.record.capability import Worth
from bench.results.disturbance import canary_median_ns, disturbances
from bench.results.quantiles import Counted, merged


@dataclass(frozen=True)
class Row:
    """One method with its start and level on one vehicle's demand set: every repeat of it.

    Attributes
    ----------
    cells : the repeats, each measured by a process of its own
    workers : those processes
    disturbed : what disturbed the machine meanwhile, empty where it was quiet
    attainable : share of the set's demands that are labelled inactive or active
    """

    vehicle: str
    demands: str
    method: str
    start: str
    level: str
    cells: tuple[Cell, ...]
    workers: tuple[Worker, ...]
    disturbed: tuple[str, ...]
    attainable: float = 0.0

    @property
    def label(self) -> str:
        """Method, start and level as tables show them, e.g. ``qp/osqp warm tight``; default is not said."""
        return " ".join([self.method, *(w for w in (self.start, self.level) if w not in ("-", "default"))])

    @cached_property
    def failed(self) -> Cell | None:
        """The first repeat that was not measured, None where all were."""
        return next((cell for cell in self.cells if cell.status != "ok"), None)

    @cached_property
    def singles(self) -> Counted:
        """Times of single calls of all repeats together [ns]."""
        return merged(cell.singles for cell in self.cells)

    @cached_property
    def judged(self) -> list[Judged]:
        """What the equations say, one entry a repeat that was judged."""
        return [cell.judged for cell in self.cells if cell.judged is not None]

    def centre(self, batches: Callable[[Cell], Sequence[Batch]], clock: str = "wall_ns") -> list[float]:
        """Median time of a call [ns] over the batches of each repeat, one number a repeat."""
        timed = [batches(cell) for cell in self.cells]
        return [median(getattr(b, clock) / b.calls for b in repeat) for repeat in timed if repeat]

    def worst(self, what: Callable[[Judged], float | None]) -> float | None:
        """The largest value of ``what`` over the repeats, None where nobody has one."""
        return max((value for j in self.judged if (value := what(j)) is not None), default=None)


SETS = ("active", "inactive", "boundary", "infeasible", "box", "axes", "mission")
"""Order of demand sets in tables; the first one there is stands for the vehicle in pictures."""


GENERATED = "growth-"
"""Vehicles generated for the growth study, called so, are shown by their number of thrusters only."""

FAULTS = re.compile(r"(-f\d+(@[\d.e-]+)?)+$")
"""What ``Vehicle.with_fault`` adds to a vehicle's name."""


@dataclass(frozen=True)
class Run:
    """A record and its rows."""

    record: Record
    rows: tuple[Row, ...]

    @cached_property
    def by_vehicle(self) -> dict[str, list[Row]]:
        """Rows of each vehicle, sorted by its name; canaries, which belong to none, left out."""
        found: dict[str, list[Row]] = {}
        for row in self.rows:
            if row.vehicle != "-":
                found.setdefault(row.vehicle, []).append(row)
        return found

    @property
    def vehicles(self) -> list[str]:
        """Vehicles with sections of their own: neither generated ones nor the ``degraded``."""
        degraded = set(self.degraded)
        return [v for v in self.by_vehicle if v not in degraded and not v.startswith(GENERATED)]

    @property
    def degraded(self) -> list[str]:
        """Vehicles that are another one of this run after a failure."""
        return [v for v in self.by_vehicle if (whole := FAULTS.sub("", v)) != v and whole in self.by_vehicle]

    def sets(self, vehicle: str) -> list[str]:
        """Demand sets of a vehicle, in the order of tables."""
        found = {row.demands for row in self.by_vehicle[vehicle]}
        return sorted(found, key=lambda name: (SETS.index(name) if name in SETS else len(SETS), name))

    def singles(self, row: Row) -> Counted:
        """Single calls of a row's method, start and level on all of its vehicle's demand sets [ns]."""
        return merged(other.singles for other in self.of(row.vehicle) if other.label == row.label)

    def worth(self, vehicle: str) -> Worth | None:
        """What the vehicle can do and who serves it; None where the record does not say, as for a failure."""
        return next((worth for worth in self.record.worths if worth.vehicle == vehicle), None)

    def of(self, vehicle: str, demands: str = "") -> list[Row]:
        """Rows of a vehicle on one demand set, or on all."""
        return [row for row in self.by_vehicle.get(vehicle, []) if demands in ("", row.demands)]


def read_run(directory: Path) -> Run:
    """The run in a folder; raises RecordError where there is no readable record."""
    record = read(directory)
    return Run(record, gather(record))


def gather(record: Record) -> tuple[Row, ...]:
    """The record's cells as rows, sorted by vehicle, demand set, method, start and level."""
    repeats: dict[tuple[str, str, str, str, str], dict[int, Cell]] = defaultdict(dict)
    for cell in record.cells:
        k = cell.key
        repeats[k.vehicle, k.demands, k.method, k.start, k.level][k.repeat] = cell
    usual, cores = canary_median_ns(record), record.header.machine.get("cores")
    attainable = {
        (p.vehicle, p.demands): (p.labels.get("inactive", 0) + p.labels.get("active", 0)) / p.n_demands
        for p in record.problems
        if p.n_demands
    }
    rows = []
    for key, cells in sorted(repeats.items()):
        at_work = tuple(w for w in record.workers if (w.method, w.start, w.level) == key[2:])
        repeated = tuple(cells[r] for r in sorted(cells))
        busy = disturbances(repeated, usual, cores)
        rows.append(Row(*key, repeated, at_work, busy, attainable.get(key[:2], 0.0)))
    return tuple(rows)
