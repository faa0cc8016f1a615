"""Counts of instructions in a record, beside those on x86-64, and their share of a control period.

The share is a band, because instructions are not cycles and no cycle was measured. Where a record has cycles
of a call by published timings, those are the band (``KernelCost.cpi``).
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from alloc import catalogue
from alloc.discovery import Entry
from alloc.formulations import find_formulation
from alloc.formulations.hard import FORMULATION as HARD
from bench.record import Emulated, ProcessorFacts
from bench.results.quantiles import group, largest
from bench.results.refusals import UNMET, refuses
from bench.results.size import Fit, Loop, Size, rank_sizes
from bench.results.text import three

REFERENCE = "x86-64"


@dataclass(frozen=True)
class EmulatedRow:
    """One line of emulation.csv: a kernel on one demand set and one processor.

    Attributes
    ----------
    emulated : what was counted
    x86 : the count of the same C over the same demands on x86-64, None where there is none
    """

    emulated: Emulated
    x86: Emulated | None

    @property
    def method(self) -> str:
        """The method, with which faults its C knows where that is not what ``codegen`` writes by itself."""
        one = self.emulated
        return one.method if one.faults == "one" else f"{one.method}, --faults {one.faults}"

    @property
    def kernel(self) -> tuple[str, str, str, str]:
        """Vehicle, processor, method and precision."""
        one = self.emulated
        return one.vehicle, one.target, one.method, one.scalar

    @property
    def calls(self) -> int:
        """Number of calls that were counted."""
        return self.emulated.tried or sum(calls for _, calls in self.emulated.instructions)

    @property
    def mean(self) -> float | None:
        """Mean instructions of a call (exact counts have no outliers); None for a search."""
        return None if self.emulated.tried else _mean(self.emulated)

    @property
    def worst(self) -> int | None:
        """Instructions of the most costly call."""
        return _worst(self.emulated)

    @property
    def costliest(self) -> int | None:
        """Instructions of the most costly call that is known, numbers that overflow or are none included."""
        return max(filter(None, (self.worst, self.emulated.known)), default=None)

    @property
    def worst_over_x86(self) -> float | None:
        """Ratio of the most costly calls [-]."""
        return _ratio(self.worst, _worst(self.x86))

    @property
    def cells(self) -> dict[str, str | int | float | None]:
        """The line of emulation.csv by column, in order; docs/counting.md says what they mean."""
        one = self.emulated
        low, high = one.cycles or (None, None)
        return {
            "vehicle": one.vehicle,
            "target": one.target,
            "method": self.method,
            "scalar": one.scalar,
            "limits": one.limits,
            "demands": one.demands,
            "status": one.status,
            "reason": one.reason,
            "n_calls": self.calls,
            "instructions_mean": self.mean,
            "instructions_worst": self.worst,
            "instructions_known": one.known,
            "instructions_at_most": one.at_most,
            "cycles_low": low,
            "cycles_high": high,
            "mean_over_x86": _ratio(self.mean, _mean(self.x86)),
            "worst_over_x86": self.worst_over_x86,
            "flash_bytes": one.flash_bytes,
            "ram_static_bytes": one.ram_static_bytes,
            "stack_bytes": one.stack_bytes,
            "distance_rel_max": one.distance_rel_max,
            "other_verdicts": one.other_verdicts if self.calls else None,
            "agrees": {True: "yes", False: "no", None: "-"}[one.agrees],
            "boards": "; ".join(f"{name} {least} to {most}" for name, (least, most) in one.boards.items()),
            "least": one.least,
            "within_1pct_share": one.within_1pct_share,
            "along_mean": one.along_mean,
            "direction_error_max_deg": one.direction_error_max_deg,
            "instructions_known_off": one.known_off,
        }


def latest_processors(processors: Iterable[ProcessorFacts]) -> list[ProcessorFacts]:
    """Processors by name; where two have the same name, the later one counts."""
    latest = {one.name: one for one in processors}
    return [latest[name] for name in sorted(latest)]


def emulated_rows(emulated: Iterable[Emulated]) -> list[EmulatedRow]:
    """Rows in the order of their names; where two have the same names, the later one counts."""
    latest = {(r.vehicle, r.method, r.scalar, r.limits, r.faults, r.demands, r.target): r for r in emulated}
    return [EmulatedRow(latest[key], latest.get((*key[:-1], REFERENCE))) for key in sorted(latest)]


def _mean(row: Emulated | None) -> float | None:
    if row is None or not row.instructions:
        return None
    calls = sum(calls for _, calls in row.instructions)
    return sum(count * calls for count, calls in row.instructions) / calls


def _worst(row: Emulated | None) -> int | None:
    return row.instructions[-1][0] if row is not None and row.instructions else None


def _ratio(value: float | None, reference: float | None) -> float | None:
    return value / reference if value is not None and reference else None


IN_WORDS = {"double": "double precision", "float": "single precision"}


def table_scalar(counted: Sequence[EmulatedRow]) -> str:
    """The scalar that a table with one number a kernel shows: double, where anything was counted so."""
    scalars = {row.emulated.scalar for row in counted if row.worst is not None}
    scalars = scalars or {row.emulated.scalar for row in counted}
    return "float" if scalars == {"float"} else "double"


def refusal_reason(emulated: Sequence[Emulated]) -> str:
    """Reason why nothing was counted of these rows; empty where something was, or there are none."""
    reasons = [row.reason for row in emulated if row.target != REFERENCE]
    return reasons[0] if reasons and all(row.status == "refused" for row in emulated) else ""


@dataclass(frozen=True)
class Cpi:
    """Cycles of an instruction, averaged over a call.

    Attributes
    ----------
    low, high : least and most cycles per instruction
    basis : why these are assumed
    """

    low: float
    high: float
    basis: str

    def __str__(self) -> str:
        """The band and its basis, as reports show them."""
        return f"{self.low:g} to {self.high:g}; {self.basis}"


PUBLISHED = "by published timings at zero wait states (docs/counting.md)"
"""Basis of a band whose cycles come out of the record."""


def assumed_cpi(processors: Iterable[ProcessorFacts]) -> Mapping[str, Cpi]:
    """Cycles an instruction that a record assumes, by processor; a processor without has no band."""
    return {one.name: Cpi(one.cpi[0], one.cpi[1], one.basis) for one in processors if len(one.cpi) == 2}


def period_share(instructions: float, clock_hz: float, rate_hz: float, cpi: Cpi) -> tuple[float, float]:
    """Least and most share of the control period 1 / ``rate_hz`` that a call takes at a clock [-]."""
    return instructions * cpi.low / clock_hz * rate_hz, instructions * cpi.high / clock_hz * rate_hz


USUAL_SCALAR = "double"
"""Precision that a label leaves out: Python's own."""


@dataclass(frozen=True, kw_only=True)
class KernelCost:
    """Counts of one kernel on one processor, all demand sets taken together.

    Attributes
    ----------
    vehicle, target, method, scalar : what names the kernel and the processor
    instructions : count of the most costly call that is known, over every demand set and what overflows,
        without a failed thruster
    one_failed : the same of calls with one thruster off, as far as they were asked; None where none was
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
    one_failed: int | None = None
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

    @cached_property
    def optimal(self) -> bool:
        """True if the method answers the optimum within limits, eq. 4-5."""
        return find_formulation(self.formulation).optimal

    @cached_property
    def size(self) -> Size:
        """The part of its size that no clock changes; with a reason it has no verdict."""
        picky = refuses(self.formulation)
        return Size(
            **{name: getattr(self, name) for name in METHOD},
            label=self.label,
            fit=Fit.UNKNOWN,
            reason="" if self.agrees else "not all answers are right",
            exact=self.optimal and self.agrees,
            refusal=UNMET if picky else "",
            unanswered=picky or not find_formulation(self.formulation).limited,
            picky=picky,
        )


METHOD = ("vehicle", "method", "twin", "family", "solver", "formulation")
"""Names that a kernel and its size share."""


@dataclass(frozen=True, kw_only=True)
class Band:
    """Share of the control period that one kernel takes on one processor, at a clock.

    Attributes
    ----------
    kernel : the kernel and its count
    low, high : share of the period [-]
    fit : whether that fits the control loop
    size : to stand beside methods that were timed; the upper end of the band is its median
    """

    kernel: KernelCost
    low: float
    high: float
    fit: Fit
    size: Size


def find_kernels(rows: Iterable[EmulatedRow], board: str = "") -> list[KernelCost]:
    """Each kernel that was counted on each processor, by their names; cycles are those of a ``board``.

    A size is asked for the C as codegen writes it by itself. Other forms stand in where that was not counted.
    """
    known = {entry.name: entry for entry in catalogue()}
    forms = group(rows, lambda row: (*row.kernel, _form(row.emulated)))
    usual = {names[:-1] for names in forms if not names[-1]}
    return [
        _kernel(own, names[-1], known.get(own[0].emulated.method), board)
        for names, own in sorted(forms.items())
        if (not names[-1] or names[:-1] not in usual) and any(row.worst is not None for row in own)
    ]


def _kernel(rows: Sequence[EmulatedRow], form: str, entry: Entry | None, board: str) -> KernelCost:
    counts = [row for row in rows if row.worst is not None]
    formulation = HARD if entry is None else find_formulation(entry.formulation)
    vehicle, target, method, scalar = rows[0].kernel
    return KernelCost(
        vehicle=vehicle,
        target=target,
        method=method,
        scalar=scalar,
        instructions=largest(row.costliest for row in counts) or 0,
        one_failed=largest(row.emulated.known_off or None for row in counts),
        at_most=largest(row.emulated.at_most or None for row in counts),
        cycles=_cycles(counts, board),
        flash_bytes=largest(row.emulated.flash_bytes for row in counts) or 0,
        rows={row.emulated.demands: row.emulated for row in counts},
        agrees=all(row.emulated.agrees for row in counts),
        missed=tuple(row.emulated.demands for row in rows if row.worst is None),
        formulation=formulation.name,
        family=formulation.family if entry is None else entry.family,
        twin="" if entry is None else entry.twin,
        solver=rows[0].emulated.solver,
        form=form,
    )


def _form(one: Emulated) -> str:
    limits = "" if one.limits == "fixed" else f", --limits {one.limits}"
    return limits + ("" if one.faults == "one" else f", --faults {one.faults}")


def bands(
    kernels: Iterable[KernelCost],
    clock_hz: float,
    loop: Loop,
    assumed: Mapping[str, Cpi],
    given: Cpi | None = None,
) -> list[Band]:
    """A band for each kernel and processor that has an assumption on cycles, by vehicle, then processor.

    ``assumed_cpi`` holds the assumptions by target, before which published timings go; ``given`` goes before
    both. The one to take first comes first, as ``rank_sizes`` says.
    """
    by_target: dict[str, dict[tuple[str, str], Band]] = {}
    for kernel in kernels:
        if kernel.target != REFERENCE and (given or kernel.target in assumed):
            band = find_band(kernel, clock_hz, loop, given or kernel.cpi(assumed[kernel.target]))
            by_target.setdefault(kernel.target, {})[kernel.vehicle, kernel.label] = band
    ranked = [
        own[size.vehicle, size.label]
        for own in by_target.values()
        for size in rank_sizes([band.size for band in own.values()], loop.period_us)
    ]
    return sorted(ranked, key=lambda band: (band.kernel.vehicle, band.kernel.target))


def _cycles(rows: Sequence[EmulatedRow], board: str) -> tuple[int, int] | None:
    spans = [row.emulated.boards.get(board) if board else row.emulated.cycles for row in rows]
    known = [span for span in spans if span]
    if len(known) < len(spans):
        return None
    return max(low for low, _ in known), max(high for _, high in known)


def find_band(kernel: KernelCost, clock_hz: float, loop: Loop, cpi: Cpi) -> Band:
    """The band of a kernel at a clock, for cycles an instruction."""
    low, high = period_share(kernel.instructions, clock_hz, loop.rate_hz, cpi)
    limit = loop.limit_share
    fit = Fit.FITS if high <= limit else Fit.MAY_FIT if low <= limit else Fit.DOES_NOT_FIT
    if kernel.missed and fit != Fit.DOES_NOT_FIT:
        fit = Fit.UNKNOWN
    size, call_us = kernel.size, high * loop.period_us
    reason = f"{three(100 * low)} to {three(100 * high)} % by its instructions"
    if kernel.missed:
        reason = f"not counted: {', '.join(kernel.missed)}"
    size = replace(
        size,
        fit=Fit.UNKNOWN if size.reason else fit,
        reason=size.reason or reason,
        p50_us=call_us,
        cpu_us=call_us,
        rate_hz=loop.highest_rate_hz(call_us),
    )
    return Band(kernel=kernel, low=low, high=high, fit=fit, size=size)
