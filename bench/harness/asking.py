"""Methods asked for answers in processes of their own: one that crashes or hangs costs its own answers."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np

from bench.demands.store import save_case
from bench.harness.job import AnswersWritten, AnswerTask, Failed, Job
from bench.harness.plan import Contender
from bench.harness.process import work
from bench.judging.question import Answers, Ask, Case, Unanswered


def asker(
    contenders: Mapping[str, Contender],
    folder: Path,
    job: Job,
    time_limit_s: float,
    tell: Callable[[str], None],
) -> Ask:
    """An ``Ask`` that goes through workers like ``job``; files go into ``folder``, ``tell`` hears the method.

    A method that is no contender is the catalogue's.
    """

    def ask(method: str, cases: Sequence[Case]) -> list[Answers | Unanswered]:
        contender = contenders.get(method)
        if contender is not None and contender.missing:
            return [Unanswered("missing", contender.missing)] * len(cases)
        tell(f"{method}, untimed")
        tasks = [_task(folder, i, case) for i, case in enumerate(cases)]
        plugin = None if contender is None else contender.plugin
        own = msgspec.structs.replace(job, method=method, plugin=plugin)
        return _answers(own, tasks, time_limit_s)

    return ask


def _task(folder: Path, number: int, case: Case) -> AnswerTask:
    task = AnswerTask(str(folder / f"case-{number}.npz"), str(folder / f"answers-{number}.npz"))
    save_case(Path(task.case), *case)
    return task


def _answers(job: Job, tasks: list[AnswerTask], time_limit_s: float) -> list[Answers | Unanswered]:
    """In as many processes as it takes; after a task that hangs the others are not tried."""
    said: dict[int, Answers | Unanswered] = {}
    pending = list(range(len(tasks)))
    while pending:
        for message in work(msgspec.structs.replace(job, tasks=[tasks[i] for i in pending]), time_limit_s):
            if isinstance(message, AnswersWritten):
                with np.load(tasks[pending[message.task]].answers) as arrays:
                    said[pending[message.task]] = Answers(arrays["F"], arrays["status"])
            elif isinstance(message, Failed):
                why = Unanswered(message.status, message.reason)
                said[pending[message.task]] = why
                if message.status == "timeout":
                    return [said.get(i, why) for i in range(len(tasks))]
        left = [i for i in pending if i not in said]
        if left == pending:  # a worker that ends without a word must not be started for ever
            return [said.get(i, Unanswered("crashed", "the worker said nothing")) for i in range(len(tasks))]
        pending = left
    return [said[i] for i in range(len(tasks))]
