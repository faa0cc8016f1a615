"""Worker process for one method: read a Job on stdin, send messages through a pipe.

Solvers print on stdout and stderr, so the pipe is a file of its own: ``python -m bench.harness.worker FD``.
"""

import gc
import os
import sys
import time
import traceback
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from alloc import Allocation, Allocator, NotApplicable, Vehicle, solvers
from alloc.allocation import BoundedSteps, FloatArray, StatusArray, TwoStage, real
from alloc.discovery import Entry, find, load_plugin, prepare
from alloc.errors import DemandError, NotInstalled, PluginError, UnknownName
from alloc.foreign import is_library, runs_apart
from alloc.live.plain import ANY_DISTANCE
from alloc.vehicle.call_limits import one_by_one
from bench.demands.store import Case, load_case, save
from bench.harness.counters import quiet_since
from bench.harness.process import (
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
from bench.harness.timing import (
    YARDSTICKS,
    Samples,
    canary_ns,
    no_garbage_collection,
    sample,
    tally,
    yardstick,
)
from bench.judging.judge import judge
from bench.judging.question import Question, read_promises
from bench.record import Cell, Worker

if TYPE_CHECKING:
    from bench.harness.conduct import Census

ASKED = 50
"""Demands of a case that are asked in single calls too."""
MOST_APART = 2
"""Number of them that may be answered otherwise: warm starts make results depend slightly on order."""
ROUGHLY = 1e-3
"""Distance by which answers may differ where none is promised, relative to the largest limit [-]."""


def answer_case(allocator: Allocator, case: Case, *, brought: bool) -> tuple[FloatArray, StatusArray]:
    """Thrusts (N, n) [N] and statuses (N,) by ``many``, or by calls where an allocator has no such function.

    ``brought`` says that the method is a user's: then ``many`` is held against single calls, since what is
    reported of it is what a vehicle is sent call by call. Raises ValueError where it answers otherwise or not
    once a demand, TypeError where thrusts are no real numbers.
    """
    vehicle, taus, f_min, f_max = case
    many = getattr(allocator, "many", None)
    together = many or partial(one_by_one, allocator, vehicle)
    asked = taus.copy()  # a method may write into what it is given
    answers, statuses = together(asked) if f_min is None else together(asked, f_min, f_max)
    F, given = real(np.asarray(answers)), np.asarray(statuses)
    if given.dtype.kind not in "iu":
        raise TypeError(f"many() gave statuses of type {given.dtype}; give values of alloc.Status")
    status = given.astype(np.int8)
    if F.shape != (len(taus), vehicle.n) or status.shape != (len(taus),):
        raise ValueError(
            f"many() gave thrusts of shape {F.shape} and statuses of shape {status.shape}"
            f" for {len(taus)} demands on {vehicle.n} thrusters"
        )
    if brought and many:
        _check_many(allocator, case, F)
    return F, status


def _check_many(allocator: Allocator, case: Case, F: FloatArray) -> None:
    """Raise ValueError where single calls give other thrusts than those of ``many``, F (N, n) [N]."""
    vehicle, *columns = case
    rows = np.linspace(0, len(F) - 1, min(ASKED, len(F)), dtype=int)
    calls = [column[rows].copy() for column in columns if column is not None]
    single = np.array([allocator(*call)[0] for call in zip(*calls, strict=True)], dtype=float)
    tolerance = allocator.tolerance
    allowed = (2 * tolerance if tolerance < ANY_DISTANCE else ROUGHLY) * vehicle.f_scale
    same = (np.abs(single - F[rows]) <= allowed) | (np.isnan(single) & np.isnan(F[rows]))
    if np.count_nonzero(~same.all(axis=1)) > min(MOST_APART, len(rows) - 1):
        first = rows[(~same.all(axis=1)).argmax()]
        raise ValueError(f"many() gives demand {first} other thrusts than a call of its own")


_CODE = (type, ModuleType, BuiltinFunctionType, Vehicle)


def reachable_bytes(thing: object) -> int:
    """Bytes of all Python objects and arrays reachable from ``thing``.

    Code, modules and the vehicle, which is the caller's, are left out. Python can't see what the C or C++
    side of a solver allocates for itself; the peak RSS of the worker includes it.
    """
    seen: set[int] = set()
    todo: list[Any] = [thing]
    total = 0
    while todo:
        held = todo.pop()
        if id(held) in seen or isinstance(held, _CODE):
            continue
        seen.add(id(held))
        if isinstance(held, FunctionType):
            # A cell of a name that nothing was ever given is empty, and has no contents to ask for.
            todo += gc.get_referents(*(held.__closure__ or ()))
            continue
        total += sys.getsizeof(held)
        if isinstance(held, np.ndarray):
            if held.base is not None:
                todo.append(held.base)
        else:
            todo += gc.get_referents(held)
    return total


def peak_rss_bytes() -> int | None:
    """High-water mark of this process's resident memory [bytes], None where the system does not tell.

    It is read from /proc: getrusage's ru_maxrss of a child starts at its parent's (Linux, exec(2) keeps it).
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return None
    line = next((line for line in status.splitlines() if line.startswith("VmHWM:")), None)
    return None if line is None else int(line.split()[1]) * 1024


SETUP_NS = 10_000_000
"""An allocator is built again and again for this long, at most SETUPS times."""
SETUPS = 4
"""Builds that are timed; what a process builds first imports the method, so it is built twice at least."""
BINDING_SHARE = 4
"""A solver's binding, and the way in to somebody's code, are timed for 1 / BINDING_SHARE of a budget."""


def main() -> None:
    """Do every task of the job on stdin, then end."""
    pipe, own_id = int(sys.argv[1]), os.getpid()
    job = msgspec.json.decode(sys.stdin.buffer.read(), type=Job)
    settle(job)

    def send(message: Message) -> None:
        if os.getpid() != own_id:  # a method forked this process, and its copy must not answer too
            os._exit(1)
        os.write(pipe, msgspec.json.encode(message) + b"\n")

    line = Worker(
        method=job.method,
        start=job.start,
        level=job.level,
        repeat=job.repeat,
        canary_ns=canary_ns(),
        core=job.core,
    )
    for number, task in enumerate(job.tasks):
        send(Begin(number))
        try:
            send(do(task, number, job, line))
        except (NotInstalled, NotApplicable) as reason:
            status = "missing" if isinstance(reason, NotInstalled) else "refused"
            send(Failed(number, status, str(reason)))
        except MemoryError:
            gib = job.memory_bytes / 2**30
            send(Failed(number, "failed", f"out of memory: it wanted more than {gib:.3g} GiB"))
            os._exit(0)  # memory that leaked would fail the next task too; the parent starts a new process
        except (Exception, SystemExit) as error:
            one_line = " ".join(str(error).split())
            place = failing_line(error, job.plugin)
            send(Failed(number, "failed", f"{place}{type(error).__name__}: {one_line}"[:300]))
    line.peak_rss_bytes = peak_rss_bytes()
    send(line)


def failing_line(error: BaseException, plugin: str | None) -> str:
    """``line 12: ``, where the plug-in's own code was when it went wrong; empty elsewhere."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if plugin and f.filename == plugin]
    return f"line {frames[-1].lineno}: " if frames else ""


def do(task: Task, number: int, job: Job, line: Worker) -> Message:
    """Do one task; the message that it ends with."""
    match task:
        case MeasureTask():
            return measure(task, job, line)
        case AnswerTask():
            write_answers(task, job)
            return AnswersWritten(number)
        case DescribeTask():
            # Few workers are asked for a line, and the module imports what describes machines.
            from bench.harness.lines import method_line

            try:
                entry = find_entry(job.method, job.plugin)
            except (PluginError, UnknownName) as error:  # the file is no plug-in, which ends the run
                return Failed(number, "refused", str(error))
            return Described(method_line(entry), entry.starts, entry.levels)


@cache
def find_entry(method: str, plugin: str | None) -> Entry:
    """The entry of a job's method, imported once."""
    return load_plugin(plugin) if plugin else find(method)


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


def write_answers(task: AnswerTask, job: Job) -> None:
    """Answer a case and write thrusts and statuses; raises what ``answer_case`` does."""
    case = load_case(Path(task.case))
    allocator = build_allocator(job, case.vehicle)
    F, status = answer_case(allocator, case, brought=job.plugin is not None)
    promises = {name: np.array(value) for name, value in read_promises(allocator).items()}
    save(Path(task.answers), F=F, status=status, **promises)


def measure(task: MeasureTask, job: Job, line: Worker) -> Cell:
    """Set a method up, time its calls on a question, and judge its answers."""
    # A vehicle of its own: a method that writes into it must not change what it is judged by.
    question, given = Question.load(Path(task.question))
    supply = question.demands.supply.arguments
    allocator, setup_ns = set_up(lambda: build_callable(job, given), 2 if line.import_ns is None else 1)
    if line.import_ns is None:  # the first build of a process imports the method
        line.import_ns = setup_ns[0] - min(setup_ns[1:])
        setup_ns = setup_ns[1:]
    cell = Cell(key=task.key, status="ok", n_demands=len(question.demands.taus), setup_ns=setup_ns)
    timed = question.timed
    inputs = arguments(timed, allocator)
    call = allocator
    if supply and job.method not in YARDSTICKS:
        call = partial(allocator, **supply)  # 0.1 us a call
        try:
            call(*next(zip(*inputs, strict=True)))
        except DemandError as refusal:
            raise NotApplicable(str(refusal)) from None
    solvers.disbelieved.clear()
    before = census(job)
    with no_garbage_collection():
        quiet = quiet_since(job.core or 0)
        samples: Samples[Any] = sample(call, inputs, job.budget_ns)
        after = census(job)
        cell.disbelieved = dict(solvers.disbelieved)
        binding = time_binding(allocator, timed, job.budget_ns // BINDING_SHARE)
        way_in = time_idle_calls(job, given, inputs, supply)
        cell.quiet = quiet()
        cell.canary_ns = canary_ns()
    cell.batches, cell.binding_batches, cell.way_in_batches = samples.batches, binding.batches, way_in.batches
    cell.singles = tally(samples.singles)
    cell.timed_ns = samples.timed_ns + binding.timed_ns + way_in.timed_ns
    if job.method not in YARDSTICKS:
        cell.allocator_bytes = reachable_bytes(allocator)
        describe(cell, allocator, samples.answers, timed)
        asked = arguments(timed, allocator)
        amiss = [WRITES] if any(map(has_changed, inputs, asked)) else []
        if before and after:
            from bench.harness.conduct import leftovers, misconduct

            # More calls of what leaves threads or processes behind might exhaust the machine.
            amiss += leftovers(before, after) or misconduct(allocator, asked, samples.answers, timed.demands)
        if cell.judged and amiss:
            cell.judged.wrong = "; ".join(filter(None, (cell.judged.wrong, *amiss)))
        if timed is not question:
            judge_whole(cell, allocator, question)
    return cell


def judge_whole(cell: Cell, allocator: Allocator, question: Question) -> None:
    """Ask all of a mission, untimed, and put its verdict in place of that on the part that was timed.

    What was wrong or far off in a timed answer stays so. In later repeats no answer is counted again.
    """
    began, part = time.perf_counter_ns(), cell.judged
    assert part is not None
    part.answers, part.counts = 0, {}
    if cell.key.repeat == 0:
        answers = [allocator(*call) for call in zip(*arguments(question), strict=True)]
        describe(cell, allocator, answers, question)
        whole = cell.judged
        assert whole is not None
        whole.wrong = whole.wrong or part.wrong
        whole.agrees = False if part.agrees is False else whole.agrees
    cell.judging_ns = time.perf_counter_ns() - began


def arguments(question: Question, allocator: Any = None) -> list[list[FloatArray]]:
    """Arguments of each call: tau, f_min and f_max where they move, and f_previous of somebody's library.

    All are copies: a method that writes into one must not change what it is judged by.
    """
    demands = question.demands
    columns = [demands.taus, demands.f_min, demands.f_max]
    columns += [demands.f_previous] * (getattr(allocator, "stated_residual", None) is not None)
    return [list(column.copy()) for column in columns if column is not None]


WRITES = "it writes into what it is given, which is the caller's"


def has_changed(given: list[FloatArray], asked: list[FloatArray]) -> bool:
    """True if arrays differ from what they were when a method got them."""
    return not np.array_equal(given, asked, equal_nan=True)


def build_allocator(job: Job, vehicle: Vehicle) -> Allocator:
    """The allocator of a job's method."""
    return prepare(find_entry(job.method, job.plugin), vehicle, start=job.start, level=job.level)


def build_callable(job: Job, vehicle: Vehicle) -> Any:
    """The function whose calls are timed: a yardstick, or the allocator of a job's method."""
    return yardstick(job.method) if job.method in YARDSTICKS else build_allocator(job, vehicle)


def set_up(build: Callable[[], Any], least: int) -> tuple[Any, list[int]]:
    """Allocator from ``build``, and the time of each build, ``least`` or more [ns]."""
    times: list[int] = []
    end = time.perf_counter_ns() + SETUP_NS
    while len(times) < least or (len(times) < SETUPS and time.perf_counter_ns() < end):
        start = time.perf_counter_ns()
        allocator = build()
        times.append(time.perf_counter_ns() - start)
    return allocator, times


def time_binding(allocator: Any, question: Question, budget_ns: int) -> Samples[Any]:
    """Time the binding of a solver alone over problems that are posed, where the allocator is a TwoStage."""
    if not isinstance(allocator, TwoStage):
        return Samples()
    calls = zip(*arguments(question), strict=True)
    # Limits that contradict themselves never reach a solver.
    posed = [
        allocator.pose(tau, *limits) for tau, *limits in calls if not limits or (limits[0] <= limits[1]).all()
    ]
    return sample(allocator.solve, list(zip(*posed, strict=True)), budget_ns, singles=0)


def census(job: Job) -> "Census | None":
    """Threads and processes now; None but for somebody's library or program that says to have no memory."""
    plugin = job.plugin
    if plugin is None or job.start == "warm" or not (runs_apart(plugin) or is_library(Path(plugin))):
        return None
    from bench.harness.conduct import take_census  # few workers have to read /proc

    return take_census()


def time_idle_calls(job: Job, vehicle: Vehicle, inputs: list[Any], supply: dict[str, float]) -> Samples[Any]:
    """Time idle calls by the way to somebody's library or program; none for other methods."""
    entry = None if job.plugin is None else find_entry(job.method, job.plugin)
    if entry is None or entry.idle_call is None:
        return Samples()
    idle, budget_ns = partial(entry.idle_call(vehicle), **supply), job.budget_ns // BINDING_SHARE
    return sample(idle, inputs, budget_ns, singles=0)


def describe(cell: Cell, allocator: Allocator, answers: list[Allocation], question: Question) -> None:
    """Put into the cell what the allocator says of itself, and what the equations say of its answers."""
    promises = read_promises(allocator)
    cell.formulation, cell.limited = promises["formulation"], promises["limited"]
    cell.worst_case_steps = allocator.worst_case_steps if isinstance(allocator, BoundedSteps) else None
    _, _, iterations, solver_s, *_ = zip(*answers, strict=True)
    if not cell.solver_singles:  # of the answers that were timed, which come first
        own_clock = np.rint(np.array(solver_s) * 1e9)
        cell.solver_singles = tally(own_clock[np.isfinite(own_clock)].astype(np.int64).tolist())
    cell.iterations_max = max(*iterations, cell.iterations_max or 0)
    cell.judged = judge(question, answers, **promises, thorough=cell.key.repeat == 0)


if __name__ == "__main__":
    main()
