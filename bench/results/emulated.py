"""Counts of instructions in a record, each beside the count of the same C on x86-64."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from bench.record import Emulated, Processor
from bench.results.table import Value

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
    def calls(self) -> int:
        """How many calls were counted."""
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
    def known(self) -> int | None:
        """Instructions of the most costly call that is known, numbers that overflow or are none included."""
        return max(filter(None, (self.worst, self.emulated.known)), default=None)

    @property
    def cycles_low(self) -> int | None:
        """Least cycles of the costliest call, None where no timing is published."""
        return self.emulated.cycles[0] if self.emulated.cycles else None

    @property
    def cycles_high(self) -> int | None:
        """Most cycles of the costliest call."""
        return self.emulated.cycles[1] if self.emulated.cycles else None

    @property
    def mean_over_x86(self) -> float | None:
        """Ratio of the means [-]."""
        return _ratio(self.mean, _mean(self.x86))

    @property
    def worst_over_x86(self) -> float | None:
        """Ratio of the most costly calls [-]."""
        return _ratio(self.worst, _worst(self.x86))


COLUMNS: dict[str, Callable[[EmulatedRow], Value]] = {
    "vehicle": lambda row: row.emulated.vehicle,
    "target": lambda row: row.emulated.target,
    "method": lambda row: row.method,
    "scalar": lambda row: row.emulated.scalar,
    "limits": lambda row: row.emulated.limits,
    "demands": lambda row: row.emulated.demands,
    "status": lambda row: row.emulated.status,
    "reason": lambda row: row.emulated.reason,
    "n_calls": lambda row: row.calls,
    "instructions_mean": lambda row: row.mean,
    "instructions_worst": lambda row: row.worst,
    "instructions_known": lambda row: row.emulated.known,
    "instructions_at_most": lambda row: row.emulated.at_most,
    "cycles_low": lambda row: row.cycles_low,
    "cycles_high": lambda row: row.cycles_high,
    "mean_over_x86": lambda row: row.mean_over_x86,
    "worst_over_x86": lambda row: row.worst_over_x86,
    "flash_bytes": lambda row: row.emulated.flash_bytes,
    "ram_static_bytes": lambda row: row.emulated.ram_static_bytes,
    "stack_bytes": lambda row: row.emulated.stack_bytes,
    "distance_rel_max": lambda row: row.emulated.distance_rel_max,
    "other_verdicts": lambda row: row.emulated.other_verdicts if row.calls else None,
    "agrees": lambda row: {True: "yes", False: "no", None: "-"}[row.emulated.agrees],
    "boards": lambda row: "; ".join(
        f"{name} {low} to {high}" for name, (low, high) in row.emulated.boards.items()
    ),
    "least": lambda row: row.emulated.least,
    "within_1pct_share": lambda row: row.emulated.within_1pct_share,
    "along_mean": lambda row: row.emulated.along_mean,
    "direction_error_max_deg": lambda row: row.emulated.direction_error_max_deg,
    "instructions_known_off": lambda row: row.emulated.known_off,
}
"""The columns of emulation.csv, in order; docs/counting.md says what they mean."""


def by_name(processors: Iterable[Processor]) -> list[Processor]:
    """Processors by name; where two have the same name, the later one counts."""
    latest = {one.name: one for one in processors}
    return [latest[name] for name in sorted(latest)]


def rows(emulated: Iterable[Emulated]) -> list[EmulatedRow]:
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


def shown_scalar(counted: Sequence[EmulatedRow]) -> str:
    """The scalar that a table with one number a kernel shows: double, where anything was counted so."""
    scalars = {row.emulated.scalar for row in counted if row.worst is not None}
    scalars = scalars or {row.emulated.scalar for row in counted}
    return "float" if scalars == {"float"} else "double"


def why_none(emulated: Sequence[Emulated]) -> str:
    """Reason why nothing was counted of these rows; empty where something was, or there are none."""
    reasons = [row.reason for row in emulated if row.target != REFERENCE]
    return reasons[0] if reasons and all(row.status == "refused" for row in emulated) else ""
