"""Refusals of methods: demands without thrusts, as shares of a log and in words."""

from math import log
from typing import NamedTuple

from alloc.formulations import find_formulation
from bench.record import MISSED_MUCH, Loss, Problem
from bench.results.columns import Row
from bench.results.quantiles import share
from bench.results.text import percent, plural, three

UNMET = "what can't be met"
MISSES = ("some of what can be met", f"{percent(MISSED_MUCH)} and more of most demands that can be met")
"""Names of attainable demands that a method refuses."""


class Refusal(NamedTuple):
    """Refusals of a method on a demand set.

    Attributes
    ----------
    share : of a log or mission that got no wrench [-]
    words : what it refuses, empty where nothing
    unanswered : True if any demand, drawn ones included, got no thrusts
    """

    share: float
    words: str
    unanswered: bool


NONE = Refusal(0.0, "", unanswered=False)


def refusal(row: Row, problem: Problem | None, even: Loss | None = None) -> Refusal:
    """The share of a log or mission that got no wrench, and in words what got none; 0 and empty for nothing.

    Of a log that was not asked whole it is the share that can't be met, for methods that refuse those. Of
    demands that were drawn to be beyond what the vehicle can do, or about the moment at which a mission comes
    to that, a share would say nothing. A method that refuses is named as such of a log that is met, too: the
    next dive may ask for more. One that delivers nothing of a demand that can be met, or MISSED_MUCH of most,
    counts as one that refuses all. Where the loss of demands drawn evenly is known they alone say that, not a
    small set drawn otherwise.
    """
    refused = _log_refusal(row, problem)
    if even and even.missed_much is not None and problem and is_random(problem):
        return refused
    judged = row.measured.judged
    if max((each.missed_p50 or 0.0 for each in judged), default=0.0) >= MISSED_MUCH:
        return Refusal(1.0, MISSES[1], unanswered=True)
    missed = max((each.missed_max or 0.0 for each in judged), default=0.0)
    return Refusal(1.0, MISSES[0], unanswered=True) if missed >= 1 and not refused.share else refused


def even_refusal(even: Loss | None) -> Refusal:
    """Refusal of demands that can be met and were drawn evenly: of most, or of one."""
    if even and even.missed_much is not None and 2 * even.missed_much >= even.n_demands:
        return Refusal(1.0, MISSES[1], unanswered=True)
    return Refusal(1.0, MISSES[0], unanswered=True) if even and even.missed_max >= 1 else NONE


SELDOM = -log(0.95)
"""Expected number at which at least one is seen in 5 % of draws."""


def is_even_refusal_open(even: Loss | None) -> bool:
    """True if as many more demands drawn evenly may say otherwise than ``even_refusal``, in 5 % of draws.

    A demand of which nothing was delivered stays one, however many more are asked.
    """
    if even is None or even.missed_much is None or even.nothing_expected is None or even.missed_max >= 1:
        return False
    _, low, high = share(even.missed_much, even.n_demands)
    return low < 0.5 and (high >= 0.5 or even.nothing_expected >= SELDOM)


def is_random(problem: Problem) -> bool:
    """True if demands were drawn at random: they are no log's, and of no mission."""
    return not problem.given and problem.rate_hz is None


def _log_refusal(row: Row, problem: Problem | None) -> Refusal:
    answered = row.answered_share
    if answered is None:
        return Refusal(0.0, "", unanswered=False)
    refused, run = 1 - answered, max(judged.refused_longest for judged in row.measured.judged)
    crossed = ""
    if problem is not None and any(cell.limited for cell in row.measured.cells):
        n = max(problem.n_demands, 1)
        crossed = "limits that cross" if problem.crossed or problem.crossed_asked else ""
        # Nobody can keep those, so to refuse them is no less than to answer them. Shares are rounded.
        refused = max(0, round(refused * n) - problem.crossed_asked) / n
        run = min(run, problem.beyond_longest) if problem.crossed_asked else run
    if (
        problem is not None and problem.given and problem.left_out and refuses(row.formulation)
    ):  # then more than was asked
        refused = problem.beyond / (problem.n_demands + problem.left_out)
        run = problem.beyond_longest
    in_time = problem is not None and (problem.given or problem.rate_hz is not None)  # a log or a mission
    nothing = max(judged.nothing_share for judged in row.measured.judged) if in_time else 0.0
    if not refused + nothing:
        words = UNMET if in_time and refuses(row.formulation) else ""
        words = f"{words}, and {crossed}" if words and crossed else words or crossed
        return Refusal(0.0, words, unanswered=False)
    if problem is None or not in_time:
        return Refusal(0.0, UNMET, unanswered=True)
    refused += nothing
    if not problem.given:
        words = f"some of {row.demands} by giving nothing" if nothing else f"{UNMET} of {row.demands}"
        return Refusal(refused, words, unanswered=True)
    words = f"{percent(refused)} of {row.demands}'s demands{' by giving nothing' if nothing else ''}"
    if run and problem.rate_hz:
        words += f", up to {three(run / problem.rate_hz)} s at a stretch"
    elif run:
        words += f", up to {plural(run, 'demand')} in a row"
    return Refusal(refused, f"{words}, and {crossed}" if crossed else words, unanswered=True)


def refuses(formulation: str) -> bool:
    """True if methods of that formulation give no thrusts where a demand can't be met."""
    known = find_formulation(formulation)
    return known.optimal and known.way is None and not known.gives_way
