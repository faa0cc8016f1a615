"""The columns of results.csv, in order: each public function here is one, a function of a Row.

Its name is the column's, with the unit at the end; its docstring is the column's documentation
(``docs/results.md``). A column that does not apply to a row is empty. Times are medians or maxima,
never means. To add a column, add a function.
"""

from statistics import median

from bench.rows import Counted, Row, merged

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
    """``ok``, or why nothing was measured: ``failed``, ``crashed``, ``timeout``, ``missing``, ``refused``."""
    return row.failed.status if row.failed else "ok"


def reason(row: Row) -> Value:
    """The reason for a status other than ``ok``, in words."""
    return row.failed.reason if row.failed else ""


def n_demands(row: Row) -> Value:
    """How many different demands the set holds."""
    return max((cell.n_demands for cell in row.cells), default=0)


def n_calls(row: Row) -> Value:
    """How many calls were timed, in batches and singly, over all repeats."""
    batched = sum(batch.calls for cell in row.cells for batch in cell.batches)
    return batched + sum(count for _, count in row.singles)


def setup_us(row: Row) -> Value:
    """Median time to prepare the method for the vehicle."""
    times = [ns for cell in row.cells for ns in cell.setup_ns]
    return _us(median(times) if times else None)


def call_p50_us(row: Row) -> Value:
    """Time of one call: median over batches, then over repeats."""
    return _us(_median(row.centre(lambda cell: cell.batches)))


def call_p99_us(row: Row) -> Value:
    """99 % of single calls were faster; empty below 1,000 calls."""
    return _us(_quantile(row.singles, 0.99))


def call_p999_us(row: Row) -> Value:
    """99.9 % of single calls were faster; empty below 10,000 calls."""
    return _us(_quantile(row.singles, 0.999))


def call_max_us(row: Row) -> Value:
    """The slowest single call seen: method, interpreter and machine together."""
    return _us(row.singles[-1][0] if row.singles else None)


def solver_p50_us(row: Row) -> Value:
    """Median of the time that the solver itself reports; empty where it reports none."""
    return _us(_quantile(merged(cell.solver_singles for cell in row.cells), 0.5))


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
    return "yes" if not any(cell.quiet and cell.quiet.steal_ticks for cell in row.cells) else "no"


def level(row: Row) -> Value:
    """Accuracy: ``default`` settings of the solver, or ``tight`` (1e-6 of the largest limit)."""
    return row.level


def formulation(row: Row) -> Value:
    """Which optimum the method answers; answers are compared only within one."""
    return next((cell.formulation for cell in row.cells if cell.formulation), "")


def repeats(row: Row) -> Value:
    """How many fresh processes measured this row."""
    return len(row.cells)


def call_p50_low_us(row: Row) -> Value:
    """Lowest ``call_p50_us`` of a single repeat."""
    return _us(min(row.centre(lambda cell: cell.batches), default=None))


def call_p50_high_us(row: Row) -> Value:
    """Highest ``call_p50_us`` of a single repeat."""
    return _us(max(row.centre(lambda cell: cell.batches), default=None))


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


def tolerance(row: Row) -> Value:
    """Distance over the largest thrust limit that ``agrees`` allows."""
    return row.worst(lambda j: j.tolerance)


def wrong(row: Row) -> Value:
    """Why an answer is wrong, where one is."""
    return next((j.wrong for j in row.judged if j.wrong), "")


def _us(ns: float | None) -> float | None:
    return None if ns is None else ns / 1000


def _median(values: list[float]) -> float | None:
    return median(values) if values else None


def _quantile(counted: Counted, q: float) -> int | None:
    n = sum(count for _, count in counted)
    if not n or n * (1 - q) < 9.999:  # ten calls must lie beyond it, or it is an anecdote
        return None
    below = 0
    for ns, count in counted:
        below += count
        if below >= q * n:
            return ns
    return counted[-1][0]
