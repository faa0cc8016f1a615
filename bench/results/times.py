"""Times of the repeats of a cell: how many calls, their middle, their tail."""

from statistics import median

from bench.record import Cell
from bench.results.quantiles import interval, quantile, total
from bench.results.repeats import Repeats


def calls(cell: Cell) -> int:
    """How many calls of a cell were timed; one that was timed both in a batch and singly counts once."""
    batched, singly = sum(batch.calls for batch in cell.batches), total(cell.singles)
    # Slow single calls are stored as batches too. Then batches and singles together hold more time than was
    # timed at all. The bins of the singles are 1 % off at most.
    batches_ns = sum(batch.wall_ns for batch in (*cell.batches, *cell.binding_batches))
    singles_ns = sum(ns * count for ns, count in cell.singles)
    twice = batched == singly and cell.timed_ns < batches_ns + 0.98 * singles_ns
    return batched if twice else batched + singly


def tail_ns(measured: Repeats, q: float) -> float | None:
    """Quantile of single calls [ns]; None where batches took longer: then the machine was not the same."""
    tail, median_ns = quantile(measured.singles, q), middle(measured.centre(lambda cell: cell.batches))
    return None if tail is None or (median_ns is not None and tail < median_ns) else tail


def end_ns(measured: Repeats, q: float, end: int) -> float | None:
    """Lower (0) or upper (1) end [ns] of the interval of ``tail_ns``; None where that is None."""
    bounds = None if tail_ns(measured, q) is None else interval(measured.singles, q)
    return None if bounds is None else bounds[end]


def us(ns: float | None) -> float | None:
    """The time in µs."""
    return None if ns is None else ns / 1000


def middle(values: list[float]) -> float | None:
    """The median; None of nothing."""
    return median(values) if values else None
