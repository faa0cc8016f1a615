"""Report section: which machine, which versions, and how quiet it was."""

from collections import Counter

from bench.record import NO_VEHICLE
from bench.results.rows import Run
from bench.results.text import percent, plain, table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """The machine as it described itself, what disturbed it, and the versions of what ran."""
    header = run.record.header
    facts = [[key.replace("_", " "), str(value)] for key, value in header.machine.items() if value != ""]
    facts += [[f"the C's {key}", value] for key, value in run.form.items()]
    facts += [["started", header.started], ["commit", header.commit or "unknown"], ["seed", str(header.seed)]]
    versions = ", ".join(plain(f"{name} {version}") for name, version in sorted(header.versions.items()))
    return "\n".join(
        [
            "## The machine, and how quiet it was\n",
            table(("what", "value"), facts),
            *([] if run.by_driver else [_quiet(run)]),
            versions + ".\n",
        ]
    )


def _quiet(run: Run) -> str:
    measured = [row for row in run.rows if not row.failed and row.vehicle != NO_VEHICLE]
    disturbed = Counter(what for row in measured for what in row.measured.disturbances)
    busy = sum(bool(row.measured.disturbances) for row in measured)
    steal = sum((c.quiet.steal_ticks or 0) for row in measured for c in row.measured.cells if c.quiet) / 100
    text = f"Disturbed rows: {busy} of {len(measured)} ({percent(busy / len(measured) if measured else 0.0)})"
    if disturbed:
        text += ", by " + ", ".join(f"{what} ({count})" for what, count in sorted(disturbed.items()))
    text += f". Time stolen by the hypervisor: {three(steal)} s."
    done = [event for event in run.record.events if event.timed_s]
    if done:
        wall, timed = sum(e.wall_s for e in done), sum(e.timed_s for e in done)
        text += f" The run took {three(wall)} s, {three(wall / timed)} times the calls it timed."
    return text + "\n"
