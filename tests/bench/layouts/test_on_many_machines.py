"""Studies on a scheduler and workers that are processes of their own: killed, resumed, the same bytes."""

import subprocess
import sys
from pathlib import Path

import pytest

from bench import load
from bench.fleet.cluster import CONNECT_S
from bench.harness.plan import RunSettings
from bench.harness.run import run
from bench.layouts.shards import SHARD, compute, file_name, source_digest, tasks
from bench.record import read
from tests.clusters import loopback_cluster
from tests.layout_studies import PLANAR, compiled
from tests.places import ROOT
from tests.runs import started, wait_for

pq = pytest.importorskip("pyarrow.parquet", reason="needs the extra layouts")
SHARDS = 6
TEXT = PLANAR.replace("n: 16", "n: 2")


def layouts(study: Path, out: Path, *options: str) -> "subprocess.Popen[bytes]":
    """`thrustbench layouts` as a process of its own."""
    return started("-m", "bench", "layouts", str(study), "--out", str(out), *options)


def ended(process: "subprocess.Popen[bytes]") -> str:
    """Output of a command that ended well."""
    output = process.communicate(timeout=120)[0].decode()
    assert process.returncode == 0, output
    return output


@pytest.fixture(scope="module")
def disturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a study whose worker was killed, then its parent, and that was resumed."""
    folder = tmp_path_factory.mktemp("disturbed")
    compiled(folder, TEXT)
    study, out = folder / "study.yaml", folder / "out"

    def kept() -> int:
        return len(list((out / "shards").glob("0-*.parquet"))) if out.exists() else 0

    with loopback_cluster(folder) as cluster:
        first = cluster.worker()
        options = ("--n", str(SHARDS * SHARD), "--scheduler", cluster.address)
        parent = layouts(study, out, *options)
        wait_for(lambda: kept() >= 1, 100)
        first.kill()
        first.wait()
        at_death = kept()
        cluster.worker(name="second")
        wait_for(lambda: kept() > at_death, 100)
        parent.kill()
        parent.communicate()
        assert kept() < SHARDS, "the parent was killed before it was done"
        ended(layouts(study, out, *options, "--resume"))
    return out


@pytest.mark.long  # a cluster of its own, whose worker is killed
def test_nothing_is_lost_or_twice_when_a_worker_and_then_the_parent_are_killed(
    disturbed: Path, tmp_path: Path
) -> None:
    """Shards that are left are the bytes that one process makes of the study without any disturbance."""
    space, _ = compiled(tmp_path, TEXT)
    expected = {}
    for task in tasks(0, SHARDS * SHARD, "sobol", 0):
        data = compute(space, task, source_digest())
        expected[file_name(task.round, task.index, data)] = data
    assert {path.name: path.read_bytes() for path in (disturbed / "shards").iterdir()} == expected


HASTY = """
from bench.__main__ import main
from bench.fleet import cluster
cluster.CONNECT_S = 0.5
main()
"""
"""The program, which waits for a scheduler less long."""


def test_a_scheduler_that_is_not_there_is_one_line_within_ten_seconds(tmp_path: Path) -> None:
    compiled(tmp_path, PLANAR)
    assert CONNECT_S <= 8.0  # and a second or two to start Python
    done = subprocess.run(
        [
            *(sys.executable, "-c", HASTY, "layouts", tmp_path / "study.yaml"),
            *("--out", tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1, done.stderr
    assert "--scheduler tcp://127.0.0.1:9: no scheduler answers there" in done.stderr
    assert not (tmp_path / "out").exists()


def test_without_a_scheduler_this_machine_s_own_workers_do_the_work(tmp_path: Path) -> None:
    compiled(tmp_path, PLANAR)
    printed = ended(layouts(tmp_path / "study.yaml", tmp_path / "out", "--n", "64", "--workers", "1"))
    assert "Dask's dashboard: http://127.0.0.1:" in printed
    assert "64 layouts in " in printed
    assert "64 layouts were drawn" in (tmp_path / "out" / "report.md").read_text()


@pytest.mark.long  # a cluster of its own, whose worker is killed
def test_a_best_layout_s_numbers_are_met_by_a_run_on_its_file(disturbed: Path, tmp_path: Path) -> None:
    """Its volume, maxima and shares as a run records them, and the shares of the study's own demands."""
    rows = pq.read_table(disturbed / "front.parquet").to_pylist()
    front = {f"ukwial-{row['round']}-{row['layout']}": row for row in rows}
    file = sorted((disturbed / "best").glob("*.yaml"))[0]
    row = front[file.stem]
    settings = RunSettings(
        vehicles=(str(file),),
        demands=(str(disturbed / "demands.csv"),),
        methods=("pinv", "nullspace"),
        repeats=1,
        budget_ms=1.0,
    )
    run(settings, tmp_path, resume=False, watch=lambda progress: None)
    measured = {line.method: line for line in load(tmp_path)}
    assert measured["pinv"].within_1pct_share == pytest.approx(row["closed_form_served_share"])
    assert measured["nullspace"].within_1pct_share == pytest.approx(row["exact_served_share"])
    (capability,) = read(tmp_path).capabilities
    whole, *failed = capability.authority
    assert whole.condition == pytest.approx(row["condition"], rel=1e-9)
    assert whole.safe_share == pytest.approx(row["safe_share"], rel=1e-9)
    assert whole.closed_form_share == pytest.approx(row["closed_form_volume_share"], rel=1e-9)
    assert whole.axis_max == pytest.approx(
        [row[axis] for axis in ("surge_max_N", "sway_max_N", "yaw_max_Nm")]
    )
    worst = min(failed, key=lambda state: (state.rank, state.volume_share))
    assert worst.volume_share * row["authority"] == pytest.approx(row["authority_after_one"], rel=1e-9)


@pytest.mark.long  # a cluster of its own, whose worker is killed
def test_best_layouts_are_vehicle_files_that_check_and_codegen_take(disturbed: Path, tmp_path: Path) -> None:
    file = sorted((disturbed / "best").glob("*.yaml"))[0]
    assert "0 errors" in ended(started("-m", "bench", "check", str(file), "--no-picture"))
    codegen = ("codegen", "--vehicle", str(file), "--method", "nullspace", "--out", str(tmp_path / "c"))
    assert ".c" in ended(started("-m", "bench", *codegen))
