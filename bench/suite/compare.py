"""Two pytest-benchmark files side by side, for information: stored times are too unsteady for a gate."""

from math import exp, log
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec

from alloc import AllocError


class BadBenchmarkFile(AllocError):
    """A file is not what ``pytest bench/suite --benchmark-json FILE`` writes."""


Positive = msgspec.Meta(gt=0)


class Stats(msgspec.Struct):
    """Times of a benchmark's rounds.

    Attributes
    ----------
    min, median : the least and the middle one [s]
    """

    min: Annotated[float, Positive]
    median: Annotated[float, Positive]


class Extra(msgspec.Struct, frozen=True):
    """Figures that a benchmark of ``bench/suite`` adds.

    Attributes
    ----------
    calls : how many a round makes
    """

    calls: Annotated[int, Positive] = 1


class Benchmark(msgspec.Struct):
    """One benchmark of a file.

    Attributes
    ----------
    fullname : file, test and parameters
    stats : times of its rounds
    extra_info : what ``bench/suite`` added
    """

    fullname: str
    stats: Stats
    extra_info: Extra = Extra()


MACHINE = ("node", "machine", "system", "release", "python_implementation", "python_version")
"""Keys of machine and interpreter in pytest-benchmark's file, besides the processor."""


class BenchmarkFile(msgspec.Struct):
    """The part of a pytest-benchmark file that is read.

    Attributes
    ----------
    machine_info : where it was measured
    benchmarks : in the order of the file
    """

    machine_info: dict[str, Any]
    benchmarks: list[Benchmark]


class BenchmarkRatio(NamedTuple):
    """A benchmark that both files A and B have.

    Attributes
    ----------
    name : file, test and parameters
    a_us, b_us : median time of one call in A and in B [us]
    median_ratio, min_ratio : B / A of the medians and of the least times
    """

    name: str
    a_us: float
    b_us: float
    median_ratio: float
    min_ratio: float


class Comparison(NamedTuple):
    """Two files A and B side by side.

    Attributes
    ----------
    ratios : benchmarks that both have
    only_a, only_b : names of benchmarks that only one has
    machine : how machine and software differ
    """

    ratios: list[BenchmarkRatio]
    only_a: list[str]
    only_b: list[str]
    machine: list[str]

    @property
    def geometric_mean(self) -> float:
        """Mean of the ratios of medians; its inverse is the mean where A and B are exchanged."""
        return exp(sum(log(r.median_ratio) for r in self.ratios) / len(self.ratios))


def read(path: Path) -> BenchmarkFile:
    """Read a pytest-benchmark file; raises BadBenchmarkFile."""
    remedy = "give a file written by 'pytest bench/suite --benchmark-json FILE'"
    try:
        return msgspec.json.decode(path.read_bytes(), type=BenchmarkFile)
    except OSError as error:
        raise BadBenchmarkFile(f"{path}: can't be read ({error.strerror}); {remedy}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise BadBenchmarkFile(f"{path}: {error}; {remedy}") from None


def compare(a: BenchmarkFile, b: BenchmarkFile) -> Comparison:
    """Pair benchmarks by name; times and ratios per call where a benchmark says how many a round has."""
    before = {benchmark.fullname: benchmark for benchmark in a.benchmarks}
    after = {benchmark.fullname: benchmark for benchmark in b.benchmarks}
    ratios = []
    for name in sorted(before.keys() & after.keys()):
        pair = before[name], after[name]
        a_us, b_us = (side.stats.median / side.extra_info.calls * 1e6 for side in pair)
        a_min, b_min = (side.stats.min / side.extra_info.calls for side in pair)
        ratio = BenchmarkRatio(
            name=name, a_us=a_us, b_us=b_us, median_ratio=b_us / a_us, min_ratio=b_min / a_min
        )
        ratios.append(ratio)
    return Comparison(
        ratios=ratios,
        only_a=sorted(before.keys() - after.keys()),
        only_b=sorted(after.keys() - before.keys()),
        machine=_differences(a.machine_info, b.machine_info),
    )


def _differences(a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    def facts(info: dict[str, Any]) -> dict[str, Any]:
        cpu = info.get("cpu")
        name, cores = (cpu.get("brand_raw"), cpu.get("count")) if isinstance(cpu, dict) else (None, None)
        return {"cpu": name, "cores": cores} | {key: info.get(key) for key in MACHINE}

    before, after = facts(a), facts(b)
    return [f"{key}: {before[key]} | {after[key]}" for key in before if before[key] != after[key]]
