"""The keys of a vehicle file, and their text as YAML."""

import json
import re
from typing import Any, Literal

import msgspec

from alloc.vehicle.frame import Frame

Numbers = list[float]
Points = dict[str, list[tuple[float, float]]]
Currents = dict[str, float | list[tuple[float, float]]]
"""A power law's numbers by name, or points [command, A] by voltage: YAML has mappings of one kind only."""


class EscKeys(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """An ESC, and the thruster behind it, as a vehicle file has them.

    Attributes
    ----------
    neutral : command of no thrust [µs, or what the range is in]
    range : the least and the largest command
    step : what the wire resolves; left out, 1 where the range has enough of these
    reversed : thrusters, by index or name, whose ESC runs the other way; true for all
    dead_band : neutral sends thrusts below the smallest to neutral; jump to the nearer of the two
    curve : V: [[command, N], …]; or the path of a CSV with columns command, N or kgf, volts; or the name of
        a shipped one. Left out, thrust is linear from neutral to f_min and f_max
    volts : voltage where a call says none [V]
    current : V: [[command, A], …] beside the curve; or ahead, astern [A/N^power] and power of a law; left
        out, the column amps of the curve's CSV, where it has one
    """

    neutral: float
    range: tuple[float, float]
    step: float | None = None
    reversed: bool | list[int | str] = []
    dead_band: Literal["neutral", "jump"] = "neutral"
    curve: str | Points | None = None
    volts: float | None = None
    current: Currents | None = None


class CapKeys(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Cap on what all thrusters draw together: amps or watts.

    Attributes
    ----------
    amps, watts : what the supply gives [A], [W]
    reserve : what everything else draws of it, in the same unit
    """

    amps: float | None = None
    watts: float | None = None
    reserve: float = 0.0


class AutopilotKeys(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The autopilot's mixer, as a vehicle file has it.

    Attributes
    ----------
    ardusub : name of ArduSub's frame, as VECTORED; empty for PX4
    px4 : PX4's CA_METHOD, automatic or pseudoinverse; empty for ArduSub
    airmode : PX4's MC_AIRMODE: 0 off, 1 for roll and pitch, 2 for yaw too; ArduSub alone reads what follows
    motors : the thrusters of motors 1, 2, …, by index or name; left out, in the file's order
    reversed : thrusters, by index or name, whose MOT_n_DIRECTION is -1
    coupling : MOT_FV_CPLNG_K [-]
    gains : by axis, force or moment of input 1; left out, what its factors give on this geometry [N, N m]
    thrust : esc for the curves of ``esc``, or linear; left out, esc where there is one
    """

    ardusub: str = ""
    px4: str = ""
    airmode: int = 0
    motors: list[int | str] = []
    reversed: list[int | str] = []
    coupling: float = 1.0
    gains: dict[str, float] = {}
    thrust: str = ""


class InertiaKeys(msgspec.Struct, forbid_unknown_fields=True):
    """Mass and moments of inertia about the centre of mass, and what the water adds to each axis.

    Attributes
    ----------
    mass : of the vehicle, water inside its hull included [kg]
    moments : about x, y, z [kg m^2]
    added : added mass of surge, sway, heave [kg] and added moments of roll, pitch, yaw [kg m^2]
    """

    mass: float
    moments: tuple[float, float, float]
    added: tuple[float, float, float, float, float, float] = (0.0,) * 6


class Planar(msgspec.Struct, forbid_unknown_fields=True):
    """Thrusters in the horizontal plane, as eq. 3 takes them.

    Attributes
    ----------
    alpha_deg : direction of each thrust from the longitudinal axis [deg]
    d : distance of each thruster from the centre of gravity [m]
    phi_deg : direction from the centre of gravity to each thruster [deg]
    """

    alpha_deg: Numbers
    d: Numbers
    phi_deg: Numbers


class Rates(msgspec.Struct, forbid_unknown_fields=True):
    """Rates of change of thrusts, rise and fall apart.

    Attributes
    ----------
    up, down : one number for all thrusters or one for each [N/s]
    """

    up: float | Numbers
    down: float | Numbers


class SurveyKeys(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Tolerance of a geometry: of poses, or of the entries of T.

    Attributes
    ----------
    mm, deg : of positions along each axis [mm] and of directions about each [deg]
    relative : of each entry of T, relative to the largest of its row [-]
    """

    mm: float | None = None
    deg: float | None = None
    relative: float | None = None


class AzimuthKeys(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Forces that a thruster gives which turns about the axis z, as a vehicle file has them.

    Attributes
    ----------
    max, min : largest and smallest force [N]
    sector_deg : angles of force from x towards y, from and to [deg]
    forbidden_deg : zones that are left out of the sector, each from and to [deg]
    sides : of the polygon that stands for the whole disc
    rate_deg : how fast it turns [deg/s]; None where nothing says
    slew : how fast the size of its force may change [N/s]; None where nothing says
    """

    max: float
    min: float = 0.0
    sector_deg: tuple[float, float] = (-180.0, 180.0)
    forbidden_deg: list[tuple[float, float]] = []
    sides: int = 16
    rate_deg: float | None = None
    slew: float | None = None


MISSING = (0.0, 0.0, 0.0)
"""Direction of a thruster whose file gives none: this very object."""


class Thruster(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """One thruster at a pose.

    Attributes
    ----------
    position : where the thruster sits [m]
    direction : unit vector along which positive thrust pushes the vehicle [-]
    name : what people call it, as ``--fault`` and every table do then
    azimuth : forces of one that turns, in place of a direction
    """

    position: tuple[float, float, float]
    direction: tuple[float, float, float] = MISSING
    name: str = ""
    azimuth: AzimuthKeys | None = None


Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]


class VehicleFile(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The keys of a vehicle file. T, poses (planar or thrusters), or both in agreement give the geometry.

    Attributes
    ----------
    name : label in tables
    dof : controlled degrees of freedom, the rows of T
    f_min, f_max : limits, one number for all thrusters or one for each that does not turn [N]; left out, the
        ends of the curve in ``esc``
    source : where the numbers come from
    planar : poses in the horizontal plane
    T : rows of the (k, n) configuration matrix; force rows [-], moment rows [m]
    thrusters : poses in space
    frame : of everything in the file, and of every demand: frd for x ahead, y to starboard, z down; flu for
        x ahead, y to port, z up; left out, frd
    center_of_mass : point about which the moments of ``thrusters`` are taken [m]
    reaction_torque : moment of each propeller along its own thrust, for 1 N: one number or one for each; T
        has it as a part [m]
    suspect : thrusters, by index or name, whose column of T is taken as published though no thruster can
        make it
    weights : diagonal of H; a file gives this or H [1/N^2]
    H : rows of the (n, n) matrix of eq. 4 [1/N^2]
    slack_weights : (k,) diagonal of Q for the soft formulation
    slew : how fast thrusts may change: one number, one for each thruster, or up (towards f_max) and
        down (towards f_min, as when one spins up astern) apart [N/s]
    volts : limits [f_min, f_max] by the battery's voltage [V], each one number or one for each thruster [N]
    esc : what stands between thrusts and the wire: one for all thrusters or one for each
    priority : the axes in levels, for a demand that can't be met: those of the first level are served first
    groups : the axes in groups, each of which keeps its direction then; left out, those that share thrusters
    names : what people call each thruster, where ``thrusters`` does not say; "" for one without a name
    autopilot : what mixes today
    rank : intended rank of T where it is below k
    survey : how well poses, or T, are known; left out, 3 mm and 0.3 deg, or 1 % where T is no poses'
    cap : on the current or the power of all thrusters together; needs ``current`` in ``esc``
    inertia : mass and moments of inertia, added ones too: readiness from accelerations needs it
    weak : auto, by ``survey``; or sigma / sigma_max up to which methods with a share leave a direction out
    notes : remarks, such as what an import assumed
    """

    name: str
    dof: list[Axis]
    f_min: float | Numbers | None = None
    f_max: float | Numbers | None = None
    source: str = ""
    planar: Planar | None = None
    T: list[Numbers] | None = None
    thrusters: list[Thruster] | None = None
    frame: Frame | None = None
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reaction_torque: float | Numbers | None = None
    suspect: list[int | str] = []
    weights: Numbers | None = None
    H: list[Numbers] | None = None
    slack_weights: Numbers | None = None
    slew: float | Numbers | Rates | None = None
    volts: dict[str, tuple[float | Numbers, float | Numbers]] | None = None
    esc: EscKeys | list[EscKeys] | None = None
    cap: CapKeys | None = None
    inertia: InertiaKeys | None = None
    priority: list[list[Axis]] = []
    groups: list[list[Axis]] = []
    names: list[str] | None = None
    autopilot: AutopilotKeys | None = None
    rank: int | None = None
    survey: SurveyKeys | None = None
    weak: Literal["auto"] | float = "auto"
    notes: list[str] = []


_PLAIN = re.compile(r"[A-Za-z][\w.,/@()+-]*( [\w.,/@()+-]+)*")
_WORDS = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}  # no text in some version of YAML


def to_yaml(keys: VehicleFile) -> str:
    """The text of a vehicle file: one key a line, one thruster or row of a matrix a line."""
    lines = []
    for key, value in msgspec.to_builtins(keys).items():
        if (
            isinstance(value, (list, tuple))
            and value
            and isinstance(value[0], (list, dict, str))
            and key != "dof"
        ):
            lines.append(f"{key}:")
            lines += [f"  - {_flow(entry)}" for entry in value]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, str):
        plain = _PLAIN.fullmatch(value) and value.lower() not in _WORDS
        return value if plain else json.dumps(value, ensure_ascii=False)
    if isinstance(value, float) and value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return repr(value)
