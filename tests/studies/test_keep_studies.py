"""Output of a study, kept with the command and the commit that made it."""

import re
import subprocess
from pathlib import Path

import pytest

from keep import keep, title
from tests.places import DOCS, ROOT


def test_a_study_s_tables_are_kept_below_its_command_and_commit(tmp_path: Path) -> None:
    study = "'What a study finds: all of it.'\nimport sys\nprint('| n |', *sys.argv[1:])\n"
    (tmp_path / "tiny.py").write_text(study)
    text = keep("tiny", ["--n", "4"], results=tmp_path / "kept", studies=tmp_path).read_text()
    assert text.startswith("# What a study finds\n\n`python docs/studies/tiny.py --n 4`, at commit ")
    assert text.endswith("\n\n| n | --n 4\n")


def test_a_study_that_fails_keeps_nothing(tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("print('half a table')\nraise SystemExit(1)\n")
    with pytest.raises(subprocess.CalledProcessError):
        keep("broken", [], results=tmp_path / "kept", studies=tmp_path)
    assert not (tmp_path / "kept").exists()


@pytest.mark.parametrize("page", sorted((ROOT / "results/studies").glob("*.md")), ids=lambda page: page.stem)
def test_kept_tables_name_a_commit_and_the_study_that_is_here_or_was_there(page: Path) -> None:
    first, _, head, *tables = page.read_text(encoding="utf-8").splitlines()
    study = DOCS / "studies" / f"{page.stem}.py"
    if study.exists():
        assert first == f"# {title(study)}"
        assert f"python docs/studies/{page.stem}.py" in head
        assert " commit" in head
    else:
        assert re.match(rf"`python bench/studies/{page.stem}.py\b[^`]*` at commits? [0-9a-f]{{7}}\b", head)
    assert any(line.startswith("|") for line in tables)
