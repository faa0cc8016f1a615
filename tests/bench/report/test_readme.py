"""README.md: its code prints what it shows, its commands exist, its links lead somewhere."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench.__main__ import cli
from tests.pages import PAGES, blocks
from tests.places import ROOT
from tests.renderings import differences

README = ROOT / "README.md"


def test_the_code_in_the_readme_prints_what_is_shown_below_it() -> None:
    (code,) = blocks(README, "python")
    command = [sys.executable, "-"]  # on standard input, where a locale that lacks its letters does no harm
    done = subprocess.run(command, input=code, cwd=ROOT, capture_output=True, encoding="utf-8", check=True)
    assert not all(differences(done.stdout, shown) for shown in blocks(README, ""))


def test_every_command_in_the_readme_exists() -> None:
    each = [re.findall(r"^thrustbench (\w+)", block, flags=re.MULTILINE) for block in blocks(README, "")]
    shown = [command for commands in each for command in commands]
    assert len(next(filter(None, each))) == 6, "six commands that matter; --help has the others"
    assert set(shown) <= set(cli.list_commands(None))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_to_a_file_leads_to_one(page: Path) -> None:
    for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if "://" not in link:
            assert (page.parent / link).exists(), link
