"""Shares of the control period from counts of instructions: bands, because instructions are not cycles."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from alloc import catalogue
from alloc.formulations import find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from bench.record import Emulated
from bench.results.cycles import PUBLISHED, Cpi, share
from bench.results.emulated import REFERENCE, EmulatedRow
from bench.results.size import Fit, Loop, Size, ordered
from bench.results.sizing import refuses
from bench.results.text import three

USUAL_SCALAR = "double"
"""Precision that a label leaves out: Python's own."""


@dataclass(frozen=True, kw_only=True)
class Counted:
    """Counts of one kernel on one processor, all demand sets taken together.

    Attributes
    ----------
    vehicle, target, method, scalar : what names the kernel and the processor
    instructions : count of the most costly call that is known, over every demand set and what overflows,
        without a failed thruster
    off : the same of calls with one thruster off, as far as they were asked; None where none was
    at_most : what no call exceeds, by the binary's longest path; None where that is not known
    cycles : of the most costly call, at least and at most, by published timings; None where none are known
    flash_bytes : code and tables, for all failures [bytes]
    rows : what was counted, by demand set
    agrees : whether all of the kernel's answers were right
    missed : demand sets whose count failed; any may hold a more costly call, so then nothing is known to fit
    formulation, family, twin : of the method, as the catalogue describes it; a solver's generated C is posed
        as the optimum within limits
    solver : the solver whose own generator wrote the C, empty for this project's
    form : how it differs from what ``codegen`` writes by itself, as ", --faults none"; else empty
    """

    vehicle: str
    target: str
    method: str
    scalar: str
    instructions: int
    off: int | None = None
    at_most: int | None = None
    cycles: tuple[int, int] | None = None
    flash_bytes: int = 0
    rows: Mapping[str, Emulated] = field(default_factory=dict)
    agrees: bool
    missed: tuple[str, ...] = ()
    formulation: str = ""
    family: str = ""
    twin: str = ""
    solver: str = ""
    form: str = ""

    @property
    def label(self) -> str:
        """Method and form, and the precision where it is not Python's own."""
        named = self.method + self.form
        return named if self.scalar == USUAL_SCALAR else f"{named} {self.scalar}"

    def cpi(self, assumed: Cpi) -> Cpi:
        """Cycles an instruction of the most costly call: by published timings, else as assumed."""
        if self.cycles is None:
            return assumed
        low, high = (cycles / self.instructions for cycles in self.cycles)
        return Cpi(low, high, PUBLISHED)

    @property
    def optimal(self) -> bool:
        """True if the method answers the optimum within limits, eq. 4-5."""
        return find_formulation(self.formulation).optimal


@dataclass(frozen=True, kw_only=True)
class Band:
    """Share of the control period that one kernel takes on one processor, at a clock.

    Attributes
    ----------
    counted : the kernel and its count
    low, high : share of the period [-]
    fit : whether that fits the control loop
    """

    counted: Counted
    low: float
    high: float
    fit: Fit


def counted(rows: Iterable[EmulatedRow], board: str = "") -> list[Counted]:
    """Each kernel that was counted on each processor, by their names; cycles are those of a ``board``.

    A size is asked for the C as codegen writes it by itself. Other forms stand in where that was not counted.
    """
    known = {entry.name: entry for entry in catalogue()}
    forms: dict[tuple[str, str, str, str], dict[str, list[EmulatedRow]]] = {}
    for row in rows:
        key = (row.emulated.vehicle, row.emulated.target, row.emulated.method, row.emulated.scalar)
        forms.setdefault(key, {}).setdefault(_form(row.emulated), []).append(row)
    groups = [
        (*key, form, own[form])
        for key, own in sorted(forms.items())
        for form in ([""] if "" in own else sorted(own))
    ]
    made = []
    for vehicle, target, method, scalar, form, group in groups:
        counts = [row for row in group if row.worst is not None]
        if not counts:
            continue
        entry = known.get(method)
        formulation = HARD if entry is None else find_formulation(entry.formulation)
        made.append(
            Counted(
                vehicle=vehicle,
                target=target,
                method=method,
                scalar=scalar,
                instructions=max(row.known or 0 for row in counts),
                off=max((row.emulated.known_off for row in counts if row.emulated.known_off), default=None),
                at_most=max((row.emulated.at_most for row in counts if row.emulated.at_most), default=None),
                cycles=_cycles(counts, board),
                flash_bytes=max(row.emulated.flash_bytes or 0 for row in counts),
                rows={row.emulated.demands: row.emulated for row in counts},
                agrees=all(row.emulated.agrees for row in counts),
                missed=tuple(row.emulated.demands for row in group if row.worst is None),
                formulation=formulation.name,
                family=formulation.family if entry is None else entry.family,
                twin="" if entry is None else entry.twin,
                solver=group[0].emulated.solver,
                form=form,
            )
        )
    return made


def _form(one: Emulated) -> str:
    limits = "" if one.limits == "fixed" else f", --limits {one.limits}"
    return limits + ("" if one.faults == "one" else f", --faults {one.faults}")


def bands(
    rows: Iterable[EmulatedRow],
    clock_hz: float,
    loop: Loop,
    assumed: Mapping[str, Cpi],
    given: Cpi | None = None,
) -> list[Band]:
    """A band for each kernel and processor that has an assumption on cycles, the one to take first.

    ``assumed`` holds the assumptions by target, before which published timings go; ``given`` goes before
    both. As in ``sizing.sizes`` what may fit comes before what does not, right answers before others, the
    optimum within limits before what knows none, and then the cheaper one.
    """
    made = [
        _band(kernel, clock_hz, loop, given or kernel.cpi(assumed[kernel.target]))
        for kernel in counted(rows)
        if kernel.target != REFERENCE and (given or kernel.target in assumed)
    ]
    return sorted(made, key=_usefulness)


def _cycles(rows: Sequence[EmulatedRow], board: str) -> tuple[int, int] | None:
    spans = [row.emulated.boards.get(board) if board else row.emulated.cycles for row in rows]
    known = [span for span in spans if span]
    if len(known) < len(spans):
        return None
    return max(low for low, _ in known), max(high for _, high in known)


def as_sizes(bands: Sequence[Band], loop: Loop) -> list[Size]:
    """The bands of one processor as sizes, to stand beside those of machines that were timed.

    In place of a median there is the upper end of the band.
    """
    return ordered([_size(band, loop) for band in bands])


def _band(kernel: Counted, clock_hz: float, loop: Loop, cpi: Cpi) -> Band:
    low, high = share(kernel.instructions, clock_hz, loop.rate_hz, cpi)
    limit = loop.limit_share
    fit = Fit.FITS if high <= limit else Fit.MAY_FIT if low <= limit else Fit.DOES_NOT_FIT
    if kernel.missed and fit != Fit.DOES_NOT_FIT:
        fit = Fit.UNKNOWN
    return Band(counted=kernel, low=low, high=high, fit=fit)


def _size(band: Band, loop: Loop) -> Size:
    kernel = band.counted
    reason = f"{three(100 * band.low)} to {three(100 * band.high)} % by its instructions"
    if kernel.missed:
        reason = f"not counted: {', '.join(kernel.missed)}"
    return Size(
        vehicle=kernel.vehicle,
        method=kernel.method,
        label=kernel.label,
        twin=kernel.twin,
        family=kernel.family,
        solver=kernel.solver,
        formulation=kernel.formulation,
        fit=band.fit if kernel.agrees else Fit.UNKNOWN,
        reason=reason if kernel.agrees else "not all answers are right",
        exact=kernel.optimal and kernel.agrees,
        refusal=refusal_of(kernel.formulation),
        p50_us=band.high * loop.period_us,
        cpu_us=band.high * loop.period_us,
        rate_hz=loop.highest_rate_hz(band.high * loop.period_us),
    )


def refusal_of(formulation: str) -> str:
    """Demands that methods of a formulation refuse, by what it promises; empty for none."""
    return "what can't be met" if refuses(formulation) else ""


def _usefulness(band: Band) -> tuple[str, str, bool, bool, bool, Fit, int, str]:
    kernel, late = band.counted, band.fit > Fit.MAY_FIT
    what = (kernel.vehicle, kernel.target)
    return *what, late, not kernel.agrees, not kernel.optimal, band.fit, kernel.instructions, kernel.scalar
