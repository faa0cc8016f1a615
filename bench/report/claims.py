"""Claims that report, `size` and terminal make, each with the demands that it is about.

A sentence that says worst, up to, nothing, all, every, only or at most stands here, or a test fails that
renders runs and finds such words.
"""

from typing import NamedTuple


class SetClaim(NamedTuple):
    """A sentence about demands, calls or rows.

    Attributes
    ----------
    sentence : a regular expression that finds it
    demands : the set that it speaks of
    statistic : what is said of them
    number : where the record has how many they are
    """

    sentence: str
    demands: str
    statistic: str
    number: str


ASKED = "all demands of the vehicle's sets in this run, missions whole"
ATTAINABLE = "the attainable ones among all demands of the vehicle's sets in this run"
DRAWN = "demands drawn evenly from what the vehicle can do"
ROWS = "all rows of the run"

CLAIMS = (
    SetClaim(r"take [^;.]+; exact", ATTAINABLE, "largest distance to the optimum", "Judged.answers"),
    SetClaim(r"take [^;.]+; not exact", ATTAINABLE, "largest distance to the optimum", "Judged.answers"),
    SetClaim(r"answers every demand", ASKED, "demands without thrusts: none", "Problem.n_demands"),
    SetClaim(r"refuses what can't be met", ASKED, "what its formulation refuses", "Problem.n_demands"),
    SetClaim(r"refuses [\d.]+ % of \S+'s demands", "all demands of a log", "share", "Problem.left_out"),
    SetClaim(r"nothing to take", ATTAINABLE, "largest or median loss", "Judged.answers"),
    SetClaim(r"nothing here fits", "all timed calls", "median time", "Batch.calls"),
    SetClaim(r"of \S+ [\d,]+ demands [\d,]+ asked", "a mission", "part of it", "Problem.left_out"),
    SetClaim(r"only the first \d+ were asked", "a log", "part of it", "Problem.left_out"),
    SetClaim(r"No spare thruster: each wrench", "all wrenches", "freedom of the vehicle", "Problem.nullity"),
    SetClaim(r"so slowest calls within that", "calls of fixed work", "longest pause", "Cell.singles"),
    SetClaim(r"exact constrained allocation", "each vehicle's first set", "median time", "Batch.calls"),
    SetClaim(r"of what a vehicle can do: that much", DRAWN, "share within 1 %", "Served.n_demands"),
    SetClaim(
        r"worst of its corners(, where these are few,)? and of [\d,]+ demands drawn .* up to",
        f"wrenches of thrusters at their limits, and {DRAWN}",
        "largest loss and turn",
        "Served.corners, Served.sample",
    ),
    SetClaim(r"worst of [\d,]+ demands drawn .* up to", DRAWN, "largest loss and turn", "Served.sample"),
    SetClaim(
        r"Worst of [\d,]+ demands drawn evenly, with .* and nobody told",
        DRAWN,
        "least share delivered along a demand, largest turn",
        "FailureCost.n_demands",
    ),
    SetClaim(
        r"The exact answer \(.*\) delivers all [\d,]+ that were drawn",
        DRAWN,
        "share within 1 %",
        "MixerCost.n_demands",
    ),
    SetClaim(r"drawn evenly the autopilot costs most", DRAWN, "largest losses", "MixerCost.n_demands"),
    SetClaim(
        r"less than [\d.]+ % of all such demands|Of all such demands less than",
        "all that the demands were drawn from",
        "share beyond the worst of n: 10 / n, with a chance of 0.005 % of more",
        "n_demands of the worst",
    ),
    SetClaim(
        r"[Nn]ot decided by so few", f"{DRAWN}, and all timed calls", "intervals", "Size.n_even, Batch.calls"
    ),
    SetClaim(
        r"the cap leaves .* Delivered, over", "directions drawn evenly", "medians", "FuseCost.n_demands"
    ),
    SetClaim(
        r"Thrusts within limits make at most", "all thrusts within limits", "bound", "Problem.weak_bound_N"
    ),
    SetClaim(r"labels and losses are of all that counts", "a row's demands", "strong part", "Problem.weak"),
    SetClaim(r": weak: \w+", "all wrenches along an axis", "authority", "Problem.weak"),
    SetClaim(
        r"n the \d+ demands asked.* up to", "each vehicle's first set, and logs", "largest loss", "n_demands"
    ),
    SetClaim(r"Every timed answer was judged", ROWS, "rows by verdict", "Run.rows"),
    SetClaim(
        r"attainable demands above and of [\d,]+ drawn evenly .* nothing is lost",
        f"{ATTAINABLE}, and {DRAWN}",
        "largest loss at most WRENCH_TOLERANCE",
        "Problem.labels, Served.sample",
    ),
    SetClaim(
        r"attainable demands above nothing is lost, and of [\d,]+ drawn .* at most 1 %",
        f"{ATTAINABLE}, and {DRAWN}",
        "largest loss, and all within 1 %",
        "Problem.labels, Served.n_demands",
    ),
    SetClaim(
        r"attainable demands above, the only ones asked, nothing is lost",
        ATTAINABLE,
        "largest loss at most WRENCH_TOLERANCE",
        "Problem.labels",
    ),
    SetClaim(r"are shares of (a|an) \w+", "what is left after a failure", "rank", "Authority.rank"),
    SetClaim(r"some direction can't be pushed at all", "all wrenches", "rank", "Authority.rank"),
    SetClaim(r"full rank on paper, hardly any thrust", "all wrenches", "condition", "Authority.condition"),
    SetClaim(
        r"No row disagrees, and no answer is wrong", ROWS, "wrong or far answers: none", "Judged.answers"
    ),
    SetClaim(r"No row is without a measurement", ROWS, "rows without a time: none", "Run.rows"),
    SetClaim(
        r"in \d+ of \d+ rows where two repeats", "rows with two repeats", "intervals apart", "Cell.singles"
    ),
    SetClaim(r"demands \([^)]* s\) of waypoints", "a mission", "part of it", "Problem.left_out"),
)
