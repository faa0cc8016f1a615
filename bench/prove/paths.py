"""The ways through a compiled kernel, the longest first: each with arguments that take it, or shown infeasible.

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

from bench.prove.cases import Integer
from bench.prove.feasible import Solver
from bench.prove.lifted import LEAVE, Lifted
from bench.prove.machine import Machine, State
from bench.prove.numbers import Array, Numbers

FORKS = 2000
"""How many forks of one kernel are looked at."""
QUESTIONS = 300
"""And how many questions are asked of the solver."""
NEAR = 30
"""Arguments that are tried beside those that the solver proposes."""


class Way(NamedTuple):
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


class Ways(NamedTuple):
    """What was found.

    Attributes
    ----------
    found : ways
    at_most : no call takes more instructions
    complete : whether ``found`` holds all there are
    """

    found: list[Way]
    at_most: int
    complete: bool


class _Open(NamedTuple):
    """Where a way goes on; sorted by what it could take at most, the largest first."""

    rank: tuple[int, int]
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
) -> Ways:
    """The ways of each fault in ``calls``, which has its inputs (size, N) by name.

    ``arguments`` names what the function takes, in order, ``fault`` among them; ``remaining`` is that of
    ``binary``. Raises NotFollowed.
    """
    search = _Search(code, entry, remaining, calls, scalar, arguments)
    found = list(search.run())
    taken = max((way.instructions for way in found if way.call.size), default=0)
    unknown = [way.instructions for way in found if not way.call.size and not way.infeasible]
    rest = [-each.rank[0] for each in search.open]
    at_most = min(remaining[entry], max([taken, *unknown, *rest]))
    return Ways(found, at_most, not rest)


class _Search:
    def __init__(
        self,
        code: Lifted,
        entry: int,
        remaining: Mapping[int, int],
        calls: Mapping[int, dict[str, Array]],
        scalar: Any,
        arguments: list[str],
    ) -> None:
        self._remaining = remaining
        self._numbers = {fault: Numbers(scalar, given) for fault, given in calls.items()}
        self._machines = {fault: Machine(code, numbers) for fault, numbers in self._numbers.items()}
        self._solvers: dict[int, Solver] = {}
        self._questions = self._serial = 0
        self.open: list[_Open] = []
        for fault, given in calls.items():
            state = _called(self._machines[fault], self._numbers[fault], entry, arguments, fault, given)
            self._push(fault, state, np.arange(self._numbers[fault].size), ())

    def run(self) -> Iterator[Way]:
        """Follow ways until none is open, or enough were looked at."""
        forks = 0
        while self.open and forks < FORKS and self._questions < QUESTIONS:
            here = heapq.heappop(self.open)
            state = here.state
            while state.at != LEAVE:
                found = self._machines[here.fault].step(state)
                if len(found) > 1:
                    break
                state = found[0].state
            if state.at == LEAVE:
                yield self._way(here, state.executed, infeasible=False)
                continue
            forks += 1
            for fork in found:
                yield from self._followed(here, fork)

    def _followed(self, here: _Open, fork: Any) -> Iterator[Way]:
        numbers = self._numbers[here.fault]
        held = (*here.held, (fork.condition, fork.holds))
        taken = here.taken[(numbers.integer(fork.condition)[here.taken] != 0) == fork.holds]
        if not len(taken):
            self._questions += 1
            solver = self._solvers.setdefault(here.fault, Solver(numbers))
            proposed = solver.possible(held)
            if proposed is False:
                most = fork.state.executed + self._rest(fork.state)
                yield self._way(here, most, infeasible=True)
                return
            if isinstance(proposed, np.ndarray):
                taken = self._tried(numbers, proposed, held)
        self._push(here.fault, fork.state, taken, held)

    def _tried(
        self, numbers: Numbers, proposed: NDArray[Any], held: tuple[tuple[Integer, bool], ...]
    ) -> NDArray[np.intp]:
        """Add a proposal and what lies near it to the calls; those that take the way."""
        rng = np.random.default_rng(numbers.size)
        scale = np.append(0.0, 2.0 ** rng.uniform(-60, -3, NEAR))
        near = proposed[:, None] * (1.0 + scale * rng.uniform(-1, 1, (len(proposed), NEAR + 1)))
        begin, rows, calls = numbers.size, 0, {}
        for name, given in numbers.calls.items():
            calls[name] = np.hstack([given, near[rows : rows + len(given)]])
            rows += len(given)
        with np.errstate(over="ignore"):
            numbers.ask(calls)
        fits = np.arange(begin, numbers.size)
        for condition, holds in held:
            fits = fits[(numbers.integer(condition)[fits] != 0) == holds]
        return fits

    def _way(self, here: _Open, instructions: int, infeasible: bool) -> Way:
        calls = self._numbers[here.fault].calls.values()
        taken = [] if infeasible else here.taken[:1].tolist()
        call = np.concatenate([given[:, taken[0]] for given in calls]) if taken else np.zeros(0)
        return Way(here.fault, instructions, call, infeasible)

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
        heapq.heappush(self.open, _Open((-most, self._serial), fault, state, taken, held))


PLACES = 0x1000_0000
"""How far the arrays of a call lie from each other."""


def _called(
    machine: Machine,
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
