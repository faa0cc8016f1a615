"""The columns of results.csv, in order: each property of ``Row``, then of ``Judgements``; no cached_property.

A property's name is the column's, with the unit at the end; its docstring is the column's documentation
(``docs/results.md``). A column that does not apply to a row is empty in the file and None here. Times are
medians or maxima, never means. To add a column, add a property.
"""

from dataclasses import dataclass
from functools import cached_property
from statistics import median

from alloc.formulations import find_formulation
from bench.record import Cell, Method
from bench.record.schema import machine_name
from bench.results.judgements import Judgements, Worst
from bench.results.quantiles import merged, quantile, total
from bench.results.repeats import calls, end_ns, middle, most, tail_ns, us


@dataclass(frozen=True)
class Row(Judgements):
    """One line of results.csv: a method with its start and level on one vehicle's demand set."""

    @cached_property
    def described(self) -> Method:
        """The method's line of the record."""
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
    def unlimited(self) -> bool:
        """True if thrusts may lie beyond the limits; a user's method says so of itself."""
        known = find_formulation(self.formulation)
        measured = [cell for cell in self.measured.cells if cell.status == "ok"]
        rule = self.described.plugin and not known.references  # of the user's own: no file says what it keeps
        return not known.limited or (rule and bool(measured) and not any(c.limited for c in measured))

    @cached_property
    def title(self) -> str:
        """Meaning of its answers, in a few words."""
        known = find_formulation(self.formulation)
        return "a rule that promises no limits" if self.unlimited and known.limited else known.title

    @cached_property
    def failed(self) -> Cell | None:
        """The first repeat that was not measured, None where all were."""
        return next((cell for cell in self.measured.cells if cell.status != "ok"), None)

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
        """``yes`` where answers are as near the optimum as promised, else ``no``; ``-`` without a promise."""
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
        """Disturbances of the machine where ``quiet`` is no; docs/method.md says what counts."""
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
        """Optimum that the method answers; answers are compared only within one."""
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
