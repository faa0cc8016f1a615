"""docs/solvers.md agrees with each solver's file, and its reproductions are programs."""

import pytest

from alloc import solvers
from solver_defects import reproductions
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
    assert ROWS[name][1] == pins[solvers.load(name).PACKAGE]


def test_every_reproduction_compiles_and_is_short() -> None:
    programs = reproductions(TEXT)
    assert len(programs) > 10
    for title, code in programs.items():
        compile(code, title, "exec")
        assert len(code.splitlines()) < 30


@pytest.mark.parametrize("name", solvers.names())
def test_every_level_has_a_tolerance_for_each_formulation(name: str) -> None:
    solver = solvers.load(name)
    for formulation in ("hard", "soft"):
        promised = solver.TOLERANCE[formulation]
        assert set(promised) == set(solver.SETTINGS)
        if "tight" in promised:
            assert promised["tight"] <= promised["default"]
