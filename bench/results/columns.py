"""The columns of results.csv, in order: each property of ``Row`` is one, no cached_property is.

A property's name is the column's, with the unit at the end; its docstring is the column's documentation
(``docs/results.md``). A column that does not apply to a row is empty in the file and None here. Times are
medians or maxima, never means. To add a column, add a property.
"""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from statistics import median

from alloc.formulations import find_formulation
from bench.record import Cell, Method
from bench.record.machine import machine_name
from bench.results.judgements import Worst, by_level, worst_axis
from bench.results.quantiles import merged, quantile, total
from bench.results.repeats import Repeats, most
from bench.results.times import calls, end_ns, middle, tail_ns, us


@dataclass(frozen=True)
class Row:
    """One line of results.csv: a method with its start and level on one vehicle's demand set.

    Attributes
    ----------
    measured : the repeats that the columns are worked out from
    """

    measured: Repeats

    @cached_property
    def described(self) -> Method:
        """What the record says of the method itself."""
        return self.measured.described

    @cached_property
    def label(self) -> str:
        """Method, start and level as tables show them, e.g. ``qp/osqp warm tight``, without ``default``."""
        choices = (self.start, self.level)
        return " ".join([self.method, *(choice for choice in choices if choice not in ("-", "default"))])

    @cached_property
    def family(self) -> str:
        """Family of the method: reports show its methods together."""
        return self.described.family or find_formulation(self.formulation).family

    @cached_property
    def failed(self) -> Cell | None:
        """The first repeat that was not measured, None where all were."""
        return next((cell for cell in self.measured.cells if cell.status != "ok"), None)

    @cached_property
    def agreed(self) -> bool | None:
        """``agrees`` as True or False; None where no right answer is known."""
        verdicts = {judged.agrees for judged in self.measured.judged if judged.agrees is not None}
        return None if not verdicts else verdicts == {True}

    @cached_property
    def undisturbed(self) -> bool:
        """``quiet`` as True or False."""
        return not self.measured.disturbances

    @property
    def vehicle(self) -> str:
        """Name of the vehicle that answers; ``-f2`` says that thruster 2 (from 0) is off."""
        return self.measured.key.vehicle

    @property
    def demands(self) -> str:
        """Name of the demand set."""
        return self.measured.key.demands

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.measured.key.method

    @property
    def start(self) -> str:
        """``cold`` (new solver object a call), ``reused`` (the same) or ``warm`` (from the last answer)."""
        return self.measured.key.start

    @property
    def status(self) -> str:
        """``ok``, or why there is no time: ``failed``, ``crashed``, ``timeout``, ``missing``, ``refused``."""
        return self.failed.status if self.failed else "ok"

    @property
    def reason(self) -> str:
        """The reason for a status other than ``ok``, in words."""
        return self.failed.reason if self.failed else ""

    @property
    def n_demands(self) -> int:
        """How many different demands the set holds."""
        return max((cell.n_demands for cell in self.measured.cells), default=0)

    @property
    def n_calls(self) -> int:
        """How many calls were timed over all repeats; a call timed both in a batch and singly counts once."""
        return sum(map(calls, self.measured.cells))

    @property
    def setup_us(self) -> float | None:
        """Median time to prepare the method for the vehicle."""
        times = [ns for cell in self.measured.cells for ns in cell.setup_ns]
        return us(median(times) if times else None)

    @property
    def call_p50_us(self) -> float | None:
        """Time of one call: median over batches, then over repeats."""
        return us(middle(self.measured.centre(lambda cell: cell.batches)))

    @property
    def call_p99_us(self) -> float | None:
        """Time that 99 % of single calls did not exceed; empty below 1,000 calls, or below the median."""
        return us(tail_ns(self.measured, 0.99))

    @property
    def call_p999_us(self) -> float | None:
        """Time that 99.9 % of single calls did not exceed; empty below 10,000 calls, or below the median."""
        return us(tail_ns(self.measured, 0.999))

    @property
    def call_max_us(self) -> float | None:
        """The slowest single call seen: method, interpreter and machine together."""
        return us(self.measured.singles[-1][0] if self.measured.singles else None)

    @property
    def solver_p50_us(self) -> float | None:
        """Median of the time that the solver itself reports; empty where it reports none."""
        return us(quantile(merged(cell.solver_singles for cell in self.measured.cells), 0.5))

    @property
    def iterations_max(self) -> int | None:
        """Most iterations that any demand took, by the solver's own count."""
        return most(cell.iterations_max for cell in self.measured.cells)

    @property
    def solved_fraction(self) -> float | None:
        """Share of answers with status SOLVED (0 to 1), infeasible demands counted too."""
        answers = sum(j.answers for j in self.measured.judged)
        return sum(j.counts.get("SOLVED", 0) for j in self.measured.judged) / answers if answers else None

    wrench_error_max = Worst(
        "Largest |T P f - tau| of any axis and demand, in N or N m as the axis has it.",
        lambda j: most(j.wrench_error_max),
    )
    limit_violation_max_N = Worst(
        "Largest excess of any thrust over its limit.", lambda j: j.limit_violation_max_N
    )
    distance_max_N = Worst(
        "Largest |f - f*| to the optimum of the same formulation; empty where no optimum is known.",
        lambda j: j.distance_max_N,
    )

    @property
    def agrees(self) -> str:
        """``yes`` where every answer is as near the optimum as promised, else ``no``; ``-`` if unknown."""
        return {None: "-", True: "yes", False: "no"}[self.agreed]

    @property
    def peak_rss_MB(self) -> float | None:
        """Peak resident memory of the worker process (1 MB = 1e6 bytes), largest over repeats."""
        peak = most(worker.peak_rss_bytes for worker in self.measured.workers)
        return None if peak is None else peak / 1e6

    @property
    def quiet(self) -> str:
        """``no`` where the machine was busy with something else while this row was timed."""
        return "yes" if self.undisturbed else "no"

    @property
    def disturbed_by(self) -> str:
        """What disturbed the machine where ``quiet`` is no; docs/method.md says what counts."""
        return "; ".join(self.measured.disturbances)

    @property
    def machine(self) -> str:
        """Name of the machine: the folder's that `thrustbench run` chooses there."""
        return machine_name(self.measured.origin.machine)

    @property
    def commit(self) -> str:
        """Commit of this project that was measured; ``+changes`` where its files differed from it."""
        return self.measured.origin.commit

    @property
    def level(self) -> str:
        """Accuracy: ``default`` settings of the solver, or ``tight`` (1e-6 of the largest limit)."""
        return self.measured.key.level

    @property
    def formulation(self) -> str:
        """Which optimum the method answers; answers are compared only within one."""
        return next((cell.formulation for cell in self.measured.cells if cell.formulation), "")

    @property
    def repeats(self) -> int:
        """How many repeats there are; each that was measured had a fresh process."""
        return len(self.measured.cells)

    @property
    def call_p50_low_us(self) -> float | None:
        """Lowest ``call_p50_us`` of a single repeat."""
        return us(min(self.measured.centre(lambda cell: cell.batches), default=None))

    @property
    def call_p50_high_us(self) -> float | None:
        """Highest ``call_p50_us`` of a single repeat."""
        return us(max(self.measured.centre(lambda cell: cell.batches), default=None))

    @property
    def call_p99_low_us(self) -> float | None:
        """Lower end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
        return us(end_ns(self.measured, 0.99, 0))

    @property
    def call_p99_high_us(self) -> float | None:
        """Upper end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
        return us(end_ns(self.measured, 0.99, 1))

    @property
    def call_p999_low_us(self) -> float | None:
        """Lower end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
        return us(end_ns(self.measured, 0.999, 0))

    @property
    def call_p999_high_us(self) -> float | None:
        """Upper end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
        return us(end_ns(self.measured, 0.999, 1))

    @property
    def n_single_calls(self) -> int:
        """How many of ``n_calls`` were timed singly; quantiles are of these."""
        return total(self.measured.singles)

    @property
    def call_cpu_p50_us(self) -> float | None:
        """Like ``call_p50_us``, on the clock of the thread's own CPU time."""
        return us(middle(self.measured.centre(lambda cell: cell.batches, "cpu_ns")))

    @property
    def binding_p50_us(self) -> float | None:
        """Time of the solver's own Python binding inside the call: median over batches, then repeats."""
        return us(middle(self.measured.centre(lambda cell: cell.binding_batches)))

    @property
    def worst_case_steps(self) -> int | None:
        """Proven bound on elementary steps of one call; empty where a method has none."""
        return most(cell.worst_case_steps for cell in self.measured.cells)

    @property
    def allocator_bytes(self) -> int | None:
        """Bytes that the prepared allocator holds."""
        return most(cell.allocator_bytes for cell in self.measured.cells)

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

    @property
    def disbelieved(self) -> str:
        """What a solver said and was not believed, with calls: false INFEASIBLE, unknown exit flags."""
        counts = sum((Counter(cell.disbelieved) for cell in self.measured.cells), Counter())
        return "; ".join(f"{what} ({count:,} of {self.n_calls:,} calls)" for what, count in counts.items())

    tolerance = Worst("Distance over the largest thrust limit that ``agrees`` allows.", lambda j: j.tolerance)

    @property
    def wrong(self) -> str:
        """Why an answer is wrong; empty where none is."""
        return next((j.wrong for j in self.measured.judged if j.wrong), self.measured.wrong_elsewhere)

    lost_wrench_p50 = Worst(
        "Median of |delivered - tau| / |tau|, delivered being what thrusts clipped to their limits push.",
        lambda j: j.loss.get("lost_wrench_p50"),
    )
    lost_wrench_p99 = Worst(
        "99 % of demands lose no more of their wrench than this share.",
        lambda j: j.loss.get("lost_wrench_p99"),
    )
    lost_wrench_max = Worst(
        "Largest share of any demand's wrench that is not delivered.", lambda j: j.loss.get("lost_wrench_max")
    )
    lost_force_max_N = Worst(
        "Largest |delivered - tau| on any force axis.", lambda j: worst_axis(j, moments=False)
    )
    lost_moment_max_Nm = Worst(
        "Largest |delivered - tau| on any moment axis.", lambda j: worst_axis(j, moments=True)
    )
    answered_share = Worst(
        "Share of demands (0 to 1) that got a finite f; losses are of these.",
        lambda j: j.loss.get("answered_share"),
        min,
    )
    within_1pct_share = Worst(
        "Share of demands (0 to 1) whose wrench is delivered within 1 %.",
        lambda j: j.loss.get("within_1pct_share"),
        min,
    )
    within_5pct_share = Worst(
        "Share of demands (0 to 1) whose wrench is delivered within 5 %.",
        lambda j: j.loss.get("within_5pct_share"),
        min,
    )
    direction_error_p50_deg = Worst(
        "Median angle between delivered and demanded wrench.", lambda j: j.loss.get("direction_error_p50_deg")
    )
    direction_error_max_deg = Worst(
        "Largest angle between delivered and demanded wrench.",
        lambda j: j.loss.get("direction_error_max_deg"),
    )
    effort_over_optimum_p50 = Worst(
        "Median of f'Hf / f*'Hf* - 1 where f meets the demand, f* the optimum of eq. 4-5.",
        lambda j: j.loss.get("effort_over_optimum_p50"),
    )
    effort_over_optimum_max = Worst(
        "Largest f'Hf / f*'Hf* - 1.", lambda j: j.loss.get("effort_over_optimum_max")
    )
    limits_violated_share = Worst(
        "Share of answers (0 to 1) with a thrust beyond a limit, before clipping.",
        lambda j: j.loss.get("limits_violated_share"),
    )
    thrusters_saturated_mean = Worst(
        "Mean number of thrusters at or beyond a limit.", lambda j: j.loss.get("thrusters_saturated_mean")
    )

    @property
    def share_p50(self) -> str:
        """Median share (0 to 1) delivered of each level of a demand; empty where answers say none."""
        return by_level([j.share_p50 for j in self.measured.judged], median)

    @property
    def share_min(self) -> str:
        """Least share (0 to 1) delivered of each level of any demand, first level first."""
        return by_level([j.share_min for j in self.measured.judged], min)
