"""The result table of README.md, between two marks."""

from pathlib import Path

from alloc import AllocError
from alloc.allocation import WRENCH_TOLERANCE
from alloc.formulations import EXACT_METHODS
from bench.record import Capability, RecordError
from bench.results.columns import Row
from bench.results.ranking import best_rows, is_exact, largest_loss, representatives, shortlist
from bench.results.rows import Run
from bench.results.text import percent, table, three

START, END = "<!-- results:start -->", "<!-- results:end -->"
VEHICLES = ("ukwial", "bluerov2-heavy")
"""The paper's vehicle, and the commonest one with eight thrusters. A run without them shows its first two."""
MOST = 10
"""Most lines of the table."""


def result_table(run: Run) -> str:
    """A line for each method worth considering: its median on each vehicle; tail and loss on the last one.

    Raises RecordError for a run without times, such as one of emulated processors.
    """
    shown = [name for name in VEHICLES if name in run.vehicles] or run.vehicles[:2]
    if not shown:
        raise RecordError("this run holds no times of any vehicle, so no result table; give one that does")
    by_vehicle = {name: best_rows(run, name, run.sets(name)[0]) for name in shown}
    medians = {name: {row.method: row for row in rows} for name, rows in by_vehicle.items()}
    rows = shortlist(by_vehicle[shown[-1]])[:MOST]
    ways = {row.label: way for way, row in representatives(by_vehicle[shown[-1]]).items()}
    lines = [
        [
            f"`{row.label}`",
            ways.get(row.label, row.family),
            *(_median(medians[name].get(row.method)) for name in shown),
            three(run.tail_us(row, 0.999)),
            loss_text(row),
            served_text(run, shown[-1], row),
        ]
        for row in rows
    ]
    headers = (
        "method",
        "what it is",
        *(f"{name} [µs]" for name in shown),
        "one call in 1000 [µs]",
        "worst demand, missing",
        "demands served",
    )
    return _caption(run, shown) + "\n" + table(headers, lines)


def loss_text(row: Row | None) -> str:
    """The largest share of a demand's wrench that a row loses; 0 where each is met."""
    worst = None if row is None else largest_loss(row)
    return "0" if worst is not None and worst < WRENCH_TOLERANCE else percent(worst)


def served_text(run: Run, vehicle: str, row: Row) -> str:
    """``served_share`` in per cent; empty where it is not known."""
    return percent(served_share(run, vehicle, row))


def served_share(run: Run, vehicle: str, row: Row) -> float | None:
    """The share of the vehicle's attainable set that a method delivers within 1 % [-]; None if not known.

    The share depends on the answers alone: a native build serves what its twin does, and any exact solver of
    the catalogue what ``nullspace`` does; a plug-in was exact on the demands asked, and is counted itself.
    What was not counted is what the row served of ``uniform``, a demand set that is even over the attainable
    set.
    """
    capability = run.capability(vehicle)
    served = [s for s in capability.served if s.fault is None] if capability else []
    shares = {s.method: s.within_1pct / s.n_demands for s in served}
    as_exact = EXACT_METHODS[:1] * (is_exact(row) and not row.described.plugin)
    names = [*as_exact, row.described.twin, row.method]
    on_uniform = [other for other in run.of(vehicle, "uniform") if other.label == row.label]
    known = [*(shares[name] for name in names if name in shares), *(r.within_1pct_share for r in on_uniform)]
    return next(iter(known), None)


class MarkerError(AllocError):
    """A file has no marks for the table."""


def put(path: Path, text: str, start: str = START, end: str = END) -> None:
    """Replace what stands between the two marks of a file; raises MarkerError."""
    try:
        whole = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        raise MarkerError(f"{path}: can't be read as text; give the README to update") from None
    before, opening, rest = whole.partition(start)
    _, closing, after = rest.partition(end)
    if not opening or not closing:
        raise MarkerError(f"{path}: has no '{start}' and '{end}'; write them where the table shall stand")
    path.write_text(f"{before}{start}\n{text}{end}{after}", encoding="utf-8")


def _caption(run: Run, shown: list[str]) -> str:
    cpu = run.record.header.machine.get("cpu", "this machine")
    python = run.record.header.versions.get("python", "Python")
    return (
        f"Median time of one call from Python on {cpu} with {python}, asked"
        " for what takes the thrusters to their limits. The last three columns are"
        f" {shown[-1]}'s: what one call in a thousand exceeds, how much of the worst of these demands is not"
        " delivered, and which share of all that the vehicle can do is delivered within 1 %.\n"
    )


def _median(row: Row | None) -> str:
    return three(row.call_p50_us) if row else ""


def uncounted_methods(capability: Capability) -> list[str]:
    """A line for each method whose share of the vehicle could not be had, with the reason."""
    where = f"on {capability.vehicle}, what it serves is not counted"
    return [f"{u.method} {where}: {u.status} {u.reason.rstrip('.')}" for u in capability.unserved]
