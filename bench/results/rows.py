"""Rows of a run: the record's cells gathered, one row for each line of results.csv, with disturbances.

The table of a run is a pandas frame. Polars is imported in less time (0.3 s after NumPy, pandas 0.55 s), but
takes 180 MB where pandas takes 85, and its usual wheels need AVX2, which an Atom on board does not have.
pandas is imported where a frame is made, not before.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple, get_type_hints

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from alloc.formulations import find_formulation
from bench.record import (
    NO_VEHICLE,
    Capability,
    Cell,
    Header,
    Key,
    Method,
    Problem,
    Record,
    Served,
    Worker,
    read,
)
from bench.results.columns import Row, columns
from bench.results.quantiles import Histogram, Repeats, group, largest, merge, quantile

if TYPE_CHECKING:
    import pandas as pd

INTERRUPTED_SHARE = 0.1
"""Share of batches that may have an involuntary switch: up to one in ten does not move their median."""
STEAL_TICKS = 2
"""Ticks of 10 ms taken by the hypervisor that disturb; a single tick may be the clock's own rounding."""
SLOWEST_SHARE = 0.9
"""Lowest clock frequency over the highest; a lower ratio means a governor or a hot core."""
DRIFT = 0.1
"""Change of the fixed canary against the run's median; between processes it repeats within 2 %."""


def canary_median_ns(record: Record) -> float | None:
    """Median time of the run's fixed canary [ns], None without one."""
    times = [cell.canary_ns for cell in record.cells if cell.canary_ns is not None]
    return float(median(times)) if times else None


def disturbances(cells: Iterable[Cell], usual_canary_ns: float | None, cores: int | None) -> tuple[str, ...]:
    """Names of what disturbed any of the cells; empty where the machine was quiet."""
    names = (name for cell in cells for name in _disturbances(cell, usual_canary_ns, cores))
    return tuple(dict.fromkeys(names))


def _disturbances(cell: Cell, usual_canary_ns: float | None, cores: int | None) -> list[str]:
    quiet, names = cell.quiet, []
    interrupted = sum(batch.switches > 0 for batch in cell.batches)
    if interrupted > INTERRUPTED_SHARE * len(cell.batches):
        names.append("involuntary switches")
    if usual_canary_ns and cell.canary_ns and abs(cell.canary_ns / usual_canary_ns - 1) > DRIFT:
        names.append("canary drift")
    if quiet is None:
        return names
    if (quiet.steal_ticks or 0) >= STEAL_TICKS:
        names.append("steal")
    if quiet.throttled:
        names.append("throttled")
    if quiet.mhz and min(quiet.mhz) < SLOWEST_SHARE * max(quiet.mhz):
        names.append("frequency")
    if quiet.load is not None and cores and quiet.load > cores:
        names.append("load")
    return names


class RowSamples(NamedTuple):
    """Times of all repeats of a row; B batches of calls, and S calls that were timed singly.

    Attributes
    ----------
    repeat : (B,) which repeat measured each batch, counted from 0
    calls : (B,) calls in each batch
    wall_ns, cpu_ns : (B,) time that each batch took, by the clock and of the thread's own CPU time [ns]
    single_ns : (S,) time of each single call [ns], sorted; records keep it in bins 2 % wide
    """

    repeat: NDArray[np.int64]
    calls: NDArray[np.int64]
    wall_ns: NDArray[np.int64]
    cpu_ns: NDArray[np.int64]
    single_ns: NDArray[np.int64]


def samples(row: Row) -> RowSamples:
    """Measured times of a row, before any statistics."""
    batches = [
        (i, b.calls, b.wall_ns, b.cpu_ns) for i, cell in enumerate(row.measured.cells) for b in cell.batches
    ]
    repeat, calls, wall_ns, cpu_ns = np.array(batches, np.int64).reshape(-1, 4).T
    times, counts = np.array(row.measured.singles, np.int64).reshape(-1, 2).T
    return RowSamples(repeat, calls, wall_ns, cpu_ns, np.repeat(times, counts))


SETS = ("active", "inactive", "boundary", "infeasible", "box", "axes", "mission")
"""Order of demand sets in tables. The first set that a vehicle has represents it in pictures."""

KINDS = {int: "Int64", int | None: "Int64", float | None: "float64"}
"""Types of a frame's numbers, also where a column is empty."""

FORM = ("scalar", "limits", "faults")
"""Properties of a board's C that decide the time of a call and its answers."""


@dataclass(frozen=True, eq=False)
class Run:
    """A record and its rows; two runs are never equal, so what is worked out of one can be kept.

    Attributes
    ----------
    record : all facts of the run
    rows : its cells gathered, sorted by vehicle, demand set, method, start and level
    """

    record: Record
    rows: tuple[Row, ...]

    @property
    def header(self) -> Header:
        """Start, commit, versions, options and files of the run."""
        return self.record.header

    @property
    def machine(self) -> dict[str, Any]:
        """The facts about the machine: processor, cores, memory, governor, OS, kernel."""
        return self.record.header.machine

    @property
    def by_driver(self) -> bool:
        """True if the C driver of ``thrustbench board`` called the methods, and nothing in Python."""
        return "port" in self.machine

    @property
    def form(self) -> dict[str, str]:
        """Precision, limits and faults of the C that a board's driver called; empty where Python called."""
        said = self.record.header.settings
        return {key: str(said.get(key, "unknown")) for key in FORM} if self.by_driver else {}

    def samples(self, row: Row) -> RowSamples:
        """The times of a row as they were taken, before any statistics."""
        return samples(row)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """One frame with the columns of results.csv: line i is ``rows[i]``, NA where that has None."""
        import pandas as pd

        series = {}
        for name, column in columns().items():
            kind = KINDS.get(get_type_hints(column)["return"])
            series[name] = pd.Series([getattr(row, name) for row in self.rows], dtype=kind)
        return pd.DataFrame(series)

    @cached_property
    def by_vehicle(self) -> dict[str, list[Row]]:
        """Rows by vehicle, in the order of names; canaries belong to no vehicle and are left out."""
        return group((row for row in self.rows if row.vehicle != NO_VEHICLE), lambda row: row.vehicle)

    @cached_property
    def by_method(self) -> dict[tuple[str, str], list[Row]]:
        """Rows of each vehicle and ``label``: a method with its start and level on all demand sets."""
        rows = (row for own in self.by_vehicle.values() for row in own)
        return group(rows, lambda row: (row.vehicle, row.label))

    @cached_property
    def measured(self) -> list[Row]:
        """Rows of vehicles that have a time."""
        return [row for own in self.by_vehicle.values() for row in own if not row.failed]

    @cached_property
    def disturbances(self) -> Counter[str]:
        """Number of ``measured`` rows by what disturbed them."""
        return Counter(what for row in self.measured for what in row.measured.disturbances)

    @cached_property
    def disturbed(self) -> int:
        """Number of ``measured`` rows that something disturbed."""
        return sum(not row.undisturbed for row in self.measured)

    @cached_property
    def problem_by_set(self) -> dict[tuple[str, str], Problem]:
        """The problem of each vehicle and demand set."""
        return {(problem.vehicle, problem.demands): problem for problem in self.record.problems}

    @cached_property
    def problems(self) -> dict[str, Problem]:
        """One problem for each vehicle, for the facts about the vehicle itself."""
        return {problem.vehicle: problem for problem in self.record.problems}

    @property
    def vehicles(self) -> list[str]:
        """Vehicles with sections of their own: all but a study's vehicles and the ``degraded`` ones."""
        degraded = set(self.degraded)
        return [name for name in self.by_vehicle if name not in degraded and not self.study(name)]

    @property
    def degraded(self) -> list[str]:
        """Vehicles that are another vehicle of this run after a failure."""
        return [name for name in self.by_vehicle if self.whole(name) in self.by_vehicle.keys() - {name}]

    def study(self, vehicle: str) -> str:
        """The study that a vehicle was generated for, empty for any other vehicle."""
        return self.problems[vehicle].study if vehicle in self.problems else ""

    def whole(self, vehicle: str) -> str:
        """Name of the vehicle without its faults."""
        return self.problems[vehicle].whole if vehicle in self.problems else vehicle

    def sets(self, vehicle: str) -> list[str]:
        """Demand sets of a vehicle, in the order of tables."""
        return sort_sets({row.demands for row in self.by_vehicle[vehicle]})

    def leading_sets(self, vehicle: str) -> list[str]:
        """The sets that stand for all of a vehicle's: the first of tables, and each that a user brought."""
        first, *others = self.sets(vehicle)
        return [first, *(name for name in others if self.is_log(vehicle, name))]

    @property
    def main_sets(self) -> list[tuple[str, str]]:
        """Each vehicle with each of its ``leading_sets``: the tables of report.md."""
        return [(vehicle, demands) for vehicle in self.vehicles for demands in self.leading_sets(vehicle)]

    def is_log(self, vehicle: str, demands: str) -> bool:
        """True if a user brought that set."""
        problem = self.problem_by_set.get((vehicle, demands))
        return problem is not None and problem.given

    def singles(self, row: Row) -> Histogram:
        """Single calls of a row's method, start and level on all of its vehicle's demand sets [ns]."""
        return self._singles.get((row.vehicle, row.label), [])

    @cached_property
    def _singles(self) -> dict[tuple[str, str], Histogram]:
        return {key: merge(row.measured.singles for row in rows) for key, rows in self.by_method.items()}

    def tail_us(self, row: Row, q: float) -> float | None:
        """Quantile ``q`` of ``singles`` [us]; None where there are too few, on any set, for it.

        A set on which calls take long has few of them. Where its median lies above the quantile of all, that
        quantile leaves the set out.
        """
        tail = quantile(self.singles(row), q)
        slowest = largest(r.call_p50_us for r in self.by_method.get((row.vehicle, row.label), [])) or 0.0
        return None if tail is None or tail / 1000 < slowest else tail / 1000

    def capability(self, vehicle: str) -> Capability | None:
        """The vehicle's capability; None where the record has none, as for a degraded vehicle."""
        return next((c for c in self.record.capabilities if c.vehicle == vehicle), None)

    @property
    def capabilities(self) -> list[Capability]:
        """Capabilities of ``vehicles``, in their order."""
        return [known for vehicle in self.vehicles if (known := self.capability(vehicle))]

    def select(self, vehicle: str, demands: str = "") -> list[Row]:
        """Rows of a vehicle on one demand set, or on all."""
        return [row for row in self.by_vehicle.get(vehicle, []) if demands in ("", row.demands)]


def sort_sets(sets: Iterable[str]) -> list[str]:
    """Names of demand sets in the order of tables."""
    return sorted(sets, key=lambda name: (SETS.index(name) if name in SETS else len(SETS), name))


def count_answers(rows: Iterable[Row]) -> str:
    """Demands that got thrusts, of how many asked, ``20 of 60``; empty where it is not known."""
    known = [(row.n_demands, row.answered_share) for row in rows]
    asked = sum(n for n, share in known if share is not None)
    return f"{sum(round(n * share) for n, share in known if share is not None)} of {asked}" if asked else ""


def served_count(run: Run, row: Row) -> Served | None:
    """Count of demands drawn evenly that answers like a row's were asked; None without.

    They are the method's own or those of its base. Other foreign code of this project answers as the counted
    method of its formulation does; where that is the optimum, a solver may miss it.
    """
    capability, own = run.capability(row.vehicle), row.described
    whole = [s for s in capability.served if s.fault is None] if capability else []
    names = [row.method, own.base]
    if own.foreign and not (own.twin or own.plugin or find_formulation(row.formulation).optimal):
        names += [m.name for m in run.record.methods if m.formulation == row.formulation and not m.plugin]
    return next((s for name in names for s in whole if s.method == name), None)


def read_run(directory: Path) -> Run:
    """The run in a folder; raises RecordError where there is no readable record."""
    record = read(directory)
    return Run(record, gather(record))


def _choice(key: Key) -> tuple[str, str, str]:
    return key.method, key.start, key.level


def gather(record: Record) -> tuple[Row, ...]:
    """The record's cells as rows, sorted by vehicle, demand set, method, start and level."""
    repeats: dict[Key, dict[int, Cell]] = defaultdict(dict)
    for cell in record.cells:
        repeats[replace(cell.key, repeat=0)][cell.key.repeat] = cell
    usual, counted = canary_median_ns(record), record.header.machine.get("cores")
    cores = counted if isinstance(counted, int) else None
    problems = {(p.vehicle, p.demands): p for p in record.problems}
    attainable = {
        (p.vehicle, p.demands): (p.labels.get("inactive", 0) + p.labels.get("active", 0)) / p.n_demands
        for p in record.problems
        if p.n_demands
    }
    unique = {problem.vehicle for problem in record.problems if problem.n == problem.rank}
    workers: dict[tuple[str, str, str], list[Worker]] = defaultdict(list)
    for worker in record.workers:
        workers[worker.method, worker.start, worker.level].append(worker)
    methods = {method.name: method for method in record.methods}
    wrong = {(c.vehicle, method): what for c in record.capabilities for method, what in c.wrong.items()}
    plugins = {method.name for method in record.methods if method.plugin}
    others = {
        (cell.key.vehicle, *_choice(cell.key)): f"{cell.judged.objection} ({cell.key.demands} demands)"
        for cell in record.cells
        if cell.key.method in plugins and cell.judged is not None and cell.judged.objection
    }
    missing = {
        (c.vehicle, s.method)
        for c in record.capabilities
        for s in c.served
        if s.fault is None and s.within_1pct < s.n_demands
    }
    rows = []
    for key, cells in sorted(repeats.items()):
        repeated = tuple(cells[r] for r in sorted(cells))
        described = methods.get(key.method, Method(name=key.method))
        rows.append(
            Row(
                Repeats(
                    key=key,
                    origin=record.header,
                    described=described,
                    cells=repeated,
                    workers=tuple(workers[_choice(key)]),
                    disturbances=disturbances(repeated, usual, cores),
                    attainable=attainable.get((key.vehicle, key.demands), 0.0),
                    unique=key.vehicle in unique,
                    wrong_elsewhere=wrong.get((key.vehicle, key.method), ""),
                    wrong_on_others=others.get((key.vehicle, *_choice(key)), ""),
                    missed_elsewhere=(key.vehicle, described.base) in missing,
                    problem=problems.get((key.vehicle, key.demands)),
                )
            )
        )
    return tuple(rows)
