"""A proof as a page, and several as a table."""

from collections import Counter
from collections.abc import Iterable

from bench.proof.proof import Proof, Rounding, WorstPath
from bench.results.text import table, three

ROWS = 20
"""Paths that a page shows of each target."""
VERDICTS = {
    "taken": "that a call takes",
    "infeasible": "that none takes",
    "neither": "of which neither is known",
}
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

{proof.method} for {proof.vehicle}, {proof.scalar}, limits {LIMITS[proof.limits]}.
This page speaks of the header and the source for which

    cat {proof.function}.h {proof.function}.c | sha256sum

prints `{proof.sha256}`; the self-test prints the same number.

## What is shown

{claims}
{_rounding(proof)}{_worst_paths(proof.worst_paths)}{_misra(proof)}
## What this rests on

{assumptions}

Made by thrustbench {proof.thrustbench} with {named} in {proof.seconds:.0f} s.
`docs/proof.md` says what each of these is worth.
"""


def _rounding(proof: Proof) -> str:
    if not proof.rounding:
        return ""
    return "\n## Rounding\n\n" + table(
        [
            "thruster off",
            "bound [N]",
            "largest seen [N]",
            "of demands",
            "found by a search [N]",
            "bound / largest",
            "bound where a branch turns [N]",
            "Gappa, before limits [N]",
            "1 - α*",
        ],
        (_rounding_row(each) for each in proof.rounding),
    )


def _rounding_row(each: Rounding) -> list[str]:
    return [
        "-" if each.fault < 0 else str(each.fault),
        three(each.bound_n),
        three(each.observed_n),
        f"{each.demands:,}",
        three(each.searched_n) if each.searched_n is not None else "-",
        three(each.ratio) if each.ratio else "-",
        three(each.flipped_n) if each.flipped_n is not None else "-",
        three(each.gappa_n) if each.gappa_n is not None else "-",
        three(each.verdict_band) if each.verdict_band is not None else "-",
    ]


def _worst_paths(paths: list[WorstPath]) -> str:
    rows = [
        [
            each.target,
            str(each.attained),
            "not known" if each.at_most is None else str(each.at_most),
            "exact" if each.at_most == each.attained else each.reason or "an interval",
            f"{each.calls:,}",
            ", ".join(f"{status}: {most}" for status, most in each.by_status.items()),
        ]
        for each in paths
    ]
    if not rows:
        return ""
    worst = table(["target", "attained", "at most", "", "calls run", "attained by status"], rows)
    listed = "".join(_paths(each) for each in paths if each.paths)
    return f"\n## The worst path, in instructions\n\n{worst}{listed}"


def _paths(worst: WorstPath) -> str:
    """The ways through the binary for one target."""
    counted: Counter[str] = Counter(each.verdict for each in worst.paths)
    kinds = ", ".join(f"{counted[verdict]} {word}" for verdict, word in VERDICTS.items())
    which = "all" if worst.all_paths else "not all, the longest among them"
    rows = [
        [
            str(each.instructions),
            "-" if each.fault < 0 else str(each.fault),
            each.verdict,
            " ".join(f"{value:.6g}" if isinstance(value, float) else value for value in each.call),
        ]
        for each in worst.paths[:ROWS]
    ]
    more = f"\n{len(worst.paths) - ROWS} more stand in proof.json.\n" if len(worst.paths) > ROWS else ""
    head = ["instructions", "thruster off", "", "a call that takes it"]
    return f"\n### Paths on {worst.target}: {which}\n\n{kinds}.\n\n{table(head, rows)}{more}"


def _misra(proof: Proof) -> str:
    if not proof.misra:
        return ""
    return "\n## MISRA C:2012 rules that are broken\n\n" + table(
        ["rule", "places", "why"], ([each.rule, str(each.places), each.reason] for each in proof.misra)
    )


def summary(proofs: Iterable[Proof]) -> str:
    """Markdown: one line a kernel."""
    return "# Proofs\n\n" + table(
        [
            "kernel",
            *("errors", "status", "limits"),
            "rounding / seen",
            "worst path",
            "MISRA without a reason",
            "s",
        ],
        (_line(proof) for proof in proofs),
    )


def _line(proof: Proof) -> list[str]:
    verdicts = [each.verdict.replace("does not apply", "-") for each in proof.claims[:3]]
    ratios = [each.ratio for each in proof.rounding]
    exact = [f"{each.target} {each.attained}" for each in proof.worst_paths if each.at_most == each.attained]
    wide = [
        f"{each.target} {each.attained}…{each.at_most}"
        for each in proof.worst_paths
        if each.at_most != each.attained
    ]
    return [
        proof.function,
        *verdicts,
        three(max(ratios)) if any(ratios) else "-",
        ", ".join([*exact, *wide]) or "-",
        str(sum(not each.reason for each in proof.misra)),
        f"{proof.seconds:.0f}",
    ]
