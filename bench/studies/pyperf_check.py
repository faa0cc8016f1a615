"""Medians of our batches beside pyperf's: ``python -m bench.studies.pyperf_check``.

Five callables are timed by ``bench.harness.timing`` and by ``python -m pyperf timeit`` in turns, in fresh
processes on the same core; docs/method.md quotes the table. The exit code is 1 where the two differ by more
than 3 %. The study takes a minute and a half on an idle machine and needs ``pip install pyperf``.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from statistics import median

from alloc import FloatArray, build, load_vehicle
from bench.demands import build_demands
from bench.harness import machine
from bench.harness.child import environment
from bench.harness.timing import no_garbage_collection, sample
from bench.harness.yardsticks import CANARIES, yardstick
from bench.results.text import table

CALLABLES = (
    ("pinv", "ukwial"),
    ("walsh", "bluerov2-heavy"),
    ("nullspace", "nautilus"),
    ("qp/daqp", "ukwial"),
    (CANARIES[0], "ukwial"),
)
PROCESSES = 20
"""Processes of each kind; they differ by 3 to 7 % (memory layout), so their medians differ by 1 to 2 %."""
WITHIN = 0.03
N = 100
BUDGET_NS = 200_000_000
MIN_TIME = "--min-time=0.0005"
"""Short, so that most values are undisturbed on a busy machine too; it is still 10,000 clock readings."""


def prepared(method: str, vehicle_name: str) -> tuple[Callable[[FloatArray], object], Sequence[FloatArray]]:
    """The callable and its inputs: the inactive demands of a run."""
    vehicle = load_vehicle(vehicle_name)
    taus = list(build_demands("inactive", vehicle, seed=0, n=N).taus)
    return (yardstick(method) if method in CANARIES else build(method, vehicle)), taus


@cache
def one_pass(method: str, vehicle_name: str) -> Callable[[], None]:
    """What pyperf times: one pass over the inputs.

    The callable is cached, because pyperf runs its set-up again before every value. Building it anew would
    cool the caches and move the heap each time, which cost the loop of integer additions 12 %.
    """
    call, taus = prepared(method, vehicle_name)

    def calls() -> None:
        for tau in taus:
            call(tau)

    return calls


def ours(method: str, vehicle_name: str) -> float:
    """Time of one call in this process [ns], median over the batches without a context switch."""
    core = machine.core()
    if core is not None:
        os.sched_setaffinity(0, {core})
    call, taus = prepared(method, vehicle_name)
    with no_garbage_collection():
        batches = sample(call, [taus], BUDGET_NS).batches
    undisturbed = [batch for batch in batches if batch.switches == 0] or batches
    return median(batch.wall_ns / batch.calls for batch in undisturbed)


def theirs(method: str, vehicle_name: str) -> float:
    """Time of one call in a worker process of pyperf [ns], median over its values."""
    set_up = (
        f"from bench.studies.pyperf_check import one_pass; calls = one_pass({method!r}, {vehicle_name!r})"
    )
    core = machine.core()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "values.json"
        pin = [] if core is None else [f"--affinity={core}"]
        options = ["-p1", "-n30", "-w2", MIN_TIME, "--quiet", *pin, f"-o{out}"]
        _python("-m", "pyperf", "timeit", *options, "-s", set_up, "calls()")
        runs = json.loads(out.read_text())["benchmarks"][0]["runs"]
    values = [float(value) for run in runs for value in run.get("values", [])]
    return median(values) * 1e9 / N


def main() -> None:
    """Print the table; with a callable's name and vehicle, time that callable here and print its time."""
    if len(sys.argv) == 3:
        print(ours(sys.argv[1], sys.argv[2]))
        return
    rows, agree = [], True
    for method, vehicle_name in CALLABLES:
        a, b = [], []
        for _ in range(PROCESSES):  # in turns, so that a slow spell hits both
            a.append(float(_python("-m", "bench.studies.pyperf_check", method, vehicle_name)))
            b.append(theirs(method, vehicle_name))
        ratio = median(a) / median(b)
        agree &= abs(ratio - 1.0) <= WITHIN
        rows.append((method, vehicle_name, f"{median(a):.0f}", f"{median(b):.0f}", f"{ratio:.3f}"))
    print(table(("callable", "vehicle", "ours [ns]", "pyperf [ns]", "ratio"), rows))
    sys.exit(0 if agree else 1)


def _python(*arguments: str) -> str:
    command = [sys.executable, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, env=environment()).stdout


if __name__ == "__main__":
    main()
