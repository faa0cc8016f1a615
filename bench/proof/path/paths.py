"""The ways through a compiled kernel: each with arguments that take it, or shown infeasible.

Every call goes through ``machine``, so a way is a list of conditions on numbers. Many calls are answered at
once beside it: a way that one of them takes is feasible. Of the others ``feasible`` says whether any
arguments take them, and proposes some. Ways are followed in the order of the instructions that they could
take at most, so that the first complete one that a call takes is the longest.
"""

import heapq
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.proof.path.cases import Integer
from bench.proof.path.feasible import Feasibility
from bench.proof.path.lifted import LEAVE, Lifted
from bench.proof.path.machine import Follower, State
from bench.proof.path.numbers import Array, Numbers

FORKS = 2000
"""How many forks of one kernel are looked at."""
QUESTIONS = 200
"""And how many questions are asked of the solver."""
BRIEF, MODERATE, LONG = 50_000, 6_000_000, 50_000_000
"""What z3 may spend on a question: about any way; about a complete one that would be the longest, in real
numbers; and with rounding, which is asked where real numbers say that none take it."""
FAILED = 8
"""How many such ways may stay without a call before no more are looked at so long; one, if it is too hard."""
LISTED = 50
"""How many ways and questions there are at most for the sake of those that are not the longest."""
STRICT = ((True, 0.0), (False, 1e-3), (False, 0.0))
"""How solvers are asked: the first may say that no arguments take a way, all may propose some."""
NEAR = 1000
"""Arguments that are tried about those that the solver proposes, in each round."""
ROUNDS = 5
"""How often what meets most is what the next arguments lie about."""
KEPT = 30
"""Of them, those that the next round starts from: they meet most of the conditions of a way."""


class PathFound(NamedTuple):
    """A way through a kernel, or all that begin alike and no arguments take.

    Attributes
    ----------
    fault : the thruster that is off, -1 for none
    instructions : on it; of an infeasible one at most
    call : arguments that take it, one array; empty where none is known
    infeasible : whether it is shown that none do
    """

    fault: int
    instructions: int
    call: NDArray[Any]
    infeasible: bool


class PathsFound(NamedTuple):
    """What was found.

    Attributes
    ----------
    found : ways
    at_most : no call takes more instructions
    complete : whether ``found`` holds all there are
    """

    found: list[PathFound]
    at_most: int
    complete: bool


class _Open(NamedTuple):
    """Where a way goes on: first what calls take, and of that what may be longest."""

    rank: tuple[bool, int, int]
    most: int
    fault: int
    state: State
    taken: NDArray[np.intp]
    held: tuple[tuple[Integer, bool], ...]


def ways(
    code: Lifted,
    entry: int,
    remaining: Mapping[int, int],
    calls: Mapping[int, dict[str, Array]],
    scalar: Any,
    arguments: list[str],
    closely: bool,
) -> PathsFound:
    """The ways of each fault in ``calls``, which has its inputs (size, N) by name.

    ``arguments`` names what the function takes, in order, ``fault`` among them; ``remaining`` is that of
    ``binary``. ``closely`` spends LONG on what would be the longest. Raises NotFollowed.
    """
    numbers = {fault: Numbers(scalar, given) for fault, given in calls.items()}
    search = _Search(code, remaining, numbers, closely)
    for fault, given in calls.items():
        search.begin(fault, entry, arguments, given)
    found = list(search.run())
    taken = max((way.instructions for way in found if way.call.size), default=0)
    unknown = [way.instructions for way in found if not way.call.size and not way.infeasible]
    rest = [each.most for each in search.open]
    at_most = min(remaining[entry], max([taken, *unknown, *rest]))
    return PathsFound(found, at_most, not rest)


class _Search:
    def __init__(
        self, code: Lifted, remaining: Mapping[int, int], numbers: Mapping[int, Numbers], closely: bool
    ) -> None:
        self._remaining, self._numbers = remaining, numbers
        self._machines = {fault: Follower(code, each) for fault, each in numbers.items()}
        self._solvers: dict[tuple[int, int], list[Feasibility]] = {}
        self._questions = self._serial = 0
        self._failed = 0 if closely else FAILED
        self.open: list[_Open] = []

    def begin(self, fault: int, entry: int, arguments: list[str], given: Mapping[str, Array]) -> None:
        """Open the ways of this fault, whose calls are given by the names of their arguments."""
        numbers = self._numbers[fault]
        state = _called(self._machines[fault], numbers, entry, arguments, fault, given)
        self._push(fault, state, np.arange(numbers.size), ())

    def run(self) -> Iterator[PathFound]:
        """Follow ways until none is open, or enough were looked at.

        Where too many questions were asked, ways are followed still: how often loops go round is in the code.
        """
        forks = longest = unknown = listed = 0
        aside: list[_Open] = []
        while self.open and forks < FORKS:
            here = heapq.heappop(self.open)
            tired = self._questions >= QUESTIONS
            enough = listed >= LISTED or self._questions >= LISTED
            if here.most <= (max(longest, unknown) if tired else longest) and enough:
                aside.append(here)
                continue
            if not len(here.taken) and not tired:
                here, infeasible = self._asked(here, BRIEF)
                if infeasible:
                    listed += 1
                    yield PathFound(here.fault, here.most, np.zeros(0), infeasible=True)
                    continue
            state = here.state
            while state.at != LEAVE:
                found = self._machines[here.fault].step(state)
                if len(found) > 1:
                    break
                state = found[0].state
            if state.at == LEAVE:
                listed += 1
                if not len(here.taken) and state.executed > longest and self._failed < FAILED:
                    here, infeasible = self._asked(here, LONG)
                    if infeasible:
                        yield PathFound(here.fault, state.executed, np.zeros(0), infeasible=True)
                        continue
                way = self._complete(here, state)
                if way.call.size:
                    longest = max(longest, way.instructions)
                else:
                    unknown = max(unknown, way.instructions)
                yield way
                continue
            forks += 1
            for condition, holds, there in found:
                answers = self._numbers[here.fault].integer(condition)[here.taken] != 0
                held = (*here.held, (condition, holds))
                self._push(here.fault, there, here.taken[answers == holds], held)
        self.open += aside

    def _asked(self, here: _Open, effort: int) -> tuple[_Open, bool]:
        """A way that no call took yet, with calls that do where some were found; and whether none can."""
        numbers = self._numbers[here.fault]
        key = here.fault, effort
        if key not in self._solvers:
            strict = STRICT if effort == BRIEF else STRICT[1:] + STRICT[:1]
            self._solvers[key] = [Feasibility(numbers, *each, overflow=effort == LONG) for each in strict]
        for solver in self._solvers[key]:
            self._questions += 1
            proposed = solver.possible(here.held, effort if solver.rounds else min(effort, MODERATE))
            if proposed is False and solver.rounds:
                return here, True
            if proposed is True and effort == BRIEF:  # what is too hard for one is for the others
                self._questions += 2
                return here, False
            if isinstance(proposed, np.ndarray):
                taken = self._tried(numbers, proposed, here.held)
                if len(taken):
                    return here._replace(taken=taken), False
            if proposed is not False and effort == LONG and not solver.apart:
                self._failed += FAILED if proposed is True else 1
                return here, False
        return here, False

    def _tried(
        self, numbers: Numbers, proposed: NDArray[Any], held: tuple[tuple[Integer, bool], ...]
    ) -> NDArray[np.intp]:
        """Add a proposal and what lies near it to the calls; those that take the way."""
        rng = np.random.default_rng(numbers.size)
        best = proposed[:, None]
        for _ in range(ROUNDS):
            parents = best[:, rng.integers(0, best.shape[1], NEAR)]
            scale = 2.0 ** rng.uniform(-np.finfo(numbers.scalar).nmant - 2, 0, NEAR)
            moved = rng.uniform(-1, 1, (len(proposed), NEAR))
            moved[:, rng.random(NEAR) < 0.2] = -rng.random()
            moved[rng.random(moved.shape) < rng.choice([0.0, 0.5], NEAR)] = 0.0
            near = np.hstack([best, parents * (1.0 + scale * moved)])
            trial = numbers.trial(_by_name(numbers, near))
            met = sum(((trial.integer(condition) != 0) == holds).astype(int) for condition, holds in held)
            if (met == len(held)).any():
                begin = numbers.size
                more = _by_name(numbers, near[:, met == len(held)][:, :KEPT])
                numbers.ask({name: np.hstack([given, more[name]]) for name, given in numbers.calls.items()})
                return np.arange(begin, numbers.size)
            best = near[:, np.argsort(-met, kind="stable")[:KEPT]]
        return np.arange(0)

    def _complete(self, here: _Open, state: State) -> PathFound:
        calls = self._numbers[here.fault].calls.values()
        call = [given[:, here.taken[0]] for given in calls] if len(here.taken) else [np.zeros(0)]
        return PathFound(here.fault, state.executed, np.concatenate(call), infeasible=False)

    def _rest(self, state: State) -> int:
        if state.at == LEAVE:
            return 0
        return self._remaining[state.at] + sum(self._remaining[each] for each in state.frames)

    def _push(
        self,
        fault: int,
        state: State,
        taken: NDArray[np.intp],
        held: tuple[tuple[Integer, bool], ...],
    ) -> None:
        self._serial += 1
        most = state.executed + self._rest(state)
        rank = (not len(taken), -most, self._serial)
        heapq.heappush(self.open, _Open(rank, most, fault, state, taken, held))


def _by_name(numbers: Numbers, stacked: Array) -> dict[str, Array]:
    """Calls (all inputs, N), apart by the names of the arguments."""
    sizes = [len(given) for given in numbers.calls.values()]
    return dict(zip(numbers.calls, np.split(stacked, np.cumsum(sizes)[:-1]), strict=True))


PLACES = 0x1000_0000
"""How far the arrays of a call lie from each other."""


def _called(
    machine: Follower,
    numbers: Numbers,
    entry: int,
    arguments: list[str],
    fault: int,
    inputs: Mapping[str, Array],
) -> State:
    """The call, with inputs in memory."""
    given = [fault % 2**32 if name == "fault" else PLACES * i for i, name in enumerate(arguments, 1)]
    state = machine.start(entry, given)
    size = numbers.scalar(0).itemsize
    for name, place in zip(arguments, given, strict=True):
        for j in range(len(inputs.get(name, ()))):
            state.memory.write(place + j * size, size, numbers.number("input", name, j))
    return state
