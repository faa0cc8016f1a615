"""``thrustbench check``."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bench.commands import NOISE, PATH, check_picture, echo, log_options, read_options, wrench_noise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from alloc import Vehicle
    from alloc.allocation import FloatArray
    from alloc.vehicle.file import Mounting

TITLE = "drawn by thrustbench check"
"""Title of its pictures, by which a picture of its own is told from any other file."""


@click.command()
@click.argument("vehicle", metavar="VEHICLE.yaml")
@click.option("--json", "as_json", is_flag=True, help="One JSON object instead of a table; no picture.")
@click.option("--probe", is_flag=True, help="What each thruster alone should do, to be ticked at the pool.")
@click.option("--failures", is_flag=True, help="Failures that show, look alike, and demands to tell them.")
@NOISE
@click.option(
    "--demands", type=PATH, metavar="LOG", help="With --failures: demands that are flown, in order."
)
@log_options
@click.option("-o", "--output", type=PATH, help="With --failures: the demands to fly, as CSV.")
@click.option("--fit-current", "log", type=PATH, metavar="LOG", help="Fit currents to a log of outputs.")
@click.option("--autopilot", default="", metavar="A", help="ardusub:FRAME, px4, a parameter file, or key.")
@click.option("--picture", type=PATH, metavar="FILE", help="An .svg, .pdf or .png [<vehicle>.svg, here].")
@click.option("--no-picture", is_flag=True, help="Draw nothing.")
def command(
    vehicle: str,
    as_json: bool,
    probe: bool,
    failures: bool,
    noise: str,
    demands: Path | None,
    output: Path | None,
    log: Path | None,
    autopilot: str,
    picture: Path | None,
    no_picture: bool,
    **reading: Any,
) -> int:
    """Say what is odd about a vehicle file, and draw the vehicle.

    Errors (exit code 2), warnings, and what each failure costs. What commands make is drawn where it has
    'esc', as <vehicle>-esc.svg. With --probe the table of the pool is drawn too, as <vehicle>-probe.svg and
    .pdf beside the drawing. With --failures: the smallest loss of each thruster that shows, pairs that look
    alike, demands to fly that tell the others apart, and how long a monitor takes to accuse a thruster that
    is off, given the noise of a wrench [N, N m]. With
    --autopilot: a table of what each input makes, drawn as <vehicle>-autopilot.svg; key is the file's own.
    With --fit-current: the law of `esc.current` that fits a .BIN or ULog with the battery's current, and what
    the fit leaves.
    """
    from alloc.lint.autopilot import as_text as factors_as_text
    from alloc.lint.autopilot import shares
    from alloc.lint.check import check_vehicle
    from alloc.lint.probe import as_text, probes
    from alloc.lint.report import as_table, to_json
    from alloc.methods.px4 import unit_outputs
    from alloc.vehicle.azimuth import refuse_azimuths
    from bench.judging.current import fit_text
    from bench.judging.weak import weak_lines

    check_picture(picture)
    if not failures and (noise or demands or output):
        raise click.UsageError("--noise, --demands and -o are of --failures; give that too")
    if any(reading.values()) and not demands:
        raise click.UsageError("--scale, --columns, --frame and --topic are of --demands; give that too")
    if failures and as_json:
        raise click.UsageError("--failures is text, and a CSV with -o; leave out --json")
    if log is not None and as_json:
        raise click.UsageError("--fit-current is text; leave out --json")
    report = check_vehicle(vehicle, autopilot)
    drawn, mounting = _read(report.path, autopilot) if report.facts is not None else (None, None)
    options = {"--probe": probe, "--failures": failures, "--fit-current": log, "--autopilot": autopilot}
    for option in filter(options.get, options):
        refuse_azimuths(drawn.azimuths if drawn else (), option, "it knows thrusters along a line")
    tried = probes(drawn) if probe and drawn is not None else None
    echo(to_json(report, tried) if as_json else as_table(report))
    for line in weak_lines(drawn) if drawn is not None and not as_json else []:
        echo(line)
    percent = None
    if autopilot and drawn is not None and (mixer := drawn.autopilot) is not None and not as_json:
        factors = unit_outputs(drawn) if mixer.method == "px4" else mixer.factors
        percent = shares(drawn, mixer, factors)
        echo(factors_as_text(mixer, percent))
    if tried is not None and not as_json:
        echo(as_text(tried))
    remarks: list[str] = []
    if failures and drawn is not None:
        text, remarks = _isolation(drawn, noise, demands, output, **reading)
        echo(text)
    if log is not None and drawn is not None:
        echo(fit_text(log, drawn))
    if drawn is not None and mounting is not None and (picture or not (as_json or no_picture)):
        for line in _pictures(report.path, drawn, mounting, picture, probe, percent):
            echo(line, err=as_json)
    errors = [finding for finding in report.findings if finding.level == "error"]
    if errors:
        first = errors[0]
        line = f", line {first.line}" if first.line else ""
        key = "" if first.key in first.message else f"{first.key}: "
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        file = str(report.path).replace("\n", " ")
        echo(f"thrustbench: {file}{line}: {key}{first.message}{more}", err=True)
        return 2
    for remark in remarks:  # at last, since a refusal is one line
        echo(remark, err=True)
    return 0


def _read(file: Path, autopilot: str) -> "tuple[Vehicle, Mounting]":
    """The vehicle of a file without an error in T or limits, and the poses of its thrusters."""
    from alloc.lint.autopilot import choose
    from alloc.vehicle.file import build_document, matrices, poses, read_document, vehicle_with

    document = read_document(file)
    keys = document.keys
    if any(thruster.azimuth for thruster in keys.thrusters or ()):
        vehicle = build_document(document, file)
        return vehicle, poses(keys, vehicle.T[:, [first for first, *_ in vehicle.actuators]])
    if autopilot:
        keys.autopilot = choose(autopilot, keys.autopilot)
    T, _ = matrices(keys)
    return vehicle_with(keys, T), poses(keys, T)


def _isolation(
    vehicle: "Vehicle", noise: str, demands: Path | None, output: Path | None, **options: Any
) -> tuple[str, list[str]]:
    """Failures that can be told apart, and when, in lines; remarks on the log of demands.

    The demands to fly go into the output.
    """
    import numpy as np

    from alloc.errors import DemandError
    from alloc.files.textfile import write_text
    from alloc.lint.isolation import as_text, isolation
    from bench.inputs.demand_csv import format_demands
    from bench.inputs.log_limits import row_limits
    from bench.inputs.logs import log_for, rate_hz
    from bench.judging import accusation

    found, remarks = isolation(vehicle, wrench_noise(vehicle, noise)), []
    if demands is None:
        seconds = accusation.times_of_thrusters(vehicle, found.noise)
        told = accusation.as_text(vehicle, seconds, accusation.ASSUMED)
    else:
        flown = log_for(vehicle, demands, read_options(**options))
        limits, known = row_limits(demands, flown.columns, vehicle), rate_hz(flown.t)
        hz = known or accusation.RATE_HZ
        if hz * accusation.LATE_S < 1.0:
            raise DemandError(
                f"{demands}: t: {1 / hz:g} s between rows, expected at most {accusation.LATE_S:g} s; log each"
                " call, or state the unit: --columns 't=t [ms]'"
            )
        seconds = accusation.times_of_thrusters(vehicle, found.noise, flown.taus, hz, limits)
        lasting_s = len(flown.taus) / hz
        said = f"at {hz:.3g} calls a second{'' if known else ' (assumed)'} and the demands of {demands}"
        if lasting_s < accusation.LATE_S:
            said += f", which last {lasting_s:.3g} s"
        told = accusation.as_text(vehicle, seconds, said, lasting_s)
        remarks = [flown.notes, *([f"warning: {flown.doubt}"] if flown.doubt else [])]
    if output is not None:
        taus = np.array([trial.tau for trial in found.trials]).reshape(-1, vehicle.k)
        write_text(output, format_demands(None, taus, vehicle.dof, frame=vehicle.frame))
    return f"{as_text(vehicle, found)}\n{told}", remarks


def _pictures(
    file: Path,
    vehicle: "Vehicle",
    mounting: "Mounting",
    picture: Path | None,
    probe: bool,
    percent: "FloatArray | None",
) -> list[str]:
    """Draw the vehicle, and the table of the pool or of inputs if asked for; lines that say where they are.

    Without a name they go into the current folder, where they replace nothing but older ones of their kind.
    """
    import matplotlib as mpl

    from alloc.lint.probe import probes
    from bench.report.pictures.sketch import input_map, sheet, sketch, thrust_curve
    from bench.report.pictures.style import SETTINGS

    target = picture or Path(f"{file.stem}.svg")
    with mpl.rc_context(SETTINGS):
        said = "drawn from three sides; arrows show which way positive thrust pushes"
        said += "; polygons, what turning thrusters give" if vehicle.azimuths else ""
        lines = [_saved(sketch(vehicle, mounting), target, picture is not None, said)]
        if vehicle.esc:
            beside = target.with_name(f"{target.stem}-esc{target.suffix}")
            lines.append(
                _saved(thrust_curve(vehicle), beside, picture is not None, "what its ESCs' commands make")
            )
        if percent is not None and vehicle.autopilot is not None:
            beside = target.with_name(f"{target.stem}-autopilot{target.suffix}")
            made = input_map(vehicle, percent, vehicle.autopilot.frame)
            lines.append(_saved(made, beside, picture is not None, "what its autopilot's inputs make"))
        if probe:
            drawn = sheet(vehicle, probes(vehicle))
            for suffix in (".svg", ".pdf"):
                beside = target.with_name(f"{target.stem}-probe{suffix}")
                lines.append(_saved(drawn, beside, picture is not None, "drawn, to be ticked at the pool"))
    return lines


def _saved(figure: "Figure", target: Path, named: bool, said: str) -> str:
    """Save a figure, and say so; raises FileError where a file that the user named can't be written."""
    from alloc.errors import FileError
    from bench.report.pictures.style import save_as

    try:
        if not named and target.exists() and TITLE.encode() not in target.read_bytes():
            return f"{target}: is another file, so nothing is drawn; --picture names a place"
        save_as(figure, target, TITLE)
    except OSError as error:
        if not named:
            return f"{target}: not drawn ({error.strerror}); --picture names another place"
        raise FileError(f"can't be written ({error.strerror}); name another place", path=target) from None
    return f"{target}: {said}"
