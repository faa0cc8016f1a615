"""C that breaks no claim on memory or limits, and still answers wrongly, is not shown."""

from dataclasses import replace

import pytest

from alloc import load_vehicle
from alloc.c import missing
from bench.proof import answers, subject
from bench.proof.proof import Claim, Proof
from bench.proof.safety.harness import Subject

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


def of(kernel: str, old: str = "", new: str = "") -> Subject:
    """The C of a method for Ukwial, with one piece of its text exchanged."""
    made = subject(load_vehicle("ukwial"), kernel, "double", "fixed")
    name = f"{made.name}.c"
    assert old in made.files[name]
    return replace(made, files={**made.files, name: made.files[name].replace(old, new, 1)})


def not_shown(broken: Subject) -> set[str]:
    """What is claimed and not shown."""
    kinds = {
        answers.ANSWERS[:40]: "answers",
        answers.SHARE: "share",
        answers.LEAST: "least",
        answers.STATICS: "statics",
    }
    failed = [claim.claim for claim in answers.claims(broken) if claim.verdict == "not shown"]
    return {kind for text in failed for begin, kind in kinds.items() if text.startswith(begin)}


@pytest.mark.parametrize("kernel", ["nullspace", "scaled", "priority", "pinv", "clip", "redistribute"])
def test_a_kernel_as_it_is_answers_what_it_must(kernel: str) -> None:
    verdicts = [claim.verdict for claim in answers.claims(of(kernel))]
    assert set(verdicts) == {"shown", "tested"}


BODY = "    const double t2 = tau[2];\n"
BROKEN = {
    "refuses everything": (
        "nullspace", BODY, f"    if (1) return INFEASIBLE;\n{BODY}",
        {"answers", "least"},
    ),
    "a tolerance a million times as wide": (
        "nullspace", "0x1.0c6f7a0b5ed8ep-22", "0x1.0c6f7a0b5ed8ep-2", {"answers"}
    ),
    "more effort than needed": ("nullspace", "least(hi0, 0x0.0p+0)", "least(hi0, 0x1.0p+0)", {"least"}),
    "a counter that breaks the second call": (
        "nullspace", BODY, f"    static int calls;\n    if (++calls == 2) return INFEASIBLE;\n{BODY}",
        {"answers", "statics"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", BROKEN)
def test_what_answers_wrongly_is_found(what: str) -> None:
    kernel, old, new, found = BROKEN[what]
    assert not_shown(of(kernel, old, new)) == found


def test_a_share_that_is_not_the_linear_program_s_is_found() -> None:
    made = of("scaled")
    name = f"{made.name}.c"
    text = made.files[name]
    at = text.index("share[0] = ")
    end = text.index(";", at)
    changed = f"{text[:at]}share[0] = 0.999 * ({text[at + 11 : end]}){text[end:]}"
    assert not_shown(replace(made, files={**made.files, name: changed})) == {"share"}


def test_a_proof_s_first_line_is_the_least_of_its_claims() -> None:
    facts = dict.fromkeys(("vehicle", "method", "scalar", "limits", "function", "sha256", "thrustbench"), "-")
    shown, tested, lacking = (
        Claim(claim="a", verdict=verdict, by="")  # type: ignore[arg-type]  # texts of the Literal
        for verdict in ("shown", "tested", "not shown")
    )

    def least(*claims: Claim, numbers: list[Claim]) -> str:
        made = Proof(**facts, tools={}, assumptions=[], claims=list(claims), numbers=numbers)
        return made.least

    assert least(shown, numbers=[shown]) == "all shown"
    assert least(shown, tested, numbers=[]) == "all shown, but for 1 that are tested"
    assert least(shown, tested, numbers=[lacking]) == "1 of 3 claims not shown"
