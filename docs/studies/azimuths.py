"""Answers for random boats whose thrusters turn, each proven right or counted as wrong.

``nice python docs/studies/azimuths.py [--vehicles N] [--first N] [--demands N] [--lps N] [--jobs N]`` asks
nullspace and scaled, of boats with more than three dimensions qp/daqp, and prints counts by method:

- SOLVED is right where T P f makes the demand, f lies within the polygons, and multipliers u >= 0, y show by
  duality that no thrusts of less effort do: 1/2 f'Hf - L(u, y) >= 1/2 |f - f*|^2_H, L the dual value. Or it
  is as near as the method promises to thrusts of another solver that are shown to be so.
- INFEASIBLE is right where a direction c has c'tau above the sum over thrusters of the largest c'T_i v over
  the corners v of their sets. PARTIAL, of scaled, where thrusts make a share of the demand along its own
  line and such a c shows that no larger one can be made; their effort is certified for some.
- Of some demands the largest share is a linear program's too, and nullspace's thrusts are qp/daqp's.

``… --quta`` compares quta (0.1.0, with quadprog) where it is installed: on the case of its README, and on
random double-ended ferries, the same polygons in both.
"""

import argparse
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from scipy.optimize import nnls

from alloc import NotApplicable, Status, Vehicle, alpha_max, build
from alloc.allocation import EXACT_TOLERANCE, WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.reach.attainable import alpha_max_lp
from alloc.reach.zonotope import limit_rows, vertices, zonotope
from alloc.vehicle.azimuth import SPARE, Azimuth, polygon_corners
from bench.demands.boats import AXES, boats

NEAR = 1e-9
"""Distance from a limit at which it may have a multiplier, relative to the largest limit [-]."""
EFFORT = 1e-12
"""Largest duality gap, relative to the effort of the largest limit [-]: f is off by some 1e-6 of it."""
ROUNDING = 64 * float(np.finfo(np.float64).eps)
"""Share of the terms of a gap that is rounding: multipliers grow as 1 / distance from the set's edge [-]."""
AGREE = 1e-8
"""Largest difference of a share from a linear program's, which works to 1e-10 in scaled wrench [-]."""
SHARES = (1.0 - 1e-6, 1.0 + 1e-6, 0.98, 1.02, 3.0)
"""Shares of what is attainable that half of the demands ask for; the others are spread from 0 to 1."""
SECOND = "qp/quadprog"
"""The solver whose thrusts are certified in place of others, which must then lie within their promise of
these: near the edge an error of 1e-12 in a thrust costs more than EFFORT."""
SPARSE = 5
"""One in so many demands is asked of a QP solver, whose calls take a hundred times as long as nullspace's."""
CERTIFIED = 50
"""Demands a boat of which the effort of PARTIAL answers is certified."""


def ask(vehicle: Vehicle, rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    """Demands (m, k) [N, N m] in random directions, at most n, and the share of each that is attainable."""
    taus = rng.normal(size=(n, vehicle.k)) * vehicle.wrench_scale
    far = alpha_max(vehicle, taus)
    shares = np.where(rng.random(n) < 0.5, rng.choice(SHARES, n), rng.random(n))
    kept = (far > 1e-6) & (shares > 1e-9)
    return (taus * (far * shares)[:, None])[kept], 1.0 / shares[kept]


def proven_beyond(vehicle: Vehicle, taus: FloatArray) -> FloatArray:
    """Least h(c) / c'tau over directions c (N,), h by corners: no larger share of tau is attainable."""
    c = zonotope(vehicle).facets / vehicle.wrench_scale
    sets = zip(map(list, vehicle.actuators), vertices(vehicle), strict=True)
    h = sum((c @ vehicle.TP[:, own] @ corners.T).max(axis=1) for own, corners in sets)
    along = taus @ c.T
    least: FloatArray = np.where(along > 0.0, h / np.where(along > 0.0, along, 1.0), np.inf).min(axis=1)
    return least


def off(vehicle: Vehicle, F: FloatArray, taus: FloatArray, tolerance: float) -> BoolArray:
    """Answers (N,) that miss their demand or leave their limits."""
    rows = limit_rows(vehicle)
    missed = np.abs((F @ vehicle.TP.T - taus) / vehicle.wrench_scale).max(axis=1)
    beyond = (F @ rows.A.T - rows.reach).max(axis=1)
    right: BoolArray = (missed <= tolerance) & (beyond <= SPARE * vehicle.f_scale)
    return ~right


def gaps(vehicle: Vehicle, F: FloatArray) -> FloatArray:
    """Duality gaps (N,) of thrusts for the wrench that they make, relative to that of ``f_scale`` [-]."""
    rows, unit, h = limit_rows(vehicle), vehicle.f_scale, np.diag(vehicle.H)
    T, X, reach = vehicle.TP / vehicle.row_lengths[:, None], F / unit, rows.reach / unit
    at = reach - X @ rows.A.T <= NEAR
    found = np.full(len(F), np.inf)
    patterns, which = np.unique(at, axis=0, return_inverse=True)
    for i, pattern in enumerate(patterns):
        members = np.flatnonzero(which == i)
        A = np.hstack([T.T, -rows.A[pattern].T])
        inverse = np.linalg.pinv(A, rcond=1e-10)
        found[members] = _gap(X[members], (X[members] * h) @ inverse.T, A, h, reach[pattern], vehicle.k, T)
        signed = np.hstack([T.T, -T.T, -rows.A[pattern].T])
        for j in members[~(found[members] <= EFFORT)]:
            u = nnls(signed, h * X[j])[0]
            y = np.append(u[: vehicle.k] - u[vehicle.k : 2 * vehicle.k], u[2 * vehicle.k :])
            found[j] = min(found[j], _gap(X[[j]], y[None], A, h, reach[pattern], vehicle.k, T)[0])
    relative: FloatArray = found / h.max()
    return relative


def _gap(
    X: FloatArray, Y: FloatArray, A: FloatArray, h: FloatArray, reach: FloatArray, k: int, T: FloatArray
) -> FloatArray:
    """1/2 x'Hx less the dual value of multipliers Y (N, k + a), without what ROUNDING may be of the terms.

    Multipliers of limits are taken as 0 where they are negative.
    """
    Y = np.hstack([Y[:, :k], np.maximum(Y[:, k:], 0.0)])
    wrench, limits = (X @ T.T) * Y[:, :k], Y[:, k:] * reach
    efforts = 0.5 * np.hstack([X**2 * h, (Y @ A.T) ** 2 / h]).sum(axis=1)
    size = np.abs(wrench).sum(axis=1) + limits.sum(axis=1) + efforts
    gap: FloatArray = efforts - wrench.sum(axis=1) + limits.sum(axis=1) - ROUNDING * size
    return gap


def judge(method: str, vehicle: Vehicle, taus: FloatArray) -> Counter[str]:
    """Counts of answers of a method by what is proven of them."""
    allocate = build(method, vehicle)
    F, status = allocate.many(taus)
    most = proven_beyond(vehicle, taus)
    tolerance = WRENCH_TOLERANCE if method.startswith("qp/") else EXACT_TOLERANCE
    solved, partial = status == Status.SOLVED, status == Status.PARTIAL
    bad = np.zeros(len(taus), dtype=bool)
    bad[solved] = off(vehicle, F[solved], taus[solved], tolerance)
    for i in np.flatnonzero(solved)[~(gaps(vehicle, F[solved]) <= EFFORT)]:
        right = build(SECOND, vehicle)(taus[i]).f
        bad[i] |= not gaps(vehicle, right[None])[0] <= EFFORT
        bad[i] |= not np.abs(F[i] - right).max() <= allocate.tolerance * vehicle.f_scale
    if method == "scaled" and partial.any():
        made, asked = F[partial] @ vehicle.TP.T / vehicle.wrench_scale, taus[partial] / vehicle.wrench_scale
        share = (made * asked).sum(axis=1) / (asked**2).sum(axis=1)
        bad[partial] = off(vehicle, F[partial], share[:, None] * taus[partial], tolerance)
        bad[partial] |= ~(share >= most[partial] * (1.0 - EXACT_TOLERANCE) - EXACT_TOLERANCE)
        # Of a demand that is small beside what thrusters do the wrench tells the share to few digits.
        for i in np.flatnonzero(bad & partial):
            share, size = allocate(taus[i]).share[0], np.abs(taus[i] / vehicle.wrench_scale).max()
            bad[i] = off(vehicle, F[[i]], share * taus[[i]], tolerance)[0]
            bad[i] |= not abs(share - most[i]) * size <= EXACT_TOLERANCE
        bad[np.flatnonzero(partial)[:CERTIFIED]] |= ~(gaps(vehicle, F[partial][:CERTIFIED]) <= EFFORT)
    elif partial.any():  # of a QP solver: less than what was asked for, and it says so
        bad[partial] = False
    infeasible = status == Status.INFEASIBLE
    bad[infeasible] = ~(most[infeasible] < 1.0)
    none = (status == Status.NOT_CONVERGED) | (partial & (method != "scaled"))
    return Counter(
        {
            f"{method} answers": len(taus),
            f"{method} wrong": int(bad.sum()),
            f"{method} gave none": int(none.sum()),
        }
    )


def study(vehicle: Vehicle, seed: int, n: int, lps: int) -> Counter[str]:
    """Counts of one boat: each method's answers, and those that other solvers give otherwise."""
    rng = np.random.default_rng(seed)
    taus, reach = ask(vehicle, rng, n)
    found: Counter[str] = Counter({f"boats with {len(vehicle.azimuths)} azimuths": 1})
    try:
        exact = build("nullspace", vehicle)
        methods = ["nullspace", "scaled"]
    except NotApplicable:
        exact, methods = None, ["qp/daqp"]
        taus, reach = taus[::SPARSE], reach[::SPARSE]
    found[f"boats for {methods[0]}"] += 1
    for method in methods:
        found.update(judge(method, vehicle, taus))
    for tau, far in zip(taus[:lps], reach[:lps], strict=True):
        found["linear programs"] += 1
        found["shares that differ"] += not abs(alpha_max_lp(vehicle, tau) - far) <= AGREE * max(far, 1.0)
        if exact and far > 1.0:
            right = build("qp/daqp", vehicle)(tau)
            found["thrusts of qp/daqp compared"] += right.status is Status.SOLVED
            apart = np.abs(exact(tau).f - right.f).max() > WRENCH_TOLERANCE * vehicle.f_scale
            found["thrusts that differ"] += bool(right.status is Status.SOLVED and apart)
    return found


def ferry(x: float, y: float, force: float, sides: int, other: tuple[float, float]) -> Vehicle:
    """A vessel with two azimuth thrusters in discs, at (x, y) and ``other`` [m]."""
    places = ((x, y), other)
    disc = polygon_corners(force, (-180.0, 180.0), sides)
    columns = [column for a, b in places for column in ((1.0, 0.0, -b), (0.0, 1.0, a))]
    return Vehicle(
        name="ferry",
        dof=AXES,
        T=np.array(columns).T,
        H=np.eye(4),
        f_min=np.full(4, -force),
        f_max=np.full(4, force),
        readiness=np.ones(4),
        slack_weights=np.ones(3),
        azimuths=(Azimuth(0, disc), Azimuth(2, disc)),
        weak_limit=0.0,
    )


def compare_quta(vessels: int, n: int) -> None:
    """Print what quta gives, and how long a call takes, of its README's case and of random ferries."""
    from quta.allocator import (  # type: ignore[import-not-found]  # no dependency of the project
        AllocationError,
        MinimizePowerAllocator,
    )
    from quta.thruster import AzimuthThruster  # type: ignore[import-not-found]  # the same

    rng, counts, ratios = np.random.default_rng(5), Counter[str](), list[float]()
    cases = [(ferry(-20.0, 5.0, 1e4, 32, (-20.0, -5.0)), np.array([[0.0, 500.0, 8000.0]]))]
    for _ in range(vessels):
        made = ferry(rng.uniform(1, 30), 0.0, rng.uniform(50, 5e4), 16, (-rng.uniform(1, 30), 0.0))
        cases.append((made, ask(made, rng, n)[0]))
    for vehicle, taus in cases:
        allocate, other = build("nullspace", vehicle), MinimizePowerAllocator()
        for i in (0, 2):
            place = vehicle.T[2, i + 1], -vehicle.T[2, i]
            sides = len(vehicle.azimuths[0].corners)
            other.add_thruster(AzimuthThruster(place, float(vehicle.f_max[0]), sides))
        for tau in taus:
            start = time.process_time_ns()
            ours = allocate(tau)
            middle = time.process_time_ns()
            try:
                f = other.allocate(tau, relax=False)[0]
            except AllocationError:
                f = None
            ratios.append((time.process_time_ns() - middle) / max(middle - start, 1))
            relaxed = vehicle.T @ other.allocate(tau)[0]
            counts["answers"] += 1
            counts["verdicts that differ"] += (f is None) == ours.found
            if f is not None and ours.found:
                counts["thrusts that differ"] += np.abs(f - ours.f).max() > WRENCH_TOLERANCE * vehicle.f_scale
                lost = np.abs((relaxed - tau) / vehicle.wrench_scale).max()
                counts["missed by more than 1e-6 by default"] += lost > WRENCH_TOLERANCE
        if len(taus) == 1:
            print("README's case:", ours.f.round(6), "quta", np.round(f, 6), "by default", relaxed.round(3))
    print(dict(counts), f"a call of quta takes {np.median(ratios):.1f} of nullspace's (median)")


def main() -> None:
    """Run the study, and print its counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="Boats before this one are passed over.")
    parser.add_argument("--demands", type=int, default=5000)
    parser.add_argument("--lps", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quta", action="store_true")
    given = parser.parse_args()
    if given.quta:
        compare_quta(given.vehicles, given.demands)
        return
    fleet, found = boats(given.vehicles), Counter[str]()
    with ProcessPoolExecutor(given.jobs) as pool:
        asked = [
            pool.submit(study, v, i, given.demands, given.lps)
            for i, v in enumerate(fleet)
            if i >= given.first
        ]
        for i, each in enumerate(asked):
            found.update(each.result())
            if i % 100 == 99:
                print(f"{i + 1} boats", dict(found), flush=True)
    for name in sorted(found):
        print(f"{name}: {found[name]:,}")


if __name__ == "__main__":
    main()
