"""Our problems as a qpbenchmark test set (extra ``qpbenchmark``).

    qpbenchmark docs/studies/thrust_allocation.py run

qpbenchmark wants the class to be named after the file.
"""

from collections.abc import Iterator
from typing import NamedTuple

from qpbenchmark import Problem, TestSet

from alloc import NotApplicable, Vehicle, list_vehicles, load_vehicle
from alloc.allocation import FloatArray
from alloc.qp import pose_hard
from bench.demands import build_demands

REGIMES = ("inactive", "active")
"""Attainable demand sets only: qpbenchmark counts "infeasible" as a failure even where it is right."""
SEED = 2004


class AllocationCase(NamedTuple):
    """One problem before it is posed.

    Attributes
    ----------
    name : vehicle, demand set and number
    vehicle : the vehicle
    tau : (k,) demand [N, N m]
    """

    name: str
    vehicle: Vehicle
    tau: FloatArray


def cases(vehicles: tuple[str, ...] = (), each: int = 5) -> list[AllocationCase]:
    """``each`` demands of either regime for each of the vehicles, or of all shipped ones."""
    made = []
    for name in vehicles or list_vehicles():
        vehicle = load_vehicle(name)
        for regime in REGIMES:
            try:
                taus = build_demands(regime, vehicle, SEED, each).taus
            except NotApplicable:  # without redundancy no demand is active
                continue
            made += [AllocationCase(f"{name}-{regime}-{i}", vehicle, tau) for i, tau in enumerate(taus)]
    return made


class ThrustAllocation(TestSet):  # type: ignore[misc]
    """Eq. 4-5 of shipped vehicles, scaled as ``alloc.pose_hard`` does it for every solver here."""

    def __init__(self, vehicles: tuple[str, ...] = (), each: int = 5) -> None:
        """Choose vehicles, and the number of demands of each regime."""
        self.cases = cases(vehicles, each)
        super().__init__()

    @property
    def title(self) -> str:
        """Title of the report."""
        return "Thrust allocation test set"

    @property
    def description(self) -> str:
        """Description of the problems."""
        return "Constrained thrust allocation (eq. 4-5) of marine vehicles with 4 to 8 thrusters."

    @property
    def sparse_only(self) -> bool:
        """False: dense solvers take part too, because the largest problem has 8 unknowns."""
        return False

    def __iter__(self) -> Iterator[Problem]:
        """Problems one by one."""
        for name, vehicle, tau in self.cases:
            posed = pose_hard(vehicle)
            qp, b = posed.qp, posed.b_of_tau @ tau
            yield Problem(qp.H, qp.g, None, None, qp.A, b, qp.lb, qp.ub, name=name)
