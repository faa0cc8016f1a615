"""A proof as a page, several as a table, and the folder of one: the C, proof.json, and its page."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from alloc.files.textfile import write_folder
from bench.proof.proof import Miss, Proof, WorstPath
from bench.report.html import document
from bench.results.text import table, three

LIMITS = {"call": "of the call", "fixed": "fixed"}


def page(proof: Proof) -> str:
    """Markdown: what was shown, what was not, and what it rests on."""
    named = ", ".join(f"{name} {version}" for name, version in proof.tools.items() if version)
    claims = table(
        ["claim", "", "by", "in the tool's words"],
        (
            (each.claim, each.verdict, each.by, "; ".join(each.words[:6]))
            for each in [*proof.claims, *proof.numbers]
        ),
    )
    assumptions = "\n".join(f"- {each}" for each in proof.assumptions)
    return f"""\
# Proof of {proof.function}

**{proof.least[:1].upper()}{proof.least[1:]}.**

{proof.method} for {proof.vehicle}, {proof.scalar}, limits {LIMITS[proof.limits]}.
This page speaks of the files for which

    cat {" ".join(proof.files)} | sha256sum

prints `{proof.sha256}`; a self-test prints which it was made with.
{_beside(proof)}
## What is shown

{claims}
{_misses(proof.misses)}{_worst_paths(proof.worst_paths)}{_misra(proof)}
## What this rests on

{assumptions}

Made by thrustbench {proof.thrustbench} with {named} in {proof.seconds:.0f} s.
`docs/proof.md` says what each of these is worth.
"""


def _beside(proof: Proof) -> str:
    if not proof.esc_files:
        return ""
    return f"""
What it says of NAME_esc and NAME_to_esc it says of those for which

    cat {" ".join(proof.esc_files)} | sha256sum

prints `{proof.esc_sha256}`.
"""


def _misses(rows: list[Miss]) -> str:
    if not rows:
        return ""
    head = ("thruster off", "promise [of what SOLVED may miss]", "roundings of T f", "roundings of τ")
    cells = [
        [
            "-" if each.fault < 0 else str(each.fault),
            three(each.promise),
            three(each.roundings),
            three(each.of_tau),
        ]
        for each in rows
    ]
    return "\n## How far T f may be from its wrench\n\n" + table(head, cells)


def _worst_paths(paths: list[WorstPath]) -> str:
    rows = [
        [
            each.target,
            str(each.attained),
            "not known" if each.at_most is None else str(each.at_most),
            "exact" if each.exact else each.reason or "an interval",
            f"{each.calls:,}",
            ", ".join(f"{status}: {most}" for status, most in each.by_status.items()),
        ]
        for each in paths
    ]
    if not rows:
        return ""
    head = ["target", "seen", "at most", "", "calls run", "seen by status"]
    return "\n## The worst path, in instructions\n\n" + table(head, rows)


def _misra(proof: Proof) -> str:
    if not proof.misra:
        return ""
    return "\n## MISRA C:2012 rules that are broken\n\n" + table(
        ["rule", "places", "why"], ([each.rule, str(each.places), each.reason] for each in proof.misra)
    )


def summary(proofs: Iterable[Proof]) -> str:
    """Markdown: one line a kernel."""
    head = (
        *("kernel", "least of all claims", "errors", "status", "limits"),
        *("worst path", "MISRA without a reason", "s"),
    )
    return "# Proofs\n\n" + table(head, map(_line, proofs))


def _line(proof: Proof) -> list[str]:
    verdicts = [each.verdict.replace("does not apply", "-") for each in proof.claims[:3]]
    return [
        proof.function,
        proof.least,
        *verdicts,
        ", ".join(f"{each.target} {each}" for each in proof.worst_paths) or "-",
        str(sum(not each.reason for each in proof.misra)),
        f"{proof.seconds:.0f}",
    ]


def write(made: Mapping[str, str], proof: Proof, folder: Path) -> None:
    """Write this C with its proof into ``folder``, made if missing; raises FileError where that fails."""
    text = page(proof)
    files = {
        **made,
        "proof.json": msgspec.json.format(msgspec.json.encode(proof), indent=2).decode() + "\n",
        "proof.md": text,
        "proof.html": document(text, folder),
    }
    write_folder(folder, files)
