"""The how-to documents do what they say: files are written, commands run, output compared."""

import ast
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import alloc.formulations
import alloc.plugin
import alloc.solvers
import bench
import bench.__main__
from alloc import Allocator, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import BoundedSteps, TwoStage
from alloc.discovery import load_plugin, prepare
from alloc.formulations import list_formulations
from bench.demands import build_demands
from bench.judging.judge import judge
from bench.judging.question import ask_here, questions
from tests.pages import FENCE, PAGES, blocks, saved
from tests.places import DOCS

EXPORTED = {"alloc", "bench"} | {
    f"{package.__name__}.{n}" for package in (alloc, alloc.plugin, bench) for n in package.__all__
}
NUMBER = re.compile(r"-?\d+(\.\d+)?(e-?\d+)?")


def assert_same(printed: str, shown: str) -> None:
    """Equal but for digits: the documents show three decimals."""
    assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown)
    for number, rounded in zip(NUMBER.finditer(printed), NUMBER.finditer(shown), strict=True):
        assert float(number[0]) == pytest.approx(float(rounded[0]), abs=6e-4)


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that commands are typed in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_consoles(document: str) -> None:
    """Run each command that a page shows with its output, and compare."""
    for console in blocks(DOCS / document, "console"):
        typed, _, shown = console.partition("\n")
        program, *arguments = shlex.split(typed.removeprefix("$ "))
        if program == "thrustbench":
            done = CliRunner().invoke(bench.__main__.cli, arguments, catch_exceptions=False)
            code, printed = done.exit_code, done.stderr + done.stdout
        else:
            assert program == "python"
            command = [sys.executable, *arguments]
            ran = subprocess.run(command, capture_output=True, text=True, check=False)
            code, printed = ran.returncode, ran.stderr + ran.stdout
        assert code == 0, printed
        assert_same(printed, shown)


def hidden(page: Path) -> list[str]:
    """Imports of a page's code that are neither exported nor of a module the page calls public."""
    prose = FENCE.sub("", page.read_text(encoding="utf-8"))
    public = set(re.findall(r"`((?:alloc|bench)[\w.]*)`[^.`]*\bis public\b", prose))
    imports: list[tuple[str, str]] = []
    for node in ast.walk(ast.parse("\n".join(blocks(page, "python")))):
        if isinstance(node, ast.Import):
            imports += [(alias.name, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            imports += [(str(node.module), f"{node.module}.{alias.name}") for alias in node.names]
    ours = [(module, name) for module, name in imports if module.partition(".")[0] in ("alloc", "bench")]
    return [name for module, name in ours if name not in EXPORTED and not public & {module, name}]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_a_page_s_code_imports_of_ours_is_public(page: Path) -> None:
    assert hidden(page) == []


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("from alloc import build, Vehicle", []),
        ("from alloc import Live", ["alloc.Live"]),
        ("from alloc.allocation import checked", ["alloc.allocation.checked"]),
        ("import alloc.discovery", ["alloc.discovery"]),
        ("from alloc.solvers import Answer\nfrom alloc import solvers\nimport alloc.solvers", []),
        ("from bench import Row, load\nimport numpy", []),
        ("def f():\n    from bench.demands import build_demands", ["bench.demands.build_demands"]),
    ],
)
def test_hidden_names_what_a_page_imports_that_is_not_public(
    code: str, names: list[str], tmp_path: Path
) -> None:
    page = tmp_path / "page.md"
    prose = "`alloc.solvers`, like alloc, is public. Not so `alloc.allocation`."
    page.write_text(f"{prose}\n\n```python\n{code}\n```\n")
    assert hidden(page) == names


@pytest.mark.parametrize(
    ("page", "files_of"),
    [
        ("your-vehicle.md", ["your-vehicle.md"]),
        ("your-dive.md", ["your-vehicle.md", "your-dive.md"]),
        ("add-a-method.md", ["add-a-method.md"]),
        ("saturation.md", ["saturation.md"]),
        ("autopilot.md", ["autopilot.md"]),
        ("add-a-formulation.md", []),
    ],
)
def test_a_page_shows_what_its_commands_print(page: str, files_of: list[str], desk: Path) -> None:
    for name in files_of:
        saved(DOCS / name, desk)
    run_consoles(page)


def test_saturation_s_code_does_what_it_says() -> None:
    (code,) = blocks(DOCS / "saturation.md", "python")
    exec(code, {})


@pytest.mark.parametrize("protocol", [Allocator, TwoStage, BoundedSteps], ids=lambda p: p.__name__)
def test_add_a_method_names_all_that_an_allocator_has_or_may_have(protocol: type) -> None:
    prose = FENCE.sub("", (DOCS / "add-a-method.md").read_text(encoding="utf-8"))
    members = [name for name in vars(protocol) if not name.startswith("_")]
    assert members
    assert [name for name in members if not re.search(rf"`(allocate\.)?{name}\b", prose)] == []


def test_the_example_method_keeps_its_promise(tmp_path: Path, rng: np.random.Generator) -> None:
    saved(DOCS / "add-a-method.md", tmp_path)
    entry = load_plugin(tmp_path / "damped.py")
    for name in list_vehicles():
        vehicle = load_vehicle(name)
        damped, exact = prepare(entry, vehicle), build("pinv", vehicle)
        tau = vehicle.TP @ rng.uniform(0.3 * vehicle.f_min, 0.3 * vehicle.f_max)
        off = np.abs(damped(tau).f - exact(tau).f).max()
        assert off <= damped.tolerance * vehicle.f_scale


def test_the_example_solver_is_found_and_solves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "slsqp.py").write_text(blocks(DOCS / "add-a-solver.md", "python")[0])
    monkeypatch.setattr(alloc.solvers, "__path__", [*alloc.solvers.__path__, str(tmp_path)])
    catalogue.cache_clear()
    try:
        names = {entry.name for entry in catalogue()}
        assert {"qp/slsqp", "qp-soft/slsqp"} <= names
        assert "qpsolvers/slsqp" not in names  # qpsolvers has no such adapter
        f, status, *_ = build("qp/slsqp", load_vehicle("ukwial"))([300, -50, 10])
    finally:
        sys.modules.pop("alloc.solvers.slsqp", None)
        monkeypatch.undo()
        catalogue.cache_clear()
    assert status == alloc.Status.SOLVED
    shown = blocks(DOCS / "add-a-solver.md", "console")[0].splitlines()[2].split(",")
    np.testing.assert_allclose(f, [float(cell) for cell in shown[1:]], atol=6e-4)


def anchors(page: Path) -> set[str]:
    """Targets of links: a page's headings, spelt as GitHub does."""
    headings = re.findall(r"^#+ (.+)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_link_to_a_heading_finds_that_heading(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#\s]*)#([^)]+)\)", page.read_text(encoding="utf-8"))
    assert [
        anchor for target, anchor in links if anchor not in anchors(page.parent / target if target else page)
    ] == []


def test_the_example_formulation_is_found_and_its_method_is_held_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    formulation, method = blocks(DOCS / "add-a-formulation.md", "python")
    for folder, text in (("formulations", formulation), ("methods", method)):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "derated.py").write_text(text)
    monkeypatch.setattr(
        alloc.formulations, "__path__", [*alloc.formulations.__path__, str(tmp_path / "formulations")]
    )
    list_formulations.cache_clear()
    try:
        assert "derated" in {formulation.name for formulation in list_formulations()}
        vehicle = load_vehicle("ukwial")
        (question,) = questions([build_demands("active", vehicle, seed=1, n=5)], ask_here)
        allocate = prepare(load_plugin(tmp_path / "methods" / "derated.py"), vehicle)
        answers = [allocate(tau) for tau in question.demands.taus]
        promises = {"formulation": "derated", "limited": True, "tolerance": allocate.tolerance}
        assert judge(question, answers, **promises).agrees is True
        twice = [answer._replace(f=answer.f * 1.001) for answer in answers]
        assert judge(question, twice, **promises).agrees is False
    finally:
        sys.modules.pop("alloc.formulations.derated", None)
        monkeypatch.undo()
        list_formulations.cache_clear()
