"""Small made-up records for tests of readers, with numbers that can be worked out by hand."""

from pathlib import Path
from typing import Any

import msgspec

from bench.record import (
    SCHEMA,
    Authority,
    Batch,
    Capability,
    Cell,
    Header,
    Judged,
    Key,
    Line,
    Loss,
    Method,
    Problem,
    Served,
    Worker,
)
from bench.results.rows import Run, read_run


def header(**changes: Any) -> Header:
    machine = {"id": "made-up", "cpu": "Example CPU", "cores": 2}
    return msgspec.structs.replace(
        Header(
            schema=SCHEMA,
            started="2026-01-01T00:00:00Z",
            commit="0" * 40,
            seed=1,
            machine=machine,
            versions={"python": "3.11.7"},
            settings={},
        ),
        **changes,
    )


def cell(method: str = "pinv", us: int = 1, **changes: Any) -> Cell:
    """A cell whose median batch takes ``us`` µs a call, with single calls of 1 … 20,000 ns, one each."""
    made = Cell(
        key=Key("ukwial", "inactive", method),
        status="ok",
        formulation="unlimited",
        n_demands=10,
        setup_ns=[5_000, 7_000, 6_000],
        batches=[Batch(100, us * calls * 100_000, us * calls * 90_000, 0) for calls in (1, 2, 1)],
        singles=[(ns, 1) for ns in range(1, 20_001)],
        judged=Judged(
            answers=10,
            counts={"SOLVED": 9, "INFEASIBLE": 1},
            wrench_error_max=[0.5, None, 2.0],
            agrees=True,
            distance_max_N=1e-7,
        ),
    )
    return msgspec.structs.replace(made, **changes)


def problem(
    vehicle: str, n: int = 4, *, whole: str = "", fault: int | None = None, study: str = ""
) -> Problem:
    """A set of ten active demands on a planar vehicle of n thrusters, with one of them off or none."""
    return Problem(
        vehicle=vehicle,
        whole=whole or vehicle,
        faults=[] if fault is None else [(fault, 0.0)],
        study=study,
        demands="active",
        n_demands=10,
        labels={"active": 10},
        rate_hz=None,
        reference="nullspace",
        dof=["surge", "sway", "yaw"],
        n=n,
        rank=3,
        nullity=n - 3,
        f_scale=50.0,
        wrench_scale=[100.0, 100.0, 50.0],
    )


def solver(name: str) -> Method:
    """A method that calls a QP solver."""
    return Method(name=name, formulation="hard", family="QP solver, live", solver="daqp", foreign=True)


def exact_cell(vehicle: str, method: str, us: float) -> Cell:
    """A cell whose answers are the hard optimum, ``us`` a call."""
    ns = round(us * 1000)
    judged = Judged(answers=10, counts={"SOLVED": 10}, agrees=True, distance_rel_max=1e-12, tolerance=1e-9)
    return Cell(
        key=Key(vehicle, "active", method),
        status="ok",
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


def run(directory: Path, *lines: Line, **header_changes: Any) -> Run:
    """The run of a record of these lines in the folder."""
    return read_run(record(directory, header(**header_changes), *lines))


def judge(cell: Cell, **changes: Any) -> Cell:
    """The cell, judged otherwise."""
    return msgspec.structs.replace(cell, judged=msgspec.structs.replace(cell.judged, **changes))


def rename(cell: Cell, **changes: Any) -> Cell:
    """The cell under another key."""
    return msgspec.structs.replace(cell, key=msgspec.structs.replace(cell.key, **changes))


def worker(method: str, **changes: Any) -> Worker:
    """A process that measured a method, with a peak of 60 MB."""
    key: dict[str, Any] = {"method": method, "start": "-", "level": "-", "repeat": 0}
    made = Worker(**key, import_ns=10**7, peak_rss_bytes=60_000_000)
    return msgspec.structs.replace(made, **changes)


def capability(vehicle: str = "ukwial", **changes: Any) -> Capability:
    """Capability of a planar vehicle of full rank that no method was counted on."""
    ends: dict[str, Any] = {"axis_min": [-3.0, -2.0, -1.0], "axis_max": [3.0, 2.0, 1.0]}
    shares = {"volume_share": 1.0, "closed_form_share": 0.625, "safe_share": 0.555}
    healthy = Authority(fault=None, vehicle=vehicle, rank=3, condition=1.0, **shares, **ends)
    dof = ["surge", "sway", "yaw"]
    made = Capability(vehicle=vehicle, dof=dof, authority=[healthy], served=[], curves=[], planes=[])
    return msgspec.structs.replace(made, **changes)


def served(method: str, share: int, n: int = 100, **changes: Any) -> Served:
    """Share of n demands that a method serves."""
    return msgspec.structs.replace(
        Served(fault=None, method=method, n_demands=n, within_1pct=share, within_5pct=share), **changes
    )


def loss(n: int, missed: float, **changes: Any) -> Loss:
    """Worst of n demands that all got thrusts."""
    return msgspec.structs.replace(
        Loss(n_demands=n, n_answers=n, missed_max=missed, turned_max_deg=100 * missed), **changes
    )


def whole(directory: Path) -> Path:
    """A record with a cell of every outcome: ok, crashed, and judged wrong."""
    failed = cell("qp/gone", status="crashed", reason="signal 11", batches=[], singles=[], judged=None)
    wrong = cell(
        "clip",
        judged=Judged(
            answers=10,
            counts={"SOLVED": 10},
            wrench_error_max=[3.0],
            agrees=False,
            wrong="wrench missed by 3 N",
        ),
    )
    workers = [worker(method) for method in ("pinv", "qp/osqp", "clip")]
    osqp = cell("qp/osqp", 20, key=Key("ukwial", "inactive", "qp/osqp", start="warm", level="tight"))
    return record(directory, header(), *workers, cell(), osqp, failed, wrong)
