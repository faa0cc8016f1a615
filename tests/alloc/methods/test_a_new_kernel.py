"""A method that offers ``program`` is C by that alone: CONTRIBUTING's row on a kernel, followed."""

import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import alloc.methods
from alloc import build, catalogue, generate, load_vehicle
from alloc.c.compiled import compiler, missing
from alloc.discovery import find
from alloc.errors import PluginError
from alloc.methods import clip, recipes
from bench.chips.board.project import plan, write
from bench.chips.kernels import as_c, methods
from bench.chips.study import Plan, emulate
from bench.gate.worker import Orders
from bench.proof import subject
from tests.emulators import available
from tests.kernel_file import METHOD

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


@contextmanager
def found(name: str, text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A method of that name and text, found in a folder of methods."""
    (folder / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(alloc.methods, "__path__", [*alloc.methods.__path__, str(folder)])
    caches = (recipes, catalogue)
    for each in caches:
        each.cache_clear()
    yield name
    for each in caches:
        each.cache_clear()
    sys.modules.pop(f"alloc.methods.{name}", None)


@pytest.fixture
def meek(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The method of ``tests.kernel_file``, found in a folder of methods."""
    with found("meek", METHOD, tmp_path, monkeypatch) as name:
        yield name


def test_a_method_with_a_program_is_in_the_catalogue_and_its_c_answers_as_python_does(meek: str) -> None:
    vehicle = load_vehicle("ukwial")
    assert find(f"{meek}@native").twin == meek
    python, native = build(meek, vehicle), build(f"{meek}@native", vehicle)
    rng = np.random.default_rng(4)
    taus = rng.normal(size=(300, vehicle.k)) * vehicle.wrench_scale
    ends = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, *taus.shape[:1], vehicle.n)), axis=0)
    for limits in ((), tuple(ends)):
        (F, status), (native_F, native_status) = (each.many(taus, *limits) for each in (python, native))
        np.testing.assert_array_equal(native_status, status)
        np.testing.assert_allclose(native_F, F, rtol=0, atol=1e-12 * vehicle.f_scale)


@pytest.mark.parametrize("limits", ["fixed", "call"])
@pytest.mark.parametrize("scalar", ["double", "float"])
def test_its_self_test_is_green(meek: str, scalar, limits, tmp_path: Path) -> None:
    assert self_test(generate(load_vehicle("ukwial"), meek, scalar=scalar, limits=limits), tmp_path) == 0


@pytest.mark.parametrize(("many", "code"), [("F", 0), ("0.9 * F", 1)])
def test_a_copy_of_clip_as_the_page_says_is_c_and_its_self_test_finds_a_rule_that_was_changed_in_python_alone(
    many: str, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The command of docs/add-a-method.md, section 4."""
    text = Path(clip.__file__).read_text(encoding="utf-8")
    for old, new in (('FORMULATION = "clip"', 'FORMULATION = "mine"'), ("return F\n", f"return {many}\n")):
        assert text.count(old) == 1
        text = text.replace(old, new)
    with found("mine", text, tmp_path, monkeypatch) as name:
        assert self_test(generate(load_vehicle("ukwial"), name), tmp_path) == code


@pytest.mark.parametrize("needed", ["build", "FORMULATION", "MEANINGS"])
def test_a_file_of_a_method_that_is_half_written_is_named_with_what_it_lacks(
    needed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = re.sub(rf"^(def )?{needed}\b", r"\1another", METHOD, flags=re.MULTILINE)
    with (
        found("half", text, tmp_path, monkeypatch),
        pytest.raises(PluginError, match=rf"half.py: has no {needed}"),
    ):
        catalogue()


def self_test(files: Mapping[str, str], tmp_path: Path) -> int:
    """Exit code of the self-test of generated files."""
    folder = tmp_path / "c"
    folder.mkdir()
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    units = [name for name in files if name.endswith(".c")]
    subprocess.run([*compiler(), "-std=c99", "-O1", "-I.", *units, "-o", "selftest"], cwd=folder, check=True)
    return subprocess.run(["./selftest"], cwd=folder, check=False).returncode


def test_a_proof_finds_it(meek: str) -> None:
    assert subject(load_vehicle("ukwial"), meek, "double", "call").limited


def test_it_is_counted_on_a_processor_and_agrees_there(meek: str) -> None:
    assert as_c([meek]) == (f"{meek}@native",)
    assert f"{meek}@native" in methods()
    asked = Plan(
        vehicles=(load_vehicle("ukwial"),),
        processors=(available("cortex-m4f"),),
        methods=as_c([meek]),
        scalars=("float",),
        demands=("infeasible",),
        seed=1,
        n=20,
    )
    rows = list(emulate(asked))
    assert [row.demands for row in rows] == ["infeasible", "search"]
    assert all(row.agrees and row.instructions and not row.reason for row in rows)


def test_a_project_for_a_board_asks_it(meek: str, tmp_path: Path) -> None:
    asked = plan(load_vehicle("ukwial"), as_c([meek]), ["infeasible"], "double", "call", 5, 1)
    assert [kernel.twin for kernel in asked.kernels] == [meek]
    assert not asked.omissions
    write(asked, tmp_path)
    assert list(tmp_path.rglob(f"ukwial_{meek}_call.c"))


def test_the_gate_has_cells_of_it(meek: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])  # the worker puts the tree in front
    worker = Orders()
    worker.load(str(Path(alloc.__file__).parents[1]), "", {}, {}, [])
    assert {name for _, name, _ in worker.cells()[0]} >= {meek, f"{meek}@native"}
    assert worker.build("cell", "ukwial", f"{meek}@native", "-")["formulation"] == meek
