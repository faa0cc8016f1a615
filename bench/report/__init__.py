"""The files that are rendered from records: results.csv, report.md, details.md, report.html and pictures."""

from collections.abc import Sequence
from pathlib import Path

from bench.report import together
from bench.report.html import html
from bench.report.page import details, page
from bench.report.pictures import draw_all
from bench.results.emulated import emulated_rows
from bench.results.machines import NamedRun, read_machines
from bench.results.text import write_csv


def render(*directories: Path, out: Path | None = None) -> Path:
    """Write the report of one run into its folder, or of one or several into ``out``, from records alone.

    Of several runs there is one results.csv and emulation.csv with the rows of all, and one report.html;
    report.md and details.md put the machines side by side. Instructions of emulated processors never stand
    beside times. The same records give the same bytes. Returns the path of report.md; raises RecordError
    where a folder holds no readable record.
    """
    machines = read_machines(directories)
    directory = out or directories[0]
    directory.mkdir(parents=True, exist_ok=True)
    _tables(machines, directory)
    if len(machines) == 1:
        run = machines[0].run
        drawn = draw_all(run, directory)
        text, more = page(run, drawn), details(run, drawn)
    else:
        text, more = together.page(machines), together.details(machines)
    report = directory / "report.md"
    report.write_text(text, encoding="utf-8")
    (directory / "details.md").write_text(more, encoding="utf-8")
    (directory / "report.html").write_text(html(machines, text, more), encoding="utf-8")
    return report


def _tables(machines: Sequence[NamedRun], directory: Path) -> None:
    import pandas as pd

    emulated = [row.cells for machine in machines for row in emulated_rows(machine.run.record.emulated)]
    timed = [machine.run for machine in machines if machine.run.rows]
    if timed or not emulated:
        tables = [run.table for run in timed or [machine.run for machine in machines]]
        write_csv(directory / "results.csv", pd.concat(tables) if len(tables) > 1 else tables[0])
    if emulated:  # a mean count without decimals is written as an integer
        write_csv(directory / "emulation.csv", pd.DataFrame(emulated, dtype=object), pointed=False)
