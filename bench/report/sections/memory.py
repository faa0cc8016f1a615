"""Report section: a method's memory, and the time of its import."""

from statistics import median

from bench.record import NO_VEHICLE, Worker
from bench.results.repeats import most
from bench.results.rows import Run
from bench.results.text import table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """A table: peak memory of each method's process, also over an empty one's, and the time of its import."""
    methods = sorted({row.method for row in run.rows if not row.failed and row.vehicle != NO_VEHICLE})
    workers = {name: [w for w in run.record.workers if w.method == name] for name in methods}
    empty = _peak_MB(workers.get("noop", []))
    lines = []
    for name in sorted(methods, key=lambda name: _peak_MB(workers[name]) or 0.0):
        peak = _peak_MB(workers[name])
        over = None if peak is None or empty is None else peak - empty
        imports = [w.import_ns for w in workers[name] if w.import_ns is not None and name != "noop"]
        # Without anything to import, a first build may be quicker than later ones: that counts as zero.
        import_ms = max(median(imports), 0.0) / 1e6 if imports else None
        held = most(row.allocator_bytes for row in run.rows if row.method == name)
        lines.append([name, three(peak), three(over), three(held and held / 1000), three(import_ms)])
    headers = ("method", "peak [MB]", "over an empty worker [MB]", "allocator [kB]", "import [ms]")
    text = (
        "Peak resident memory of a process that runs this method and nothing else, numpy included, the"
        " largest over its starts and levels; an empty worker is `noop`'s. *Allocator* is the largest over"
        " vehicles, as Python sees it: what a solver holds outside Python is only in the peak. *Import* is"
        " what a process's first build takes longer than later ones.\n"
    )
    known = any(number for _, *numbers in lines for number in numbers)
    return f"## Memory\n\n{text}\n{table(headers, lines)}" if known else ""


def _peak_MB(workers: list[Worker]) -> float | None:
    peak = most(worker.peak_rss_bytes for worker in workers)
    return None if peak is None else peak / 1e6
