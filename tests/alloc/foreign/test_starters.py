"""The files to start from in each language: built as they say, they answer as ``clip`` does."""

import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import Status, build, load_vehicle
from alloc.c.compiled import missing
from alloc.discovery import load_plugin, prepare
from bench.commands.init import command
from bench.inputs.starter import LANGUAGES
from tests.compilers import needs

TOOLS = {"python": (), "c": ("cc",), "cpp": ("cmake", "g++"), "rust": ("cargo",), "exec": ()}


@pytest.mark.skipif(bool(missing()), reason=missing() or "-")
@pytest.mark.parametrize("language", LANGUAGES)
def test_what_init_writes_is_built_by_what_it_prints_and_is_clip(
    language: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs(*TOOLS[language])
    monkeypatch.chdir(tmp_path)
    words = ["my-rov", "--like", "bluerov2-heavy", "--language", language]
    made = CliRunner().invoke(command, words, standalone_mode=False, catch_exceptions=False)
    _, built, method = LANGUAGES[language]
    assert f"--method {method} " in made.output
    if built:
        assert f"{built} && \\\n" in made.output
        done = subprocess.run(built, shell=True, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        assert "warning" not in done.stderr
    vehicle = load_vehicle("my-rov.yaml").with_fault(0, 0.5)
    foreign, clip = prepare(load_plugin(method), vehicle), build("clip", vehicle)
    rng = np.random.default_rng(31)
    sizes = vehicle.wrench_scale * rng.uniform(0.02, 2.0, size=(60, 1))
    taus = rng.normal(size=(60, vehicle.k)) * sizes
    F, statuses = foreign.many(taus)
    expected, known = clip.many(taus)
    np.testing.assert_allclose(F, expected, atol=1e-9 * vehicle.f_scale)
    np.testing.assert_array_equal(statuses, known)
    assert {*statuses.tolist()} == {Status.SOLVED, Status.PARTIAL}


def test_each_language_has_its_choice() -> None:
    (choice,) = (option.type for option in command.params if option.name == "language")
    assert list(LANGUAGES) == list(choice.choices)  # type: ignore[attr-defined]


@pytest.mark.parametrize("language", [name for name in LANGUAGES if LANGUAGES[name].build])
def test_the_page_has_each_language_s_build(language: str) -> None:
    page = (Path(__file__).parents[3] / "docs/judge-your-allocator.md").read_text(encoding="utf-8")
    row = next(line for line in page.splitlines() if line.startswith(f"| `{language}` "))
    assert LANGUAGES[language].build in row
    assert all(shlex.quote(name) in row for name in LANGUAGES[language].files)
