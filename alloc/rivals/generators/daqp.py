"""DAQP: dual active set; its own C, with the problem and the workspace laid out beforehand."""

import numpy as np

from alloc.program import Scalar
from alloc.qp import QP
from alloc.rivals import Files, daqp_core
from alloc.rivals.c import array
from alloc.rivals.download import source
from alloc.solvers import Level

ALGORITHM = "dual active set"
LICENCE = "MIT"
CAP = daqp_core.CAP
TOLERANCE = daqp_core.TOLERANCE


def missing() -> str:
    """Command that fetches the source package, whose C the installed one does not have."""
    return source("daqp").missing()


def generate(qp: QP, scalar: Scalar, level: Level) -> Files:
    """DAQP's problem is min |u|^2, d_low <= [R^-1; M] u <= d_high, with H = R'R, x = R^-1 u and M = A R^-1.

    All but d is worked out here, as DAQP does when it sets a problem up. Each call begins with the equations
    as active set; their factors are kept from call to call.
    """
    p, m = qp.A.shape
    R_inv = np.linalg.inv(np.linalg.cholesky(qp.H).T)
    diagonal = np.diag(R_inv)
    even = np.count_nonzero(R_inv - np.diag(diagonal)) == 0
    M = qp.A @ R_inv
    lengths = np.linalg.norm(np.vstack([R_inv, M]), axis=1)
    tables = [array("M_rows", M / lengths[m:, None], scalar), array("scaling", 1.0 / lengths, scalar)]
    if not even:
        packed = (R_inv / lengths[:m, None])[np.triu_indices(m)]
        tables.append(array("R_inv", packed, scalar))
        factor = ".Rinv = (real *)R_inv, .state = DAQP_STATE_RINV_NORMALIZED"
    elif (diagonal != 1.0).any():
        tables.append(array("R_inv", diagonal, scalar))
        factor = ".RinvD = (real *)R_inv"
    else:
        factor = ".Rinv = NULL"
    text = _TEXT % {"m": m, "p": p, "tables": "\n".join(tables), "factor": factor}
    return daqp_core.files("rival_daqp", text, scalar, level)


_TEXT = """\
#include "daqp.h"
#include "rival.h"
#include "settings.h"

enum { VARIABLES = %(m)d, EQUATIONS = %(p)d, ROWS = VARIABLES + EQUATIONS, MOST = VARIABLES + 1 };
%(tables)s
static real u[VARIABLES], low[ROWS], high[ROWS], lam[MOST], lam_star[MOST];
static real L[MOST * (MOST + 1) / 2], D[MOST], xldl[MOST], zldl[MOST];
static int sense[ROWS], active[MOST];
static DAQPWorkspace work = {
    .n = VARIABLES, .m = ROWS, .ms = VARIABLES, .M = (real *)M_rows, .dupper = high, .dlower = low,
    .sense = sense, .scaling = (real *)scaling, .x = u, .u = u, .lam = lam, .lam_star = lam_star,
    .L = L, .D = D, .xldl = xldl, .zldl = zldl, .WS = active, .settings = &settings,
    .sing_ind = DAQP_EMPTY_IND, %(factor)s,
};

/* The factors of the equations are those of the last call, unless DAQP changed their order. */
static void begin(void)
{
    int kept = 1;
    for (int i = 0; i < VARIABLES; i++)
        sense[i] = 0;
    for (int i = 0; i < EQUATIONS; i++) {
        sense[VARIABLES + i] = DAQP_ACTIVE + DAQP_IMMUTABLE;
        work.lam[i] = 1;
        kept &= active[i] == VARIABLES + i;
    }
    reset_daqp_workspace(&work);
    if (kept)
        work.n_active = EQUATIONS;
    else
        daqp_activate_constraints(&work);
}

int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y)
{
    for (int i = 0; i < VARIABLES; i++) {
        low[i] = lb[i] * scaling[i];
        high[i] = ub[i] * scaling[i];
    }
    for (int i = 0; i < EQUATIONS; i++)
        low[VARIABLES + i] = high[VARIABLES + i] = b[i] * scaling[VARIABLES + i];
    begin();
    const int flag = daqp_ldp(&work);
    if (flag <= 0) { /* the direction in which the multipliers grow without end */
        for (int i = 0; i < EQUATIONS; i++)
            y[i] = 0;
        for (int i = 0; i < work.n_active; i++)
            if (active[i] >= VARIABLES)
                y[active[i] - VARIABLES] = work.lam_star[i] * scaling[active[i]];
    }
    ldp2qp_solution(&work);
    for (int i = 0; i < VARIABLES; i++)
        x[i] = u[i];
    return flag > 0 ? 0 : flag == DAQP_EXIT_INFEASIBLE ? 2 : 3;
}
"""
