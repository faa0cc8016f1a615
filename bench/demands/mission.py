"""Mission: stationkeeping, waypoint steps and a current, with a thruster failing half way.

The sets ``mission`` and ``mission-fault`` are its two halves. All vehicles fly one body, a BlueROV2 Heavy by
Fossen's equations of motion: on each axis a wrench counts as the share of what the vehicle can reach. So
every vehicle has the BlueROV2's acceleration and speed at full thrust, and the same seed gives all of them
the same kind of minute. Degrees of freedom that a vehicle does not control are held at zero, so a planar
vehicle stays in its plane.

    M v' + C(v) v + (D + Dq |v|) v + g(eta) = tau        (Fossen 2021, ch. 8; v relative to the water)

Parameters: von Benzon et al. 2022, "An Open-Source Benchmark Simulator: Control of a BlueROV2
Underwater Robot", J. Mar. Sci. Eng. 10(12), 1898, Table A1. Its centre of mass is the origin.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from alloc import Vehicle, alpha_max, load_vehicle
from alloc.allocation import WRENCH_TOLERANCE, BoolArray, FloatArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.vehicle.frame import signs
from alloc.vehicle.geometry import DOF
from bench.demands.strong import axis_maxima, strong_demands, strong_vehicle

MASS = 13.5
"""[kg]"""
WEIGHT = MASS * 9.82
BUOYANCY = 1000.0 * 9.82 * 0.0134
"""Density, gravity and volume of the source; 1 N less than the weight [N]."""
BUOYANCY_Z = -0.01
"""z of the centre of buoyancy, which lies above the centre of mass [m]."""

INERTIA = np.array([MASS, MASS, MASS, 0.26, 0.23, 0.37])
"""(6,) rigid body [kg, kg m^2]."""
ADDED = np.array([6.36, 7.12, 18.68, 0.189, 0.135, 0.222])
"""(6,) added mass [kg, kg m^2]."""
M = INERTIA + ADDED
LINEAR = np.array([13.7, 0.0, 33.0, 0.0, 0.8, 0.0])
"""(6,) linear damping [N s/m, N m s]."""
QUADRATIC = np.array([141.0, 217.0, 190.0, 1.19, 0.47, 1.5])
"""(6,) quadratic damping [N s^2/m^2, N m s^2]."""


def resistance(v: FloatArray, masses: FloatArray = M) -> FloatArray:
    """C(v) v + (D + Dq |v|) v of a velocity (6,) relative to the water [N, N m].

    M = diag(``masses``), so C(v) v takes Kirchhoff's form: w x (M1 u); w x (M2 w) + u x (M1 u).
    """
    u, w = v[:3], v[3:]
    momentum, spin = masses[:3] * u, masses[3:] * w
    turning = np.concatenate([cross(w, momentum), cross(w, spin) + cross(u, momentum)])
    total: FloatArray = turning + (LINEAR + QUADRATIC * np.abs(v)) * v
    return total


def restoring(attitude: FloatArray) -> FloatArray:
    """g(eta) (6,) of roll, pitch, yaw (3,) [rad]: weight and buoyancy [N, N m] (Fossen 2021, eq. 4.6)."""
    roll, pitch, _ = attitude
    excess, lever = WEIGHT - BUOYANCY, -BUOYANCY_Z * BUOYANCY
    sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    return np.array([excess * sp, -excess * cp * sr, -excess * cp * cr, lever * cp * sr, lever * sp, 0.0])


def rotation(attitude: FloatArray) -> FloatArray:
    """(3, 3) from body to earth axes, for roll, pitch, yaw (3,) [rad] (Fossen 2021, eq. 2.31)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(attitude), np.cos(attitude)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def euler_rates(attitude: FloatArray, w: FloatArray) -> FloatArray:
    """Rates of roll, pitch, yaw (3,) [rad/s] for a body rate w (3,) (Fossen 2021, eq. 2.41)."""
    sr, cr, tp, cp = np.sin(attitude[0]), np.cos(attitude[0]), np.tan(attitude[1]), np.cos(attitude[1])
    across = sr * w[1] + cr * w[2]
    return np.array([w[0] + tp * across, cr * w[1] - sr * w[2], across / cp])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """a x b of two vectors (3,); it takes a tenth of the time of numpy's."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


RATE_HZ = 100.0
HALF = 3000
"""Demands before the failure, and after the failure: 30 s each."""
STEPS = (500, 1200, 1900, 3600, 4400, 5200)
"""Demands at which a new waypoint is given: 5, 12, 19, 36, 44 and 52 s. In between the vehicle arrives and
keeps station; the thruster fails at 30 s, while the vehicle keeps station."""

POSITION_STEP = 3.0
"""Farthest that the next waypoint lies on each axis: some body lengths [m]."""
TURN_STEP = np.radians([10.0, 10.0, 90.0])
"""Largest steps of roll and pitch, which are trimmed a little, and of yaw, up to a quarter turn [rad]."""

CURRENT = 0.3
"""Mean horizontal current; the vehicle makes about 0.9 m/s at full thrust [m/s]."""
GUST, GUST_S = 0.1, 10.0
"""Spread [m/s] and time constant [s] of the current's variation, first-order Gauss-Markov (Fossen 2021,
ch. 10)."""
NOISE = 0.005
"""Spread of the measured velocities: that of a Doppler log and a MEMS gyro [m/s, rad/s]."""

STIFFNESS = np.array([2.0, 2.0, 2.0, 4.0, 4.0, 3.0])
"""Natural frequency that the controller gives each axis [rad/s]; attitude is quicker than position. A step
of 2 m asks for all that surge can give, stationkeeping for a tenth to a third of that."""
DAMPING = 0.9
INTEGRAL = 0.1
"""Share of the stiffness that is integrated [1/s]: slow enough not to upset the damping."""


@dataclass(frozen=True, eq=False)
class Flight:
    """Record of a flown mission.

    Attributes
    ----------
    taus : (N, k) demands [N, N m]
    poses : (N, 6) x, y, z, roll, pitch, yaw [m, rad]
    setpoints : (N, 6) where the vehicle should be, in the same terms
    """

    taus: FloatArray
    poses: FloatArray
    setpoints: FloatArray


class Surroundings(NamedTuple):
    """Surroundings of N demands.

    Attributes
    ----------
    setpoints : (N, 6) where the vehicle should be, in earth axes [m, rad]
    current : (N, 3) in earth axes [m/s]
    noise : (N, 6) of the measured velocities [m/s, rad/s]
    """

    setpoints: FloatArray
    current: FloatArray
    noise: FloatArray


Act = Callable[[FloatArray], FloatArray]
"""A function of the autopilot's demand (k,) that returns the wrench (k,) that acts [N, N m]."""


def fly(
    vehicle: Vehicle,
    degraded: Vehicle,
    rng: np.random.Generator,
    n: int = 2 * HALF,
    failure: int = HALF,
    act: tuple[Act, Act] | None = None,
) -> Flight:
    """Simulate the first n demands of the mission; the same for the same generator state.

    Parameters
    ----------
    vehicle, degraded : what answers before and after ``failure`` demands
    rng : of setpoints, current and noise
    n : number of demands
    failure : the demand from which ``degraded`` answers
    act : what acts before and after the failure; None is ``largest_share``, which favours no method

    The autopilot limits each axis to what that axis reaches alone, as autopilots do, so its demands are
    often infeasible. Raises NotApplicable where zero thrust is forbidden.
    """
    before, after = act or (largest_share(vehicle), largest_share(degraded))
    surroundings = _surroundings(rng, np.isin(DOF, vehicle.dof))
    acts = [before] * min(failure, n) + [after] * (n - failure)
    return follow(vehicle, surroundings, acts, newtons_of_the_body(vehicle))


def move(vehicle: Vehicle, axis: str, metres: float, n: int, act: Act) -> Flight:
    """Simulate n demands of a move along one axis, from rest, in still water.

    A newton of the vehicle is one on the body here: shares of what axes reach would enlarge what a move along
    one axis makes on another. The body has the vehicle's ``inertia`` where its file says one; damping, weight
    and buoyancy are the BlueROV2 Heavy's.
    """
    still = Surroundings(np.zeros((n, 6)), np.zeros((n, 3)), np.zeros((n, 6)))
    still.setpoints[:, DOF.index(axis)] = metres
    masses = M if vehicle.inertia is None else vehicle.inertia
    return follow(vehicle, still, [act] * n, ways_of_the_body(vehicle), masses)


def follow(
    vehicle: Vehicle,
    surroundings: Surroundings,
    acts: Sequence[Act],
    per_newton: FloatArray,
    masses: FloatArray = M,
) -> Flight:
    """Simulate the body and its autopilot from rest at the origin.

    ``acts`` has what acts at each demand in turn; ``per_newton`` (k,) is the wrench on the body for 1 N or
    1 N m on each axis of the vehicle; ``masses`` (6,) the body's, with what the water adds [kg, kg m^2].
    """
    axes = [DOF.index(axis) for axis in vehicle.dof]
    free = np.isin(np.arange(6), axes)
    backward, forward = axis_maxima(vehicle)
    setpoints, current, noise = surroundings
    n = len(acts)
    taus, poses = np.empty((n, vehicle.k)), np.empty((n, 6))
    pose, v, integral = np.zeros(6), np.zeros(6), np.zeros(6)
    for i, act in enumerate(acts):
        R, g = rotation(pose[3:]), restoring(pose[3:])
        error = setpoints[i] - pose
        error[3:] = (error[3:] + np.pi) % (2 * np.pi) - np.pi
        error[:3] = R.T @ error[:3]
        wish = masses * STIFFNESS * (STIFFNESS * (error + integral) - 2 * DAMPING * (v + noise[i])) + g
        tau = np.clip(wish[axes] / per_newton, backward, forward)
        taus[i], poses[i] = tau, pose
        acting = act(tau)
        wrench = np.zeros(6)
        wrench[axes] = acting * per_newton
        # Anti-windup: no integration while the thrusters saturate.
        if (np.abs(acting - tau) <= WRENCH_TOLERANCE * vehicle.wrench_scale).all():
            integral += INTEGRAL * error / RATE_HZ
        relative = v.copy()
        relative[:3] -= R.T @ current[i]
        v = v + free * (wrench - resistance(relative, masses) - g) / masses / RATE_HZ
        pose = pose + free * np.concatenate([R @ v[:3], euler_rates(pose[3:], v[3:])]) / RATE_HZ
    return Flight(taus, poses, setpoints[:n])


def largest_share(vehicle: Vehicle) -> Act:
    """The largest attainable share of a demand (``alloc.alpha_max``), or of its part that can be reached."""
    vehicle = strong_vehicle(vehicle)
    reachable = vehicle.TP @ generalized_inverse(vehicle) if vehicle.rank < vehicle.k else np.eye(vehicle.k)

    def act(tau: FloatArray) -> FloatArray:
        acting: FloatArray = reachable @ tau
        return min(1.0, max(0.0, float(alpha_max(vehicle, acting[None])[0]))) * acting

    return act


def under_way(
    vehicle: Vehicle,
    rng: np.random.Generator,
    n: int,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
) -> FloatArray:
    """n consecutive demands (n, k) [N, N m] of the first half, from ``interesting_start``."""
    taus = fly(vehicle, vehicle, rng, HALF).taus
    start = interesting_start(vehicle, taus, n, f_min, f_max)
    return taus[start : start + n]


def interesting_start(
    vehicle: Vehicle,
    taus: FloatArray,
    n: int,
    f_min: FloatArray | None = None,
    f_max: FloatArray | None = None,
) -> int:
    """First of n demands of the first half, all of whose demands are ``taus``.

    Fewer than all are half before, half after the moment at which the vehicle, after its first waypoint, can
    do what is asked again, within f_min and f_max (n,) [N] if given: all of one kind would say little.
    """
    asked = strong_demands(vehicle, taus[STEPS[0] :])
    able = np.flatnonzero(alpha_max(strong_vehicle(vehicle), asked, f_min, f_max) >= 1)
    middle = STEPS[0] + (int(able[0]) if able.size else 0)
    return max(0, min(middle - n // 2, HALF - n))


def newtons_of_the_body(vehicle: Vehicle) -> FloatArray:
    """(k,) wrench on the body for 1 N or N m on each axis of the vehicle: the body's reach over its own.

    The body is in frd, so it is negative for the axes that a vehicle in flu has the other way round.
    """
    heavy = load_vehicle("bluerov2-heavy")
    reach = dict(zip(heavy.dof, _reach(heavy), strict=True))
    shares = np.array([reach[axis] for axis in vehicle.dof]) / _reach(vehicle)
    per_newton: FloatArray = ways_of_the_body(vehicle) * shares
    return per_newton


def ways_of_the_body(vehicle: Vehicle) -> FloatArray:
    """(k,) 1, or -1 where an axis of the vehicle points against the body's."""
    ways: FloatArray = signs(vehicle.dof) if vehicle.frame == "flu" else np.ones(vehicle.k)
    return ways


def _reach(vehicle: Vehicle) -> FloatArray:
    backward, forward = axis_maxima(vehicle)
    reach: FloatArray = (forward - backward) / 2
    # An axis that can't be pushed alone still needs a scale.
    return np.where(reach > 0, reach, vehicle.wrench_scale)


def _surroundings(rng: np.random.Generator, free: BoolArray) -> Surroundings:
    """The whole mission's, 2 HALF demands."""
    n = 2 * HALF
    setpoints = np.zeros((n, 6))
    for start in STEPS:
        setpoints[start:, :3] += rng.uniform(-POSITION_STEP, POSITION_STEP, 3)
        setpoints[start:, 3:] = rng.uniform(-1.0, 1.0, 3) * TURN_STEP
    heading = rng.uniform(-np.pi, np.pi)
    keep = np.exp(-1.0 / (GUST_S * RATE_HZ))
    gusts = rng.normal(size=(n, 3)) * GUST * np.sqrt(1 - keep**2)
    for i in range(1, n):
        gusts[i] += keep * gusts[i - 1]
    current = gusts + CURRENT * np.array([np.cos(heading), np.sin(heading), 0.0])
    return Surroundings(setpoints * free, current, rng.normal(size=(n, 6)) * NOISE)
