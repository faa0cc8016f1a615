"""DAQP's own C and settings, which two generators lay problems out for."""

import re

from alloc.program import Scalar
from alloc.rivals import Files
from alloc.rivals.c import single
from alloc.rivals.download import source
from alloc.solvers import Level
from alloc.solvers import daqp as binding

CAP: dict[Level, int] = {"default": 100, "tight": 100}
"""Iterations of a call at most; DAQP's own cap is 10,000."""
TOLERANCE: dict[Level, dict[Scalar, float]] = {
    "default": {"double": 1e-5, "float": 1e-5},
    "tight": {"double": 1e-9, "float": 1e-5},
}
"""A limit violated by up to 1e-6 counts as kept by default, in single precision always; else by 1e-10."""

_HEADERS = ("types.h", "constants.h", "auxiliary.h", "factorization.h", "daqp.h")
_CORE = ("daqp.c", "auxiliary.c", "factorization.c")
"""The method itself; the rest of DAQP sets problems up, on a heap, or solves others."""


_FUNCTION = re.compile(r"\b(?=(?:daqp_\w+|ldp2qp_solution|reset_daqp_workspace)\b)")


def files(name: str, text: str, scalar: Scalar, level: Level) -> Files:
    """The C around DAQP's own, in file ``<name>.c``, and what is the same for every problem.

    ``settings.h`` has DAQP's defaults, or the tolerance of its binding's tight level, and the cap. All
    functions have names of their own, so that an image may hold DAQP twice.
    """
    shared = {file: _FUNCTION.sub(f"{name}_", each) for file, each in _core(scalar, level).items()}
    return Files({f"{name}.c": _FUNCTION.sub(f"{name}_", text)}, shared)


def _core(scalar: Scalar, level: Level) -> dict[str, str]:
    daqp = source("daqp")
    texts = daqp.read("csrc/include", _HEADERS) | daqp.read("csrc/src", _CORE)
    texts["constants.h"] = f"#define DAQP_NO_SOFT_WEIGHTS\n{texts['constants.h']}"  # nothing is soft here
    tight = level == "tight" and scalar == "double"
    primal = binding.SETTINGS["tight"]["primal_tol"] if tight else "DAQP_DEFAULT_PRIM_TOL"
    texts["settings.h"] = _SETTINGS % (primal, CAP[level])
    return {name: single(text) for name, text in texts.items()} if scalar == "float" else texts


_SETTINGS = """\
static DAQPSettings settings = {
    .primal_tol = %s, .dual_tol = DAQP_DEFAULT_DUAL_TOL, .zero_tol = DAQP_DEFAULT_ZERO_TOL,
    .pivot_tol = DAQP_DEFAULT_PIVOT_TOL, .progress_tol = DAQP_DEFAULT_PROG_TOL,
    .cycle_tol = DAQP_DEFAULT_CYCLE_TOL, .iter_limit = %d, .fval_bound = DAQP_INF,
    .rho_soft = DAQP_DEFAULT_RHO_SOFT, .sing_tol = DAQP_DEFAULT_SING_TOL,
    .refactor_tol = DAQP_DEFAULT_REFACTOR_TOL,
};
"""
