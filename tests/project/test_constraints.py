"""constraints.txt: pins that every CPython which README promises can install, and what each asks for."""

import re
import tomllib
from importlib.metadata import distributions

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

from tests.places import ROOT

PIN = re.compile(r"(?P<name>\S+)==(?P<version>\S+) +# Python ?(?P<python>.*)")
LINES = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
PINS = {canonicalize_name(found["name"]): found for found in map(PIN.fullmatch, LINES) if found}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FIRST = "3.11.0"
"""The first CPython that README promises: 3.11 or newer."""


def refused(pins: dict[str, re.Match[str]], python: str) -> list[str]:
    """The pins whose own Requires-Python leaves that CPython out."""
    return [pin["name"] for pin in pins.values() if not SpecifierSet(pin["python"]).contains(python)]


def test_readme_and_pyproject_promise_the_same_first_python() -> None:
    major_minor = FIRST.rpartition(".")[0]
    assert PROJECT["requires-python"] == f">={major_minor}"
    assert f"CPython {major_minor} or newer" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_each_line_is_a_pin_and_the_python_that_it_wants() -> None:
    assert [line for line in LINES if not PIN.fullmatch(line)] == []
    assert len(PINS) == len(LINES)


def test_the_first_python_that_is_promised_can_install_every_pin() -> None:
    assert refused(PINS, FIRST) == []


def test_a_pin_that_wants_a_later_patch_of_python_is_found() -> None:
    line = "pymdown-extensions==13.1               # Python >=3.11.5"
    found = PIN.fullmatch(line)
    assert found
    assert refused({"it": found}, FIRST) == refused({"it": found}, "3.11.2") == ["pymdown-extensions"]
    assert refused({"it": found}, "3.11.5") == []


def test_what_is_noted_beside_a_pin_is_what_the_installed_package_says() -> None:
    """Packages that are here; .ci/interpreters asks the index about all of them."""
    asked = 0
    for distribution in distributions():
        pin = PINS.get(canonicalize_name(distribution.name))
        if pin and pin["version"] == distribution.version:
            said = SpecifierSet(distribution.metadata.get("Requires-Python") or "")
            assert said == SpecifierSet(pin["python"]), pin["name"]
            asked += 1
    assert asked > 20  # the runtime packages and what they need, at least


@pytest.mark.parametrize("extra", ["", *PROJECT["optional-dependencies"]])
def test_what_the_project_asks_for_is_pinned_at_a_version_that_it_takes(extra: str) -> None:
    asked = PROJECT["optional-dependencies"][extra] if extra else PROJECT["dependencies"]
    for requirement in map(Requirement, asked):
        if requirement.name != PROJECT["name"]:
            pin = PINS[canonicalize_name(requirement.name)]
            assert requirement.specifier.contains(pin["version"]), requirement


def test_all_is_all_extras() -> None:
    """No extra is installed nowhere: CI installs ``all``, and what ``all`` names."""
    extras = PROJECT["optional-dependencies"]
    reached, todo = set(), ["all"]
    while todo:
        reached.add(extra := todo.pop())
        for requirement in map(Requirement, extras[extra]):
            if requirement.name == PROJECT["name"]:
                todo += requirement.extras - reached
    assert reached == set(extras)
