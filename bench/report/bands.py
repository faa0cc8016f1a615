"""Output of ``thrustbench size --clock``: bands of shares of the period, and their assumptions."""

from collections.abc import Collection

from bench.results.bands import Band, bands
from bench.results.cycles import PUBLISHED, Cpi, assumed
from bench.results.emulated import rows, why_none
from bench.results.rows import Run
from bench.results.size import Loop
from bench.results.text import table, three


def page(
    run: Run, loop: Loop, clock_MHz: float | None, given: Cpi | None = None, vehicles: Collection[str] = ()
) -> str:
    """Bands for a record's emulated processors and the assumptions behind them, or what is missing for them.

    ``given`` replaces the cycles an instruction that the record assumes; ``vehicles`` are the only ones to
    show, all if empty.
    """
    if not run.record.emulated:
        return (
            "This record holds no instructions of emulated processors; `thrustbench emulate` counts them.\n"
        )
    if clock_MHz is None:
        return "This record holds instructions of emulated processors; give --clock MHZ to size with them.\n"
    known = assumed(run.record.processors)
    counted = [row for row in rows(run.record.emulated) if not vehicles or row.emulated.vehicle in vehicles]
    if reason := why_none([row.emulated for row in counted]):
        return f"Nothing was counted on emulated processors: {reason}.\n"
    shown = bands(counted, clock_MHz * 1e6, loop, known, given)
    bounded = any(band.counted.at_most is not None for band in shown)
    asked = any(band.counted.off is not None for band in shown)
    off = " Under one off stands the same of calls with any one thruster off." * asked
    bound = " No call takes more than stands under at most, the longest way through the binary." * bounded
    parts = [
        f"Emulated processors at {clock_MHz:g} MHz, {loop.rate_hz:g} Hz. Instructions are of the costliest"
        " call that is known without a failed thruster: asked, found by a search, or with numbers that"
        f" overflow or are none.{off}{bound} The share of the control period without a failed thruster is a"
        " band, for instructions are not cycles.\n",
        table(
            (
                "vehicle",
                "target",
                "method",
                "scalar",
                "verdict",
                "exact",
                "share [%]",
                "instructions",
                "one off",
                "at most",
                "cycles",
                "answers",
            ),
            [_line(band) for band in shown],
        ),
        f"Cycles are {PUBLISHED}. Where there are none, or others are given, cycles an instruction are:\n",
    ]
    named = dict.fromkeys(band.counted.target for band in shown)
    bases = [f"- {target}: {given or known[target]}." for target in named]
    return "\n".join([*parts, *bases, ""])


def _line(band: Band) -> list[str]:
    kernel = band.counted
    shares = f"{three(100 * band.low)} to {three(100 * band.high)}"
    answers = "right" if kernel.agrees else "not all right"
    answers += f"; not counted: {', '.join(kernel.missed)}" if kernel.missed else ""
    optimum = "yes" if kernel.optimal else "no"
    names = [kernel.vehicle, kernel.target, kernel.method + kernel.form, kernel.scalar]
    counts = ["" if each is None else str(each) for each in (kernel.instructions, kernel.off, kernel.at_most)]
    cycles = "" if kernel.cycles is None else f"{kernel.cycles[0]} to {kernel.cycles[1]}"
    return [*names, str(band.fit), optimum, shares, *counts, cycles, answers]
