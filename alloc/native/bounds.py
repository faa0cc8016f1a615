"""The limits of a kernel as C expressions: constants of the vehicle, or arguments of the call."""

from typing import Literal

from alloc.native.code import Scalar, Table, Value, defined, term
from alloc.vehicle import Vehicle

Where = Literal["fixed", "call"]
"""Whether the vehicle's own limits stand in the C, or f_min and f_max are arguments of each call."""


def parameters(vehicle: Vehicle, scalar: Scalar, limits: Where, levels: int, *, fault: bool = True) -> str:
    """The parameters of the C function, or without ``fault`` of the one that answers for one fault."""
    names = [(f"const {scalar} tau", vehicle.k)]
    if limits == "call":
        names += [(f"const {scalar} f_min", vehicle.n), (f"const {scalar} f_max", vehicle.n)]
    arrays = [f"{name}[{size}]" for name, size in names]
    shares = [f"{scalar} share[{levels}]"] if levels else []
    return ", ".join([*arrays, *["int fault"] * fault, f"{scalar} f[{vehicle.n}]", *shares])


def arguments(limits: Where, levels: int, fault: str = "") -> str:
    """The arguments of a call, with ``fault`` in its place where one is given."""
    given = ["tau", "f_min", "f_max"] if limits == "call" else ["tau"]
    return ", ".join([*given, *([fault] if fault else []), "f", *["share"] * (levels > 0)])


class CLimits:
    """The limits of one kernel; a thruster that is off has none, whatever the arguments hold for it.

    Attributes
    ----------
    at_call : whether they are arguments
    """

    def __init__(self, vehicle: Vehicle, where: Where, c: Table, mark: str = "") -> None:
        """Limits of the working thrusters, with their constants in table ``c`` and a mark in their names."""
        self._mark, self._vehicle = mark, vehicle
        self.at_call = where == "call"
        self._f_min, self._f_max = vehicle.f_min.tolist(), vehicle.f_max.tolist()
        self._working = vehicle.working.tolist()
        self._c = c

    def definitions(self) -> list[str]:
        """Statements that read the arguments, and how far limits cross."""
        if not self.at_call:
            return []
        low, high = f"l{self._mark}", f"h{self._mark}"
        crossing = [defined(f"o{self._mark}{i}", f"{low}{i} - {high}{i}", self._c) for i in self._working]
        sides = ((low, "f_min"), (high, "f_max"))
        read = [defined(f"{side}{i}", f"{a}[{i}]", self._c) for i in self._working for side, a in sides]
        return [*read, *crossing]

    def again(self, mark: str) -> "CLimits":
        """The same limits, read again behind a fence, so that they hold no register until then."""
        return CLimits(self._vehicle, "call" if self.at_call else "fixed", self._c, mark)

    def runs(self) -> list[tuple[str, int, int]]:
        """(array, first index, count) of all stretches of the arguments that belong to working thrusters."""
        stretches: list[list[int]] = []
        for i in self._working if self.at_call else []:
            if stretches and i == sum(stretches[-1]):
                stretches[-1][1] += 1
            else:
                stretches.append([i, 1])
        return [(array, start, n) for array in ("f_min", "f_max") for start, n in stretches]

    def far(self, i: int, least: float) -> tuple[Value, Value]:
        """Limits of thrust i, moved away from zero until they are that far from it [N]."""
        if not self.at_call:
            return min(self._f_min[i], -least), max(self._f_max[i], least)
        low, high = self.ends(i)
        return f"least({low}, {self._c(-least)})", f"most({high}, {self._c(least)})"

    def ends(self, i: int, scale: float = 1.0, wider: float = 0.0) -> tuple[str, str]:
        """Limits of ``scale`` (above zero) times thrust i, moved apart by ``wider`` on either side."""
        if not self.at_call:
            return self._c(scale * self._f_min[i] - wider), self._c(scale * self._f_max[i] + wider)
        (_, low), (_, high) = (term(scale, f"{side}{self._mark}{i}", self._c) for side in "lh")
        return (f"({low} - {self._c(wider)})", f"({high} + {self._c(wider)})") if wider else (low, high)
