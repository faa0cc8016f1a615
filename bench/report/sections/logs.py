"""Report section: how the logs of demands were understood, and what may be wrong with them."""

from bench.results.rows import Run
from bench.results.text import plain


def section(run: Run, drawn: frozenset[str]) -> str:
    """A line for each remark; empty without logs."""
    lines = [f"- {plain(line)}\n" for line in run.record.said]
    return "\n".join(["How the logs were understood:\n", "".join(lines)]) if lines else ""
