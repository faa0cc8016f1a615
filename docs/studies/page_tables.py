"""Puts tables that records give into the pages that show them, each between its two marks.

``python docs/studies/page_tables.py`` writes those of results/; ``… page_tables.py sizes esc`` writes what
README and docs/esc.md say of C, which it counts anew under QEMU in three minutes. A mark is
``<!-- NAME:start -->``, then ``<!-- NAME:end -->``, on lines of their own or within one; the function of that
name is the table, or the words.
``thrustbench report --readme`` writes README's times.
"""

import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from statistics import fmean

from click.testing import CliRunner

from bench.__main__ import cli
from bench.record import Record, read
from bench.report.sections import emulation
from bench.results.emulated import EmulatedRow, emulated_rows
from bench.results.text import table
from newtons import PAGE, summed

ROOT = Path(__file__).parents[2]
EMULATED = ROOT / "results/emulated"
EMBEDDED = "docs/embedded.md"

Kernel = tuple[str, str, str, str, str]
"""Vehicle, method, target, scalar and limits."""
VEHICLES = ("ukwial", "bluerov2-heavy", "supply-vessel")
M4F, M7 = ("cortex-m4f", "float"), ("cortex-m7", "double")
ASKED = ("inactive", "active", "infeasible")
"""Classes of demands whose counts are compared with goals."""


def goals() -> str:
    """Demands asked of each kernel, and their counts."""
    record = read(EMULATED)
    return emulation.goals(emulated_rows(record.emulated), record.processors)


def ratios() -> str:
    """Counts and ratios of counts on a Cortex-M7 in double precision, beside their goals."""
    kernels = _kernels(read(EMULATED))

    def most(vehicle: str, method: str, limits: str) -> int:
        return _most(row for row in kernels[vehicle, method, *M7, limits] if row.emulated.demands in ASKED)

    def steady(vehicle: str) -> float:
        answered = [
            row
            for row in kernels[vehicle, "nullspace@native", *M7, "fixed"]
            if row.emulated.demands in ("inactive", "active")
        ]
        return _most(answered) / fmean(row.mean or 0.0 for row in answered)

    exact = {
        v: {limits: most(v, "nullspace@native", limits) for limits in ("fixed", "call")} for v in VEHICLES
    }
    lines = [
        _goal("`nullspace`, fixed limits", (75, 140, 420), [float(exact[v]["fixed"]) for v in VEHICLES], "d"),
        _goal(
            "worst over mean of answered demands, d ≤ 2", (1.02, 1.02, None), [steady(v) for v in VEHICLES]
        ),
        _goal(
            "`nullspace`, limits of the call over fixed",
            (1.4,) * 3,
            [exact[v]["call"] / exact[v]["fixed"] for v in VEHICLES],
        ),
    ]
    for limits, words in (("fixed", "fixed"), ("call", "limits of the call")):
        for method in ("scaled", "priority"):
            found = [most(v, f"{method}@native", limits) / exact[v][limits] for v in VEHICLES]
            lines.append(_goal(f"`{method}` over `nullspace`, {words}", (3,) * 3, found))
    software = [
        _most(own) / _most(kernels[vehicle, method, *M4F, limits])
        for (vehicle, method, target, scalar, limits), own in kernels.items()
        if (target, scalar) == (M4F[0], "double") and (vehicle, method, *M4F, limits) in kernels
        if method.endswith("@native")
    ]
    return (
        f"{table(('what', 'goal', *VEHICLES, ''), lines, markdown=True)}\n"
        f"Double precision on a Cortex-M4F is software: {_span(software, '.0f')} times the instructions.\n"
    )


def cycles() -> str:
    """Distance between the ends of a cycle interval."""
    kernels = _kernels(read(EMULATED))
    apart = {
        board: [
            row.emulated.cycles[1] / row.emulated.cycles[0]
            for (_, method, *on, limits), own in kernels.items()
            if method in ("nullspace@native", "priority@native") and (*on, limits) == (*board, "fixed")
            for row in own
            if row.emulated.demands == "active" and row.emulated.cycles
        ]
        for board in (M4F, M7)
    }
    return (
        f"For `active` demands the upper end is {_span(apart[M4F], '.2f')} times the lower on the M4F,"
        f" {_span(apart[M7], '.1f')} times on the M7 (`nullspace`, `priority`).\n"
    )


def _span(values: Iterable[float], digits: str) -> str:
    """The least and the largest of some numbers, in words."""
    found = list(values)
    return f"{min(found):{digits}} to {max(found):{digits}}"


def _goal(what: str, most: tuple[float | None, ...], found: list[float], digits: str = ".2f") -> list[str]:
    """A line of ``ratios``: a goal a vehicle, none where it was not asked."""
    missed = [
        name
        for name, value, end in zip(VEHICLES, found, most, strict=True)
        if end is not None and not value <= end
    ]
    asked = dict.fromkeys(f"{end:g}" for end in most if end is not None)
    said = f"**not met**: {', '.join(missed)}" if missed else "met"
    whole = digits == "d"
    return [what, f"≤ {' / '.join(asked)}", *(f"{int(v)}" if whole else f"{v:{digits}}" for v in found), said]


def rivals() -> str:
    """The costliest call of the exact method, of no limits at all and of solvers' own C."""
    kernels = _kernels(read(EMULATED))
    solvers = [f"qp/{name}@generated" for name in ("daqp-reduced", "daqp", "qrqp", "qoco", "osqp")]
    exact, reduced, direct = "nullspace@native", *solvers[:2]
    columns = [(vehicle, *board) for board in (M4F, M7) for vehicle in VEHICLES]
    headers = ("method", *(f"{t.removeprefix('cortex-').upper()} {scalar}: {v}" for v, t, scalar in columns))
    lines = [
        [
            f"`{method}`",
            *(f"{_most(kernels[v, method, target, scalar, 'fixed']):,}" for v, target, scalar in columns),
        ]
        for method in ("pinv@native", exact, *solvers)
    ]

    def over(method: str) -> str:
        found = [
            _most(own) / _most(kernels[vehicle, exact, target, scalar, "fixed"])
            for (vehicle, name, target, scalar, limits), own in kernels.items()
            if name == method and limits == "fixed" and (target, scalar) in (M4F, M7)
        ]
        return _span(found, ".0f")

    beside = {k[0] for k in kernels if k[1] == reduced}
    own = {
        name: [k for k in kernels if k[1] == name and k[2:4] in (M4F, M7) and k[0] in beside]
        for name in (exact, *solvers)
    }
    flash = {name: [kernels[k][0].emulated.flash_bytes or 0 for k in keys] for name, keys in own.items()}
    ram = [(kernels[k][0].emulated.ram_static_bytes or 0) / 1024 for name in solvers for k in own[name]]
    moved = [
        _most(kernels[v, exact, target, scalar, "call"]) / _most(kernels[v, exact, target, scalar, "fixed"])
        for v, _, target, scalar, limits in own[exact]
        if limits == "fixed"
    ]
    largest = [max(flash[name]) / 1024 for name in solvers]
    return "\n".join(
        [
            f"{table(headers, lines, markdown=True)}\n"
            f"Over {', '.join(sorted(beside))}, in both precisions:\n",
            f"- The strongest rival takes {over(reduced)} times the instructions of the exact method, DAQP as"
            f" its users call it {over(direct)} times.",
            f"- The largest flash of a rival is {_span(largest, '.1f')} KiB, of the exact"
            f" method {max(flash[exact]) / 1024:.1f} KiB, tables for every failed thruster included. RAM is"
            f" {_span(ram, '.1f')} KiB against none.",
            f"- Limits of each call cost a solver's C hardly anything; the exact method takes"
            f" {_span(moved, '.1f')} times the instructions.\n",
        ]
    )


def exact() -> str:
    """The exact method's costliest call on a Cortex-M7 in double precision, by size of the vehicle."""
    kernels = _kernels(read(EMULATED))
    most = [_most(kernels[vehicle, "nullspace@native", *M7, "fixed"]) for vehicle in VEHICLES]
    return "{} (4 thrusters, 3 axes), {} (8, 6), {} (6, 3)".format(*most)


def strongest() -> str:
    """Least instructions of the strongest rival over the exact method's."""
    found = re.findall(r"strongest rival takes (\d+) to", rivals())
    return f"{found[0]} and more"


def stm32f446() -> str:
    """Output of the command that stands above the table."""
    page = (ROOT / EMBEDDED).read_text(encoding="utf-8")
    (typed,) = re.findall(r"`thrustbench (size results/stm32f446 .*)`", page)
    done = CliRunner().invoke(cli, typed.replace("results", str(ROOT / "results")).split())
    return "".join(f"{line}\n" for line in done.stdout.splitlines() if line.startswith("|"))


SIZED = (("nullspace", "fixed"), ("scaled", "fixed"), ("scaled", "call"))
"""Methods, and where their limits are, whose C ``sizes`` is about."""


def newtons() -> str:
    """Worth of each solver's words in newtons and scaled."""
    return summed(PAGE.read_text(encoding="utf-8"))


def sizes() -> str:
    """Flash, stack and instructions of C that has code for each failed thruster, or one table for all."""
    headers = ("`codegen`", "flash [B]", "stack of all [B]", "most instructions, no fault")
    return table(headers, [sized(*of) for of in SIZED], markdown=True)


def sized(method: str, limits: str) -> list[str]:
    """A line of ``sizes``."""
    asked = f"tiburon --limits {limits} --method {method}"
    counted = _emulated(*(f"{asked} --faults {faults}" for faults in ("one", "all")))
    one, every = (
        _kernels(counted, faults)["tiburon", f"{method}@native", *M4F, limits] for faults in ("one", "all")
    )
    flash = [f"{each[0].emulated.flash_bytes:,}" for each in (one, every)]
    stack = max(row.emulated.stack_bytes or 0 for row in every)
    most = [f"{_most(each):,}" for each in (one, every)]
    option = f"`--method {method}{' --limits call' * (limits == 'call')}`"
    return [option, " / ".join(flash), str(stack), " / ".join(most)]


def esc() -> str:
    """Cost of the C from thrusts to ESCs, with limits that are fixed and with those of the call."""
    counted = _kernels(_emulated("bluerov2-heavy --method esc"))
    flash, most = (
        [of(counted["bluerov2-heavy", "esc", *M4F, limits]) for limits in ("fixed", "call")]
        for of in (lambda rows: rows[0].emulated.flash_bytes or 0, _most)
    )
    return (
        f"With six voltages and eight thrusters on a Cortex-M4F it takes {flash[0]:,} B of flash and at most"
        f" {most[0]:,} instructions, with limits of the call {flash[1]:,} B and {most[1]:,}"
        " (`thrustbench emulate --method esc`).\n"
    )


def _emulated(*asked: str) -> Record:
    """Counts of ``thrustbench emulate`` on a Cortex-M4F in float for these."""
    with tempfile.TemporaryDirectory() as folder:
        for words in asked:
            typed = f"emulate --vehicle {words} --target {M4F[0]} --float --out {folder} --add"
            command = [sys.executable, "-m", "bench", *typed.split()]
            subprocess.run(command, check=True, stdout=subprocess.PIPE)
        return read(Path(folder))


def _kernels(record: Record, faults: str = "one") -> dict[Kernel, list[EmulatedRow]]:
    """Counts of each kernel, a row for each class of demands."""
    found: dict[Kernel, list[EmulatedRow]] = {}
    for row in emulated_rows(record.emulated):
        one = row.emulated
        if one.faults == faults and row.worst is not None:
            key = (one.vehicle, one.method, one.target, one.scalar, one.limits)
            found.setdefault(key, []).append(row)
    return found


def _most(counted: Iterable[EmulatedRow]) -> int:
    """Instructions of the costliest call."""
    return max(row.worst or 0 for row in counted)


TABLES: dict[str, tuple[str, Callable[[], str]]] = {
    "goals": ("docs/counting.md", goals),
    "ratios": ("docs/counting.md", ratios),
    "cycles": ("docs/counting.md", cycles),
    "rivals": ("docs/rivals.md", rivals),
    "exact": ("docs/paper.md", exact),
    "strongest": ("docs/paper.md", strongest),
    "stm32f446": (EMBEDDED, stm32f446),
    "newtons": ("docs/solvers.md", newtons),
    "sizes": ("README.md", sizes),
    "esc": ("docs/esc.md", esc),
}
"""Each table by the name of its marks: the page, and what makes it."""
COUNTED = ("sizes", "esc")
"""Tables that no record gives: they are counted anew."""


def shown(name: str) -> str:
    """Text between the marks of a table."""
    return _parts(name)[1].removeprefix("\n")


def write(name: str) -> None:
    """Replace what stands between the marks of a table."""
    before, inner, after = _parts(name)
    page, made = TABLES[name]
    own_lines = "\n" if inner.startswith("\n") else ""
    (ROOT / page).write_text(before + own_lines + made() + after, encoding="utf-8")


def _parts(name: str) -> tuple[str, str, str]:
    """A page before a table, the table, and the page after it, its marks not in the table."""
    page = TABLES[name][0]
    text = (ROOT / page).read_text(encoding="utf-8")
    start, end = f"<!-- {name}:start -->", f"<!-- {name}:end -->"
    before, opened, rest = text.partition(start)
    inner, closed, after = rest.partition(end)
    assert opened + closed == start + end, f"{page} lacks the marks of {name}"
    return before + opened, inner, closed + after


if __name__ == "__main__":
    for name in sys.argv[1:] or [name for name in TABLES if name not in COUNTED]:
        write(name)
