"""Keeps what a study prints in results/studies: ``python docs/studies/keep.py STUDY [ARGUMENT …]``.

The file is named after the study and begins with what the study shows, and the command, the commit and the
processor that made it.
"""

import ast
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from bench.harness.machine import commit, cpu

STUDIES = Path(__file__).parent
RESULTS = STUDIES.parents[1] / "results" / "studies"


def title(study: Path) -> str:
    """Title of a study: the first words of its docstring, up to a colon or a full stop."""
    words = ast.get_docstring(ast.parse(study.read_text(encoding="utf-8"))) or study.stem
    return re.split(r"[:.]", words, maxsplit=1)[0]


def keep(study: str, arguments: Sequence[str], results: Path = RESULTS, studies: Path = STUDIES) -> Path:
    """Run a study and write what it prints; raises CalledProcessError, and keeps nothing, where it fails."""
    command = [str(studies / f"{study}.py"), *arguments]
    printed = subprocess.run([sys.executable, *command], check=True, stdout=subprocess.PIPE, text=True).stdout
    typed = shlex.join([f"docs/studies/{study}.py", *arguments])
    results.mkdir(parents=True, exist_ok=True)
    page = results / f"{study}.md"
    made = f"`python {typed}`, at commit {commit() or 'unknown'}, on {cpu()}."
    page.write_text(f"# {title(studies / f'{study}.py')}\n\n{made}\n\n{printed}", encoding="utf-8")
    return page


if __name__ == "__main__":
    print(keep(sys.argv[1], sys.argv[2:]))
