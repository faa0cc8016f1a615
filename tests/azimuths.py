"""Boats whose thrusters turn: a ferry's file, and random ones with linear programs on the same polygons."""

import numpy as np
from scipy.optimize import linprog, nnls

from alloc import Vehicle
from bench.demands.boats import boats

__all__ = ["FERRY", "boats", "corners_lp", "demands_around", "excess", "stationarity"]
FERRY = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [1.8, 0, 0], azimuth: {max: 100}, name: bow}
  - {position: [-1.8, 0, 0], azimuth: {max: 100}, name: stern}
"""


def corners_lp(vehicle: Vehicle, tau: np.ndarray) -> float:
    """alpha* by a linear program over the corners of all sets: no half-plane, no facet."""
    columns, groups = [], []
    for azimuth in vehicle.azimuths:
        if vehicle.readiness[azimuth.first]:
            groups.append(len(azimuth.corners))
            columns += [vehicle.TP[:, azimuth.components] @ corner for corner in azimuth.corners]
    turning = {i for azimuth in vehicle.azimuths for i in azimuth.components}
    for i in sorted({*vehicle.working.tolist()} - turning):
        groups.append(2)
        columns += [vehicle.TP[:, i] * vehicle.f_min[i], vehicle.TP[:, i] * vehicle.f_max[i]]
    size = np.abs(tau / vehicle.wrench_scale).max()
    pushed = np.column_stack([*columns, -tau / size]) / vehicle.wrench_scale[:, None]
    shares = np.zeros((len(groups), len(columns) + 1))
    for row, (end, count) in enumerate(zip(np.cumsum(groups), groups, strict=True)):
        shares[row, end - count : end] = 1.0
    optimum = linprog(
        np.append(np.zeros(len(columns)), -1.0),
        A_eq=np.vstack([pushed, shares]),
        b_eq=np.append(np.zeros(vehicle.k), np.ones(len(groups))),
        bounds=[(0, None)] * len(columns) + [(None, None)],
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    assert optimum.status == 0, optimum.message
    return float(optimum.x[-1] / size)


def demands_around(vehicle: Vehicle, rng: np.random.Generator, n: int) -> np.ndarray:
    """n wrenches (n, k) in random directions, of the size of what the vehicle can do [N, N m]."""
    taus: np.ndarray = rng.normal(size=(n, vehicle.k)) * vehicle.wrench_scale
    return taus


def excess(vehicle: Vehicle, f: np.ndarray) -> float:
    """Distance by which thrusts (n,) leave polygons and limits, relative to the largest limit [-]."""
    rows, far = [*np.eye(vehicle.n), *-np.eye(vehicle.n)], [*vehicle.f_max, *-vehicle.f_min]
    if vehicle.half_planes is not None:
        rows, far = [*rows, *vehicle.half_planes.A], [*far, *vehicle.half_planes.reach]
    return float((np.array(rows) @ f - far).max() / vehicle.f_scale)


def stationarity(vehicle: Vehicle, f: np.ndarray, near: float = 1e-7) -> float:
    """Least |Hf - T'y + C'u| over y and u >= 0, C the limits that f is at, relative to |Hf| [-].

    Zero proves that f is the least effort for the wrench that it makes, with no solver asked.
    """
    on = vehicle.working
    rows, far = [*np.eye(vehicle.n), *-np.eye(vehicle.n)], [*vehicle.f_max, *-vehicle.f_min]
    turning = {i for azimuth in vehicle.azimuths for i in azimuth.components}
    fixed = [i not in turning for i in range(vehicle.n)] * 2
    rows, far = [row for row, own in zip(rows, fixed, strict=True) if own], list(np.array(far)[fixed])
    if vehicle.half_planes is not None:
        rows, far = [*rows, *vehicle.half_planes.A], [*far, *vehicle.half_planes.reach]
    C = np.array(rows)
    at = C[np.array(far) - C @ f <= near * vehicle.f_scale][:, on]
    T = (vehicle.TP / vehicle.row_lengths[:, None])[:, on]
    gradient = (vehicle.H @ f)[on]
    size = max(float(np.linalg.norm(gradient)), 1e-6 * vehicle.f_scale)
    return float(nnls(np.hstack([T.T, -T.T, -at.T]), gradient)[1] / size)
