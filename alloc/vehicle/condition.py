"""Cost of rounding on a vehicle: promised accuracy as a function of the conditions of T and H."""

import numpy as np

from alloc.vehicle.model import Vehicle

ROUNDING = 8 * float(np.finfo(np.float64).eps)
"""Share that rounding takes of a thrust, for each thruster and unit of condition [-]."""


def condition(vehicle: Vehicle) -> float:
    """Largest over smallest singular value of T P over its rank, with rows of unit length [-].

    So many times the thrust is needed along the weakest direction as along the strongest.
    """
    sigma = np.linalg.svd(vehicle.TP / vehicle.row_lengths[:, None], compute_uv=False)
    return float(sigma[0] / sigma[vehicle.rank - 1]) if vehicle.rank else 1.0


def unevenness(vehicle: Vehicle) -> float:
    """Condition of H over the working thrusters, in units of thrust that make its diagonal 1."""
    on = vehicle.working
    H = vehicle.H[np.ix_(on, on)]
    units = 1.0 / np.sqrt(np.diag(H))
    return float(np.linalg.cond(units[:, None] * H * units))


def wrench_doubt(vehicle: Vehicle) -> float:
    """Distance by which rounding may move thrusts that meet a wrench, over the largest limit [-].

    A wrench is known to eps of its size, and T P f = tau turns this into eps cond(T P) of the thrusts; each
    of the n products of a sum adds as much.
    """
    return ROUNDING * vehicle.n * condition(vehicle)


def excess_that_misses(vehicle: Vehicle, share: float) -> float:
    """By how much every thrust may be moved, and the wrench misses ``share`` of ``wrench_scale`` at most [N].

    That is share / max_r sum_i |T_ri| / wrench_scale_r.
    """
    pushed = (np.abs(vehicle.TP) / vehicle.wrench_scale[:, None]).sum(axis=1).max()
    return float(share / pushed) if pushed > 0 else vehicle.f_scale


def magnified(vehicle: Vehicle) -> float:
    """Distance from the optimum at which a solver may stop, over that for thrusters that are alike [-].

    A gap that is a share of the cost lets thrusts err by sqrt(cond H) of the share's root, because
    1/2 |f - f*|^2_H <= gap, and what a wrench misses is made of the weakest thruster's thrust:

        sqrt(cond H) max |T_i| / min |T_i|

    over the working thrusters, with the columns T_i in unit of ``wrench_scale``.
    """
    on = vehicle.working
    columns = np.linalg.norm(vehicle.TP[:, on] / vehicle.wrench_scale[:, None], axis=0)
    pushing = columns[columns > 0]
    uneven = float(pushing.max() / pushing.min()) if pushing.size else 1.0
    return uneven * float(np.sqrt(np.linalg.cond(vehicle.H[np.ix_(on, on)])))


def promised(vehicle: Vehicle, tolerance: float) -> float:
    """``tolerance`` [-], or what rounding leaves of it on this vehicle.

    Rounding moves a wrench, and the weakest thruster may have to make up for it: ROUNDING n times
    cond(T P) ``magnified`` + the condition of H in even units. On the very edge of what the thrusters can do
    the optimum itself may move by any distance with the last bit of a demand, and nothing is promised.
    """
    doubt = wrench_doubt(vehicle) * magnified(vehicle) + ROUNDING * vehicle.n * unevenness(vehicle)
    return max(tolerance, doubt)
