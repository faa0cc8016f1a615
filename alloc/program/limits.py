"""The limits of a kernel as numbers of its program: constants of the vehicle, or arguments of the call."""

import numpy as np

from alloc.allocation import FloatArray
from alloc.program.graph import Expression, Graph, Number, least, most
from alloc.program.nodes import Where
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
    ) -> None:
        """Limits of the working thrusters; ``anew`` where the arguments were read before."""
        self._vehicle, self._graph, self._anew, self._faults = vehicle, graph, anew, faults
        self.at_call = where == "call"
        self._f_min, self._f_max = vehicle.f_min.tolist(), vehicle.f_max.tolist()
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
