"""docs/theory.md maps every equation of the paper to a function; test_names.py says that it exists."""

import re

from tests.places import DOCS


def test_every_equation_of_the_paper_has_a_function() -> None:
    text = (DOCS / "theory.md").read_text(encoding="utf-8")
    cells = re.findall(r"^\| ([\d, ]+) \|.*`alloc\.", text, flags=re.MULTILINE)
    assert [int(n) for cell in cells for n in cell.split(",")] == list(range(1, 29))
    assert "| App. A |" in text
