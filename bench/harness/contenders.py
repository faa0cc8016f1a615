"""The methods that take part in a run: those of the catalogue that were named, and plug-ins."""

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

from alloc import UnknownName, catalogue, find, find_formulation
from alloc.formulations import EXACT_METHODS
from bench.harness.job import Described, DescribeTask, Failed, Job
from bench.harness.lines import method_line
from bench.harness.plan import Contender, RunSettings
from bench.harness.process import work
from bench.record import Method


def contenders(settings: RunSettings) -> list[Contender]:
    """Plug-ins first, then the catalogue's.

    A name may be a pattern as a shell has it, ``qp/*``. Raises UnknownName for one that nothing has, or that
    two have: they would share their rows.
    """
    plugged = [described(path, settings) for path in dict.fromkeys(settings.plugins)]
    wanted = settings.methods or (() if plugged else ("*",))
    for name in wanted:
        if not any(fnmatchcase(entry.name, name) for entry in catalogue()):
            find(name)  # raises UnknownName, which lists what there is
    chosen = [
        Contender(method_line(entry), entry.starts, entry.levels, entry.missing)
        for entry in catalogue()
        if any(fnmatchcase(entry.name, name) for name in wanted) and entry.family not in settings.without
    ]
    names = [contender.method.name for contender in (*plugged, *chosen)]
    for contender in plugged:
        if names.count(contender.method.name) > 1:
            raise UnknownName(
                f"{contender.plugin}: another method is called '{contender.method.name}' too; rename the file"
            )
    return [*plugged, *chosen]


def described(path: str, settings: RunSettings) -> Contender:
    """The method in a file, as it says of itself in a process of its own; raises UnknownName for no plug-in.

    A file that crashes or hangs when imported takes part under its name: its rows say what it did.
    """
    name = Path(path).stem.replace("_", "-")
    job = Job(method=name, plugin=path, tasks=[DescribeTask()], memory_bytes=settings.memory_MB << 20)
    for message in work(job, settings.time_limit_s):
        if isinstance(message, Described):
            return Contender(message.method, message.starts, message.levels, plugin=path)
        if isinstance(message, Failed) and message.status == "refused":
            raise UnknownName(message.reason)
    return Contender(Method(name=name), plugin=path)


def sampled(taking_part: Iterable[Contender]) -> list[str]:
    """The methods whose share of a vehicle's capability is counted.

    Of what runs foreign code the twin in Python stands for it. A solver answers what its formulation does:
    the exact method stands for those that answer the optimum, and the demand set ``uniform`` tells whether
    that holds.
    """
    names: list[str] = []
    for method, _, _, missing, plugin in taking_part:
        if missing:
            continue
        if plugin or not method.foreign:
            names.append(method.name)
        elif method.twin:
            names.append(method.twin)
        elif find_formulation(method.formulation).optimal:
            names.append(EXACT_METHODS[0])
    return list(dict.fromkeys(names))
