"""A project times NAME_esc too, and its log says whether the thrusts that it made are Python's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import AllocError, NotApplicable, load_vehicle
from bench.chips import esc
from bench.chips.board.project import Project, plan, write
from bench.chips.board.record import keep
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.processors import processor
from bench.record import read
from bench.report import render
from bench.report.sizes import page
from bench.results.machines import read_machines
from bench.results.size import Loop
from bench.results.sizing import sizes
from bench.results.text import three
from tests.board_logs import forged, opened, sealed
from tests.board_projects import make
from tests.emulators import available

HEAVY = load_vehicle("bluerov2-heavy")
METHODS = ("pinv@native", esc.METHOD)


def project(limits: str, methods: tuple[str, ...] = METHODS, n: int = 8) -> Project:
    return plan(HEAVY, methods, ("active",), "float", limits, n, 3)  # type: ignore[arg-type]  # of parameters


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Output of a method and NAME_esc with limits of the call on this computer."""
    folder = tmp_path_factory.mktemp("esc")
    write(project("call"), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    return (folder / "build/posix/LOG").read_bytes()


def kept(text: bytes, folder: Path) -> dict[tuple[str, str], object]:
    (folder / "LOG").write_bytes(text)
    keep(folder / "LOG", folder / "run")
    return {(cell.key.method, cell.key.demands): cell.judged for cell in read(folder / "run").cells}


def test_a_log_says_that_what_was_made_is_python_s_and_a_report_has_its_rows(
    log: bytes, tmp_path: Path
) -> None:
    judged = kept(log, tmp_path)
    assert set(judged) == {
        ("noop", "active"),
        ("pinv@native", "active"),
        *((esc.METHOD, s) for s in esc.SIZES),
    }
    for name in esc.SIZES:
        assert judged[esc.METHOD, name].agrees  # type: ignore[attr-defined]  # of a Judged
    render(tmp_path / "run")
    assert "| esc " in (tmp_path / "run/details.md").read_text(encoding="utf-8")


def test_size_says_what_commands_cost_on_top_of_a_method(log: bytes, tmp_path: Path) -> None:
    kept(log, tmp_path)
    ((machine,), loop) = (read_machines([tmp_path / "run"]), Loop(rate_hz=100))
    rows = [row for row in machine.run.rows if row.method == esc.METHOD]
    slowest = max(row.call_max_us or 0.0 for row in rows)
    text = page([machine], {machine.name: sizes(machine.run, loop)}, loop)
    assert f"slowest {three(slowest / loop.period_us * 100)} % of the period" in text


def test_line_ends_of_a_terminal_change_nothing(log: bytes, tmp_path: Path) -> None:
    whole = kept(log, tmp_path)
    assert kept(log.replace(b"\n", b"\r\n"), tmp_path) == whole


def test_a_thrust_that_the_command_does_not_make_is_told(log: bytes, tmp_path: Path) -> None:
    asks, lines = b"", opened(log)
    for i, line in enumerate(lines):
        asks = line if line.startswith(b"ask") else asks
        if line.startswith(b"f 5 ") and b" esc thrusts" in asks:
            words = line.split(b" ")
            (value,) = np.frombuffer(bytes.fromhex(words[4].decode()), ">f4")
            words[4] = np.array(value + 1.0, ">f4").tobytes().hex().encode()
            lines[i] = b" ".join(words)
    (tmp_path / "LOG").write_bytes(sealed(lines))
    done = keep(tmp_path / "LOG", tmp_path / "run")
    assert not done.good
    assert any("esc on thrusts: makes other thrusts than Python" in line for line in done.lines)


@pytest.mark.parametrize("status", [b"0", b"4294967294", b"99"])
def test_another_status_than_python_s_is_told(log: bytes, status: bytes, tmp_path: Path) -> None:
    """One that always was 0, or none of the header's, was right."""
    asks, lines = b"", opened(log)
    for i, line in enumerate(lines):
        asks = line if line.startswith(b"ask") else asks
        if line.startswith(b"f ") and b" esc thrusts" in asks:
            words = line.split(b" ")
            lines[i] = b" ".join([*words[:2], status, *words[3:]])
    (tmp_path / "LOG").write_bytes(sealed(lines))
    done = keep(tmp_path / "LOG", tmp_path / "run")
    assert not done.good
    assert any("esc on thrusts" in line and "another status" in line for line in done.lines)


@pytest.mark.parametrize(
    ("what", "becomes"),
    [
        (rb"^ask (\w+) esc thrusts", rb"ask \1 esc active"),
        (rb"^ask (\w+) pinv@native active", rb"ask \1 pinv@native thrusts"),
        (rb"^fact limits call", b"fact limits fixed"),
        (rb"^fact method esc .*", b"fact method esc"),
        (rb"^fact method esc - - 0", b"fact method esc - - 9"),
        (rb"^fact demands thrusts -", b"fact demands thrusts nan"),
    ],
)
def test_a_forged_log_is_refused_in_one_line(log: bytes, what: bytes, becomes: bytes, tmp_path: Path) -> None:
    (tmp_path / "LOG").write_bytes(forged(log, what, becomes))
    with pytest.raises(AllocError) as refused:
        keep(tmp_path / "LOG", tmp_path / "run")
    assert str(refused.value).isprintable()


def test_alone_and_through_qemu_s_serial_line_it_takes_what_emulate_counts(tmp_path: Path) -> None:
    available("cortex-m4f")
    write(project("fixed", (esc.METHOD,)), tmp_path)
    make(tmp_path, "PORT=mps2-an386", "log")
    keep(tmp_path / "build/mps2-an386/LOG", tmp_path / "run")
    rows = {row.demands: row for row in read(tmp_path / "run").emulated}
    (tmp_path / "image").mkdir()
    image = link(esc.kernel(HEAVY, "float", "fixed"), processor("cortex-m4f"), tmp_path / "image")
    for name, calls in esc.calls(HEAVY, "fixed", 8, 3).items():
        values, often = np.unique(count(image, calls).instructions, return_counts=True)
        assert rows[name].instructions == list(zip(values.tolist(), often.tolist(), strict=True))
        assert rows[name].agrees
        assert rows[name].method == esc.METHOD


def test_a_vehicle_without_escs_is_not_asked_and_it_is_said() -> None:
    bare = replace(HEAVY, esc=())
    made = plan(bare, METHODS, ("active",), "float", "fixed", 5, 0)
    assert made.thrusts == {}
    assert made.omissions == ("esc: bluerov2-heavy: has no ESCs; add 'esc' to its file",)
    with pytest.raises(NotApplicable, match="nothing is left to ask; esc"):
        plan(bare, (esc.METHOD,), ("active",), "float", "fixed", 5, 0)
