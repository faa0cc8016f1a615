"""What a kernel must answer, tried on stated demands: that it does answer, how far, and with least effort.

A kernel that refuses everything breaks no claim on memory or limits. Here its C is compiled and called as a
vehicle would call it, and held against linear programs and a QP solver, which share nothing with it. This is
a test, not a proof: its claims say ``tested``.
"""

import ctypes
import re

import numpy as np

from alloc import AllocError, Label, Status, alpha_max, build, label
from alloc.allocation import BoolArray, FloatArray, IndexArray
from alloc.c.compiled import shared_library
from alloc.errors import NotInstalled
from alloc.formulations import find_formulation
from alloc.formulations.scaled import FORMULATION as SCALED
from alloc.program import Scalar
from alloc.reach.attainable import alpha_max_lp
from bench.proof.proof import Claim, not_shown
from bench.proof.safety.harness import Subject

MARGIN: dict[Scalar, float] = {"double": 1e-5, "float": 1e-3}
"""|1 - alpha*| from which on rounding and the tolerance of SOLVED decide nothing [-]."""
CLOSE: dict[Scalar, float] = {"double": 1e-6, "float": 1e-3}
"""Distance to a solver's answer, over the largest limit, that counts as none [-]."""
DEMANDS = 500
"""Demands that are drawn of each kind: inside what the vehicle can do, at its edge, and beyond."""
PROGRAMS = 100
"""Linear programs that shares are held against."""

ANSWERS = "Demands that it must answer are SOLVED, and demands beyond the edge are not: {}."
SHARE = "The share of a demand beyond the edge is that of a linear program."
LEAST = "What is SOLVED is of least effort, as a QP solver finds it."
STATICS = "Nothing that a call leaves behind changes the next: no static data that can be written."
_STATIC = re.compile(
    r"^\s*static\s+(?!const\b|inline\b)(?:volatile\s+)?\w+\s+\w+\s*(?:\[[^]]*\]\s*)*[=;,]", re.M
)


def claims(of: Subject) -> list[Claim]:
    """The claims on answers of a kernel within its vehicle's limits, and that it keeps nothing."""
    made = [_keeps_nothing(of)]
    if of.limits == "call":
        return made
    taus, alpha, inactive = _demands(of)
    try:
        F, status, share = called(of, taus)
    except NotInstalled as reason:
        return [*made, not_shown(ANSWERS.format(of.vehicle.name), [str(reason)])]
    made.append(_answers(of, alpha, _must(of, taus, alpha, inactive), status))
    if of.kernel == SCALED.name:
        made.append(_shares(of, taus, alpha, share))
    if find_formulation(_formulation(of)).optimal:
        made.append(_least(of, taus, F, status))
    return made


def _formulation(of: Subject) -> str:
    return build(of.kernel, of.vehicle).formulation


def _keeps_nothing(of: Subject) -> Claim:
    text = re.sub(r"/\*.*?\*/", "", of.source, flags=re.S)
    kept = [" ".join(found.split()) for found in _STATIC.findall(text)]
    if kept:
        return not_shown(STATICS, kept)
    return Claim(claim=STATICS, verdict="shown", by="the C's declarations")


def _demands(of: Subject) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Demands inside, at the edge and beyond; alpha* of each; and where the closed form keeps the limits.

    Where limits exclude zero alpha* does not tell what can be met, the label does: others have NaN.
    """
    vehicle, margin = of.vehicle, 2 * MARGIN[of.scalar]
    rng = np.random.default_rng(2004)
    inside: FloatArray = rng.uniform(vehicle.f_min, vehicle.f_max, (DEMANDS, vehicle.n)) @ vehicle.TP.T
    reach = alpha_max(vehicle, inside)
    with np.errstate(divide="ignore", invalid="ignore"):
        near = [inside * (reach / wanted)[:, None] for wanted in (1 + margin, 1 - margin, 0.7)]
    taus = np.vstack([inside, 0.2 * inside, *near])
    taus = taus[np.logical_and.reduce(np.isfinite(taus), axis=1)]
    margins = label(vehicle, taus)
    alpha, inactive = margins.alpha, margins.label == Label.INACTIVE
    if not _zero_is_allowed(of):
        attained = margins.label != Label.INFEASIBLE
        alpha = np.where((alpha > 1) == attained, alpha, np.nan)
    return taus, alpha, inactive


def _zero_is_allowed(of: Subject) -> bool:
    return bool(((of.vehicle.f_min <= 0) & (of.vehicle.f_max >= 0)).all())


def called(of: Subject, taus: FloatArray) -> tuple[FloatArray, IndexArray, FloatArray]:
    """F (N, n) [N], status (N,) and share (N, levels) of the C, compiled for this computer; whole vehicle."""
    number = np.float64 if of.scalar == "double" else np.float32
    function = ctypes.CDLL(str(shared_library(of.name, of.files)))[of.name]
    F, share = np.full((len(taus), of.vehicle.n), np.nan), np.full((len(taus), of.levels), np.nan)
    status = np.empty(len(taus), dtype=np.intp)
    for i, tau in enumerate(taus.astype(number)):
        f, parts = np.full(of.vehicle.n, np.nan, number), np.full(max(of.levels, 1), np.nan, number)
        there = [array.ctypes.data_as(ctypes.c_void_p) for array in (tau, f, parts)]
        status[i] = function(there[0], -1, *there[1 : 3 if of.levels else 2])
        F[i], share[i] = f, parts[: of.levels]
    return F, status, share


def _must(of: Subject, taus: FloatArray, alpha: FloatArray, inactive: BoolArray) -> BoolArray:
    """Which demands the method must answer with SOLVED."""
    inside: BoolArray = alpha > 1 + MARGIN[of.scalar]
    if find_formulation(_formulation(of)).optimal:
        return inside
    if of.levels > 1:  # the first may leave some of a demand that can be met: the method in Python says
        inside &= build(of.kernel, of.vehicle).many(taus)[1] == Status.SOLVED
        return inside
    return inactive  # closed forms and rules of practice promise what the closed form meets


def _answers(of: Subject, alpha: FloatArray, must: BoolArray, status: IndexArray) -> Claim:
    margin = MARGIN[of.scalar]
    must_not = (alpha < 1 - margin) & of.limited
    said = f"|1 - α*| > {margin:g}, {must.sum()} inside and {must_not.sum()} beyond of {of.vehicle.name}"
    claim = ANSWERS.format(said)
    if not must.any():
        return not_shown(claim, ["no demand was drawn that it must answer: the claim would be empty"])
    wrong = [
        f"{count} of {asked.sum()} {words}"
        for asked, bad, words in (
            (must, must & (status != Status.SOLVED), "that can be met are not SOLVED"),
            (must_not, must_not & (status == Status.SOLVED), "that can't be met are SOLVED"),
        )
        if (count := int(np.count_nonzero(bad)))
    ]
    if not (status == Status.SOLVED).any():
        wrong.append("nothing is SOLVED")
    return not_shown(claim, wrong) if wrong else Claim(claim=claim, verdict="tested", by="its C, called")


def _shares(of: Subject, taus: FloatArray, alpha: FloatArray, share: FloatArray) -> Claim:
    if not _zero_is_allowed(of):
        return Claim(claim=SHARE, verdict="does not apply", by="", words=["limits exclude zero"])
    beyond = np.flatnonzero(alpha < 1 - MARGIN[of.scalar])
    beyond = beyond[:: max(1, len(beyond) // PROGRAMS)]
    if not len(beyond):
        return not_shown(SHARE, ["no demand beyond the edge was drawn: the claim would be empty"])
    right = np.array([min(1.0, alpha_max_lp(of.vehicle, taus[i])) for i in beyond])
    off = float(np.nan_to_num(np.abs(share[beyond, 0] - right), nan=1.0).max())
    words = [f"off by up to {off:.2g} in {len(beyond)} linear programs"]
    if off > CLOSE[of.scalar]:
        return not_shown(SHARE, words)
    return Claim(claim=SHARE, verdict="tested", by="HiGHS, through SciPy", words=words)


def _least(of: Subject, taus: FloatArray, F: FloatArray, status: IndexArray) -> Claim:
    solved = status == Status.SOLVED
    if not solved.any():
        return not_shown(LEAST, ["nothing is SOLVED: the claim would be empty"])
    try:
        right, known = build("qp/daqp", of.vehicle, start="cold").many(taus[solved])
    except AllocError as reason:
        return not_shown(LEAST, [str(reason)])
    compared = known == Status.SOLVED
    off = float((np.abs(F[solved] - right)[compared] / of.vehicle.f_scale).max(initial=0.0))
    words = [f"off by up to {off:.2g} of the largest limit in {compared.sum()} demands"]
    if not compared.any() or off > CLOSE[of.scalar]:
        return not_shown(LEAST, words)
    return Claim(claim=LEAST, verdict="tested", by="DAQP, cold", words=words)
