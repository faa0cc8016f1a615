"""Runs of several machines side by side: their names, valid comparisons, and what fits on all."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import Any

from bench.record import Problem, RecordError
from bench.record.schema import machine_name
from bench.results.columns import Row
from bench.results.emulated import Cpi, assumed_cpi, bands, emulated_rows, find_kernels
from bench.results.ranking import best_rows, unmeasured_plugins
from bench.results.rows import Run, read_run
from bench.results.size import Loop, Size, rank_sizes, worst_size
from bench.results.sizing import sizes

SAME = 1e-6
"""Distance of two numbers that are the same but for rounding, relative to them [-]."""


@dataclass(frozen=True)
class NamedRun:
    """A run, and the name that its machine has among others.

    Attributes
    ----------
    name : the machine's, with the folder's where two runs are of machines that have the same name; that of
        the folder alone where processors were emulated
    run : what was measured there
    """

    name: str
    run: Run


def read_machines(directories: Sequence[Path]) -> list[NamedRun]:
    """The runs in these folders.

    Raises RecordError for a folder that is named twice or holds no record, and where two runs have another
    vehicle, or a user's other demands, of one name: they would be shown as one.
    """
    resolved = [directory.resolve() for directory in directories]
    twice = [
        str(given) for given, real in zip(directories, resolved, strict=True) if resolved.count(real) > 1
    ]
    if twice:
        raise RecordError(f"{twice[0]}: is named twice; give each run once")
    runs = [read_run(directory) for directory in directories]
    _check_names(directories, runs)
    names = [
        directory.name if run.record.emulated and not run.rows else machine_name(run.record.header.machine)
        for run, directory in zip(runs, resolved, strict=True)
    ]
    folders = Counter(directory.name for directory in resolved)
    named = []
    for name, run, directory in zip(names, runs, resolved, strict=True):
        folder = directory.name if folders[directory.name] == 1 else str(directory)
        named.append(NamedRun(name if names.count(name) == 1 else f"{name} ({folder})", run))
    return named


def _check_names(directories: Sequence[Path], runs: Sequence[Run]) -> None:
    """Raise RecordError where one name stands for two vehicles, or for two demand sets of a user's."""
    vehicles: dict[str, tuple[Path, Problem]] = {}
    sets: dict[tuple[str, str], tuple[Path, Problem]] = {}
    for directory, run in zip(directories, runs, strict=True):
        for (vehicle, demands), problem in run.problem_by_set.items():
            what = ""
            first, known = sets.setdefault((vehicle, demands), (directory, problem))
            if _are_other_demands(known, problem):
                what = f"{demands} are other demands than in {first}"
            first, known = vehicles.setdefault(vehicle, (directory, problem))
            if _is_other_vehicle(known, problem):
                what = f"{vehicle} is another vehicle than in {first}"
            if what:
                raise RecordError(f"{directory}: {what}; change the name in one, or report each by itself")


def _is_other_vehicle(one: Problem, two: Problem) -> bool:
    """True if two vehicles of one name differ, as far as the records tell."""
    shapes = [(each.dof, each.n, each.rank, each.faults) for each in (one, two)]
    numbers = [[*each.wrench_scale, each.f_scale, *each.numbers] for each in (one, two)]
    known = len(numbers[0]) if one.numbers and two.numbers else len(one.wrench_scale) + 1
    return shapes[0] != shapes[1] or not _are_equal(*(each[:known] for each in numbers))


def _are_other_demands(one: Problem, two: Problem) -> bool:
    """True if two sets of a user's demands have one name and one size, and other values."""
    asked = [(each.n_demands, each.left_out) for each in (one, two)]
    return bool(one.sums and two.sums) and asked[0] == asked[1] and not _are_equal(one.sums, two.sums)


def _are_equal(one: Sequence[float], two: Sequence[float]) -> bool:
    """True if numbers are the same but for rounding, to float too: a board may calculate in it."""
    return len(one) == len(two) and all(
        isclose(x, y, rel_tol=SAME, abs_tol=1e-9) for x, y in zip(one, two, strict=True)
    )


def list_differences(machines: Sequence[NamedRun]) -> list[str]:
    """A sentence for each run after the first: how it differs from the first besides its machine."""
    first, *others = machines
    return [
        f"{first.name} and {other.name}: {'. '.join(find_differences(first.run, other.run)) or 'nothing'}."
        for other in others
    ]


def find_differences(a: Run, b: Run) -> list[str]:
    """Differences of two runs besides their machines, in words; a ratio of their times includes them."""
    one, two = a.record.header, b.record.header
    differences = _list_changes(
        {"seed": one.seed, "commit": one.commit}, {"seed": two.seed, "commit": two.commit}
    )
    ours, theirs = ({Path(path).name: sha for path, sha in each.files.items()} for each in (one, two))
    differences += [
        f"the text of {name}" for name in sorted(ours) if theirs.get(name, ours[name]) != ours[name]
    ]
    if a.by_driver != b.by_driver:  # a driver has none of Python's versions
        callers = ("a board's driver" if run.by_driver else "Python" for run in (a, b))
        return [*differences, f"calls from {' and from '.join(callers)}"]
    differences += _list_changes(one.versions, two.versions, "none")
    return differences + _list_changes(
        {**a.form, "compiler's flags": a.machine.get("flags")},
        {**b.form, "compiler's flags": b.machine.get("flags")},
    )


def _list_changes(one: Mapping[str, Any], two: Mapping[str, Any], lacking: str = "unknown") -> list[str]:
    """Entries of the same name and different value, with both values."""
    keys = sorted(one.keys() | two.keys())
    both = (
        (key, *(lacking if has.get(key) in ("", None) else has[key] for has in (one, two))) for key in keys
    )
    return [f"{key} {ours} and {theirs}" for key, ours, theirs in both if ours != theirs]


def comparison_obstacle(a: Run, b: Run, vehicle: str, demands: str) -> str:
    """Reason why two runs can't be compared on a vehicle's demand set; empty if they can."""
    ours, theirs = (run.problem_by_set.get((vehicle, demands)) for run in (a, b))
    if ours is None or theirs is None:
        return "not asked on both"
    if ours.rate_hz is None and a.record.header.seed != b.record.header.seed:
        return "demands of another seed"
    if ours.n_demands != theirs.n_demands:
        return f"{ours.n_demands} demands and {theirs.n_demands}"
    if a.by_driver != b.by_driver:  # a call from Python takes ten times what the C in it takes
        return "one machine's calls were made from Python, the other's by a board's driver in C"
    return f"other C: {'; '.join(other)}" if (other := _list_changes(a.form, b.form)) else ""


def medians(machines: Sequence[NamedRun], vehicle: str, demands: str) -> dict[str, list[Row | None]]:
    """One row a machine by method, start and level: those that represent a method on any of the machines.

    Only the user's own methods may have a row without a time.
    """
    shown = [row.label for m in machines for row in best_rows(m.run, vehicle, demands)]
    shown += [row.label for m in machines for row in unmeasured_plugins(m.run, vehicle, demands)]
    measured = [
        {row.label: row for row in m.run.select(vehicle, demands) if not row.failed or row.described.plugin}
        for m in machines
    ]
    return {label: [by_label.get(label) for by_label in measured] for label in dict.fromkeys(shown)}


def order_changes(by_label: Mapping[str, Sequence[Row | None]], i: int, j: int) -> list[tuple[str, str]]:
    """Pairs of methods of which the first is faster on machine ``i``, and the second on machine ``j``.

    A method is faster if its slowest repeat beats the other's fastest one; smaller differences are noise.
    """
    here, there = (
        {
            label: (row.call_p50_low_us, row.call_p50_high_us)
            for label, rows in by_label.items()
            if (row := rows[k])
        }
        for k in (i, j)
    )
    both = [label for label in by_label if label in here and label in there]
    return [
        (first, second)
        for first in both
        for second in both
        if _is_faster(here[first], here[second]) and _is_faster(there[second], there[first])
    ]


def machine_sizes(
    machines: Sequence[NamedRun], loop: Loop, clock_hz: float | None = None, given: Cpi | None = None
) -> dict[str, list[Size]]:
    """The sizes on each machine that was timed and, where a clock is given, each processor that was emulated.

    ``given`` replaces the cycles an instruction that the records assume.
    """
    sized = {m.name: sizes(m.run, loop) for m in machines if m.run.by_vehicle}
    for machine in machines if clock_hz else ():
        record = machine.run.record
        kernels = find_kernels(emulated_rows(record.emulated))
        for band in bands(kernels, clock_hz or 0.0, loop, assumed_cpi(record.processors), given):
            sized.setdefault(emulated_name(band.kernel.target), []).append(band.size)
    return sized


def emulated_name(target: str) -> str:
    """The name of an emulated processor among machines."""
    return f"{target} (emulated)"


def sizes_on_all(sized: Mapping[str, Sequence[Size]], loop: Loop) -> list[Size]:
    """Methods on every machine that has the vehicle: for each the worst of its sizes, best first.

    ``sized`` holds the sizes by machine. A method that some machine has not measured is left out.
    """
    return rank_sizes([worst_size(there) for there in _complete_sizes(sized)], loop.period_us)


def _complete_sizes(sized: Mapping[str, Sequence[Size]]) -> list[dict[str, Size]]:
    """Sizes by machine of each method that every machine with the vehicle has measured."""
    by_name: dict[tuple[str, str], dict[str, Size]] = {}
    for machine, own in sized.items():
        for size in own:
            by_name.setdefault((size.vehicle, size.label), {})[machine] = size
    asked = {
        vehicle: {machine for machine, own in sized.items() if any(s.vehicle == vehicle for s in own)}
        for vehicle in {vehicle for vehicle, _ in by_name}
    }
    return [there for (vehicle, _), there in by_name.items() if there.keys() == asked[vehicle]]


def count_partial_methods(sized: Mapping[str, Sequence[Size]]) -> dict[str, int]:
    """Number of methods by vehicle that ``sizes_on_all`` leaves out: some machine did not measure them."""
    known = {(size.vehicle, size.method) for own in sized.values() for size in own}
    whole = {(size.vehicle, size.method) for there in _complete_sizes(sized) for size in there.values()}
    return Counter(vehicle for vehicle, _ in known - whole)


def _is_faster(one: tuple[float | None, float | None], other: tuple[float | None, float | None]) -> bool:
    slowest, fastest = one[1], other[0]
    return slowest is not None and fastest is not None and slowest < fastest
