"""Constrained allocation, eq. 4-5, through qpsolvers: everything built anew at each call.

What most programs do first; beside ``qp/<solver>`` it shows what the wrapper and the set-up cost.
"""

from importlib.util import find_spec
from pathlib import Path

from alloc import solvers
from alloc.live.allocator import Live
from alloc.live.one_shot import one_shot
from alloc.qp import pose_hard
from alloc.vehicle import Vehicle

FORMULATION = "hard"
STARTS = ("cold",)
LEVELS = ("default",)


def variants() -> dict[str, str]:
    """``qpsolvers/<solver>`` for every solver that has a file in ``alloc/solvers`` and one in qpsolvers."""
    spec = find_spec("qpsolvers")
    if spec is None or spec.origin is None:
        return {f"qpsolvers/{name}": "not installed; pip install qpsolvers" for name in solvers.names()}
    wrapped = {path.stem.removesuffix("_") for path in Path(spec.origin).parent.glob("solvers/*_.py")}
    return {f"qpsolvers/{name}": solvers.missing(name) for name in solvers.names() if name in wrapped}


def SUMMARY(name: str) -> str:
    """One line for the catalogue."""
    return f"eq. 4-5, one-shot through qpsolvers, by {solvers.behind(name).ALGORITHM}"


def build(name: str, vehicle: Vehicle, start: str = "cold", level: str = "default") -> Live:
    """Prepare ``qpsolvers/<solver>``: only the scaled matrices are kept from call to call."""
    posed = pose_hard(vehicle)
    solve = one_shot(posed.qp, name.partition("/")[2])
    return Live(FORMULATION, vehicle, posed, solve, solvers.behind(name).TOLERANCE[FORMULATION]["default"])
