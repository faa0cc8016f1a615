"""The one-shot route to any solver: qpsolvers sets the whole problem up at each call."""

import warnings
from typing import Any

import numpy as np

from alloc.allocation import FloatArray, Status
from alloc.errors import NotInstalled, SolverError
from alloc.qp import QP
from alloc.solvers import Answer, Solve, highs

CAPS: dict[str, dict[str, Any]] = {"proxqp": {"max_iter": 200}}
"""By solver, the cap that its defaults lack: ProxQP's 10,000 iterations take 20 s for infeasible demands."""


def one_shot(qp: QP, solver: str) -> Solve:
    """Prepare (b, lb, ub) -> Answer by a call of qpsolvers with the solver's defaults.

    qpsolvers does not say why there is no solution, so the status is then NOT_CONVERGED, even where the
    solver itself knows the demand to be infeasible. qpsolvers has no iteration count and no clock that all
    solvers share. Raises NotInstalled for a solver that qpsolvers can't load; the function returned raises
    SolverError where qpsolvers calls the solver in a way that the solver does not know.
    """
    if solver == "highs":
        highs.silent_binding()
    from qpsolvers import Problem, available_solvers, dense_solvers, solve_problem
    from scipy.sparse import csc_matrix

    if solver not in available_solvers:  # a binding is installed that this qpsolvers can't import
        raise NotInstalled(
            f"qpsolvers/{solver}: qpsolvers finds no {solver}; pip install -U qpsolvers[{solver}]"
        )

    # Sparse-only solvers would convert dense matrices, and warn, at each call.
    H, A = (qp.H, qp.A) if solver in dense_solvers else (csc_matrix(qp.H), csc_matrix(qp.A))

    bounded = qp.bounded
    low, high = qp.lb.copy(), qp.ub.copy()

    def solve(b: FloatArray, lb: FloatArray, ub: FloatArray) -> Answer:
        low[bounded], high[bounded] = lb, ub
        with warnings.catch_warnings():
            # Some adapters warn of an infeasible demand, which the status already says.
            warnings.simplefilter("ignore")
            try:
                problem = Problem(H, qp.g, None, None, A, b, low, high)
                solution = solve_problem(problem, solver, **CAPS.get(solver, {}))
            except (AttributeError, ImportError, TypeError) as error:  # never a demand's fault
                raise SolverError(
                    f"qpsolvers/{solver}: {type(error).__name__}: {error}; qpsolvers does not fit "
                    f"the {solver} that is installed: update both"
                ) from error
            except Exception:  # each solver refuses a demand far too large in its own way
                return Answer(qp.g, Status.NOT_CONVERGED)
        if not solution.found or solution.x is None:
            return Answer(qp.g, Status.NOT_CONVERGED)
        return Answer(solution.x, Status.SOLVED)

    # Where qpsolvers does not fit the solver, that shows here, and not in a control loop.
    solve(np.zeros(len(qp.A)), low[bounded], high[bounded])
    return solve
