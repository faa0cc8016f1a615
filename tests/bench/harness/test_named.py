"""A method chosen by name is run, or refused with a reason; a plug-in file names its method."""

from pathlib import Path

import msgspec
import pytest

from alloc.c import missing
from alloc.errors import UnknownName
from bench.harness.plan import RunSettings, SettingsError, default, quick
from tests.plugin_files import write_plugin
from tests.runs import contenders


def test_a_preset_leaves_no_family_and_no_solver_out_that_was_named() -> None:
    settings = msgspec.structs.replace(quick(), methods=("qp-soft/daqp", "qpsolvers/*", "qp/sip"))
    names = [contender.method.name for contender in contenders(settings)]
    assert "qp-soft/daqp" in names
    assert {"qpsolvers/daqp", "qp/sip"} <= set(names)
    assert not {c.method.name for c in contenders(quick())} & set(names)


def test_a_named_method_without_the_start_that_was_named_is_refused() -> None:
    named = msgspec.structs.replace(quick(), starts=("warm",), methods=("pinv", "qp/quadprog"))
    with pytest.raises(SettingsError, match="--start warm: qp/quadprog has cold, reused; name one of these"):
        contenders(named)


def test_a_pattern_takes_those_that_have_the_start() -> None:
    settings = msgspec.structs.replace(quick(), methods=("qp/*",), starts=("warm",))
    assert "qp/quadprog" in {contender.method.name for contender in contenders(settings)}


def test_a_plug_in_without_the_start_that_was_named_is_refused(tmp_path: Path) -> None:
    path = Path(write_plugin(tmp_path, "off"))
    path.write_text(
        path.read_text().replace("build(vehicle)", "build(vehicle, start)") + "\nSTARTS = ('cold',)\n"
    )
    settings = msgspec.structs.replace(quick(), plugins=(str(path),), starts=("warm",))
    with pytest.raises(SettingsError, match="--start warm: off has cold; name one of these"):
        contenders(settings)


def test_a_plug_in_is_marked_as_what_the_user_brought(tmp_path: Path) -> None:
    settings = msgspec.structs.replace(quick(), plugins=(write_plugin(tmp_path, "off"),), methods=("pinv",))
    assert {c.method.name: c.method.plugin for c in contenders(settings)} == {"off": True, "pinv": False}


@pytest.mark.parametrize("settings", [default(), quick()], ids=["default", "quick"])
def test_a_method_of_a_program_a_call_is_asked_by_name_only(settings: RunSettings) -> None:
    assert "frugal" not in {c.method.name for c in contenders(settings)}
    named = msgspec.structs.replace(settings, methods=("frugal",))
    assert [c.method.name for c in contenders(named)] == ["frugal"]


needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing() or "-")


@pytest.mark.parametrize(
    ("files", "methods"),
    [
        (["a/mine.py", "b/mine.py"], ()),
        (["pinv.py"], ("pinv",)),
        (["noop.py"], ()),  # a yardstick
        pytest.param(["pinv.py"], ("pinv@native",), marks=needs_compiler),  # it represents this one
        (["nullspace.py"], ("qp/daqp",)),
    ],
)
def test_two_methods_of_one_name_are_refused_not_dropped(
    tmp_path: Path, files: list[str], methods: tuple[str, ...]
) -> None:
    plugins = [tmp_path / name for name in files]
    for file in plugins:
        file.parent.mkdir(exist_ok=True)
        file.write_text("from alloc.methods.pinv import FORMULATION, build\n")
    settings = RunSettings(demands=(), methods=methods, plugins=tuple(map(str, plugins)))
    with pytest.raises(UnknownName, match="another method is called"):
        contenders(settings)
    twice = RunSettings(demands=(), plugins=(str(plugins[0]), str(plugins[0])))
    assert files == ["noop.py"] or len(contenders(twice)) == 1  # a file named twice is one plug-in
