"""Extras that only one command needs; a command that lacks one ends with one line that names it."""

import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from alloc import catalogue
from bench.__main__ import main
from tests.places import ROOT

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]
STUDY = "base: ukwial\ngroups: {bow: {thrusters: [0, 1], azimuth_deg: {from: 10, to: 80}}}\n"
ALLOCATE = "allocate|demands.csv|--vehicle|ukwial|--method|"
CASES = {
    "fleet|--scheduler|tcp://127.0.0.1:1|--vehicle|ukwial": ("fleet", ("dask", "distributed")),
    "layouts|study.yaml|--out|out": ("layouts", ("pyarrow",)),
    "layouts|study.yaml|--out|other": ("layouts", ("distributed",)),
    "export|--problems|--out|out": ("problems", ("pyarrow",)),
    "demands|log.bag|--vehicle|ukwial": ("ros", ("rosbags",)),
    "allocate|log.bag|--vehicle|ukwial|--method|pinv": ("ros", ("rosbags",)),
    "run|--vehicle|ukwial|--method|pinv|--demands|log.bag|--out|out": ("ros", ("rosbags",)),
    "demands|log.ulg|--vehicle|ukwial": ("px4", ("pyulog",)),
    "demands|dive.bin|--vehicle|bluerov2-heavy|--from-outputs": ("ardupilot", ("pymavlink",)),
    "import|robot.urdf": ("urdf", ("urdf_parser_py",)),
    "import|model.sdf": ("urdf", ("defusedxml",)),
    f"{ALLOCATE}qp/scs": ("scs", ("scs",)),
    f"{ALLOCATE}qp/cvxopt": ("solvers", ("cvxopt",)),
    f"{ALLOCATE}qp/highs": ("solvers", ("highspy",)),
    f"{ALLOCATE}qp/qpalm": ("solvers", ("qpalm",)),
    f"{ALLOCATE}qp/quadprog": ("solvers", ("quadprog",)),
    f"{ALLOCATE}qp/ecos": ("solvers", ("ecos",)),
    f"{ALLOCATE}qp/elastiqp": ("more-solvers", ("elastiqp",)),
    f"{ALLOCATE}qp/qtqp": ("more-solvers", ("qtqp",)),
    f"{ALLOCATE}qp/sip": ("more-solvers", ("sip_qp_python",)),
    f"{ALLOCATE}qp/superadmm": ("more-solvers", ("superADMM",)),
    f"{ALLOCATE}qp/qrqp@generated": ("rivals", ("casadi",)),
    f"{ALLOCATE}qp/qoco@generated": ("rivals", ("qocogen",)),
}
"""A command line, the extra that it needs, and the modules of it that are not there."""
ELSEWHERE = {
    "all": "all others",
    "browser": "tests of report.html",
    "docs": "make docs",
    "prove": "one bound of several: the page says what it lacks",
    "qpbenchmark": "a study",
    "test": "make test",
}
"""Extras that no command stops without, and what they are for."""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The current folder, with a file of each kind."""
    (tmp_path / "demands.csv").write_text("surge,sway,yaw\n1,2,3\n")
    (tmp_path / "study.yaml").write_text(STUDY)
    (tmp_path / "robot.urdf").write_text("<robot name='r'><link name='base_link'/></robot>")
    (tmp_path / "model.sdf").write_text("<sdf><model name='m'/></sdf>")
    (tmp_path / "log.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(50))
    (tmp_path / "dive.bin").write_bytes(bytes(50))
    (tmp_path / "log.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(50))
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    catalogue.cache_clear()


def hide(monkeypatch: pytest.MonkeyPatch, modules: tuple[str, ...]) -> None:
    """Neither ``import`` nor ``find_spec`` finds them, or what is below them."""
    catalogue.cache_clear()  # it keeps what is missing
    for loaded in list(sys.modules):
        if loaded.partition(".")[0] in modules:
            monkeypatch.setitem(sys.modules, loaded, None)
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)
        assert find_spec(module) is None


@pytest.mark.parametrize("line", CASES)
def test_a_command_that_lacks_an_extra_ends_with_the_line_that_installs_it(
    line: str, place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    extra, modules = CASES[line]
    hide(monkeypatch, modules)
    monkeypatch.setattr(sys, "argv", ["thrustbench", *line.split("|")])
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().err
    assert ended.value.code == 2, said
    assert said.count("\n") == 1, said
    packages = [re.split(r"[^\w.-]", requirement)[0] for requirement in EXTRAS[extra]]
    remedies = [f"pip install 'thrustbench[{extra}]'", *(f"pip install {package}\n" for package in packages)]
    assert any(remedy in said for remedy in remedies), said
    assert not (place / "out").exists()


def test_each_extra_is_asked_of_a_command_or_has_another_use() -> None:
    assert {extra for extra, _ in CASES.values()} | set(ELSEWHERE) == set(EXTRAS)


def test_each_remedy_in_the_code_names_an_extra_that_there_is() -> None:
    named = re.compile(r"thrustbench\[([\w,]+)\]")
    sources = [*(ROOT / "alloc").rglob("*.py"), *(ROOT / "bench").rglob("*.py")]
    found = {name for path in sources for name in named.findall(path.read_text(encoding="utf-8"))}
    assert found
    assert {extra for names in found for extra in names.split(",")} <= set(EXTRAS)
