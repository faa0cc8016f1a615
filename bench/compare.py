"""Two pytest-benchmark files side by side. It informs and never gates: stored times can't carry that."""

from math import exp, log
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from alloc import AllocError


class BadBenchmarkFile(AllocError):
    """A file is not what ``pytest bench/suite --benchmark-json FILE`` writes."""


class Stats(msgspec.Struct):
    """Of the rounds of one benchmark: the least and the middle one [s]."""

    min: float
    median: float


class Benchmark(msgspec.Struct):
    """One benchmark of a file."""

    fullname: str
    stats: Stats
    extra_info: dict[str, Any] = {}


class BenchmarkFile(msgspec.Struct):
    """What is read of a pytest-benchmark file."""

    machine_info: dict[str, Any]
    benchmarks: list[Benchmark]


class Ratio(NamedTuple):
    """One benchmark found in both files: time of one call in each, and how they relate."""

    name: str
    a_us: float
    b_us: float
    median_ratio: float
    min_ratio: float


class Comparison(NamedTuple):
    """What two files say together: ratios B / A, names in one file only, machine differences."""

    ratios: list[Ratio]
    only_a: list[str]
    only_b: list[str]
    machine: list[str]

    @property
    def geometric_mean(self) -> float:
        """Of the ratios of the medians, the mean that does not depend on which file is A."""
        return exp(sum(log(r.median_ratio) for r in self.ratios) / len(self.ratios))


def read(path: Path) -> BenchmarkFile:
    """Read a pytest-benchmark file; raises BadBenchmarkFile."""
    remedy = "give a file written by 'pytest bench/suite --benchmark-json FILE'"
    try:
        found = msgspec.json.decode(path.read_bytes(), type=BenchmarkFile)
    except OSError as error:
        raise BadBenchmarkFile(f"{path}: can't be read ({error.strerror}); {remedy}") from None
    except msgspec.DecodeError as error:
        raise BadBenchmarkFile(f"{path}: {error}; {remedy}") from None
    if any(min(b.stats.min, b.stats.median) <= 0 for b in found.benchmarks):
        raise BadBenchmarkFile(f"{path}: a time is not positive; {remedy}")
    return found


def compare(a: BenchmarkFile, b: BenchmarkFile) -> Comparison:
    """Pair benchmarks by name; times per call where a benchmark says how many calls a round has."""
    before = {one.fullname: one for one in a.benchmarks}
    after = {one.fullname: one for one in b.benchmarks}
    ratios = []
    for name in sorted(before.keys() & after.keys()):
        x, y = before[name], after[name]
        a_us, b_us = (one.stats.median / one.extra_info.get("calls", 1) * 1e6 for one in (x, y))
        ratios.append(Ratio(name, a_us, b_us, b_us / a_us, y.stats.min / x.stats.min))
    return Comparison(
        ratios=ratios,
        only_a=sorted(before.keys() - after.keys()),
        only_b=sorted(after.keys() - before.keys()),
        machine=_differences(a.machine_info, b.machine_info),
    )


def _differences(a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    def facts(info: dict[str, Any]) -> dict[str, Any]:
        cpu = info.get("cpu", {})
        keys = ("node", "machine", "system", "release", "python_implementation", "python_version")
        return {"cpu": cpu.get("brand_raw"), "cores": cpu.get("count"), **{k: info.get(k) for k in keys}}

    before, after = facts(a), facts(b)
    return [f"{key}: {before[key]} | {after[key]}" for key in before if before[key] != after[key]]
