"""Docstrings, public names, commits and the change log keep the project's rules of style."""

import ast
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from tests.places import ROOT

BANNED = ("What", "Whether", "Which", "That", "Of", "Where", "Who", "Why", "When", "If", "So", "How")
"""Words that open a clause: the subject of such a line comes last, or stands in another line."""
FIRST_HELD = "dcb73804f1eb5743bdbd9f039fa66fe773a1e087"
"""The last commit before subjects were held to this form."""
SUBJECT = re.compile(r"[a-z0-9/_,+ -]+: [a-z0-9`].*[^.]")


def first_lines(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line number and first line of each docstring in a module, those behind constants and fields too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            if text := ast.get_docstring(node):
                yield getattr(node, "lineno", 1), text.splitlines()[0]
            for before, after in pairwise(node.body):
                match before, after:
                    case (
                        ast.Assign() | ast.AnnAssign(),
                        ast.Expr(ast.Constant(str(text))),
                    ):
                        yield after.lineno, text.splitlines()[0]


def opens_with_a_clause(line: str) -> bool:
    """True if a line opens with a banned word."""
    return re.split(r"\W", line, maxsplit=1)[0] in BANNED


@pytest.mark.parametrize(
    ("line", "is_banned"),
    [
        ("What a call costs.", True),
        ("Whether a demand can be met.", True),
        ("Cost of a call [us].", False),
        ("Whatever it is.", False),
    ],
)
def test_a_clause_is_told_from_a_noun_phrase(line: str, is_banned: bool) -> None:
    assert opens_with_a_clause(line) == is_banned


def sources(*folders: str) -> list[Path]:
    """Python files of the folders, sorted."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def is_title(path: Path, number: int) -> bool:
    """True for the docstring of a study itself, whose first words ``results/studies`` has as its title."""
    return path.parent == ROOT / "docs" / "studies" and number == 1


@pytest.mark.parametrize("folder", ["alloc", "bench", "docs", "tests"])
def test_docstrings_open_with_a_noun_phrase_or_an_imperative_on_one_line(folder: str) -> None:
    odd = [
        f"{path.relative_to(ROOT)}:{number}: {line}"
        for path in sources(folder)
        for number, line in first_lines(ast.parse(path.read_text(encoding="utf-8")))
        if len(line) > 110 or (opens_with_a_clause(line) and not is_title(path, number))
    ]
    assert odd == []


ENDINGS = {
    *("above", "aside", "behind", "below", "beside", "beyond", "from", "in", "of", "off", "on", "out"),
    *("within", "asked", "called", "checked", "chosen", "counted", "drawn", "found", "given", "held", "kept"),
    *("known", "left", "made", "met", "moved", "said", "seen", "sent", "shown", "taken", "told", "turned"),
    *("with", "written"),
}
"""Participles and prepositions: a name that ends with one says neither what it is nor what it does."""
CEILINGS = {
    "alloc.allocation": 2,
    "alloc.lint": 1,
    "alloc.reach": 1,
    "alloc.vehicle": 10,
    "bench.demands": 3,
    "bench.layouts": 4,
    "bench.record": 8,
    "bench.report": 1,
    "bench.suite": 1,
}
"""Names with such an ending that a room still has, at most; lower a number as names go. Others have none."""


def public_names(tree: ast.Module | ast.ClassDef) -> Iterator[str]:
    """Public functions, classes, methods and annotated attributes."""
    for node in tree.body:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name) if not name.startswith("_"):
                yield name
                if isinstance(node, ast.ClassDef):
                    yield from public_names(node)
            case ast.AnnAssign(target=ast.Name(id=name)) if isinstance(
                tree, ast.ClassDef
            ) and not name.startswith("_"):
                yield name


def has_odd_ending(name: str) -> bool:
    """True if a name's last word is a participle or a preposition of ``ENDINGS``."""
    return name.rsplit("_", 1)[-1].lower() in ENDINGS


def test_names_that_end_in_a_participle_or_a_preposition_become_no_more() -> None:
    counts: Counter[str] = Counter()
    for path in sources("alloc", "bench"):
        names = [path.stem, *public_names(ast.parse(path.read_text(encoding="utf-8")))]
        room = ".".join(path.relative_to(ROOT).with_suffix("").parts[:2])
        counts[room] += sum(map(has_odd_ending, names))
    grown = {room: (n, CEILINGS.get(room, 0)) for room, n in counts.items() if n > CEILINGS.get(room, 0)}
    assert grown == {}


def test_an_odd_ending_is_found_in_functions_methods_and_attributes_alone() -> None:
    tree = ast.parse("class A:\n  left: int\n  def held(self): ...\ndef _said(): ...\ndef off_axis(): ...")
    assert [name for name in public_names(tree) if has_odd_ending(name)] == ["left", "held"]


def test_the_change_log_has_at_most_500_words_and_opens_with_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert len(text.split()) <= 500
    version = re.search(r'^version = "(.*)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert version is not None
    assert re.findall(r"^## (\S+)", text, re.MULTILINE)[0] == version[1]


def subjects(folder: Path) -> list[str]:
    """Subjects of all commits after ``FIRST_HELD``; skips the test where the history is not there."""
    log = ["git", "-C", str(folder), "log", "--no-merges", "--format=%s", f"{FIRST_HELD}..HEAD"]
    done = subprocess.run(log, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("the history before subjects were held to a form is not in this clone")
    return done.stdout.splitlines()


def test_a_commit_s_subject_names_its_room_and_fits_72_characters() -> None:
    assert [s for s in subjects(ROOT) if len(s) > 72 or not SUBJECT.fullmatch(s)] == []


@pytest.mark.parametrize(
    ("subject", "fits"),
    [
        ("gate: compare shares only where they differ", True),
        ("inputs, formats: read a list of thrusters", True),
        ("Shares are compared", False),
        ("gate: compare shares.", False),
    ],
)
def test_a_subject_without_its_room_is_refused(subject: str, fits: bool) -> None:
    assert bool(SUBJECT.fullmatch(subject)) == fits
