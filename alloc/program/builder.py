"""A program while it is made: arguments as values, what is refused, and in which order it is calculated."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import reduce

from alloc.program.graph import Expression, Graph, Number, lifted, select
from alloc.program.limits import Limits, States
from alloc.program.nodes import Branch, DataLoop, Exit, Fence, Node, Program, Scalar, Step, Where, Write
from alloc.program.order import placed
from alloc.vehicle import Vehicle


class Builder:
    """What a method writes its program into.

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
        """What comes is begun only now."""
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

    def write(self, thrusts: dict[int, Expression]) -> None:
        """These thrusts are written next, and hold no register from then on; nothing is refused behind it."""
        for i, value in thrusts.items():
            self._open[-1].append(Write("f", i))
            self._written["f", i] = value.node

    def loop(self, loop: DataLoop, *arrays: Sequence[Number]) -> list[Expression]:
        """What a loop over data makes of the last of these arrays."""
        self._loops[loop.name] = loop
        given = tuple(lifted(each, self.graph).node for array in arrays for each in array)
        return [self.graph.value("loop", loop.name, i, given) for i in range(loop.arrays[-1][1])]

    def program(self, f: Sequence[Number], status: Expression | int, share: Sequence[Number] = ()) -> Program:
        """The program that writes these and returns ``status``, unless it refused."""
        written = {("f", i): each for i, each in enumerate(f)}
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
