"""A project runs wherever C compiles; a record holds what arrived whole of its log, and nothing else."""

import re
import shutil
import struct
import subprocess
import time
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, NotApplicable, build, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.formulations import Family
from alloc.program import Scalar, Where
from bench.__main__ import cli
from bench.chips.board.files import write
from bench.chips.board.heard import Heard, boards
from bench.chips.board.keep import keep
from bench.chips.board.measured import lines
from bench.chips.board.project import Project, plan
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import own
from bench.demands import labelled
from bench.inputs.board_answers import answered, seen
from bench.inputs.board_log import LogError, parse, read_board_log
from bench.record import Method, read
from bench.report import render
from bench.report.sections import slowest
from bench.report.verdict import usual
from bench.results.fit import Fit, Loop
from bench.results.machines import read_machines
from bench.results.ranking import exact
from bench.results.rows import read_run
from bench.results.sizing import sizes
from tests.board_logs import forged, opened, sealed
from tests.emulators import available
from tests.vehicle_files import torpedo

METHODS = ("nullspace@native", "pinv@native")
SETS = ("inactive", "active", "infeasible")


def project(scalar: Scalar = "double", n: int = 20) -> Project:
    return plan(load_vehicle("ukwial"), METHODS, SETS, scalar, "fixed", n, 3)


def make(folder: Path, *words: str) -> None:
    """Build with `make`; skips without a tool, and fails with the compiler's words."""
    compiler = next((word[3:] for word in words if word.startswith("CC=")), "cc")
    for tool in ("make", compiler):
        if not shutil.which(tool):
            pytest.skip(f"needs {tool}")
    done = subprocess.run(["make", *words], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a small project printed on this computer: every demand timed 150 times."""
    folder = tmp_path_factory.mktemp("project")
    write(project(), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=150")
    return (folder / "build/posix/LOG").read_bytes()


Hear = Callable[[bytes], list[Heard]]


@pytest.fixture
def hear(tmp_path: Path) -> Hear:
    def boards_in(text: bytes) -> list[Heard]:
        path = tmp_path / "LOG"
        path.write_bytes(text)
        return boards(path, read_board_log(path))

    return boards_in


def numbers(heard: Heard) -> dict[object, object]:
    """Everything that would be kept of a board, as values that compare."""
    kept: dict[object, object] = {name: d.taus.tobytes() for name, d in heard.demands.items()}
    for key, runs in heard.asked.items():
        for run in runs:
            arrays = (run.F.tobytes(), run.status.tobytes(), run.ticks.tobytes())
            kept[key] = (*arrays, tuple(run.ones), tuple(run.passes), run.worst_demand, run.worst_ticks)
    return kept


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_it_builds_for_posix_with_make_alone_and_warnings_as_errors(
    compiler: str, scalar: Scalar, tmp_path: Path
) -> None:
    write(project(scalar, n=3), tmp_path)
    assert "-Werror" in (tmp_path / "Makefile").read_text()
    make(tmp_path, f"CC={compiler}")
    assert (tmp_path / "build/posix/board").exists()


def test_a_log_becomes_a_run_like_any_other(log: bytes, tmp_path: Path) -> None:
    (tmp_path / "LOG").write_bytes(log)
    kept = keep(tmp_path / "LOG", tmp_path / "run", "Desk 1")
    assert kept.good, kept.said
    (machine,) = read_machines([tmp_path / "run"])
    assert machine.name == "desk-1"
    record = read(tmp_path / "run")
    cells = {(cell.key.method, cell.key.demands): cell for cell in record.cells}
    assert set(cells) == {("noop", "inactive"), *((m, d) for m in METHODS for d in SETS)}
    for (method, demands), cell in cells.items():
        assert sum(times for _, times in cell.singles) == 20 * 150
        assert [batch.calls for batch in cell.batches] == [20] * 150
        if method != "noop":
            (problem,) = [p for p in record.problems if p.demands == demands]
            assert cell.judged is not None
            assert cell.judged.answers == problem.n_demands == 20
            assert len(cell.worst) == 3
    assert cells["nullspace@native", "active"].judged.agrees  # type: ignore[union-attr]
    assert cells["nullspace@native", "infeasible"].judged.counts == {"INFEASIBLE": 20}  # type: ignore[union-attr]
    assert slowest.section(machine.run, frozenset()).count("nullspace@native") == 3
    sized = sizes(machine.run, Loop(rate_hz=10.0))
    assert {size.method: size.fit for size in sized if size.exact}["nullspace@native"] <= Fit.WITHOUT_TAIL


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
            survived += len(heard.asked)
            assert numbers(heard).items() <= whole.items()
    assert survived > 20  # or the check above checks nothing


def test_lost_bytes_cost_their_block_and_it_is_named(log: bytes, tmp_path: Path) -> None:
    at = log.index(b"ask", log.index(b"nullspace@native active")) - 200
    (tmp_path / "LOG").write_bytes(log[:at] + log[at + 30 :])
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert any("nullspace@native on active" in line for line in kept.said)
    cells = {(cell.key.method, cell.key.demands) for cell in read(tmp_path / "run").cells}
    assert ("nullspace@native", "active") not in cells
    assert ("nullspace@native", "infeasible") in cells


def test_a_reset_in_the_middle_is_a_repeat_of_what_was_whole_before(log: bytes, tmp_path: Path) -> None:
    cut = log.index(b"pinv@native active")
    (tmp_path / "LOG").write_bytes(log[:cut] + b"\xff\x00" + log)
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert "the log has 2 starts, 1 of which ran to the end" in kept.said
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
    assert sum(map(len, hear(log)[0].asked.values())) == 7
    assert sum(map(len, hear(b"".join(torn))[0].asked.values())) == 6


def test_two_boards_in_one_log_become_two_records(log: bytes, tmp_path: Path) -> None:
    write(project("float"), tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    second = (tmp_path / "build/posix/LOG").read_bytes()
    (tmp_path / "LOG").write_bytes(log + second)
    keep(tmp_path / "LOG", tmp_path / "runs", "desk")
    first, other = (read(tmp_path / "runs" / name) for name in ("1-desk", "2-desk"))
    assert {sum(times for _, times in cell.singles) for cell in first.cells} == {20 * 150}
    assert {sum(times for _, times in cell.singles) for cell in other.cells} == {20 * 2}


def test_a_board_s_report_says_how_a_board_is_timed_and_nothing_of_python_s_processes(
    log: bytes, tmp_path: Path
) -> None:
    """Nor that the board was quiet, which its driver can't see."""
    (tmp_path / "LOG").write_bytes(log)
    keep(tmp_path / "LOG", tmp_path / "run", "desk")
    render(tmp_path / "run")
    short, long = ((tmp_path / "run" / f"{name}.md").read_text("utf-8") for name in ("report", "details"))
    assert "desk was timed by its driver in double precision, which can't see what else ran there" in short
    assert "generated C from the board's driver." in short
    assert re.search(r"the C's limits +\| +fixed", long)
    assert "One program in C called one method after the other" in long
    for said in ("from Python", "process of its own", "of Python on", "hypervisor", "quiet:", "## Memory"):
        assert said not in short + long, said


def test_a_board_s_report_says_what_did_not_arrive(log: bytes, tmp_path: Path) -> None:
    rows = log.splitlines(keepends=True)
    asked = next(i for i, row in enumerate(rows) if b" ask " in row and b" pinv@native " in row)
    (tmp_path / "LOG").write_bytes(b"".join(rows[: asked + 2] + rows[asked + 3 :]))
    keep(tmp_path / "LOG", tmp_path / "run", "desk")
    render(tmp_path / "run")
    short = (tmp_path / "run/report.md").read_text("utf-8")
    assert "its log is not whole: left out are pinv@native on " in short


def test_a_solver_s_own_c_on_a_board_is_no_closed_form(log: bytes, tmp_path: Path) -> None:
    """The report said so, and that the solver was called through Python."""
    (tmp_path / "LOG").write_bytes(log)
    (heard,) = boards(tmp_path / "LOG", read_board_log(tmp_path / "LOG"))
    kernels = heard.board.kernels
    kernels["nullspace@native"] = replace(kernels["nullspace@native"], solver="osqp")
    families = {line.name: line.family for line in lines(heard, "desk", "") if isinstance(line, Method)}
    assert families == {"noop": "", "nullspace@native": Family.GENERATED, "pinv@native": ""}


def test_single_precision_is_held_to_what_it_can_keep(tmp_path: Path) -> None:
    write(project("float"), tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    assert keep(tmp_path / "build/posix/LOG", tmp_path / "run").good


def test_single_precision_s_answers_on_the_edge_are_right_however_weak_a_thruster_is(tmp_path: Path) -> None:
    """Rounding of a demand, which the edge magnifies, is no fault of the C, and recommends no other."""
    sets, methods = ("active", "boundary", "infeasible"), ("nullspace@native", "scaled@native")
    write(plan(torpedo(), methods, sets, "float", "fixed", 60, 3, "none"), tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    kept = keep(tmp_path / "build/posix/LOG", tmp_path / "run")
    assert kept.good, kept.said
    (beyond,) = [
        r for r in read_run(tmp_path / "run").rows if r.formulation == "scaled" and not r.solved_fraction
    ]
    assert exact(beyond)


@pytest.mark.parametrize(
    ("ticks", "said"),
    [("return 7;", "stands still"), ("static uint32_t t; return t -= 3;", "goes backwards")],
)
def test_a_port_whose_ticks_are_nonsense_is_told(ticks: str, said: str, tmp_path: Path) -> None:
    write(project(n=3), tmp_path)
    port = tmp_path / "ports/posix.c"
    text = port.read_text()
    begin, end = text.index("    struct timespec"), text.index("}\n\nvoid board_put")
    port.write_text(text[:begin] + f"    {ticks}\n" + text[end:])
    make(tmp_path)
    done = subprocess.run([tmp_path / "build/posix/board"], capture_output=True, timeout=20)
    assert done.returncode == 1
    (tmp_path / "LOG").write_bytes(done.stdout)
    with pytest.raises(LogError, match=said):
        keep(tmp_path / "LOG", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_log_of_demands_keeps_its_rate_and_what_of_it_was_not_asked(tmp_path: Path) -> None:
    """A report opens at the rate of a user's log, and says which share of all of it is refused."""
    rows = "\n".join(f"{i / 20},{tau},0,0" for i, tau in enumerate([100, 900, 900, 900, 100, 100]))
    (tmp_path / "dive.csv").write_text(f"t,surge,sway,yaw\n{rows}\n")
    asked = ["--vehicle", "ukwial", "--method", "nullspace", "--n", "3"]
    words = ["board", *asked, "--demands", str(tmp_path / "dive.csv"), "--out", str(tmp_path)]
    written = CliRunner().invoke(cli, words)
    assert "frame frd (the file names none)" in written.output
    assert "Of dive's 6 demands only the first 3 were asked" in written.output
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    keep(tmp_path / "build/posix/LOG", tmp_path / "run")
    (said,) = usual(read_run(tmp_path / "run"))
    assert "at 20 Hz" in said
    assert "refuses 50.0 % of dive, up to 0.15" in said


def test_a_wrong_answer_is_judged_by_equations(log: bytes, tmp_path: Path) -> None:
    """A kernel that doubles its thrusts says SOLVED, and its checks sums are right."""
    write(project(n=5), tmp_path)
    adapter = tmp_path / "kernels/ukwial_nullspace/adapter.c"
    text = adapter.read_text()
    call = "CALL(ukwial_nullspace, (tau, -1, f));"
    assert call in text
    spoiled = "int status = ukwial_nullspace(tau, -1, f);\n    f[0] *= 2;\n    return status;"
    adapter.write_text(text.replace(call, spoiled))
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    kept = keep(tmp_path / "build/posix/LOG", tmp_path / "run")
    assert not kept.good
    assert any("nullspace@native on active: SOLVED, but the wrench is not met" in line for line in kept.said)


Becomes = bytes | Callable[[re.Match[bytes]], bytes]


def five_less(line: re.Match[bytes]) -> bytes:
    """A line of an answer whose first thrust is five newtons less."""
    (thrust,) = struct.unpack(">d", bytes.fromhex(line[2].decode()))
    return line[1] + struct.pack(">d", thrust - 5.0).hex().encode()


def of_method(log: bytes, method: bytes, sets: tuple[bytes, ...], what: bytes, becomes: Becomes) -> bytes:
    """The log with a pattern replaced in the answers of one method to these sets, with right checksums."""
    lines, asks = opened(log), b""
    for i, line in enumerate(lines):
        asks = line if line.startswith(b"ask ") else asks
        if line.startswith(b"f ") and method in asks and any(b" %s " % name in asks for name in sets):
            lines[i] = re.sub(what, becomes, line)
    assert sealed(lines) != log
    return sealed(lines)


@pytest.mark.parametrize(
    ("method", "names", "what", "becomes", "said"),
    [
        (
            "clip",
            (b"active", b"infeasible"),
            rb"^(f \d+ 1 \d+)( \S+){8}",  # zero is inside the limits, and PARTIAL promises no more
            rb"\1" + b" 0000000000000000" * 8,
            "makes other thrusts than Python (8 of 8 answers, first for demand 0)",
        ),
        (
            "clip",
            (b"active",),  # five newtons less on one thruster, of the first demand
            rb"^(f 0 1 \d+ )(\S+)",
            five_less,
            "makes other thrusts than Python (1 of 8 answers, first for demand 0)",
        ),
        (
            "nullspace",
            (b"inactive", b"active"),
            rb"^(f \d+) 0 ",
            rb"\1 1 ",
            "says PARTIAL for SOLVED (8 of 8 answers, first for demand 0)",
        ),
        (
            "nullspace",
            (b"boundary",),  # SOLVED and INFEASIBLE are both right there, but PARTIAL is not
            rb"^(f \d+) 0 ",
            rb"\1 1 ",
            "says PARTIAL for SOLVED",
        ),
    ],
)
def test_answers_that_no_equation_refuses_are_held_to_python_s(
    method: str,
    names: tuple[bytes, ...],
    what: bytes,
    becomes: Becomes,
    said: str,
    whole: bytes,
    tmp_path: Path,
) -> None:
    (tmp_path / "LOG").write_bytes(of_method(whole, method.encode() + b"@native", names, what, becomes))
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert not kept.good
    for name in names:
        place = f"{method}@native on {name.decode()}: "  # equations may say something of it too
        assert any(place in line and said in line for line in kept.said)
    others = [line for line in kept.said if " on " in line and not line.startswith(method)]
    assert not others


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a project with a rule of practice and the exact method printed on this computer."""
    folder = tmp_path_factory.mktemp("rules")
    asked = ("clip@native", "nullspace@native")
    write(plan(load_vehicle("bluerov2-heavy"), asked, (*SETS, "boundary"), "double", "fixed", 8, 3), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    return (folder / "build/posix/LOG").read_bytes()


@pytest.mark.parametrize(
    ("vehicle", "scalar", "limits"),
    [
        ("bluerov2", "double", "fixed"),
        ("tiburon", "double", "call"),
        ("subjugator8", "float", "fixed"),
        ("nautilus", "float", "call"),
    ],
)
def test_every_method_s_own_c_is_right_also_where_rounding_decides(
    vehicle: str, scalar: Scalar, limits: Where, tmp_path: Path
) -> None:
    """Demands of each set, and such whose T* tau lies on limits but for 1e-4 to 1e-12 of it."""
    loaded, rng = load_vehicle(vehicle), np.random.default_rng(5)
    sets = (*SETS, "boundary", "jolts")
    made = plan(loaded, tuple(own()), sets, scalar, limits, 40, 3, "none")
    taus = rng.normal(size=(40, loaded.k)) * loaded.wrench_scale
    f = taus @ generalized_inverse(loaded).T
    room = np.where(f > 0.0, loaded.f_max, -loaded.f_min) / np.maximum(np.abs(f), 1e-9)
    off = rng.choice([1e-12, 1e-11, 1e-10, 1e-6, 1e-4], 40) * rng.choice([-1.0, 1.0], 40)
    at_limits = labelled("at-limits", loaded, taus * (room.min(axis=1) * (1.0 + off))[:, None])
    write(replace(made, sets=(*made.sets, at_limits)), tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    kept = keep(tmp_path / "build/posix/LOG", tmp_path / "run")
    assert kept.good, kept.said


@pytest.fixture(scope="module")
def leveled(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """What a project with `priority`, which has levels, printed on this computer."""
    folder = tmp_path_factory.mktemp("levels")
    methods = ("priority@native", "clip@native")
    write(plan(load_vehicle("bluerov2-heavy"), methods, SETS[1:], "double", "fixed", 8, 3), folder)
    make(folder, "log", "CFLAGS=-O1 -DBOARD_PASSES=2")
    return (folder / "build/posix/LOG").read_bytes()


def test_a_log_holds_what_was_delivered_of_each_level_as_a_run_does(
    leveled: bytes, hear: Hear, tmp_path: Path
) -> None:
    """Two ways: the shares that the C wrote on the line, and those of the same method in Python."""
    (heard,) = hear(leveled)
    allocate = build("priority", heard.vehicle)
    for name, demands in heard.demands.items():
        (run,) = heard.asked["priority@native", name]
        np.testing.assert_allclose(run.shares, [allocate(tau).share for tau in demands.taus], atol=1e-12)
        assert heard.asked["clip@native", name][0].shares.shape == (8, 0)
    keep(tmp_path / "LOG", tmp_path / "run")
    cells = {(cell.key.method, cell.key.demands): cell.judged for cell in read(tmp_path / "run").cells}
    beyond, within = cells["priority@native", "infeasible"], cells["priority@native", "active"]
    assert beyond is not None
    assert within is not None
    assert min(within.share_min) >= 0.99  # of each level but the last at most 1 % is kept back
    assert len(beyond.share_p50) == 3
    assert min(beyond.share_min) < 0.99


def test_shares_that_the_thrusts_do_not_deliver_are_wrong(leveled: bytes, tmp_path: Path) -> None:
    one, half = (np.array(value, ">f8").tobytes().hex().encode() for value in (1.0, 0.5))
    lines = opened(leveled)
    spoiled = [line.replace(one, half) if line.startswith(b"f ") else line for line in lines]
    (tmp_path / "LOG").write_bytes(sealed(spoiled))
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert not kept.good
    assert any("shares of its levels that its thrusts do not deliver" in line for line in kept.said)


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
    for key, (run,) in old.asked.items():
        assert run.shares.shape[1] == 0
        np.testing.assert_array_equal(run.F, new.asked[key][0].F)
        assert run.ones == new.asked[key][0].ones


@pytest.mark.parametrize("text", [b"", b"\x00\xff" * 500, b"tb or not tb\n" * 9, b"tb 0 board 0 00000000\n"])
def test_a_foreign_log_is_refused_with_what_to_do(text: bytes, hear: Hear) -> None:
    with pytest.raises(LogError, match=r"; (give|open)"):
        hear(text)


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


def test_a_log_with_a_clock_that_says_it_has_none_is_counts_without_the_driver_s_own_method(
    log: bytes, tmp_path: Path
) -> None:
    (tmp_path / "LOG").write_bytes(forged(log, rb"ticks_per_s \d+", b"ticks_per_s 0"))
    keep(tmp_path / "LOG", tmp_path / "out")
    assert {row.method for row in read(tmp_path / "out").emulated} == set(METHODS)


def test_what_would_move_a_terminal_s_cursor_is_not_printed(log: bytes, tmp_path: Path) -> None:
    lines = opened(forged(log, rb"fact processor .*", b"fact processor \x1b[2J\x07evil"))
    lines.insert(1, b"nonsense \x1b]0;mine\x07")
    (tmp_path / "LOG").write_bytes(sealed(lines))
    try:
        said = keep(tmp_path / "LOG", tmp_path / "out").said
    except AllocError as error:
        said = [str(error)]
    assert all(line.isprintable() for line in said)
    assert "evil" in "".join(said)


def test_what_a_vehicle_does_not_have_is_left_out_and_said() -> None:
    vehicle = load_vehicle("supply-vessel")
    asked = ("walsh@native", "pinv@native", "clip@library")
    made = plan(vehicle, asked, ("active", "jolts"), "double", "fixed", 5, 0)
    assert [kernel.method for kernel in made.kernels] == ["pinv@native"]
    assert [demands.name for demands in made.sets] == ["active"]
    assert [reason.partition(":")[0] for reason in made.left_out] == ["walsh@native", "clip@library", "jolts"]
    with pytest.raises(NotApplicable, match="supply-vessel: nothing is left to ask"):
        plan(vehicle, ("walsh@native",), ("active",), "double", "fixed", 5, 0)


def test_a_log_of_one_function_for_all_faults_says_so_and_its_answers_are_judged(tmp_path: Path) -> None:
    vehicle = load_vehicle("ukwial")
    asked = plan(vehicle, (*METHODS, "walsh@native"), SETS[:1], "double", "fixed", 5, 3, "all")
    assert [reason.partition(":")[0] for reason in asked.left_out] == ["walsh@native"]
    write(asked, tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    kept = keep(tmp_path / "build/posix/LOG", tmp_path / "kept", "")
    assert kept.good
    header = read(kept.folders[0]).header
    assert header.settings["faults"] == "all"
    names = {path.parent.name: path.read_text() for path in tmp_path.glob("kernels/*/ukwial_*.c")}
    assert sorted(names) == ["ukwial_nullspace", "ukwial_pinv"]
    assert all("_all(" in text for text in names.values())


@pytest.mark.parametrize(("machine", "name"), [("mps2-an386", "cortex-m4f"), ("mps2-an500", "cortex-m7")])
def test_a_log_through_qemu_s_serial_line_has_the_plugin_s_counts(
    machine: str, name: str, tmp_path: Path
) -> None:
    """Two ways: the line, read back; and the image that `emulate` counts, whose demands come from a file."""
    board = available(name)
    scalar: Scalar = "float" if name == "cortex-m4f" else "double"
    asked = project(scalar)
    write(asked, tmp_path)
    make(tmp_path, f"PORT={machine}", "log")
    keep(tmp_path / f"build/{machine}/LOG", tmp_path / "run")
    rows = {(row.method, row.demands): row for row in read(tmp_path / "run").emulated}
    assert len(rows) == 6
    for kernel in asked.kernels:
        folder = tmp_path / kernel.entry
        folder.mkdir()
        image = link(kernel, board, folder)
        for demands in asked.sets:
            counted = count(image, kernel.calls(demands.taus, *demands.limits))
            values, calls = np.unique(counted.instructions, return_counts=True)
            row = rows[kernel.method, demands.name]
            assert row.instructions == list(zip(values.tolist(), calls.tolist(), strict=True))
            assert row.stack_bytes == counted.stack_bytes.max()
            assert row.target == name
            assert row.agrees


def filled_in(folder: Path) -> None:
    """The port for a Cortex-M as a user leaves it, who fills it in and deletes the line that says so."""
    port = folder / "ports/cortex_m.c"
    port.write_text(re.sub(r"#error .*\n", "", port.read_text()))


def test_a_port_that_nobody_filled_in_does_not_build(tmp_path: Path) -> None:
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    done = subprocess.run(
        ["make", "-C", tmp_path, "PORT=cortex-m"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode != 0
    assert "fill in what says TO FILL IN, board_put() too, then delete this line" in done.stderr


def test_the_driver_without_kernels_is_small(tmp_path: Path) -> None:
    """At most 8 KiB of flash and 2 KiB of RAM on a Cortex-M, stack included, which -fstack-usage gives."""
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    filled_in(tmp_path)
    make(tmp_path, "PORT=cortex-m", "CFLAGS=-O2 -fstack-usage")
    objects = [tmp_path / f"build/cortex-m/{name}.c.o" for name in ("driver", "ports/cortex_m")]
    printed = subprocess.run(["arm-none-eabi-size", *objects], capture_output=True, text=True, check=True)
    sizes = np.array([line.split()[:3] for line in printed.stdout.splitlines()[1:]], dtype=int)
    text, data, zeroed = sizes.sum(axis=0)
    frames = [
        int(line.split("\t")[1])
        for path in tmp_path.rglob("driver*.su")
        for line in path.read_text().splitlines()
    ]
    assert len(frames) > 5
    assert text + data <= 8192
    assert data + zeroed + sum(frames) <= 2048  # as if each function called the next


def test_other_flags_compile_what_was_compiled_with_others(tmp_path: Path) -> None:
    write(project(n=1), tmp_path)
    made = tmp_path / "build/posix/driver.c.o"
    times = []
    for flags in ("CFLAGS=-O1", "CFLAGS=-O1", "CFLAGS=-O0"):
        make(tmp_path, flags)
        times.append(made.stat().st_mtime_ns)
    assert times[0] == times[1] < times[2]


def test_a_main_as_the_page_describes_it_links_with_the_library(tmp_path: Path) -> None:
    available("cortex-m4f")
    write(project("float", n=1), tmp_path)
    filled_in(tmp_path)
    make(tmp_path, "PORT=cortex-m")
    text = '#include "board.h"\nint main(void) { board_start(); return board_run(); }\n'
    (tmp_path / "main.c").write_text(text)
    flags = "-std=c99 -Wall -Wextra -Werror -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16"
    words = f"arm-none-eabi-gcc {flags} --specs=nosys.specs main.c build/cortex-m/board.a -lm -o main.elf"
    done = subprocess.run(words.split(), cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


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
    calls = sum(times for block in log.blocks for _, times in seen(block, "one"))
    assert time.process_time() - start <= 2.0
    assert calls == 1_000_000
    assert all(len(one.F) == 200 for one in answers)
    assert log.damaged == log.lost == 0
