"""``thrustbench codegen`` writes all that is needed to compile, test and call the C."""

import ctypes
import subprocess
from math import nan
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from alloc import AllocError, load_vehicle
from alloc.c import compiled, missing
from alloc.errors import UnknownName
from alloc.vehicle.file import find_file
from bench.__main__ import cli
from bench.chips.kernels import as_c, methods, own
from bench.commands.codegen import command

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


def codegen(*arguments: str) -> list[Path]:
    done = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return [Path(line) for line in done.stdout.splitlines()]


@pytest.mark.parametrize("single", [False, True], ids=["double", "float"])
def test_the_commands_and_the_example_on_the_page_compile_and_pass(tmp_path: Path, single: bool) -> None:
    files = codegen(
        "--vehicle", "ukwial", "--method", "nullspace", "--out", str(tmp_path), *["--float"] * single
    )
    assert {file.suffix for file in files} == {".h", ".c", ".md"}
    (written,) = (file for file in files if file.suffix == ".md")
    page = written.read_text()
    line = next(line for line in page.splitlines() if line.startswith("    cc "))
    done = subprocess.run(
        line.replace("cc", compiled.compiler()[0], 1),
        shell=True,
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 wrong" in done.stdout
    (tmp_path / "example.c").write_text(page.split("```c\n")[1].split("```")[0])
    command_line = [
        *compiled.compiler(),
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-pedantic",
        "-Werror",
    ]
    subprocess.run([*command_line, "-c", "example.c"], cwd=tmp_path, check=True)


def test_the_page_s_example_of_the_monitor_compiles_and_its_self_test_passes(tmp_path: Path) -> None:
    options = ["--float", "--monitor", "--noise", "4,4,1"]
    codegen("--vehicle", "ukwial", "--method", "pinv", *options, "--out", str(tmp_path))
    page = (tmp_path / "ukwial_pinv_float.md").read_text()
    line = next(line for line in page.splitlines() if line.startswith("    cc ") and "_monitor.c" in line)
    cc = compiled.compiler()
    done = subprocess.run(
        line.replace("cc", cc[0], 1), shell=True, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    example = page.split('```c\n#include "ukwial_pinv_float_monitor.h"')[1].split("```")[0]
    (tmp_path / "example.c").write_text('#include "ukwial_pinv_float_monitor.h"\n' + example)
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-pedantic", "-Werror"]
    subprocess.run([*cc, *strict, "-c", "example.c"], cwd=tmp_path, check=True)


def test_the_page_s_way_to_the_escs_compiles_and_passes(tmp_path: Path) -> None:
    codegen("--vehicle", "bluerov2", "--method", "clip", "--float", "--esc", "--out", str(tmp_path))
    page = (tmp_path / "bluerov2_clip_float.md").read_text()
    line = next(line for line in page.splitlines() if line.startswith("    cc ") and "_esc.c" in line)
    line = line.replace("cc", compiled.compiler()[0], 1)
    done = subprocess.run(line, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "96 cases; 0 wrong" in done.stdout
    (tmp_path / "example.c").write_text(page.split("## From a wrench")[1].split("```c\n")[1].split("```")[0])
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror"]
    subprocess.run([*compiled.compiler(), *strict, "-c", "example.c"], cwd=tmp_path, check=True)


def test_the_page_s_limits_at_a_voltage_are_those_of_the_vehicle(tmp_path: Path) -> None:
    codegen("--vehicle", "bluerov2-heavy", "--method", "clip", "--limits", "call", "--out", str(tmp_path))
    page = (tmp_path / "bluerov2_heavy_clip_call.md").read_text()
    code = page.split("## Limits at")[1].split("```c\n")[1].split("```")[0]
    (tmp_path / "limits.c").write_text(code)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror", "-shared", "-fPIC"]
    subprocess.run([*compiled.compiler(), *flags, "limits.c", "-o", "limits.so"], cwd=tmp_path, check=True)
    function = ctypes.CDLL(str(tmp_path / "limits.so")).limits_at
    vehicle = load_vehicle("bluerov2-heavy")
    for volts, known in ((11.3, 11.3), (16.0, 16.0), (10.0, 10.0), (3.0, 10.0), (99.0, 20.0), (nan, 10.0)):
        low, high = (ctypes.c_double * 8)(), (ctypes.c_double * 8)()
        function(ctypes.c_double(volts), low, high)
        np.testing.assert_allclose((low, high), vehicle.limits(volts=known), rtol=1e-15)


def test_the_page_warns_of_a_kernel_that_knows_no_limits(tmp_path: Path) -> None:
    for method in ("pinv", "nullspace"):
        codegen("--vehicle", "ukwial", "--method", method, "--out", str(tmp_path))
        page = (tmp_path / f"ukwial_{method}.md").read_text()
        assert ("may lie beyond these limits" in page) == (method == "pinv")


def test_a_failure_that_single_precision_cannot_answer_is_named_with_the_way_to_do_without(
    tmp_path: Path,
) -> None:
    """Without one of two tunnels pitch hangs on mains that lie 2 cm below the centre of mass."""
    file = tmp_path / "eel.yaml"
    file.write_text(
        "name: eel\nsource: sketch\ndof: [surge, heave, pitch]\nf_min: -40\nf_max: 40\n"
        "names: [port, stbd, bow, aft]\n"
        "T: [[1, 1, 0, 0], [0, 0, 1, 1], [-0.02, -0.008, -0.69, 0.65]]\n"
    )
    asked = ("--vehicle", str(file), "--method", "scaled", "--float", "--out", str(tmp_path))
    with pytest.raises(AllocError, match=r"eel without bow: T nearly loses rank.*--faults none"):
        codegen(*asked)
    assert codegen(*asked, "--faults", "none")


def test_a_second_method_in_the_same_folder_replaces_nothing_of_the_first(tmp_path: Path) -> None:
    first = codegen("--vehicle", "ukwial", "--method", "pinv", "--out", str(tmp_path))
    before = [file.read_bytes() for file in first]
    codegen("--vehicle", "ukwial", "--method", "nullspace", "--out", str(tmp_path))
    codegen("--vehicle", "ukwial", "--method", "pinv", "--float", "--out", str(tmp_path))
    assert [file.read_bytes() for file in first] == before


def test_vehicles_whose_names_c_cannot_tell_apart_do_not_replace_each_other_s_files(tmp_path: Path) -> None:
    text = find_file("ukwial").read_text()
    out = tmp_path / "c"
    for name in ("a b", "a-b"):
        (tmp_path / f"{name}.yaml").write_text(text.replace("name: ukwial", f"name: {name}"))
    asked = ["--method", "pinv", "--out", str(out), "--vehicle"]
    for _ in range(2):  # its own files it may replace
        codegen(*asked, str(tmp_path / "a b.yaml"))
    before = {path: path.read_bytes() for path in out.rglob("*.*")}
    with pytest.raises(AllocError, match="is of a b, and C can't tell a-b from it; give another --out"):
        codegen(*asked, str(tmp_path / "a-b.yaml"))
    assert {path: path.read_bytes() for path in out.rglob("*.*")} == before


def test_names_of_thrusters_stand_in_header_and_page(tmp_path: Path) -> None:
    files = codegen("--vehicle", "subjugator8", "--method", "pinv", "--out", str(tmp_path))
    texts = {file.suffix: file.read_text() for file in files if not file.stem.endswith("_test")}
    assert " *        f[7] BRV\n" in texts[".h"]
    assert "| `f[7]` BRV |" in texts[".md"]


@pytest.mark.parametrize(
    ("vehicle", "more", "told"),
    [("bluerov2-heavy", [], True), ("bluerov2-heavy", ["--limits", "call"], False), ("ukwial", [], False)],
)
def test_limits_by_voltage_are_pointed_at_where_the_c_has_fixed_ones(
    tmp_path: Path, vehicle: str, more: list[str], told: bool
) -> None:
    words = ["--vehicle", vehicle, "--method", "clip", "--out", str(tmp_path), *more]
    done = CliRunner().invoke(command, words, catch_exceptions=False)
    assert ("to have those of each voltage, --limits call" in done.stderr) == told


@pytest.mark.parametrize("command", ["board", "codegen"])
def test_a_command_that_takes_c_takes_both_of_its_names(command: str, tmp_path: Path) -> None:
    made = []
    for name in ("pinv", "pinv@native"):
        asked = [command, "--vehicle", "ukwial", "--method", name, "--out", str(tmp_path / name)]
        result = CliRunner().invoke(cli, asked, standalone_mode=False)
        assert result.exception is None, result.exception
        folder = tmp_path / name
        made.append({path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.[ch]")})
    assert made[0] == made[1] != {}


def test_every_method_that_has_c_is_found_by_either_name_and_once() -> None:
    assert as_c([*own().values(), *methods()]) == methods()
    assert as_c(["nothing"]) == ("nothing",)  # refused, by this name, where its C is built


@pytest.mark.parametrize("command", ["codegen", "prove"])
def test_a_row_of_the_library_is_told_the_option_that_makes_it(command: str, tmp_path: Path) -> None:
    asked = [command, "--vehicle", "ukwial", "--method", "scaled@library", "--out", str(tmp_path)]
    with pytest.raises(UnknownName, match="give --library in place of --method"):
        CliRunner().invoke(cli, asked, standalone_mode=False, catch_exceptions=False)


def test_forms_of_one_name_do_not_replace_each_other(tmp_path: Path) -> None:
    wanted = ["codegen", "--vehicle", "ukwial", "--method", "pinv", "--out", str(tmp_path)]
    assert CliRunner().invoke(cli, [*wanted, "--faults", "none"]).exit_code == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    again = CliRunner().invoke(cli, [*wanted, "--faults", "none"])
    assert again.exit_code == 0
    with pytest.raises(AllocError, match=r"ukwial_pinv\.h: was written with --faults none; delete it, or"):
        CliRunner().invoke(cli, wanted, standalone_mode=False, catch_exceptions=False)
    assert before == {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
