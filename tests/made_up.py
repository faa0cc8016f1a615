"""A small made-up record for tests of what reads records: numbers that can be worked out by hand."""

from pathlib import Path
from typing import Any

import msgspec

from bench.record import SCHEMA, Batch, Cell, Header, Judged, Key, Line, Problem, Worker


def header(**changes: Any) -> Header:
    machine = {"id": "made-up", "cpu": "Example CPU", "cores": 2}
    return msgspec.structs.replace(
        Header(SCHEMA, "2026-01-01T00:00:00Z", "0" * 40, 1, machine, {"python": "3.11.7"}, {}), **changes
    )


def cell(method: str = "pinv", us: int = 1, **changes: Any) -> Cell:
    """A cell that takes ``us`` µs a call in its middle batch, and 1 … 20,000 ns singly, once each."""
    made = Cell(
        Key("ukwial", "inactive", method),
        "ok",
        formulation="unlimited",
        n_demands=10,
        setup_ns=[5_000, 7_000, 6_000],
        batches=[Batch(100, us * calls * 100_000, us * calls * 90_000, 0) for calls in (1, 2, 1)],
        singles=[(ns, 1) for ns in range(1, 20_001)],
        judged=Judged(10, {"SOLVED": 9, "INFEASIBLE": 1}, [0.5, None, 2.0], agrees=True, distance_max_N=1e-7),
    )
    return msgspec.structs.replace(made, **changes)


def problem(vehicle: str, n: int) -> Problem:
    """A set of ten active demands on a planar vehicle of n thrusters."""
    dof = ["surge", "sway", "yaw"]
    return Problem(
        vehicle, "active", 10, {"active": 10}, None, "nullspace", dof, n, 3, n - 3, 50.0, [100.0, 100.0, 50.0]
    )


def exact_cell(vehicle: str, method: str, us: float) -> Cell:
    """A cell whose answers are the hard optimum, ``us`` a call."""
    ns = round(us * 1000)
    judged = Judged(10, {"SOLVED": 10}, agrees=True, distance_rel_max=1e-12, tolerance=1e-9)
    return Cell(
        Key(vehicle, "active", method),
        "ok",
        formulation="hard",
        batches=[Batch(100, 100 * ns, 100 * ns, 0)],
        allocator_bytes=1000,
        judged=judged,
    )


def record(directory: Path, *lines: Line) -> Path:
    """Write a record of these lines, header first, into the folder; returns the folder."""
    encoded = (msgspec.json.encode(line) + b"\n" for line in lines)
    (directory / "record.jsonl").write_bytes(b"".join(encoded))
    return directory


def whole(directory: Path) -> Path:
    """A record with one row of every kind."""
    failed = cell("qp/gone", status="crashed", reason="signal 11", batches=[], singles=[], judged=None)
    wrong = cell("clip", judged=Judged(10, {"SOLVED": 10}, [3.0], agrees=False, wrong="wrench missed by 3 N"))
    workers = [
        Worker(method, "-", "-", 0, 10**8, 10**7, 60_000_000) for method in ("pinv", "qp/osqp", "clip")
    ]
    osqp = cell("qp/osqp", 20, key=Key("ukwial", "inactive", "qp/osqp", "warm", "tight"))
    return record(directory, header(), *workers, cell(), osqp, failed, wrong)
