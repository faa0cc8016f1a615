"""Vehicles as a tape measure finds them: their poses off by a tolerance."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.geometry import DOF, pose_matrix
from alloc.vehicle.weak import Survey, six_rows


def move_poses(vehicle: Vehicle, survey: Survey, rng: np.random.Generator) -> Vehicle:
    """The vehicle with each thrust's line moved: along and turned about each axis, uniformly.

    Lines are those that T says: e and e x m of a column of force e and moment m, [e; m], and the moment e'm
    that a propeller has along its own thrust stays. Rows that T leaves out are those of the vehicle's poses,
    or count as 0.
    """
    whole = six_rows(vehicle.T, vehicle.dof, vehicle.poses)
    e, m = whole[:3].T, whole[3:].T
    turn, moved = rng.uniform(-1.0, 1.0, (2, vehicle.n, 3))
    turned = e + np.cross(np.radians(survey.deg) * turn, e)
    turned *= (np.linalg.norm(e, axis=1) / np.linalg.norm(turned, axis=1))[:, None]
    positions = np.cross(e, m) + 1e-3 * survey.mm * moved
    found = pose_matrix(positions, turned, reaction_torque=np.einsum("ij,ij->i", e, m))
    poses = None if vehicle.poses is None else found
    return replace(vehicle, T=found[[DOF.index(axis) for axis in vehicle.dof]], poses=poses)


def failures(vehicle: Vehicle, most: int) -> list[tuple[int, ...]]:
    """All sets of up to ``most`` thrusters of a vehicle."""
    return [off for m in range(most + 1) for off in combinations(range(vehicle.n), m)]


def fail_thrusters(vehicle: Vehicle, off: tuple[int, ...]) -> Vehicle:
    """The vehicle with those thrusters off."""
    for i in off:
        vehicle = vehicle.with_fault(i)
    return vehicle


def hexarotor(arm: float = 0.3, moment: float = 0.05, limit: float = 10.0) -> Vehicle:
    """Six rotors that push up, turn either way in turn, and reverse; arm and moment of each for 1 N [m]."""
    angle = np.radians(30.0 + 60.0 * np.arange(6))
    positions = arm * np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], axis=1)
    own = moment * np.array([1.0, -1.0] * 3)
    T = pose_matrix(positions, np.tile([0.0, 0.0, -1.0], (6, 1)), reaction_torque=own)
    return Vehicle(
        name="hexarotor",
        dof=DOF[2:],
        T=T[2:],
        H=np.eye(6),
        f_min=np.full(6, -limit),
        f_max=np.full(6, limit),
        readiness=np.ones(6),
        slack_weights=np.full(4, 2000.0),
        source="generated",
    )


def pushable_demands(vehicle: Vehicle, count: int, rng: np.random.Generator) -> FloatArray:
    """Demands (count, k) along what the thrusters push, up to three times as far as they reach [N, N m]."""
    f = rng.uniform(vehicle.f_min, vehicle.f_max, (count, vehicle.n))
    demands: FloatArray = f @ vehicle.TP.T * rng.uniform(0.5, 3.0, (count, 1))
    return demands
