"""Report section: what these numbers do not say."""

from bench.report.verdict import cut_logs
from bench.results.rows import Run
from bench.results.text import plain

PYTHON = """\
- Times are of Python on this machine. Another processor moves them all, and not all alike: run it there, or
  transfer it with `thrustbench size --canary` and take the band seriously.
"""
DRIVER = """\
- Times are of C on this board, with this compiler, these flags, caches and wait states; another moves them.
"""
TEXT = """\
- A slowest call is the slowest of those made, on a machine that does other things too; it is no bound.
- Demand sets are drawn, not flown. Give your own log as a demand set before you decide.
- Static allocation: no thruster dynamics, no power model. Slew rates and voltage act in `slew`, in `sag`
  and in logs that bring limits; other sets have fixed limits.
"""
VIRTUAL = """- This was a virtual machine: p99.9 and slowest calls include what its host did.
"""
NOISY = """- More than one row in ten was measured while the machine was disturbed: look at column `quiet`.
"""


def section(run: Run, drawn: frozenset[str]) -> str:
    """The limits of every run, and those of this one."""
    measured = [row for row in run.rows if not row.failed]
    noisy = sum(bool(row.measured.disturbances) for row in measured) > len(measured) / 10
    virtual = run.record.header.machine.get("virtual")
    cut = "".join(f"- {sentence}\n" for sentence in cut_logs(run, plain))
    times = DRIVER if run.by_driver else PYTHON
    return "## Limits\n\n" + times + TEXT + cut + (VIRTUAL if virtual else "") + (NOISY if noisy else "")
