"""Fixed work timed on a machine, and what it says of times measured on another one: an estimate."""

from dataclasses import dataclass
from math import prod
from pathlib import Path

import msgspec

from alloc import AllocError
from bench import columns
from bench.ranking import number
from bench.rows import Run

BUDGET_NS = 1_000_000_000
"""Time spent on each canary: some 500 batches."""
BEYOND = 1.5
"""The band is the canaries' ratios, widened by this. They are a Python loop and a matrix product; a
solver's code also depends on caches, compilers and instruction sets, which neither of them feels."""


class CanaryError(AllocError):
    """A canary file, or a record's canaries, can't be used."""


class CanaryFile(msgspec.Struct):
    """What ``thrustbench canary`` writes: the machine, and the median time of each canary [us]."""

    canary_schema: int
    machine: dict[str, str | int | float | bool | None]
    median_us: dict[str, float]


@dataclass(frozen=True)
class Transfer:
    """How much longer calls take on the target than where the run was made.

    low, high: ends of the band; centre: geometric mean of the canaries' ratios. machine: the target.
    """

    low: float
    centre: float
    high: float
    machine: str


def measure() -> CanaryFile:
    """Time the canaries here, as a run does."""
    from bench.harness import machine
    from bench.harness.timing import no_garbage_collection, sample
    from bench.harness.yardsticks import CANARIES, yardstick

    found = {}
    for name in CANARIES:
        with no_garbage_collection():
            batches = sample(yardstick(name), [None] * 100, BUDGET_NS, singles=0).batches
        times = sorted(batch.wall_ns / batch.calls for batch in batches)
        found[name] = times[len(times) // 2] / 1000
    return CanaryFile(1, machine.describe(), found)


def load(path: Path) -> CanaryFile:
    """Read what ``thrustbench canary`` wrote; raises CanaryError."""
    remedy = "give a file that `thrustbench canary` wrote on the target"
    try:
        found = msgspec.json.decode(path.read_bytes(), type=CanaryFile)
    except OSError as error:
        raise CanaryError(f"{path}: can't be read ({error.strerror}); {remedy}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise CanaryError(f"{path}: {error}; {remedy}") from None
    if found.canary_schema != 1 or not found.median_us or min(found.median_us.values()) <= 0:
        raise CanaryError(f"{path}: holds no canary times of schema 1; {remedy}")
    return found


def transfer(run: Run, target: CanaryFile) -> Transfer:
    """The band by which times of a run change on the target; raises CanaryError without canaries."""
    here = {row.method: number(columns.call_p50_us(row)) for row in run.rows if row.vehicle == "-"}
    ratios = [us / there for name, us in target.median_us.items() if (there := here.get(name))]
    if not ratios:
        raise CanaryError("this run holds none of the file's canaries; run again with this version")
    centre = prod(ratios) ** (1 / len(ratios))
    return Transfer(
        min(ratios) / BEYOND, centre, max(ratios) * BEYOND, str(target.machine.get("cpu") or "the target")
    )
