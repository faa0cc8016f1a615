"""The one-shot route through qpsolvers, for any solver."""

import warnings

from alloc.allocation import FloatArray, Status
from alloc.errors import NotInstalled, SolverError
from alloc.qp import QP
from alloc.solvers import Answer, Solve


def one_shot(qp: QP, solver: str) -> Solve:
    """b -> qpsolvers' answer with the solver's defaults.

    qpsolvers says whether it found a solution, not why it didn't, so without one the status is
    NOT_CONVERGED, also where the solver itself knows that there is none. It has no iteration count
    and no clock that all solvers share. Raises NotInstalled for a solver that qpsolvers can't load, and
    the answer SolverError where it calls the solver in a way that the solver does not know.
    """
    from qpsolvers import Problem, available_solvers, dense_solvers, solve_problem
    from scipy.sparse import csc_matrix

    if solver not in available_solvers:  # its binding is there, but not one that this qpsolvers can import
        raise NotInstalled(
            f"qpsolvers/{solver}: qpsolvers finds no {solver}; pip install -U qpsolvers[{solver}]"
        )

    # Sparse-only solvers would convert, and warn, at each call.
    H, A = (qp.H, qp.A) if solver in dense_solvers else (csc_matrix(qp.H), csc_matrix(qp.A))

    def solve(b: FloatArray) -> Answer:
        with warnings.catch_warnings():
            # Some solvers' routes warn on an infeasible demand: here that is a status, not news.
            warnings.simplefilter("ignore")
            try:
                solution = solve_problem(Problem(H, qp.g, None, None, A, b, qp.lb, qp.ub), solver)
            except (AttributeError, ImportError, TypeError) as error:  # no demand does that
                raise SolverError(
                    f"qpsolvers/{solver}: {type(error).__name__}: {error}; qpsolvers does not fit "
                    f"the {solver} that is installed: update both"
                ) from error
            except Exception:  # a demand so far out that the solver refuses it, each in its own way
                return Answer(qp.g, Status.NOT_CONVERGED)
        if not solution.found or solution.x is None:
            return Answer(qp.g, Status.NOT_CONVERGED)
        return Answer(solution.x, Status.SOLVED)

    return solve
