"""Records of a board's log, one a board, which reports and tables read like any other machine's."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from alloc import Allocation, Status, Vehicle, build
from alloc.c.selftest import AGREEMENT
from alloc.formulations import Family
from alloc.formulations.hard import FORMULATION as HARD
from alloc.kernels.tolerance import SOLVER_ERROR, WRENCH_ERROR
from alloc.rivals import load
from bench.chips import esc
from bench.chips.agreement import agreement, explained
from bench.chips.board.log import NOOP, Heard, TimedCalls, boards
from bench.chips.count import CallCounts
from bench.chips.kernels import Kernel
from bench.chips.processors import names, processor
from bench.demands import DemandSet
from bench.harness.lines import problem
from bench.inputs.board_log import BoardLog, LogError, read_board_log
from bench.judging.judge import judge
from bench.judging.question import Question, ask_here, questions, right_answers
from bench.record import SCHEMA, Batch, Cell, Emulated, Header, Judged, Key, Line, Method, Problem
from bench.record.file import Writer
from bench.record.measured import binned
from bench.record.schema import slug
from bench.results.quantiles import merge
from bench.results.ranking import EXACT_WITHIN
from bench.results.text import plural

COARSE = 0.1
"""Share of single calls without a tick from which on a counter is too coarse to time one."""

PASSES = 10_000
"""Most passes of a method over a set that a record keeps one by one; a log counts those that are alike."""


@dataclass(frozen=True)
class Promise:
    """Promise of a kernel, which its answers are held to.

    Attributes
    ----------
    formulation : whose right answers
    limited : whether thrusts lie inside the limits
    tolerance : largest distance to the right answer, over the largest limit [-]
    """

    formulation: str
    limited: bool
    tolerance: float


def lines(heard: Heard, name: str, started: str) -> Iterator[Line]:
    """The header of a record, then its lines: cells of a board that has a clock, else counts.

    ``name`` is the machine's, ``started`` the date and time that the record gives.
    """
    yield _header(heard, name, started)
    if not heard.board.ticks_per_s:
        if heard.board.processor in names():
            yield processor(heard.board.processor).facts
        yield from counts(heard)
        return
    asked = questions(list(heard.demands.values()), ask_here)
    yield Method(name=NOOP, yardstick=True)
    for kernel in heard.board.kernels.values():
        if kernel.method == esc.METHOD:
            yield Method(name=esc.METHOD, foreign=True, yardstick=True)
            continue
        twin = "" if kernel.solver else kernel.twin
        formulation = promise(kernel, heard).formulation
        yield Method(
            name=kernel.method,
            formulation=formulation,
            family=Family.GENERATED if kernel.solver else "",
            solver=kernel.solver,
            foreign=True,
            twin=twin,
        )
    for question in asked:
        yield problem(question)
    for name, calls in heard.thrusts.items():
        yield _thrusts(heard.vehicle, name, len(calls))
    for (method, name), runs in heard.runs.items():
        for repeat, run in enumerate(runs):
            cell = _cell(heard, method, name, repeat, run)
            if method == esc.METHOD:
                cell.judged, cell.worst = _sent(heard, name, run)
            elif method != NOOP:
                kernel, promised = heard.board.kernels[method], promise(heard.board.kernels[method], heard)
                cell.formulation, cell.limited = promised.formulation, promised.limited
                (question,) = (each for each in asked if each.demands.name == name)
                cell.judged = _judged(question, kernel, promised, run, thorough=repeat == 0)
                cell.worst = question.demands.taus[run.worst_demand].tolist()
            yield cell


def promise(kernel: Kernel, heard: Heard) -> Promise:
    """Promise of a kernel: its twin's, as far as its scalar can hold that."""
    if kernel.solver:
        tolerance = load(kernel.solver).TOLERANCE["default"][kernel.scalar]
        return Promise(HARD.name, limited=True, tolerance=tolerance)
    twin = build(kernel.twin, heard.board.vehicle)
    return Promise(twin.formulation, twin.limited, max(twin.tolerance, AGREEMENT[kernel.scalar]))


def _header(heard: Heard, name: str, started: str) -> Header:
    facts = heard.board.facts
    clock = {"ticks_per_s": heard.board.ticks_per_s} if heard.board.ticks_per_s else {}
    said = {key: facts.get(key, "") for key in ("port", "caches", "compiler", "flags")}
    return Header(
        schema=SCHEMA,
        started=started,
        commit=facts.get("commit", "").replace("-", ""),
        seed=heard.board.seed,
        machine={"name": slug(name), "cpu": heard.board.processor, **said, **clock},
        versions={"compiler": facts.get("compiler", "")},
        settings={
            "vehicles": [heard.board.vehicle.name],
            "methods": list(heard.board.kernels),
            "demands": list(heard.board.rates),
            "scalar": facts["scalar"],
            "limits": facts["limits"],
            "faults": facts.get("faults", "one"),
            "missing": heard.missing,
        },
    )


def _thrusts(vehicle: Vehicle, name: str, count: int) -> Problem:
    """The line of a set of thrusts that NAME_esc was asked."""
    return Problem(
        vehicle=vehicle.name,
        whole=vehicle.whole or vehicle.name,
        demands=name,
        n_demands=count,
        labels={},
        rate_hz=None,
        reference="",
        dof=list(vehicle.dof),
        n=vehicle.n,
        rank=vehicle.rank,
        nullity=vehicle.nullity,
        f_scale=vehicle.f_scale,
        wrench_scale=vehicle.wrench_scale.tolist(),
        names=list(vehicle.names),
        frame=vehicle.frame,
    )


def _sent(heard: Heard, name: str, run: TimedCalls) -> tuple[Judged, list[float]]:
    """Verdict of Python on the thrusts that NAME_esc made, and the slowest call's."""
    calls, n = heard.thrusts[name], heard.vehicle.n
    agrees, apart = esc.agreement(heard.vehicle, calls, run.F, run.status)
    judged = Judged(
        answers=len(calls),
        counts={},
        distance_rel_max=apart,
        tolerance=esc.MADE,
        agrees=agrees,
        wrong="" if agrees else "makes other thrusts than Python, or says another status",
    )
    return judged, calls[run.worst_demand, :n].tolist()


def _cell(heard: Heard, method: str, name: str, repeat: int, run: TimedCalls) -> Cell:
    hz = heard.board.ticks_per_s

    def ns(ticks: int) -> int:
        return round(ticks * 1e9 / hz)

    N = len(run.F)
    none = sum(times for ticks, times in run.ones if ticks == 0)
    coarse = none > COARSE * sum(times for _, times in run.ones)
    batches = [Batch(N, ns(ticks), ns(ticks), 0) for ticks in _spread(run.passes)]
    return Cell(
        key=Key(heard.board.vehicle.name, name, method, repeat=repeat),
        status="ok",
        n_demands=N,
        batches=batches,
        singles=[] if coarse else merge([[(binned(ns(ticks)), times)] for ticks, times in run.ones]),
        timed_ns=sum(ns(ticks) * times for ticks, times in (*run.ones, *run.passes)),
    )


def _spread(seen: list[tuple[int, int]]) -> list[int]:
    """The ticks of each pass, sorted; of more than PASSES, so many that lie evenly among them."""
    ticks, times = np.array(seen, dtype=np.int64).reshape(-1, 2).T
    ends, total = np.cumsum(times), int(times.sum())
    places = np.arange(total) if total <= PASSES else (np.arange(PASSES) + 0.5) * (total / PASSES)
    spread: list[int] = ticks[np.searchsorted(ends, places, side="right")].tolist()
    return spread


def _judged(question: Question, kernel: Kernel, promised: Promise, run: TimedCalls, thorough: bool) -> Judged:
    known = {int(value) for value in Status}
    judged_with = partial(
        judge,
        question,
        [
            Allocation(f, Status(s) if s in known else s, share=tuple(share))
            for f, s, share in zip(run.F, run.status.tolist(), run.shares.tolist(), strict=True)
        ],
        formulation=promised.formulation,
        limited=promised.limited,
        tolerance=promised.tolerance,
        wrench_tolerance=(SOLVER_ERROR if kernel.solver else WRENCH_ERROR)[kernel.scalar],
        thorough=thorough,
    )
    judged = judged_with()
    if not kernel.solver and (judged.distance_rel_max or 0.0) > EXACT_WITHIN:
        right = right_answers(question, promised.formulation)
        judged = judged_with(doubt=explained(kernel, question.demands, right).apart)
    if not kernel.solver:
        # Equations alone let a rule of practice make anything inside the limits, and call it PARTIAL.
        counted = CallCounts(run.F, run.status, run.ticks, run.stack_bytes, run.shares)
        said = [judged.wrong, agreement(kernel, question.demands, counted).wrong]
        if run.other_answers:  # this project's C keeps nothing between calls
            said.append(f"answers of {run.other_answers} passes differ from those of the first")
        judged.wrong = "; ".join(filter(None, said))
    return judged


def counts(heard: Heard) -> Iterator[Emulated]:
    """Counts of instructions where a tick of the port is one: a line for each method on each demand set."""
    facts = heard.board.facts
    for (method, name), runs in heard.runs.items():
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


SHOWN = 6
"""Most lost blocks that are named."""


class BoardRecords(NamedTuple):
    """Result of ``keep``.

    Attributes
    ----------
    lines : for whoever reads the log
    folders : of the records
    good : whether every answer of this project's C is right
    """

    lines: list[str]
    folders: list[Path]
    good: bool


def keep(path: Path, out: Path, name: str = "") -> BoardRecords:
    """Write a record of the board that a log is of into ``out``; of several boards, into folders in it.

    Raises LogError where nothing in the log can be used, RecordError where ``out`` can't be written.
    """
    log = read_board_log(path)
    found = boards(path, log)
    useful = [heard for heard in found if heard.runs]
    if not useful:
        raise LogError(f"{path}: {_nothing(log)}; run the board again, to the line `done`")
    said, good = _lost(log), True
    started = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    folders = [out]
    if len(useful) > 1:
        folders = [
            out / f"{i}-{slug(name or heard.board.processor)}" for i, heard in enumerate(useful, start=1)
        ]
    for heard, folder in zip(useful, folders, strict=True):
        good = _record(heard, name or heard.board.processor, started, folder, said) and good
    return BoardRecords(said, folders, good)


def _record(heard: Heard, name: str, started: str, folder: Path, said: list[str]) -> bool:
    good, calls = True, 0
    with Writer(folder) as writer:
        first, *rest = lines(heard, name, started)
        assert isinstance(first, Header)
        writer.create(first)
        writer.extend(rest)
    for line in rest:
        if isinstance(line, Cell):
            calls += sum(times for _, times in line.singles)
            if line.judged is not None and line.judged.objection:
                said.append(f"{line.key.method} on {line.key.demands}: {line.judged.objection}")
                good = good and bool(heard.board.kernels[line.key.method].solver)
        elif isinstance(line, Emulated):
            calls += sum(times for _, times in line.instructions)
            if line.agrees is False:
                said.append(f"{line.method} on {line.demands}: not as in Python")
                good = good and line.solver != ""
    if heard.missing:
        more = f" and {len(heard.missing) - SHOWN} more" if len(heard.missing) > SHOWN else ""
        said.append(f"{name}: not whole, so left out: {', '.join(heard.missing[:SHOWN])}{more}")
    blocks = sum(len(runs) for (method, _), runs in heard.runs.items() if method != NOOP)
    said.append(f"{name}: {blocks} blocks, {calls} calls")
    return good


def _lost(log: BoardLog) -> list[str]:
    said = []
    if log.damaged or log.lost:
        said.append(_not_whole(log))
    if log.starts > 1:
        said.append(f"the log has {log.starts} starts, {log.finished} of which ran to the end")
    elif not log.finished:
        said.append("the log ends before the board had finished")
    return said + [f"the driver said: {words}" for words in log.nonsense]


def _nothing(log: BoardLog) -> str:
    if log.nonsense:
        return f"its driver said: {log.nonsense[0]}"
    return f"no method on any demand set arrived whole ({_not_whole(log)})"


def _not_whole(log: BoardLog) -> str:
    """Numbers of lines that are damaged and that are missing beside those: a damaged one has no number."""
    missing = max(log.lost - log.damaged, 0)
    return f"{plural(log.damaged, 'damaged line')}, {plural(missing, 'missing line')}"
