"""The header of a board's log: what was asked, of which vehicle, and what port and compiler said."""

import base64
import json
import zlib
from dataclasses import dataclass
from math import inf
from typing import Any, cast

import numpy as np

from alloc import Vehicle, rivals
from alloc.methods import recipe
from alloc.program import Scalar, Where
from bench.chips import esc
from bench.chips.kernel import SCALARS, Kernel
from bench.demands.store import vehicle_of
from bench.inputs.board_log import LogBlock, whole
from bench.record.schema import unusable

_LARGEST = 1 << 22
"""Bytes of a vehicle at most: a vehicle of a hundred thrusters has 200 kB."""


@dataclass(frozen=True, kw_only=True)
class LogHeader:
    """The header of a log.

    Attributes
    ----------
    facts : what port and compiler said, by name: processor, port, caches, compiler, flags, commit, seed, …
    ticks_per_s : of the port's counter [Hz]; 0 where a tick is an instruction
    seed : of the demands
    vehicle : as the project had it, in double precision
    kernels : each method's names, scalar and form of limits, without its C
    rates : of each demand set, its sampling rate [Hz] or None
    logs : of each demand set that a user brought, how many demands are left out, and ``beyond`` and
        ``beyond_longest`` of all, as ``bench.demands.DemandSet`` has them
    """

    facts: dict[str, str]
    ticks_per_s: int
    seed: int
    vehicle: Vehicle
    kernels: dict[str, Kernel]
    rates: dict[str, float | None]
    logs: dict[str, tuple[int, int, int]]

    @property
    def processor(self) -> str:
        """Name that the port gives its processor."""
        return self.facts.get("processor", "")

    def of_escs(self, demands: str) -> bool:
        """True if a set of that name is asked of NAME_esc."""
        return esc.METHOD in self.kernels and demands in esc.SIZES


def header(block: LogBlock) -> LogHeader:
    """Header in a block of kind ``board``; raises an error of any kind where another driver wrote it."""
    facts: dict[str, str] = {}
    several: dict[str, list[list[str]]] = {"method": [], "demands": [], "vehicle": []}
    for name, *words in block.rows("fact"):
        if name in several:
            several[name].append(words)
        else:
            facts[name] = " ".join(words)
    ((said,),) = block.rows("ticks_per_s")
    ticks_per_s = whole(said)
    packed = base64.b64decode("".join(piece for (piece,) in several["vehicle"]), validate=True)
    text = zlib.decompressobj().decompress(packed, _LARGEST)
    arrays: dict[str, list[Any]] = json.loads(text)
    if not isinstance(arrays, dict):
        raise ValueError(f"a vehicle that is {str(arrays)[:40]}")
    vehicle = vehicle_of({key: np.array(value) for key, value in arrays.items()})
    if why := unusable(vehicle.name) or unusable(vehicle.whole or vehicle.name):
        raise ValueError(why)
    scalar, limits = cast(Scalar, facts["scalar"]), cast(Where, facts["limits"])
    if scalar not in SCALARS or limits not in ("fixed", "call"):
        raise ValueError(f"scalar {scalar}, limits {limits}")
    described = (words if len(words) > 3 else [*words, "0"] for words in several["method"])
    kernels = {
        method: Kernel(
            method=method,
            twin="" if method == esc.METHOD else twin,
            solver="" if solver == "-" else solver,
            scalar=scalar,
            limits=limits,
            k=vehicle.k,
            n=vehicle.n,
            entry="",
            declaration="",
            arguments="",
            sources={},
            levels=whole(levels, vehicle.k),
        )
        for method, twin, solver, levels in described
    }
    for method, kernel in kernels.items():
        if method != esc.METHOD:
            recipe(kernel.twin)
            if not kernel.solver and method.partition("@")[0] != kernel.twin:
                raise ValueError(f"method {method}, which is {kernel.twin}")
        elif not vehicle.esc:
            raise ValueError(f"method {method} of a vehicle without ESCs")
    if not kernels or not {kernel.solver for kernel in kernels.values()} <= {"", *rivals.names()}:
        raise ValueError(f"methods {', '.join(kernels) or 'none'}, of which a solver is not known here")
    rates = {name: None if rate == "-" else _rate(rate) for name, rate, *_ in several["demands"]}
    logs = {name: _log(words) for name, _, *words in several["demands"] if words}
    return LogHeader(
        facts=facts,
        ticks_per_s=ticks_per_s,
        seed=whole(facts.get("seed", "0"), (1 << 63) - 1),
        vehicle=vehicle,
        kernels=kernels,
        rates=rates,
        logs=logs,
    )


def _rate(word: str) -> float:
    rate = float(word)
    if not 0 < rate < inf:
        raise ValueError(f"a rate of {word[:40]} Hz")
    return rate


def _log(words: list[str]) -> tuple[int, int, int]:
    left_out, beyond, longest = map(whole, words)
    return left_out, beyond, longest
