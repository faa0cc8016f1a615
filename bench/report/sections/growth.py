"""Report section: how time and memory grow with the number of thrusters (the growth study)."""

from collections import defaultdict
from collections.abc import Callable

from bench.report.pictures import picture
from bench.results.growth import FITTED_FROM, Series, exponent, pays_up_to, series
from bench.results.rows import Run
from bench.results.text import plain, table, three


def section(run: Run, drawn: frozenset[str]) -> str:
    """Time and allocator size by number of thrusters, with fitted exponents; only for a growth study."""
    measured = series(run)
    if not measured:
        return ""
    parts = [
        "## How it grows with the number of thrusters\n",
        f"Generated vehicles, active demands. Exponent: p of time ~ nᵖ fitted from n = {FITTED_FROM} on, with"
        " its standard error. Allocators are as large as Python sees them: what a solver holds outside is not"
        " in it.\n",
        picture(
            "growth.svg", "median call and allocator size of each method over the number of thrusters", drawn
        ),
    ]
    for k in sorted({s.k for s in measured}):
        family = [s for s in measured if s.k == k]
        parts += [
            f"### {k} degrees of freedom\n",
            _where_it_pays(family) + "\n",
            _table("median [µs], n =", family, Series.times_us),
            _table("allocator [kB], n =", family, Series.kilobytes),
            _refused(family),
        ]
    return "\n".join(part for part in parts if part)


def _where_it_pays(family: list[Series]) -> str:
    best, without = pays_up_to(family)
    if best is None:
        return "No exact closed form beats the exact QP solvers here."
    text = f"An exact closed form is faster than every exact QP solver up to n = {best}"
    return f"{text}; from n = {min(without)} on none is offered." if without else f"{text}."


def _table(title: str, family: list[Series], of: Callable[[Series], dict[int, float]]) -> str:
    sizes = sorted({n for s in family for n in s.rows})
    lines = []
    for s in family:
        values = of(s)
        fit = exponent(values)
        power = "" if fit is None else f"{fit[0]:.2f} ± {fit[1]:.2f}"
        if values:
            lines.append([s.label, *(three(values.get(n)) for n in sizes), power])
    return table((title, *map(str, sizes), "exponent"), lines)


def _refused(family: list[Series]) -> str:
    reasons: dict[tuple[str, str], list[int]] = defaultdict(list)
    for s in family:
        for n, row in s.rows.items():
            if row.failed:
                reasons[s.label, row.status].append(n)
    rows = {s.label: s.rows for s in family}
    lines = []
    for (label, status), sizes in reasons.items():
        why = str(rows[label][sizes[0]].reason)
        at = ", ".join(map(str, sizes))
        lines.append(f"- {plain(f'{label}, n = {at}: {status}; at n = {sizes[0]}: {why}')}")
    return "\n".join(lines) + "\n" if lines else ""
