"""Claims about rounding: no thrust is off by more than a bound, no verdict outside of a band.

A bound stands beside the largest error of many attainable demands, which refutes one that is too small.
"""

from collections.abc import Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np

from alloc import NotApplicable, Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.program import Evaluated, Node, Operation, Program, Scalar, alike, answered, values
from bench.chips.toolchain import ToolError
from bench.demands.corners import attainable
from bench.proof.proof import Claim, Rounding, not_shown
from bench.proof.rounding.arithmetic import WIDER
from bench.proof.rounding.errors import Errors
from bench.proof.source import ANSWERED, NotRead, Subject, subject
from bench.proof.symbolic import programs

BOUNDED = "Rounding moves no thrust of an attainable demand by more than the bound below."
REFUSES = "A demand whose α* is below 1 by more than the band is refused."
ALIKE = 2.0**-23
"""Constants this close are one number, in double and rounded to float."""
SAYS = 0.01
"""A band as wide as this leaves next to nothing that is refused."""
DEMANDS = 20_000
"""Attainable demands, a third of them on the edge, that tell how large what is compared becomes there."""
FAR = 2.0
"""So many times an attainable demand, or its opposite, changes all that depends on what thrusters can do."""
NOTHING = 100.0
"""What changes by no more than so many times its rounding does not change: constants are rounded, too."""
CHUNK = 10_000
"""Demands at a time: so many values of every operation fit a processor's cache."""
KINDS = {"double": (np.float64, np.longdouble), "float": (np.float32, np.float64)}
"""The scalar, and what the formula is calculated in beside it."""


def rounding_claim(of: Subject, demands: int, demands_fault: int) -> tuple[Claim, list[Rounding]]:
    """Claim that errors have bounds, and these beside the errors of so many demands, whole and of a fault."""
    if of.limits == "call":
        return not_shown(BOUNDED, ["limits of the call: ranges are known for the vehicle's own only"]), []
    try:
        found, exact = programs(of), exact_constants(of)
    except (NotRead, ToolError) as error:
        return not_shown(BOUNDED, [str(error)]), []
    rows: list[Rounding] = []
    words: list[str] = []
    for fault, program in found.items():
        vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
        given = program, vehicle, of.scalar, exact.get(fault)
        errors = Errors(*given)
        turned = Errors(*given, flips=True) if errors.branches else errors
        try:
            bound, flipped = errors.bound(), turned.bound()
            band = verdict_band(program, errors, vehicle, of.scalar)
            count = demands if fault < 0 else demands_fault
            observed = sample(program, vehicle, of.scalar, exact.get(fault, {}), count)
        except (NotRead, NotApplicable) as reason:
            words.append(f"fault {fault}: {reason}")
            continue
        rows.append(
            Rounding(
                fault=fault,
                bound_n=bound,
                observed_n=observed.error,
                demands=count,
                flipped_n=flipped if flipped > bound else None,
                verdict_band=band,
            )
        )
        if not (observed.error <= bound and observed.flipped <= flipped):
            worst = max(observed.error, observed.flipped)
            words.append(f"fault {fault}: an error of {worst:.3g} N was seen, above the bound")
    if words:
        return not_shown(BOUNDED, words), rows
    return Claim(claim=BOUNDED, verdict="shown", by="ranges and errors, operation by operation"), rows


def band_claim(rounding: list[Rounding], faults: set[int]) -> Claim:
    """Claim on the widest band of all that the C answers for: each of these ``faults``, -1 among them."""
    bands = {each.fault: each.verdict_band for each in rounding if each.verdict_band is not None}
    if missing := sorted(faults - {each.fault for each in rounding}):
        return not_shown(REFUSES, [f"fault {fault}: no band is known without a bound" for fault in missing])
    if not bands:
        return Claim(claim=REFUSES, verdict="does not apply", by="", words=["this method refuses none"])
    if wide := [fault for fault, band in bands.items() if not band < SAYS]:
        why = "a demand may be accepted of which next to nothing can be had, where it is as small as rounding"
        return not_shown(REFUSES, [f"fault {fault}: {why}" for fault in wide])
    words = [f"at most {max(bands.values()):.2g}"]
    return Claim(claim=REFUSES, verdict="shown", by="the program's own numbers", words=words)


def exact_constants(of: Subject) -> dict[int, dict[Node, float]]:
    """Constants of each fault by node before they were rounded to float; none in double.

    They are read out of the same kernel in double. Where float makes other sums of it, the constants count as
    they stand in the C.
    """
    if of.scalar == "double":
        return {}
    try:
        double = programs(subject(of.vehicle, of.kernel, "double", of.limits, of.faults))
    except NotApplicable:
        return {}
    exact: dict[int, dict[Node, float]] = {}
    for fault, program in programs(of).items():
        other = double[fault].nodes
        if [each[0] for each in other] != [each[0] for each in program.nodes]:
            continue
        pairs = enumerate(zip(other, program.nodes, strict=True))
        exact[fault] = {
            node: wide[1]
            for node, (wide, narrow) in pairs
            if wide[0] == "const" and abs(wide[1] - narrow[1]) <= ALIKE * abs(wide[1])
        }
    return exact


class Sample(NamedTuple):
    """Largest errors of many demands.

    Attributes
    ----------
    error : largest |f - f in real numbers| of all that were answered and took the same branches in both [N]
    flipped : largest of those that took others [N]
    answered, demands : how many of them
    """

    error: float
    flipped: float
    answered: int
    demands: int


def sample(
    program: Program,
    vehicle: Vehicle,
    scalar: Scalar,
    exact: dict[Node, float],
    demands: int,
) -> Sample:
    """Answer so many seeded attainable demands, and hold each answer against the formula's."""
    rng = np.random.default_rng(2004)
    narrow, wide = KINDS[scalar]
    error = flipped = 0.0
    written = 0
    limits = (("f_min", vehicle.f_min), ("f_max", vehicle.f_max))
    for begin in range(0, demands, CHUNK):
        count = min(CHUNK, demands - begin)
        tau = attainable(vehicle, rng, count).astype(narrow)
        ends = {side: np.repeat(each[:, None], count, axis=1) for side, each in limits}
        made = values(program, {"tau": tau, **ends}, narrow)
        got = answered(program, made, count)
        writes = np.isin(got.status, ANSWERED)
        written += int(writes.sum())
        true = values(program, {"tau": tau, **ends}, wide, exact)
        difference, same = apart(program, got, made, true)
        error = max(error, float(difference[writes & same].max(initial=0.0)))
        flipped = max(flipped, float(difference[writes & ~same].max(initial=0.0)))
    return Sample(error, flipped, written, demands)


def apart(program: Program, got: Evaluated, some: list[Any], true: list[Any]) -> tuple[FloatArray, BoolArray]:
    """(N,) how far thrusts lie from those in real numbers [N], and whether both took the same branches.

    ``some`` and ``true`` are the program's values, rounded and not; ``got`` is its answer to the first.
    """
    off: FloatArray = np.abs(got.F - answered(program, true, len(got.F)).F).max(axis=1)
    return off, alike(program, some, true)


def verdict_band(program: Program, errors: Errors, vehicle: Vehicle, scalar: Scalar) -> float | None:
    """1 - alpha* of the least attainable demand that may be SOLVED still [-]; None where none is refused.

    What is compared with a bound b is convex along the ray to a demand: r at its begin, at most m wherever
    the demand is attainable. It is answered where that is at most b + e, e the rounding error, so that
    alpha* >= 1 / (1 + (b + e - m) / (m - r)). All of these are the program's own: b and r are its numbers,
    and m is the largest of many attainable demands, which is no more than the true one and so widens the
    band. Where m is r but for rounding there is none: demands as small as the slack pass, however little of
    them can be had. What no multiple of a demand changes is no edge of the set: a thruster's own limits,
    which don't cross, or a direction that no thruster pushes. Raises NotRead where what is compared can't be
    followed.
    """
    taus, at_rest = attainable(vehicle, np.random.default_rng(2004), DEMANDS), _at_rest(program)
    largest, *far = (_largest(program, by * taus, scalar) for by in (1.0, FAR, -FAR))
    band = None
    for condition, _ in program.exits:
        for term, bound in _compared(program.nodes, condition):
            if term not in errors.values or bound not in errors.values:
                raise NotRead(errors.reasons.get(term, "no number"))
            error = errors.error(term) + WIDER["double"] * errors.values[term].size
            if all(each[term] - at_rest[term] <= NOTHING * error for each in far):
                continue
            width = largest[term] - at_rest[term]
            beyond = errors.values[bound].high - largest[term] + error
            band = max(band or 0.0, 1.0 - 1.0 / (1.0 + beyond / width) if width > NOTHING * error else inf)
    return band


def _largest(program: Program, taus: FloatArray, scalar: Scalar) -> list[Any]:
    """The largest that every node is of these demands (k, N), calculated in the wider scalar."""
    each = values(program, {"tau": taus}, KINDS[scalar][1])
    return [None if one is None else float(np.max(one)) for one in each]


def _at_rest(program: Program) -> list[Any]:
    """Values of every node where tau is zero."""
    named = {operation[1]: operation[2] for operation in program.nodes if operation[0] == "input"}
    inputs = {name: np.zeros((last + 1, 1)) for name, last in named.items()}
    return [
        None if each is None else float(np.ravel(each)[0]) for each in values(program, inputs, np.float64)
    ]


def _compared(nodes: Sequence[Operation], condition: Node) -> list[tuple[Node, Node]]:
    """Pairs (what must not exceed, what it may be) that a refusal compares; each maximum taken apart."""
    match nodes[condition]:
        case ("not", inner) if nodes[inner][0] == "le":
            _, left, bound = nodes[inner]
            return [(term, bound) for term in _maxima(nodes, left)]
        case ("and", a, b):
            return _compared(nodes, a) + _compared(nodes, b)
    return []


def _maxima(nodes: Sequence[Operation], node: Node) -> list[Node]:
    match nodes[node]:
        case ("max", a, b):
            return _maxima(nodes, a) + _maxima(nodes, b)
        case ("add", a, b) if nodes[b][0] == "sub" and nodes[b][1] == nodes[b][2]:
            return _maxima(nodes, a)
        case ("sub", a, b) if a == b:
            return []
    return [node]
