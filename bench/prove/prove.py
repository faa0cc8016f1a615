"""One kernel, everything that can be shown of it."""

import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from alloc import NotApplicable
from alloc.native import digest
from alloc.native.code import TOLERANCE
from alloc.vehicle.condition import wrench_doubt
from bench.emulation.toolchain import ToolError, missing, target
from bench.harness import machine
from bench.prove import misra, safety, tools
from bench.prove.certificate import ASSUMPTIONS, Certificate, Claim, Rounding, WorstPath
from bench.prove.gappa import before_limits
from bench.prove.harness import Subject, subject
from bench.prove.rounding import Errors, verdict_band
from bench.prove.seen import MET, seen
from bench.prove.symbolic import Node, NotRead, Program, programs
from bench.prove.worst import TARGETS, worst_path

DEMANDS = 1_000_000
"""Demands of the whole vehicle beside whose largest error the bound stands."""
DEMANDS_FAULT = 10_000
"""Of each fault, and where there is no bound."""
ALIKE = 2.0**-23
"""Constants this close are one number, in double and rounded to float."""

BOUNDED = "Rounding moves no thrust of an attainable demand by more than the bound below."
MADE = "An attainable demand that is SOLVED is made: T f = tau. Tested, not proven."


class Studied(NamedTuple):
    """What was found about numbers: claims, and a row for each fault."""

    claims: list[Claim]
    rounding: list[Rounding]


def prove(of: Subject) -> Certificate:
    """The certificate of a kernel; raises NotInstalled where Frama-C is missing."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        claims = safety.claims(of, Path(folder))
        rules = misra.broken(of, Path(folder))
    studied = _numbers(of)
    paths, lacking = _paths(of)
    if rules is None:
        lacking.append(_not_shown("MISRA C:2012", ["needs cppcheck: " + tools.remedy(["cppcheck"])]))
    return Certificate(
        vehicle=of.vehicle.name,
        method=of.kernel,
        scalar=of.scalar,
        limits=of.limits,
        function=of.name,
        sha256=digest(of.name, of.files),
        thrustbench=machine.commit(),
        tools={name: tools.version(name) for name in tools.PACKAGES},
        assumptions=ASSUMPTIONS,
        claims=claims,
        numbers=[*studied.claims, *lacking],
        rounding=studied.rounding,
        worst_paths=paths,
        misra=rules or [],
        seconds=round(time.perf_counter() - begin, 1),
    )


def _numbers(of: Subject) -> Studied:
    if of.limits == "call":
        reason = "limits of the call: ranges are known for the vehicle's own limits only"
        return Studied([_not_shown(BOUNDED, [reason])], [])
    try:
        found, exact = programs(of), _exact(of)
    except (NotRead, ToolError) as error:
        return Studied([_not_shown(BOUNDED, [str(error)]), _not_shown(MADE, [str(error)])], [])
    rows: list[Rounding] = []
    words: list[str] = []
    missed: list[str] = []
    solved = 0
    for fault, program in found.items():
        vehicle = of.vehicle if fault < 0 else of.vehicle.with_fault(fault)
        errors = Errors(program, vehicle, of.scalar, exact.get(fault))
        try:
            bound = max(errors.error(node) for (name, _), node in program.outputs.items() if name == "f")
            slack = max(TOLERANCE[of.scalar], wrench_doubt(vehicle)) * vehicle.f_scale
            band = verdict_band(program, errors, slack)
        except NotRead as reason:
            bound, band = None, None
            words.append(f"fault {fault}: {reason}")
        demands = DEMANDS if fault < 0 and bound is not None else DEMANDS_FAULT
        try:
            sample = seen(program, vehicle, of.scalar, exact.get(fault, {}), demands, bound is not None)
        except NotRead as reason:
            missed.append(f"fault {fault}: {reason}")
            continue
        solved += sample.solved
        if not sample.missed <= MET[of.scalar]:
            missed.append(f"fault {fault}: T f misses tau by {sample.missed:.2g} of the wrench scale")
        if bound is not None:
            row = Rounding(
                fault=fault, bound_n=bound, observed_n=sample.error, demands=demands, verdict_band=band
            )
            rows.append(row if fault >= 0 else _with_gappa(row, program, errors, of))
            if not sample.error <= bound:
                words.append(f"fault {fault}: an error of {sample.error:.3g} N was seen, above the bound")
    made = Claim(claim=MADE, verdict="tested", by="seeded demands", words=[f"{solved:,} SOLVED"])
    shown = Claim(claim=BOUNDED, verdict="shown", by="ranges and errors, operation by operation")
    return Studied(
        [_not_shown(BOUNDED, words) if words else shown, _not_shown(MADE, missed) if missed else made], rows
    )


def _with_gappa(row: Rounding, program: Program, errors: Errors, of: Subject) -> Rounding:
    bound = before_limits(program, errors, of.vehicle, of.scalar)
    return Rounding(
        fault=row.fault,
        bound_n=row.bound_n,
        observed_n=row.observed_n,
        demands=row.demands,
        gappa_n=bound,
        verdict_band=row.verdict_band,
    )


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
    for name in TARGETS[of.scalar]:
        words = missing(target(name))
        try:
            if not words:
                paths.append(worst_path(of, target(name)))
        except ToolError as error:
            words = str(error)
        if words:
            lacking.append(_not_shown(f"The worst path on {name}.", [words]))
    return paths, lacking


def _not_shown(claim: str, words: list[str]) -> Claim:
    return Claim(claim=claim, verdict="not shown", by="", words=words)
