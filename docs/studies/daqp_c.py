"""DAQP's own C with one vehicle's problem as a kernel for the C loop, without Python or a clock in it."""

from pathlib import Path

from alloc import Vehicle
from alloc.qp import pose_hard
from bench.chips.kernels import Kernel, braced

EQUALITY = 5
"""DAQP's mark for a row of A that is an equation: always active."""


def daqp_kernel(vehicle: Vehicle, csrc: Path) -> Kernel:
    """A kernel set up at its first call, as ``qp/daqp`` reused: a call sets bounds and drops the active set.

    ``csrc`` is the folder of that name in DAQP's source distribution.
    """
    posed = pose_hard(vehicle)
    p, m = posed.qp.A.shape
    function = "int daqp_allocate(const double *tau, double *f)"
    adapter = f"""\
#include "api.h"
#include "utils.h"

static double H[{m * m}] = {braced(posed.qp.H)}, g[{m}], A[{p * m}] = {braced(posed.qp.A)};
static const double b_of_tau[{p * vehicle.k}] = {braced(posed.b_of_tau)};
static double low[{m + p}] = {braced(posed.qp.lb)}, high[{m + p}] = {braced(posed.qp.ub)};
static const double unit[{m}] = {braced(posed.unit)};
static double x[{m}], lam[{m + p}];
static int sense[{m + p}];
static const int working[{m}] = {{{", ".join(str(i) for i in posed.working)}}};
static DAQPProblem qp = {{.n = {m}, .m = {m + p}, .ms = {m}, .H = H, .f = g, .A = A,
                         .bupper = high, .blower = low, .sense = sense}};
static DAQPWorkspace work;
static DAQPResult result = {{.x = x, .lam = lam}};

{function}
{{
    static int ready;
    if (!ready) {{
        for (int i = 0; i < {p}; i++)
            sense[{m} + i] = {EQUALITY};
        if (setup_daqp(&qp, &work, 0) < 0)
            return -100;
        ready = 1;
    }}
    for (int i = 0; i < {p}; i++) {{
        double b = 0;
        for (int j = 0; j < {vehicle.k}; j++)
            b += b_of_tau[i * {vehicle.k} + j] * tau[j];
        low[{m} + i] = high[{m} + i] = b;
    }}
    const int flag = daqp_update_ldp(DAQP_UPDATE_d | DAQP_UPDATE_sense, &work, &qp);
    if (flag < 0)
        return flag;
    daqp_solve(&result, &work);
    for (int i = 0; i < {m}; i++)
        f[working[i]] = unit[i] * x[i];
    return result.exitflag;
}}
"""
    files = {path.name: path.read_text(encoding="utf-8") for path in (csrc / "include").glob("*.h")}
    files |= {path.name: path.read_text(encoding="utf-8") for path in (csrc / "src").glob("*.c")}
    return Kernel(
        method="qp/daqp in C",
        twin="nullspace",
        solver="daqp",
        scalar="double",
        k=vehicle.k,
        n=vehicle.n,
        entry="daqp_allocate",
        declaration=f"{function};",
        arguments="tau, f",
        sources=files | {"daqp_allocate.c": adapter},
    )
