"""Settings of a run, with the presets of `thrustbench run`, and the order of its measurements."""

import random
from collections.abc import Container, Iterable
from fnmatch import fnmatchcase
from typing import NamedTuple

import msgspec

from alloc import AllocError, list_vehicles
from alloc.formulations import Family, find_formulation
from alloc.solvers import slow
from bench.harness.timing import CANARIES, YARDSTICKS
from bench.inputs.faults import EACH, GivenFault
from bench.inputs.logs import LogOptions
from bench.record import NO_VEHICLE, Key, Method

OVERHEAD_S = 0.03
"""Time that a cell takes besides its timed calls (starting up, setting up, judging), until a run has measured
its own."""
LEAST_MS, MOST_MS = 15.0, 100.0
"""Bounds of a cell's budget: the lower one is a handful of batches, and no statistic here gains from a budget
beyond the upper one."""


class SettingsError(AllocError):
    """Two settings of a run contradict each other."""


class RunSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Everything that decides what a run measures; the record's header keeps it.

    Attributes
    ----------
    demands, vehicles : names or paths
    methods : names, or patterns as a shell has them; empty for all
    without : methods, families of methods and solvers that are left out
    study : a study out of ``bench.demands.generated``, whose vehicles are measured too
    plugins : files with a method
    faults : of each vehicle, one at a time; None is the whole vehicle
    once : patterns of methods, families and demand sets that are measured in the first repeat only
    log : what logs among the demands do not say themselves
    starts, levels : those to take of what a method offers; empty: see ``matching_choices``
    repeats : fresh processes of each method
    seed : of demands and order
    n_demands : demands of each set
    budget_ms : timed calls of a cell in one repeat [ms]; None: whatever lets the run take about ``target_s``
    target_s : how long the run should take [s]
    time_limit_s : most that a cell may take [s]
    memory_MB : most memory that a worker may allocate [MB]
    """

    demands: tuple[str, ...]
    vehicles: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    study: str = ""
    plugins: tuple[str, ...] = ()
    faults: tuple[GivenFault | None, ...] = (None,)
    once: tuple[str, ...] = ()
    log: LogOptions = LogOptions()
    starts: tuple[str, ...] = ()
    levels: tuple[str, ...] = ()
    repeats: int = 2
    seed: int = 0
    n_demands: int = 60
    budget_ms: float | None = None
    target_s: float = 155.0
    time_limit_s: float = 10.0
    memory_MB: int = 2048


class Contender(NamedTuple):
    """A method that takes part in a run.

    Attributes
    ----------
    method : what the record keeps of it
    starts, levels : what it offers
    missing : what to install for the method, empty where nothing is missing
    plugin : file of a plug-in, None for a method of the catalogue
    trouble : what goes wrong with a plug-in when it is tried before the run, empty for nothing
    """

    method: Method
    starts: tuple[str, ...] = ("-",)
    levels: tuple[str, ...] = ("-",)
    missing: str = ""
    plugin: str | None = None
    trouble: str = ""


class Group(msgspec.Struct, frozen=True, kw_only=True):
    """Work of one worker process: a method with its start and level, once.

    Attributes
    ----------
    method, start, level, repeat : what the worker runs
    keys : the cells, in order
    """

    method: str
    start: str
    level: str
    repeat: int
    keys: tuple[Key, ...]


def groups(
    settings: RunSettings,
    contenders: Iterable[Contender],
    asked: Iterable[tuple[str, str]],
    sequences: Container[tuple[str, str]] = (),
) -> list[Group]:
    """The keys of every worker, repeat by repeat, shuffled within each so that drift hits all methods alike.

    ``asked`` are the (vehicle, demand set) pairs of the run, ``sequences`` those whose demands follow each
    other in time: there every start is measured, since only there a last answer is worth something. The
    yardsticks are added to the contenders.
    """
    pairs = list(asked)
    in_a_row = [pair for pair in pairs if pair in sequences]
    choices = [(pairs, c.method, *choice) for c in contenders for choice in matching_choices(c, settings)]
    choices += [(in_a_row, c.method, *choice) for c in contenders for choice in other_starts(c, settings)]
    choices += [(pairs, yardstick, "-", "-") for yardstick in YARDSTICKS.values()]
    dice = random.Random(settings.seed)
    planned: list[Group] = []
    for repeat in range(settings.repeats):
        dice.shuffle(choices)
        for where, method, start, level in choices:
            places = [(NO_VEHICLE, "-")] if method.name in CANARIES else dice.sample(where, len(where))
            if repeat > 0:
                places = [place for place in places if not _once(settings, method, place[1])]
            keys = tuple(Key(v, d, method.name, start=start, level=level, repeat=repeat) for v, d in places)
            if keys:
                planned.append(Group(method=method.name, start=start, level=level, repeat=repeat, keys=keys))
    return planned


def _once(settings: RunSettings, method: Method, demands: str) -> bool:
    names = (method.name, method.family, demands)
    return any(fnmatchcase(name, pattern) for pattern in settings.once for name in names)


def matching_choices(contender: Contender, settings: RunSettings) -> list[tuple[str, str]]:
    """The starts and levels of a contender to measure.

    Where the settings name none, one start is measured: ``reused`` where it is offered, since a vehicle
    would run the method so. A solver that answers an optimum is measured at every level, which shows the
    price of accuracy; any other method at its most accurate one.
    """
    method, starts, levels = contender.method, contender.starts, contender.levels
    some_starts = settings.starts or (("reused",) if "reused" in starts else starts[:1])
    every_level = find_formulation(method.formulation).optimal
    some_levels = settings.levels or (levels if every_level else levels[-1:])
    if len(levels) == 1:  # an exact solver, or the one-shot route, has no other level to choose
        some_levels = levels
    return [
        (start, level)
        for start in starts
        for level in levels
        if start in (*some_starts, "-") and level in some_levels
    ]


def check_offers(contender: Contender, settings: RunSettings) -> None:
    """Raise SettingsError where a contender has none of the starts, or of the levels, that were named."""
    if matching_choices(contender, settings):
        return
    for option, named, offered in (
        ("--start", settings.starts, contender.starts),
        ("--level", settings.levels, contender.levels),
    ):
        if named and not {*named, "-"}.intersection(offered):
            name, has = contender.method.name, ", ".join(offered)
            raise SettingsError(f"{option} {' '.join(named)}: {name} has {has}; name one of these")


def other_starts(contender: Contender, settings: RunSettings) -> list[tuple[str, str]]:
    """A solver's other starts, at its most accurate level; none where starts are named."""
    if settings.starts or not contender.method.solver:
        return []
    usual = {start for start, _ in matching_choices(contender, settings)}
    level = (settings.levels or contender.levels)[-1]
    return [(start, level) for start in contender.starts if start not in usual and level in contender.levels]


def check(settings: RunSettings) -> None:
    """Raise SettingsError where the timed calls of a cell alone would outlast its time limit."""
    least_s = (settings.budget_ms or 0.0) / 1e3
    if least_s >= settings.time_limit_s:
        raise SettingsError(
            f"--budget-ms {settings.budget_ms:g}: no cell can be timed for so long within --time-limit"
            f" {settings.time_limit_s:g}; raise the limit"
        )


def budget_ns(settings: RunSettings, left_s: float, cells: int, overhead_s: float) -> int:
    """Time for the timed calls of each next cell [ns], roughly; see ``RunSettings.budget_ms``.

    Parameters
    ----------
    settings : of the run
    left_s : time left for all cells that are not measured yet [s]
    cells : how many these are
    overhead_s : time that each of them takes besides its timed calls [s]
    """
    if settings.budget_ms is not None:
        return round(settings.budget_ms * 1e6)
    each_ms = 1e3 * (left_s / max(cells, 1) - overhead_s)
    return round(1e6 * min(max(each_ms, LEAST_MS), MOST_MS))


DEFAULT_DEMANDS = ("inactive", "active", "infeasible")

ONCE = ("uniform", Family.SOFT, Family.ONE_SHOT)
"""Measured in the first repeat only, which leaves time for the fast methods: the demand set that
shares are counted on, and slow methods, whose times differ by far more than the 0.5-1 % between processes."""

GROWTH_METHODS = (
    "pinv",
    "pinv@native",
    "svd",
    "clip",
    "redistribute",
    "nullspace",
    "nullspace@native",
    "qp/clarabel",
    "qp/daqp",
    "qp/osqp",
    "qp/piqp",
    "qp/proxqp",
    "qp/quadprog",
)
"""The usual methods of each kind: a study of all forty would take hours."""


def default() -> RunSettings:
    """Every vehicle and method, with ``matching_choices`` of each: under 3 minutes on 2 cores."""
    return RunSettings(vehicles=list_vehicles(), demands=(*DEFAULT_DEMANDS, "uniform"), once=ONCE)


def quick() -> RunSettings:
    """Two vehicles in one repeat, without slow solvers, the one-shot route and soft QPs: under 25 s."""
    return RunSettings(
        vehicles=("ukwial", "bluerov2-heavy"),
        demands=DEFAULT_DEMANDS,
        without=(Family.SOFT, Family.ONE_SHOT, *slow()),
        levels=("tight",),
        repeats=1,
        n_demands=50,
        target_s=15.0,
    )


def full() -> RunSettings:
    """Every vehicle, fault, demand set, start and level: about an hour."""
    from bench.demands import list_demands

    return RunSettings(
        vehicles=list_vehicles(),
        demands=list_demands(),
        faults=(None, EACH),
        starts=("cold", "reused", "warm"),
        levels=("default", "tight"),
        repeats=1,
        target_s=3300.0,
    )


def growth() -> RunSettings:
    """The growth study: generated vehicles of 4 to 64 thrusters, active demands, one repeat."""
    return RunSettings(
        study="growth",
        demands=("active",),
        methods=GROWTH_METHODS,
        levels=("tight",),  # at its defaults Clarabel misses its promise 2.5 times at 64
        repeats=1,
        n_demands=50,
    )
