"""Boats whose thrusters turn: a ferry's file, and random ones with linear programs on the same polygons."""

import numpy as np
from scipy.optimize import linprog, nnls

from alloc import Vehicle
from alloc.vehicle.azimuth import Azimuth, polygon_corners

FERRY = """\
name: boat
dof: [surge, sway, yaw]
thrusters:
  - {position: [1.8, 0, 0], azimuth: {max: 100}, name: bow}
  - {position: [-1.8, 0, 0], azimuth: {max: 100}, name: stern}
"""
AXES = ("surge", "sway", "yaw")


def boat(rng: np.random.Generator, azimuths: int, fixed: int) -> Vehicle:
    """A vehicle in the plane with that many thrusters that turn, in discs and sectors, beside fixed ones.

    The first is in a disc or a sector of more than a quarter, so that all axes are pushed.
    """
    columns, turning, weights = [], [], []
    places = rng.uniform(-5.0, 5.0, (azimuths + fixed, 2))
    for x, y in places[:azimuths]:
        sides = int(rng.integers(3, 21))
        start = rng.uniform(-180.0, 180.0)
        sector = (-180.0, 180.0) if rng.random() < 0.6 else (start, start + rng.uniform(40.0, 180.0))
        turning.append(Azimuth(len(columns), polygon_corners(rng.uniform(20.0, 200.0), sector, sides)))
        columns += [(1.0, 0.0, -y), (0.0, 1.0, x)]
        weights += [rng.uniform(0.5, 2.0)] * 2
    for x, y in places[azimuths:]:
        angle = rng.uniform(-np.pi, np.pi)
        columns.append((np.cos(angle), np.sin(angle), x * np.sin(angle) - y * np.cos(angle)))
        weights.append(rng.uniform(0.5, 2.0))
    n = len(columns)
    return Vehicle(
        name=f"boat-{azimuths}-{fixed}",
        dof=AXES,
        T=np.array(columns).T,
        H=np.diag(weights),
        f_min=-rng.uniform(5.0, 100.0, n),
        f_max=rng.uniform(5.0, 100.0, n),
        readiness=np.ones(n),
        slack_weights=np.ones(3),
        azimuths=tuple(turning),
        weak_limit=0.0,
    )


def boats(count: int, seed: int = 1, most: int = 4) -> list[Vehicle]:
    """Random boats with 1 to ``most`` azimuths and up to three fixed thrusters, all of rank 3."""
    rng, made = np.random.default_rng(seed), list[Vehicle]()
    while len(made) < count:
        azimuths = 1 + len(made) % most
        fixed = int(rng.integers(1 if azimuths == 1 else 0, 4))
        if (vehicle := boat(rng, azimuths, fixed)).rank == 3:
            made.append(vehicle)
    return made


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
