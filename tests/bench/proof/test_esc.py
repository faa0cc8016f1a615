"""Proof of the way to the ESCs, and its failure where the C is broken."""

import re
from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest

from alloc import load_vehicle
from bench.proof import Subject, prove, subject
from bench.proof.page import page
from bench.proof.safety import esc
from sabotages import KINDS, all_kinds
from tests.analysers import needs_frama_c

BLUEROV2 = load_vehicle("bluerov2")


Plant = Callable[[Subject, str, str], None]
"""Function that puts a text into a subject's C for ESCs where a pattern matches."""


@pytest.fixture(autouse=True)
def _analyser() -> None:
    needs_frama_c()


@pytest.fixture
def plant(monkeypatch: pytest.MonkeyPatch) -> Plant:
    """Break the C for ESCs for the rest of a test."""

    def change(of: Subject, pattern: str, instead: str) -> None:
        made, name = esc.files(of), f"{of.name}_esc.c"
        text, changed = re.subn(pattern, instead, made[name])
        assert changed
        monkeypatch.setattr(esc, "files", lambda _: made | {name: text})

    return change


@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_any_bits_give_commands_within_the_range_and_no_error(limits: str, tmp_path: Path) -> None:
    of = subject(BLUEROV2, "pinv", "float", limits)  # type: ignore[arg-type]  # pytest's parameters are text
    assert {claim.verdict for claim in esc.claims(of, tmp_path)} == {"shown"}


def test_a_macro_of_one_compiler_in_the_kernel_s_header_is_not_shown(tmp_path: Path) -> None:
    """The analyser reads the branch that GCC does not."""
    of = subject(BLUEROV2, "pinv", "float", "fixed")
    name = f"{of.name}.h"
    other = of.files[name].replace("\nint ", "\n#ifdef __GNUC__\n#define volts 0.0F\n#endif\nint ")
    assert other != of.files[name]
    claims = esc.claims(replace(of, files={**of.files, name: other}), tmp_path)
    assert {claim.verdict for claim in claims} == {"not shown"}


def test_a_voltage_that_is_kept_for_later_calls_is_not_shown(tmp_path: Path, plant: Plant) -> None:
    """Each command was within its range, and after 5,000 calls another one than Python's."""
    of = subject(BLUEROV2, "pinv", "float", "fixed")
    plant(of, r"\w+_find\(([^)]*)\)\n\{", r"\g<0>\n    static float known;")
    (claim,) = [claim for claim in esc.claims(of, tmp_path) if claim.claim == esc.STATELESS]
    assert (claim.verdict, claim.words) == ("not shown", ["known outlives a call, and can change"])


def test_a_vehicle_without_escs_has_no_such_claim(tmp_path: Path) -> None:
    of = subject(load_vehicle("ukwial"), "pinv", "float", "fixed")
    assert esc.claims(of, tmp_path) == []
    assert esc.files(of) == {}


def test_what_is_told_of_a_number_is_told_where_the_c_asks_for_it_only(tmp_path: Path, plant: Plant) -> None:
    """Limits of the call: C that takes NaN for a number makes an integer of it."""
    of = subject(BLUEROV2, "pinv", "float", "call")
    plant(of, r"const int known = x - x == 0\.0F;", "const int known = 1;")
    assert esc.claims(of, tmp_path)[0].verdict == "not shown"


@pytest.mark.parametrize(
    ("line", "broken"),
    [
        ("return state >= ", "command[0] = (int16_t)(3000 - command[0]);\n    return state >= "),
        (r"x = !known \? ", "x = 0 ? "),
        (r"return sent == TB_SOLVED \? found : sent;", "return TB_SOLVED;"),
    ],
    ids=["a thruster is reversed", "NaN is no zero", "the status is dropped"],
)
def test_safe_c_that_sends_something_else_than_python_is_told(
    line, broken, tmp_path: Path, plant: Plant
) -> None:
    """Each command lies within its range there, and the proof once said that all is shown."""
    of = subject(load_vehicle("bluerov2-heavy"), "clip", "float", "fixed")
    assert [claim.verdict for claim in esc.esc_tests(of, tmp_path / "whole")] == ["tested"]
    plant(of, line, broken)
    assert [claim.verdict for claim in esc.esc_tests(of, tmp_path)] == ["not shown"]


def test_the_page_names_all_files_that_it_speaks_of(monkeypatch) -> None:
    monkeypatch.setattr("bench.proof.worst.processors", lambda: ())
    of = subject(BLUEROV2, "pinv", "float", "fixed")
    proof, made = prove(of), esc.files(of)
    assert proof.esc_files == [*made]
    assert proof.esc_sha256 == sha256("".join(made.values()).encode()).hexdigest()
    assert f"cat {' '.join(made)} | sha256sum\n\nprints `{proof.esc_sha256}`" in page(proof)
    assert esc.SENT in [claim.claim for claim in proof.claims if claim.verdict == "tested"]


@pytest.mark.parametrize(
    ("line", "broken"),
    [
        (r"j > \w+ \? \w+ : j < \w+ \? \w+ : j", "j"),
        *(
            pytest.param(*each, marks=pytest.mark.long)
            for each in (
                (r" & \w+_LAST_CELL\]", "]"),
                (r"while \(above < x && k < .*\) \{", "while (above < x) {"),
                (r"!\(x > least\[curve\] && x < most\[curve\]\)", "0"),
                (r"tb_leastf\((tb_sizef\([^,]*), 1.0F\)", r"\1"),
                (r"_NEUTRAL\(i\) \+ \(j\)\)", "_NEUTRAL(i) + 2 * (j))"),
            )
        ),
        (r"command\[i\] = \w+_NEUTRAL\(i\);", "command[i] = (int16_t)found;"),  # of NAME_to_esc alone
    ],
)
def test_a_broken_line_is_not_shown(line, broken, tmp_path: Path, plant: Plant) -> None:
    of = subject(BLUEROV2, "pinv", "float", "fixed")
    plant(of, line, broken)
    assert "not shown" in [claim.verdict for claim in esc.claims(of, tmp_path)]


@pytest.mark.parametrize(
    ("limits", "numbers"), [("call", ("f[0]", "low[0]", "high[0]")), ("fixed", ("f[0]",))]
)
def test_an_error_that_one_kind_of_number_in_a_local_array_reaches_is_found(
    limits, numbers, tmp_path: Path, plant: Plant
) -> None:
    of = subject(BLUEROV2, "pinv", "float", limits)
    plant(of, r"    if \(found != TB_SOLVED", all_kinds(*numbers) + r"\g<0>")
    words = esc.claims(of, tmp_path)[0].words
    lines = {word.split(": ")[0] for word in words if "99 < 1: Invalid" in word}
    assert len(lines) == len(numbers) * len(KINDS)


def test_a_member_that_may_be_no_number_is_not_shown(tmp_path: Path, plant: Plant) -> None:
    """Curves' ends keep their values for the analyser, so that they are asserted to be numbers."""
    of = subject(BLUEROV2, "pinv", "float", "fixed")
    plant(of, "    now->down = ", "    now->down = volts; now->down = ")
    assert any("is_finite(now->down)" in word for word in esc.claims(of, tmp_path)[0].words)


@pytest.mark.long
@pytest.mark.parametrize("scalar", ["double", "float"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("number", ["f[0]", "f_min[0]", "f_max[0]", "volts"])
@pytest.mark.parametrize(
    ("broken", "instead"),
    [(esc.NO_ERROR, "command[999] = 0;"), (esc.RANGE, "command[0] = 9999; return TB_SOLVED;")],
)
def test_a_number_of_one_kind_that_breaks_a_claim_is_found(
    broken: str, instead: str, number: str, kind: str, scalar, tmp_path: Path, plant: Plant
) -> None:
    of = subject(BLUEROV2, "pinv", scalar, "call")
    planted = rf"\g<0>    if ({KINDS[kind].format(number)}) {{ {instead} }}\n"
    plant(of, r"\w+(?<!_to)_esc\(const [^{]*\)\n\{\n", planted)
    assert broken in [claim.claim for claim in esc.claims(of, tmp_path) if claim.verdict == "not shown"]
