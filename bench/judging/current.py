"""Currents of a log beside those of a vehicle's file, and the law that fits them.

The battery feeds everything aboard, so beside the thrusters' law a constant current is fitted:

    I = rest + ahead * sum of |f_i|^p over f_i > 0 + astern * sum of |f_i|^p over f_i < 0
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from alloc import Vehicle
from alloc.allocation import BoolArray, FloatArray
from alloc.errors import DemandError, VehicleError
from bench.inputs.outputs import Outputs, read_outputs

POWER = 1.5
"""Power of the law: thrust grows with the square of a propeller's speed, and its power with the cube [-]."""
STEP_V = 0.05
"""Voltages are rounded to this: a T200's current changes by 1 % in 0.1 V [V]."""
BANDS = 5
"""Bands of the model's current, with as many rows each."""
FEWEST = 20
"""Rows that a fit needs at least."""
ALIKE = 100.0
"""Condition of the three currents, each of length 1, above which a log does not tell them apart."""


class CurrentFit(NamedTuple):
    """A law fitted to a log.

    Attributes
    ----------
    ahead, astern : factors of |f|^POWER [A/N^POWER]
    rest : everything else draws [A]
    rows, most : rows with a measured current, and the largest of these [A]
    rms, farthest : root mean square and largest distance of a row from the fit [A]
    """

    ahead: float
    astern: float
    rest: float
    rows: int
    most: float
    rms: float
    farthest: float


def model_amps(vehicle: Vehicle, f: FloatArray, volts: FloatArray | None) -> FloatArray:
    """Current (N,) of all thrusters together by the vehicle's file, at each row's voltage (N,) [A].

    Raises VehicleError for a vehicle without currents.
    """
    if volts is None:
        nominal: FloatArray = vehicle.draw().amps(f).sum(axis=1)
        return nominal
    steps = np.maximum(np.rint(volts / STEP_V), 1.0)
    amps = np.empty(len(f))
    for step in np.unique(steps):
        rows = steps == step
        amps[rows] = vehicle.draw(float(step * STEP_V)).amps(f[rows]).sum(axis=1)
    return amps


def current_lines(vehicle: Vehicle, f: FloatArray, outputs: Outputs) -> list[tuple[str, str]]:
    """Lines of ``thrustbench demands`` on measured currents beside the model's of thrusts (N, n) [N].

    Bands of the model's current have as many rows each. Empty for a vehicle without a cap, and for a log
    without currents.
    """
    if vehicle.cap is None or outputs.amps is None:
        return []
    model, measured = model_amps(vehicle, f, outputs.volts), outputs.amps
    known = np.flatnonzero(np.isfinite(measured))
    if not known.size:
        return []
    lines = [
        ("battery's current", f"in {len(known)} of {len(f)} rows, at most {measured[known].max():.3g} A")
    ]
    for band in np.array_split(known[np.argsort(model[known], kind="stable")], BANDS):
        if band.size:
            ends = f"{model[band[0]]:.3g} … {model[band[-1]]:.3g} A"
            more = float(np.mean(measured[band] - model[band]))
            lines.append(
                (f"model {ends}", f"measured {measured[band].mean():.3g} A, {more:+.2g} A on average")
            )
    return lines


def fit_current(f: FloatArray, measured: FloatArray) -> CurrentFit:
    """The law of least squares of thrusts (N, n) [N] and the battery's currents (N,) [A], all at least 0.

    Raises DemandError where thrusts do not tell the three apart.
    """
    from scipy.optimize import nnls

    known: BoolArray = np.isfinite(measured)
    amps, law = measured[known], np.abs(f[known]) ** POWER
    sides = [(law * (f[known] > 0)).sum(axis=1), (law * (f[known] < 0)).sum(axis=1)]
    columns = np.column_stack([*sides, np.ones(len(amps))])
    if len(amps) < FEWEST:
        raise DemandError(f"got {len(amps)} rows with a current, expected {FEWEST} or more")
    for side, way in zip(sides, ("ahead", "astern"), strict=True):
        if not side.any():
            raise DemandError(f"no thruster pushes {way}, expected both ways; drive all axes")
    lengths = np.linalg.norm(columns, axis=0)
    if not np.linalg.cond(columns / lengths) <= ALIKE:
        raise DemandError(
            "the currents ahead, astern and at rest always change together, expected some that do not; drive"
            " one axis after the other, and rest between"
        )
    ahead, astern, rest = (nnls(columns / lengths, amps)[0] / lengths).tolist()
    left = amps - columns @ [ahead, astern, rest]
    return CurrentFit(
        ahead=ahead,
        astern=astern,
        rest=rest,
        rows=len(amps),
        most=float(amps.max()),
        rms=float(np.sqrt(np.mean(left**2))),
        farthest=float(np.abs(left).max()),
    )


def fit_text(log: Path, vehicle: Vehicle) -> str:
    """Lines with the law that fits a log of outputs, for the vehicle's file, and what it leaves.

    Raises VehicleError for a vehicle without ESCs, FileError or DemandError for a log that can't be used.
    """
    if not vehicle.esc:
        raise VehicleError(f"{vehicle.name}: has no ESCs for --fit-current; add 'esc' to its file", "esc")
    outputs = read_outputs(log, vehicle)
    if outputs.amps is None:
        raise DemandError(f"{log}: holds no current of a battery; log it (BAT.Curr, or PX4's battery_status)")
    f = vehicle.thrusts(outputs.u, outputs.volts)
    try:
        fit = fit_current(f, outputs.amps)
    except DemandError as error:
        raise DemandError(f"{log}: {error}") from None
    law = f"{{ahead: {fit.ahead:.3g}, astern: {fit.astern:.3g}, power: {POWER:g}}}"
    lines = [
        f"fit      current: {law}, for 'esc'",
        f"fit      reserve: {fit.rest:.3g}, for 'cap': everything else draws so many A",
        f"fit      leaves {fit.rms:.2g} A root mean square, {fit.farthest:.2g} A at most, of"
        f" {fit.most:.3g} A in {fit.rows} rows",
    ]
    if all(esc.current is not None for esc in vehicle.esc):
        left = outputs.amps - model_amps(vehicle, f, outputs.volts) - fit.rest
        lines.append(
            f"fit      the file's currents leave {np.sqrt(np.nanmean(left**2)):.2g} A root mean square"
        )
    return "\n".join(lines)
