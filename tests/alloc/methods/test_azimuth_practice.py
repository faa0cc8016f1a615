"""clip and redistribute on thrusters that turn, held against their definitions, thruster by thruster."""

import numpy as np
import pytest

from alloc import Status, Vehicle, build, load_vehicle
from alloc.reach.zonotope import vertices
from tests.azimuths import boats, demands_around, excess

BOATS = boats(32)
METHODS = ("clip", "redistribute")


def nearest(corners: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Point of a set with those corners (v, c), in order, that is nearest to f (c,)."""
    if corners.shape[1] == 1:
        return f.clip(corners.min(), corners.max())
    if len(corners) == 1:
        return corners[0]
    best, inside = corners[0], True
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = b - a
        inside &= bool(along[0] * (f - a)[1] - along[1] * (f - a)[0] >= 0.0)
        foot = a + along * min(max((f - a) @ along / (along @ along), 0.0), 1.0)
        best = foot if np.linalg.norm(foot - f) < np.linalg.norm(best - f) else best
    return f if inside else best


def least_effort(vehicle: Vehicle, on: list[int], rest: np.ndarray) -> np.ndarray:
    """Least f'Hf of thrusts ``on`` alone among those nearest to a wrench, by square roots of weights."""
    f, roots = np.zeros(vehicle.n), np.sqrt(np.diag(vehicle.H))[on]
    A = (vehicle.TP / vehicle.row_lengths[:, None])[:, on]
    f[on] = np.linalg.pinv(A / roots, rcond=1e-10) @ (rest / vehicle.row_lengths) / roots
    return f


def by_definition(vehicle: Vehicle, tau: np.ndarray, again: bool) -> np.ndarray:
    """T* tau, each force to its set's nearest; with ``again`` the others share what is left, in passes."""
    sets, parts = vertices(vehicle), [list(part) for part in vehicle.actuators]
    free, frozen = [i for i in range(len(parts)) if vehicle.readiness[parts[i][0]]], np.zeros(vehicle.n)
    f = least_effort(vehicle, [c for i in free for c in parts[i]], tau)
    while again and free:
        beyond = [i for i in free if np.linalg.norm(nearest(sets[i], f[parts[i]]) - f[parts[i]]) > 1e-7]
        if not beyond:
            break
        for i in beyond:
            frozen[parts[i]] = nearest(sets[i], f[parts[i]])
            free.remove(i)
        on = [c for i in free for c in parts[i]]
        f = frozen + (least_effort(vehicle, on, tau - vehicle.TP @ frozen) if on else 0.0)
    for part, own in zip(parts, sets, strict=True):
        f[part] = nearest(own, f[part])
    return f


@pytest.mark.parametrize("method", METHODS)
def test_forces_go_straight_to_their_polygons_as_the_rule_says(method: str) -> None:
    rng, met = np.random.default_rng(21), 0
    failed = [boat.with_fault(0) for boat in BOATS if boat.with_fault(0).rank == 3]
    assert len(failed) > 10
    for vehicle in BOATS + failed:
        allocate, inverse = build(method, vehicle), build("pinv", vehicle)
        for tau in demands_around(vehicle, rng, 6) * rng.choice([0.05, 0.3, 1.0], (6, 1)):
            result = allocate(tau)
            right = by_definition(vehicle, tau, method == "redistribute")
            assert result.f == pytest.approx(right, abs=1e-6 * vehicle.f_scale), (vehicle.name, tau)
            assert excess(vehicle, result.f) <= 1e-14
            miss = np.abs((vehicle.TP @ result.f - tau) / vehicle.wrench_scale).max()
            assert (result.status is Status.SOLVED) == (miss <= 1e-9)
            assert result.status in (Status.SOLVED, Status.PARTIAL)
            if excess(vehicle, f := inverse(tau).f) <= 0.0:
                assert (result.f == f).all()
                met += 1
    assert met > 30


def test_redistribute_meets_what_clip_misses() -> None:
    """A demand beyond the bow's disc that the stern can take over: surge, which both push alike."""
    ferry = load_vehicle("double-ended-ferry")
    tau = [600.0, 600.0, 700.0]
    clipped, shared = (ferry.T @ build(method, ferry)(tau).f for method in METHODS)
    assert clipped[0] < 552.0
    assert shared[0] == pytest.approx(600.0)


@pytest.mark.parametrize("method", METHODS)
def test_many_give_the_answers_of_single_calls(method: str) -> None:
    rng = np.random.default_rng(22)
    for vehicle in BOATS[:8]:
        allocate, taus = build(method, vehicle), demands_around(vehicle, rng, 5)
        F, status = allocate.many(taus)
        for tau, f, given in zip(taus, F, status, strict=True):
            single = allocate(tau)
            assert (single.f == f).all()
            assert single.status == given
