"""Logs that a terminal wrapped, and those whose checksums are right and whose words no driver wrote."""

import base64
import json
import textwrap
import time
import zlib
from pathlib import Path

import pytest

from bench.chips.board.log import boards
from bench.chips.board.record import keep
from bench.inputs.board_log import LogError, read_board_log
from bench.report import render
from bench.results.rows import read_run
from tests.board_logs import forged, opened, sealed
from tests.board_projects import printed, project


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Output of a small project on this computer: each of its three demands 5 times."""
    return printed(tmp_path_factory.mktemp("project"), project(n=3), 5)


def called(log: bytes, name: str, place: int = 0) -> bytes:
    """The log of a vehicle of that name, or with ``place`` 2 of one that has that name without its faults."""
    lines = opened(log)
    pieces = [line.split(b" ")[2] for line in lines if line.startswith(b"fact vehicle")]
    arrays = json.loads(zlib.decompress(base64.b64decode(b"".join(pieces))))
    arrays["vehicle"][place] = name
    return of_vehicle(log, json.dumps(arrays))


def of_vehicle(log: bytes, text: str) -> bytes:
    """The log with that text for its vehicle."""
    lines = opened(log)
    packed = base64.b64encode(zlib.compress(text.encode()))
    first = next(i for i, line in enumerate(lines) if line.startswith(b"fact vehicle"))
    others = [line for line in lines if not line.startswith(b"fact vehicle")]
    made = [b"fact vehicle " + packed[i : i + 96] for i in range(0, len(packed), 96)]
    return sealed([*others[:first], *made, *others[first:]])


@pytest.mark.parametrize("place", [0, 2])
@pytest.mark.parametrize("name", ["uk\0wial", "a\nb", "\x1b[31mred", "a\u202eb", "x" * 300])
def test_a_vehicle_whose_name_can_t_be_shown_is_refused(
    name: str, place: int, log: bytes, tmp_path: Path
) -> None:
    (tmp_path / "LOG").write_bytes(called(log, name, place))
    with pytest.raises(LogError, match="is no name of 1 to 100 printable characters") as refused:
        keep(tmp_path / "LOG", tmp_path / "run")
    assert str(refused.value).startswith(f"{tmp_path / 'LOG'}: ")
    assert str(refused.value).isprintable()
    assert not (tmp_path / "run").exists()


def test_a_vehicle_of_any_other_name_is_drawn(log: bytes, tmp_path: Path) -> None:
    (tmp_path / "LOG").write_bytes(called(log, "../漢字 " + 93 * "x"))
    keep(tmp_path / "LOG", tmp_path / "run")
    render(tmp_path / "run")
    assert list((tmp_path / "run").glob("cost-..⁄漢字 xxx*.svg"))


@pytest.mark.parametrize("text", ["[1, 2]", "5", "null", "NaN", '"a"', "{}", "[" * 100_000, '{"a":' * 50_000])
def test_what_is_no_vehicle_is_refused_in_one_line(text: str, log: bytes, tmp_path: Path) -> None:
    (tmp_path / "LOG").write_bytes(of_vehicle(log, text))
    with pytest.raises(LogError, match="is of another version of the driver") as refused:
        keep(tmp_path / "LOG", tmp_path / "run")
    assert len(str(refused.value).splitlines()) == 1


def test_a_clock_of_no_ticks_is_refused_of_a_processor_whose_instructions_nobody_counts(
    log: bytes, tmp_path: Path
) -> None:
    """Its record had no row, and report and size showed an empty table."""
    (tmp_path / "LOG").write_bytes(forged(log, rb"^ticks_per_s \d+", b"ticks_per_s 0"))
    keep(tmp_path / "LOG", tmp_path / "counted")  # this computer's instructions can be counted
    other = forged((tmp_path / "LOG").read_bytes(), b"^fact processor .*", b"fact processor STM32F767")
    (tmp_path / "LOG").write_bytes(other)
    with pytest.raises(LogError, match=r"counts instructions, as ticks_per_s is 0, of .*; give ticks_per_s"):
        keep(tmp_path / "LOG", tmp_path / "run")


@pytest.mark.parametrize("width", [50, 80])
def test_a_log_that_a_terminal_wrapped_is_read_as_it_was_printed(
    width: int, log: bytes, tmp_path: Path
) -> None:
    texts = log.decode().splitlines()
    wrapped = [piece for text in texts for piece in textwrap.wrap(text, width, drop_whitespace=False)]
    assert max(map(len, texts)) > 80
    (tmp_path / "LOG").write_bytes(log)
    (tmp_path / "WRAPPED").write_text("\r\n".join(wrapped) + "\r\n", newline="")
    found, plain = (read_board_log(tmp_path / name) for name in ("WRAPPED", "LOG"))
    assert found.blocks == plain.blocks
    (heard,) = boards(tmp_path / "WRAPPED", found)
    assert heard.missing == []


@pytest.mark.parametrize("times", [10_000, 50_000_000])
def test_very_many_passes_are_read_at_once_and_keep_their_median(
    times: int, log: bytes, tmp_path: Path
) -> None:
    """Each was kept by itself: a forged log held the reader up for minutes, or took all memory."""
    lines = []
    for line in opened(log):
        words = line.split(b" ")
        if words[0] in (b"one", b"all"):
            words[2::2] = [b"%d" % (times * int(often)) for often in words[2::2]]
        elif words[0] == b"ask":
            words[5] = b"%d" % (5 * times)
        lines.append(b" ".join(words))
    medians = []
    for name, text in (("FEW", log), ("MANY", sealed(lines))):
        (tmp_path / name).write_bytes(text)
        start = time.process_time()
        keep(tmp_path / name, tmp_path / f"{name} run")
        assert time.process_time() - start < 10
        run = read_run(tmp_path / f"{name} run")
        medians.append({(row.label, row.demands): row.call_p50_us for row in run.rows})
    assert medians[0] == medians[1]
    assert {row.n_single_calls for row in run.rows} == {15 * times}
    assert {len(cell.batches) for cell in run.record.cells} == {10_000}
