"""Share of the demands that the C's thrusts deliver, as three numbers of a record."""

import numpy as np

from alloc import Status
from bench.chips.count import CallCounts
from bench.demands import DemandSet
from bench.judging.judge import rounded
from bench.judging.loss import direction_error_deg, relative_wrench_error, share_along
from bench.record import SERVED_WITHIN


def delivered(demands: DemandSet, counted: CallCounts) -> dict[str, float | None]:
    """Share of all demands delivered to 1 %; mean share along and largest angle of those answered."""
    answered = np.isin(counted.status, (Status.SOLVED, Status.PARTIAL))[:, None]
    asked = demands.vehicle, demands.taus, np.where(answered, counted.F, np.nan), demands.limits
    close = np.count_nonzero(relative_wrench_error(*asked) <= SERVED_WITHIN) / len(demands.taus)
    along, turned = share_along(*asked), direction_error_deg(*asked)
    return {
        "within_1pct_share": rounded(close),
        "along_mean": None if np.isnan(along).all() else rounded(float(np.nanmean(along))),
        "direction_error_max_deg": None if np.isnan(turned).all() else rounded(float(np.nanmax(turned))),
    }
