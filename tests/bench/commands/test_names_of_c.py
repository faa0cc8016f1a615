"""C of a method has one name for every command that takes C: the method's, or that of its row in a run."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from alloc import AllocError
from alloc.errors import UnknownName
from bench.__main__ import cli
from bench.chips.kernels import as_c, methods, own


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
