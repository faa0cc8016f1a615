"""DAQP on the problem without its equations: as many variables as the null space has dimensions."""

import numpy as np

from alloc.program import Scalar
from alloc.qp import QP
from alloc.rivals import Files, daqp_core
from alloc.rivals.c import array, indices
from alloc.rivals.download import source
from alloc.solvers import Level

ALGORITHM = "dual active set, equations eliminated beforehand"
LICENCE = "MIT"
CAP = daqp_core.CAP
TOLERANCE = daqp_core.TOLERANCE

STILL = 1e-9
"""A row of N shorter than this is rounding: no z moves that thrust."""


def missing() -> str:
    """Command that fetches the source package, whose C the installed one does not have."""
    return source("daqp").missing()


def generate(qp: QP, scalar: Scalar, level: Level) -> Files:
    """x = G b + N z with N'HN = I: least |z|^2 with lb - G b <= N z <= ub - G b, DAQP's own form.

    G = H^-1 A'(A H^-1 A')^-1; what a library that eliminates equations would find at each call. Whether a
    thrust that no z moves keeps its bounds is seen beforehand.
    """
    p, m = qp.A.shape
    weighted = np.linalg.solve(qp.H, qp.A.T)
    G = weighted @ np.linalg.inv(qp.A @ weighted)
    basis = np.linalg.svd(qp.A)[2][p:].T
    N = basis @ np.linalg.inv(np.linalg.cholesky(basis.T @ qp.H @ basis)).T
    lengths = np.linalg.norm(N, axis=1)
    moving = np.flatnonzero(lengths > STILL * lengths.max(initial=0.0)) if p < m else np.arange(0)
    still = np.setdiff1d(np.arange(m), moving)
    tables = [array("G", G, scalar), array("A", qp.A, scalar)]
    tables += [indices("still", still)] if len(still) else []
    if len(moving):
        rows, sizes = N[moving] / lengths[moving, None], lengths[moving]
        tables += [array("rows", rows, scalar), array("lengths", sizes, scalar)]
        tables += [array("scaling", 1.0 / sizes, scalar), indices("moving", moving)]
    sizes_of = {"d": max(m - p, 1), "rows": len(moving), "still": len(still), "m": m, "p": p}
    text = (_HEAD + (_TEXT if len(moving) else _SOLVED)) % {**sizes_of, "tables": "\n".join(tables)}
    return daqp_core.files("rival_daqp_reduced", text, scalar, level)


_HEAD = """\
#include "daqp.h"
#include "rival.h"
#include "settings.h"

enum { VARIABLES = %(m)d, EQUATIONS = %(p)d, FREE = %(d)d, ROWS = %(rows)d, STILL = %(still)d };
enum { MOST = FREE + 1 };
%(tables)s

/* x = G b; 2 where a thrust that no z moves breaks a bound, which y, its row in multipliers, then proves. */
static int closed_form(const real *b, const real *lb, const real *ub, real *x, real *y)
{
    for (int i = 0; i < VARIABLES; i++) {
        x[i] = 0;
        for (int j = 0; j < EQUATIONS; j++)
            x[i] += G[i * EQUATIONS + j] * b[j];
    }
#if %(still)d
    for (int r = 0; r < STILL; r++) {
        const int i = still[r];
        if (x[i] > ub[i] + settings.primal_tol || x[i] < lb[i] - settings.primal_tol) {
            for (int j = 0; j < EQUATIONS; j++)
                y[j] = A[j * VARIABLES + i];
            return 2;
        }
    }
#endif
    return 0;
}
"""
_SOLVED = """
int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y)
{
    return closed_form(b, lb, ub, x, y);
}
"""
"""C of a vehicle whose equations leave nothing to choose."""
_TEXT = """
static real u[FREE], low[ROWS], high[ROWS], lam[MOST], lam_star[MOST];
static real L[MOST * (MOST + 1) / 2], D[MOST], xldl[MOST], zldl[MOST];
static int sense[ROWS], active[MOST];
static DAQPWorkspace work = {
    .n = FREE, .m = ROWS, .M = (real *)rows, .dupper = high, .dlower = low, .sense = sense,
    .scaling = (real *)scaling, .x = u, .u = u, .lam = lam, .lam_star = lam_star, .L = L, .D = D,
    .xldl = xldl, .zldl = zldl, .WS = active, .settings = &settings, .sing_ind = DAQP_EMPTY_IND,
};

int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y)
{
    if (closed_form(b, lb, ub, x, y) != 0)
        return 2;
    for (int r = 0; r < ROWS; r++) {
        sense[r] = 0;
        low[r] = (lb[moving[r]] - x[moving[r]]) * scaling[r];
        high[r] = (ub[moving[r]] - x[moving[r]]) * scaling[r];
    }
    reset_daqp_workspace(&work);
    const int flag = daqp_ldp(&work);
    if (flag <= 0) { /* multipliers that N turns to zero are A'y, and A A' = I */
        for (int j = 0; j < EQUATIONS; j++) {
            y[j] = 0;
            for (int i = 0; i < work.n_active; i++)
                y[j] += A[j * VARIABLES + moving[active[i]]] * work.lam_star[i] * scaling[active[i]];
        }
    }
    for (int r = 0; r < ROWS; r++) {
        real along = 0;
        for (int j = 0; j < FREE; j++)
            along += rows[r * FREE + j] * u[j];
        x[moving[r]] += along * lengths[r];
    }
    return flag > 0 ? 0 : flag == DAQP_EXIT_INFEASIBLE ? 2 : 3;
}
"""
