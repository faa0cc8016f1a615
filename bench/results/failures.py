"""Costs of failures in a record: which method is shown, and costs by failure."""

from bench.record import Capability, FailureCost
from bench.results.rows import Run
from bench.results.text import number_range


def shown_method(capability: Capability) -> str | None:
    """Method whose costs are shown by thruster: the announced one's, else the first; None without costs."""
    unknown = [cost.method for cost in capability.failure_costs if not cost.announced]
    known = [cost.method for cost in capability.failure_costs if cost.announced]
    return next((method for method in known if method in unknown), unknown[0] if unknown else None)


def by_failure(
    capability: Capability, method: str = "", *, announced: bool = False
) -> dict[str, FailureCost]:
    """Cost by failure of a method, or once announced, which one method answers for all."""
    return {
        cost.failure: cost
        for cost in capability.failure_costs
        if cost.announced == announced and (announced or cost.method == method)
    }


def thruster_names(capability: Capability) -> list[str]:
    """Names of the thrusters that fail, by index where they have none."""
    on = capability.failure_costs[0].thrusters if capability.failure_costs else []
    return [(i < len(capability.names) and capability.names[i]) or str(i) for i in on]


def failure_sentence(run: Run) -> str:
    """Sentence for the overview: what a thruster that is off costs until it is announced, and then."""
    shares = []
    for capability in run.capabilities:
        cost = by_failure(capability, shown_method(capability) or "").get("off")
        known = by_failure(capability, announced=True).get("off")
        if cost is not None and known is not None:
            shares.append((100 * cost.share_p50[cost.weakest], 100 * known.share_p50[cost.weakest]))
    if not shares:
        return ""
    before, after = map(number_range, zip(*shares, strict=True))
    return (
        f"With the costliest thruster off and nobody told, {before} % of a demand is delivered, {after} %"
        " once it is announced (medians; `details.md` has each failure)."
    )
