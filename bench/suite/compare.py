"""Two pytest-benchmark files side by side. It informs and never gates: stored times can't carry that."""

from math import exp, log
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec

from alloc import AllocError


class BadBenchmarkFile(AllocError):
    """A file is not what ``pytest bench/suite --benchmark-json FILE`` writes."""


Positive = msgspec.Meta(gt=0)


class Stats(msgspec.Struct):
    """Of the rounds of one benchmark: the least and the middle one [s]."""

    min: Annotated[float, Positive]
    median: Annotated[float, Positive]


class Extra(msgspec.Struct, frozen=True):
    """What a benchmark of ``bench/suite`` adds: how many calls a round makes."""

    calls: Annotated[int, Positive] = 1


class Benchmark(msgspec.Struct):
    """One benchmark of a file."""

    fullname: str
    stats: Stats
    extra_info: Extra = Extra()


class Cpu(msgspec.Struct, frozen=True):
    """The processor, as pytest-benchmark found it."""

    brand_raw: str | None = None
    count: int | None = None


class Machine(msgspec.Struct):
    """Machine and software, as pytest-benchmark found them."""

    cpu: Cpu | None = None
    node: str | None = None
    machine: str | None = None
    system: str | None = None
    release: str | None = None
    python_implementation: str | None = None
    python_version: str | None = None


class BenchmarkFile(msgspec.Struct):
    """What is read of a pytest-benchmark file."""

    machine_info: Machine
    benchmarks: list[Benchmark]


class BenchmarkRatio(NamedTuple):
    """One benchmark found in both files: time of one call in each, and how they relate."""

    name: str
    a_us: float
    b_us: float
    median_ratio: float
    min_ratio: float


class Comparison(NamedTuple):
    """What two files say together: ratios B / A, names in one file only, machine differences."""

    ratios: list[BenchmarkRatio]
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
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise BadBenchmarkFile(f"{path}: {error}; {remedy}") from None
    return found


def compare(a: BenchmarkFile, b: BenchmarkFile) -> Comparison:
    """Pair benchmarks by name; times and ratios per call where a benchmark says how many a round has."""
    before = {one.fullname: one for one in a.benchmarks}
    after = {one.fullname: one for one in b.benchmarks}
    ratios = []
    for name in sorted(before.keys() & after.keys()):
        pair = before[name], after[name]
        a_us, b_us = (one.stats.median / one.extra_info.calls * 1e6 for one in pair)
        a_min, b_min = (one.stats.min / one.extra_info.calls for one in pair)
        ratios.append(BenchmarkRatio(name, a_us, b_us, b_us / a_us, b_min / a_min))
    return Comparison(
        ratios=ratios,
        only_a=sorted(before.keys() - after.keys()),
        only_b=sorted(after.keys() - before.keys()),
        machine=_differences(a.machine_info, b.machine_info),
    )


def _differences(a: Machine, b: Machine) -> list[str]:
    def facts(info: Machine) -> dict[str, Any]:
        cpu = info.cpu or Cpu()
        return msgspec.structs.asdict(info) | {"cpu": cpu.brand_raw, "cores": cpu.count}

    before, after = facts(a), facts(b)
    return [f"{key}: {before[key]} | {after[key]}" for key in before if before[key] != after[key]]
