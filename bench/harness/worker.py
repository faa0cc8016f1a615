"""One process that runs one method: a Job comes in on stdin, lines go out on a pipe of their own.

Stdout and stderr are left to the solvers, which print on them. Run as ``python -m bench.harness.worker FD``.
"""

import os
import sys
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from alloc import (
    Allocation,
    Allocator,
    BoundedSteps,
    Entry,
    NotApplicable,
    NotInstalled,
    TwoStage,
    UnknownName,
    Vehicle,
    find,
    load_plugin,
    one_by_one,
    prepare,
)
from bench.demands.store import load_case, save
from bench.harness.job import (
    AnswersWritten,
    AnswerTask,
    Begin,
    Described,
    DescribeTask,
    Failed,
    Job,
    MeasureTask,
    Message,
    Task,
)
from bench.harness.lines import method_line
from bench.harness.memory import peak_rss_bytes, reachable_bytes
from bench.harness.quiet import between, reading
from bench.harness.timing import Samples, counted, no_garbage_collection, sample
from bench.harness.yardsticks import YARDSTICKS, canary_ns, yardstick
from bench.judging.judge import judge
from bench.judging.question import Question
from bench.record import Cell, Worker

SETUP_NS = 10_000_000
"""Building is repeated for this long, or SETUPS times."""
SETUPS = 4
BINDING_SHARE = 4
"""The binding's own clock gets 1 / BINDING_SHARE of a cell's budget."""


def main() -> None:
    """Do every task of the job on stdin; end by itself after the last."""
    pipe = int(sys.argv[1])
    job = msgspec.json.decode(sys.stdin.buffer.read(), type=Job)
    settle(job)

    def send(message: Message) -> None:
        os.write(pipe, msgspec.json.encode(message) + b"\n")

    line = Worker(
        method=job.method,
        start=job.start,
        level=job.level,
        repeat=job.repeat,
        startup_ns=time.monotonic_ns() - job.spawned_ns,
        canary_ns=canary_ns(),
        core=job.core,
    )
    for number, task in enumerate(job.tasks):
        send(Begin(number))
        try:
            send(done(task, number, job, line))
        except (NotInstalled, NotApplicable) as reason:
            send(Failed(number, "missing" if isinstance(reason, NotInstalled) else "refused", str(reason)))
        except MemoryError:
            gib = job.memory_bytes / 2**30
            send(Failed(number, "failed", f"out of memory: it wanted more than {gib:.3g} GiB"))
            os._exit(0)  # what leaked would fail the next task too; the parent starts a new process
        except (Exception, SystemExit) as error:
            said = " ".join(str(error).split())
            send(Failed(number, "failed", f"{type(error).__name__}: {said}"[:300]))
    line.peak_rss_bytes = peak_rss_bytes()
    send(line)


def done(task: Task, number: int, job: Job, line: Worker) -> Message:
    """Do one task; what there is to say of it."""
    match task:
        case MeasureTask():
            return measure(task, Question.load(Path(task.question)), job, line)
        case AnswerTask():
            vehicle, taus = load_case(Path(task.case))
            allocator = prepared(job, vehicle)
            many = getattr(allocator, "many", partial(one_by_one, allocator, k=vehicle.k, n=vehicle.n))
            F, status = many(taus)
            save(Path(task.answers), F=F, status=status)
            return AnswersWritten(number)
        case DescribeTask():
            try:
                entry = entry_of(job.method, job.plugin)
            except UnknownName as error:  # it is no plug-in: what the file's owner must hear
                return Failed(number, "refused", str(error))
            return Described(method_line(entry), entry.starts, entry.levels)


@cache
def entry_of(method: str, plugin: str | None) -> Entry:
    """The method that a job is about, imported once."""
    return load_plugin(Path(plugin)) if plugin else find(method)


def settle(job: Job) -> None:
    """Pin this process to its core, bound its memory, and have it die with its parent."""
    if job.core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {job.core})
    if sys.platform == "linux":
        import ctypes
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (job.memory_bytes, job.memory_bytes))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        pr_set_pdeathsig, sigkill = 1, 9  # prctl(2)
        ctypes.CDLL(None).prctl(pr_set_pdeathsig, sigkill)


def measure(task: MeasureTask, question: Question, job: Job, line: Worker) -> Cell:
    """Set up, time, judge."""
    allocator, setup_ns = set_up(lambda: callable_of(job, question.demands.vehicle))
    if line.import_ns is None and len(setup_ns) > 1:  # the first build of this process
        line.import_ns = setup_ns[0] - min(setup_ns[1:])
        setup_ns = setup_ns[1:]
    cell = Cell(task.key, "ok", n_demands=len(question.demands.taus), setup_ns=setup_ns)
    core = job.core if job.core is not None else 0
    # A copy: a method that writes into its demand must not change what it is judged by.
    taus = list(question.demands.taus.copy())
    with no_garbage_collection():
        before = reading(core)
        samples: Samples[Any] = sample(allocator, taus, job.budget_ns)
        binding = time_binding(allocator, question, job.budget_ns // BINDING_SHARE)
        cell.quiet = between(before, reading(core))
        cell.canary_ns = canary_ns()
    cell.batches, cell.binding_batches = samples.batches, binding.batches
    cell.singles = counted(samples.singles)
    cell.timed_ns = samples.timed_ns + binding.timed_ns
    if job.method not in YARDSTICKS:
        cell.allocator_bytes = reachable_bytes(allocator)
        describe(cell, allocator, samples.answers, question)
    return cell


def prepared(job: Job, vehicle: Vehicle) -> Allocator:
    """The allocator of a job's method."""
    return prepare(entry_of(job.method, job.plugin), vehicle, start=job.start, level=job.level)


def callable_of(job: Job, vehicle: Vehicle) -> Any:
    """What a job calls: a yardstick, or the method's allocator."""
    return yardstick(job.method) if job.method in YARDSTICKS else prepared(job, vehicle)


def set_up(build: Callable[[], Any]) -> tuple[Any, list[int]]:
    """The allocator, and how long each of several builds took [ns]."""
    times: list[int] = []
    end = time.perf_counter_ns() + SETUP_NS
    while len(times) < 2 or (len(times) < SETUPS and time.perf_counter_ns() < end):
        start = time.perf_counter_ns()
        allocator = build()
        times.append(time.perf_counter_ns() - start)
    return allocator, times


def time_binding(allocator: Any, question: Question, budget_ns: int) -> Samples[Any]:
    """Time the solver's binding alone, b -> x over prepared b's, where the allocator has one."""
    if not isinstance(allocator, TwoStage):
        return Samples()
    b = [allocator.pose(tau) for tau in question.demands.taus]
    return sample(allocator.solve, b, budget_ns, singles=0)


def describe(cell: Cell, allocator: Allocator, answers: list[Allocation], question: Question) -> None:
    """What the allocator says of itself, and what the equations say of its answers."""
    cell.formulation, cell.limited = allocator.formulation, allocator.limited
    cell.worst_case_steps = allocator.worst_case_steps if isinstance(allocator, BoundedSteps) else None
    _, _, iterations, solver_s = zip(*answers, strict=True)
    own_clock = np.rint(np.array(solver_s) * 1e9)
    cell.solver_singles = counted(own_clock[np.isfinite(own_clock)].astype(np.int64).tolist())
    cell.iterations_max = max(iterations)
    cell.judged = judge(
        question,
        answers,
        formulation=allocator.formulation,
        limited=allocator.limited,
        tolerance=allocator.tolerance,
        thorough=cell.key.repeat == 0,
    )


if __name__ == "__main__":
    main()
