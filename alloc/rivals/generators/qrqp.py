"""CasADi's qrqp: primal-dual active set by sparse QR; what CasADi's generator writes."""

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from alloc.program import Scalar
from alloc.qp import QP
from alloc.rivals import Files
from alloc.rivals.c import array, single
from alloc.solvers import Level

ALGORITHM = "primal-dual active set, sparse QR"
LICENCE = "LGPL-3.0; what it generates is MIT-0"
CAP: dict[Level, int] = {"default": 100}
TOLERANCE: dict[Level, dict[Scalar, float]] = {"default": {"double": 1e-9, "float": 1e-5}}

SETTINGS: dict[Scalar, dict[str, Any]] = {
    "double": {"max_iter": CAP["default"]},
    "float": {"max_iter": CAP["default"], "constr_viol_tol": 1e-5, "dual_inf_tol": 1e-5},
}
"""Settings other than CasADi's defaults, 1000 iterations and 1e-8, which
single precision does not reach."""

SWITCHES: dict[str, Any] = {"with_header": True, "casadi_int": "int"}
"""Arguments of CasADi's generator; the rest are its defaults."""


def missing() -> str:
    """Command that installs CasADi."""
    return "" if find_spec("casadi") else "not installed; pip install casadi"


def generate(qp: QP, scalar: Scalar, level: Level) -> Files:
    """``conic`` with qrqp, called with b, lb and ub, from x = 0 and no multipliers."""
    import casadi

    H, A = casadi.sparsify(casadi.DM(qp.H)), casadi.sparsify(casadi.DM(qp.A))
    quiet = {"print_iter": False, "print_header": False, "print_info": False, "error_on_fail": False}
    sparsity = {"h": H.sparsity(), "a": A.sparsity()}
    with tempfile.TemporaryDirectory() as folder:
        generator = casadi.CodeGenerator("qrqp", SWITCHES)
        generator.add(casadi.conic("qrqp", "qrqp", sparsity, quiet | SETTINGS[scalar]))
        generator.generate(f"{folder}/")
        texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(Path(folder).glob("*.[ch]"))}
    tables = [array("H", H.nonzeros(), scalar), array("A", A.nonzeros(), scalar), array("g", qp.g, scalar)]
    texts["rival_qrqp.c"] = _TEXT % {"tables": "\n".join(tables)}
    if scalar == "float":
        texts = {name: single(text) for name, text in texts.items()}
    return Files(texts, {})


_TEXT = """\
#include "qrqp.h"
#include "rival.h"

%(tables)s

int rival_solve(const real *b, const real *lb, const real *ub, real *x, real *y)
{
    static int integers[qrqp_SZ_IW];
    static real numbers[qrqp_SZ_W];
    const real *given[qrqp_SZ_ARG] = {H, g, A, b, b, lb, ub}; /* no first guess, no parameters */
    real *found[qrqp_SZ_RES] = {x, 0, y};
    return qrqp(given, found, integers, numbers, 0) == 0 ? 0 : 3;
}
"""
