"""Report section on weak axes: what is weak on a vehicle, and what is lost by which method."""

from alloc.vehicle.geometry import unit
from bench.report.verdict import weak_words
from bench.results.rows import Run
from bench.results.text import plain, table

WEAK = """## What is weak, and who loses by it

Along a *weak* direction thrusters make no more than twice what the survey's errors make of nothing.
`scaled`, `scaled-by-group` and `priority` leave it out; labels, losses and *served* are of the rest, for all
methods. Up to four times that it *counts by* a share: their answers lie by that share between leaving it
out and holding it; labels hold it. `nullspace` and the QPs hold a weak one too: they refuse, or thrusters
push against each other. `pinv`, `clip` and the other rules ask T* τ, mostly beyond limits. The table asks
half of what an axis can do, and nothing of the others: what is made of it, and the largest thrust.
"""


def weak(run: Run, drawn: frozenset[str]) -> str:
    """A table for each vehicle with weak directions; a line for those after a failure."""
    parts = []
    for vehicle in run.vehicles:
        capability = run.capability(vehicle)
        if not (words := weak_words(run, vehicle)):
            continue
        problem = run.problems[vehicle]
        bounds = " and ".join(f"{bound:.3g} N" for bound in problem.weak_bound_N)
        title = f"### {plain(vehicle)}, weak: {plain(words)}\n"
        parts.append(
            f"{title}\nThrusts within limits make at most {bounds} along it, moments over the rms arm.\n"
        )
        if capability and capability.weak_costs:
            methods = list(capability.weak_costs[0].wrench)
            lines = [
                [
                    cost.axis,
                    f"{cost.demand:.3g} {unit(cost.axis)}",
                    *(cost.words(m, unit(cost.axis)) for m in methods),
                ]
                for cost in capability.weak_costs
            ]
            parts.append(table(("axis", "asked", *methods), lines))
    failed = {name: words for name in run.degraded if (words := weak_words(run, name))}
    parts += [f"After a failure, {plain(name)}, weak: {plain(words)}.\n" for name, words in failed.items()]
    return "\n".join([WEAK, *parts]) if parts else ""
