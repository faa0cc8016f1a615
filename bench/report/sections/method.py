"""Report section: how it was measured."""

from bench.results.rows import Run

PYTHON = """\
- Each method, start and level ran in a process of its own, pinned to one core, with one BLAS thread and
  without garbage collection, {repeats}, in seeded random order.
- Medians come from batches of about 2 ms, tails from single calls. Setting up is not solving and is timed
  apart. Nothing is subtracted; what the timing loop itself takes is the row `noop`.
"""
DRIVER = """\
- One program in C called one method after the other: each demand once with cold caches, then singly for
  the tail, and as often in passes for the median. Nothing is subtracted; the row `noop` is what timing takes.
"""
TEXT = """\
- Every answer that was timed was judged from the vehicle's equations. A row with a wrong answer is a failure,
  not a time, and is never called exact.
- A quantile is printed only where ten calls lie beyond it, with its 95 % interval from order statistics,
  as if calls were independent (*Tails* says how far that goes).
- `inactive` demands lie where the pseudoinverse keeps within the limits; `active` ones are attainable but
  need the limits; `infeasible` ones are not attainable.
- Pictures and the lines *exact* show a method by its fastest start and level that is right everywhere, exact
  ones before others; all of them are in `results.csv`, and so are vehicles after a failure (`-f2`: thruster
  2, counted from 0, is off), of which the report shows one line each. A picture without room for all methods
  says so: it has yours, those that none beats in time and loss, then of each family in turns.
"""


def section(run: Run, drawn: frozenset[str]) -> str:
    """The rules of measuring, with this run's number of repeats."""
    repeats = max((len(row.measured.cells) for row in run.rows), default=1)
    ran = PYTHON.format(repeats="once" if repeats == 1 else f"{repeats} times afresh")
    return "## How it was measured\n\n" + (DRIVER if run.by_driver else ran) + TEXT
