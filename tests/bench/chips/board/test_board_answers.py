"""A board's answers are judged by equations, and where these refuse nothing held to Python's."""

import re
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.program import Scalar, Where
from bench.chips.board.project import plan, write
from bench.chips.board.record import counts, keep, lines
from bench.chips.kernels import own
from bench.demands import labelled
from bench.demands.generated import edge_demands, numbered
from bench.record import Cell, read
from bench.results.ranking import is_exact
from bench.results.rows import read_run
from tests.board_logs import opened, sealed
from tests.board_projects import METHODS, SETS, Hear, make, printed, project
from tests.vehicle_files import torpedo


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
    assert kept.good, kept.lines
    (beyond,) = [
        r for r in read_run(tmp_path / "run").rows if r.formulation == "scaled" and not r.solved_fraction
    ]
    assert is_exact(beyond)


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
    assert any("nullspace@native on active: SOLVED, but the wrench is not met" in line for line in kept.lines)


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
        assert any(place in line and said in line for line in kept.lines)
    others = [line for line in kept.lines if " on " in line and not line.startswith(method)]
    assert not others


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
    assert kept.good, kept.lines


@pytest.mark.parametrize(("scalar", "method"), [("float", "redistribute"), ("double", "priority")])
def test_answers_that_a_clock_times_and_a_counter_counts_get_the_same_verdict(
    scalar: Scalar, method: str, tmp_path: Path, hear: Hear
) -> None:
    """On the edges of nearly symmetric vehicles, where answers differ by more than rounding explains."""
    number = {"redistribute": 4, "priority": 11}[method]
    vehicle, rng = numbered(number)
    made = plan(vehicle, (f"{method}@native",), ("infeasible",), scalar, "fixed", 2, 3, "none")
    edges = labelled("edges", vehicle, edge_demands(vehicle, rng, 60))
    (heard,) = hear(printed(tmp_path, replace(made, sets=(edges,)), 1))
    (judged,) = (line.judged for line in lines(heard, "board", "") if isinstance(line, Cell) and line.judged)
    (counted,) = counts(heard)
    assert counted.distance_rel_max > 1e-11  # not what rounding takes
    assert (counted.agrees, judged.wrong) == (True, "")


def test_a_log_holds_what_was_delivered_of_each_level_as_a_run_does(
    leveled: bytes, hear: Hear, tmp_path: Path
) -> None:
    """Two ways: the shares that the C wrote on the line, and those of the same method in Python."""
    (heard,) = hear(leveled)
    allocate = build("priority", heard.vehicle)
    for name, demands in heard.demands.items():
        (run,) = heard.runs["priority@native", name]
        np.testing.assert_allclose(run.shares, [allocate(tau).share for tau in demands.taus], atol=1e-12)
        assert heard.runs["clip@native", name][0].shares.shape == (8, 0)
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
    assert any("shares of its levels that its thrusts do not deliver" in line for line in kept.lines)


def test_a_thrust_that_is_no_number_is_said_in_a_line_and_nothing_else(log: bytes, tmp_path: Path) -> None:
    """numpy warned of it too, with lines of this project's source."""
    lines = opened(log)
    at = next(i for i, line in enumerate(lines) if line.startswith(b"f ") and b"7ff8" not in line)
    lines[at] = b" ".join([*lines[at].split()[:-4], *([b"7ff0000000000000"] * 4)])
    (tmp_path / "LOG").write_bytes(sealed(lines))
    kept = keep(tmp_path / "LOG", tmp_path / "run")
    assert not kept.good
    assert any("NaN or infinity although it says SOLVED" in line for line in kept.lines)


def test_a_log_of_one_function_for_all_faults_says_so_and_its_answers_are_judged(tmp_path: Path) -> None:
    vehicle = load_vehicle("ukwial")
    asked = plan(vehicle, (*METHODS, "walsh@native"), SETS[:1], "double", "fixed", 5, 3, "all")
    assert [reason.partition(":")[0] for reason in asked.omissions] == ["walsh@native"]
    write(asked, tmp_path)
    make(tmp_path, "log", "CFLAGS=-O1 -DBOARD_PASSES=1")
    kept = keep(tmp_path / "build/posix/LOG", tmp_path / "kept", "")
    assert kept.good
    header = read(kept.folders[0]).header
    assert header.settings["faults"] == "all"
    names = {path.parent.name: path.read_text() for path in tmp_path.glob("kernels/*/ukwial_*.c")}
    assert sorted(names) == ["ukwial_nullspace", "ukwial_pinv"]
    assert all("_all(" in text for text in names.values())
