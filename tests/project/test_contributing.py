"""CONTRIBUTING.md and CITATION.cff say what pyproject.toml says."""

import re
import tomllib

import pytest
from ruamel.yaml import YAML

from tests.places import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def layers(package: str) -> list[set[str]]:
    """The rooms of a package by the contracts, from bottom to top; rooms of one layer in one set."""
    for contract in PROJECT["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers":
            inside = "".join(f"{container}." for container in contract.get("containers", []))
            rooms = [{inside + room for room in re.split(r" \| ", layer)} for layer in contract["layers"]]
            ours = [layer for layer in rooms if all(room.startswith(f"{package}.") for room in layer)]
            if ours:
                return ours[::-1]
    raise AssertionError(f"no contract of layers for {package}")


@pytest.mark.parametrize("package", ["alloc", "bench"])
def test_contributing_lists_the_rooms_in_the_order_of_the_contracts(package: str) -> None:
    shown = [
        set(re.findall(r"`([\w.]+)`", cell)) for cell in re.findall(r"^\| (`\w+\..*?) \|", TEXT, re.MULTILINE)
    ]
    assert [room for room in shown if any(name.startswith(f"{package}.") for name in room)] == layers(package)


def test_the_citation_has_the_title_abstract_licence_keywords_and_author_of_the_project() -> None:
    citation = YAML(typ="safe").load(ROOT / "CITATION.cff")
    project = PROJECT["project"]
    expected = {"title": project["name"], "abstract": project["description"], "license": project["license"]}
    assert {key: citation[key] for key in expected} == expected
    assert citation["keywords"] == project["keywords"]
    assert citation["authors"][0]["name"].lower() in (ROOT / "LICENSE").read_text(encoding="utf-8")
