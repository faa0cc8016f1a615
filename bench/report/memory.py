"""Report section: what a method needs of memory and of time before its first call."""

from statistics import median

from bench.record import Worker
from bench.report.text import table, three
from bench.rows import Run


def section(run: Run, drawn: frozenset[str]) -> str:
    """Peak memory of each method's process, over an empty one, and what its import takes."""
    by_label: dict[str, list[Worker]] = {}
    for row in run.rows:
        if not row.failed:
            by_label.setdefault(row.label, list(row.workers))
    allocators = {row.label: size for row in run.rows if (size := _bytes(run, row.label)) is not None}
    empty = _peak_MB(by_label.get("noop", []))
    lines = []
    for label, workers in sorted(by_label.items(), key=lambda item: _peak_MB(item[1]) or 0.0):
        peak = _peak_MB(workers)
        imports = [w.import_ns for w in workers if w.import_ns is not None]
        lines.append(
            [
                label,
                three(peak),
                three(peak - empty) if peak is not None and empty is not None else "",
                three(allocators[label] / 1000) if label in allocators else "",
                three(median(imports) / 1e6) if imports else "",
            ]
        )
    headers = ("method", "peak [MB]", "over an empty worker [MB]", "allocator [kB]", "import [ms]")
    text = (
        "Peak resident memory of a process that runs this method and nothing else, numpy included; an empty"
        " worker is `noop`'s. *Import* is what the first build takes longer than later ones.\n"
    )
    return f"## Memory\n\n{text}\n{table(headers, lines)}" if any(w for w in by_label.values()) else ""


def _peak_MB(workers: list[Worker]) -> float | None:
    return max((w.peak_rss_bytes / 1e6 for w in workers if w.peak_rss_bytes is not None), default=None)


def _bytes(run: Run, label: str) -> int | None:
    sizes = [cell.allocator_bytes for row in run.rows if row.label == label for cell in row.cells]
    return max((size for size in sizes if size is not None), default=None)
