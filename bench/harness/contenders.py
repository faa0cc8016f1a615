"""Methods that take part in a run: catalogue methods by name, and plug-ins."""

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from msgspec.structs import replace

from alloc import catalogue, list_vehicles, load_vehicle
from alloc.errors import UnknownName, unknown
from alloc.formulations import EXACT_METHODS, find_formulation
from bench.demands.store import Case, save_case
from bench.harness.lines import method_line
from bench.harness.plan import Contender, RunSettings, check_offers
from bench.harness.process import AnswerTask, Described, DescribeTask, Failed, Job, Task, work
from bench.harness.sets import vehicles
from bench.harness.timing import YARDSTICKS
from bench.record import Method


def contenders(settings: RunSettings) -> list[Contender]:
    """The plug-ins, then the methods of the catalogue.

    A name may be a pattern as a shell has it, ``qp/*``. A plug-in takes part whether it is named or not.
    Whoever names methods gets them: ``settings.without`` leaves families out of all methods only. Raises
    UnknownName for a name that no method has, and for a plug-in whose name is taken: two methods of one name
    would share their rows. Raises SettingsError for a named method, or a plug-in, that has none of the starts
    or levels that were named: it would be left without a row.
    """
    plugged = plugged_in(settings)
    wanted = settings.methods or (() if plugged else ("*",))
    known = [*(contender.method.name for contender in plugged), *(entry.name for entry in catalogue())]
    for name in wanted:
        if not any(fnmatchcase(method, name) for method in known):
            raise unknown("method", name, known)  # a plug-in's file a_b.py holds the method a-b
    chosen = [
        Contender(method=method_line(entry), starts=entry.starts, levels=entry.levels, missing=entry.missing)
        for entry in catalogue()
        if any(fnmatchcase(entry.name, name) for name in wanted)
        and (settings.methods or entry.family not in settings.without)
    ]
    for contender in [*plugged, *(c for c in chosen if c.method.name in wanted)]:
        check_offers(contender, settings)
    taken = {contender.method.name for contender in chosen} | {*sampled(chosen), *YARDSTICKS}
    for contender in plugged:
        if contender.method.name in taken:
            raise UnknownName(
                f"{contender.plugin}: another method is called '{contender.method.name}' too; rename the file"
            )
        taken.add(contender.method.name)
    return [*plugged, *chosen]


def plugged_in(settings: RunSettings) -> list[Contender]:
    """The plug-ins, each imported, built for the run's first vehicle and asked twice by a worker.

    A file that crashes or hangs meanwhile takes part under its name. The run measures a plug-in that has a
    ``trouble`` too, and its rows say why it has no times; its author should not have to wait for that.
    Raises UnknownName where a file is no plug-in.
    """
    if not settings.plugins:
        return []
    vehicle = (vehicles(settings) or [load_vehicle(list_vehicles()[0])])[0]
    taus = np.array([np.zeros(vehicle.k), 0.1 * vehicle.TP @ (vehicle.f_min + vehicle.f_max)])
    with TemporaryDirectory(prefix="thrustbench-") as folder:
        task = AnswerTask(str(Path(folder) / "case.npz"), str(Path(folder) / "answers.npz"))
        save_case(Path(task.case), Case(vehicle, taus))
        return [_described(path, vehicle.name, task, settings) for path in dict.fromkeys(settings.plugins)]


def _described(path: str, vehicle: str, task: AnswerTask, settings: RunSettings) -> Contender:
    name = Path(path).stem.replace("_", "-")
    contender = Contender(method=Method(name=name, plugin=True), plugin=path)
    tasks: list[Task] = [DescribeTask(), task]
    job = Job(method=name, plugin=path, tasks=tasks, memory_bytes=settings.memory_MB << 20)
    for message in work(job, settings.time_limit_s):
        if isinstance(message, Described):
            own = replace(message.method, plugin=True)
            contender = contender._replace(method=own, starts=message.starts, levels=message.levels)
        elif isinstance(message, Failed):
            if message.task == 0 and message.status == "refused":
                raise UnknownName(message.reason)
            trouble = f"{path}, on {vehicle}: {message.status}: {message.reason}"
            contender = contender._replace(trouble=trouble)
    return contender


def sampled(taking_part: Iterable[Contender]) -> list[str]:
    """The methods whose share of a vehicle's capability is counted.

    A method that runs foreign code is represented by its twin in Python. A solver without a twin is
    represented by the exact method where its formulation has one optimum; the demand set ``uniform``
    tells whether the solver reaches it.
    """
    names: list[str] = []
    for contender in taking_part:
        method = contender.method
        if contender.missing:
            continue
        if contender.plugin or not method.foreign:
            names.append(method.name)
        elif method.twin:
            names.append(method.twin)
        elif find_formulation(method.formulation).optimal:
            names.append(EXACT_METHODS[0])
    return list(dict.fromkeys(names))
