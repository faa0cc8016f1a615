"""Repeats of a cell and statistics of their times."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import TypeVar

from bench.record import Batch, Cell, Header, Judged, Key, Method, Worker
from bench.results.quantiles import Histogram, interval, merged, quantile, total

N = TypeVar("N", int, float)


@dataclass(frozen=True, kw_only=True)
class Repeats:
    """All repeats of a method with its start and level on one vehicle's demand set: the data of a row.

    Attributes
    ----------
    key : the row's name, with repeat 0
    origin : what ran, where and with which versions: the record's header
    described : what the record says of the method itself
    cells : the repeats, each measured by a process of its own
    workers : the processes that measured them
    disturbances : what disturbed the machine meanwhile, empty where it was quiet
    attainable : share of the set's demands that are labelled inactive or active [-]
    wrong_elsewhere : what is wrong with the method's untimed answers on this vehicle, empty where nothing is
    wrong_on_others : what is wrong with a plug-in's answers on another of the vehicle's sets
    missed_elsewhere : whether these, or those of its twin, miss a demand that the vehicle can meet
    """

    key: Key
    origin: Header
    described: Method
    cells: tuple[Cell, ...]
    workers: tuple[Worker, ...]
    disturbances: tuple[str, ...]
    attainable: float = 0.0
    wrong_elsewhere: str = ""
    wrong_on_others: str = ""
    missed_elsewhere: bool = False

    @cached_property
    def singles(self) -> Histogram:
        """Times of single calls of all repeats together [ns]."""
        return merged(cell.singles for cell in self.cells)

    @cached_property
    def judged(self) -> list[Judged]:
        """Judgements by the equations, one for each repeat that was judged."""
        return [cell.judged for cell in self.cells if cell.judged is not None]

    def centre(self, batches: Callable[[Cell], Sequence[Batch]], clock: str = "wall_ns") -> list[float]:
        """Median time of a call [ns] over the batches of each repeat, one number a repeat."""
        timed = [batches(cell) for cell in self.cells]
        return [median(getattr(b, clock) / b.calls for b in repeat) for repeat in timed if repeat]


def most(values: Iterable[N | None]) -> N | None:
    """The largest of the values that are not None; None where all are."""
    return max((value for value in values if value is not None), default=None)


def most_of_all(values: Iterable[N | None]) -> N | None:
    """The largest of the values; None where one is, for it might be larger."""
    known = list(values)
    return None if None in known else most(known)


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
