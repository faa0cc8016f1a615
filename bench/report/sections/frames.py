"""Report section: in which frame demands and wrenches are, vehicle by vehicle."""

from alloc.vehicle.frame import FRAMES, described
from bench.results.rows import Run
from bench.results.text import plain


def section(run: Run, drawn: frozenset[str]) -> str:
    """One sentence a frame: which vehicles have it, and what its axes are."""
    whole: dict[str, list[str]] = {frame: [] for frame in FRAMES}
    for problem in run.record.problems:
        if not problem.study and problem.whole not in whole[problem.frame]:
            whole[problem.frame].append(problem.whole)
    sentences = [
        f"Demands of {plain(', '.join(sorted(vehicles)))} are in {described(frame)}."
        for frame, vehicles in whole.items()
        if vehicles
    ]
    return " ".join(sentences) + "\n" if sentences else ""
