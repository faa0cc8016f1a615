"""A method that hurts its own worker (its files, its process, its results' types) costs its own row only."""

import pytest

from bench.harness.plan import RunSettings
from bench.harness.run import run
from bench.record import Record, read
from tests.plugin_files import TAMPERING, limited_when_stuck, write_plugin

TIME_LIMIT_S = 0.2


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory, bare_runs: None) -> Record:
    folder = tmp_path_factory.mktemp("tampering")
    settings = RunSettings(
        vehicles=("ukwial",),
        demands=("infeasible",),
        plugins=tuple(write_plugin(folder, name) for name in TAMPERING),
        methods=("pinv",),
        n_demands=8,
        budget_ms=0,
        repeats=1,
        time_limit_s=TIME_LIMIT_S,
    )
    with limited_when_stuck(folder):
        run(settings, folder, resume=False, watch=lambda progress: None)
    return read(folder)


@pytest.mark.parametrize(
    ("method", "status", "reason"),
    [
        ("closes-files", "crashed", "exit code 1"),
        ("closes-files-and-hangs", "timeout", f"no answer within {TIME_LIMIT_S:g} s"),
        ("miscounts", "failed", "the result can't be recorded: Expected `int | null`, got `float`"),
        ("promises-nan", "failed", "tolerance nan promises nothing"),
        ("promises-text", "failed", "limited 'no' promises nothing; give True or False"),
        ("promises-a-misspelling", "failed", "'unlimted' is a letter or two from 'unlimited'"),
        ("forges", "failed", "the worker sent a message about another task"),
        ("forks", "ok", ""),  # the copy of the worker says nothing
        ("pinv", "ok", ""),
    ],
)
def test_each_method_has_one_row_that_says_what_it_did(
    record: Record, method: str, status: str, reason: str
) -> None:
    (cell,) = [cell for cell in record.cells if cell.key.method == method]
    assert cell.status == status
    assert reason in cell.reason
