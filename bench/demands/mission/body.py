"""Fossen's equations of motion for a BlueROV2 Heavy, in SI units, all six degrees of freedom.

    M v' + C(v) v + (D + Dq |v|) v + g(eta) = tau        (Fossen 2021, ch. 8; v relative to the water)

Parameters: von Benzon et al. 2022, "An Open-Source Benchmark Simulator: Control of a BlueROV2
Underwater Robot", J. Mar. Sci. Eng. 10(12), 1898, Table A1. Its centre of mass is the origin.
"""

import numpy as np

from alloc.allocation import FloatArray

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


def resistance(v: FloatArray) -> FloatArray:
    """C(v) v + (D + Dq |v|) v of a velocity (6,) relative to the water [N, N m].

    M is diagonal, so C(v) v takes Kirchhoff's form: w x (M1 u); w x (M2 w) + u x (M1 u).
    """
    u, w = v[:3], v[3:]
    momentum, spin = M[:3] * u, M[3:] * w
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
