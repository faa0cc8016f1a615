"""One kernel, everything that can be shown of it."""

import tempfile
import time
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from alloc import NotApplicable
from alloc.c import digest, known_faults
from alloc.program import Node
from bench.chips.target import targets
from bench.chips.toolchain import ToolError, missing
from bench.harness import machine
from bench.proof import misra, tools
from bench.proof.answers import answered
from bench.proof.not_read import NotRead
from bench.proof.proof import ASSUMPTIONS, Claim, Proof, Rounding, WorstPath, not_shown
from bench.proof.rounding.band import verdict_band
from bench.proof.rounding.errors import Errors
from bench.proof.rounding.gappa import before_limits
from bench.proof.rounding.search import RUNS, searched
from bench.proof.rounding.seen import seen
from bench.proof.safety import claims as safety
from bench.proof.safety import esc
from bench.proof.sent import sent
from bench.proof.subject import Subject, subject
from bench.proof.symbolic import programs
from bench.proof.translation import translated
from bench.proof.worst import Contradicted, Counted, worst_path


class Effort(NamedTuple):
    """How much is tried beside what is proven.

    Attributes
    ----------
    demands, demands_fault : those of the whole vehicle and of each fault, beside whose largest error the
        bound on rounding stands
    runs : how often a search for larger errors begins anew
    closely : whether a bound far above the errors is followed more closely, for some times as long
    """

    demands: int
    demands_fault: int
    runs: int
    closely: bool


USUAL = Effort(100_000, 2_000, 1, closely=False)
THOROUGH = Effort(1_000_000, 10_000, RUNS, closely=True)
FAR = 10.0
"""Where the bound is so many times the largest error of random demands, a search looks for larger ones; where
it is so many times those, too, for a closer bound."""
ALIKE = 2.0**-23
"""Constants this close are one number, in double and rounded to float."""

SAYS = 0.01
"""A band as wide as this leaves next to nothing that is refused."""

BOUNDED = "Rounding moves no thrust of an attainable demand by more than the bound below."


REFUSES = "A demand whose α* is below 1 by more than the band is refused."
WORST = "No call takes more instructions than the bound."


def prove(
    of: Subject,
    effort: Effort = USUAL,
    say: Callable[[str], None] = lambda _: None,
    before: Counted = MappingProxyType({}),
) -> Proof:
    """The proof of a kernel; raises NotInstalled where Frama-C is missing.

    ``say`` is told what is looked at next; ``before`` are costly demands that are known.
    """
    begin = time.perf_counter()
    say("memory, status and limits")
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        claims, way = safety.claims(of, Path(folder)), esc.claims(of, Path(folder))
        rules = misra.broken(of, Path(folder))
        runs = claims[0].verdict == "shown"  # C that may write anywhere is not run
        if runs and way and way[0].verdict == "shown":
            way += sent(of, Path(folder))
    claims += [*way, translated(of)]
    if runs:
        say("answers to many demands")
        claims += answered(of)
    say("rounding")
    bounded, rounding = _bounded(of, effort)
    say("worst paths")
    paths, refuted, lacking = _paths(of, before)
    beside = esc.files(of)
    if rules is None:
        lacking.append(not_shown("MISRA C:2012", ["needs cppcheck: " + tools.remedy(["cppcheck"])]))
    return Proof(
        vehicle=of.vehicle.name,
        method=of.kernel,
        scalar=of.scalar,
        limits=of.limits,
        function=of.name,
        files=[f"{of.name}.h", f"{of.name}.c"],
        sha256=digest(of.name, of.files),
        esc_files=[*beside],
        esc_sha256=sha256("".join(beside.values()).encode()).hexdigest() if beside else "",
        thrustbench=machine.commit(),
        tools={name: tools.version(name) for name in tools.PACKAGES},
        assumptions=ASSUMPTIONS,
        claims=[*claims, *refuted],
        numbers=[bounded, _band(rounding, {-1, *known_faults(of.vehicle, of.faults).tolist()}), *lacking],
        rounding=rounding,
        worst_paths=paths,
        misra=rules or [],
        seconds=round(time.perf_counter() - begin, 1),
    )


def _band(rounding: list[Rounding], faults: set[int]) -> Claim:
    """The widest band of all that the C answers for: each of these ``faults``, -1 among them."""
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


def _bounded(of: Subject, effort: Effort) -> tuple[Claim, list[Rounding]]:
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
        demands = effort.demands if fault < 0 else effort.demands_fault
        try:
            bound, flipped = errors.bound(), turned.bound()
            band = verdict_band(program, errors, vehicle, of.scalar)
            sample = seen(program, vehicle, of.scalar, exact.get(fault, {}), demands)
        except (NotRead, NotApplicable) as reason:
            words.append(f"fault {fault}: {reason}")
            continue
        worse = None
        if sample.error < (enough := bound / FAR):
            worse = searched(program, vehicle, of.scalar, exact.get(fault, {}), enough, effort.runs)
        largest = max(sample.error, worse or 0.0)
        if effort.closely and largest < enough and not errors.branches:
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


def _paths(of: Subject, before: Counted) -> tuple[list[WorstPath], list[Claim], list[Claim]]:
    """The worst paths, bounds that a call disproves, and targets that lack a tool."""
    paths, refuted, lacking = list[WorstPath](), list[Claim](), list[Claim]()
    for target in targets():
        if of.scalar not in target.scalars:  # in software its length depends on the numbers
            continue
        words = missing(target)
        try:
            if not words:
                paths.append(worst_path(of, target, before))
        except Contradicted as error:
            refuted.append(not_shown(WORST, [str(error)]))
        except ToolError as error:
            words = str(error)
        if words:
            lacking.append(not_shown(f"The worst path on {target.name}.", [words]))
    return paths, refuted, lacking
