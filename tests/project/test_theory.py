"""docs/theory.md maps every equation of the paper to a function that exists."""

import re
from importlib import import_module

import pytest

from tests.places import DOCS

TEXT = (DOCS / "theory.md").read_text(encoding="utf-8")
NAMES = sorted(set(re.findall(r"`((?:alloc|bench)\.[\w.]+)`", TEXT)))


@pytest.mark.parametrize("name", NAMES)
def test_what_the_theory_names_exists(name: str) -> None:
    module, attributes = name, []
    while True:
        try:
            found = import_module(module)
            break
        except ModuleNotFoundError:
            module, _, last = module.rpartition(".")
            attributes.insert(0, last)
    for attribute in attributes:
        found = getattr(found, attribute)


def test_every_equation_of_the_paper_has_a_place() -> None:
    cells = re.findall(r"^\| ([\d, ]+) \|.*`alloc\.", TEXT, flags=re.MULTILINE)
    numbers = [int(n) for cell in cells for n in cell.split(",")]
    assert numbers == list(range(1, 29))
    assert "| App. A |" in TEXT
