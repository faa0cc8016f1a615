"""A record survives kills, a full disk and a second run, and is continued where it stopped."""

import gzip
import os
import random
import re
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner

from bench.__main__ import cli
from bench.harness.plan import RunSettings
from bench.harness.run import WORKING, check_same, run
from bench.record import FILE_NAME, PACKED, Record, RecordError, read
from bench.record.file import PREVIOUS, Writer
from tests.made_up import header
from tests.places import ROOT
from tests.runs import started, wait_for, written

DEMANDS = ["--demands=inactive", "--demands=active", "--demands=infeasible"]
METHODS = ["--method=pinv", "--method=svd"]
TINY = ["run", "--vehicle=ukwial", *METHODS, *DEMANDS, "--n=4", "--budget-ms=0", "--repeats=1"]
CELLS = 2 * 3 + 3 + 2  # two methods and noop on three demand sets, and two canaries

MEASURE = """
import sys; from pathlib import Path
from bench.harness.plan import RunSettings; from bench.harness.run import run
demands, methods = ("inactive", "active", "infeasible"), ("pinv", "svd")
starts = ("cold", "reused", "warm")
settings = RunSettings(
    vehicles=("ukwial",), demands=demands, methods=methods, starts=starts, n_demands=4, budget_ms=0, repeats=1
)
run(settings, Path(sys.argv[1]), resume=True, watch=lambda progress: None)
"""
"""The run of TINY without its report, which takes longer than all the rest."""

FULL_DISK = """
import errno, os, sys
write, full = os.write, int(sys.argv.pop(1))
def write_record(descriptor, data):
    if b'"type":' in data and os.fstat(descriptor).st_size + len(data) > full:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    return write(descriptor, data)
os.write = write_record
from bench.__main__ import main
main()
"""
"""The program on a disk that is full as soon as the record has so many bytes."""


def measured(folder: Path) -> None:
    with started("-c", MEASURE, str(folder)) as process:
        output = process.communicate()[0]
    assert process.returncode == 0, output


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("finished")
    measured(folder)
    return folder


def test_a_record_cut_at_any_byte_of_its_last_lines_gives_the_whole_lines_before(
    finished: Path, tmp_path: Path
) -> None:
    data = written(finished)
    lines = data.splitlines(keepends=True)
    first = len(data) - len(b"".join(lines[-3:]))
    for cut in range(first, len(data) + 1):
        (tmp_path / FILE_NAME).write_bytes(data[:cut])
        record = read(tmp_path)
        whole = data[:cut].count(b"\n")
        assert 1 + count(record) == whole
    # A record that was cut is continued at the end of its last whole line.
    (tmp_path / FILE_NAME).write_bytes(data[: first + 5])
    with Writer(tmp_path) as writer:
        writer.resume()
    assert (tmp_path / FILE_NAME).read_bytes() == data[:first]


def test_a_new_run_in_the_same_folder_keeps_the_last_record_as_previous(
    finished: Path, tmp_path: Path
) -> None:
    old = written(finished)
    (tmp_path / FILE_NAME).write_bytes(old)
    for made in (header(), header(seed=5)):
        with Writer(tmp_path) as writer:
            writer.create(made)
        assert (tmp_path / PREVIOUS).read_bytes() == old
        old = written(tmp_path)
    assert read(tmp_path).header.seed == 5


def test_a_packed_record_is_not_continued_since_a_new_one_would_hide_it(tmp_path: Path) -> None:
    (tmp_path / PACKED).write_bytes(gzip.compress(msgspec.json.encode(header()) + b"\n"))
    with Writer(tmp_path) as writer, pytest.raises(RecordError, match="gunzip it first"):
        writer.resume()
    assert read(tmp_path).header == header()


def count(record: Record) -> int:
    kinds = (
        record.methods,
        record.problems,
        record.capabilities,
        record.cells,
        record.workers,
        record.events,
    )
    return sum(map(len, kinds))


@pytest.mark.parametrize("kills", [3, pytest.param(8, marks=pytest.mark.long)])
def test_killed_at_random_moments_and_resumed_every_cell_is_there_once_and_none_has_changed(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, kills: int
) -> None:
    """No folder of the killed runs is left either, neither where temporary ones lie nor beside the record."""
    temporary = tmp_path_factory.mktemp("temporary")
    monkeypatch.setenv("TMPDIR", str(temporary))
    dice = random.Random(6)
    before = b""

    def grown() -> bool:
        return process.poll() is not None or len(written(tmp_path)) > len(before)

    for _ in range(kills):
        with started("-c", MEASURE, str(tmp_path)) as process:
            wait_for(grown)
            time.sleep(dice.uniform(0.0, 0.2))
            process.kill()
        data = written(tmp_path)
        assert data.startswith(before)
        before = data[: data.rfind(b"\n") + 1]
    measured(tmp_path)
    assert not [*temporary.iterdir(), *tmp_path.glob(f"{WORKING}*")]
    assert written(tmp_path).startswith(before)
    assert "resumed" in [event.what for event in read(tmp_path).events]
    times = Counter(cell.key for cell in read(tmp_path).cells)
    assert len(times) == CELLS
    assert set(times.values()) == {1}
    assert {cell.status for cell in read(tmp_path).cells} == {"ok"}


def test_a_full_disk_ends_the_run_with_one_line_and_keeps_what_was_written(
    finished: Path, tmp_path: Path
) -> None:
    full = len(written(finished)) - 6_000  # bytes of the record: some of its cells fit, not all
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(full), *TINY, f"--out={tmp_path}"],
        cwd=ROOT,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 2
    (line,) = done.stderr.decode().splitlines()
    assert FILE_NAME in line
    assert "--resume" in line
    kept = written(tmp_path)
    assert kept.endswith(b"\n")
    some = len(read(tmp_path).cells)
    assert 0 < some < CELLS
    settings = read(tmp_path).header.settings
    run(msgspec.convert(settings, RunSettings), tmp_path, resume=True, watch=lambda progress: None)
    assert written(tmp_path).startswith(kept)
    assert len(read(tmp_path).cells) == CELLS


def test_two_runs_never_write_into_one_folder(tmp_path: Path) -> None:
    with Writer(tmp_path):
        result = CliRunner().invoke(cli, [*TINY, f"--out={tmp_path}"], standalone_mode=False)
    assert isinstance(result.exception, RecordError)
    assert "another run writes here" in str(result.exception)


def test_a_record_made_with_other_settings_is_not_continued(finished: Path) -> None:
    before = written(finished)
    options = [*TINY, "--seed=1", "--resume", f"--out={finished}"]
    error = CliRunner().invoke(cli, options, standalone_mode=False).exception
    assert isinstance(error, RecordError)
    assert "seed" in str(error)
    assert written(finished) == before


def test_a_record_made_without_a_package_that_is_there_now_is_not_continued(tmp_path: Path) -> None:
    old = header(versions={"python": "CPython 3.11.7"})
    new = header(versions={"python": "CPython 3.11.7", "quadprog": "0.1.13"})
    with pytest.raises(RecordError, match="quadprog"):
        check_same(old, new, tmp_path)


def test_a_packed_record_reads_as_the_plain_one_did(finished: Path, tmp_path: Path) -> None:
    packed = gzip.compress(written(finished))
    (tmp_path / PACKED).write_bytes(packed)
    assert read(tmp_path) == read(finished)
    for damaged in (packed[: len(packed) // 2], b"no archive", packed[:40] + b"\xff" * 40 + packed[80:]):
        (tmp_path / PACKED).write_bytes(damaged)
        with pytest.raises(RecordError, match="can't be read"):
            read(tmp_path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b"", "no complete line"),
        (b"not json\n", "no header"),
        (b'{"type":"header","schema":99}\n', "schema 99"),
        (b'{"type":"cell"}\n', "no header"),
    ],
)
def test_a_file_that_is_no_record_is_refused_by_name(tmp_path: Path, text: bytes, says: str) -> None:
    (tmp_path / FILE_NAME).write_bytes(text)
    with pytest.raises(RecordError, match=says) as caught:
        read(tmp_path)
    assert str(tmp_path / FILE_NAME) in str(caught.value)


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(RecordError, match="can't be written"):
        Writer(blocked / "run")
    assert os.listdir(tmp_path) == ["file"]


def test_what_is_said_of_a_line_does_not_repeat_all_of_it(finished: Path, tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_bytes(written(finished) + b'{"type":"' + b"x" * 9999 + b'"}\n')
    with pytest.raises(RecordError, match="remove that line") as caught:
        read(tmp_path)
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


@pytest.mark.parametrize(
    "key", [rb'("batches":\[\[\d+,)(?=\d)', rb'("singles":\[\[)(?=\d)', rb'("n_demands":)(?=\d)']
)
def test_a_negative_time_is_no_time(finished: Path, tmp_path: Path, key: bytes) -> None:
    """The method of such a line was the first to be recommended."""
    head, mark, cells = written(finished).partition(b'{"type":"cell"')
    spoilt = re.sub(key, rb"\1-", cells, count=1)
    assert spoilt != cells
    (tmp_path / FILE_NAME).write_bytes(head + mark + spoilt)
    with pytest.raises(RecordError, match=r"Expected `int` >= 0.*remove that line"):
        read(tmp_path)
