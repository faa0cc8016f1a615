"""A board's log as counts of instructions, where a tick of the port is one and there is no clock."""

from collections.abc import Iterator

import msgspec
import numpy as np

from bench.chips import esc
from bench.chips.agreement import agreement
from bench.chips.board.heard import NOOP, Heard, TimedCalls
from bench.chips.count import CallCounts
from bench.demands import DemandSet
from bench.record import Emulated


def counts(heard: Heard) -> Iterator[Emulated]:
    """A line of a record for each method on each demand set."""
    facts = heard.board.facts
    for (method, name), runs in heard.asked.items():
        if method == NOOP:  # a driver that counts instructions does not ask it
            continue
        kernel, run = heard.board.kernels[method], runs[0]
        counted = CallCounts(run.F, run.status, run.ticks, run.stack_bytes, run.shares)
        row = Emulated(
            vehicle=heard.board.vehicle.name,
            target=heard.board.processor,
            method=method,
            scalar=kernel.scalar,
            limits=kernel.limits,
            solver=kernel.solver,
            seed=heard.board.seed,
            tools={"compiler": facts.get("compiler", ""), "thrustbench": facts.get("commit", "")},
        )
        if method == esc.METHOD:
            yield esc.counted_row(row, name, heard.vehicle, heard.thrusts[name], counted)
            continue
        demands = heard.demands[name]
        agreed = agreement(kernel, demands, counted)
        values, calls = np.unique(run.ticks, return_counts=True)
        yield msgspec.structs.replace(
            row,
            demands=name,
            instructions=list(zip(values.tolist(), calls.tolist(), strict=True)),
            worst=_worst(demands, run),
            stack_bytes=int(run.stack_bytes.max()),
            agrees=agreed.agrees,
            distance_rel_max=agreed.distance_rel_max,
            other_verdicts=agreed.other_verdicts,
        )


def _worst(demands: DemandSet, run: TimedCalls) -> list[float]:
    worst: list[float] = demands.taus[int(run.ticks.argmax())].tolist()
    return worst
