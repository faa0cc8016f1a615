"""A record holds what arrived whole of a log, and nothing else."""

import time
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, load_vehicle
from bench.chips.board.log import Heard
from bench.chips.board.record import keep
from bench.inputs.board_log import LogError, answered, parse, tick_counts
from bench.record import read
from tests.board_logs import forged, opened, sealed
from tests.board_projects import Hear, project


def numbers(heard: Heard) -> dict[object, object]:
    """Everything that would be kept of a board, as values that compare."""
    kept: dict[object, object] = {name: d.taus.tobytes() for name, d in heard.demands.items()}
    for key, runs in heard.runs.items():
        for run in runs:
            arrays = (run.F.tobytes(), run.status.tobytes(), run.ticks.tobytes())
            kept[key] = (*arrays, tuple(run.ones), tuple(run.passes), run.worst_demand, run.worst_ticks)
    return kept


def test_demands_and_vehicle_come_back_to_the_last_bit(log: bytes, hear: Hear) -> None:
    (heard,) = hear(log)
    asked = {demands.name: demands for demands in project().sets}
    for name, demands in heard.demands.items():
        np.testing.assert_array_equal(demands.taus, asked[name].taus)
        np.testing.assert_array_equal(demands.labels, asked[name].labels)
    np.testing.assert_array_equal(heard.vehicle.T, load_vehicle("ukwial").T)
    assert heard.missing == []


def test_with_one_byte_in_a_hundred_changed_no_wrong_number_is_kept(log: bytes, hear: Hear) -> None:
    """Also with so few changed that blocks survive beside damaged ones; digits become other digits."""
    whole = numbers(hear(log)[0])
    rng = np.random.default_rng(16)
    digits = np.frombuffer(b"0123456789abcdef", np.uint8)
    survived = 0
    for share in [0.01] * 5 + [1e-4] * 5 + [2e-5] * 20:
        text = np.frombuffer(log, np.uint8).copy()
        hit = np.flatnonzero(rng.random(len(text)) < share)
        noise = text[hit] ^ rng.integers(1, 256, len(hit), dtype=np.uint8)
        plausible = np.isin(text[hit], digits) & (rng.random(len(hit)) < 0.9)
        text[hit] = np.where(plausible, rng.choice(digits, len(hit)), noise)
        try:
            found = hear(text.tobytes())
        except LogError:
            continue
        for heard in found:
            survived += len(heard.runs)
            assert numbers(heard).items() <= whole.items()
    assert survived > 20  # or the check above checks nothing


def test_lost_bytes_cost_their_block_and_it_is_named(log: bytes, tmp_path: Path) -> None:
    at = log.index(b"ask", log.index(b"nullspace@native active")) - 200
    (tmp_path / "LOG").write_bytes(log[:at] + log[at + 30 :])
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert any("nullspace@native on active" in line for line in kept.lines)
    cells = {(cell.key.method, cell.key.demands) for cell in read(tmp_path / "run").cells}
    assert ("nullspace@native", "active") not in cells
    assert ("nullspace@native", "infeasible") in cells


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda lines: [*lines[:40], lines[40][:-1] + b"?", *lines[41:]], "1 damaged line, 0 missing lines"),
        (lambda lines: [*lines[:40], *lines[41:]], "0 damaged lines, 1 missing line"),
        (lambda lines: [*lines[:40], lines[41][:-1] + b"?", *lines[42:]], "1 damaged line, 1 missing line"),
    ],
    ids=["damaged", "missing", "both"],
)
def test_a_damaged_line_is_not_missing_too(
    change: Callable[[list[bytes]], list[bytes]], said: str, log: bytes, tmp_path: Path
) -> None:
    (tmp_path / "LOG").write_bytes(b"\n".join(change(log.split(b"\n"))))
    assert said in keep(tmp_path / "LOG", tmp_path / "run").lines


def test_a_reset_in_the_middle_is_a_repeat_of_what_was_whole_before(log: bytes, tmp_path: Path) -> None:
    cut = log.index(b"pinv@native active")
    (tmp_path / "LOG").write_bytes(log[:cut] + b"\xff\x00" + log)
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert "the log has 2 starts, 1 of which ran to the end" in kept.lines
    repeats = [
        (cell.key.method, cell.key.demands) for cell in read(tmp_path / "run").cells if cell.key.repeat == 1
    ]
    assert ("nullspace@native", "active") in repeats
    assert ("pinv@native", "active") not in repeats


def test_a_block_that_a_reset_tore_apart_is_not_made_whole_by_the_next_start(log: bytes, hear: Hear) -> None:
    """Numbered without a gap, but of two starts: the block's CRC is over the text of both halves."""
    lines = log.splitlines(keepends=True)
    inside = next(i for i, line in enumerate(lines) if b" one " in line)
    body = lines[inside].rsplit(b" ", 1)[0].replace(b" one ", b" all ")
    torn = [*lines[:inside], b"%s %08x\n" % (body, zlib.crc32(body)), *lines[inside + 1 :]]
    assert sum(map(len, hear(log)[0].runs.values())) == 7
    assert sum(map(len, hear(b"".join(torn))[0].runs.values())) == 6


def test_a_log_of_before_shares_were_printed_is_still_read(leveled: bytes, hear: Hear) -> None:
    lines = opened(leveled)
    assert sealed(lines) == leveled  # it is the driver's form
    ends, asks = 3 + 8, b""
    for i, line in enumerate(lines):
        asks = line if line.startswith(b"ask") else asks
        if line.startswith(b"fact method"):
            lines[i] = line.rpartition(b" ")[0]
        elif line.startswith(b"f ") and b"priority" in asks:
            lines[i] = b" ".join(line.split(b" ")[: ends + 1])
    (old,) = hear(sealed(lines))
    (new,) = hear(leveled)
    for key, (run,) in old.runs.items():
        assert run.shares.shape[1] == 0
        np.testing.assert_array_equal(run.F, new.runs[key][0].F)
        assert run.ones == new.runs[key][0].ones


@pytest.mark.parametrize("text", [b"", b"\x00\xff" * 500, b"tb or not tb\n" * 9, b"tb 0 board 0 00000000\n"])
def test_a_foreign_log_is_refused_with_what_to_do(text: bytes, hear: Hear) -> None:
    with pytest.raises(LogError, match=r"; (give|open)"):
        hear(text)


@pytest.mark.parametrize("end", [b" ", b"\t", b"\x1b[0m", b"\x1b[0m\x1b[K", b"\x1b[0K"])
def test_blanks_and_colours_behind_each_line_are_no_damage(end: bytes, log: bytes, hear: Hear) -> None:
    (whole,), (found,) = hear(log), hear(log.replace(b"\n", end + b"\n"))
    assert numbers(found) == numbers(whole)


def test_a_log_as_a_terminal_or_powershell_saves_it_is_the_same_log(log: bytes, hear: Hear) -> None:
    [plain] = hear(log)
    ends = (b"\r\n", b"\r", b"\n\r", b"\r\r\n", b"\n\n")
    for text in (*(log.replace(b"\n", end) for end in ends), log.decode("ascii").encode("utf-16")):
        [read_back] = hear(text)
        assert numbers(read_back) == numbers(plain)
        assert not read_back.missing


FORGED: tuple[tuple[bytes, bytes], ...] = (
    (rb"fact method pinv@native (\S+) -", rb"fact method pinv@native \1 ../../x"),
    (rb"fact method pinv@native (\S+) -", rb"fact method pinv@native \1 os"),
    (rb"fact method pinv@native (\S+) -", rb"fact method walsh@native \1 -"),
    (rb"fact method pinv@native \S+ -", b"fact method pinv@native pi\x00nv -"),
    (rb"fact method pinv@native (\S+) -", b"fact method pinv@native none -"),
    (rb"fact demands inactive \S+", b"fact demands inactive " + b"a" * 5000),
    (rb"fact method pinv@native (\S+) - (\d+)", rb"fact method pinv@native \1 - 999999999"),
    (rb"fact method .*", b"fact method"),
    (rb"fact (method|demands) .*", b"fact nothing"),
    (rb"ticks_per_s \d+", b"ticks_per_s -5"),
    (rb"ticks_per_s \d+", b"ticks_per_s 1" + b"0" * 32),
    (rb"fact demands inactive \S+", b"fact demands inactive nan"),
    (rb"fact demands inactive \S+", b"fact demands inactive -1e400"),
    (rb"fact seed \d+", b"fact seed -1"),
    (rb"^one \d+ ", b"one -7 "),
    (rb"^one \d+ ", b"one 1" + b"0" * 32 + b" "),
    (rb"^worst (\d+) \d+", rb"worst \1 -1"),
    (rb"^worst (\d+) \d+", rb"worst \1 1" + b"0" * 32),
    (rb"^f (\d+) (\d+) \d+", rb"f \1 \2 -1"),
    (rb"^f (\d+) (\d+) \d+", rb"f \1 \2 12345678901"),
)


@pytest.mark.parametrize(("what", "becomes"), FORGED)
def test_a_forged_log_whose_checksums_are_right_is_refused_in_one_line(
    log: bytes, what: bytes, becomes: bytes, tmp_path: Path
) -> None:
    (tmp_path / "LOG").write_bytes(forged(log, what, becomes))
    with pytest.raises(AllocError) as refused:
        keep(tmp_path / "LOG", tmp_path / "out")
    message = str(refused.value)
    assert message.isprintable()
    assert message.startswith(f"{tmp_path / 'LOG'}: ")
    assert len(message) < len(str(tmp_path)) + 500


def test_what_would_move_a_terminal_s_cursor_is_not_printed(log: bytes, tmp_path: Path) -> None:
    lines = opened(forged(log, rb"fact processor .*", b"fact processor \x1b[2J\x07evil"))
    lines.insert(1, b"nonsense \x1b]0;mine\x07")
    (tmp_path / "LOG").write_bytes(sealed(lines))
    try:
        said = keep(tmp_path / "LOG", tmp_path / "out").lines
    except AllocError as error:
        said = [str(error)]
    assert all(line.isprintable() for line in said)
    assert "evil" in "".join(said)


def test_a_log_of_a_million_calls_is_read_within_two_seconds() -> None:
    """50 blocks of 200 demands with eight thrusts, each timed 100 times, as the driver prints them."""
    lines: list[bytes] = []

    def line(text: str, block: int) -> int:
        body = f"tb {len(lines)} {text}".encode()
        lines.append(body + b" %08x" % zlib.crc32(body))
        return zlib.crc32(lines[-1], block)

    for method in range(50):
        block = line(f"ask 12345678 m{method} active 200 100", 0)
        for i in range(200):
            block = line(f"f {i} 0 {i} " + " ".join(["4009a5c3f0e1d2b7"] * 8), block)
        for i in range(0, 400, 8):
            block = line("one " + " ".join(f"{i + j} 50" for j in range(8)), block)
        line(f"end {zlib.crc32(b'tb %d end' % len(lines), block):08x}", 0)
    start = time.process_time()
    log = parse(b"\n".join(lines))
    answers = [answered(block, 8, np.dtype("<f8")) for block in log.blocks]
    calls = sum(times for block in log.blocks for _, times in tick_counts(block, "one"))
    assert time.process_time() - start <= 2.0
    assert calls == 1_000_000
    assert all(len(one.F) == 200 for one in answers)
    assert log.damaged == log.lost == 0
