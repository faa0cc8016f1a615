"""One kernel, everything that can be shown of it."""

import tempfile
import time
from pathlib import Path

from alloc import NotApplicable
from alloc.c import digest
from alloc.kernels.tolerance import TOLERANCE
from alloc.program import Node
from alloc.vehicle.condition import wrench_doubt
from bench.chips.target import targets
from bench.chips.toolchain import ToolError, missing
from bench.harness import machine
from bench.proof import answers, misra, tools
from bench.proof.not_read import NotRead
from bench.proof.path.worst import worst_path
from bench.proof.proof import ASSUMPTIONS, Claim, Proof, Rounding, WorstPath, not_shown
from bench.proof.rounding.band import verdict_band
from bench.proof.rounding.errors import Errors
from bench.proof.rounding.gappa import before_limits
from bench.proof.rounding.search import searched
from bench.proof.rounding.seen import made, seen
from bench.proof.safety import claims as safety
from bench.proof.safety.harness import Subject, subject
from bench.proof.symbolic import programs
from bench.proof.translation import translated

DEMANDS = 1_000_000
"""Demands of the whole vehicle beside whose largest error the bound stands."""
DEMANDS_FAULT = 10_000
"""Of each fault."""
FAR = 10.0
"""Where the bound is so many times the largest error of random demands, a search looks for larger ones; where
it is so many times those, too, for a closer bound."""
ALIKE = 2.0**-23
"""Constants this close are one number, in double and rounded to float."""

BOUNDED = "Rounding moves no thrust of an attainable demand by more than the bound below."


def prove(of: Subject) -> Proof:
    """The proof of a kernel; raises NotInstalled where Frama-C is missing."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        claims = safety.claims(of, Path(folder))
        rules = misra.broken(of, Path(folder))
    bounded, rounding = _bounded(of)
    paths, lacking = _paths(of)
    if rules is None:
        lacking.append(not_shown("MISRA C:2012", ["needs cppcheck: " + tools.remedy(["cppcheck"])]))
    return Proof(
        vehicle=of.vehicle.name,
        method=of.kernel,
        scalar=of.scalar,
        limits=of.limits,
        function=of.name,
        sha256=digest(of.name, of.files),
        thrustbench=machine.commit(),
        tools={name: tools.version(name) for name in tools.PACKAGES},
        assumptions=ASSUMPTIONS,
        claims=[*claims, *answers.claims(of), translated(of)],
        numbers=[bounded, made(of), *lacking],
        rounding=rounding,
        worst_paths=paths,
        misra=rules or [],
        seconds=round(time.perf_counter() - begin, 1),
    )


def _bounded(of: Subject) -> tuple[Claim, list[Rounding]]:
    if of.limits == "call":
        return not_shown(BOUNDED, ["limits of the call: ranges are known for the vehicle's own only"]), []
    try:
        found, exact = programs(of), _exact(of)
    except (NotRead, ToolError) as error:
        return not_shown(BOUNDED, [str(error)]), []
    rows: list[Rounding] = []
    words: list[str] = []
    for fault, program in found.items():
        vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
        given = program, vehicle, of.scalar, exact.get(fault)
        errors = Errors(*given)
        turned = Errors(*given, flips=True) if errors.branches else errors
        slack = max(TOLERANCE[of.scalar], wrench_doubt(vehicle)) * vehicle.f_scale
        demands = DEMANDS if fault < 0 else DEMANDS_FAULT
        try:
            bound, flipped = errors.bound(), turned.bound()
            band = verdict_band(program, errors, slack)
            sample = seen(program, vehicle, of.scalar, exact.get(fault, {}), demands)
        except NotRead as reason:
            words.append(f"fault {fault}: {reason}")
            continue
        worse = None
        if sample.error < (enough := bound / FAR):
            worse = searched(program, vehicle, of.scalar, exact.get(fault, {}), enough)
        largest = max(sample.error, worse or 0.0)
        if largest < enough and not errors.branches:
            bound = flipped = min(bound, Errors(*given, closely=True).bound())
        gappa = before_limits(program, errors, vehicle, of.scalar) if fault < 0 else None
        rows.append(
            Rounding(
                fault=fault,
                bound_n=bound,
                observed_n=sample.error,
                demands=demands,
                searched_n=worse,
                gappa_n=gappa,
                flipped_n=flipped if flipped > bound else None,
                flips=sample.flips,
                flipped_seen_n=sample.flipped,
                verdict_band=band,
            )
        )
        if not (largest <= bound and sample.flipped <= flipped):
            words.append(f"fault {fault}: an error of {largest:.3g} N was seen, above the bound")
    if words:
        return not_shown(BOUNDED, words), rows
    return Claim(claim=BOUNDED, verdict="shown", by="ranges and errors, operation by operation"), rows


def _exact(of: Subject) -> dict[int, dict[Node, float]]:
    """Of each fault, constants by node as they were before they were rounded to float; none in double.

    They are read out of the same kernel in double. Where float makes other sums of it, the constants count as
    they stand in the C.
    """
    if of.scalar == "double":
        return {}
    try:
        double = programs(subject(of.vehicle, of.kernel, "double", of.limits))
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


def _paths(of: Subject) -> tuple[list[WorstPath], list[Claim]]:
    paths, lacking = [], []
    for target in targets():
        if of.scalar not in target.scalars:  # in software its length depends on the numbers
            continue
        words = missing(target)
        try:
            if not words:
                paths.append(worst_path(of, target))
        except ToolError as error:
            words = str(error)
        if words:
            lacking.append(not_shown(f"The worst path on {target.name}.", [words]))
    return paths, lacking
