"""Runs the reproductions of ``docs/solvers.md``, a process each: ``python docs/studies/solver_defects.py``.

The study prints the output of each reproduction and how it ended. Some crash or hang, as they should.
"""

import re
import subprocess
import sys
from pathlib import Path

from bench.harness.child import cause

DOCUMENT = Path(__file__).parents[2] / "docs" / "solvers.md"
LIMIT_S = 20


def reproductions(text: str) -> dict[str, str]:
    """Code of each section that has code, by the section's heading."""
    sections = re.findall(r"^### (.+?)$.*?^```python\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return dict(sections)


def outcome(code: str) -> str:
    """What a fresh interpreter prints when it runs the code, and how it ends."""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired as late:
        return f"{(late.stdout or b'').decode()}still running after {LIMIT_S} s"
    return f"{done.stdout.decode().rstrip()}\n{cause(done.returncode, done.stderr)}".lstrip()


def main() -> None:
    """Print every reproduction's outcome."""
    for title, code in reproductions(DOCUMENT.read_text(encoding="utf-8")).items():
        print(f"{title}:\n{outcome(code)}\n", flush=True)


if __name__ == "__main__":
    main()
