"""Docstrings open with a noun phrase or an imperative, and commits with their room and an imperative."""

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.places import ROOT

BANNED = ("What", "Whether", "Which", "That", "Of", "Where", "Who", "Why", "When", "If", "So")
"""Words that open a clause: the subject of such a line comes last, or stands in another line."""
FIRST_HELD = "dcb73804f1eb5743bdbd9f039fa66fe773a1e087"
"""The last commit before subjects were held to this form."""
SUBJECT = re.compile(r"[a-z0-9/_,+ -]+: [a-z0-9`].*[^.]")


def first_lines(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line number and first line of each docstring in a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (
            text := ast.get_docstring(node)
        ):
            yield getattr(node, "lineno", 1), text.splitlines()[0]


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


@pytest.mark.parametrize("package", ["alloc", "bench"])
def test_docstrings_open_with_a_noun_phrase_or_an_imperative(package: str) -> None:
    odd = [
        f"{path.relative_to(ROOT)}:{number}: {line}"
        for path in sorted((ROOT / package).rglob("*.py"))
        for number, line in first_lines(ast.parse(path.read_text(encoding="utf-8")))
        if opens_with_a_clause(line)
    ]
    assert odd == []


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
