"""The files that are rendered from a run's record: results.csv, report.md, report.html and pictures."""

from pathlib import Path

from bench.report.html import html
from bench.report.page import page
from bench.report.pictures import draw_all
from bench.results.emulated import COLUMNS, rows
from bench.results.rows import read_run
from bench.results.table import columns, write_csv


def render(directory: Path) -> Path:
    """Write results.csv, report.md, report.html and the pictures from ``record.jsonl`` alone.

    Instructions of emulated processors go to emulation.csv, never beside times. The same record gives the
    same bytes. Returns the path of report.md; raises RecordError where the
    folder holds no readable record.
    """
    run = read_run(directory)
    if run.rows or not run.record.emulated:
        write_csv(directory / "results.csv", columns(), run.rows)
    if run.record.emulated:  # a mean count without decimals is written as an integer
        write_csv(directory / "emulation.csv", COLUMNS, rows(run.record.emulated), pointed=False)
    drawn = draw_all(run, directory)
    report = directory / "report.md"
    text = page(run, drawn)
    report.write_text(text, encoding="utf-8")
    (directory / "report.html").write_text(html(text, directory), encoding="utf-8")
    return report
