"""The columns of results.csv, in order: each ``cached_property`` of ``Row``; a plain property is none.

A property's name is the column's, with the unit at the end; its docstring is the column's documentation
(``docs/results.md``). A column that does not apply to a row is empty in the file and None here. Times are
medians or maxima, never means. To add a column, add a cached property.
"""

import inspect
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from statistics import median

from alloc.formulations import find_formulation
from bench.record import FARTHER, Cell, Method
from bench.record.schema import machine_name
from bench.results.quantiles import (
    Repeats,
    Worst,
    by_level,
    calls,
    end_ns,
    largest,
    median_or_none,
    merge,
    microseconds,
    quantile,
    tail_ns,
    total,
    worst_axis,
)
from bench.results.text import table


@dataclass(frozen=True)
class Row:
    """One line of results.csv: a method with its start and level on one vehicle's demand set.

    Attributes
    ----------
    measured : the repeats that the columns are worked out from
    """

    measured: Repeats

    @property
    def described(self) -> Method:
        """The method's line of the record."""
        return self.measured.described

    @property
    def label(self) -> str:
        """Method, start and level as tables show them, e.g. ``qp/osqp warm tight``, without ``default``."""
        choices = (self.start, self.level)
        return " ".join([self.method, *(choice for choice in choices if choice not in ("-", "default"))])

    @property
    def family(self) -> str:
        """Family of the method: reports show its methods together."""
        return self.described.family or find_formulation(self.formulation).family

    @property
    def unlimited(self) -> bool:
        """True if thrusts may lie beyond the limits; a user's method says so of itself."""
        known = find_formulation(self.formulation)
        measured = [cell for cell in self.measured.cells if cell.status == "ok"]
        rule = self.described.plugin and not known.references  # of the user's own: no file says what it keeps
        return not known.limited or (rule and bool(measured) and not any(c.limited for c in measured))

    @property
    def title(self) -> str:
        """Meaning of its answers, in a few words."""
        known = find_formulation(self.formulation)
        return "a rule that promises no limits" if self.unlimited and known.limited else known.title

    @property
    def failed(self) -> Cell | None:
        """The first repeat that was not measured, None where all were."""
        return next((cell for cell in self.measured.cells if cell.status != "ok"), None)

    @property
    def undisturbed(self) -> bool:
        """``quiet`` as True or False."""
        return not self.measured.disturbances

    @property
    def partial_by_weak(self) -> float:
        """Share of answers (0 to 1) that are PARTIAL, and leave out a weak part of the demand only."""
        answers = sum(j.answers for j in self.measured.judged)
        return sum(j.partial_by_weak for j in self.measured.judged) / answers if answers else 0.0

    @property
    def agreed(self) -> bool | None:
        """``agrees`` as True or False; None where no right answer is known."""
        verdicts = {judged.agrees for judged in self.measured.judged if judged.agrees is not None}
        return None if not verdicts else verdicts == {True}

    @cached_property
    def vehicle(self) -> str:
        """Name of the vehicle that answers; ``-f2`` says that thruster 2 (from 0) is off."""
        return self.measured.key.vehicle

    @cached_property
    def demands(self) -> str:
        """Name of the demand set."""
        return self.measured.key.demands

    @cached_property
    def method(self) -> str:
        """Name of the method."""
        return self.measured.key.method

    @cached_property
    def start(self) -> str:
        """``cold`` (new solver object a call), ``reused`` (the same) or ``warm`` (from the last answer)."""
        return self.measured.key.start

    @cached_property
    def status(self) -> str:
        """``ok``, or why there is no time: ``failed``, ``crashed``, ``timeout``, ``missing``, ``refused``."""
        return self.failed.status if self.failed else "ok"

    @cached_property
    def reason(self) -> str:
        """The reason for a status other than ``ok``, in words."""
        return self.failed.reason if self.failed else ""

    @cached_property
    def n_demands(self) -> int:
        """Number of different demands in the set."""
        return max((cell.n_demands for cell in self.measured.cells), default=0)

    @cached_property
    def n_calls(self) -> int:
        """Number of timed calls over all repeats; a call timed both in a batch and singly counts once."""
        return sum(map(calls, self.measured.cells))

    @cached_property
    def setup_us(self) -> float | None:
        """Median time to prepare the method for the vehicle."""
        times = [ns for cell in self.measured.cells for ns in cell.setup_ns]
        return microseconds(median(times) if times else None)

    @cached_property
    def call_p50_us(self) -> float | None:
        """Time of one call: median over batches, then over repeats."""
        return microseconds(median_or_none(self.measured.centre(lambda cell: cell.batches)))

    @cached_property
    def call_p99_us(self) -> float | None:
        """Time that 99 % of single calls did not exceed; empty below 1,000 calls, or below the median."""
        return microseconds(tail_ns(self.measured, 0.99))

    @cached_property
    def call_p999_us(self) -> float | None:
        """Time that 99.9 % of single calls did not exceed; empty below 10,000 calls, or below the median."""
        return microseconds(tail_ns(self.measured, 0.999))

    @cached_property
    def call_max_us(self) -> float | None:
        """The slowest single call seen: method, interpreter and machine together."""
        return microseconds(self.measured.singles[-1][0] if self.measured.singles else None)

    @cached_property
    def solver_p50_us(self) -> float | None:
        """Median of the time that the solver itself reports; empty where it reports none."""
        return microseconds(quantile(merge(cell.solver_singles for cell in self.measured.cells), 0.5))

    @cached_property
    def iterations_max(self) -> int | None:
        """Most iterations that any demand took, by the solver's own count."""
        return largest(cell.iterations_max for cell in self.measured.cells)

    @cached_property
    def solved_fraction(self) -> float | None:
        """Share of answers with status SOLVED (0 to 1), infeasible demands counted too."""
        answers = sum(j.answers for j in self.measured.judged)
        return sum(j.counts.get("SOLVED", 0) for j in self.measured.judged) / answers if answers else None

    wrench_error_max = Worst(
        "Largest |T P f - tau| of any axis and demand, in N or N m as the axis has it.",
        lambda j: largest(j.wrench_error_max),
    )
    limit_violation_max_N = Worst(
        "Largest excess of any thrust over its limit.", lambda j: j.limit_violation_max_N
    )
    distance_max_N = Worst(
        "Largest |f - f*| to the optimum of the same formulation; empty where no optimum is known.",
        lambda j: j.distance_max_N,
    )

    @cached_property
    def agrees(self) -> str:
        """``yes`` where answers are as near the optimum as promised, else ``no``; ``-`` without a promise."""
        return {None: "-", True: "yes", False: "no"}[self.agreed]

    @cached_property
    def peak_rss_MB(self) -> float | None:
        """Peak resident memory of the worker process (1 MB = 1e6 bytes), largest over repeats."""
        peak = largest(worker.peak_rss_bytes for worker in self.measured.workers)
        return None if peak is None else peak / 1e6

    @cached_property
    def quiet(self) -> str:
        """``no`` where the machine was busy with something else while this row was timed."""
        return "yes" if self.undisturbed else "no"

    @cached_property
    def disturbed_by(self) -> str:
        """Disturbances of the machine where ``quiet`` is no; docs/method.md says what counts."""
        return "; ".join(self.measured.disturbances)

    @cached_property
    def machine(self) -> str:
        """Name of the machine: the folder's that `thrustbench run` chooses there."""
        return machine_name(self.measured.origin.machine)

    @cached_property
    def commit(self) -> str:
        """Commit of this project that was measured; ``+changes`` where its files differed from it."""
        return self.measured.origin.commit

    @cached_property
    def level(self) -> str:
        """Accuracy: ``default`` settings of the solver, or ``tight`` (1e-6 of the largest limit)."""
        return self.measured.key.level

    @cached_property
    def formulation(self) -> str:
        """Optimum that the method answers; answers are compared only within one."""
        return next((cell.formulation for cell in self.measured.cells if cell.formulation), "")

    @cached_property
    def repeats(self) -> int:
        """Number of repeats; each that was measured had a fresh process."""
        return len(self.measured.cells)

    @cached_property
    def call_p50_low_us(self) -> float | None:
        """Lowest ``call_p50_us`` of a single repeat."""
        return microseconds(min(self.measured.centre(lambda cell: cell.batches), default=None))

    @cached_property
    def call_p50_high_us(self) -> float | None:
        """Highest ``call_p50_us`` of a single repeat."""
        return microseconds(max(self.measured.centre(lambda cell: cell.batches), default=None))

    @cached_property
    def call_p99_low_us(self) -> float | None:
        """Lower end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
        return microseconds(end_ns(self.measured, 0.99, 0))

    @cached_property
    def call_p99_high_us(self) -> float | None:
        """Upper end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
        return microseconds(end_ns(self.measured, 0.99, 1))

    @cached_property
    def call_p999_low_us(self) -> float | None:
        """Lower end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
        return microseconds(end_ns(self.measured, 0.999, 0))

    @cached_property
    def call_p999_high_us(self) -> float | None:
        """Upper end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
        return microseconds(end_ns(self.measured, 0.999, 1))

    @cached_property
    def n_single_calls(self) -> int:
        """Number of ``n_calls`` that were timed singly; quantiles are of these."""
        return total(self.measured.singles)

    @cached_property
    def call_cpu_p50_us(self) -> float | None:
        """Like ``call_p50_us``, on the clock of the thread's own CPU time."""
        return microseconds(median_or_none(self.measured.centre(lambda cell: cell.batches, "cpu_ns")))

    @cached_property
    def binding_p50_us(self) -> float | None:
        """Time of the solver's own Python binding inside the call: median over batches, then repeats."""
        return microseconds(median_or_none(self.measured.centre(lambda cell: cell.binding_batches)))

    @cached_property
    def worst_case_steps(self) -> int | None:
        """Proven bound on elementary steps of one call; empty where a method has none."""
        return largest(cell.worst_case_steps for cell in self.measured.cells)

    @cached_property
    def allocator_bytes(self) -> int | None:
        """Bytes that the prepared allocator holds."""
        return largest(cell.allocator_bytes for cell in self.measured.cells)

    wrench_error_relative = Worst(
        "Largest wrench error over the size of a wrench on its axis (row of T times the largest limit).",
        lambda j: j.wrench_error_rel_max,
    )
    distance_relative = Worst(
        "``distance_max_N`` over the largest thrust limit.", lambda j: j.distance_rel_max
    )
    gap_relative = Worst(
        "Largest relative duality gap: a certificate that needs no reference.", lambda j: j.gap_rel_max
    )
    failed_after_failure_share = Worst(
        "Share (0 to 1) without thrusts, of attainable demands right after an answer without thrusts.",
        lambda j: j.failed_after_failure,
    )

    @cached_property
    def disbelieved(self) -> str:
        """Statuses that were not believed, with calls: false INFEASIBLE, unknown exit flags."""
        counts = sum((Counter(cell.disbelieved) for cell in self.measured.cells), Counter())
        n_calls = sum(map(calls, self.measured.cells))
        return "; ".join(f"{what} ({count:,} of {n_calls:,} calls)" for what, count in counts.items())

    tolerance = Worst("Distance over the largest thrust limit that ``agrees`` allows.", lambda j: j.tolerance)

    @cached_property
    def wrong(self) -> str:
        """Reason why an answer is wrong, of a plug-in one on another set, too; empty where none is."""
        own = next((j.wrong for j in self.measured.judged if j.wrong), "") or self.measured.wrong_elsewhere
        on_others = self.measured.wrong_on_others
        return own or (FARTHER if on_others and self.agreed is False else on_others)

    lost_wrench_p50 = Worst(
        "Median of |delivered - tau| / |tau|, delivered being what thrusts clipped to their limits push."
    )
    lost_wrench_p99 = Worst("99 % of demands lose no more of their wrench than this share.")
    lost_wrench_max = Worst("Largest share of any demand's wrench that is not delivered.")
    lost_force_max_N = Worst(
        "Largest |delivered - tau| on any force axis.", lambda j: worst_axis(j, moments=False)
    )
    lost_moment_max_Nm = Worst(
        "Largest |delivered - tau| on any moment axis.", lambda j: worst_axis(j, moments=True)
    )
    answered_share = Worst("Share of demands (0 to 1) that got a finite f; losses are of these.", worst=min)
    within_1pct_share = Worst("Share of demands (0 to 1) whose wrench is delivered within 1 %.", worst=min)
    within_5pct_share = Worst("Share of demands (0 to 1) whose wrench is delivered within 5 %.", worst=min)
    direction_error_p50_deg = Worst("Median angle between delivered and demanded wrench.")
    direction_error_max_deg = Worst("Largest angle between delivered and demanded wrench.")
    effort_over_optimum_p50 = Worst(
        "Median of f'Hf / f*'Hf* - 1 where f meets the demand, f* the optimum of eq. 4-5."
    )
    effort_over_optimum_max = Worst("Largest f'Hf / f*'Hf* - 1.")
    limits_violated_share = Worst("Share of answers (0 to 1) with a thrust beyond a limit, before clipping.")
    thrusters_saturated_mean = Worst("Mean number of thrusters at or beyond a limit.")

    @cached_property
    def share_p50(self) -> str:
        """Median share (0 to 1) delivered of each level of a demand; empty where answers say none."""
        return by_level([j.share_p50 for j in self.measured.judged], median)

    @cached_property
    def share_min(self) -> str:
        """Least share (0 to 1) delivered of each level of any demand, first level first."""
        return by_level([j.share_min for j in self.measured.judged], min)

    @cached_property
    def weak(self) -> str:
        """Axes that are weak, with the share left, or count in part; labels are without weak ones."""
        return "; ".join(self.measured.problem.weak) if self.measured.problem else ""

    @cached_property
    def weak_bound_N(self) -> float | None:
        """The most that thrusts make along a weak direction, moments over the rms arm; empty without one."""
        return largest(self.measured.problem.weak_bound_N) if self.measured.problem else None

    @cached_property
    def alpha_hard(self) -> float | None:
        """Median alpha* under eq. 4-5, which holds weak axes at the demand; empty where none is weak."""
        return self.measured.problem.alpha_hard if self.measured.problem else None

    @cached_property
    def way_in_p50_us(self) -> float | None:
        """Part of ``call_p50_us`` that is the way in: to a library of your own, or a program's pipe."""
        return microseconds(median_or_none(self.measured.centre(lambda cell: cell.way_in_batches)))


def columns() -> dict[str, Callable[[Row], str | int | float | None]]:
    """Every column of results.csv by name, in order."""
    return {name: one.func for name, one in vars(Row).items() if isinstance(one, cached_property)}


def documentation() -> str:
    """The columns as a Markdown table, from their docstrings."""
    meanings = {name: inspect.cleandoc(column.__doc__ or "") for name, column in columns().items()}
    return table(
        ("column", "meaning"),
        [(f"`{name}`", meaning.replace("``", "`")) for name, meaning in meanings.items()],
        markdown=True,
    )
