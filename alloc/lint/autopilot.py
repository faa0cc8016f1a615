"""An autopilot's factors against the geometry: the remarks, and the table of what each input makes."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from alloc.allocation import BoolArray, FloatArray
from alloc.errors import FileError, VehicleError, unknown
from alloc.files.ardupilot import SETTING, read_parameters, sub_settings
from alloc.files.px4 import is_px4, px4_settings
from alloc.lint.report import Remark, note, warning
from alloc.vehicle import Vehicle
from alloc.vehicle.autopilot import FRAMES, SENSE, Autopilot
from alloc.vehicle.file import Mounting
from alloc.vehicle.geometry import DOF
from alloc.vehicle.keys import AutopilotKeys

INPUTS = ("forward", "lateral", "throttle", "roll", "pitch", "yaw")
"""ArduSub's names of its inputs, in the order of DOF."""
PUSHES = 0.1
"""Share of what the strongest thruster does along an axis from which another counts as pushing there [-]."""
MIRROR = np.array([1.0, -1.0, 1.0])
ACROSS = np.array([-1.0, 1.0, 1.0])
"""Signs of a vector in its mirror image, port for starboard and bow for stern."""
MIRROR_ROWS = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
ACROSS_ROWS = np.array([-1.0, 1.0, 1.0, 1.0, -1.0, -1.0])
"""The same of forces and moments, in the order of DOF."""


def made_by_outputs(vehicle: Vehicle, mixer: Autopilot) -> tuple[FloatArray, BoolArray]:
    """Force and moment (6, n) of each thruster at output 1, along ArduSub's inputs; (6,) known rows."""
    if vehicle.poses is not None:
        rows, known = vehicle.poses, np.ones(6, dtype=bool)
    else:
        rows, known = np.zeros((6, vehicle.n)), np.zeros(6, dtype=bool)
        at = [DOF.index(axis) for axis in vehicle.dof]
        rows[at], known[at] = vehicle.T, True
    size = (mixer.thrust[1] - mixer.thrust[0]) / 2
    made: FloatArray = np.array(SENSE[vehicle.frame])[:, None] * rows * size
    return made, known


def shares(vehicle: Vehicle, mixer: Autopilot, factors: FloatArray) -> FloatArray:
    """(6, 6) percentages: a row an axis, a column an input; NaN where the geometry says nothing.

    ``factors`` (n, 6) are the outputs of inputs 1, of ArduSub its table.

    On the diagonal stands the share of all that the thrusters could do along the axis; beside it, of all that
    the axis's own input makes (of all that the thrusters could do, where that is nothing). Thrust is taken as
    alike ahead and astern.
    """
    W, known = made_by_outputs(vehicle, mixer)
    M, most = W @ factors, np.abs(W).sum(axis=1)
    own = np.abs(np.diag(M))
    unit = np.where(own > PUSHES * PUSHES * most, own, most)
    with np.errstate(invalid="ignore", divide="ignore"):
        percent = 100 * M / unit[:, None]
        np.fill_diagonal(percent, 100 * np.diag(M) / most)
    percent[~known | (most == 0)] = np.nan
    return percent


def as_text(mixer: Autopilot, percent: FloatArray) -> str:
    """The table of ``shares``."""
    lines = [
        f"{mixer.frame}: diagonal, % of what all thrusters could do; beside it, % of the axis's own input",
        f"{'':8}" + "".join(f"{name:>10}" for name in INPUTS),
    ]
    for axis, row in zip(DOF, percent, strict=True):
        cells = "".join(f"{'' if np.isnan(cell) else f'{cell + 0.0:.1f}':>10}" for cell in row.round(1))
        lines.append(f"{axis:8}{cells}".rstrip())
    return "\n".join(lines)


def on_autopilot(vehicle: Vehicle, mounting: Mounting) -> Iterator[Remark]:
    """Remarks on thrusters that contradict their factors, are no mirror images, or lie beside the middle."""
    if (mixer := vehicle.autopilot) is None or mixer.frame not in FRAMES:  # PX4 knows the positions
        return
    W, known = made_by_outputs(vehicle, mixer)
    turned, wrong = contradictions(W, known, mixer)
    motors, frame = mixer.motors, mixer.frame
    others = [other for other in FRAMES if len(FRAMES[other]) == vehicle.n and other != frame]
    odd = len(turned) + len(wrong)
    for other in others if 2 * odd >= vehicle.n else ():
        if not any(contradictions(W, known, _in_frame(mixer, other))[1]):
            yield warning(
                "autopilot",
                f"{odd} of {vehicle.n} thrusters contradict {frame}, none {other}; set FRAME_CONFIG"
                f" = {list(FRAMES).index(other)} ({other}), or wire them as {frame} has its motors",
            )
            return
    for i in turned:
        yield warning(
            "autopilot",
            f"{vehicle.called(i)} pushes opposite to all factors of motor {motors[i]} of {frame};"
            f" set MOT_{motors[i]}_DIRECTION = {-mixer.directions[i]}",
        )
    exchanged = _exchanged(W, known, mixer, wrong)
    for i in wrong:
        if i in exchanged:
            at, sign = exchanged[i]
            also = f", MOT_{at}_DIRECTION = {sign}" if sign != mixer.directions[motors.index(at)] else ""
            yield warning(
                "autopilot",
                f"{vehicle.called(i)} is wired as motor {motors[i]} of {frame} but placed as motor {at};"
                f" give its output SERVOn_FUNCTION = {32 + at}{also}",
            )
        else:
            axes = ", ".join(INPUTS[axis] for axis in _against(W, known, mixer, i))
            yield warning(
                "autopilot",
                f"{vehicle.called(i)} contradicts motor {motors[i]} of {frame} along {axes};"
                " correct its position or direction, or choose another frame",
            )
    clean = [i for i in range(vehicle.n) if i not in turned and i not in wrong and mounting.stands[i]]
    yield from _on_mirrors(vehicle, mixer, mounting, clean)
    yield from _on_axes(vehicle, mixer, W, known)


def contradictions(W: FloatArray, known: BoolArray, mixer: Autopilot) -> tuple[list[int], list[int]]:
    """Thrusters that push opposite to all of their factors, and those that contradict some of them."""
    turned, wrong = list[int](), list[int]()
    for i, row in enumerate(mixer.factors):
        against = _against(W, known, mixer, i)
        if len(against) == 0:
            continue
        opposite = _senses(W)[:, i] == -np.sign(row)
        (turned if opposite[(row != 0) & _asked(W, known)].all() else wrong).append(i)
    return turned, wrong


def _asked(W: FloatArray, known: BoolArray) -> BoolArray:
    """(6,) axes that the geometry knows and some thruster pushes."""
    asked: BoolArray = known & (np.abs(W).max(axis=1) > 1e-9 * np.abs(W).max())
    return asked


def _senses(W: FloatArray) -> FloatArray:
    """(6, n) which way each thruster pushes along each axis: 1, -1, or 0 for next to nothing."""
    most = np.abs(W).max(axis=1, keepdims=True)
    pushes: FloatArray = np.where(np.abs(W) > PUSHES * most, np.sign(W), 0.0)
    return pushes


def _against(W: FloatArray, known: BoolArray, mixer: Autopilot, i: int) -> list[int]:
    """Axes whose factor of thruster i has another sign than what it pushes."""
    row = mixer.factors[i]
    odd = (row != 0) & _asked(W, known) & (_senses(W)[:, i] != np.sign(row))
    return np.flatnonzero(odd).tolist()


def _in_frame(mixer: Autopilot, frame: str) -> Autopilot:
    """The same motors and directions in another frame."""
    return Autopilot(frame, mixer.motors, mixer.directions, mixer.thrust, mixer.coupling)


def _exchanged(
    W: FloatArray, known: BoolArray, mixer: Autopilot, wrong: Sequence[int]
) -> dict[int, tuple[int, int]]:
    """Motor that each thruster of ``wrong`` is placed as, where it is another's there, and its direction."""
    if not wrong:
        return {}
    motors = [mixer.motors[i] for i in wrong]
    B, asked, senses = np.array(FRAMES[mixer.frame]), _asked(W, known), _senses(W)
    cost, signs = np.zeros((len(wrong), len(wrong))), np.ones((len(wrong), len(wrong)), dtype=int)
    for a, i in enumerate(wrong):
        for b, motor in enumerate(motors):
            factors = B[motor - 1] * asked
            misses = [
                int(((factors != 0) & (sign * senses[:, i] != np.sign(factors))).sum()) for sign in (1, -1)
            ]
            cost[a, b], signs[a, b] = min(misses), 1 if misses[0] <= misses[1] else -1
    rows, columns = linear_sum_assignment(cost)
    return {
        wrong[a]: (motors[b], int(signs[a, b]))
        for a, b in zip(rows.tolist(), columns.tolist(), strict=True)
        if cost[a, b] == 0 and a != b
    }


def _pairs(mixer: Autopilot, among: Sequence[int], image: FloatArray) -> Iterator[tuple[int, int, float]]:
    """Thrusters whose factors are mirror images, and the sign of the second; i, i for one that is its own."""
    B = np.array(FRAMES[mixer.frame])[np.array(mixer.motors) - 1]

    def sign(a: int, b: int) -> float | None:
        return next((s for s in (1.0, -1.0) if np.array_equal(B[b], s * image * B[a])), None)

    alone = [a for a in among if sign(a, a) is not None]
    for a in among:
        for b in [a] if a in alone else [b for b in among if b > a and b not in alone]:
            if (found := sign(a, b)) is not None:
                yield a, b, found


def _misses(
    mixer: Autopilot,
    mounting: Mounting,
    among: Sequence[int],
    rows: FloatArray,
    image: FloatArray,
    middle: FloatArray,
) -> dict[tuple[int, int], tuple[float, float]]:
    """Distance [m] and angle [deg] of each pair's second line of thrust from the first's image."""
    found = {}
    along = mounting.directions * np.array(mixer.directions)[:, None]
    for a, b, sign in _pairs(mixer, among, rows):
        unit = along[b] / np.linalg.norm(along[b])
        wanted = sign * image * along[a] / np.linalg.norm(along[a])
        apart = mounting.positions[b] - middle - image * (mounting.positions[a] - middle)
        beside = float(np.linalg.norm(apart - apart.dot(unit) * unit))
        angle = float(np.degrees(np.arccos(np.clip(abs(unit.dot(wanted)), -1.0, 1.0))))
        found[a, b] = beside, angle
    return found


def _middle(mixer: Autopilot, mounting: Mounting, among: Sequence[int], rows: FloatArray, axis: int) -> float:
    """Middle of most pairs along an axis [m]."""
    places = mounting.positions[:, axis]
    between = [(places[a] + places[b]) / 2 for a, b, _ in _pairs(mixer, among, rows)]
    return float(np.median(between)) if between else float(mounting.center[axis])


def _on_mirrors(
    vehicle: Vehicle, mixer: Autopilot, mounting: Mounting, among: Sequence[int]
) -> Iterator[Remark]:
    """Remarks on pairs that are no mirror images though their factors are, and on a middle beside the centre.

    Two poses differ by twice the survey's tolerance at most.
    """
    far, wide = 2e-3 * vehicle.survey.mm, 2 * vehicle.survey.deg
    middle = mounting.center.copy()
    middle[1] = _middle(mixer, mounting, among, MIRROR_ROWS, 1)
    middle[0] = _middle(mixer, mounting, among, ACROSS_ROWS, 0)
    beside = middle[1] - mounting.center[1]
    if abs(beside) > far / 2:
        starboard = (beside < 0) == (vehicle.frame == "frd")
        yield warning(
            "autopilot",
            f"the centre of mass lies {1e3 * abs(beside):.0f} mm to {'starboard' if starboard else 'port'} of"
            f" the thrusters' middle, which {mixer.frame} does not know: what pushes also turns; move"
            " ballast, or allocate by the geometry",
        )
    sides = _misses(mixer, mounting, among, MIRROR_ROWS, MIRROR, middle)
    ends = _misses(mixer, mounting, among, ACROSS_ROWS, ACROSS, middle)
    odd = {i for pair, (mm, deg) in ends.items() if mm > far or deg > wide for i in pair}
    for (a, b), (apart, angle) in sides.items():
        if apart <= far and angle <= wide:
            continue
        fault = [i for i in (a, b) if i in odd] if ends else []
        blamed = fault if len(fault) == 1 else [a, b] if a != b else [a]
        names = " and ".join(vehicle.called(i) for i in blamed)
        other = vehicle.called(b if blamed == [a] else a)
        image = (
            f"{names} {'is' if a == b else 'are'} no mirror image{'' if a == b else 's'}"
            if len(blamed) != 1 or a == b
            else f"{names} is no mirror image of {other}"
        )
        yield warning(
            "autopilot",
            f"{image}, as {mixer.frame} takes for granted: {1e3 * apart:.0f} mm and {angle:.1f} deg apart;"
            " correct the pose, or expect moves that turn",
        )


def _on_axes(vehicle: Vehicle, mixer: Autopilot, W: FloatArray, known: BoolArray) -> Iterator[Remark]:
    """Notes on controlled axes that the factors don't command though thrusters push them."""
    for axis in vehicle.dof:
        j = DOF.index(axis)
        if known[j] and not mixer.factors[:, j].any() and (most := float(np.abs(W[j]).sum())) > 0:
            unit = "N" if j < 3 else "N m"
            yield note(
                "autopilot",
                f"{mixer.frame} commands no {axis}, though the thrusters could make up to {most:.3g} {unit}",
            )


def choose(spec: str, said: AutopilotKeys | None) -> AutopilotKeys:
    """The autopilot that a command names: key for the file's, ardusub:FRAME, px4, or a file of parameters.

    Which thruster is which motor stays as the file says; its directions count for its own frame alone. Raises
    VehicleError, or FileError for a parameter file.
    """
    kind, _, frame = spec.partition(":")
    if spec == "key":
        if said is None:
            raise VehicleError("autopilot: the file has no key 'autopilot'; name ardusub:FRAME", "autopilot")
        return said
    order = list(said.motors) if said is not None else []
    if kind == "ardusub" and frame:
        if frame not in FRAMES:
            raise VehicleError(f"autopilot: {unknown('frame', frame, FRAMES)}", "autopilot")
        same = said is not None and said.ardusub == frame
        return said if said is not None and same else AutopilotKeys(ardusub=frame)
    if kind == "px4":
        return AutopilotKeys(px4=frame or "automatic")
    path = Path(spec)
    if not path.is_file():
        raise VehicleError(
            f"autopilot: got {spec[:40]!r}, expected ardusub:FRAME, px4, key, or a file of parameters",
            "autopilot",
        )
    given, names = read_parameters(path), list(FRAMES)
    if is_px4(given):
        method, airmode, rotors = px4_settings(given, path)
        return AutopilotKeys(px4=method, airmode=airmode, motors=list(range(rotors)))
    settings = sub_settings(given, path)
    if not 0 <= settings.frame < len(names):
        known = f"0 to {len(names) - 1}, {names[0]} to {names[-1]}"
        raise FileError(f"{SETTING} is {settings.frame}; there are {known}", path=path)
    reverse: list[int | str] = [
        order[motor - 1] if motor <= len(order) else motor - 1
        for motor in settings.reverse
        if motor <= len(FRAMES[names[settings.frame]])
    ]
    return AutopilotKeys(
        ardusub=names[settings.frame], motors=order, reversed=reverse, coupling=settings.coupling
    )
