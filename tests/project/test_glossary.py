"""docs/glossary.md and the code have the same words, and no two things share one."""

import ast
import re
from collections import Counter
from importlib import import_module

import pytest

from tests.places import DOCS, ROOT

TERMS = re.findall(
    r"^\| ([^|]+) \| [^|]+ \| `([\w.]+)` \|$", (DOCS / "glossary.md").read_text(), re.MULTILINE
)


@pytest.mark.parametrize(("word", "place"), TERMS, ids=[word for word, _ in TERMS])
def test_a_word_lives_where_the_glossary_says(word: str, place: str) -> None:
    module, _, name = place.rpartition(".")
    assert hasattr(import_module(module), name) or import_module(place), word


def test_every_word_stands_in_the_glossary_once() -> None:
    assert [word for word, count in Counter(word for word, _ in TERMS).items() if count > 1] == []


def test_no_two_classes_share_a_name() -> None:
    files = [path for package in ("alloc", "bench") for path in (ROOT / package).rglob("*.py")]
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in files)
    names = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    assert [name for name, count in names.items() if count > 1] == []
