"""Inputs of a run: all are read, then all are doubted, before anything is measured."""

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from alloc import NotApplicable, Vehicle, catalogue, list_vehicles, load_vehicle
from alloc.discovery import Entry, plugin_name, unknown_method
from alloc.errors import DemandError, PluginError, UnknownName
from alloc.formulations import EXACT_METHODS, find_formulation
from alloc.vehicle.azimuth import refuse_pieces
from bench.demands import DemandSet, build_demands
from bench.demands.generated import STUDIES
from bench.demands.store import Case, same_vehicle, save_case
from bench.harness.lines import method_line
from bench.harness.plan import Contender, RunSettings, check, check_offers
from bench.harness.process import AnswerTask, Described, DescribeTask, Failed, Job, Task, work
from bench.harness.timing import YARDSTICKS
from bench.inputs.faults import faulty
from bench.record import NO_VEHICLE, Method


class RunDemands(NamedTuple):
    """Demands of a run, as read.

    Attributes
    ----------
    vehicles : that the settings name, without faults
    states : the vehicles of a study and those named, then each of them with every fault
    each : each demand set of each state, as often as it is named; the vehicles of a study come first
    lacking : by demand set, the vehicles by the reason why they have no such demands
    """

    vehicles: list[Vehicle]
    states: list[Vehicle]
    each: list[DemandSet]
    lacking: dict[str, dict[str, list[str]]]

    @property
    def sets(self) -> list[DemandSet]:
        """The demand sets, each once."""
        sets: dict[tuple[str, str], DemandSet] = {}
        for made in self.each:
            sets.setdefault((made.vehicle.name, made.name), made)
        return list(sets.values())


class Inputs(NamedTuple):
    """Everything that a run reads.

    Attributes
    ----------
    settings : which name all the rest
    contenders : the plug-ins, then the methods of the catalogue
    demands : vehicles and demand sets
    """

    settings: RunSettings
    contenders: list[Contender]
    demands: RunDemands


def read_inputs(settings: RunSettings) -> Inputs:
    """Read methods, plug-ins, vehicles, logs and demand sets; raises what can't be read."""
    check(settings)  # at once: numbers that contradict each other need no file
    return Inputs(settings, read_contenders(settings), read_demands(settings))


def doubt_inputs(inputs: Inputs) -> list[str]:
    """Doubts that do not end the run, one line each; raises what ``doubt_contenders`` and others raise."""
    return [
        *doubt_contenders(inputs.contenders, inputs.settings),
        *doubt_demands(inputs.demands),
    ]


def read_contenders(settings: RunSettings) -> list[Contender]:
    """Read the plug-ins, then the methods of the catalogue.

    A name may be a pattern as a shell has it, ``qp/*``. A plug-in takes part whether it is named or not.
    Whoever names methods gets them: ``settings.without``, and what a method's own file says, leave some
    out of all methods only. Raises UnknownName for a name that no method has.
    """
    plugged = plugin_contenders(settings)
    wanted = settings.methods or (() if plugged else ("*",))
    known = [*(contender.method.name for contender in plugged), *(entry.name for entry in catalogue())]
    for name in wanted:
        if not any(fnmatchcase(method, name) for method in known):
            raise unknown_method(name, known)  # a plug-in's file a_b.py holds the method a-b
    chosen = [
        Contender(method=method_line(entry), starts=entry.starts, levels=entry.levels, missing=entry.missing)
        for entry in catalogue()
        if any(fnmatchcase(entry.name, name) for name in wanted)
        and (settings.methods or is_usual(entry, settings.without))
    ]
    return [*plugged, *chosen]


def is_usual(entry: Entry, without: tuple[str, ...]) -> bool:
    """True for a method that takes part where none is named."""
    return not entry.named_only and {entry.name, entry.family, entry.solver}.isdisjoint(without)


def doubt_contenders(contenders: list[Contender], settings: RunSettings) -> list[str]:
    """One line for each plug-in that goes wrong when it is tried.

    Raises UnknownName for a plug-in whose name is taken: two methods of one name would share their rows.
    Raises SettingsError for a named method, or a plug-in, that has none of the starts or levels that were
    named: it would be left without a row.
    """
    plugged = [contender for contender in contenders if contender.plugin]
    chosen = [contender for contender in contenders if not contender.plugin]
    for contender in [*plugged, *(c for c in chosen if c.method.name in settings.methods)]:
        check_offers(contender, settings)
    taken = {contender.method.name for contender in chosen} | {*sampled_methods(chosen), *YARDSTICKS}
    for contender in plugged:
        if contender.method.name in taken:
            raise UnknownName(
                f"{contender.plugin}: another method is called '{contender.method.name}' too; rename the file"
            )
        taken.add(contender.method.name)
    return [contender.trouble for contender in plugged if contender.trouble]


def plugin_contenders(settings: RunSettings) -> list[Contender]:
    """The plug-ins, each imported, built for the run's first vehicle and asked twice by a worker.

    A file that crashes or hangs meanwhile takes part under its name. The run measures a plug-in that has a
    ``trouble`` too, and its rows say why it has no times; its author should not have to wait for that.
    Raises PluginError where a file is no plug-in.
    """
    if not settings.plugins:
        return []
    vehicle = load_vehicle((settings.vehicles or list_vehicles())[0])
    taus = np.array([np.zeros(vehicle.k), 0.1 * vehicle.TP @ (vehicle.f_min + vehicle.f_max)])
    with TemporaryDirectory(prefix="thrustbench-") as folder:
        task = AnswerTask(str(Path(folder) / "case.npz"), str(Path(folder) / "answers.npz"))
        save_case(Path(task.case), Case(vehicle, taus))
        return [_described(path, vehicle.name, task, settings) for path in dict.fromkeys(settings.plugins)]


def _described(path: str, vehicle: str, task: AnswerTask, settings: RunSettings) -> Contender:
    name = plugin_name(path)
    contender = Contender(method=Method(name=name, plugin=True), plugin=path)
    tasks: list[Task] = [DescribeTask(), task]
    job = Job(method=name, plugin=path, tasks=tasks, memory_bytes=settings.memory_MB << 20)
    for message in work(job, settings.time_limit_s):
        if isinstance(message, Described):
            own = replace(message.method, plugin=True)
            contender = contender._replace(method=own, starts=message.starts, levels=message.levels)
        elif isinstance(message, Failed):
            if message.task == 0 and message.status == "refused":
                raise PluginError(message.reason)
            trouble = f"{path}, on {vehicle}: {message.status}: {message.reason}"
            contender = contender._replace(trouble=trouble)
    return contender


def sampled_methods(taking_part: Iterable[Contender]) -> list[str]:
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


def read_demands(settings: RunSettings) -> RunDemands:
    """Read every demand set of every vehicle with every fault; the vehicles of a study come first."""
    named = [load_vehicle(name) for name in settings.vehicles]
    for vehicle in named:
        refuse_pieces(vehicle.azimuths, "run")
    whole = [*(STUDIES[settings.study]() if settings.study else ()), *named]
    states = [state for vehicle in whole for state in faulty(vehicle, settings.faults)]
    made: list[DemandSet] = []
    lacking: dict[str, dict[str, list[str]]] = {}
    for vehicle in states:
        for name in settings.demands:
            try:
                made.append(
                    build_demands(
                        name,
                        vehicle,
                        settings.seed,
                        settings.n_demands,
                        settings.log,
                        whole=not vehicle.faults,  # every failure of every vehicle would take hours
                    )
                )
            except NotApplicable as reason:
                why = str(reason).removeprefix(f"{vehicle.name}: ")
                lacking.setdefault(name, {}).setdefault(why, []).append(vehicle.name)
    return RunDemands(named, [*whole, *states], made, lacking)


def doubt_demands(demands: RunDemands) -> list[str]:
    """One line for each set that some vehicles have no demands of, with each reason and its first vehicle.

    Raises NotApplicable where no set is left. Raises DemandError where two different vehicles or sets would
    share their names and so their rows: two logs of one name, or a vehicle file that kept the name of the
    file it was copied from.
    """
    by_key: dict[tuple[str, str], DemandSet] = {}
    for made in demands.each:
        key = (made.vehicle.name, made.name)
        if not _same(by_key.setdefault(key, made), made):
            raise DemandError(
                f"two different vehicles or demand sets are called '{key[0]}', '{key[1]}';"
                " change the name in a vehicle file, or rename a log"
            )
    lacking = [f"{name}: {_reasons(reasons)}" for name, reasons in demands.lacking.items()]
    if not by_key:
        raise NotApplicable(
            f"none of these vehicles has any of these demands ({'; '.join(lacking)}); name others"
        )
    by_name: dict[str, Vehicle] = {}
    for vehicle in demands.states:  # one called a-f2 would share its sections of the report with a, 2 off
        if vehicle.name == NO_VEHICLE:
            raise DemandError(f"a vehicle is called '{vehicle.name}', which stands for none; change its name")
        if not same_vehicle(by_name.setdefault(vehicle.name, vehicle), vehicle):
            raise DemandError(
                f"two different vehicles are called '{vehicle.name}'; change the name in a file"
            )
    return [f"demands left out: {line}" for line in lacking]


def _reasons(reasons: dict[str, list[str]]) -> str:
    """Each reason with the first vehicle that it is true of, and of how many more it is."""
    return "; ".join(
        f"{first}: {why}" + (f"; so for {len(others)} more" if others else "")
        for why, (first, *others) in reasons.items()
    )


def _same(a: DemandSet, b: DemandSet) -> bool:
    return same_vehicle(a.vehicle, b.vehicle) and np.array_equal(a.taus, b.taus)
