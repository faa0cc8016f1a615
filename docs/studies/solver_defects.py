"""Runs the programs of ``docs/studies/defects``: ``python docs/studies/solver_defects.py [NAME]…``.

Each runs in a process of its own. The study prints its title, what it prints and how it ends; docs/solvers.md
says what follows from it. The study ends with 1 where one does otherwise than its docstring says.
"""

import ast
import subprocess
import sys
from pathlib import Path

from bench.harness.process import cause

FOLDER = Path(__file__).parent / "defects"
LIMIT_S = 20


def programs() -> dict[str, Path]:
    """The programs by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.py"))}


def told(program: Path) -> tuple[str, str]:
    """The title and the expected outcome that a program's docstring holds."""
    text = ast.get_docstring(ast.parse(program.read_text(encoding="utf-8"))) or ""
    title, _, rest = text.partition("\n")
    return title, "\n".join(line.removeprefix("    ") for line in rest.partition("::\n\n")[2].splitlines())


def outcome(program: Path) -> str:
    """Output of a fresh interpreter that runs the program, and how it ends."""
    try:
        done = subprocess.run([sys.executable, program], capture_output=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired as late:
        return f"{(late.stdout or b'').decode()}still running after {LIMIT_S} s"
    return f"{done.stdout.decode().rstrip()}\n{cause(done.returncode, done.stderr)}".strip()


def main(names: list[str]) -> int:
    """Print the outcome of the named programs, or of all; 1 where one has changed."""
    changed = 0
    for name, program in programs().items():
        if not names or name in names:
            title, expected = told(program)
            found = outcome(program)
            print(f"{name}: {title}\n{found}\n", flush=True)
            if found != expected:
                changed = 1
                print(f"{name} has changed; it was\n{expected}\n", flush=True)
    return changed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
