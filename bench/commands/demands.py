"""``thrustbench demands``."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bench.commands import PATH, check_picture, echo, log_options, not_over, read_options

if TYPE_CHECKING:
    from alloc import Vehicle
    from alloc.allocation import FloatArray
    from bench.inputs.outputs import Outputs
    from bench.judging.readiness import WindowReadiness


@click.command()
@click.argument("log", type=PATH)
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@log_options
@click.option("--from-outputs", is_flag=True, help="What the commands that went to the ESCs made.")
@click.option("--accelerations", is_flag=True, help="With --from-outputs: readiness of each thruster.")
@click.option("--picture", type=PATH, metavar="FILE", help="Readiness over time: an .svg, .pdf or .png.")
@click.option("-o", "--output", type=PATH, help="The demands as CSV, in the vehicle's frame.")
def command(
    log: Path,
    vehicle: str,
    from_outputs: bool,
    accelerations: bool,
    picture: Path | None,
    output: Path | None,
    **options: Any,
) -> None:
    """Say what a log (CSV, ROS bag, PX4 ULog) asks of a vehicle.

    Rate, gaps, labels, what a closed form could serve, and the energy where the vehicle has a cap. With
    --from-outputs, of a log of commands to the ESCs (ArduPilot .BIN, PX4 ULog, CSV with u0, u1, …): which
    wrench they made by the vehicle's `esc`, how often a thruster stood at its end or in its dead band, what
    of the demand was left undone, what `scaled` would leave of it, and, where the vehicle has a cap, the
    battery's current beside the model's.
    -o writes the wrenches that were made. With --accelerations, of the same logs where they hold the motion
    (docs/failures.md): how ready each thruster was, with an interval, and which ones are weak.
    """
    not_over(output, log)
    if accelerations and not from_outputs:
        raise click.UsageError("--accelerations is of --from-outputs; give that too")
    if picture is not None and not accelerations:
        raise click.UsageError("--picture is of --accelerations; give that too")
    check_picture(picture)
    if from_outputs:
        _outputs(log, vehicle, output, accelerations, picture, **options)
        return
    from alloc import load_vehicle
    from alloc.files.textfile import write_text
    from bench.demands import labelled
    from bench.demands.log_summary import demands_text, hold_times, summarise
    from bench.inputs.demand_csv import format_demands
    from bench.inputs.log_limits import row_limits
    from bench.inputs.logs import log_for, rate_hz
    from bench.judging.cap import energy_lines

    answering = load_vehicle(vehicle)
    read = log_for(answering, log, read_options(**options))
    t, taus, columns = read.t, read.taus, read.columns
    low, high = row_limits(log, columns, answering)
    demands = labelled(log.stem, answering, taus, low, high, rate_hz=rate_hz(t))
    echo(demands_text(summarise(demands, t), demands, energy_lines(demands, hold_times(t))))
    if output is not None:
        write_text(output, format_demands(t, taus, answering.dof, columns, frame=answering.frame))
    echo(read.notes, err=True)  # at last, since a refusal is one line
    if read.doubt:
        echo(f"warning: {read.doubt}", err=True)


def _outputs(
    log: Path, name: str, output: Path | None, accelerations: bool, picture: Path | None, **options: Any
) -> None:
    from alloc.errors import DemandError, VehicleError
    from alloc.files.textfile import write_text
    from alloc.vehicle.file import load_fixed_vehicle
    from bench.demands.log_summary import extra_columns, made_by, outputs_text
    from bench.inputs.demand_csv import format_demands, scale_factors
    from bench.inputs.outputs import read_outputs
    from bench.judging.current import current_lines

    given = read_options(**options)
    vehicle = load_fixed_vehicle(name)
    if not vehicle.esc:
        raise VehicleError(
            f"{name}: has no ESCs for --from-outputs; add 'esc' to its file (docs/esc.md)", "esc"
        )
    scale_factors(given.scale, vehicle.dof)
    outputs = read_outputs(log, vehicle, given.columns, given.frame, given.topic, sensed=accelerations)
    if given.scale and outputs.taus is None:
        raise DemandError(f"{log}: has no demands that could be scaled; leave out --scale")
    made = made_by(outputs, vehicle, given.scale)
    readiness = _readiness(log, vehicle, outputs, made.f, given.columns, picture) if accelerations else ""
    echo(outputs_text(made, outputs, vehicle, current_lines(vehicle, made.f, outputs)))
    if readiness:
        echo(readiness)
    held = ""
    if output is not None:
        columns, held = extra_columns(outputs.volts, vehicle)
        write_text(output, format_demands(outputs.t, made.taus, vehicle.dof, columns, frame=vehicle.frame))
    echo(outputs.notes, err=True)
    if held:
        echo(f"{output}: {held}", err=True)
    in_shares = (
        "the log has demands in shares; 1 is taken for what the vehicle can do on an axis alone,"
        " in the weaker direction; --scale says what it is in N, N m"
    )
    is_open = outputs.shares and outputs.taus is not None and not given.scale
    for doubt in filter(None, (outputs.doubt, in_shares if is_open else "")):
        echo(f"warning: {doubt}", err=True)


def _readiness(
    log: Path,
    vehicle: "Vehicle",
    outputs: "Outputs",
    f: "FloatArray",
    columns: "Mapping[str, str]",
    picture: Path | None,
) -> str:
    """Lines on how ready each thruster was; raises DemandError where no window says anything."""
    from alloc.errors import DemandError
    from bench.inputs.outputs import read_motion
    from bench.judging.readiness import (
        WINDOW_S,
        as_text,
        estimate_ratios,
        estimate_readiness,
        estimate_windows,
        group_text,
    )

    is_weighed = vehicle.inertia is not None
    motion = read_motion(log, outputs, vehicle, columns)
    estimate = estimate_readiness if is_weighed else estimate_ratios
    assert outputs.t is not None
    windows = list(
        estimate_windows(vehicle, outputs.t[motion.rows], f[motion.rows], motion.a, motion.v, estimate)
    )
    if all(window.is_vague for window in windows):
        raise DemandError(
            f"{log}: nothing can be said of any thruster: no window of {WINDOW_S:g} s has enough rows and"
            " motion; fly what `check --failures` names"
        )
    if motion.source:
        echo(motion.source, err=True)
    if picture is not None:
        _draw(vehicle, windows, picture)
    return as_text(vehicle, windows) if is_weighed else f"{group_text(vehicle)}\n{as_text(vehicle, windows)}"


def _draw(vehicle: "Vehicle", windows: "list[WindowReadiness]", target: Path) -> None:
    import matplotlib as mpl
    import numpy as np

    from alloc.errors import FileError
    from bench.judging.readiness import MODEL, VAGUE
    from bench.report.pictures.readiness import TITLE, readiness
    from bench.report.pictures.style import SETTINGS, save_as

    with mpl.rc_context(SETTINGS):
        half_width = np.array([each.half_width for each in windows])
        half_width[half_width >= VAGUE] = np.nan
        figure = readiness(
            [vehicle.called(i) for i in range(vehicle.n)],
            [(each.begin, each.end) for each in windows],
            np.array([each.p for each in windows]) + 0 * half_width,
            half_width,
            np.array([np.isin(range(vehicle.n), each.accused) for each in windows]),
            MODEL,
        )
        try:
            save_as(figure, target, TITLE)
        except OSError as error:
            raise FileError(f"can't be written ({error.strerror}); name another place", path=target) from None
    echo(f"{target}: {TITLE}", err=True)
