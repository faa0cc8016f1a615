"""The repeats of one cell, taken together."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import TypeVar

from bench.record import Batch, Cell, Header, Judged, Key, Method, Worker
from bench.results.quantiles import Histogram, merged

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
