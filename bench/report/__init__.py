"""From a run's record to what people read: results.csv, report.md and report.html with pictures."""

from pathlib import Path

from bench.report.page import page
from bench.results import write_csv
from bench.rows import read_run


def render(directory: Path) -> Path:
    """Write results.csv and report.md from ``record.jsonl`` alone; the same record gives the same bytes.

    Returns the path of report.md. Raises RecordError where the folder holds no readable record.
    """
    run = read_run(directory)
    write_csv(run.rows, directory / "results.csv")
    report = directory / "report.md"
    report.write_text(page(run), encoding="utf-8")
    return report
