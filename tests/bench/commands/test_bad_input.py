"""A wrong argument or file ends a command soon, with exit code 2 and one line on standard error."""

import os
import pkgutil
import shlex
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from bench import commands
from bench.__main__ import cli, main
from tests.made_up import cell, header, record
from tests.places import ROOT

GOOD = "surge,sway,yaw\n1,2,3\n"
ALLOCATE = "allocate|good.csv|--vehicle|ukwial|--method"
CODEGEN = "codegen|--vehicle|ukwial|--method"
IMPORT = "import|TAM.yaml|--f-min|-1|--f-max|1"
TAM = "tam: [[1, 1], [0, 0], [0, 0], [0, 0], [0, 0], [-1, 1]]\n"


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: a good demand file, a good TAM and many bad files."""
    (tmp_path / "good.csv").write_text(GOOD)
    (tmp_path / "TAM.yaml").write_text(TAM)
    (tmp_path / "nan.csv").write_text("surge,sway,yaw\n1,nan,3\n")
    (tmp_path / "wide.csv").write_text("surge,sway,yaw\n1,2,3,4\n")
    (tmp_path / "other.csv").write_text("surge,heave\n1,2\n")
    (tmp_path / "ned.csv").write_text("# NED\nsurge,sway,yaw\n1,2,3\n")
    (tmp_path / "slow.csv").write_text("t,surge,sway,yaw\n0,1,2,3\n100,1,2,3\n200,1,2,3\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "broken.yaml").write_text("name: [\n")
    (tmp_path / "tagged.yaml").write_text("name: !!python/object/apply:os.system [ls]\n")
    (tmp_path / "broken.py").write_text("def build(:\n")
    (tmp_path / "empty.py").write_text("")
    (tmp_path / "unbuilt.py").write_text("def build(vehicle):\n    raise RuntimeError('no')\n")
    (tmp_path / "divides.py").write_text("def build(vehicle):\n    return lambda tau: 1 / 0\n")
    (tmp_path / "no-curve.yaml").write_text(
        "name: v\ndof: [surge]\nT: [[1]]\nesc: {neutral: 0, range: [-1, 1], curve: gone.csv}\n"
    )
    (tmp_path / "exits.py").write_text("import sys; sys.exit(0)\n")
    (tmp_path / "fake.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(50))
    (tmp_path / "fake.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(50))
    (tmp_path / "good.py").write_text("from alloc.methods.pinv import FORMULATION, build\n")
    for name, benchmark in (
        ("latin.json", b'"fullname": "\xff", "stats": {"min": 1, "median": 1}'),
        ("calls.json", b'"fullname": "a", "stats": {"min": 1, "median": 1}, "extra_info": {"calls": 0}'),
        ("zero.json", b'"fullname": "a", "stats": {"min": 0, "median": 1}'),
    ):
        (tmp_path / name).write_bytes(b'{"machine_info": {}, "benchmarks": [{' + benchmark + b"}]}")
    (tmp_path / "study.yaml").write_text(
        "base: ukwial\ngroups: {bow: {thrusters: [0, 1], azimuth_deg: [9, 5]}}\n"
    )
    (tmp_path / "misspelt.yaml").write_text("base: ukwial\ngroups: {bow: {thruster: [0, 1]}}\n")
    (tmp_path / "folder").mkdir()
    (tmp_path / "blocked" / "results.csv").mkdir(parents=True)
    record(tmp_path / "blocked", header(), cell())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refusal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, line: str) -> str:
    """The one line with which the program refuses a command line."""
    monkeypatch.setattr(sys, "argv", ["thrustbench", *line.split("|")])
    start = time.process_time()
    with pytest.raises(SystemExit) as ended:
        main()
    message = capsys.readouterr().err
    assert time.process_time() - start < 5
    assert ended.value.code == 2, message
    assert message.count("\n") == 1, message
    assert "Traceback" not in message
    return message


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("fly", "No such command 'fly'"),
        ("allocate", "Missing"),
        (f"{ALLOCATE}|pinv|--speed", "No such option"),
        (f"{ALLOCATE}|pinv|--method|clip", "allocate: --method takes one value; 2 are given"),
        ("run|--method", " run: Option '--method' requires an argument; see "),
        ("board|--vehicle|ukwial|--vehicle|tiburon", "board: --vehicle takes one value; 2 are given"),
        ("allocate|good.csv|--vehicle|yellow|--method|pinv", "no vehicle 'yellow'; there are bluerov2"),
        ("allocate|good.csv|--vehicle|broken.yaml|--method|pinv", "broken.yaml, line 2: not valid YAML"),
        ("allocate|good.csv|--vehicle|tagged.yaml|--method|pinv", "tagged.yaml, line 1: tag"),
        ("allocate|good.csv|--vehicle|gone.yaml|--method|pinv", "gone.yaml: can't be read (no such file"),
        ("allocate|good.csv|--vehicle|folder|--method|pinv", "folder: can't be read (is a directory)"),
        (f"{ALLOCATE}|magic", "no method 'magic'; there are ardusub"),
        (f"{ALLOCATE}|qp/gurobi", "no method 'qp/gurobi'"),
        ("allocate|good.csv|--vehicle|bluerov2|--method|pinv", "no column 'heave'"),
        ("allocate|gone.csv|--vehicle|ukwial|--method|pinv", "gone.csv: can't be read (no such file"),
        ("allocate|folder|--vehicle|ukwial|--method|pinv", "folder: not a bag, as it has no metadata.yaml"),
        ("allocate|nan.csv|--vehicle|ukwial|--method|pinv", "nan.csv, line 2: sway is 'nan'"),
        ("allocate|ned.csv|--vehicle|ukwial|--method|pinv", "ned.csv: line 1: '# NED' may state a frame"),
        ("allocate|wide.csv|--vehicle|ukwial|--method|pinv", "wide.csv, line 2: got 4 cells, expected 3"),
        (
            "allocate|other.csv|--vehicle|ukwial|--method|pinv",
            "line 1: no column 'sway' or 'yaw' among surge, heave",
        ),
        ("allocate|empty.csv|--vehicle|ukwial|--method|pinv", "the file is empty"),
        ("allocate|binary.csv|--vehicle|ukwial|--method|pinv", "not UTF-8"),
        (f"{ALLOCATE}|walsh|--fault|9", "there is no thruster 9; count from 0 to 3"),
        (f"{ALLOCATE}|walsh|--fault|0@0.5", "thruster 0 is weakened"),
        (f"{ALLOCATE}|pinv|--fault|x", "no thruster has the name 'x'"),
        (f"{ALLOCATE}|pinv|--fault|0@nan", ""),
        (f"{ALLOCATE}|pinv|--fault|0@2", "readiness"),
        ("allocate|good.csv|--vehicle|nautilus|--method|walsh", "no column 'heave'"),
        (f"{ALLOCATE}|qp/daqp|--start|hot", "qp/daqp has no start 'hot'"),
        (f"{ALLOCATE}|pinv|--level|tight", "pinv has no level 'tight'"),
        (f"{ALLOCATE}|m|--plugin|broken.py", "broken.py: can't be imported"),
        (f"{ALLOCATE}|m|--plugin|empty.py", "empty.py: has no build(vehicle)"),
        (f"{ALLOCATE}|m|--plugin|gone.py", "gone.py"),
        (f"{ALLOCATE}|pinv|-o|no/where.csv", "no/where.csv: can't be written"),
        (f"{ALLOCATE}|pinv|-o|folder", "folder: can't be written"),
        (f"{ALLOCATE}|pinv|-o|/dev/full", "/dev/full: can't be written (no space"),
        (f"{ALLOCATE}|pinv|--plugin|good.py", "good.py: holds method 'good', not 'pinv'; give --method good"),
        (f"{ALLOCATE}|unbuilt|--plugin|unbuilt.py", "unbuilt.py: line 2: RuntimeError: no"),
        (f"{ALLOCATE}|divides|--plugin|divides.py", "divides.py: line 2: ZeroDivisionError"),
        (f"{ALLOCATE}|qp/osqp|--level|perfect", "qp/osqp has no level 'perfect'"),
        (f"{ALLOCATE}|pinv|--esc", "ukwial: has no ESCs for --esc; add 'esc' to its file"),
        (
            "demands|good.csv|--vehicle|ukwial|--from-outputs",
            "ukwial: has no ESCs for --from-outputs; add 'esc'",
        ),
        (f"{CODEGEN}|svd|--out|out", "no kernel 'svd'"),
        (f"{CODEGEN}|pinv|--esc|--out|out", "ukwial: has no ESCs; add 'esc' to its file"),
        (f"{CODEGEN}|pinv|--noise|4|--out|out", "--noise is of --monitor; give that too"),
        (f"{CODEGEN}|pinv|--lasting|4|--out|out", "--lasting is of --monitor; give that too"),
        (f"{CODEGEN}|pinv|--monitor|--lasting|0|--out|out", "--lasting: got 0 calls, expected 1 or more"),
        (f"{CODEGEN}|pinv|--monitor|--lasting|nan|--out|out", "--lasting: got nan calls, expected 1 or more"),
        (f"{CODEGEN}|pinv|--monitor|--noise|1e-9|--out|out", "--noise: surge: got 1e-09 N"),
        (f"{CODEGEN}|pinv|--out|/dev/null/here", "give another --out"),
        (f"{CODEGEN}|walsh|--faults|all|--out|out", "leave out --faults all"),
        ("codegen|--vehicle|titanic|--method|pinv|--out|out", "no vehicle 'titanic'"),
        ("codegen|--vehicle|supply-vessel|--method|walsh|--out|out", "walsh: supply-vessel"),
        ("check|gone.yaml", "gone.yaml: can't be read"),
        ("check|ukwial|--noise|1", "--noise, --demands and -o are of --failures; give that too"),
        ("check|ukwial|--failures|--columns|t=x", "--topic are of --demands; give that too"),
        ("check|ukwial|--demands|a.csv", "--noise, --demands and -o are of --failures; give that too"),
        (
            "check|ukwial|--failures|--noise|1,2",
            "--noise has 2 factors, expected one, or one for each of surge",
        ),
        (
            "check|ukwial|--failures|--demands|slow.csv",
            "slow.csv: t: 100 s between rows, expected at most 60",
        ),
        ("check|ukwial|--failures|--noise|0", "--noise '0': give one number above 0"),
        ("check|ukwial|--failures|--json", "--failures is text, and a CSV with -o; leave out --json"),
        ("check|ukwial|--fit-current|good.csv", "ukwial: has no ESCs for --fit-current; add 'esc'"),
        ("check|bluerov2|--fit-current|good.csv|--json", "--fit-current is text; leave out --json"),
        ("check|bluerov2|--fit-current|gone.bin", "gone.bin"),
        ("check|no-curve.yaml", "no-curve.yaml: esc: gone.csv: can't be read"),
        ("check|binary.csv", "binary.csv, line 2: not UTF-8 text; give"),
        ("import|TAM.yaml|-o|ours.yaml", "no limits in it; give --f-min and --f-max"),
        ("import|TAM.yaml|--f-min|nan|--f-max|1", "f_min holds NaN"),
        ("import|TAM.yaml|--f-min|3|--f-max|1", "exceeds"),
        ("import|TAM.yaml|--f-min|x|--f-max|1", "'x' is not a valid float"),
        (f"{IMPORT}|--dof|up,down", "dof: got 'up', expected some of surge"),
        (f"{IMPORT}|--name|a/b", "name: give 1 to 60"),
        (f"{IMPORT}|--format|blueprint", "no format 'blueprint'"),
        (f"{IMPORT}|-o|no/where.yaml", "can't be written"),
        ("import|folder", "is a directory"),
        ("import|TAM.yaml|--limits|TAM.yaml", "has no tam with min_thrust"),
        ("import|TAM.yaml|--limits|gone.yaml", "gone.yaml"),
        ("import|binary.csv", "not UTF-8"),
        ("export|ukwial|--format|docx", "can't write format 'docx'; there are ardusub-matrix, csv, px4, ros"),
        ("export|ukwial|--format|csv|-o|/dev/full", "no space left"),
        ("export|ukwial", "give VEHICLE --format F, or --problems --out DIR"),
        ("export|ukwial|--format|csv|--n|3", "give VEHICLE --format F, or --problems --out DIR"),
        ("export|ukwial|--problems|--out|out", "--problems takes --out DIR and no vehicle"),
        ("export|--problems", "--problems takes --out DIR and no vehicle"),
        ("export|--problems|--out|good.csv", "good.csv: file exists"),
        ("demands|gone.bag|--vehicle|ukwial", "no such file"),
        ("demands|fake.bag|--vehicle|ukwial", "not a bag"),
        ("demands|fake.ulg|--vehicle|ukwial", "fake.ulg: "),
        ("demands|folder|--vehicle|ukwial", "not a bag"),
        ("demands|good.csv|--vehicle|ukwial|--scale|1,2", "--scale has 2 factors, expected one"),
        ("demands|good.csv|--vehicle|ukwial|--scale|0", "--scale '0': give one number above 0"),
        (f"{ALLOCATE}|pinv|--scale|1,-1,1", "give one number above 0"),
        ("demands|good.csv|--vehicle|ukwial|--frame|up", "'up' is not one of"),
        ("run|--vehicle|yellow|--out|out", "no vehicle 'yellow'"),
        ("run|--method|magic|--out|out", "no method 'magic'"),
        ("run|--demands|magic|--out|out", "no demand set 'magic'"),
        ("run|--vehicle|ukwial|--demands|nan.csv|--out|out", "sway is 'nan'"),
        ("run|--repeats|0", "0 is not in the range"),
        ("run|--n|many", "'many' is not a valid integer"),
        ("run|--n|99999999999999|--out|out", "out of memory; ask for fewer demands"),
        ("run|--vehicle|ukwial|--method|pinv|--out|good.csv", "good.csv"),
        ("run|--budget-ms|500|--time-limit|0.5|--out|out", "--budget-ms 500: no cell can be timed"),
        ("run|--plugin|exits.py|--out|out", "exits.py: can't be imported (SystemExit"),
        ("run|--study|growth|--quick", "give one of --study, --quick and --all"),
        ("prove|--vehicle|yellow|--out|out", "no vehicle 'yellow'"),
        ("prove|--vehicle|ukwial|--method|magic|--out|out", "no kernel 'magic'"),
        ("prove|--vehicle|nautilus|--method|walsh|--out|out", "are not +-equal"),
        ("gate|HEAD|--repo|good.csv", "Directory 'good.csv' is a file"),
        ("gate|HEAD|--plugin|folder", "File 'folder' is a directory"),
        ("report|blocked", "blocked/results.csv: is a directory"),
        ("report|gone", "gone"),
        ("report|folder", "folder"),
        ("size|folder|--rate|50", "folder"),
        ("size|folder|--rate|nan", "nan is not a finite number"),
        ("size|folder|--rate|inf", "inf is not a finite number"),
        ("size|folder|--rate|-1", "-1.0 is not in the range"),
        ("size|folder|--rate|50|--clock|nan", "nan is not a finite number"),
        ("size|folder|--rate|50|--cpi|3|1", "--cpi 3 1: give the lower number first"),
        ("run|--time-limit|inf", "inf is not a finite number"),
        ("run|--memory|99999999999", "is not in the range"),
        ("gate|HEAD|--threshold|nan", "nan is not a finite number"),
        ("layouts|gone.yaml|--out|out", "gone.yaml: can't be read (no such file"),
        ("layouts|misspelt.yaml|--out|out", "misspelt.yaml, line 2: groups.bow: unknown key 'thruster'"),
        ("layouts|study.yaml|--out|good.csv", "good.csv: can't be written (not a directory)"),
        ("layouts|study.yaml", "Missing option '--out'"),
        ("layouts|study.yaml|--out|out|--n|0", "0 is not in the range"),
        ("layouts|study.yaml|--out|out|--workers|2|--scheduler|tcp://a:1", "--workers is of this machine"),
        ("fleet|--vehicle|ukwial", "Missing option '--scheduler'; see "),
        ("fleet|--scheduler|tcp://127.0.0.1:9|--speed|3", "No such option '--speed'"),
        ("fleet|--scheduler|tcp://127.0.0.1:9|--resume", "--resume of run is no option of a fleet"),
        ("board|--out|out", "give --vehicle V to write a project, or --read LOG"),
        (
            "board|--vehicle|ukwial|--read|good.csv|--out|out",
            "give --vehicle V to write a project, or --read LOG",
        ),
        ("board|--vehicle|ukwial", "Missing option '--out'"),
        ("board|--vehicle|ukwial|--method|svd|--out|out", "no C is generated for method 'svd'"),
        ("board|--vehicle|ukwial|--demands|waves|--out|out", "no demand set 'waves'"),
        ("board|--vehicle|ukwial|--demands|jolts|--out|out", "which takes --limits call"),
        ("board|--vehicle|ukwial|--n|2|--out|good.csv", "good.csv: can't be written"),
        ("board|--read|gone.log|--out|out", "gone.log: can't be read (No such file"),
        ("board|--read|folder|--out|out", "folder: can't be read (Is a directory)"),
        ("board|--read|binary.csv|--out|out", "binary.csv: holds no line of the driver"),
        (f"{ALLOCATE}|pinv|-o|good.csv", "good.csv: is the file that is read"),
        ("demands|good.csv|--vehicle|ukwial|-o|./good.csv", "good.csv: is the file that is read"),
        ("import|TAM.yaml|-o|TAM.yaml", "TAM.yaml: is the file that is read"),
        ("compare|gone.json|gone.json", "gone.json"),
        ("compare|binary.csv|binary.csv", "binary.csv"),
        ("compare|latin.json|latin.json", "latin.json: "),
        ("compare|calls.json|calls.json", "calls.json: Expected `int` >= 1"),
        ("compare|zero.json|zero.json", "zero.json: Expected `float` > 0"),
    ],
)
def test_bad_input_ends_with_2_and_one_line(
    place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, line: str, says: str
) -> None:
    if line.startswith("layouts"):
        pytest.importorskip("pyarrow", reason="the extra layouts")
    before = sorted(place.rglob("*"))
    assert says in refusal(capsys, monkeypatch, line)
    assert [(place / name).read_text() for name in ("good.csv", "TAM.yaml")] == [GOOD, TAM]
    # __pycache__ is Python's own, of a plug-in.
    after = sorted(path for path in place.rglob("*") if "__pycache__" not in path.parts)
    assert after == before, "something half done was left behind"


not_root = pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")


@not_root
@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("good.csv", f"{ALLOCATE}|pinv", "can't be read (permission denied)"),
        ("TAM.yaml", "check|TAM.yaml", "can't be read (permission denied)"),
        ("good.py", f"{ALLOCATE}|good|--plugin|good.py", "can't be imported"),
        ("fake.bag", "demands|fake.bag|--vehicle|ukwial", "not a bag"),
        ("zero.json", "compare|zero.json|zero.json", "can't be read (Permission denied)"),
        ("blocked/record.jsonl", "report|blocked", "can't be read (Permission denied)"),
        ("folder", "size|folder|--rate|50", "permission denied"),
        ("folder", "run|--vehicle|ukwial|--method|pinv|--out|folder", "permission denied; make room"),
        ("folder", f"{ALLOCATE}|pinv|-o|folder/f.csv", "permission denied"),
    ],
)
def test_a_file_or_folder_without_permission_is_refused_by_the_command_that_needs_it(
    place: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    line: str,
    says: str,
) -> None:
    (place / name).chmod(0)
    try:
        message = refusal(capsys, monkeypatch, line)
    finally:
        (place / name).chmod(0o700)  # pytest empties the folder later
    assert name in message
    assert says in message


@not_root
def test_a_file_that_is_only_written_need_not_be_readable(place: Path) -> None:
    (place / "out.csv").touch(mode=0o200)
    arguments = ["allocate", "good.csv", "--vehicle=ukwial", "--method=pinv", "-o", "out.csv"]
    assert CliRunner().invoke(cli, arguments).exit_code == 0
    assert (place / "out.csv").read_text().startswith("status")


def test_a_file_name_with_a_line_break_is_shown_on_one_line(
    place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "a b.yaml" in refusal(capsys, monkeypatch, "check|a\nb.yaml")


def test_output_that_its_reader_closes_early_ends_without_a_traceback_or_a_verdict() -> None:
    for command in (["columns"], ["list"]):  # click writes the one, rich the other
        with subprocess.Popen(
            [sys.executable, "-m", "bench", *command],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        ) as left:
            assert left.stdout is not None
            assert left.stderr is not None
            left.stdout.close()
            assert left.stderr.read() == b""
        assert left.returncode == 128 + signal.SIGPIPE  # 1 would say that something got worse


def test_a_command_that_writes_a_folder_finishes_it_though_nobody_reads_its_output(place: Path) -> None:
    run = "run --vehicle ukwial --method pinv --demands inactive --n 5 --repeats 1 --out unread"
    with subprocess.Popen(
        [sys.executable, "-m", "bench", *run.split()], cwd=place, stdout=subprocess.PIPE
    ) as left:
        assert left.stdout is not None
        left.stdout.close()
    assert left.returncode == 0
    assert (place / "unread" / "report.md").exists()
    for module in pkgutil.iter_modules(commands.__path__):
        command: click.Command = import_module(f"bench.commands.{module.name}").command
        if {"--out"} & {name for option in command.params for name in option.opts}:
            assert hasattr(command.callback, "__wrapped__"), module.name


@pytest.mark.parametrize(
    ("line", "code", "lines"),
    [("list >&-", 0, 0), ("check gone.yaml >&-", 2, 1), ("check gone.yaml <&- >&- 2>&-", 2, 0)],
)
def test_a_stream_that_the_caller_closed_drops_what_is_written(line: str, code: int, lines: int) -> None:
    shell = f"{shlex.quote(sys.executable)} -m bench {line}"
    done = subprocess.run(["sh", "-c", shell], cwd=ROOT, capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count(b"\n")) == (code, b"", lines), done.stderr


def test_a_letter_that_the_terminal_lacks_is_escaped() -> None:
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        [sys.executable, "-m", "bench", "list"], cwd=ROOT, env=ascii_only, capture_output=True, check=True
    )
    assert rb"\u2026" in done.stdout  # limits stand as -250 … 250


def test_standard_output_on_a_full_disk_ends_with_one_line() -> None:
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "bench", "columns"],
            cwd=ROOT,
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == b"thrustbench: no space left on device; make room there or name another place\n"
