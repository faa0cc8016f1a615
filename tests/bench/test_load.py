"""A run in a script: ``bench.load``, and the page about it."""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import get_args, get_type_hints

import pandas as pd
import pytest

from bench import Row, load, load_run
from bench.record import PACKED, Batch, Judged, Key, RecordError
from bench.results.columns import columns
from tests import made_up
from tests.pages import blocks
from tests.places import DOCS, ROOT
from tests.readers import refused

TIMED = sorted(
    path.parent for path in (ROOT / "results").glob(f"*/{PACKED}") if path.with_name("results.csv").exists()
)
TYPED = """\
from pathlib import Path
from typing import assert_type
from bench import Row, load, load_run

rows = load("results")
assert_type(rows, tuple[Row, ...])
assert_type(load_run("results").rows, tuple[Row, ...])
assert_type(rows[0].agreed, bool | None)
assert_type(load(Path("results"))[0].call_p50_us, float | None)
assert_type([row.vehicle for row in rows], list[str])
"""


@pytest.mark.parametrize("directory", TIMED, ids=lambda path: path.name)
def test_a_row_s_attributes_are_the_cells_of_the_committed_csv(directory: Path) -> None:
    with (directory / "results.csv").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    rows = load(str(directory))
    assert len(rows) == len(lines) > 0
    for name, column in columns().items():
        kind = get_type_hints(column)["return"]
        for row, line in zip(rows, lines, strict=True):
            value, cell = getattr(row, name), line[name]
            assert isinstance(value, kind), name
            if isinstance(value, float):
                assert float(cell) == pytest.approx(value, rel=5.1e-6, abs=0), name  # six digits
            else:
                assert cell == ("" if value is None else str(value)), name


@pytest.mark.parametrize("directory", [*TIMED, None], ids=lambda path: path.name if path else "made up")
def test_a_run_s_table_has_the_columns_and_cells_of_its_rows(directory: Path | None, tmp_path: Path) -> None:
    run = load_run(directory or made_up.whole(tmp_path))
    assert list(run.table) == list(columns())
    for name in columns():
        cells = run.table[name]
        for row, cell in zip(run.rows, cells, strict=True):
            value = getattr(row, name)
            assert pd.isna(cell) if value is None else cell == value, name
        assert pd.api.types.is_integer_dtype(cells) == (int in kinds(name)), name
        assert pd.api.types.is_float_dtype(cells) == (float in kinds(name)), name


def test_rows_are_read_without_pandas(tmp_path: Path) -> None:
    made_up.whole(tmp_path)
    code = "import sys; from bench import load; assert load(sys.argv[1]); assert 'pandas' not in sys.modules"
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, check=True, timeout=60)


def kinds(name: str) -> tuple[type, ...]:
    """Types of a column's values."""
    kind = get_type_hints(columns()[name])["return"]
    return get_args(kind) or (kind,)


def test_a_folder_is_named_by_text_or_by_a_path(tmp_path: Path) -> None:
    made_up.whole(tmp_path)
    assert load(tmp_path) == load(str(tmp_path))
    assert {type(row) for row in load(tmp_path)} == {Row}


def test_a_folder_without_a_readable_record_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="give a run's folder"):
        load(tmp_path)
    record = tmp_path / "record.jsonl"
    refused(lambda: load(str(tmp_path)), record)
    record.write_text("{}\n")
    refused(lambda: load(str(tmp_path)), record)


def test_the_page_s_example_draws_a_picture(tmp_path: Path) -> None:
    example, _ = blocks(DOCS / "scripts.md", "python")
    (tmp_path / "results").symlink_to(ROOT / "results")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    subprocess.run([sys.executable, "-c", example], cwd=tmp_path, env=environment, check=True, timeout=100)
    assert (tmp_path / "exact.png").read_bytes().startswith(b"\x89PNG")


def test_the_page_s_second_example_prints_times(tmp_path: Path) -> None:
    _, example = blocks(DOCS / "scripts.md", "python")
    (tmp_path / "results").symlink_to(ROOT / "results")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", example],
        cwd=tmp_path,
        env=environment,
        check=True,
        timeout=100,
        capture_output=True,
        text=True,
    )
    assert re.search(
        r"[1-9]\d* single calls, the median [1-9]\d* ns\nbatches: [1-9]\d* ns a call$", done.stdout.strip()
    )


def test_a_run_gives_its_rows_its_machine_and_how_it_was_made(tmp_path: Path) -> None:
    made_up.whole(tmp_path)
    run = load_run(str(tmp_path))
    assert run.rows == load(tmp_path)
    assert run.machine == run.record.header.machine == run.header.machine


def test_samples_are_the_times_of_every_batch_and_of_every_single_call(tmp_path: Path) -> None:
    first, second = Batch(10, 5_000, 4_000, 0), Batch(20, 8_000, 7_000, 0)
    cells = [
        made_up.cell(
            batches=[first], singles=[(300, 2), (700, 1)], key=Key("ukwial", "active", "pinv", repeat=0)
        ),
        made_up.cell(key=Key("ukwial", "active", "pinv", repeat=1), batches=[second], singles=[(300, 1)]),
    ]
    made_up.record(tmp_path, made_up.header(), *cells)
    run = load_run(tmp_path)
    (row,) = run.rows
    times = run.samples(row)
    assert times.repeat.tolist() == [0, 1]
    assert times.calls.tolist() == [10, 20]
    assert times.wall_ns.tolist() == [5_000, 8_000]
    assert times.cpu_ns.tolist() == [4_000, 7_000]
    assert times.single_ns.tolist() == [300, 300, 300, 700]


def test_a_row_without_times_has_empty_samples(tmp_path: Path) -> None:
    made_up.record(
        tmp_path, made_up.header(), made_up.cell(status="crashed", batches=[], singles=[], judged=None)
    )
    run = load_run(tmp_path)
    assert [len(array) for array in run.samples(run.rows[0])] == [0] * 5


@pytest.mark.parametrize(("agrees", "word"), [(True, "yes"), (False, "no"), (None, "-")])
def test_booleans_say_what_the_words_say(agrees: bool | None, word: str, tmp_path: Path) -> None:
    judged = Judged(answers=1, counts={"SOLVED": 1}, agrees=agrees)
    made_up.record(tmp_path, made_up.header(), made_up.cell(judged=judged))
    (row,) = load(tmp_path)
    assert (row.agreed, row.agrees) == (agrees, word)
    assert row.undisturbed is (row.quiet == "yes")


@pytest.mark.long
def test_a_type_checker_knows_the_columns_of_a_row(tmp_path: Path) -> None:
    examples = blocks(DOCS / "scripts.md", "python")
    (tmp_path / "typed.py").write_text(TYPED)
    for i, example in enumerate(examples):
        (tmp_path / f"example{i}.py").write_text(example)
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "typed.py", "example0.py", "example1.py"],
        cwd=tmp_path,
        env={**os.environ, "MYPYPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=290,  # types of pandas are read too
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_a_batch_of_no_calls_is_refused_with_its_line(tmp_path: Path) -> None:
    made_up.record(tmp_path, made_up.header(), made_up.cell(batches=[Batch(0, 1, 1, 0)]))
    with pytest.raises(RecordError, match="line 2: Expected `int` >= 1"):
        load(tmp_path)
