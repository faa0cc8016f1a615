"""Build a program: arguments and limits as values, exits, and the order of calculation."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import reduce

import numpy as np

from alloc.allocation import FloatArray
from alloc.program.graph import Expression, Graph, Number, least, lifted, most, select
from alloc.program.nodes import Branch, DataLoop, Exit, Fence, Node, Program, Scalar, Step, Where, Write
from alloc.program.order import placed
from alloc.vehicle import Vehicle

States = dict[int, Vehicle]
"""A vehicle, under -1, and with each of some thrusters off, under its index."""


def states(vehicle: Vehicle) -> States:
    """The vehicle, and with each one thruster off."""
    off = vehicle.working.tolist() if len(vehicle.working) > 1 else []
    return {-1: vehicle} | {i: vehicle.with_fault(i) for i in off}


class Limits:
    """The limits of one kernel; a thruster that is off has none, whatever the arguments hold for it.

    Attributes
    ----------
    at_call : whether they are arguments
    by_fault : (faults, n) twice, f_min and f_max for each fault [N]; None where there is one of each
    """

    def __init__(
        self,
        vehicle: Vehicle,
        where: Where,
        graph: Graph,
        anew: bool = False,
        faults: States | None = None,
        ends: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        """Limits of the working thrusters; ``anew`` where the arguments were read before.

        ``ends`` are those of other rows [N], in place of thrusters, that no call changes.
        """
        self._vehicle, self._graph, self._anew, self._faults = vehicle, graph, anew, faults
        self.at_call = where == "call"
        low, high = ends or (vehicle.f_min, vehicle.f_max)
        self._f_min, self._f_max = low.tolist(), high.tolist()
        self.by_fault: tuple[FloatArray, FloatArray] | None = None
        if faults and not self.at_call:
            each = faults.values()
            self.by_fault = np.array([one.f_min for one in each]), np.array([one.f_max for one in each])

    def again(self) -> "Limits":
        """The same limits, read again, so that they hold no register until then."""
        where: Where = "call" if self.at_call else "fixed"
        return Limits(self._vehicle, where, self._graph, anew=True, faults=self._faults)

    def of_no_fault(self) -> "Limits":
        """Those of the vehicle, or of the call, whatever is off."""
        return Limits(self._vehicle, "call" if self.at_call else "fixed", self._graph, anew=self._anew)

    def _argument(self, array: str, i: int) -> Expression:
        begins = "l" if array == "f_min" else "h"
        found = self._graph.value("input", array, i).named(f"{begins}{i}")
        return self._graph.value("again", found.node).named(f"{begins}e{i}") if self._anew else found

    def ends(self, i: int, scale: float = 1.0, wider: float = 0.0) -> tuple[Number, Number]:
        """Limits of ``scale`` (above zero) times thrust i, moved apart by ``wider`` on either side."""
        if self.by_fault:
            lows, highs = (scale * side[:, i] for side in self.by_fault)
            return self._graph.of_each(lows - wider), self._graph.of_each(highs + wider)
        if not self.at_call:
            return scale * self._f_min[i] - wider, scale * self._f_max[i] + wider
        low, high = scale * self._argument("f_min", i), scale * self._argument("f_max", i)
        return (low - wider, high + wider) if wider else (low, high)

    def far(self, i: int, at_least: Number) -> tuple[Number, Number]:
        """Limits of thrust i, moved away from zero until they are that far from it [N]."""
        low, high = self.ends(i)
        return self._graph.plain(least(low, -at_least)), self._graph.plain(most(high, at_least))

    def crossing(self, i: int) -> Expression:
        """f_min - f_max of thrust i, above zero only where the limits of the call cross."""
        return (self._argument("f_min", i) - self._argument("f_max", i)).named(f"o{i}")

    def finite(self) -> list[Expression]:
        """The conditions that the arguments which belong to working thrusters are finite."""
        stretches: list[list[int]] = []
        for i in self._vehicle.working.tolist() if self.at_call else []:
            if stretches and i == sum(stretches[-1]):
                stretches[-1][1] += 1
            else:
                stretches.append([i, 1])
        return [
            self._graph.value("finite", array, first, count)
            for array in ("f_min", "f_max")
            for first, count in stretches
        ]


class Builder:
    """Program under construction, as a method writes it.

    Attributes
    ----------
    vehicle : whose kernel it is, with its faults
    scalar : the type of all numbers
    tau : (k,) the demand's entries
    limits : those of thrusts
    graph : the nodes so far
    faults : the vehicle with each fault that the program is for; empty where it is for this vehicle alone
    """

    def __init__(
        self,
        vehicle: Vehicle,
        limits: Where = "fixed",
        scalar: Scalar = "double",
        faults: States | None = None,
    ) -> None:
        """Without a step."""
        self.vehicle, self.scalar, self.faults = vehicle, scalar, faults or {}
        self.graph = Graph(scalar)
        self.tau = [self.graph.value("input", "tau", j).named(f"t{j}") for j in range(vehicle.k)]
        self.limits = Limits(vehicle, limits, self.graph, faults=faults)
        self._open: list[list[Step]] = [[]]
        self._under: list[Expression] = []
        self._exits: list[tuple[Node, int]] = []
        self._written: dict[tuple[str, int], Node] = {}
        self._loops: dict[str, DataLoop] = {}

    def compute(self, *values: Number) -> None:
        """These are calculated next, one after the other, with what they need."""
        self._open[-1] += [each.node for each in values if isinstance(each, Expression)]

    def fence(self) -> None:
        """Scheduling barrier: the steps that follow are not begun earlier."""
        self._open[-1].append(Fence())

    def refuse(
        self, where: Expression, status: int, *cases: tuple[Expression, int], unlikely: bool = True
    ) -> None:
        """Return where a condition holds: the status of the first case that holds, else ``status``."""
        step = Exit(where.node, tuple((case.node, returned) for case, returned in cases), status, unlikely)
        self._open[-1].append(step)
        held = reduce(lambda outer, inner: outer & inner, [*self._under, where])
        self._exits += [((held & case).node, returned) for case, returned in cases]
        self._exits.append((held.node, status))

    @contextmanager
    def where(
        self, condition: Expression, unlikely: bool = False
    ) -> Iterator[Callable[[Number, Number], Expression]]:
        """Steps that are taken where a condition holds only.

        Gives a function of what a number is then and what it is else; it returns what it is behind the steps.
        """
        merged: list[Node] = []

        def merge(then: Number, other: Number) -> Expression:
            value = select(condition, then, other)
            merged.append(value.node)
            return value

        self._under.append(condition)
        self._open.append([])
        yield merge
        self._under.pop()
        steps = self._open.pop()
        self._open[-1].append(Branch(condition.node, tuple(steps), tuple(dict.fromkeys(merged)), unlikely))

    def write(self, values: dict[int, Expression], array: str = "f") -> None:
        """These outputs are written next, and hold no register from then on; nothing is refused behind it."""
        for i, value in values.items():
            self._open[-1].append(Write(array, i))
            self._written[array, i] = value.node

    def loop(self, loop: DataLoop, *arrays: Sequence[Number]) -> list[Expression]:
        """Result of a loop over data, in the last of these arrays."""
        self._loops[loop.name] = loop
        given = tuple(lifted(each, self.graph).node for array in arrays for each in array)
        return [self.graph.value("loop", loop.name, i, given) for i in range(loop.arrays[-1][1])]

    def program(
        self,
        f: Sequence[Number],
        status: Expression | int,
        share: Sequence[Number] = (),
        beside: Mapping[tuple[str, int], Number] | None = None,
    ) -> Program:
        """The program that writes these and returns ``status``, unless it refused.

        ``beside`` are values of other outputs, by an array's name and the index.
        """
        written = {("f", i): each for i, each in enumerate(f)}
        written |= beside or {}
        written |= {("share", level): each for level, each in enumerate(share)}
        return placed(
            Program(
                outputs={place: lifted(each, self.graph).node for place, each in written.items()},
                status=lifted(status, self.graph).node,
                nodes=tuple(self.graph.nodes),
                exits=tuple(self._exits),
                scalar=self.scalar,
                names=self.graph.names,
                steps=(*self._open[0], *(Write(*place) for place in written if place not in self._written)),
                loops=self._loops,
                faults=tuple(self.faults),
            )
        )
