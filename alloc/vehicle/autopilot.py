"""ArduSub's frames as tables of factors, a vehicle's frame, motors and directions, and PX4's coefficients.

Facts read in libraries/AP_Motors/AP_Motors6DOF.cpp. Of releases, whose tags were out of reach, in copies that
name one: ArduSub 4.1.2 (Blue-Atlas-Robotics/ardupilot 19f03f008ff3, with a version.h of 4.1.2), 4.5.2-beta1
(jijinck-eyerov/Ardusub_4.5 038609f69ccf), and angelw-lab/ardupilot-4.7-beta 490dfd35789f, whose VECTORED_6DOF
asks for less throttle at the surface. All have three output functions with the equations that are here, and a
pulse linear in the output but for 4.1.2's copy, as ArduPilot/ardupilot 0fd5fbf258e8 has it. Factors are alike
but for SIMPLEROV: 0fd5fbf258e8 and 4.1.2 give its frames the same five motors, and motors 3 and 4 no roll;
the copies of 4.5.2 and 4.7 have frames of their own in place of the last two. Release notes of 4.5.2 and
4.5.3 (ReleaseNotes.txt, ArduPilot/ardupilot 007ad99f781c) name no change of the mixer. Merged into one,
the functions are in Williangalvani/ardupilot 0899be29b0e3 (ArduPilot's pull request 34182, open in September
2026), from which the factors are; ES-Alexander/ardupilot 2bc5faab9b1c has the same with the three apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from alloc.allocation import FloatArray
from alloc.errors import VehicleError, unknown
from alloc.vehicle.geometry import DOF
from alloc.vehicle.names import thruster_index

Factors = tuple[tuple[float, ...], ...]

_LEVEL: Factors = (
    (-1, 1, 0, 0, 0, 1),
    (-1, -1, 0, 0, 0, -1),
    (1, 1, 0, 0, 0, -1),
    (1, -1, 0, 0, 0, 1),
)
"""Four thrusters at the corners, across the diagonals: the first half of both vectored frames."""
_SIMPLE: Factors = (
    (1, 0, 0, 0, 0, -1),
    (1, 0, 0, 0, 0, 1),
    (0, 0, -1, 1, 0, 0),
    (0, 0, -1, -1, 0, 0),
    (0, 1, 0, 0, 0, 0),
)
FRAMES: Mapping[str, Factors] = {
    "BLUEROV1": (
        (1, 0, 0, 0, 0, -1),
        (1, 0, 0, 0, 0, 1),
        (0, 0, 0.45, -0.5, 0.5, 0),
        (0, 0, 0.45, 0.5, 0.5, 0),
        (0, 0, 1, 0, -1, 0),
        (0, 1, 0, -0.25, 0, 0),
    ),
    "VECTORED": (*_LEVEL, (0, 0, -1, 1, 0, 0), (0, 0, -1, -1, 0, 0)),
    "VECTORED_6DOF": (
        *_LEVEL,
        (0, 0, -1, 1, -1, 0),
        (0, 0, -1, -1, -1, 0),
        (0, 0, -1, 1, 1, 0),
        (0, 0, -1, -1, 1, 0),
    ),
    "VECTORED_6DOF_90DEG": (
        (0, 0, 1, 1, 1, 0),
        (1, 0, 0, 0, 0, 1),
        (0, 0, 1, 1, -1, 0),
        (0, 1, 0, 0, 0, 0),
        (0, 1, 0, 0, 0, 0),
        (0, 0, 1, -1, 1, 0),
        (1, 0, 0, 0, 0, -1),
        (0, 0, 1, -1, -1, 0),
    ),
    "SIMPLEROV_3": (*_SIMPLE[:2], (0, 0, -1, 0, 0, 0)),
    "SIMPLEROV_4": _SIMPLE[:4],
    "SIMPLEROV_5": _SIMPLE,
}
"""Factors of each frame, one row a motor from 1 [-]: forward (ahead), lateral (to starboard), throttle (up),
roll (starboard side down), pitch (bow up), yaw (bow to starboard). The firmware gives SIMPLEROV_4 a fifth
motor."""

PX4_FRAMES: Mapping[str, str] = {"automatic": "PX4", "pseudoinverse": "PX4 pseudoinverse"}
"""Stand-ins for a frame's name where PX4 mixes, by its CA_METHOD: it computes factors from positions."""

AIRMODES = (0, 1, 2)
"""Values of MC_AIRMODE: heave may not grow to keep an axis, may for roll and pitch, may for yaw too."""

SENSE: Mapping[str, tuple[float, ...]] = {"frd": (1, 1, -1, 1, 1, 1), "flu": (1, -1, 1, 1, -1, -1)}
"""Signs of ArduSub's six inputs, in the order of DOF, along the axes of each body frame."""

LARGEST_CT = 100.0
"""Largest CA_ROTORn_CT that PX4's module.yaml of its control allocator takes."""


@dataclass(frozen=True, eq=False)
class Autopilot:
    """ArduSub or PX4 on a vehicle of n thrusters.

    Attributes
    ----------
    frame : name of its table, one of FRAMES; of PX4 one of PX4_FRAMES
    motors : (n,) number of each thruster's motor, from 1
    directions : (n,) MOT_n_DIRECTION of each thruster's motor, 1 or -1
    coupling : MOT_FV_CPLNG_K [-]
    gains : by axis, force or moment that input 1 stands for [N, N m]; that of the geometry where it has none
    airmode : MC_AIRMODE of PX4, one of AIRMODES
    thrust : (2, n) thrust at outputs -1 and 1 [N], of all thrusters: the autopilot knows of no failure
    curve : whether ArduSub's outputs push through the curves of the vehicle's ``esc``, else linearly
    """

    frame: str
    motors: tuple[int, ...]
    directions: tuple[int, ...]
    thrust: FloatArray
    coupling: float = 1.0
    gains: Mapping[str, float] = field(default_factory=dict)
    airmode: int = 0
    curve: bool = False

    @property
    def method(self) -> str:
        """Name of the method that mixes as it does."""
        return "ardusub" if self.frame in FRAMES else "px4"

    @property
    def factors(self) -> FloatArray:
        """(n, 6) ArduSub's output of each thruster for each input, columns as DOF, with directions [-]."""
        rows = np.array(FRAMES[self.frame])[np.array(self.motors) - 1]
        signed: FloatArray = np.array(self.directions)[:, None] * rows + 0.0
        return signed


def px4_coefficients(f_max: FloatArray) -> tuple[FloatArray, float]:
    """CA_ROTORn_CT of thrusters (n,), and the thrust of CT 1 [N], above 1 where PX4's range asks for it."""
    unit = max(1.0, float(f_max.max()) / LARGEST_CT)
    return f_max / unit, unit


def mixer_frame(ardusub: str, px4: str) -> str:
    """The frame that a file names, or what stands for one of PX4; raises VehicleError."""
    if bool(ardusub) == bool(px4):
        both = "both" if px4 else "neither"
        raise VehicleError(f"autopilot: got {both} of ardusub and px4, expected one of them", "autopilot")
    if px4 and px4 not in PX4_FRAMES:
        raise VehicleError(f"autopilot: {unknown('CA_METHOD', px4, PX4_FRAMES)}", "autopilot")
    return PX4_FRAMES[px4] if px4 else ardusub


def frame_named(name: str, n: int) -> str:
    """The frame of that name in FRAMES; raises VehicleError unless it is there and has n motors."""
    if name not in FRAMES:
        raise VehicleError(f"autopilot: {unknown('frame', name, FRAMES)}", "autopilot")
    if (motors := len(FRAMES[name])) != n:
        fitting = ", ".join(other for other, rows in FRAMES.items() if len(rows) == n)
        hint = f"frames with {n}: {fitting}" if fitting else f"no frame has {n}"
        raise VehicleError(
            f"autopilot: {name} has {motors} motors, the vehicle {n} thrusters; {hint}", "autopilot"
        )
    return name


def thrust_by_curve(mixer: Autopilot, thrust: str, has_esc: bool) -> bool:
    """Return True if outputs push through ``esc``, by key ``thrust`` of a file; raises VehicleError."""
    if thrust not in ("", "esc", "linear"):
        raise VehicleError(f"autopilot: {unknown('thrust', thrust, ('esc', 'linear'))}", "autopilot")
    if thrust == "esc" and not has_esc:
        raise VehicleError("autopilot: thrust is esc, and the file has no 'esc'; add it", "autopilot")
    if thrust and mixer.method != "ardusub":
        raise VehicleError("autopilot: ardusub alone reads thrust; leave it out", "autopilot")
    return has_esc and thrust != "linear" and mixer.method == "ardusub"


def make_autopilot(
    frame: str,
    limits: tuple[FloatArray, FloatArray],
    names: Sequence[str] = (),
    motors: Sequence[int | str] = (),
    reverse: Sequence[int | str] = (),
    coupling: float = 1.0,
    gains: Mapping[str, float] | None = None,
    airmode: int = 0,
) -> Autopilot:
    """The autopilot of a vehicle with these f_min and f_max (n,) [N]; raises VehicleError.

    Parameters
    ----------
    frame : its name, as ``mixer_frame`` has it
    names : of the thrusters
    motors : the thrusters of motors 1, 2, …, by index or name; left out, in the file's order
    reverse : the thrusters, by index or name, whose MOT_n_DIRECTION is -1
    coupling : MOT_FV_CPLNG_K [-]
    gains : by axis, force or moment of input 1 [N, N m]
    airmode : MC_AIRMODE of PX4
    """
    low, high = limits
    n = len(low)
    if frame not in PX4_FRAMES.values():
        frame_named(frame, n)
    elif len(motors) not in (0, n):
        raise VehicleError(
            f"autopilot: {frame} has {len(motors)} motors, the vehicle {n} thrusters", "autopilot"
        )
    try:
        order = [thruster_index(one, names, n, "motors") for one in motors] or list(range(n))
        turned = {thruster_index(one, names, n, "reversed") for one in reverse}
    except (VehicleError, LookupError) as error:
        raise VehicleError(f"autopilot: {error}", "autopilot") from None
    if sorted(order) != list(range(n)):
        raise VehicleError(
            f"autopilot: motors names {len(set(order))} of {n} thrusters; name each once, motor 1's first",
            "autopilot",
        )
    if not 0.0 <= coupling < np.inf:
        raise VehicleError(f"autopilot: coupling is {coupling:g}; give 0 to 1.5", "autopilot")
    for axis, gain in (gains or {}).items():
        if axis not in DOF or not 0.0 < gain < np.inf:
            raise VehicleError(
                f"autopilot: gains: got {axis!s:.40}: {gain:g}, expected an axis and a number above 0",
                "autopilot",
            )
    if airmode not in AIRMODES or (airmode and frame != PX4_FRAMES["automatic"]):
        reads = "give 0, 1 or 2" if airmode not in AIRMODES else "px4: automatic alone reads it; leave it out"
        raise VehicleError(f"autopilot: airmode is {airmode}; {reads}", "autopilot")
    thrust = np.array([np.minimum(low, 0.0), np.maximum(high, 0.0)])
    thrust.setflags(write=False)
    return Autopilot(
        frame=frame,
        motors=tuple(order.index(i) + 1 for i in range(n)),
        directions=tuple(-1 if i in turned else 1 for i in range(n)),
        thrust=thrust,
        coupling=float(coupling),
        gains=dict(gains or {}),
        airmode=airmode,
    )
