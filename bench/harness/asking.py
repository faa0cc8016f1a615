"""Methods answer demands in processes of their own: one that crashes or hangs costs its own answers only."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np

from bench.demands.store import Case, save_case
from bench.harness.job import AnswersWritten, AnswerTask, Failed, Job
from bench.harness.plan import Contender
from bench.harness.process import work
from bench.judging.question import Answers, Ask, Unanswered, checked_promises


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
            return Answers(arrays["F"], arrays["status"], checked_promises(arrays))
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
