"""One gate from end to end: prepare, answers, instructions, paired time, and again where in doubt."""

import random
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from time import monotonic
from types import MappingProxyType

from bench.gate import environments, instructions, pairs, trees
from bench.gate.cells import DEFAULT_CELLS, Demands
from bench.gate.examine import examine
from bench.gate.prober import Prober
from bench.gate.record import GateCell, GateRecord, GateSettings
from bench.gate.side import Died, Refused, SourceTree
from bench.gate.trees import BASE, HEAD, BadTree, Source
from bench.gate.verdict import Outcome, has_moved, in_both, is_suspect, row, trips, verdict
from bench.harness import machine
from bench.results.text import counted

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
    plugins: tuple[Path, ...] = (),
    vehicles: Mapping[str, str] = MappingProxyType({}),
    always: bool = False,
    count: bool = True,
    tell: Tell = lambda _: None,
) -> GateRecord:
    """Compare two trees; the record holds all that ``verdict`` needs.

    ``plugins`` are users' methods, each taken as base and head have it, or as it lies where neither has it.
    Where neither side is a tree of this project, its plug-ins are measured with the installed ``alloc``.
    ``vehicles`` are files of users' vehicles, by what their cells are called.
    ``always`` measures although nothing that can matter differs; ``count`` allows instruction
    counts; ``tell`` is called with a line about each stage. Raises BadTree for a side that can't be measured.
    """
    started = monotonic()
    record = GateRecord(base=base.label, head=head.label, settings=settings, machine=machine.describe())
    with tempfile.TemporaryDirectory(prefix="thrustbench-gate-") as folder:
        base_tree, head_tree = (Path(folder) / name for name in (BASE, HEAD))
        users = bool(plugins) and trees.is_own(base) and trees.is_own(head)
        unpack = trees.own if users else trees.unpack
        unpack(base, base_tree, plugins)
        unpack(head, head_tree, plugins)
        files = trees.of_each_side(((base, base_tree), (head, head_tree)), plugins)
        both = (
            SourceTree(base_tree, plugins=files[0], vehicles=vehicles, source=base.path),
            SourceTree(head_tree, plugins=files[1], vehicles=vehicles, source=head.path),
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
        record.unchanged = "" if always or looks_out else environments.unchanged(*both)
        if not record.unchanged:
            if not users and environments.requirements(base_tree) != environments.requirements(head_tree):
                tell("environments: the requirements differ, so each side gets its own")
                record.notes.append(
                    "the requirements differ: each side was measured in an environment of its own"
                )
            if not users:
                with _stage(record, "prepare"):
                    both = environments.prepare(*both, Path(folder) / "environments")
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
        if count:
            tell(f"instructions: {counted(len(cells), 'cell')}, both sides at once")
            with _stage(record, "instructions"):
                _instructions(record, cells, both, demands)
        tell(f"time: {record.settings.pairs} pairs of processes, {counted(len(cells), 'cell')}")
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
    if missing := instructions.missing():
        record.notes.append(missing)
        return
    try:
        instructions.count(cells, both, demands, hash_seed=0)
        suspects = [cell for cell in cells if trips(cell.instructions[0])]
        if suspects:
            instructions.count(suspects, both, demands, hash_seed=1)
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
    pairs.calibrate(cells, both[0], demands, settings)
    done = pairs.measure(cells, both, demands, settings, rng, deadline)
    for _ in range(ATTEMPTS - 1):
        if not done or not any(cell.is_control and has_moved(row(cell, settings)) for cell in cells):
            break
        tell("time from the start: the machine moved, as cells tell that no commit can change")
        for cell in cells:
            cell.pairs.clear()
        done = pairs.measure(cells, both, demands, settings, rng, deadline)
    suspects = [cell for cell in cells if cell.is_control or (done and is_suspect(cell, settings))]
    if done and any(not cell.is_control for cell in suspects):
        tell(f"time again, fresh pairs: {', '.join(c.name for c in suspects if not c.is_control)}")
        done = pairs.measure(suspects, both, demands, settings, rng, deadline)
    if not done:
        fewest = min(len(cell.pairs) for cell in cells)
        record.cut = (
            f"the budget of {settings.budget_s:g} s was spent after {fewest} pairs; "
            "give a larger --budget or fewer --cells"
        )
