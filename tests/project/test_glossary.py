"""Each word stands in docs/glossary.md once, and no two classes share a name; test_names.py checks places."""

import ast
import re
from collections import Counter

from tests.places import DOCS, ROOT


def test_every_word_stands_in_the_glossary_once() -> None:
    text = (DOCS / "glossary.md").read_text(encoding="utf-8")
    words = re.findall(r"^\| (?!word )([^|]+) \|", text, re.MULTILINE)
    assert "demand" in words
    assert [word for word, count in Counter(words).items() if count > 1] == []


def test_no_two_classes_share_a_name() -> None:
    files = [path for package in ("alloc", "bench") for path in (ROOT / package).rglob("*.py")]
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in files)
    names = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    assert [name for name, count in names.items() if count > 1] == []
