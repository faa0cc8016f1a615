"""A proof of generated C holds for any bits in its arguments; and it fails where the C is broken."""

import json
import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from alloc import generate, load_vehicle
from alloc.c import digest
from alloc.c.compiled import compiler
from alloc.program import Scalar
from bench.commands.prove import command
from bench.proof import Proof, prove, subject, tools
from bench.proof.certify import broken_rules
from bench.proof.safety import claims as safety
from bench.proof.safety import eva
from sabotages import KINDS, SABOTAGES, Sabotage, all_kinds, noticed, sabotaged
from tests.analysers import needs_frama_c

UKWIAL = load_vehicle("ukwial")
QUICK = {
    "an entry behind tau is read",
    "a sign is wrong",
    "a thrust is not cut at its limits",
    "a lower limit stands for the upper",
    "a limit is wider by one bit",
    "NaN passes the limits",
    "a number is read before it is written",
    "f is touched by a call that is refused",
    "another thruster is taken for the failed one",
    "faults that there are not go by the name of one",
    "a share is above one",
    "GCC's hint lets NaN pass",
}
"""Breaks tried here; test_symbolic.py breaks C with limits of the call, ``make prove`` all there is."""

ALIKE = {
    "a sign is wrong",
    "a lower limit stands for the upper",
    "a limit is wider by one bit",
    "another thruster is taken for the failed one",
}
"""Those that the same claim shows as another does: asked with ``-m long``."""


@pytest.fixture(autouse=True)
def _analyser() -> None:
    needs_frama_c()


@pytest.mark.parametrize(
    ("kernel", "limits"),
    [
        ("nullspace", "fixed"),
        ("scaled", "call"),
        ("pinv", "fixed"),
        pytest.param("nullspace", "call", marks=pytest.mark.long),
        pytest.param("scaled", "fixed", marks=pytest.mark.long),
        pytest.param("pinv", "call", marks=pytest.mark.long),
    ],
)
def test_a_kernel_is_free_of_errors_and_keeps_limits(kernel: str, limits: str, tmp_path: Path) -> None:
    """Each claim is shown; of the closed form, which knows no limits, all but that on limits."""
    of = subject(UKWIAL, kernel, "double", limits)  # type: ignore[arg-type]  # pytest's parameters are text
    claims = safety.claims(of, tmp_path)
    assert len(claims) >= 3
    assert {claim.verdict for claim in claims} <= {"shown", "does not apply"}
    assert [claim.claim for claim in claims if claim.verdict == "does not apply"] == (
        [] if of.limited else [safety.LIMITS]
    )


@pytest.mark.parametrize("kernel", ["clip", "shrink", "redistribute"])
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_one_function_for_all_faults_gives_zero_for_the_one_that_is_off(
    kernel: str, scalar: Scalar, tmp_path: Path
) -> None:
    """Also where what the others take over is taken from it, x - x, of which intervals see no zero."""
    claims = safety.claims(subject(UKWIAL, kernel, scalar, "fixed", "all"), tmp_path)
    assert {claim.verdict for claim in claims} == {"shown"}


@pytest.mark.parametrize("scalar", ["double", "float"])
def test_a_limit_that_no_decimal_is_exactly_is_the_number_that_the_c_has(
    scalar: Scalar, tmp_path: Path
) -> None:
    """99.7 is a real to the analyser, and another number in C."""
    claims = safety.claims(subject(load_vehicle("subjugator8"), "clip", scalar, "fixed"), tmp_path)
    assert {claim.verdict for claim in claims} == {"shown"}


def test_a_thruster_that_could_not_rest_gives_zero_when_it_is_off(tmp_path: Path) -> None:
    """Its limits leave out zero, and hold while it works."""
    never = replace(UKWIAL, f_min=np.array([-250.0, 10.0, -250.0, -250.0]))
    claims = safety.claims(subject(never, "clip", "double", "fixed"), tmp_path)
    assert {claim.verdict for claim in claims} == {"shown"}


@pytest.mark.parametrize(
    "sabotage",
    [
        pytest.param(each, id=each.name, marks=pytest.mark.long if each.name in ALIKE else ())
        for each in SABOTAGES
        if each.name in QUICK
    ],
)
def test_a_proof_finds_sabotage(sabotage: Sabotage, tmp_path: Path) -> None:
    """The same C, broken in one place, is not shown, and the words say why."""
    whole = subject(UKWIAL, sabotage.kernel, "double", sabotage.limits)
    assert noticed(sabotaged(whole, sabotage), tmp_path)


PLANTS = [each for each in SABOTAGES if any(each.name.endswith(f"] is {kind}") for kind in KINDS)]
REACHED = {
    "an entry": safety.NO_ERROR,
    "a status": safety.STATUS,
    "f is touched": safety.STATUS,
    "limits": safety.LIMITS,
    "a share": safety.SHARES,
}


@pytest.mark.long
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize(
    "sabotage", [pytest.param(each, id=each.name) for each in PLANTS if each.limits == "fixed"]
)
def test_a_claim_is_not_shown_where_one_kind_of_demand_breaks_it(
    sabotage: Sabotage, scalar: Scalar, tmp_path: Path
) -> None:
    """EVA itself finds it: NaN in an entry of an array was once unreachable to it."""
    of = sabotaged(subject(UKWIAL, sabotage.kernel, scalar, "fixed"), sabotage)
    found = {each.claim for each in safety.claims(of, tmp_path) if each.verdict == "not shown"}
    (broken,) = {claim for words, claim in REACHED.items() if sabotage.name.startswith(words)}
    assert broken in found
    assert broken == safety.NO_ERROR or safety.NO_ERROR not in found


LOCAL = {
    r"        int j = 0;\n": ("f[0]", "low[0]", "high[0]", "Z[0][0]", "E[0][0]", "end[0]"),
    r"    if \(of_z > ": ("f[0]", "Z[0][0]", "E[0][0]"),
    r"    const \w+ y0 = tb_withinf?\(g\[0\]": ("g[0]",),
}
"""By line of redistribute's C, its own arrays that can be read in front of it."""


@pytest.mark.parametrize("scalar", ["double", pytest.param("float", marks=pytest.mark.long)])
def test_an_error_that_one_kind_of_number_in_a_local_array_reaches_is_found(
    scalar: Scalar, tmp_path: Path
) -> None:
    of = subject(UKWIAL, "redistribute", scalar, "call", "none")
    text, planted = of.source, 0
    for line, numbers in LOCAL.items():
        text, count = re.subn(line, lambda at, numbers=numbers: all_kinds(*numbers) + at[0], text, count=1)
        planted += count * len(numbers) * len(KINDS)
    broken = replace(of, files={**of.files, f"{of.name}.c": text})
    words = safety.claims(broken, tmp_path)[0].words
    assert planted == 10 * len(KINDS)
    assert len({word.split(": ")[0] for word in words if "99 < 1: Invalid" in word}) == planted


def test_an_array_that_is_known_and_holds_no_number_is_not_shown(tmp_path: Path) -> None:
    """Limits keep their values for the analyser, so that they are asserted to be numbers."""
    of = subject(UKWIAL, "redistribute", "double", "fixed", "none")
    text = of.source.replace("low[4] = {-c[3],", "low[4] = {tau[0],")
    assert text != of.source
    broken = replace(of, files={**of.files, f"{of.name}.c": text})
    assert any("is_finite(low[0])" in word for word in safety.claims(broken, tmp_path)[0].words)


def test_the_status_of_a_fault_that_there_is_not_is_its_own(tmp_path: Path) -> None:
    """The switch is as it should be, and the name in it means infeasible."""
    of = subject(UKWIAL, "nullspace", "double", "fixed")
    header = of.files[f"{of.name}.h"].replace("TB_NO_SUCH_FAULT = -1", "TB_NO_SUCH_FAULT = 2")
    claims = safety.claims(replace(of, files={**of.files, f"{of.name}.h": header}), tmp_path)
    assert [claim.claim for claim in claims if claim.by == eva.NAME] == [safety.STATUS]
    assert {claim.verdict for claim in claims} == {"not shown"}  # of another header than is printed


def test_each_sabotage_that_is_tried_is_there() -> None:
    assert {each.name for each in SABOTAGES} >= QUICK


def test_what_an_analyser_can_not_read_is_not_shown(tmp_path: Path) -> None:
    """C that does not compile shows nothing, and the reason stands beside it."""
    broken = Sabotage("no C", "nullspace", "fixed", r"return TB_SOLVED;", "return TB_SOLVED")
    of = sabotaged(subject(UKWIAL, "nullspace", "double", "fixed"), broken)
    claims = safety.claims(of, tmp_path)
    assert {claim.verdict for claim in claims} == {"not shown"}
    assert any("no C: " in text for claim in claims for text in claim.words)


def test_the_command_writes_proof_page_and_the_c_they_speak_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The hash in proof.json is that of the files beside it, and the self-test prints it."""
    monkeypatch.setattr("bench.proof.worst.processors", lambda: ())  # tests/bench/proof/test_worst.py
    out = tmp_path / "proof"
    done = CliRunner().invoke(
        command,
        ["--vehicle", "ukwial", "--method", "nullspace", "--out", str(out)],
        standalone_mode=False,
        catch_exceptions=False,
    )
    assert done.return_value == 0, done.output
    assert "proof.md: all shown, but for " in done.output
    proof = msgspec.json.decode((out / "proof.json").read_bytes(), type=Proof)
    files = {path.name: path.read_text() for path in out.glob(f"{proof.function}.[ch]")}
    assert proof.sha256 == digest(proof.function, files)
    assert proof.sha256 in generate(UKWIAL, "nullspace")[f"test/{proof.function}_test.c"]
    assert proof.tools["frama-c"]
    assert proof.assumptions
    assert proof.sha256 in (out / "proof.md").read_text()
    assert json.loads((out / "proof.json").read_text())["claims"][0]["verdict"] == "shown"


def test_a_proof_says_what_it_looks_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command prints each step; C that may write anywhere is not run."""
    monkeypatch.setattr("bench.proof.worst.processors", lambda: ())
    steps = list[str]()
    made = prove(subject(UKWIAL, "pinv", "double", "fixed"), say=steps.append)
    assert steps == [
        "memory, status and limits",
        "answers to many demands",
        "the equation of an answer",
        "worst paths",
    ]
    (wild,) = (each for each in SABOTAGES if each.name == "an entry behind f is written")
    steps.clear()
    unsafe = prove(sabotaged(subject(UKWIAL, wild.kernel, "double", wild.limits), wild), say=steps.append)
    assert "answers to many demands" not in steps
    assert (made.safe, unsafe.safe) == (True, False)


def test_a_proof_says_which_rules_of_misra_are_broken_and_why(tmp_path: Path) -> None:
    """Every rule that the add-on names has a reason here."""
    if "cppcheck" in tools.absent():
        pytest.skip(f"needs cppcheck: {tools.remedy(['cppcheck'])}")
    rules = broken_rules(subject(UKWIAL, "nullspace", "double", "call"), tmp_path)
    assert rules
    assert [each.rule for each in rules if not each.reason] == []


def test_a_compiler_is_there_where_an_analyser_is() -> None:
    """Both analyser and reader preprocess the C with it."""
    assert compiler()
