"""Kernels as shared libraries: compiled once, kept by content, and what is said where that fails."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from alloc import build, load_vehicle
from alloc.c import Target, compiled, missing, sources
from alloc.errors import NotInstalled
from alloc.methods import recipe

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


def test_the_same_source_is_compiled_once_and_kept(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(tmp_path))
    source = {"answer.c": "int answer(void);\nint answer(void)\n{\n    return 1;\n}\n"}
    path = compiled.shared_library("answer", source)
    stamp = path.stat().st_mtime_ns
    assert compiled.shared_library("answer", source) == path
    assert path.stat().st_mtime_ns == stamp
    other = {"answer.c": source["answer.c"].replace("1;", "2;")}
    assert compiled.shared_library("answer", other) != path
    assert len(list(tmp_path.iterdir())) == 2


def test_processes_that_compile_the_same_kernel_at_once_all_answer(tmp_path) -> None:
    code = (
        "from alloc import build, load_vehicle\n"
        "print(build('nullspace@native', load_vehicle('ukwial'))([10, 0, 0]).f)"
    )
    environment = {**os.environ, "THRUSTBENCH_CACHE": str(tmp_path)}
    running = [
        subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE)
        for _ in range(3)
    ]
    answers = {process.communicate(timeout=60)[0] for process in running}
    assert len(answers) == 1
    assert b"[" in answers.pop()
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_without_a_compiler_the_catalogue_says_how_to_get_one(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(tmp_path))
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    assert "apt install gcc" in missing()
    with pytest.raises(NotInstalled, match="apt install gcc"):
        build("nullspace@native", load_vehicle("ukwial"))


def test_an_unusable_cc_variable_is_ignored(monkeypatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    without = compiled.compiler()
    monkeypatch.setenv("CC", 'gcc "')
    assert compiled.compiler() == without


def test_a_failing_compiler_and_an_unusable_cache_folder_are_named(monkeypatch, tmp_path) -> None:
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(tmp_path))
    with pytest.raises(NotInstalled, match="error"):
        compiled.shared_library("broken", {"broken.c": "int main(void) { return x; }"})
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(file))
    with pytest.raises(NotInstalled, match="THRUSTBENCH_CACHE"):
        compiled.shared_library("answer", {"answer.c": "int x;"})


def test_a_library_that_cannot_be_loaded_is_named_with_the_remedy(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("THRUSTBENCH_CACHE", str(tmp_path))
    vehicle = load_vehicle("ukwial")
    target = Target(vehicle=vehicle, method=recipe("nullspace"), faults="none")
    fixed, call = sources(target), sources(replace(target, limits="call"))
    library = compiled.shared_library("nullspace", fixed | call)
    library.write_bytes(b"")
    with pytest.raises(NotInstalled, match="THRUSTBENCH_CACHE"):
        build("nullspace@native", vehicle)


@pytest.mark.parametrize("method", ["pinv@native", "scaled@native"])
def test_an_answer_of_compiled_c_has_every_field_of_one_made_in_python(method: str) -> None:
    """Two fields were added, and C's tuples lacked them: they could be neither printed nor copied."""
    vehicle = load_vehicle("ukwial")
    found = build(method, vehicle)(np.zeros(vehicle.k))
    assert found._replace(iterations=3).iterations == 3
    assert found.forces == found.angles == found.amps == ()
