"""First and second choice of a quick run and of one that asks ten times as many demands.

``python docs/studies/choices.py [VEHICLES [FIRST]]`` asks each method on all shipped vehicles and on numbered
generated ones from FIRST on, 200 unless told, and prints each vehicle as it ends, with choices that differ
unsaid, then a table. A vehicle takes some seconds of a core. What was found is kept by commit: the same
command goes on from there. The longer run also draws other demands evenly from what the vehicle can do: no
choice may hang on which these were.
Times are not measured: each method takes what it takes in the record of ``results``, so noise of clocks has
no part. Generated C answers as its twin in Python does, which is asked in its place.

Nearly every vehicle has one method that is better than all others, and a comparison of these choices alone
would show little. So whatever comes first in either run is left out, and the rest compared again, until none
is left: the later choices are among rules that differ by little. Each choice is also repeated REPEATS times
with times that differ by noise: where first choices differ, each repeat must say that nothing is decided.

Of all methods on 207 vehicles both choices agree on 205, and 4 are said to be open, the other 2 among them.
With the best left out, of 2,711 choices both agree in 97.0 %, 8.7 % are said to be open, and 25, or 0.9 %,
differ unsaid. Of 18 the quick run saw a demand of which a rule delivers nothing, and the longer run's others
hold none: what was seen stays true. Of 4 a QP solver failed on a demand that only the longer run asked. Of 3
a rule missed a little less than 1 % of 2,000 demands, and a little more of others. First choices of repeats
never differ unsaid.
"""

import sys
from collections import Counter
from collections.abc import Container, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import replace as replace_size
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec import json
from msgspec.structs import replace

from alloc import AllocError, NotApplicable, Vehicle, catalogue, list_vehicles, load_vehicle
from alloc.allocation import BoundedSteps
from alloc.discovery import Entry, find, prepare
from alloc.formulations import Family
from bench.demands import build_demands
from bench.demands.generated import generate_vehicle
from bench.demands.store import Case
from bench.harness import machine
from bench.harness.lines import method_line, new_header, problem
from bench.harness.plan import DEFAULT_DEMANDS, quick
from bench.judging.capability import N_DEMANDS, even_demands
from bench.judging.judge import judge
from bench.judging.question import Answers, Question, Unanswered, questions, read_promises
from bench.judging.worst import strong_error, worst_loss
from bench.record import SERVED_WITHIN, Batch, Capability, Cell, Key, Record, Served
from bench.record.measured import binned
from bench.report.verdict import USUAL, spoken_name
from bench.results.rows import Run, gather, read_run
from bench.results.size import (
    CLOSE,
    Fit,
    Size,
    best_of_each,
    possible_first,
    possible_second,
    rank_sizes,
    second_size,
)
from bench.results.sizing import sizes
from bench.results.text import table

RECORD = Path(__file__).parents[2] / "results" / "amd-epyc-2-cores"
SOLVERS = ("qp/daqp", "qp/quadprog")
"""QP solvers that stand for all: each adds as much time as all rules together."""
CALLS = 3000
"""Timed calls of each method: enough that none is open for being too few."""
N, TENFOLD = quick().n_demands, 10
REPEATS = 10
"""Repeats of a quick run, each with times of its own."""
KEPT = Path(__file__).parents[2] / "build" / "choices"
"""Folder of what was found, by commit and vehicle: a study that was ended early goes on from there."""


class Choice(NamedTuple):
    """Advice of a run on a vehicle.

    Attributes
    ----------
    first, second : methods, as a verdict names them; empty for none, where it says that none is to take
    open : whether the verdict says that so few demands decide nothing
    """

    first: str
    second: str
    open: bool


@cache
def times_us() -> dict[str, float]:
    """The largest median of each method on any vehicle in the committed record [us]."""
    found: dict[str, float] = {}
    for row in read_run(RECORD).rows:
        if not row.failed and row.call_p50_us is not None:
            found[row.method] = max(found.get(row.method, 0.0), row.call_p50_us)
    return found


@cache
def entries() -> tuple[Entry, ...]:
    """Methods of ``run --quick`` that the record has times of; of QP solvers, SOLVERS."""
    taken = (e for e in catalogue() if e.name in times_us() and not e.missing)
    return tuple(
        e for e in taken if (e.twin or not e.solver or e.name in SOLVERS) and e.family not in LEFT_OUT
    )


LEFT_OUT = (Family.SOFT, Family.ONE_SHOT, Family.GENERATED)
"""Families that a quick run leaves out, and solvers' own C, whose answers are their library's."""


def answer(method: str, case: Case) -> Answers | Unanswered:
    """Answers of a method, or the reason why it has none."""
    try:
        allocate = prepare(find(method), case.vehicle)
    except AllocError as error:
        return Unanswered("refused", str(error))
    return Answers(*allocate.many(case.taus, f_min=case.f_min, f_max=case.f_max))


def served(vehicle: Vehicle, seed: int) -> list[Capability]:
    """Number of the demands drawn evenly that each method in Python serves, as a run counts them.

    Empty where a vehicle can do one thing only, and nothing can be drawn.
    """
    try:
        taus = even_demands(vehicle, seed, N_DEMANDS)
    except NotApplicable:
        return []
    found = []
    for entry in entries():
        reply = Unanswered("", "") if entry.foreign else answer(entry.name, Case(vehicle, taus))
        if isinstance(reply, Answers):
            error = strong_error(vehicle, taus, reply.F)
            counts = [int(np.count_nonzero(error <= within)) for within in (SERVED_WITHIN, 0.05)]
            found.append(
                Served(
                    fault=None,
                    method=entry.name,
                    n_demands=len(taus),
                    within_1pct=counts[0],
                    within_5pct=counts[1],
                    sample=worst_loss(vehicle, taus, reply.F),
                    missed=np.packbits(~(error <= SERVED_WITHIN)).tobytes(),
                )
            )
    capability = Capability(
        vehicle=vehicle.name,
        dof=list(vehicle.dof),
        authority=[],
        served=found,
        curves=[],
        planes=[],
        last_metre=[],
    )
    return [capability]


def made_run(vehicle: Vehicle, capabilities: list[Capability], n: int) -> Run:
    """A run as ``run --quick`` makes it, with n demands of each set, times out of the record."""
    sets = []
    for name in DEFAULT_DEMANDS:
        with suppress(NotApplicable):
            sets.append(build_demands(name, vehicle, 0, n))
    asked = questions(sets, lambda method, cases: [answer(method, case) for case in cases])
    methods = [method_line(entry) for entry in entries()]
    record = Record(header=new_header(0, {}), methods=methods, capabilities=capabilities)
    for question in asked:
        record.problems.append(problem(question))
        judged = {entry.name: judged_cell(entry, question) for entry in entries() if not entry.twin}
        record.cells += judged.values()
        record.cells += [timed(judged[entry.twin], entry.name) for entry in entries() if entry.twin in judged]
    return Run(record, gather(record))


def judged_cell(entry: Entry, question: Question) -> Cell:
    """The cell of a method on a question, its answers judged, its time out of the record."""
    demands = question.demands
    key = Key(demands.vehicle.name, demands.name, entry.name, entry.starts[0], entry.levels[-1])
    try:
        allocate = prepare(entry, demands.vehicle, level=entry.levels[-1])
    except AllocError as error:
        return Cell(key=key, status="refused", reason=str(error))
    answers = [allocate(tau) for tau in demands.taus]
    cell = Cell(
        key=key,
        status="ok",
        n_demands=len(answers),
        judged=judge(question, answers, **read_promises(allocate)),
    )
    cell.formulation, cell.limited = allocate.formulation, allocate.limited
    cell.worst_case_steps = allocate.worst_case_steps if isinstance(allocate, BoundedSteps) else None
    return timed(cell, entry.name)


def timed(cell: Cell, method: str) -> Cell:
    """The cell of a method that answers as this one does, in the time of the record."""
    key = replace(cell.key, method=method, start="-" if "@" in method else cell.key.start)
    if cell.status != "ok":
        return replace(cell, key=key)
    ns = binned(round(1000 * times_us()[method]))
    batch = Batch(calls=CALLS, wall_ns=CALLS * ns, cpu_ns=CALLS * ns, switches=0)
    return replace(cell, key=key, batches=[batch], singles=[(ns, CALLS)])


def best_sizes(run: Run, left_out: Container[str], factors: Mapping[str, float] = {}) -> list[Size]:
    """Best size of each method but for some, by ``slowed`` times, in the loop that reports open with."""
    known = [size for size in sizes(run, USUAL) if (size.twin or size.method) not in left_out]
    return best_of_each(rank_sizes([slowed(s, factors.get(s.method, 1.0)) for s in known], USUAL.period_us))


def slowed(size: Size, factor: float) -> Size:
    """The size with medians that are longer by a factor."""
    times = {name: getattr(size, name) for name in ("p50_us", "cpu_us")}
    return replace_size(size, **{name: us and factor * us for name, us in times.items()})


def choice(own: Sequence[Size]) -> Choice:
    """Advice by the sizes of one vehicle."""
    if not takes(own):
        return Choice("", "", open=False)
    second = second_size(own)
    name = spoken_name(second) if second else ""
    return Choice(spoken_name(own[0]), name, bool(possible_first(own, USUAL) or possible_second(own, USUAL)))


def takes(own: Sequence[Size]) -> bool:
    """True if there is a method to take."""
    return bool(own) and own[0].fit <= Fit.MAY_FIT and own[0].refused < 1


def main(count: int, first: int) -> int:
    """Compare the choices, a line for each vehicle as it ends, then a table; 1 where a vehicle failed."""
    named = [*list_vehicles(), *map(str, range(first, first + count))]
    found, commit = [], machine.commit()
    with ProcessPoolExecutor() as pool:
        running = {pool.submit(kept, name, commit): name for name in named}
        for job in as_completed(running):
            if error := job.exception():
                print(f"{running[job]}: failed: {type(error).__name__}: {error}", flush=True)
                continue
            found.append(job.result())
            lines = [f"{running[job]}: {len(found[-1])} compared", *differing(found[-1])]
            print("\n- ".join(lines), flush=True)
    print_table(found)
    return int(len(found) < len(named))


def kept(name: str, commit: str) -> "list[Pair]":
    """Choices on a shipped vehicle, or a generated one by its number, as this commit once found them."""
    path = KEPT / commit / f"{name}.json"
    if path.exists() and "+" not in commit:
        return json.decode(path.read_bytes(), type=list[Pair])
    found = compared(generate_vehicle(int(name))[0] if name.isdigit() else load_vehicle(name))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".part").write_bytes(json.encode(found))
    path.with_suffix(".part").replace(path)
    return found


def print_table(found: "Sequence[Sequence[Pair]]") -> None:
    """Print how often each fact is so: of all methods, and of fewer and fewer."""
    seen: dict[str, Counter[str]] = {"of all methods": Counter(), "with the best left out": Counter()}
    for pairs in found:
        for turn, pair in enumerate(pairs):
            seen[list(seen)[min(turn, 1)]].update(verdict(pair))
    rows = [[what, *(f"{own[what]:,}" for own in seen.values())] for what in FACTS]
    print(f"\n{len(found)} vehicles\n\n{table(['', *seen], rows)}")


class Pair(NamedTuple):
    """Choices among the same methods.

    Attributes
    ----------
    short, long : of a quick run, and of one with TENFOLD its demands
    repeats : first choices of the quick run with other times, the first with its own
    unsaid : repeats that have another first choice than a repeat has, and do not say that it is open
    """

    short: Choice
    long: Choice
    repeats: int
    unsaid: int


FACTS = (
    *("choices", "first agrees", "first and second agree", "said to be open"),
    *("said to be open, and one differs", "one differs, and not said"),
    *("first of repeats differs, and all say so", "first of repeats differs, and not all say so"),
)
"""Facts that are counted."""


def verdict(pair: Pair) -> Iterator[str]:
    """Facts about a pair, each one of FACTS."""
    short, long = pair.short, pair.long
    yield "choices"
    if short.first == long.first:
        yield "first agrees"
    if short[:2] == long[:2]:
        yield "first and second agree"
    if short.open:
        yield "said to be open"
        if short[:2] != long[:2]:
            yield "said to be open, and one differs"
    if unsaid(pair):
        yield "one differs, and not said"
    if pair.repeats > 1:
        yield f"first of repeats differs, and {'not all say so' if pair.unsaid else 'all say so'}"


def differing(pairs: Sequence[Pair]) -> Iterator[str]:
    """Choices on one vehicle that differ, without being said to be open."""
    return (f"without {i}: {pair}" for i, pair in enumerate(pairs) if unsaid(pair) or pair.unsaid)


def unsaid(pair: Pair) -> bool:
    """True if a quick run's choices are others than a long one's, and it does not say so."""
    return pair.short[:2] != pair.long[:2] and not pair.short.open


def compared(vehicle: Vehicle) -> list[Pair]:
    """Choices of a quick run on a vehicle and of one with TENFOLD its demands, of fewer and fewer methods."""
    short, long = (made_run(vehicle, served(vehicle, n), n) for n in (N, TENFOLD * N))
    left_out: set[str] = set()
    pairs: list[Pair] = []
    while takes(own := best_sizes(long, left_out)) or not pairs:
        again = [choice(best_sizes(short, left_out, noise(seed))) for seed in range(REPEATS)]
        firsts = {each.first for each in again}
        unsaid = sum(not each.open for each in again) if len(firsts) > 1 else 0
        quick_own = best_sizes(short, left_out)
        pairs.append(Pair(choice(quick_own), choice(own), len(firsts), unsaid))
        left_out |= {size.twin or size.method for size in (*quick_own[:1], *own[:1])}
    return pairs


def noise(seed: int) -> dict[str, float]:
    """Factors of the methods' times in one repeat: two repeats differ by CLOSE at most."""
    rng = np.random.default_rng(seed)
    return {name: CLOSE ** rng.uniform(-0.5, 0.5) for name in times_us()}


if __name__ == "__main__":
    sys.exit(main(*(int(word) for word in [*sys.argv[1:], *("200", "0")[len(sys.argv) - 1 :]])))
