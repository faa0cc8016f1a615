"""Costs of failures in a record: which method is shown, and costs by failure."""

from bench.record import Capability, FailureCost


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
