"""docs/solvers.md agrees with each solver's file, and names each program that shows a defect."""

import re

import pytest

from alloc import solvers
from solver_defects import outcome, programs, told
from tests.places import DOCS, ROOT

TEXT = (DOCS / "solvers.md").read_text(encoding="utf-8")
ROWS = {
    columns[0]: columns
    for line in TEXT.partition("## The problem")[0].splitlines()
    if line.startswith("|") and (columns := [text.strip() for text in line.strip("|").split("|")])
}


@pytest.mark.parametrize("name", solvers.names())
def test_the_document_and_the_file_agree_on_each_solver(name: str) -> None:
    solver = solvers.load(name)
    _, _, algorithm, licence, starts, _ = ROWS[name]
    assert (algorithm, licence, starts) == (solver.ALGORITHM, solver.LICENCE, ", ".join(solver.STARTS))


@pytest.mark.parametrize("name", solvers.names())
def test_the_documented_version_is_the_version_pinned(name: str) -> None:
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = dict(line.split()[0].split("==") for line in lines)
    assert ROWS[name][1] == pins[solvers.load(name).PACKAGE] == solvers.load(name).VERSION


def test_the_table_of_defects_names_each_program_and_no_other() -> None:
    rows = TEXT.partition("## Defects")[2]
    assert set(re.findall(r"\| `(\w+)` \|", rows)) == set(programs())


@pytest.mark.parametrize("name", programs())
def test_every_program_compiles_is_short_and_says_what_it_prints(name: str) -> None:
    text = programs()[name].read_text(encoding="utf-8")
    compile(text, name, "exec")
    title, printed = told(programs()[name])
    assert title
    assert printed
    assert len(text.rpartition('"""')[2].splitlines()) < 35


def test_a_program_shows_its_defect() -> None:
    pytest.importorskip("piqp")
    assert outcome(programs()["piqp_view"]) == told(programs()["piqp_view"])[1]


@pytest.mark.parametrize("name", solvers.names())
def test_every_level_has_a_tolerance_for_each_formulation(name: str) -> None:
    solver = solvers.load(name)
    for formulation in ("hard", "soft"):
        promised = solver.TOLERANCE[formulation]
        assert set(promised) == set(solver.SETTINGS)
        if "tight" in promised:
            assert promised["tight"] <= promised["default"]
