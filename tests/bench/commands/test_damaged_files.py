"""Every file that a user brings, damaged in many ways: read, or refused with one line that names it.

Damage is seeded, so a red test is red again. ``THRUSTBENCH_FUZZ=10000`` damages each kind of file more often.
"""

import gzip
import io
import json
import os
import shutil
import sys
import traceback
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from alloc import list_vehicles, load_vehicle
from alloc.vehicle.file import find_file
from bench.__main__ import main
from bench.chips.board.project import plan, write
from bench.inputs.demand_csv import format_demands
from tests.bench.inputs.test_import import MAELSTROM, MANTA, NAUTILUS
from tests.board_logs import opened, sealed
from tests.board_projects import make
from tests.log_files import rosbag2, write_bag1, write_bag2, write_ulog
from tests.mutations import damaged, damaged_json
from tests.output_logs import write_bin, write_csv, write_outputs_ulog
from tests.places import ROOT

MANY = int(os.environ.get("THRUSTBENCH_FUZZ", "40"))
"""Damaged files of each kind; CI takes 1000."""
PICTURES = 100
"""One of so many is drawn with its pictures, which take half a second."""


class Kind(NamedTuple):
    """A kind of file.

    Attributes
    ----------
    good : function of a folder that writes undamaged files into it and returns them
    harm : function of a file's bytes and a generator that returns the damaged bytes
    commands : command lines that read ``{file}``, named ``{stem}``, in ``{folder}``; ``{run}`` holds a run
    codes : exit codes of a file that was read
    """

    good: Callable[[Path], list[Path]]
    harm: Callable[[bytes, np.random.Generator], bytes]
    commands: tuple[str, ...]
    codes: tuple[int, ...] = (0,)


def texts(**files: str) -> Callable[[Path], list[Path]]:
    def write(folder: Path) -> list[Path]:
        paths = []
        for name, text in files.items():
            stem, _, suffix = name.rpartition("_")
            paths.append(folder / f"{stem}.{suffix}")
            paths[-1].write_text(text, encoding="utf-8")
        return paths

    return write


def vehicles(folder: Path) -> list[Path]:
    for name in list_vehicles():
        vehicle = load_vehicle(name)
        (folder / f"{name}.csv").write_text(format_demands(None, np.eye(vehicle.k), vehicle.dof))
    return [Path(shutil.copy(find_file(name), folder)) for name in list_vehicles()]


def log(write: Callable[..., Path], **options: Any) -> Callable[[Path], list[Path]]:
    def good(folder: Path) -> list[Path]:
        taus = np.random.default_rng(0).uniform(-400, 400, (6, 6)).astype(np.float32).astype(float)
        made = write(folder, np.arange(6) / 50, taus, **options)
        return sorted(path for path in made.iterdir()) if made.is_dir() else [made]

    return good


def as_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    return damaged(data, rng, binary=True)


def as_json(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.integers(4) == 0:
        return damaged(data, rng)
    return json.dumps(damaged_json(json.loads(data), rng)).encode()


def as_record(data: bytes, rng: np.random.Generator) -> bytes:
    """One line of the record damaged; the others stay, so that the damage reaches what reads them."""
    lines = data.splitlines(keepends=True)
    i = int(rng.integers(len(lines)))
    lines[i] = as_json(lines[i], rng).rstrip() + b"\n"
    return b"".join(lines)


def as_packed(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.integers(2):
        return as_bytes(data, rng)
    return gzip.compress(as_record(gzip.decompress(data), rng))


def record(folder: Path) -> list[Path]:
    """Lines of committed runs, one or two of each kind, with lists cut short."""
    lines: dict[tuple[str, ...], dict[str, Any]] = {}
    for kept in ("amd-epyc-2-cores", "emulated"):
        with gzip.open(ROOT / "results" / kept / "record.jsonl.gz") as file:
            for text in file:
                line = json.loads(text)
                kind, key = line["type"], line.get("key", {})
                if line.get("vehicle", key.get("vehicle")) in (None, "-", "ukwial"):
                    name = key.get("method", line.get("name", line.get("method", "")))
                    if kind != "header" and name not in ("", "canary/loop", "pinv", "qp/osqp", "pinv@native"):
                        continue
                    lines.setdefault((kind, name, key.get("demands", "")[:6]), line)
    shortened = [_shortened(line) for line in lines.values()]
    path = folder / "record.jsonl"
    path.write_bytes(b"".join(json.dumps(line).encode() + b"\n" for line in shortened))
    return [path]


def _shortened(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _shortened(part) for key, part in value.items()}
    return [_shortened(part) for part in value[:8]] if isinstance(value, list) else value


def packed(folder: Path) -> list[Path]:
    (path,) = record(folder)
    small = folder / "record.jsonl.gz"
    small.write_bytes(gzip.compress(path.read_bytes()))
    path.unlink()
    return [small]


def board_log(folder: Path) -> list[Path]:
    """Output of a project of two methods, one with levels, on this computer."""
    asked = ("priority@native", "pinv@native")
    write(
        plan(load_vehicle("ukwial"), asked, ("active", "infeasible"), "double", "fixed", 4, 0), folder / "c"
    )
    make(folder / "c", "log", "CFLAGS=-O1 -DBOARD_PASSES=3")
    return [Path(shutil.copy(folder / "c/build/posix/LOG", folder))]


def as_log(data: bytes, rng: np.random.Generator) -> bytes:
    """Damaged on the line; or made by hand and sealed again, so that the damage reaches what reads blocks."""
    if rng.integers(3) == 0:
        return damaged(data, rng)
    lines = opened(data)
    i = int(rng.integers(len(lines)))
    lines[i] = damaged(lines[i], rng).replace(b"\n", b" ")
    return sealed(lines)


CSV = "surge,sway,yaw\n" + "".join(f"{i},{-i / 3},{i * 1e-3}\n" for i in range(8))
TIMED = "t,yaw,surge,sway\n" + "".join(f"{i / 50},{i},{-i / 3},1e-3\n" for i in range(8))
TAM = "tam: [[1, 1, 0.5], [0, 1, -1], [0, 0, 0], [0, 0, 0], [0, 0, 0], [-1, 1, 0.2]]\nmax_thrust: 40\n"
PX4 = "".join(
    f"param set-default CA_ROTOR{i}_{key} {value}\n"
    for i, numbers in enumerate([(0.1, 0.2, 1.5), (-0.1, 0.3, 2), (0.2, -0.4, 1), (0.3, 0.1, 1)])
    for key, value in zip(("PX", "PY", "CT"), numbers, strict=True)
)
MATRIX = "dof,f0,f1,f2\nsurge,1,1,0.5\nsway,0,1,-1\nyaw,-1,1,0.2\n"
CANARY = '{"canary_schema": 1, "machine": {"cpu": "a"}, "median_us": {"canary/loop": 5.8, "canary/dot": 1.1}}'
BENCHMARKS = json.dumps(
    {
        "machine_info": {"cpu": {"brand_raw": "a", "count": 2}, "node": "b", "python_version": "3"},
        "benchmarks": [{"fullname": "x", "stats": {"min": 1.0, "median": 2.0}, "extra_info": {"calls": 10}}],
    }
)

DEMANDS = ("demands|{file}|--vehicle|ukwial",)
IMPORT = ("import|{file}|--f-min|-20|--f-max|20|-o|{folder}/made.yaml",)
READ = ("board|--read|{file}|--out|{folder}/read",)
RUN = ("report|{folder}", "size|{folder}|--rate|50|--all")
OUTPUTS = ("demands|{file}|--vehicle|bluerov2-heavy|--from-outputs",)
ESC_AS_C = "--method|pinv|--faults|none|--esc|--out|{folder}/c"


def outputs(write: Callable[..., Path]) -> Callable[[Path], list[Path]]:
    """A log of twenty outputs."""

    def written(folder: Path) -> list[Path]:
        t = np.arange(20) * 0.1
        u = np.linspace(1150, 1850, 160).reshape(20, 8).astype(int)
        return [
            write(folder, t, u, np.full(20, 15.5), np.zeros((20, 6 if write is write_outputs_ulog else 3)))
        ]

    return written


ESC = """\
esc:
  neutral: 1500
  range: [1100, 1900]
  step: 1
  reversed: [b]
  dead_band: jump
  curve: {16: [[1100, -40], [1472, 0], [1528, 0], [1900, 51]], 12: [[1100, -29], [1500, 0], [1900, 36]]}
  volts: 16
"""
WIRED = "name: wired\ndof: [surge, yaw]\nT: [[1, 1], [0.2, -0.2]]\nnames: [a, b]\n"
CURVE = "command,kgf,volts\n" + "".join(
    f"{u},{(u - 1500) / 80 * v / 16:.3g},{v}\n" for v in (12, 16) for u in range(1100, 1901, 100)
)


def curve(folder: Path) -> list[Path]:
    """A CSV that a vehicle file beside it names."""
    (folder / "wired.yaml").write_text(
        WIRED + ESC.replace(ESC[ESC.index("{") : ESC.index("}") + 1], "curve.csv")
    )
    (folder / "curve.csv").write_text(CURVE)
    return [folder / "curve.csv"]


KINDS = {
    "vehicle": Kind(
        vehicles,
        damaged,
        ("check|{file}|--no-picture", "allocate|/dev/null|--vehicle|{file}|--method|nullspace"),
    ),
    "esc": Kind(
        texts(wired_yaml=WIRED + ESC),
        damaged,
        (
            "check|{file}|--no-picture",
            "allocate|/dev/null|--vehicle|{file}|--method|nullspace|--esc",
            f"codegen|--vehicle|{{file}}|{ESC_AS_C}",
        ),
    ),
    "curve csv": Kind(
        curve,
        damaged,
        (
            "check|{folder}/wired.yaml|--no-picture",
            f"codegen|--vehicle|{{folder}}/wired.yaml|{ESC_AS_C}",
        ),
    ),
    "demand csv": Kind(
        texts(a_csv=CSV, b_csv=TIMED), damaged, (*DEMANDS, "allocate|{file}|--vehicle|ukwial|--method|pinv")
    ),
    "ros 1 bag": Kind(log(write_bag1), as_bytes, DEMANDS),
    "ros 2 bag": Kind(log(write_bag2), as_bytes, DEMANDS),
    "mcap bag": Kind(log(write_bag2, plugin=rosbag2.StoragePlugin.MCAP), as_bytes, DEMANDS),
    "ulog": Kind(log(write_ulog), as_bytes, DEMANDS),
    "outputs csv": Kind(outputs(write_csv), damaged, OUTPUTS),
    "outputs ulog": Kind(outputs(write_outputs_ulog), as_bytes, OUTPUTS),
    **({"outputs dataflash": Kind(outputs(write_bin), as_bytes, OUTPUTS)} if find_spec("pymavlink") else {}),
    "import csv": Kind(texts(T_csv=MATRIX), damaged, IMPORT),
    "import px4": Kind(texts(a_params=PX4), damaged, IMPORT),
    "import ros": Kind(texts(a_yaml=NAUTILUS, b_yaml=MAELSTROM, c_yaml=MANTA), damaged, IMPORT),
    "import tam": Kind(texts(TAM_yaml=TAM), damaged, IMPORT),
    "record": Kind(record, as_record, RUN),
    "packed record": Kind(packed, as_packed, RUN[1:]),
    "board log": Kind(board_log, as_log, READ, codes=(0, 1)),  # 1: answers that are wrong
    "canary": Kind(texts(a_json=CANARY), as_json, ("size|{run}|--rate|50|--canary|{file}",)),
    "benchmarks": Kind(texts(a_json=BENCHMARKS), as_json, ("compare|{file}|{file}",)),
}


def outcome(line: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command line; a traceback is raised."""
    sys.argv = ["thrustbench", *line.split("|")]
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        try:
            main()
        except SystemExit as ended:
            return int(ended.code or 0), out.getvalue(), err.getvalue()
    raise AssertionError("main returned")


@pytest.fixture(autouse=True)
def arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", sys.argv)


@pytest.mark.timeout(0)
@pytest.mark.parametrize("name", KINDS)
def test_a_damaged_file_is_read_or_refused_with_one_line(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither a traceback, nor a warning, nor a line beside the one, whatever numbers a file holds."""
    kind = KINDS[name]
    folder, run = tmp_path / "good", tmp_path / "run"
    folder.mkdir()
    run.mkdir()
    record(run)
    good = kind.good(folder)
    whole = [path.read_bytes() for path in good]
    accepted, found = 0, dict[str, str]()
    for i in range(MANY):
        rng = np.random.default_rng([i, *name.encode()])
        which = int(rng.integers(len(good)))
        file = good[which]
        file.write_bytes(kind.harm(whole[which], rng))
        for command in kind.commands:
            line = command.format(file=file, stem=file.stem, folder=folder, run=run)
            if i % PICTURES == 0:
                line = line.replace("--no-picture", f"--picture|{folder}/drawn.svg")
            with monkeypatch.context() as patch:
                if i % PICTURES:
                    patch.setattr("bench.report.draw_all", lambda *_: frozenset())
                try:
                    code, _, err = outcome(line)
                except Exception as error:
                    place = traceback.extract_tb(error.__traceback__)[-1]
                    what = f"{type(error).__name__}: {error} in {place.filename}:{place.lineno}"
                else:
                    read = code in kind.codes
                    what = "" if read or (code, err.count("\n")) == (2, 1) else f"{code}: {err}"
                    accepted += read
            if what and what not in found:
                kept = Path(shutil.copy(file, tmp_path / f"{i}-{file.name}"))
                found[what] = f"damage {i}, kept as {kept}: thrustbench {line}"
        file.write_bytes(whole[which])
    assert not found, "\n".join(f"{what}\n    {where}" for what, where in found.items())
    assert 0.02 * MANY < accepted < 0.98 * MANY * len(kind.commands), "too little damage, or too much"
    assert capfd.readouterr() == ("", ""), "a library printed beside Python's streams"
