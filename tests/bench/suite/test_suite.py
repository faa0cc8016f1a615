"""The pytest-benchmark suite: it passes, says what it timed, and two of its files can be compared."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from alloc import NotApplicable, load_vehicle
from bench.commands.compare import command as compare
from bench.suite.answers import question
from bench.suite.compare import BadBenchmarkFile, Benchmark, BenchmarkFile, Extra, Stats, read
from bench.suite.compare import compare as ratios
from tests.places import ROOT, other_pytest


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file that a short run of the suite leaves behind."""
    path = tmp_path_factory.mktemp("suite") / "a.json"
    options = ["--benchmark-only", "--benchmark-max-time=0.001", "--benchmark-min-rounds=1"]
    options += ["--benchmark-warmup=off", f"--benchmark-json={path}", "--vehicle=ukwial", "--all"]
    mine = path.with_name("mine.py")
    mine.write_text('"""Mine."""\nfrom alloc.methods.pinv import FORMULATION, build\n')
    options += ["--method=pinv", "--method=nullspace", "--method=mine", f"--plugin={mine}"]
    pytest_run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "bench/suite", *options]
    # pytest-benchmark switches itself off under xdist, whose variables would reach this run.
    alone = other_pytest()
    done = subprocess.run(pytest_run, cwd=ROOT, env=alone, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return path


def altered(path: Path, change: Any) -> Path:
    data = json.loads(path.read_text())
    change(data)
    other = path.with_name("b.json")
    other.write_text(json.dumps(data))
    return other


def test_every_benchmark_says_what_it_timed_and_how_right_it_was(written: Path) -> None:
    benchmarks = json.loads(written.read_text())["benchmarks"]
    assert {b["name"].partition("[")[0] for b in benchmarks} == {"test_call", "test_many", "test_setup"}
    assert {b["extra_info"]["label"] for b in benchmarks} == {"inactive", "active", "moving"}
    for benchmark in benchmarks:
        info = benchmark["extra_info"]
        assert info["vehicle"] == "ukwial"
        formulations = {"pinv": "unlimited", "nullspace": "hard", "mine": "unlimited"}
        assert info["formulation"] == formulations[info["method"]]
        assert info["certificate"]["wrench_error_rel_max"] < 1e-12


def test_times_are_those_of_one_call(written: Path) -> None:
    """A call of pinv takes a microsecond or two, a set-up less than 10 ms, on any machine of today."""
    for benchmark in json.loads(written.read_text())["benchmarks"]:
        calls = 1 if benchmark["name"].startswith("test_setup") else 1000
        assert benchmark["stats"]["iterations"] % calls == 0
        assert benchmark["stats"]["median"] < (5e-4 if calls == 1000 else 0.5)
        assert "calls" not in benchmark["extra_info"]


def collected(*options: str) -> list[str]:
    alone = other_pytest()
    pytest_run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--co", "bench/suite"]
    done = subprocess.run([*pytest_run, *options], cwd=ROOT, env=alone, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return [line.partition("::")[2] for line in done.stdout.splitlines() if "::" in line]


def test_the_default_is_what_one_compares_and_all_is_the_rest() -> None:
    """Closed forms, exact methods and live solvers with the start a vehicle would run: two minutes."""
    usual, every = collected(), collected("--all")
    assert {name.partition("[")[0] for name in usual} == {"test_call"}
    for kind in ("pinv", "svd", "nullspace", "qp/daqp reused"):
        for vehicle in ("ukwial", "bluerov2-heavy"):
            for label in ("active", "inactive"):
                assert f"test_call[{vehicle}-{label}-{kind}]" in usual
    assert not [name for name in usual if "cold" in name and "reused" in name]
    assert len(usual) <= 120 < 400 < len(every)
    assert set(usual) < set(every)


def test_answers_inside_the_limits_are_certified_without_a_reference(written: Path) -> None:
    for benchmark in json.loads(written.read_text())["benchmarks"]:
        info = benchmark["extra_info"]
        inside = info["label"] == "inactive" or info["method"] == "nullspace"
        assert (info["certificate"]["gap_rel_max"] is not None) == inside
        if inside:
            assert info["certificate"]["gap_rel_max"] < 1e-12  # exact methods: nothing but rounding


def test_a_vehicle_whose_thrusters_only_push_is_skipped_with_the_reason() -> None:
    shipped = load_vehicle("ukwial")
    with pytest.raises(NotApplicable, match="T\\* tau breaks a limit on the path"):
        question(replace(shipped, f_min=0 * shipped.f_min), "inactive")


def test_a_plug_in_is_timed_too(written: Path) -> None:
    names = {b["name"] for b in json.loads(written.read_text())["benchmarks"]}
    assert "test_many[ukwial-inactive-mine]" in names


@pytest.mark.parametrize("option", ["--method=pinvv", "--vehicle=boat", "--plugin=gone.py"])
def test_an_unknown_name_is_refused_where_pytest_would_skip_and_pass(option: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "bench/suite", "--co", option],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert done.stderr.startswith("ERROR: ")
    assert option.partition("=")[2] in done.stderr


def test_comparing_a_file_with_a_slower_one_shows_the_ratio_and_still_exits_with_0(written: Path) -> None:
    def slow_down(data: Any) -> None:
        for benchmark in data["benchmarks"]:
            benchmark["stats"]["median"] *= 2

    done = CliRunner().invoke(compare, [str(written), str(altered(written, slow_down))])
    assert done.exit_code == 0
    assert "medians' ratios: 2.000" in done.output
    assert "warning" not in done.output


def test_every_ratio_is_per_call_where_rounds_differ_in_calls() -> None:
    def file(calls: int) -> BenchmarkFile:
        # 2 µs a call in the fastest round, 3 µs in the middle one.
        stats = Stats(min=2e-6 * calls, median=3e-6 * calls)
        return BenchmarkFile({}, [Benchmark("a", stats, Extra(calls))])

    (ratio,) = ratios(file(1000), file(500)).ratios
    assert (ratio.a_us, ratio.b_us) == pytest.approx((3.0, 3.0))
    assert (ratio.median_ratio, ratio.min_ratio) == pytest.approx((1.0, 1.0))


def test_comparing_across_machines_warns(written: Path) -> None:
    def move(data: Any) -> None:
        data["machine_info"]["cpu"]["brand_raw"] = "another processor"

    done = CliRunner().invoke(compare, [str(written), str(altered(written, move))])
    assert done.exit_code == 0
    assert "warning: not the same machine or software: cpu" in done.output
    assert "another processor" in done.output


def test_a_benchmark_in_one_file_only_is_named(written: Path) -> None:
    def drop(data: Any) -> None:
        data["benchmarks"] = [b for b in data["benchmarks"] if "test_many" not in b["name"]]

    done = CliRunner().invoke(compare, [str(written), str(altered(written, drop))])
    assert "only in A: test_many.py::test_many[ukwial-inactive-pinv]" in done.output


@pytest.mark.parametrize("content", [None, "", "{}", '{"machine_info": {}, "benchmarks": [{"fullname": 1}]}'])
def test_a_file_that_is_no_benchmark_file_is_named_with_the_remedy(
    content: str | None, tmp_path: Path
) -> None:
    path = tmp_path / "x.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(BadBenchmarkFile, match=r"x\.json: .*--benchmark-json"):
        read(path)
