"""``thrustbench allocate``."""

import traceback
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from bench.commands import PATH, echo, log_options, not_over, read_options

if TYPE_CHECKING:
    from alloc import Allocation

Made = TypeVar("Made")


@click.command()
@click.argument("demands", type=PATH)
@click.option("--vehicle", required=True, metavar="V", help="A shipped name or a YAML file.")
@click.option("--method", required=True, metavar="M", help="As `thrustbench list` names it, or a file.")
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="I[@P]",
    help="Thruster I, a number or name: off, or at P; several are so together.",
)
@click.option("--start", default="", metavar="S", help="cold, reused or warm.")
@click.option("--level", default="", metavar="L", help="default or tight.")
@click.option("--plugin", "plugins", type=PATH, multiple=True, help="File that holds the method.")
@log_options
@click.option("--names", is_flag=True, help="Head the thrusts' columns with the thrusters' names.")
@click.option("--esc", is_flag=True, help="Commands of the ESCs too, and the wrench that they make.")
@click.option("--cap", metavar="A", help="Most amperes of all thrusters together; or file: the vehicle's.")
@click.option("-o", "--output", type=PATH, help="Thrust CSV [standard output].")
def command(
    demands: Path,
    vehicle: str,
    method: str,
    faults: tuple[str, ...],
    start: str,
    level: str,
    plugins: tuple[Path, ...],
    names: bool,
    esc: bool,
    cap: str | None,
    output: Path | None,
    **options: Any,
) -> None:
    """Compute the thrusts for the demands of a CSV, ROS bag or ULog.

    A CSV's header names the DOF, each row is a demand. It may say the limits of each demand: columns volts,
    and f0_min, f0_max, … in N.

    Writes status,f0,f1,… with one row a demand, in order, in N; then share0,share1,… where a method says what
    it delivered of each level of the demand. Where a method says that there is no such thrust, its numbers
    are nan. With --esc there follow u0,u1,…, what goes to the ESCs by the vehicle's `esc`, neutral where
    there is no thrust, and made_surge, … [N, N m], the wrench that these commands make, in --frame, else in
    the vehicle's; then the log's t [s] and volts [V], where it has them, and the frame, frd or flu. Thrusts
    lie within what the ESCs make at the row's voltage, or at the nominal one, so shares are those of the
    wrench made, but for the steps of the commands.

    With --cap the thrusters draw no more together, by the vehicle's `esc.current` at the row's voltage or the
    nominal one, and shares say what is left of the demand. Methods that take no cap refuse it.

    Of a thruster that turns f has two columns, along x and y; behind all others stand force0 [N] and angle0
    [deg], from x towards y, of the thruster's number in the file. Angles go the shortest way round from row
    to row, on beyond 180, and stay where there is no force.

    Where a plug-in's answer is wrong by the equations, nothing is written and a line says which: asked are
    wrench, limits and shares. Whether it is the optimum that FORMULATION promises, `run` says.
    """
    from alloc import load_vehicle
    from alloc.discovery import find, is_plugin, load_plugin, plugin_name, prepare
    from alloc.errors import PluginError, UnknownName, VehicleError
    from alloc.files.textfile import write_text
    from alloc.vehicle.azimuth import refuse_azimuths
    from bench.harness.process import run_in_copy
    from bench.inputs.demand_csv import esc_columns, format_thrusts
    from bench.inputs.faults import EACH, parse_fault, with_fault
    from bench.inputs.log_limits import row_limits, row_supply
    from bench.inputs.logs import log_for
    from bench.results.text import harmless

    not_over(output, demands)
    if not plugins and is_plugin(method):
        plugins, method = (Path(method),), plugin_name(method)
    named = [file for file in plugins if plugin_name(file) == method]
    plugin = next(iter([*named, *plugins]), None)
    answering = load_vehicle(vehicle)
    if esc:
        refuse_azimuths(answering.azimuths, "--esc", "no curve is of a force that turns")
    if esc and not answering.esc:
        raise VehicleError(f"{vehicle}: has no ESCs for --esc; add 'esc' to its file (docs/esc.md)", "esc")
    for fault in map(parse_fault, faults):
        if fault == EACH:
            raise click.UsageError("--fault each: thrusts are of one vehicle; name one thruster")
        (answering,) = with_fault(answering, fault)
    if names:
        refuse_azimuths(answering.azimuths, "--names", "columns are of components")
    if cap is not None:
        refuse_azimuths(answering.azimuths, "--cap", "no current is known of a force that turns")
    log = log_for(answering, demands, read_options(**options))
    lows, highs = row_limits(demands, log.columns, answering)
    if esc:
        low, high = answering.esc_limits(log.columns.get("volts"), lows, highs)
        if lows is None:  # one pair for all rows: the vehicle's own, so a plug-in need take no limits
            answering = replace(answering, f_min=low, f_max=high)
        else:
            lows, highs = low, high
    calls = [log.taus] if lows is None or highs is None else [log.taus, lows, highs]
    supply = row_supply(answering, cap, log.columns.get("volts"), len(log.taus))

    def answered() -> "tuple[list[Allocation], dict[str, Any]]":
        """The answers, and what the allocator promises where a plug-in's are to be held to it."""
        entry = load_plugin(plugin) if plugin else find(method)
        if entry.name != method:
            raise UnknownName(f"holds method '{entry.name}', not '{method}'; give --method {entry.name}")
        allocator: Any = prepare(entry, answering, start=start, level=level)
        answers: list[Allocation] = []
        memory: dict[str, Any] = {}
        for *call, at in zip(*calls, supply, strict=True):
            answers.append(allocator(*call, **at, **memory))
            if answering.azimuths and not plugin and answers[-1].found:  # pieces stay by hysteresis
                memory["f_previous"] = answers[-1].f
        if not plugin:
            return answers, {}
        from bench.judging.question import read_promises

        return [_answer(given, answering.n) for given in answers], read_promises(allocator)

    # A method may crash, end its process, go to another folder, or write into what it is given.
    answers, promises = run_in_copy(partial(_in_words, plugin, answered), f"{plugin or method}")
    if plugin:
        from bench.judging.faults import first_wrong

        if wrong := first_wrong(answering, log.taus, lows, highs, answers, **promises):
            raise PluginError(f"{plugin}: {wrong}; mend it")
    header = [harmless(answering.called(i)) if names else f"f{i}" for i in range(answering.n)]
    wired, doubt, frame = None, "", ""
    if esc:
        frame = options["frame"] or answering.frame
        caps = None if cap is None else [at["cap"] for at in supply]
        wired, doubt = esc_columns(
            answering, answers, log.t, log.columns.get("volts"), lows, highs, frame, caps
        )
    if answering.azimuths:
        from bench.inputs.demand_csv import polar_columns

        wired = polar_columns(answering, answers)
    text = format_thrusts(answers, header, wired, frame=frame)
    if output is None:
        echo(text, nl=False)
    else:
        write_text(output, text)
    echo(log.notes, err=True)  # at last, since a refusal is one line
    for line in filter(None, (log.doubt, doubt)):
        echo(f"warning: {line}", err=True)


def _answer(given: Any, n: int) -> "Allocation":
    """A plug-in's answer as one with n thrusts; raises TypeError or ValueError where it is none."""
    import numpy as np

    from alloc import Allocation, Status
    from alloc.allocation import real

    f, status, *_ = given
    thrusts = real(np.asarray(f))
    if thrusts.shape != (n,):
        raise ValueError(f"an answer has thrusts of shape {thrusts.shape}, not ({n},)")
    share = given[4] if len(given) > 4 else ()
    return Allocation(thrusts, Status(status), share=tuple(map(float, share)))


def _in_words(plugin: Path | None, work: Callable[[], Made]) -> Made:
    """Result of ``work``; raises PluginError, in one line, where a plug-in's own code raised."""
    from alloc import AllocError
    from alloc.errors import PluginError

    try:
        return work()
    except AllocError as error:
        if plugin is None or str(error).startswith(f"{plugin}:"):
            raise
        raise PluginError(f"{plugin}: {error}") from error
    except BaseException as error:  # SystemExit too: a plug-in must not end the command as if all were well
        if plugin is None or isinstance(error, KeyboardInterrupt):
            raise
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if Path(frame.filename).name == plugin.name]
        place = f"line {lines[-1]}: " if lines else ""
        raise PluginError(f"{plugin}: {place}{type(error).__name__}: {error}; mend it") from error
