"""Constrained allocation, eq. 4-5, through qpsolvers: everything built anew at each call.

Most programs do this first; beside ``qp/<solver>`` it shows what the wrapper and the set-up cost.
"""

from importlib.util import find_spec
from pathlib import Path

from alloc import solvers
from alloc.formulations import Family
from alloc.formulations.hard import FORMULATION as HARD
from alloc.live.allocator import Live
from alloc.live.one_shot import one_shot
from alloc.methods import Variant
from alloc.qp import pose_hard
from alloc.vehicle import Vehicle

FORMULATION = HARD.name
FAMILY = Family.ONE_SHOT
FOREIGN = True


def variants() -> dict[str, Variant]:
    """``qpsolvers/<solver>`` for every solver that has a file in ``alloc/solvers`` and one in qpsolvers."""
    wrapped = _wrapped()
    return {
        f"qpsolvers/{name}": Variant(
            key=name,
            summary=f"eq. 4-5, one-shot through qpsolvers, by {solver.ALGORITHM}",
            missing="not installed; pip install qpsolvers" if wrapped is None else solvers.missing(name),
            solver=name,
            starts=("cold",),
            levels=("default",),
        )
        for name, solver in solvers.all_solvers().items()
        if wrapped is None or name in wrapped
    }


def _wrapped() -> set[str] | None:
    """Names of the solvers that qpsolvers has an adapter for; None where it is not installed."""
    spec = find_spec("qpsolvers")
    if spec is None or spec.origin is None:
        return None
    return {path.stem.removesuffix("_") for path in Path(spec.origin).parent.glob("solvers/*_.py")}


def build(solver: str, vehicle: Vehicle, start: str = "cold", level: str = "default") -> Live:
    """Prepare ``qpsolvers/<solver>``: only the scaled matrices are kept from call to call."""
    posed = pose_hard(vehicle, shared=solvers.shared(solver))
    return Live(
        formulation=HARD.name,
        vehicle=vehicle,
        posed=posed,
        solve=one_shot(posed.qp, solver),
        tolerance=solvers.load(solver).TOLERANCE[HARD.name]["default"],
        solver=solver,
    )
