"""Rules on imports that import-linter's contracts can't express; and each of those contracts can fail."""

import ast
import os
import shutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import alloc
from tests import made_up
from tests.places import ROOT

ALL = sorted(p for folder in ("alloc", "bench", "docs/studies") for p in (ROOT / folder).rglob("*.py"))
FILES = [p for p in ALL if p.parent.name != "defects"]
"""All but the programs that show a solver's defect, which nothing imports."""
IN_ALLOC = [p for p in FILES if p.is_relative_to(ROOT / "alloc")]
METHODS, SOLVERS = ROOT / "alloc" / "methods", ROOT / "alloc" / "solvers"
BINDINGS = (
    {"clarabel", "cvxopt", "daqp", "ecos", "highspy", "osqp", "piqp", "proxsuite"}
    | {
        "qoco",
        "qpalm",
        "qpsolvers",
        "quadprog",
        "scs",
    }
    | {"elastiqp", "qtqp", "sip_qp_python", "superADMM"}
)


def imported(path: Path, function_bodies: bool = True) -> set[str]:
    """Dotted names a file imports; optionally only those that run when it is itself imported."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    deferred: set[ast.AST] = set()
    if not function_bodies:
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                deferred.update(ast.walk(node))
    names: set[str] = set()
    for node in ast.walk(tree):
        if node in deferred:
            continue
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import; write the full name"
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def home(name: str) -> str:
    """The full name of what ``alloc`` exports, with the module that makes it; any other name as it is."""
    package, _, last = name.rpartition(".")
    module = getattr(getattr(alloc, last, None), "__module__", "") if package == "alloc" else ""
    return f"{module}.{last}" if within(module, "alloc") else name


def imports_of(files: list[Path], *packages: str) -> dict[str, list[str]]:
    """Names of these packages that files import, by file."""
    found = {
        str(path.relative_to(ROOT)): [
            name for name in imported(path) if any(within(home(name), package) for package in packages)
        ]
        for path in files
    }
    return {path: names for path, names in found.items() if names}


def test_no_file_imports_a_solver_binding_before_it_is_called() -> None:
    at_once = {path: {name.split(".")[0] for name in imported(path, function_bodies=False)} for path in FILES}
    assert {path: names & BINDINGS for path, names in at_once.items() if names & BINDINGS} == {}


def test_solvers_know_problems_but_neither_vehicles_nor_methods_and_methods_know_no_catalogue() -> None:
    solvers = [path for path in FILES if path.is_relative_to(SOLVERS)]
    methods = [path for path in FILES if path.is_relative_to(METHODS)]
    assert len(solvers) > 5
    assert len(methods) > 5
    assert imports_of(solvers, "alloc.methods", "alloc.discovery", "alloc.vehicle") == {}
    assert imports_of(methods, "alloc.discovery") == {}


def test_the_harness_takes_public_names_and_each_from_one_place() -> None:
    odd = []
    for path in FILES:
        for name in imported(path) if path not in IN_ALLOC else ():
            module, _, last = name.rpartition(".")
            if within(module, "alloc"):
                hidden = any(part.startswith("_") for part in name.split("."))
                if hidden or (module != "alloc" and last in alloc.__all__):
                    exported = getattr(import_module(module), last) is getattr(alloc, last, None)
                    odd += [f"{path}: {name}: take it from alloc itself"] if hidden or exported else []
    assert odd == []


def test_a_report_renders_where_no_solver_is_installed(tmp_path: Path) -> None:
    made_up.whole(tmp_path)
    code = (
        f"import sys; sys.modules.update(dict.fromkeys({sorted(BINDINGS)!r}))\n"  # None: import fails
        "from pathlib import Path; from bench.report import render\n"
        f"render(Path({str(tmp_path)!r}))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, timeout=100)
    assert (tmp_path / "report.md").read_text(encoding="utf-8").startswith("# ")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from bench.__main__ import cli\n"
        "from click.testing import CliRunner\n"
        "assert CliRunner().invoke(cli, ['--help']).exit_code == 0\n"
        "heavy = {'numpy', 'scipy', 'pandas', 'matplotlib', 'rich', 'msgspec', 'ruamel.yaml', 'jinja2'}\n"
        "heavy &= set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, timeout=30)


def test_size_imports_neither_pandas_nor_jinja(tmp_path: Path) -> None:
    made_up.whole(tmp_path)
    code = (
        "import sys; from bench.__main__ import cli\n"
        "from click.testing import CliRunner\n"
        f"done = CliRunner().invoke(cli, ['size', {str(tmp_path)!r}, '--rate', '100'])\n"
        "assert done.exit_code == 0, done.output\n"
        "heavy = {'pandas', 'jinja2'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, timeout=60)


AGAINST = {
    "alloc/vehicle/model.py": "from alloc.reach import zonotope",
    "bench/record/schema.py": "from bench.results import rows",
    "bench/results/quantiles.py": "def f():\n    from bench.harness import timing",
    "alloc/methods/clip.py": "from alloc.methods import pinv",
    "alloc/solvers/daqp.py": "from alloc.solvers import osqp",
    "alloc/rivals/generators/daqp.py": "from alloc.rivals.generators import qoco",
    "alloc/formulations/hard.py": "from alloc.formulations import soft",
    "bench/report/sections/cost.py": "from bench.report.sections import losses",
    "bench/commands/check.py": "from bench.commands import report",
    "bench/demands/sets/box.py": "from bench.demands.sets import axes",
    "bench/inputs/formats/csv.py": "from bench.inputs.formats import tam",
    "bench/inputs/logs/ulog.py": "from bench.inputs.logs import rosbag",
    "alloc/nullspace/region.py": "import daqp",
    "alloc/vehicle/limits.py": "if TYPE_CHECKING:\n    from alloc.vehicle.model import Vehicle",
}
"""Per contract, in order, a file and an import that breaks it; one hides in a function, one is of types."""


def test_every_contract_on_imports_is_broken_by_an_import_against_it(tmp_path: Path) -> None:
    for package in ("alloc", "bench"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for file, line in AGAINST.items():
        with (tmp_path / file).open("a", encoding="utf-8") as source:
            source.write(f"\n\n{line}\n")
    linted = subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-cache"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path), "COLUMNS": "200"},  # else long names are wrapped
        capture_output=True,
        text=True,
        timeout=100,
    )
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    broken = [contract["name"] for contract in contracts if f"{contract['name']} BROKEN" in linted.stdout]
    assert broken == [contract["name"] for contract in contracts], linted.stdout
