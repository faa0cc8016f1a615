"""The columns of results.csv, in order: each public function here is one, a function of a Row.

Its name is the column's, with the unit at the end; its docstring is the column's documentation
(``docs/results.md``). A column that does not apply to a row is empty. Times are medians or maxima,
never means. To add a column, add a function.
"""

from collections.abc import Callable
from statistics import median

from bench.record import Cell
from bench.results.quantiles import interval, merged, quantile
from bench.results.rows import Row

Value = str | int | float | None


def vehicle(row: Row) -> Value:
    """Name of the vehicle that answers; ``-f2`` says that thruster 2 (from 0) is off."""
    return row.vehicle


def demands(row: Row) -> Value:
    """Name of the demand set."""
    return row.demands


def method(row: Row) -> Value:
    """Label of the method."""
    return row.method


def start(row: Row) -> Value:
    """``cold`` (new solver object a call), ``reused`` (the same), ``warm`` (last answer as first guess)."""
    return row.start


def status(row: Row) -> Value:
    """``ok``, or why a repeat lacks times: ``failed``, ``crashed``, ``timeout``, ``missing``, ``refused``."""
    return row.failed.status if row.failed else "ok"


def reason(row: Row) -> Value:
    """The reason for a status other than ``ok``, in words."""
    return row.failed.reason if row.failed else ""


def n_demands(row: Row) -> Value:
    """How many different demands the set holds."""
    return max((cell.n_demands for cell in row.cells), default=0)


def n_calls(row: Row) -> Value:
    """How many calls were timed, in batches and singly, over all repeats; a slow one, which is both, once."""
    return sum(map(_calls, row.cells))


def setup_us(row: Row) -> Value:
    """Median time to prepare the method for the vehicle."""
    times = [ns for cell in row.cells for ns in cell.setup_ns]
    return _us(median(times) if times else None)


def call_p50_us(row: Row) -> Value:
    """Time of one call: median over batches, then over repeats."""
    return _us(_median(row.centre(lambda cell: cell.batches)))


def call_p99_us(row: Row) -> Value:
    """99 % of single calls were as fast; empty below 1,000 calls."""
    return _us(quantile(row.singles, 0.99))


def call_p999_us(row: Row) -> Value:
    """99.9 % of single calls were as fast; empty below 10,000 calls."""
    return _us(quantile(row.singles, 0.999))


def call_max_us(row: Row) -> Value:
    """The slowest single call seen: method, interpreter and machine together."""
    return _us(row.singles[-1][0] if row.singles else None)


def solver_p50_us(row: Row) -> Value:
    """Median of the time that the solver itself reports; empty where it reports none."""
    return _us(quantile(merged(cell.solver_singles for cell in row.cells), 0.5))


def iterations_max(row: Row) -> Value:
    """Most iterations that any demand took, by the solver's own count."""
    return max((c.iterations_max for c in row.cells if c.iterations_max is not None), default=None)


def solved_fraction(row: Row) -> Value:
    """Share of answers with status SOLVED (0 to 1), infeasible demands counted too."""
    answers = sum(j.answers for j in row.judged)
    return sum(j.counts.get("SOLVED", 0) for j in row.judged) / answers if answers else None


def wrench_error_max(row: Row) -> Value:
    """Largest |T P f - tau| of any axis and demand, in N or N m as the axis has it."""
    return row.worst(lambda j: max((e for e in j.wrench_error_max if e is not None), default=None))


def limit_violation_max_N(row: Row) -> Value:
    """Largest excess of any thrust over its limit."""
    return row.worst(lambda j: j.limit_violation_max_N)


def distance_max_N(row: Row) -> Value:
    """Largest |f - f*| to the optimum of the same formulation; empty where there is none."""
    return row.worst(lambda j: j.distance_max_N)


def agrees(row: Row) -> Value:
    """``yes`` where every answer is as near to the optimum as promised, ``no``, ``-`` where there is none."""
    verdicts = {j.agrees for j in row.judged if j.agrees is not None}
    return "-" if not verdicts else "yes" if verdicts == {True} else "no"


def peak_rss_MB(row: Row) -> Value:
    """Peak resident memory of the worker process (1 MB = 1e6 bytes), largest over repeats."""
    peak = max((w.peak_rss_bytes for w in row.workers if w.peak_rss_bytes is not None), default=None)
    return None if peak is None else peak / 1e6


def quiet(row: Row) -> Value:
    """``no`` where the machine was busy with something else while this row was timed."""
    return "no" if row.disturbed else "yes"


def disturbed_by(row: Row) -> Value:
    """What disturbed the machine where ``quiet`` is no; docs/method.md says what counts."""
    return "; ".join(row.disturbed)


def level(row: Row) -> Value:
    """Accuracy: ``default`` settings of the solver, or ``tight`` (1e-6 of the largest limit)."""
    return row.level


def formulation(row: Row) -> Value:
    """Which optimum the method answers; answers are compared only within one."""
    return next((cell.formulation for cell in row.cells if cell.formulation), "")


def repeats(row: Row) -> Value:
    """How many repeats there are; each that was measured had a fresh process."""
    return len(row.cells)


def call_p50_low_us(row: Row) -> Value:
    """Lowest ``call_p50_us`` of a single repeat."""
    return _us(min(row.centre(lambda cell: cell.batches), default=None))


def call_p50_high_us(row: Row) -> Value:
    """Highest ``call_p50_us`` of a single repeat."""
    return _us(max(row.centre(lambda cell: cell.batches), default=None))


def call_p99_low_us(row: Row) -> Value:
    """Lower end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
    return _us(_end(row, 0.99, 0))


def call_p99_high_us(row: Row) -> Value:
    """Upper end of the 95 % interval of ``call_p99_us``, as if calls were independent."""
    return _us(_end(row, 0.99, 1))


def call_p999_low_us(row: Row) -> Value:
    """Lower end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
    return _us(_end(row, 0.999, 0))


def call_p999_high_us(row: Row) -> Value:
    """Upper end of the 95 % interval of ``call_p999_us``, as if calls were independent."""
    return _us(_end(row, 0.999, 1))


def n_single_calls(row: Row) -> Value:
    """How many of ``n_calls`` were timed singly; quantiles are of these."""
    return sum(count for _, count in row.singles)


def call_cpu_p50_us(row: Row) -> Value:
    """Like ``call_p50_us``, on the clock of the thread's own CPU time."""
    return _us(_median(row.centre(lambda cell: cell.batches, "cpu_ns")))


def binding_p50_us(row: Row) -> Value:
    """Time of the solver's own Python binding inside the call: median over batches, then repeats."""
    return _us(_median(row.centre(lambda cell: cell.binding_batches)))


def worst_case_steps(row: Row) -> Value:
    """Proven bound on elementary steps of one call; empty where a method has none."""
    return max((c.worst_case_steps for c in row.cells if c.worst_case_steps is not None), default=None)


def allocator_bytes(row: Row) -> Value:
    """Bytes that the prepared allocator holds."""
    return max((c.allocator_bytes for c in row.cells if c.allocator_bytes is not None), default=None)


def wrench_error_relative(row: Row) -> Value:
    """Largest wrench error over the size of a wrench on its axis (row norm of T times the largest limit)."""
    return row.worst(lambda j: j.wrench_error_rel_max)


def distance_relative(row: Row) -> Value:
    """``distance_max_N`` over the largest thrust limit."""
    return row.worst(lambda j: j.distance_rel_max)


def gap_relative(row: Row) -> Value:
    """Largest relative duality gap: a certificate that needs no reference."""
    return row.worst(lambda j: j.gap_rel_max)


def failed_after_failure_share(row: Row) -> Value:
    """Share (0 to 1) of attainable demands without thrusts, of those right after another such answer."""
    return row.worst(lambda j: j.failed_after_failure)


def tolerance(row: Row) -> Value:
    """Distance over the largest thrust limit that ``agrees`` allows."""
    return row.worst(lambda j: j.tolerance)


def wrong(row: Row) -> Value:
    """Why an answer is wrong, where one is."""
    return next((j.wrong for j in row.judged if j.wrong), "")


def lost_wrench_p50(row: Row) -> Value:
    """Median of |delivered - tau| / |tau|, delivered being what thrusts clipped to their limits push."""
    return _loss(row, "wrench_error_rel_p50")


def lost_wrench_p99(row: Row) -> Value:
    """99 % of demands lose no more of their wrench than this share."""
    return _loss(row, "wrench_error_rel_p99")


def lost_wrench_max(row: Row) -> Value:
    """Largest share of any demand's wrench that is not delivered."""
    return _loss(row, "wrench_error_rel_max")


def lost_force_max_N(row: Row) -> Value:
    """Largest |delivered - tau| on any force axis."""
    return _worst_axis(row, "_max_N")


def lost_moment_max_Nm(row: Row) -> Value:
    """Largest |delivered - tau| on any moment axis."""
    return _worst_axis(row, "_max_Nm")


def answered_share(row: Row) -> Value:
    """Share of demands (0 to 1) that got a finite f; losses are of these."""
    return _loss(row, "answered_share", min)


def within_1pct_share(row: Row) -> Value:
    """Share of demands (0 to 1) whose wrench is delivered within 1 %."""
    return _loss(row, "within_1pct_share", min)


def within_5pct_share(row: Row) -> Value:
    """Share of demands (0 to 1) whose wrench is delivered within 5 %."""
    return _loss(row, "within_5pct_share", min)


def direction_error_p50_deg(row: Row) -> Value:
    """Median angle between delivered and demanded wrench."""
    return _loss(row, "direction_error_p50_deg")


def direction_error_max_deg(row: Row) -> Value:
    """Largest angle between delivered and demanded wrench."""
    return _loss(row, "direction_error_max_deg")


def effort_over_optimum_p50(row: Row) -> Value:
    """Median of f'Hf / f*'Hf* - 1 where f meets the demand, f* the optimum of eq. 4-5."""
    return _loss(row, "effort_over_optimum_p50")


def effort_over_optimum_max(row: Row) -> Value:
    """Largest f'Hf / f*'Hf* - 1."""
    return _loss(row, "effort_over_optimum_max")


def limits_violated_share(row: Row) -> Value:
    """Share of answers (0 to 1) with a thrust beyond a limit, before clipping."""
    return _loss(row, "limits_violated_share")


def thrusters_saturated_mean(row: Row) -> Value:
    """Mean number of thrusters at or beyond a limit."""
    return _loss(row, "thrusters_saturated_mean")


def _calls(cell: Cell) -> int:
    batched, singly = sum(batch.calls for batch in cell.batches), sum(count for _, count in cell.singles)
    # Passes of slow single calls are batches too: then there is more time in both than was timed at all.
    # The singles' bins are 1 % off at most.
    batches_ns = sum(batch.wall_ns for batch in (*cell.batches, *cell.binding_batches))
    singles_ns = sum(ns * count for ns, count in cell.singles)
    same = batched == singly and cell.timed_ns < batches_ns + 0.98 * singles_ns
    return batched if same else batched + singly


def _loss(row: Row, key: str, worst: Callable[[list[float]], float] = max) -> float | None:
    found = [value for j in row.judged if (value := j.loss.get(key)) is not None]
    return worst(found) if found else None


def _worst_axis(row: Row, suffix: str) -> float | None:
    axes = {key for j in row.judged for key in j.loss if key.endswith(suffix)}
    found = [value for key in axes if key.startswith("wrench") and (value := _loss(row, key)) is not None]
    return max(found, default=None)


def _end(row: Row, q: float, end: int) -> int | None:
    bounds = interval(row.singles, q)
    return None if bounds is None else bounds[end]


def _us(ns: float | None) -> float | None:
    return None if ns is None else ns / 1000


def _median(values: list[float]) -> float | None:
    return median(values) if values else None
