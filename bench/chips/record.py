"""Writes counted rows into a record: a new one, or that of a run."""

from collections.abc import Iterator
from pathlib import Path

from bench.chips.study import Plan, emulate
from bench.harness.lines import begun
from bench.record import Emulated, Header
from bench.record.file import Writer


def write(plan: Plan, directory: Path, *, add: bool) -> Iterator[Emulated]:
    """Count as planned and append each row to ``directory``'s record as it comes; raises RecordError.

    With ``add`` a record that is there is continued. A reader takes the later of two rows with the same
    names.
    """
    rows = emulate(plan)  # raises for a plan that is wrong, before a record is touched
    with Writer(directory) as writer:
        before = writer.resume() if add else None
        if before is None:
            writer.create(_header(plan))
        known = before.processors if before else []
        writer.extend(facts for target in plan.targets if (facts := target.facts) not in known)
        for row in rows:
            writer.append(row)
            yield row


def _header(plan: Plan) -> Header:
    settings = {
        "vehicles": [vehicle.name for vehicle in plan.vehicles],
        "targets": [target.name for target in plan.targets],
        "methods": list(plan.methods),
        "scalars": list(plan.scalars),
        "limits": list(plan.limits),
        "faults": plan.faults,
        "demands": list(plan.demands),
        "n_demands": plan.n,
    }
    return begun(plan.seed, settings)
