"""report.md and details.md of several machines: what fits on all, and ratios where they mean anything."""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence

from bench.record.schema import machine_name
from bench.report.page import MORE
from bench.report.sections.headline import omission_note
from bench.report.verdict import first_methods, opening_loop, rate_note, trust_note, verdicts
from bench.results.columns import Row
from bench.results.emulated import IN_WORDS, emulated_rows, table_scalar
from bench.results.machines import (
    NamedRun,
    comparison_obstacle,
    count_partial_methods,
    list_differences,
    medians,
    order_changes,
    sizes_on_all,
)
from bench.results.quantiles import group, largest
from bench.results.ranking import best_rows, shortlist, unmeasured_plugins
from bench.results.rows import FORM, Run, sort_sets
from bench.results.size import Size, best_of_each
from bench.results.sizing import sizes
from bench.results.text import plain, plural, table, three

MOST = 10
"""Most pairs of methods in a sentence."""
TITLE = "# What thrust allocation costs on several machines\n"


def page(machines: Sequence[NamedRun]) -> str:
    """report.md: what fits on every machine, then the methods worth considering, machine by machine.

    A set or a method has a row if the report of any one run would give it one.
    """
    timed = [machine for machine in machines if machine.run.vehicles]
    loop = opening_loop(*(machine.run for machine in timed))
    sized = {machine.name: sizes(machine.run, loop) for machine in timed}
    whole = [s for s in best_of_each(sizes_on_all(sized, loop)) if s.vehicle in _vehicles(timed)]
    first = first_methods(whole)
    parts = [TITLE, *_opening(timed, whole, count_partial_methods(sized)), _differences(timed)]
    for vehicle, demands in _vehicle_sets(timed, Run.leading_sets):
        parts += _medians(
            timed, vehicle, demands, _shortlist_labels(timed, vehicle, demands, first.get(vehicle, ""))
        )
    return "\n".join(part for part in [*parts, _instructions(machines), MORE] if part)


def details(machines: Sequence[NamedRun]) -> str:
    """details.md: every method on every set of every vehicle, and the facts of each machine."""
    timed = [machine for machine in machines if machine.run.vehicles]
    parts = ["# The details: every method on every machine\n", _facts(machines)]
    parts += [part for asked in _vehicle_sets(timed, Run.sets) for part in _medians(timed, *asked)]
    return "\n".join(part for part in parts if part)


def _opening(timed: Sequence[NamedRun], whole: Sequence[Size], in_part: Mapping[str, int]) -> list[str]:
    if not timed:
        return []
    runs = [machine.run for machine in timed]
    where = " on every machine that has it" if len(timed) > 1 else ""
    lines = verdicts(whole, opening_loop(*runs), where)
    lines += [
        f"{vehicle}: {plural(in_part[vehicle], 'method')} without a verdict, not measured on every machine."
        for vehicle in _vehicles(timed)
        if in_part.get(vehicle)
    ]
    sentences = "\n".join(f"- {plain(sentence)}" for sentence in [*lines, *rate_note(*runs)]) + "\n"
    trust = "\n".join(f"- {plain(machine.name)} was {plain(trust_note(machine.run))}" for machine in timed)
    return [sentences, f"How sure:\n\n{trust}\n"]


def _differences(timed: Sequence[NamedRun]) -> str:
    if len(timed) < 2:
        return ""
    lines = "\n".join(f"- {plain(line)}" for line in list_differences(timed))
    return f"Other differences between the runs, which each ratio includes:\n\n{lines}\n"


def _vehicles(timed: Sequence[NamedRun]) -> list[str]:
    return sorted({vehicle for machine in timed for vehicle in machine.run.vehicles})


def _vehicle_sets(
    timed: Sequence[NamedRun], sets: Callable[[Run, str], list[str]]
) -> Iterator[tuple[str, str]]:
    """Pairs of a vehicle and a demand set that ``sets`` gives on any machine, in the order of tables."""
    for vehicle in _vehicles(timed):
        runs = [machine.run for machine in timed if vehicle in machine.run.vehicles]
        for demands in sort_sets({name for run in runs for name in sets(run, vehicle)}):
            yield vehicle, demands


def _shortlist_labels(timed: Sequence[NamedRun], vehicle: str, demands: str, first_method: str) -> set[str]:
    """Labels of the methods that a report of one run would show, and of ``first_method``."""
    rows: list[Row] = []
    for machine in timed:
        rows += shortlist(best_rows(machine.run, vehicle, demands), first_method)
        rows += unmeasured_plugins(machine.run, vehicle, demands)
    return {row.label for row in rows}


def _medians(
    timed: Sequence[NamedRun], vehicle: str, demands: str, shown: Container[str] | None = None
) -> list[str]:
    """Table of medians on each machine, with ratios to the first machine, and pairs in another order.

    All methods, or only those whose labels are in ``shown``.
    """
    with_vehicle = [machine for machine in timed if vehicle in machine.run.vehicles]
    measured = [machine for machine in with_vehicle if machine.run.select(vehicle, demands)]
    by_label = medians(measured, vehicle, demands)
    why = {m.name: comparison_obstacle(measured[0].run, m.run, vehicle, demands) for m in measured[1:]}
    ordered = sorted(by_label.items(), key=lambda item: min(_times(item[1]), default=float("inf")))
    shown_rows = {label: rows for label, rows in ordered if shown is None or label in shown}
    lines = []
    for label, rows in shown_rows.items():
        base = rows[0].call_p50_us if rows[0] else None
        line = [label, _time_text(rows[0])]
        for machine, row in zip(measured[1:], rows[1:], strict=True):
            time = row.call_p50_us if row else None
            ratio = time / base if time and base and not why[machine.name] else None
            line += [_time_text(row), three(ratio)]
        lines.append(line)
    headers = ["method", f"{measured[0].name} [µs]"]
    for machine in measured[1:]:
        headers += [f"{machine.name} [µs]", f"over {measured[0].name}"]
    parts = [f"## {plain(vehicle)}, medians on {plain(demands)} demands\n", table(headers, lines)]
    parts += omission_note(len(by_label) - len(shown_rows))
    absent = [plain(machine.name) for machine in with_vehicle if machine not in measured]
    parts += [f"Not asked on {', '.join(absent)}.\n"] if absent else []
    parts += [f"{plain(f'No ratio for {name}: {reason}.')}\n" for name, reason in why.items() if reason]
    for i, machine in enumerate(measured[1:], start=1):
        if pairs := [] if why[machine.name] else order_changes(shown_rows, 0, i):
            sentences = ". ".join(f"{a} before {b}" for a, b in pairs[:MOST])
            more = f". And {len(pairs) - MOST} pairs more" if len(pairs) > MOST else ""
            order = f"In another order on {measured[0].name} than on {machine.name}: {sentences}{more}."
            parts.append(f"{plain(order)}\n")
    return parts


def _instructions(machines: Sequence[NamedRun]) -> str:
    """Instructions of the most costly call, by emulated processor: no times, so in a table of their own."""
    every = [row for machine in machines for row in emulated_rows(machine.run.record.emulated)]
    scalar = table_scalar(every)
    counted = [row for row in every if row.worst is not None and row.emulated.scalar == scalar]
    if not counted:
        return ""
    targets = list(dict.fromkeys(row.emulated.target for row in counted))
    lines = []
    by_method = group(counted, lambda row: (row.emulated.vehicle, row.emulated.method))
    for names, own in sorted(by_method.items()):
        by_target = group(own, lambda row: row.emulated.target)
        worst = (largest(row.worst for row in by_target.get(target, [])) for target in targets)
        lines.append([*names, *("" if most is None else str(most) for most in worst)])
    title = f"## Instructions of the most costly call on emulated processors, {IN_WORDS[scalar]}\n\n"
    return title + table(("vehicle", "method", *targets), lines)


def _facts(machines: Sequence[NamedRun]) -> str:
    headers = [machine.run.record.header for machine in machines]
    rows = [
        ["machine", *(machine_name(header.machine) for header in headers)],
        ["started", *(header.started for header in headers)],
        ["commit", *(header.commit or "unknown" for header in headers)],
        ["seed", *(str(header.seed) for header in headers)],
    ]
    rows += [
        [f"the C's {key}", *(machine.run.form.get(key, "") for machine in machines)]
        for key in FORM
        if any(machine.run.form for machine in machines)
    ]
    facts = dict.fromkeys(key for header in headers for key in header.machine if key != "name")
    rows += [[key.replace("_", " "), *(str(h.machine.get(key, "")) for h in headers)] for key in facts]
    packages = sorted({name for header in headers for name in header.versions})
    rows += [[name, *(h.versions.get(name, "") for h in headers)] for name in packages]
    return table(("what", *(machine.name for machine in machines)), rows)


def _times(rows: Sequence[Row | None]) -> list[float]:
    return [time for row in rows if row is not None and (time := row.call_p50_us) is not None]


def _time_text(row: Row | None) -> str:
    """The median, or why there is none."""
    if row is None:
        return ""
    return f"{row.status}: {row.reason}" if row.failed else three(row.call_p50_us)
