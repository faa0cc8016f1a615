"""Runs each reproduction in ``docs/solvers.md``, apart: ``python -m bench.studies.solver_defects``.

Prints what each said and how it ended; some crash or hang, which is what they are there to show.
"""

import re
import subprocess
import sys
from pathlib import Path

from bench.harness.child import cause

DOCUMENT = Path(__file__).parents[2] / "docs" / "solvers.md"
LIMIT_S = 20


def reproductions(text: str) -> dict[str, str]:
    """Code of each section that has some, by the section's heading."""
    found = re.findall(r"^### (.+?)$.*?^```python\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return dict(found)


def outcome(code: str) -> str:
    """What a fresh interpreter prints, and how it ends."""
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
