"""The mutants of docs/studies/mutants.py are changes of the tree as it is."""

import shutil
from itertools import chain
from pathlib import Path

import pytest

from mutants import MUTANTS, Mutant, mutated, stages
from tests.places import ROOT


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tree")
    for package in ("alloc", "bench", "tests"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.mark.long  # whoever changes such a line hears of it in CI, and need not know this study
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_each_mutant_changes_one_line_that_still_compiles_and_has_tests(mutant: Mutant, tree: Path) -> None:
    path, before = mutated(tree, mutant)
    after = path.read_text(encoding="utf-8")
    path.write_text(before, encoding="utf-8")
    assert after != before
    compile(after, str(path), "exec")
    assert stages(tree, path)
    assert all((tree / test).exists() for test in (*chain(*stages(tree, path)), *mutant.also))


def test_a_line_that_is_gone_or_stands_twice_is_an_error(tree: Path) -> None:
    for line, places in (("no such line anywhere", 0), ("import numpy as np\n", "[0-9]+")):
        with pytest.raises(LookupError, match=f"its line stands {places} times"):
            mutated(tree, Mutant("a mutant", line, ""))
