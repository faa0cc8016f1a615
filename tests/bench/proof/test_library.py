"""libthrustbench has no run-time error with any bits in its arguments, and what is broken in it is found."""

import subprocess
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner

from alloc.library import files
from alloc.program import Scalar
from bench.commands.prove import command
from bench.proof import Proof
from bench.proof.library import library_claims
from sabotages import KINDS, all_kinds
from tests.analysers import needs_frama_c

SMALL = 3, 2
"""Thrusters and axes: the same C as with 8 and 6, which ``-m long`` asks, in a tenth of the time."""


@pytest.fixture(autouse=True)
def _analyser() -> None:
    needs_frama_c()


@pytest.mark.long
def test_any_calls_in_any_order_have_no_error_and_return_what_the_header_names(tmp_path: Path) -> None:
    made = library_claims(files("double", *SMALL), SMALL[0], tmp_path)
    assert [claim.verdict for claim in made] == ["shown"] * 5, [claim.words for claim in made]


SABOTAGED = {
    "one thruster too many is looked at": (
        "p < m; p++) {\n        const int i",
        "p <= m; p++) {\n        const int i",
    ),
    "the room for entries of facets is not looked at": ("if (*entries >= TB_ENTRIES_MAX)", "if (0)"),
    "a level may be one too large": ("level[j] >= a->k)", "level[j] > a->k)"),
    "a size is not looked at": ("k > TB_K_MAX ||", ""),
    "the active set may grow": ("if (w.q >= d)", "if (0)"),
    "rows of a facet may lie behind the last": ("row < TB_N_MAX ? row : TB_N_MAX - 1", "row"),
    "a status is none of the header's": ("return TB_NOT_CONVERGED;", "return 7;"),
}


@pytest.mark.long
@pytest.mark.parametrize("sabotage", SABOTAGED)
def test_what_is_broken_is_not_shown(sabotage: str, tmp_path: Path) -> None:
    before, after = SABOTAGED[sabotage]
    whole = files("double", *SMALL)
    broken = {name: text.replace(before, after) for name, text in whole.items()}
    assert broken != whole
    assert "not shown" in [claim.verdict for claim in library_claims(broken, SMALL[0], tmp_path)]


READ = {
    "tb_rules.c": {
        "    const int status = tb_enter(a, tau, f_min, f_max, &t);\n    return": (
            *("tau[0]", "f_min[0]", "f_max[0]", "f[0]", "a->scale", "a->G[0][0]"),
        )
    },
    "tb_prepare.c": {
        "    a->n = a->parts = 0;\n": ("T[0]", "H[0]", "readiness[0]", "f_min[0]", "f_max[0]"),
        "    const int status = mask >> ": ("a->A[0][0]", "a->readiness[0]"),
    },
    "tb_levels.c": {
        "    if (a->n < 1 || used != ": ("a->unit[0]", "a->pushed[0][0]"),
        "    if (status == TB_SOLVED && a->facets": ("share[0]",),
    },
    "tb_facets.c": {"    a->facets = 0;\n": ("doubt", "a->N[0][0]")},
}
"""By file and line of C, numbers of arguments and allocators that can be read in front of it."""


@pytest.mark.long
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_an_error_that_one_kind_of_number_reaches_is_found_in_each_argument(
    scalar: Scalar, tmp_path: Path
) -> None:
    """NaN, infinity, subnormals and minus zero; nothing else is found."""
    made, planted = files(scalar, *SMALL), 0
    for name, lines in READ.items():
        for line, numbers in lines.items():
            assert made[name].count(line) == 1
            faults = ""
            for number in numbers:
                planted += len(KINDS)
                if "->" in number or "[" not in number:
                    faults += all_kinds(number)
                else:
                    faults += f"    if ({number.split('[')[0]} != NULL) {{\n{all_kinds(number)}    }}\n"
            made[name] = made[name].replace(line, faults + line)
    no_error = library_claims(made, SMALL[0], tmp_path)[:3]
    words = [text for claim in no_error for text in claim.words]
    assert {text.split(": ", 1)[1] for text in words} == {"index_bound: 99 < 1: Invalid or unreachable"}
    assert len({text.split(": ")[0] for text in words}) == planted


@pytest.mark.long
@pytest.mark.timeout(900)
@pytest.mark.parametrize(("chosen", "room"), [((), 8), (("--vehicle", "ukwial", "--float"), 4)])
def test_the_command_proves_the_library_and_writes_the_c_that_it_speaks_of(
    chosen: tuple[str, ...], room: int, tmp_path: Path
) -> None:
    """With room for eight thrusters it takes a minute where nothing else runs."""
    done = CliRunner().invoke(command, ["--library", *chosen, "--out", str(tmp_path)], standalone_mode=False)
    assert done.return_value == 0, done.output
    proof = msgspec.json.decode((tmp_path / "proof.json").read_bytes(), type=Proof)
    assert {claim.verdict for claim in proof.claims} == {"shown", "tested"}
    summed = subprocess.run(
        f"cat {' '.join(proof.files)} | sha256sum",
        shell=True, cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert summed.stdout.startswith(proof.sha256)
    assert f"{room} thrusters" in (tmp_path / "proof.md").read_text()


def test_options_of_a_kernel_are_none_of_the_library_s() -> None:
    done = CliRunner().invoke(command, ["--library", "--method", "scaled"])
    assert done.exit_code == 2
    assert "--library" in done.output
