"""Every module, class, function and file of this project that a document or a docstring names is there."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.places import DOCS, ROOT

DOCUMENTS = sorted([*ROOT.glob("*.md"), *DOCS.glob("*.md")])
SOURCES = sorted([*ROOT.glob("alloc/**/*.py"), *ROOT.glob("bench/**/*.py")])
NAME = re.compile(r"(?<![\w./-])(?:alloc|bench)(?:\.\w+)+")
FILE = re.compile(r"(?<![\w./-])(?:(?:alloc|bench|docs|tests)/[\w./-]*|test_\w+\.py)")
TO_BE_WRITTEN = re.compile(r"(?:Save as|Move the file to)\s+`([^`]+)`")
"""A file that a page tells its reader to make."""


def exists(name: str) -> bool:
    """True if a dotted name is a module, or an attribute of one."""
    module = name
    attributes: list[str] = []
    while True:
        try:
            thing = import_module(module)
            break
        except ModuleNotFoundError:
            module, _, last = module.rpartition(".")
            attributes.insert(0, last)
    for attribute in attributes:
        annotated = {*getattr(thing, "__annotations__", ())}  # a dataclass has no such attribute itself
        thing = getattr(thing, attribute, attribute if attribute in annotated else None)
    return thing is not None


def stale(document: Path) -> list[str]:
    """The names in a document that nothing has, in prose, tables and code alike."""
    text = document.read_text(encoding="utf-8")
    files = {name.rstrip(".") for name in FILE.findall(text)} - set(TO_BE_WRITTEN.findall(text))
    missing = [name for name in files if not (ROOT / name).exists()]
    return sorted([*missing, *(name for name in set(NAME.findall(text)) if not exists(name))])


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_name_in_a_document_exists(document: Path) -> None:
    assert stale(document) == []


@pytest.mark.parametrize("room", ["alloc", "bench"])
def test_every_name_in_a_docstring_exists(room: str) -> None:
    sources = [source for source in SOURCES if source.relative_to(ROOT).parts[0] == room]
    named = [(s.name, n) for s in sources for n in re.findall(rf"``({NAME.pattern})``", s.read_text())]
    assert [(source, name) for source, name in named if not exists(name)] == []


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("`alloc.Vehicle.TP`, `alloc.qp.pose_hard(vehicle)` and `bench.record`.", []),
        ("`alloc.worth`, `alloc.Vehicle.WP`", ["alloc.Vehicle.WP", "alloc.worth"]),
        ("`python docs/studies/gone.py`", ["docs/studies/gone.py"]),
        ("`alloc/qp/__init__.py`, bench/suite/*.py and `tests/alloc/`.", []),
        ("```sh\npytest tests/gone.py\n```", ["tests/gone.py"]),
        ("see alloc/qp.py.", ["alloc/qp.py"]),
        ("`test_names.py` has no folder", ["test_names.py"]),
        ("Save as `alloc/methods/mine.py`: … in `alloc/methods/mine.py`", []),
    ],
)
def test_a_name_that_nothing_has_is_stale(text: str, names: list[str], tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    assert stale(page) == names
