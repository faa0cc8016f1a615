"""``thrustbench prove``."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from bench.commands import FAULTS, LIMITS, PATH, RUNS, SINGLE, echo, refuse_another_s, unread_output

if TYPE_CHECKING:
    from bench.proof import Proof, Subject
    from bench.proof.worst import Counted
    from bench.record import Emulated


@click.command()
@click.option(
    "--vehicle", "vehicles", multiple=True, metavar="V", help="A shipped name or a YAML file [all]."
)
@click.option("--method", "methods", multiple=True, metavar="M", help="A method that has C [all].")
@click.option(
    "--library",
    is_flag=True,
    help="In place of methods: the C that takes the matrix at run time, with room for 8 thrusters, or for V.",
)
@SINGLE
@LIMITS
@FAULTS
@click.option("--thorough", is_flag=True, help="Ten times the demands: minutes.")
@click.option(
    "--counts", type=PATH, metavar="DIR", help="What `emulate` counted, asked again [runs/emulated if there]."
)
@click.option(
    "--out", type=PATH, default=RUNS / "proof", show_default=True, metavar="DIR", help="Made if missing."
)
@unread_output()
def command(
    vehicles: tuple[str, ...],
    methods: tuple[str, ...],
    library: bool,
    single: bool,
    limits: Literal["fixed", "call"],
    faults: Literal["none", "one", "all"],
    thorough: bool,
    counts: Path | None,
    out: Path,
) -> int:
    """Prove what generated C does for every input.

    Writes proof.json and a page beside the C: no run-time error, thrusts inside the limits that make their
    wrench, answers to many demands, the worst path, MISRA rules. Several kernels get a folder each, and
    proofs.md has a line of each. Exit code 3 where an error or a thrust outside the limits can't be excluded,
    or an answer was wrong; also for ESCs of several kinds, whose range can't be shown. `make prove` installs
    what this needs, and proves all.
    """
    from concurrent.futures import ProcessPoolExecutor
    from functools import partial
    from itertools import groupby
    from os import cpu_count
    from signal import SIG_DFL, SIGTERM, signal

    from alloc import AllocError, NotApplicable, catalogue, list_vehicles
    from alloc.files.textfile import write_folder
    from alloc.vehicle.file import load_fixed_vehicle
    from bench.proof import prove_library, subject, summary, tools, write
    from bench.proof.safety import esc
    from bench.proof.worst import counted_before

    scalar: Literal["double", "float"] = "float" if single else "double"
    if library:
        if methods or len(vehicles) > 1 or limits != "fixed" or faults != "one" or thorough or counts:
            raise click.UsageError(
                "--library goes with --vehicle (one), --float and --out; leave out the others."
            )
        room = load_fixed_vehicle(vehicles[0]) if vehicles else None
        tools.need("frama-c")
        write_folder(out, {})
        shown, files = prove_library(scalar, room, lambda step: echo(f"library: {step} ...", err=True))
        write(files, shown, out)
        echo(f"{out / 'proof.md'}: {shown.least}, {shown.seconds:.0f} s")
        return 0 if shown.safe else 3
    kernels = {entry.name: entry.twin for entry in catalogue() if entry.twin}
    loaded = [load_fixed_vehicle(name) for name in vehicles or list_vehicles()]
    wanted = [kernels.get(name, name) for name in methods or kernels]
    subjects = []
    for vehicle in loaded:
        for kernel in wanted:
            try:
                subjects.append(subject(vehicle, kernel, scalar, limits, faults))
            except NotApplicable as refusal:
                if methods and len(loaded) == 1:
                    raise
                echo(str(refusal))
    tools.need("frama-c")
    write_folder(out, {})  # fails before the minutes of work, not after them
    several = len(subjects) > 1
    for place, own in groupby(sorted(subjects, key=lambda of: of.name), key=lambda of: of.name):
        first, *others = own
        if any(other.vehicle.name != first.vehicle.name for other in others):
            names = ", ".join(repr(of.vehicle.name) for of in (first, *others))
            raise AllocError(f"{place}: is the name in C of {names}; give another name to one")
        refuse_another_s(out / place if several else out, first.files)
    proofs = []
    rows = _rows(counts)
    before = [counted_before(rows, of) for of in subjects]
    pool = ProcessPoolExecutor(cpu_count(), initializer=signal, initargs=(SIGTERM, SIG_DFL))
    try:
        made = pool.map(partial(_proof, thorough=thorough), subjects, before)
        for of, proof in zip(subjects, made, strict=True):
            proofs.append(proof)
            folder = out / of.name if several else out
            write({**of.files, **esc.files(of)}, proof, folder)
            echo(f"{folder / 'proof.md'}: {proof.least}, {proof.seconds:.0f} s")
    finally:  # who ends the command ends what has not begun
        pool.shutdown(cancel_futures=True)
    if several:
        (out / "proofs.md").write_text(summary(proofs), encoding="utf-8")
        echo(out / "proofs.md")
    return 0 if all(proof.safe for proof in proofs) else 3


def _rows(counts: Path | None) -> "list[Emulated]":
    """Counts in a folder that is named, else in the usual one, where there need be none."""
    from bench.record import read

    usual = RUNS / "emulated"
    if counts is None and not any(usual.glob("record.jsonl*")):
        return []
    return read(counts or usual).emulated


def _proof(of: "Subject", before: "Counted", *, thorough: bool) -> "Proof":
    """The proof, with a line of each step on stderr."""
    from bench.proof import THOROUGH, USUAL, prove

    demands = THOROUGH if thorough else USUAL
    return prove(of, demands, lambda step: echo(f"{of.name}: {step} ...", err=True), before)
