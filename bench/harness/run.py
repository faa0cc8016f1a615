"""Parent process of a run: read, doubt, measure in one worker after the other, keep the record."""

import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import msgspec
import numpy as np

from bench.demands.store import Case, save_case
from bench.harness import machine
from bench.harness.inputs import Inputs, doubt_inputs, read_inputs, sampled_methods
from bench.harness.lines import header, problem
from bench.harness.plan import Contender, Group, RunSettings, groups
from bench.harness.process import STARTUP_S, AnswersWritten, AnswerTask, Failed, Job, work
from bench.harness.state import Progress, RunState, any_repeat
from bench.harness.timing import YARDSTICKS
from bench.judging.capability import measure_capabilities
from bench.judging.question import Answers, Ask, Unanswered, check_promises, questions
from bench.record import Cell, Header, Record, RecordError, Worker
from bench.record.file import Writer

WORKING = ".working-"
"""Prefix of the name of a run's working folder."""


def asker(
    contenders: Mapping[str, Contender],
    folder: Path,
    job: Job,
    time_limit_s: float,
    tell: Callable[[str], None],
) -> Ask:
    """An ``Ask`` whose methods run in workers.

    Parameters
    ----------
    contenders : methods by name; any other name is looked up in the catalogue
    folder : where demands and answers are stored
    job : what every worker is given besides its method and its tasks
    time_limit_s : of one case
    tell : is called with the name of the method that is asked now
    """

    def ask(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
        contender = contenders.get(method)
        if contender is not None and contender.missing:
            return [Unanswered("missing", contender.missing)] * len(cases)
        tell(f"{method}, untimed")
        tasks = [_task(folder, i, case) for i, case in enumerate(cases)]
        plugin = None if contender is None else contender.plugin
        return _answers(msgspec.structs.replace(job, method=method, plugin=plugin), tasks, time_limit_s)

    return ask


def _task(folder: Path, number: int, case: Case) -> AnswerTask:
    task = AnswerTask(str(folder / f"case-{number}.npz"), str(folder / f"answers-{number}.npz"))
    save_case(Path(task.case), case)
    return task


def _read(task: AnswerTask) -> Answers | Unanswered:
    try:
        with np.load(task.answers) as arrays:
            return Answers(arrays["F"], arrays["status"], check_promises(arrays))
    except (OSError, ValueError, KeyError) as error:  # only a method that writes into the pipe can do this
        return Unanswered("failed", f"it said that answers are written, and none can be read ({error})"[:200])


def _answers(job: Job, tasks: list[AnswerTask], time_limit_s: float) -> list[Answers | Unanswered]:
    """Start as many processes as it takes; after a task that reaches the time limit no other is tried."""
    outcomes: dict[int, Answers | Unanswered] = {}
    pending = list(range(len(tasks)))
    while pending:
        for message in work(msgspec.structs.replace(job, tasks=[tasks[i] for i in pending]), time_limit_s):
            if isinstance(message, AnswersWritten):
                outcomes[pending[message.task]] = _read(tasks[pending[message.task]])
            elif isinstance(message, Failed):
                failure = Unanswered(message.status, message.reason)
                outcomes[pending[message.task]] = failure
                if message.status == "timeout":
                    return [outcomes.get(i, failure) for i in range(len(tasks))]
        left = [i for i in pending if i not in outcomes]
        if left == pending:  # a worker that ends without a result would be started for ever
            failure = Unanswered("crashed", "the worker ended without a result")
            return [outcomes.get(i, failure) for i in range(len(tasks))]
        pending = left
    return [outcomes[i] for i in range(len(tasks))]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended a run; its record holds what was measured before."""


def run(
    settings: RunSettings,
    directory: Path,
    *,
    resume: bool,
    watch: Callable[[Progress], None],
    warn: Callable[[str], None] = lambda line: None,
) -> None:
    """Measure what the settings ask for into ``directory/record.jsonl``; tell ``watch`` how far the run is.

    ``warn`` is told of each plug-in that goes wrong, and of demands that there are not, before anything is
    measured.

    With ``resume``, cells that are in the record already are not measured again. Raises RecordError
    where the record can't be written or continued, and AllocError for unknown names. On Ctrl-C the
    worker is ended, the record says so, and Interrupted is raised.
    """
    began = time.monotonic()
    # Read and doubted before the folder is touched, so that a wrong name leaves nothing behind.
    inputs = read_inputs(settings)
    for line in doubt_inputs(inputs):
        warn(line)
    with Writer(directory) as writer, working_folder(directory) as folder:
        first = header(settings)
        old = writer.resume() if resume else None
        if old is None:
            writer.create(first)
        else:
            check_same(old.header, first, writer.path)
        state = RunState(settings=settings, writer=writer, watch=watch, began=began)
        state.event("began" if old is None else "resumed")
        try:
            with machine.reserve_core():
                known = old or Record(header=first)
                prepare(state, known, inputs, folder)
                planned = groups(settings, inputs.contenders, state.files, state.sequences)
                state.total = sum(len(group.keys) for group in planned)
                for group in planned:
                    measure(group, state)
        except KeyboardInterrupt:
            state.event("interrupted")
            raise Interrupted from None
        state.event("finished")


@contextmanager
def working_folder(directory: Path) -> Iterator[Path]:
    """A folder beside the record for what workers are asked, removed at the end.

    A run that is killed can't remove it. There the next run into ``directory`` finds it, and so does whoever
    removes the run's folder, as a fleet's host does where a run takes too long.
    """
    for left in directory.glob(f"{WORKING}*"):
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=directory, prefix=WORKING) as folder:
        yield Path(folder)


def prepare(
    state: RunState,
    known: Record,
    inputs: Inputs,
    folder: Path,
) -> None:
    """Get the right answers, store the questions, and record methods, problems and capabilities."""
    taking_part, named, sets = inputs.contenders, inputs.demands.vehicles, inputs.demands.sets
    by_name = {contender.method.name: contender for contender in taking_part}
    state.plugins = {name: c.plugin for name, c in by_name.items() if c.plugin}
    state.missing = {name: c.missing for name, c in by_name.items() if c.missing}
    state.done = known.keys()
    state.hung = {any_repeat(cell.key) for cell in known.cells if cell.status == "timeout"}
    listed = {method.name for method in known.methods}
    methods = [*(contender.method for contender in taking_part), *YARDSTICKS.values()]
    state.writer.extend(method for method in methods if method.name not in listed)
    limit_s = state.settings.time_limit_s
    # References are the catalogue's, whatever a plug-in is called, and a short limit is meant for cells.
    ask_reference = asker({}, folder, state.common_job(), max(limit_s, STARTUP_S), state.tell)
    in_record = {(line.vehicle, line.demands) for line in known.problems}
    ours = {vehicle.name for vehicle in named}
    # A plug-in may answer another formulation than its file says.
    answered = None if state.plugins else {contender.method.formulation for contender in taking_part}
    for i, question in enumerate(questions(sets, ask_reference, answered)):
        key = (question.demands.vehicle.name, question.demands.name)
        state.files[key] = folder / f"question-{i}.npz"
        question.save(state.files[key])
        if question.demands.rate_hz is not None:
            state.sequences.add(key)
        if key not in in_record:
            whole = question.demands.vehicle.whole or key[0]
            state.writer.append(problem(question, "" if whole in ours else state.settings.study))
    ask = asker(by_name, folder, state.common_job(), limit_s, state.tell)
    measured = {capability.vehicle for capability in known.capabilities}
    fresh = [vehicle for vehicle in named if vehicle.name not in measured]
    state.writer.extend(measure_capabilities(fresh, sampled_methods(taking_part), state.settings.seed, ask))
    state.ready = time.monotonic()


def measure(group: Group, state: RunState) -> None:
    """Measure the cells of a group that the record lacks, in as many processes as it takes."""
    pending = [key for key in group.keys if key not in state.done]
    hangs = 0
    while True:
        for excuse in [cell for key in pending if (cell := state.excuse(key, hangs))]:
            pending.remove(excuse.key)
            state.keep(excuse)
        if not pending:
            return
        state.tell(group.method)
        asked = tuple(pending)
        for line in work(state.job(group, pending), state.settings.time_limit_s):
            if isinstance(line, Worker):
                state.writer.append(line)
            elif isinstance(line, Failed):
                pending.remove(asked[line.task])
                state.keep(Cell(key=asked[line.task], status=line.status, reason=line.reason))
                hangs += line.status == "timeout"
            elif isinstance(line, Cell):
                pending.remove(line.key)
                state.keep(line)
        if len(pending) == len(asked):  # a worker that ends without a result would be started for ever
            reason = "the worker ended without a result"
            state.keep(Cell(key=pending.pop(0), status="crashed", reason=reason))


def check_same(old: Header, new: Header, path: Path) -> None:
    """Raise RecordError unless a record with the old header can be continued under the new one."""
    facts = [
        {"commit": header.commit, **header.versions, **header.settings, **header.machine, **header.files}
        for header in (old, new)
    ]
    for what in facts[0] | facts[1]:  # a package that was installed since is a difference too
        was, now = (header_facts.get(what) for header_facts in facts)
        if was != now:
            raise RecordError(
                f"{path}: was made with {what} {was!r}, this is {now!r}; give the same"
                " options to go on, or another --out"
            )
