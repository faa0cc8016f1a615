"""A board's log in the project's own terms: header, demands, and calls of each method."""

import base64
import binascii
import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import inf
from pathlib import Path
from typing import Any, cast

import numpy as np

from alloc import AllocError, Vehicle, rivals
from alloc.allocation import FloatArray, IndexArray
from alloc.methods import recipe
from alloc.program import Scalar, Where
from bench.chips import esc
from bench.chips.kernels import SCALARS, Kernel
from bench.chips.processors import names
from bench.demands import DemandSet, labelled
from bench.demands.store import unpack_vehicle
from bench.inputs.board_log import BoardLog, LogBlock, LogError, answered, tick_counts, whole
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
    vehicle = unpack_vehicle({key: np.array(value) for key, value in arrays.items()})
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


NOOP = "noop"
"""The driver's own method, which does nothing: what timing a call costs by itself."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TimedCalls:
    """One method on one demand set, once through.

    Attributes
    ----------
    F : (N, n) thrusts of the first pass [N]
    shares : (N, levels) what the kernel said of each level then [-]; NaN where it wrote nothing
    status : (N,) what the kernel returned then
    ticks : (N,) of the first pass
    stack_bytes : (N,) that the kernel wrote to, 0 where nobody looked
    ones : ticks of single calls in later passes, (ticks, how often)
    passes : ticks of whole passes, (ticks, how often)
    worst_demand, worst_ticks : the slowest call
    other_answers : passes whose answers were not those of the first
    """

    F: FloatArray
    shares: FloatArray
    status: IndexArray
    ticks: IndexArray
    stack_bytes: IndexArray
    ones: list[tuple[int, int]]
    passes: list[tuple[int, int]]
    worst_demand: int
    worst_ticks: int
    other_answers: int


@dataclass(frozen=True, eq=False)
class Heard:
    """Content of one board's log.

    Attributes
    ----------
    board : its header
    demands : each set whose demands arrived, by name, rounded as the board has them
    thrusts : each set of calls of NAME_esc (N, width), likewise
    runs : by method and set, one for each time that the board ran
    missing : what the project asks and no block says, in words
    """

    board: LogHeader
    demands: dict[str, DemandSet]
    thrusts: dict[str, FloatArray]
    runs: dict[tuple[str, str], list[TimedCalls]]
    missing: list[str]

    @cached_property
    def vehicle(self) -> Vehicle:
        """The vehicle with limits as the scalar has them."""
        return _rounded(self.board.vehicle, next(iter(self.board.kernels.values())).scalar)


FOREIGN = (
    KeyError,
    ValueError,
    IndexError,
    TypeError,
    RecursionError,
    zlib.error,
    binascii.Error,
    AllocError,
)
"""Errors of a header that another driver wrote, or somebody made up."""


def boards(path: Path, log: BoardLog) -> list[Heard]:
    """Each board that printed a whole header, in the order of the file; raises LogError where none did."""
    headers = {block.header: block for block in log.blocks if block.kind == "board"}
    if not headers:
        said = f"; its driver said: {log.nonsense[0]}" if log.nonsense else ""
        raise LogError(f"{path}: holds no whole header{said}; open the line first, then reset the board")
    heard = []
    for name, block in headers.items():
        own = [b for b in log.blocks if b.header == name and b.kind != "board"]
        try:
            heard.append(_heard(header(block), own))
        except FOREIGN as error:
            reason = f"is of another version of the driver ({type(error).__name__}: {str(error)[:200]})"
            raise LogError(f"{path}: {reason}; read it with the version that wrote the project") from None
        board = heard[-1].board
        if not board.ticks_per_s and board.processor not in names():
            raise LogError(
                f"{path}: counts instructions, as ticks_per_s is 0, of {board.processor[:40]!r}, which is"
                f" none of {', '.join(names())}; give ticks_per_s in the port"
            )
    return heard


def _heard(board: LogHeader, blocks: Sequence[LogBlock]) -> Heard:
    kernel = next(iter(board.kernels.values()))
    scalar = np.dtype(SCALARS[kernel.scalar])
    vehicle = _rounded(board.vehicle, kernel.scalar)
    demands, thrusts = dict[str, DemandSet](), dict[str, FloatArray]()
    for block in blocks:
        if block.kind == "demands" and (name := block.words[0]) not in demands.keys() | thrusts.keys():
            rate_hz = board.rates[name]
            if board.of_escs(name):
                thrusts[name] = _calls(block, esc.width(vehicle.n, kernel.limits), scalar)
            else:
                calls, k, n = _calls(block, kernel.width, scalar), kernel.k, kernel.n
                ends = (calls[:, k : k + n].copy(), calls[:, k + n :].copy())
                sides = ends if kernel.limits == "call" else ()
                made = labelled(name, vehicle, calls[:, :k].copy(), *sides, rate_hz=rate_hz)
                left_out, beyond, longest = board.logs.get(name, (0, 0, 0))
                demands[name] = replace(
                    made,
                    given=name in board.logs,
                    left_out=left_out,
                    beyond=beyond,
                    beyond_longest=longest,
                )
    counts = {name: len(each.taus) for name, each in demands.items()} | {
        n: len(x) for n, x in thrusts.items()
    }
    asked: dict[tuple[str, str], list[TimedCalls]] = {}
    missing = [f"the demands of {name}" for name in board.rates if name not in counts]
    for block in blocks:
        if block.kind == "ask" and block.words[1] in counts:
            method, name = block.words[:2]
            if method != NOOP and (method == esc.METHOD) != board.of_escs(name):
                raise ValueError(f"{method} asked {name}")
            levels = board.kernels[method].levels if method != NOOP else 0
            found = _asked(block, kernel.n, levels, scalar, counts[name])
            asked.setdefault((method, name), []).append(found)
    expected = product(board.kernels, board.rates)
    missing += [
        f"{method} on {name}"
        for method, name in expected
        if (method == esc.METHOD) == board.of_escs(name) and (method, name) not in asked
    ]
    return Heard(board, demands, thrusts, asked, missing)


def _rounded(vehicle: Vehicle, scalar: Scalar) -> Vehicle:
    """The vehicle with its limits as the board has them: a thrust at a limit must not count as beyond it."""
    kind = np.dtype(SCALARS[scalar])
    low, high = (side.astype(kind).astype(np.float64) for side in (vehicle.f_min, vehicle.f_max))
    return replace(vehicle, f_min=low, f_max=high)


def _calls(block: LogBlock, width: int, scalar: np.dtype[Any]) -> FloatArray:
    """Arguments of each call of a set (N, width)."""
    rows = block.rows("tau")
    bits = bytes.fromhex("".join("".join(row[1:]) for row in rows))
    return (
        np.frombuffer(bits, scalar.newbyteorder(">")).reshape(whole(block.words[1]), width).astype(np.float64)
    )


def _asked(block: LogBlock, n: int, levels: int, scalar: np.dtype[Any], count: int) -> TimedCalls:
    F, status, ticks, stack, shares = answered(block, n, scalar, levels)
    (worst,) = block.rows("worst")
    demand, worst_ticks, other = map(whole, worst)
    ones, passes = tick_counts(block, "one"), tick_counts(block, "all")
    told, repeated = whole(block.words[2]), whole(block.words[3])
    complete = len(F) == told == count and sum(times for _, times in ones) == repeated * told
    if not complete or sum(times for _, times in passes) != repeated or not 0 <= demand < told:
        raise ValueError(f"{' '.join(block.words)}: numbers that contradict each other")
    return TimedCalls(
        F=F,
        shares=shares,
        status=status,
        ticks=ticks,
        stack_bytes=stack,
        ones=ones,
        passes=passes,
        worst_demand=demand,
        worst_ticks=worst_ticks,
        other_answers=other,
    )
