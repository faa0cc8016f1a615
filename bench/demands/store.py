"""Stores a vehicle and demands on it as arrays in an .npz file, which a parent hands to a worker."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from alloc import Vehicle
from alloc.allocation import FloatArray
from alloc.vehicle.autopilot import Autopilot
from alloc.vehicle.azimuth import Azimuth
from alloc.vehicle.checks import ARRAYS
from alloc.vehicle.current import Cap, Current, CurrentTable, PowerLaw
from alloc.vehicle.esc import Esc
from alloc.vehicle.geometry import DOF
from alloc.vehicle.limits import Slew, VoltageTable
from alloc.vehicle.pieces import join
from alloc.vehicle.weak import Survey
from bench.demands import NO_SUPPLY, DemandSet, Supply

ESC = tuple(field.name for field in fields(Esc) if field.name != "current")
MIXER = ("frame", "motors", "directions", "thrust", "coupling", "curve")
LEVELS = ("priority", "groups")
HARD = ("hard_labels", "hard_alpha")
KNOWN = ("units", "poses", "inertia")
"""Arrays of a vehicle that may be missing."""


def pack_vehicle(vehicle: Vehicle, *, currents: bool = True) -> dict[str, NDArray[Any]]:
    """The arrays that a vehicle is made of, without its currents and its cap where nobody needs them."""
    names = np.array([vehicle.name, vehicle.source, vehicle.whole, vehicle.frame])
    arrays = {"vehicle": names, "dof": np.array(vehicle.dof), "thrusters": np.array(vehicle.names, dtype=str)}
    arrays |= {k: getattr(vehicle, k) for k in ARRAYS}
    for key in LEVELS:
        arrays[key] = np.array([",".join(level) for level in getattr(vehicle, key)], dtype=str)
    survey = vehicle.survey
    arrays["survey"] = np.array(
        [survey.mm, survey.deg, survey.relative, vehicle.weak_limit], dtype=np.float64
    )
    arrays |= {key: value for key in KNOWN if (value := getattr(vehicle, key)) is not None}
    arrays |= _azimuth_arrays(vehicle)
    if vehicle.slew is not None:
        arrays |= {"slew up": vehicle.slew.up, "slew down": vehicle.slew.down}
    if (table := vehicle.by_volts) is not None:
        arrays |= {"volts": table.volts, "volts f_min": table.f_min, "volts f_max": table.f_max}
    if (mixer := vehicle.autopilot) is not None:
        arrays |= {f"autopilot {key}": np.array(getattr(mixer, key)) for key in MIXER}
        arrays["autopilot airmode"] = np.array(mixer.airmode)
        arrays["autopilot gains"] = np.array([mixer.gains.get(axis, np.nan) for axis in DOF])
    for i, esc in enumerate(kinds := tuple(dict.fromkeys(vehicle.esc))):
        arrays |= {f"esc {i} {key}": np.array(getattr(esc, key)) for key in ESC}
        parts = _current_arrays(esc.current) if currents else {}
        arrays |= {f"esc {i} {key}": part for key, part in parts.items()}
    if kinds:
        arrays["esc"] = np.array([kinds.index(esc) for esc in vehicle.esc])
    if currents and (cap := vehicle.cap) is not None:
        volts = np.nan if cap.volts is None else cap.volts
        arrays["cap"] = np.array([cap.most, cap.reserve, cap.of_power, volts], dtype=np.float64)
    return arrays


def unpack_vehicle(arrays: Mapping[str, NDArray[Any]]) -> Vehicle:
    """The vehicle made of what ``pack_vehicle`` returned."""
    name, source, whole, *frame = map(str, arrays["vehicle"])
    numbers: dict[str, Any] = {key: arrays[key] for key in ARRAYS}
    if "survey" in arrays:  # logs of boards before it have none
        mm, deg, *known = arrays["survey"].tolist()
        relative, weak = (None if np.isnan(each) else each for each in known)
        numbers |= {"survey": Survey(mm, deg, relative), "weak_limit": weak}
        numbers |= {key: arrays.get(key) for key in KNOWN}
    if "azimuths" in arrays:
        places = enumerate(arrays["azimuths"].tolist())
        numbers["azimuths"] = tuple(_azimuth(first, arrays, f"azimuth {i}") for i, first in places)
    if "slew up" in arrays:
        numbers["slew"] = Slew(arrays["slew up"], arrays["slew down"])
    if "volts" in arrays:
        numbers["by_volts"] = VoltageTable(arrays["volts"], arrays["volts f_min"], arrays["volts f_max"])
    if "esc" in arrays:
        kinds = [_esc(arrays, i) for i in range(int(arrays["esc"].max()) + 1)]
        numbers["esc"] = tuple(kinds[i] for i in arrays["esc"])
    if "cap" in arrays:
        most, reserve, of_power, at = arrays["cap"].tolist()
        numbers["cap"] = Cap(most, reserve, bool(of_power), None if np.isnan(at) else at)
    if "autopilot frame" in arrays:
        numbers["autopilot"] = _mixer(arrays)
    for key, words in (("dof", "dof"), ("names", "thrusters")):
        numbers[key] = tuple(map(str, arrays[words]))
    for key in LEVELS:
        numbers[key] = tuple(tuple(str(level).split(",")) for level in arrays[key])
    numbers["frame"] = frame[0] if frame else "frd"  # logs of boards before frames were said
    return Vehicle(name=name, source=source, whole=whole, **numbers)


def _azimuth_arrays(vehicle: Vehicle) -> dict[str, NDArray[Any]]:
    """The arrays that thrusters which turn are made of; none without one."""
    if not vehicle.azimuths:
        return {}
    firsts = np.array([azimuth.first for azimuth in vehicle.azimuths])
    arrays: dict[str, NDArray[Any]] = {"azimuths": firsts}
    for i, one in enumerate(vehicle.azimuths):
        arrays[f"azimuth {i}"] = one.corners
        if one.pieces:
            arrays[f"azimuth {i} pieces"] = np.array(list(map(len, one.pieces)))
            arrays[f"azimuth {i} arc"] = np.array(one.arc or (), dtype=np.float64)
    return arrays


def _azimuth(first: int, arrays: Mapping[str, NDArray[Any]], key: str) -> Azimuth:
    """A thruster that turns, of the arrays that ``_azimuth_arrays`` made."""
    corners = arrays[key]
    if f"{key} pieces" not in arrays:
        return Azimuth(first, corners)
    pieces = np.split(corners, np.cumsum(arrays[f"{key} pieces"])[:-1])
    return join(first, pieces, tuple(arrays[f"{key} arc"].tolist()) or None, "")


def _esc(arrays: Mapping[str, NDArray[Any]], i: int) -> Esc:
    parts = ((key, arrays[f"esc {i} {key}"]) for key in ESC)
    values: dict[str, Any] = {key: part if part.ndim else part.item() for key, part in parts}
    return Esc(current=_current(arrays, f"esc {i}"), **values)


def _current_arrays(current: Current | None) -> dict[str, NDArray[Any]]:
    """The arrays that a current is made of; none without one."""
    match current:
        case None:
            return {}
        case PowerLaw():
            return {"law": np.array(current)}
        case CurrentTable():
            points = {f"amps {j}": points for j, points in enumerate(current.measured)}
            return {"amps volts": current.volts, **points}


def _current(arrays: Mapping[str, NDArray[Any]], esc: str) -> Current | None:
    if f"{esc} law" in arrays:
        return PowerLaw(*arrays[f"{esc} law"].tolist())
    if f"{esc} amps volts" in arrays:
        volts = arrays[f"{esc} amps volts"]
        return CurrentTable(volts, tuple(arrays[f"{esc} amps {j}"] for j in range(len(volts))))
    return None


def _mixer(arrays: Mapping[str, NDArray[Any]]) -> Autopilot:
    gains = zip(DOF, arrays["autopilot gains"].tolist(), strict=True)
    return Autopilot(
        frame=str(arrays["autopilot frame"]),
        motors=tuple(arrays["autopilot motors"].tolist()),
        directions=tuple(arrays["autopilot directions"].tolist()),
        thrust=arrays["autopilot thrust"],
        coupling=float(arrays["autopilot coupling"]),
        gains={axis: gain for axis, gain in gains if gain > 0.0},
        airmode=int(arrays.get("autopilot airmode", 0)),  # logs of boards before it have none, nor curve
        curve=bool(arrays.get("autopilot curve", False)),
    )


def same_vehicle(a: Vehicle, b: Vehicle) -> bool:
    """True if two vehicles have the same numbers."""
    one, two = ({key: getattr(v, key) for key in ARRAYS} | _azimuth_arrays(v) for v in (a, b))
    same = one.keys() == two.keys() and all(np.array_equal(one[key], two[key]) for key in one)
    words = ("priority", "groups", "frame", "survey", "weak_limit")
    return same and all(getattr(a, key) == getattr(b, key) for key in words)


def save(path: Path, **arrays: NDArray[Any]) -> None:
    """Write arrays into one .npz file; raises an OSError that names the file, which numpy's own does not."""
    try:
        np.savez(path, allow_pickle=False, **arrays)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None


class Case(NamedTuple):
    """Demands on a vehicle.

    Attributes
    ----------
    vehicle : that must answer
    taus : (N, k) demands [N, N m]
    f_min, f_max : (N, n) limits of each demand [N]; None where all have the vehicle's
    """

    vehicle: Vehicle
    taus: FloatArray
    f_min: FloatArray | None = None
    f_max: FloatArray | None = None


def save_case(path: Path, case: Case) -> None:
    """Write a case."""
    save(path, taus=case.taus, **pack_vehicle(case.vehicle), **_limits(case.f_min, case.f_max))


def load_case(path: Path) -> Case:
    """Read what ``save_case`` wrote."""
    with np.load(path) as arrays:
        return Case(unpack_vehicle(arrays), arrays["taus"], arrays.get("row f_min"), arrays.get("row f_max"))


def pack_demands(demands: DemandSet) -> dict[str, NDArray[Any]]:
    """The arrays of a demand set and its vehicle, without ``left_out``, which only the parent needs."""
    return pack_vehicle(demands.vehicle) | {
        "demands": np.array(demands.name),
        "taus": demands.taus,
        "labels": demands.labels,
        "alpha": demands.alpha,
        "rate_hz": np.array(np.nan if demands.rate_hz is None else demands.rate_hz),
        "gaps": np.array(demands.gaps, dtype=np.intp),
        "part": np.array(demands.part or (), dtype=np.intp),
        "supply": np.array([np.nan if x is None else x for x in demands.supply]),
        **_limits(demands.f_min, demands.f_max, demands.f_previous),
        **{key: part for key in HARD if (part := getattr(demands, key)) is not None},
    }


def unpack_demands(arrays: Mapping[str, NDArray[Any]]) -> DemandSet:
    """The demand set made of what ``pack_demands`` returned, with ``left_out`` 0."""
    rate_hz = float(arrays["rate_hz"])
    part = arrays["part"].tolist() if "part" in arrays else []  # logs of boards before it have none
    return DemandSet(
        name=str(arrays["demands"]),
        vehicle=unpack_vehicle(arrays),
        taus=arrays["taus"],
        labels=arrays["labels"],
        alpha=arrays["alpha"],
        hard_labels=arrays.get("hard_labels"),
        hard_alpha=arrays.get("hard_alpha"),
        rate_hz=None if np.isnan(rate_hz) else rate_hz,
        gaps=tuple(arrays["gaps"].tolist()),
        part=(part[0], part[1]) if part else None,
        f_min=arrays.get("row f_min"),
        f_max=arrays.get("row f_max"),
        f_previous=arrays.get("row f_previous"),
        supply=Supply(*(None if np.isnan(x) else x for x in arrays["supply"].tolist()))
        if "supply" in arrays  # logs of boards before it have none
        else NO_SUPPLY,
    )


def _limits(
    f_min: FloatArray | None, f_max: FloatArray | None, f_previous: FloatArray | None = None
) -> dict[str, FloatArray]:
    sides = {"row f_min": f_min, "row f_max": f_max, "row f_previous": f_previous}
    return {key: side for key, side in sides.items() if side is not None}
