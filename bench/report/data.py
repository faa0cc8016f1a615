"""What report.html works with: for each machine, vehicle and method the numbers that verdicts are made of.

Single calls are multisets of times. Times repeat from method to method, so each is stored once, in ``times``,
and a multiset is [place in ``times``, how often, distance to the next place, how often, …].
"""

from collections.abc import Iterable, Sequence
from typing import Any

from alloc.formulations import find_formulation
from alloc.vehicle.frame import described
from bench.record import NO_VEHICLE, Capability, Problem
from bench.report.readme import served
from bench.report.verdict import USUAL, rate_of, sure
from bench.results.bands import Counted, counted
from bench.results.columns import Row
from bench.results.cycles import assumed
from bench.results.emulated import rows as emulated_rows
from bench.results.fit import LATE_SHARE, Fit
from bench.results.machines import NamedRun, emulated_name
from bench.results.pauses import CHANCE, pauses
from bench.results.quantiles import BEYOND, CONFIDENCE, Histogram, interval, merged
from bench.results.ranking import exact, largest_loss
from bench.results.repeats import most
from bench.results.rows import SETS
from bench.results.sizing import CLOSE, refusal, wrong

ATTAINED = 1 - 1e-9
"""Share of attainable demands from which on a set's losses count as a method's: rounding of a ratio."""


def data(machines: Sequence[NamedRun]) -> dict[str, Any]:
    """Everything that the page shows, as it is written into the page."""
    times = sorted({ns for m in machines for row in m.run.rows for ns, _ in row.measured.singles} | {0})
    place = {ns: i for i, ns in enumerate(times)}
    found = [machine for m in machines for machine in _machine(m, place)]
    sets = {row["name"] for machine in found for method in machine["methods"] for row in method["sets"]}
    formulations = {method["formulation"] for machine in found for method in machine["methods"]}
    return {
        "constants": {
            "late_share": LATE_SHARE,
            "close": CLOSE,
            "chance": CHANCE,
            "confidence": CONFIDENCE,
            "beyond": BEYOND,
        },
        "fits": [str(fit) for fit in Fit],
        "rate_hz": max(filter(None, (rate_of(m.run) for m in machines)), default=USUAL.rate_hz),
        "times": times,
        "sets": sorted(sets, key=lambda name: (SETS.index(name) if name in SETS else len(SETS), name)),
        "formulations": {name: find_formulation(name).title for name in sorted(formulations)},
        "machines": found,
        # An unknown frame, as of a record of counts alone, has no entry.
        "frames": {p.vehicle: described(p.frame) for m in machines for p in m.run.record.problems},
    }


def _machine(machine: NamedRun, place: dict[int, int]) -> list[dict[str, Any]]:
    """The machine that was timed, and each processor that was emulated."""
    run, found = machine.run, []
    if run.by_vehicle:
        seen = pauses(run)
        groups: dict[tuple[str, str], list[Row]] = {}
        for row in run.rows:
            if not row.described.yardstick and row.vehicle != NO_VEHICLE:
                groups.setdefault((row.vehicle, row.label), []).append(row)
        versions = run.record.header.versions
        found.append(
            {
                "name": machine.name,
                "sure": f"was {sure(run)}",
                "excess": [list(pair) for pair in seen.excess],
                "exposure_ns": seen.exposure_ns,
                "methods": [_method(machine, rows, place, versions) for rows in groups.values()],
                "curves": {
                    vehicle: _curves(capability)
                    for vehicle in run.vehicles
                    if (capability := run.capability(vehicle)) is not None
                },
            }
        )
    kernels = counted(emulated_rows(run.record.emulated))
    known = assumed(run.record.processors)
    for target in dict.fromkeys(kernel.target for kernel in kernels if kernel.target in known):
        cpi = known[target]
        found.append(
            {
                "name": emulated_name(target),
                "sure": f"is counted exactly; {cpi.low:g} to {cpi.high:g} cycles an instruction are assumed"
                " where no timing is published.",
                "cpi": [cpi.low, cpi.high],
                "methods": [_kernel(kernel) for kernel in kernels if kernel.target == target],
            }
        )
    return found


def _method(
    machine: NamedRun, rows: Sequence[Row], place: dict[int, int], versions: dict[str, str]
) -> dict[str, Any]:
    first = rows[0]
    solver = first.described.solver
    asked = {(p.vehicle, p.demands): p for p in machine.run.record.problems}
    return {
        "vehicle": first.vehicle,
        "label": first.label,
        "method": first.method,
        "twin": first.described.twin,
        "family": first.family,
        "solver": f"{solver} {versions.get(solver, '')}".strip(),
        "formulation": first.formulation,
        "steps": first.worst_case_steps,
        "freedom": asked[first.vehicle, first.demands].nullity
        if (first.vehicle, first.demands) in asked
        else None,
        "iterations": most(row.iterations_max for row in rows),
        "memory_MB": _worst([row.peak_rss_MB for row in rows]),
        "allocator_kB": _shown(most(row.allocator_bytes for row in rows), 1e-3),
        "setup_us": _shown(most(row.setup_us for row in rows)),
        "distance": _shown(most(row.distance_relative for row in rows)),
        "promise": _shown(most(row.tolerance for row in rows)),
        "served": served(machine.run, first.vehicle, first) if first.call_p50_us is not None else "",
        "p999": _interval(merged(row.measured.singles for row in rows)),
        "sets": [_set(row, place, asked.get((row.vehicle, row.demands))) for row in rows],
    }


def _set(row: Row, place: dict[int, int], problem: Problem | None) -> dict[str, Any]:
    refused, words = refusal(row, problem)
    return {
        "name": row.demands,
        "failed": f"{row.demands}: {row.failed.status}, {row.failed.reason}" if row.failed else "",
        "wrong": wrong(row),
        "exact": exact(row),
        "refused": _shown(refused),
        "refusal": words,
        "asked": bool(row.measured.attainable) or row.agreed is not None,
        "attainable": row.measured.attainable >= ATTAINED,
        "p50_us": row.call_p50_us,
        "cpu_us": row.call_cpu_p50_us,
        "p50": [_shown(row.call_p50_low_us), _shown(row.call_p50_high_us)],
        "p999": _interval(row.measured.singles),
        "lost": _shown(largest_loss(row)),
        "singles": _packed(row.measured.singles, place),
    }


def _kernel(kernel: Counted) -> dict[str, Any]:
    return {
        "vehicle": kernel.vehicle,
        "label": kernel.label,
        "method": kernel.method,
        "twin": kernel.twin,
        "family": kernel.family,
        "solver": kernel.solver,
        "formulation": kernel.formulation,
        "exact": kernel.optimal,
        "instructions": kernel.instructions,
        "cpi": None if kernel.cycles is None else [cycles / kernel.instructions for cycles in kernel.cycles],
        "wrong": "" if kernel.agrees else "not all answers are right",
        "missed": ", ".join(kernel.missed),
        "steps": None,
        "memory_MB": None,
        "served": "",
        "sets": [],
    }


def _curves(capability: Capability) -> list[dict[str, Any]]:
    return [
        {
            "method": curve.method,
            "size": _rounded(curve.size),
            "p50": _rounded(curve.error_p50),
            "max": _rounded(curve.error_max),
        }
        for curve in capability.curves
    ]


def _packed(singles: Histogram, place: dict[int, int]) -> list[int]:
    packed, before = [], 0
    for ns, count in singles:
        packed += [place[ns] - before, count]
        before = place[ns]
    return packed


def _interval(singles: Histogram) -> list[float | None]:
    ends = interval(singles, 0.999)
    return [None, None] if ends is None else [end / 1000 for end in ends]


def _worst(values: Iterable[float | None]) -> float | None:
    known = list(values)
    return None if None in known else most(known)


def _shown(value: float | None, factor: float = 1.0) -> float | None:
    """Four digits: one more than is shown."""
    return None if value is None else float(f"{value * factor:.4g}")


def _rounded(values: Iterable[float]) -> list[float]:
    return [round(value, 4) for value in values]
