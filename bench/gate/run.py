"""Run a gate: answers, paired times on one core, instruction counts, verdict."""

import random
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import ExitStack, closing, contextmanager
from functools import cache
from pathlib import Path
from time import monotonic
from types import MappingProxyType

from bench.gate import trees
from bench.gate.examine import examine
from bench.gate.record import DEFAULT_CELLS, Demands, GateCell, GateRecord, GateSettings
from bench.gate.side import Died, Prober, Refused, Side
from bench.gate.trees import BASE, HEAD, BadTree, Source, SourceTree
from bench.gate.verdict import Outcome, in_both, is_disturbed, is_suspect, row, trips, verdict
from bench.harness import machine
from bench.harness.timing import CALLGRIND, instruction_totals
from bench.results.text import plural

PADDING = 4096
"""Most bytes of environment that are added: they move the stack through one page, as another shell would."""


def calibrate(cells: Sequence[GateCell], base: SourceTree, demands: Demands, settings: GateSettings) -> None:
    """Choose each cell's rounds so that a block takes ``settings.block_ms`` on the base."""
    with _ready(base, cells, demands, random.Random(settings.seed)) as side:
        for cell in cells:
            once = min(_block(side, cell, rounds=1) for _ in range(3))
            cell.rounds = max(1, round(settings.block_ms * 1e6 / once))
            cell.calls = cell.rounds * len(demands[cell.vehicle])


def measure(
    cells: Sequence[GateCell],
    trees: tuple[SourceTree, SourceTree],
    demands: Demands,
    settings: GateSettings,
    rng: random.Random,
    deadline: float,
) -> bool:
    """Add ``settings.pairs`` pairs to each cell; False if the deadline came first.

    A pair that runs when the deadline comes is finished, so all cells have equally many pairs.
    """
    core = machine.core()
    for pair in range(settings.pairs):
        if monotonic() > deadline:
            return False
        with ExitStack() as stack:
            base, head = (stack.enter_context(_ready(tree, cells, demands, rng, core)) for tree in trees)
            for cell in cells:
                cell.pairs.append([])
            for block in range(settings.blocks):
                for cell in rng.sample(list(cells), len(cells)):
                    # The order ABBA lets a drift over two blocks hit both sides alike. Where the number of
                    # blocks is odd, the next pair starts with the other side.
                    order = (base, head) if (pair + block) % 2 == 0 else (head, base)
                    times = {side: _block(side, cell, cell.rounds) for side in order}
                    cell.pairs[-1].append((times[base], times[head]))
    return True


def _block(side: Side, cell: GateCell, rounds: int) -> int:
    """CPU time [ns] of ``rounds`` times round the demands of a cell's vehicle."""
    return int(side.ask("block", cell=cell.name, vehicle=cell.vehicle, rounds=rounds))


def _ready(
    tree: SourceTree, cells: Sequence[GateCell], demands: Demands, rng: random.Random, core: int | None = None
) -> Side:
    side = Side(tree, hash_seed=rng.randrange(2**32), padding=rng.randrange(PADDING))
    try:
        load(side, cells, demands, core)
    except BaseException:
        side.close()
        raise
    return side


def load(side: Side, cells: Sequence[GateCell], demands: Demands, core: int | None) -> None:
    """Build the cells in a fresh process, hand over their demands, and pin the process to a core."""
    for cell in cells:
        if cell.is_control:
            side.ask("control", cell=cell.name, kind=cell.method)
        else:
            side.ask("build", cell=cell.name, **cell.names)
    for vehicle in {cell.vehicle: None for cell in cells}:
        side.ask("keep", vehicle=vehicle, taus=demands[vehicle])
    side.ask("settle", core=core)


ROUNDS = 2
"""N calls go twice round the demands: counts repeat exactly, so more rounds would only take longer."""


@cache
def missing() -> str:
    """Reason why instructions can't be counted here, with the remedy; empty where they can."""
    if not shutil.which("valgrind"):
        return "no instruction counts, the gate rests on time alone: valgrind is missing, install it"
    return ""


def count(
    cells: Sequence[GateCell], trees: tuple[SourceTree, SourceTree], demands: Demands, hash_seed: int
) -> None:
    """Append (base, head) instructions per call to each cell; both sides are counted at once.

    Raises Refused or Died as a ``Side`` does, for instance where a library uses instructions that valgrind
    does not know.
    """
    started: list[Side] = []
    with ThreadPoolExecutor(2) as pool:
        counting = [pool.submit(_count, tree, cells, demands, hash_seed, started) for tree in trees]
        try:
            for side in wait(counting, return_when=FIRST_EXCEPTION).done:
                side.result()
        except BaseException:  # a side died, or Ctrl-C: the pool would wait a minute for the other side
            for running in started:
                running.kill()
            raise
    base, head = (side.result() for side in counting)
    for cell, *pair in zip(cells, base, head, strict=True):
        cell.instructions.append((pair[0], pair[1]))


def _count(
    tree: SourceTree, cells: Sequence[GateCell], demands: Demands, hash_seed: int, started: list[Side]
) -> list[float]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "counts"
        options = (f"--callgrind-out-file={out}", "--dump-before=getppid")
        prefix = [*_fixed_addresses(), *CALLGRIND, *options]
        with Side(tree, hash_seed=hash_seed, prefix=prefix, started=started) as side:
            load(side, cells, demands, core=None)
            for cell in cells:
                side.ask("count", cell=cell.name, vehicle=cell.vehicle, rounds=ROUNDS)
        counted = instruction_totals(out)[-3 * len(cells) :]
    # Each cell has three profiles: everything before its calls, N calls, 2 N calls.
    calls = [ROUNDS * len(demands[cell.vehicle]) for cell in cells]
    return [(twice - once) / n for n, once, twice in zip(calls, counted[1::3], counted[2::3], strict=True)]


@cache
def _fixed_addresses() -> tuple[str, ...]:
    # Without address space randomisation counts repeat to the last digit; some containers forbid to
    # switch it off.
    setarch = shutil.which("setarch")
    if setarch and subprocess.run([setarch, "-R", "true"], capture_output=True).returncode == 0:
        return (setarch, "-R")
    return ()


Tell = Callable[[str], None]

ATTEMPTS = 3
"""All cells are timed at most so often, each time from the start: again where control cells show that the
machine changed. Controls alone decide it, so no cell is timed again because of its result."""


def gate(
    base: Source,
    head: Source,
    settings: GateSettings,
    *,
    patterns: Sequence[str] = DEFAULT_CELLS,
    plugins: tuple[str, ...] = (),
    vehicles: Mapping[str, str] = MappingProxyType({}),
    build: str = "",
    always: bool = False,
    count: bool = True,
    tell: Tell = lambda _: None,
) -> GateRecord:
    """Compare two trees; the record holds all that ``verdict`` needs.

    ``plugins`` are users' methods, each taken as base and head have it, or as it lies where neither has it;
    a command runs in each side's folder.
    Where neither side is a tree of this project, its plug-ins are measured with the installed ``alloc``.
    ``vehicles`` are files of users' vehicles, by what their cells are called. ``build`` is a command that
    is run in the tree of each side first. ``always`` measures although nothing that can matter differs;
    ``count`` allows instruction counts; ``tell`` is called with a line about each stage. Raises BadTree for a
    side that can't be measured.
    """
    started = monotonic()
    record = GateRecord(base=base.label, head=head.label, settings=settings, machine=machine.describe())
    with tempfile.TemporaryDirectory(prefix="thrustbench-gate-") as folder:
        base_tree, head_tree = (Path(folder) / name for name in (BASE, HEAD))
        users = bool(plugins) and trees.is_own(base) and trees.is_own(head)
        unpack = trees.own if users else trees.unpack
        unpack(base, base_tree, plugins)
        unpack(head, head_tree, plugins)
        for source, tree in ((base, base_tree), (head, head_tree)) if build else ():
            trees.build(source.label, tree / source.start, build)
        files = trees.find_plugins(((base, base_tree), (head, head_tree)), plugins)
        both = (
            SourceTree(base_tree, plugins=files[0], vehicles=vehicles, source=base.path, start=base.start),
            SourceTree(head_tree, plugins=files[1], vehicles=vehicles, source=head.path, start=head.start),
        )
        record.commits = trees.commits(base, head)
        given = set(vehicles.values())  # these are taken as they lie there
        left_out = [
            name for name in trees.uncommitted(head) if str((head.path / name).resolve()) not in given
        ]
        if left_out:
            record.notes.append(f"not committed, so not looked at: {', '.join(left_out)}")
        record.notes += [
            f"{name} differs between the two sides; both were asked with it as it lies here"
            for name, file in vehicles.items()
            if trees.differs(base, head, Path(file))
        ]
        # A plug-in in a folder may read what lies outside of it, which a commit's can't.
        looks_out = users and not (base.commit and head.commit)
        record.unchanged = "" if always or looks_out else trees.unchanged(*both)
        if not record.unchanged:
            if not users and trees.requirements(base_tree) != trees.requirements(head_tree):
                tell("environments: the requirements differ, so each side gets its own")
                record.notes.append(
                    "the requirements differ: each side was measured in an environment of its own"
                )
            if not users:
                with _stage(record, "prepare"):
                    both = trees.prepare(*both, Path(folder) / "environments")
            compare(record, both, patterns, count=count, tell=tell)
    record.seconds["all"] = monotonic() - started
    return record


def compare(
    record: GateRecord,
    both: tuple[SourceTree, SourceTree],
    patterns: Sequence[str],
    *,
    count: bool = True,
    tell: Tell = lambda _: None,
) -> None:
    """Fill the record from two trees that are ready to run, stopping where the verdict is clear."""
    deadline = monotonic() + record.settings.budget_s
    tell("answers: every cell of both sides, judged by equations")
    with _stage(record, "answers"):
        demands = _answers(record, both, patterns)
    cells = [cell for cell in record.cells if in_both(cell)]
    if verdict(record).outcome is Outcome.REGRESSION or all(cell.is_control for cell in cells):
        return  # cells are gone or wrong, or none can be compared: times can't change the verdict
    try:
        here = [cell for cell in cells if cell.method not in both[1].apart]
        if count and not all(cell.is_control for cell in here):
            tell(f"instructions: {plural(len(here), 'cell')}, both sides at once")
            with _stage(record, "instructions"):
                _instructions(record, here, both, demands)
        tell(f"time: {record.settings.pairs} pairs of processes, {plural(len(cells), 'cell')}")
        with _stage(record, "time"):
            _time(record, cells, both, demands, deadline, tell)
    except Died as reason:
        # The process had answered before. A head that dies is a regression; a base that dies says nothing
        # about the head, so the gate is only cut short.
        message = f"died while it was measured: {reason}"
        record.crashed, record.cut = (message, "") if reason.side == HEAD else ("", message)


@contextmanager
def _stage(record: GateRecord, name: str) -> Iterator[None]:
    started = monotonic()
    yield
    record.seconds[name] = monotonic() - started


def _answers(record: GateRecord, both: tuple[SourceTree, SourceTree], patterns: Sequence[str]) -> Demands:
    with ExitStack() as stack:
        try:
            base = stack.enter_context(closing(Prober(both[0])))
        except (Died, Refused) as reason:
            raise BadTree(f"{record.base}: can't be imported ({reason}); give another base") from None
        try:
            head = stack.enter_context(closing(Prober(both[1])))
        except (Died, Refused) as reason:
            record.crashed = f"can't be imported: {reason}"
            return {}
        for name in base.not_loaded.keys() & head.not_loaded.keys():
            raise BadTree(f"on both sides: {head.not_loaded[name]}")
        examined = examine(base, head, patterns)
    record.cells, record.notes = examined.cells, [*record.notes, *examined.notes]
    return examined.demands


def _instructions(
    record: GateRecord, cells: Sequence[GateCell], both: tuple[SourceTree, SourceTree], demands: Demands
) -> None:
    if lacking := missing():
        record.notes.append(lacking)
        return
    try:
        count(cells, both, demands, hash_seed=0)
        suspects = [cell for cell in cells if trips(cell.instructions[0])]
        if suspects:
            count(suspects, both, demands, hash_seed=1)
    except (Died, Refused) as reason:
        record.notes.append(f"no instruction counts, the gate rests on time alone: under valgrind, {reason}")


def _time(
    record: GateRecord,
    cells: Sequence[GateCell],
    both: tuple[SourceTree, SourceTree],
    demands: Demands,
    deadline: float,
    tell: Tell,
) -> None:
    settings = record.settings
    rng = random.Random(settings.seed)
    calibrate(cells, both[0], demands, settings)
    done = measure(cells, both, demands, settings, rng, deadline)
    for _ in range(ATTEMPTS - 1):
        if not done or not any(cell.is_control and is_disturbed(row(cell, settings)) for cell in cells):
            break
        tell("time from the start: the machine moved, as cells tell that no commit can change")
        for cell in cells:
            cell.pairs.clear()
        done = measure(cells, both, demands, settings, rng, deadline)
    suspects = [cell for cell in cells if cell.is_control or (done and is_suspect(cell, settings))]
    if done and any(not cell.is_control for cell in suspects):
        tell(f"time again, fresh pairs: {', '.join(c.name for c in suspects if not c.is_control)}")
        done = measure(suspects, both, demands, settings, rng, deadline)
    if not done:
        fewest = min(len(cell.pairs) for cell in cells)
        record.cut = (
            f"the budget of {settings.budget_s:g} s was spent after {fewest} pairs; "
            "give a larger --budget or fewer --cells"
        )
