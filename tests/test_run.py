"""A run, end to end, with real worker processes."""

from pathlib import Path

from click.testing import CliRunner

from bench.__main__ import cli
from bench.record import read

DEMANDS = ["--demands=inactive", "--demands=active", "--demands=infeasible"]
TINY = ["run", "--vehicle=ukwial", "--method=pinv", *DEMANDS, "--n=8", "--budget-ms=1", "--repeats=2"]


def test_a_run_measures_and_judges_every_cell_once_and_writes_a_report(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, [*TINY, "--out", str(tmp_path)], standalone_mode=False)
    assert result.return_value == 0, result.output
    assert (tmp_path / "results.csv").is_file()
    cells = [cell for cell in read(tmp_path).cells if cell.key.method == "pinv"]
    keys = [(cell.key.demands, cell.key.repeat) for cell in cells]
    assert sorted(keys) == [(d, r) for d in ("active", "inactive", "infeasible") for r in (0, 1)]
    for cell in cells:
        assert cell.status == "ok"
        assert cell.judged is not None
        assert cell.judged.agrees is True
        assert cell.judged.wrong == ""
        assert all(batch.calls % cell.n_demands == 0 for batch in cell.batches)
