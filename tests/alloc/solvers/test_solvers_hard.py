"""Hard sequences: what each consists of, and that every status on them is true."""

import numpy as np
import pytest

from alloc import Label, Status, Vehicle, alpha_max, build, catalogue, list_vehicles, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE
from alloc.discovery import Entry
from bench.demands import build_demands
from bench.demands.sets import hard

VEHICLES = [load_vehicle(name) for name in list_vehicles()] + [load_vehicle("ukwial").with_fault(1)]
LIMITED = [e for e in catalogue() if not e.missing and e.formulation in ("hard", "soft")]

vehicles = pytest.mark.parametrize("vehicle", VEHICLES, ids=lambda v: v.name)


@vehicles
def test_recovery_alternates_between_what_can_be_met_and_what_cannot(
    vehicle: Vehicle, rng: np.random.Generator
) -> None:
    alpha = alpha_max(vehicle, hard.recovery(vehicle, rng, 40))
    beyond = np.arange(40) // hard.RUN % 2 == 0
    assert ((alpha[beyond] < 1 - 0.9e-5) & (alpha[beyond] > 1 / 1.51)).all()
    assert ((alpha[~beyond] > 1 + 0.9e-5) & (alpha[~beyond] < 1 / 0.49)).all()


@vehicles
def test_dwelling_stays_on_the_edge_in_one_place(vehicle: Vehicle, rng: np.random.Generator) -> None:
    taus = hard.dwell(vehicle, rng, 150)
    np.testing.assert_allclose(alpha_max(vehicle, taus), 1, rtol=2 * hard.JITTER)
    apart = np.abs(np.diff(taus, axis=0) / vehicle.wrench_scale).max(axis=1)
    assert np.flatnonzero(apart > 1e-4).tolist() == [hard.DWELL - 1]


@vehicles
def test_jumps_cross_the_attainable_set_and_stay_inside(vehicle: Vehicle, rng: np.random.Generator) -> None:
    taus = hard.jumps(vehicle, rng, 20)
    assert (alpha_max(vehicle, taus) > 1).all()
    there, back = taus[0::2], taus[1::2]
    assert ((there * back).sum(axis=1) <= 0).all()


@vehicles
def test_a_corner_demand_puts_every_thruster_at_a_limit(vehicle: Vehicle, rng: np.random.Generator) -> None:
    taus = hard.corners(vehicle, rng, 20)
    np.testing.assert_allclose(alpha_max(vehicle, taus), 1, rtol=1e-9)
    F = build("nullspace", vehicle).many(taus * (1 - 1e-9))[0]
    slack = np.minimum(F - vehicle.f_min, vehicle.f_max - F) / vehicle.f_scale
    pushing = np.abs(vehicle.TP).max(axis=0) > 0
    assert slack[:, pushing].max() < 1e-6


@pytest.mark.parametrize("entry", LIMITED, ids=lambda e: e.name)
def test_every_status_on_hard_sequences_is_true(entry: Entry, vehicle: Vehicle) -> None:
    """This is the first hundredth of the full sweep, ``python docs/studies/solvers.py``."""
    demand_set = build_demands("hard", vehicle, seed=3, n=25)
    for start in entry.starts:
        for level in entry.levels:
            F, status = build(entry.name, vehicle, start=start, level=level).many(demand_set.taus)
            answered = np.isfinite(F).all(axis=1)
            assert (answered == np.isin(status, (Status.SOLVED, Status.PARTIAL))).all()
            assert (np.isnan(F).all(axis=1) | answered).all()
            assert ((vehicle.f_min <= F) & (vehicle.f_max >= F))[answered].all()
            missed = np.abs(F @ vehicle.TP.T - demand_set.taus) / vehicle.wrench_scale
            if entry.formulation == "hard":
                assert (missed[status == Status.SOLVED] <= WRENCH_TOLERANCE).all()
                assert not (status[demand_set.labels == Label.INFEASIBLE] == Status.SOLVED).any()
                assert not (status[demand_set.alpha > 1 + 5e-6] == Status.INFEASIBLE).any()
