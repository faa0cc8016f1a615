"""A board's project: what is asked, and the C99 that asks it and prints what that took."""

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from alloc import NotApplicable, Vehicle
from alloc.allocation import FloatArray
from alloc.errors import NotInstalled
from alloc.files.textfile import write_folder
from alloc.program import Faults, Scalar, Where
from alloc.program.literal import number
from alloc.vehicle.frame import described
from bench.chips import esc
from bench.chips.image import FIRMWARE
from bench.chips.kernels import Kernel, build_kernel, shapes
from bench.chips.processors import processors
from bench.demands import DemandSet, build_demands
from bench.demands.store import pack_vehicle
from bench.harness import machine


@dataclass(frozen=True, kw_only=True)
class Project:
    """Questions of a project.

    Attributes
    ----------
    vehicle : who must answer
    kernels : the C of each method, all in one scalar and with limits in one form; NAME_esc is the last
    sets : the demands of each class
    thrusts : the calls of NAME_esc (n, width), by the name of their set; empty where it is not asked
    limits : whether they stand in the C, or each call gives them
    faults : which the C knows; demands are asked of the vehicle as it is
    seed : of the demands
    omissions : methods and sets that this vehicle does not have, with the reason
    """

    vehicle: Vehicle
    kernels: tuple[Kernel, ...]
    sets: tuple[DemandSet, ...]
    thrusts: Mapping[str, FloatArray]
    limits: Where
    faults: Faults
    seed: int
    omissions: tuple[str, ...]


def plan(
    vehicle: Vehicle,
    methods: Sequence[str],
    sets: Sequence[str],
    scalar: Scalar,
    limits: Where,
    n: int,
    seed: int,
    faults: Faults = "one",
) -> Project:
    """The project of these methods and sets; what the vehicle can't have is left out, and said.

    Raises UnknownName for a name that nothing has, NotApplicable where no method or no set is left.
    """
    kernels, asked, left_out = list[Kernel](), list[DemandSet](), list[str]()
    for method in methods:
        if method == esc.METHOD:
            continue
        try:
            kernel = build_kernel(method, vehicle, scalar, limits, faults)
            if kernel.prepared:
                left_out.append(f"{method}: prepares at its first call, which would be timed with the others")
            else:
                kernels.append(kernel)
        except (NotApplicable, NotInstalled) as refusal:
            left_out.append(f"{method}: {refusal}")
    for name in sets if kernels else ():
        try:
            demands = build_demands(name, vehicle, seed, n)
        except NotApplicable as refusal:
            left_out.append(f"{name}: {refusal}")
            continue
        if demands.vehicle.faults != vehicle.faults:
            left_out.append(f"{name}: is asked of the vehicle after a failure")
        elif limits == "fixed" and demands.f_min is not None:
            left_out.append(f"{name}: each demand has limits of its own, which takes --limits call")
        else:
            asked.append(demands)
    if not asked:
        kernels.clear()
    thrusts: Mapping[str, FloatArray] = {}
    if esc.METHOD in methods:
        try:
            kernels.append(_beside(esc.kernel(vehicle, scalar, limits, faults), kernels))
            thrusts = esc.calls(vehicle, limits, n, seed)
        except NotApplicable as refusal:
            left_out.append(f"{esc.METHOD}: {refusal}")
    if not kernels:
        raise NotApplicable(f"{vehicle.name}: nothing is left to ask; {'; '.join(left_out)}")
    return Project(
        vehicle=vehicle,
        kernels=tuple(kernels),
        sets=tuple(asked),
        thrusts=thrusts,
        limits=limits,
        faults=faults,
        seed=seed,
        omissions=tuple(left_out),
    )


def _beside(kernel: Kernel, others: Sequence[Kernel]) -> Kernel:
    """The kernel without C that another one brings into the program: of the method behind NAME_esc."""
    given = {item for other in others for item in other.sources.items() if item[0].endswith(".c")}
    return replace(kernel, sources={n: text for n, text in kernel.sources.items() if (n, text) not in given})


CALLS = 10_000
"""Calls of each method on each set that are timed singly: what a p99.9 needs."""
_PIECE = 96


def write(project: Project, folder: Path) -> None:
    """Write the project's files into ``folder``; raises FileError where that can't be."""
    write_folder(folder, files(project))


def files(project: Project) -> dict[str, str]:
    """Every file of the project, as {path: text}."""
    ports = [path for path in sorted((FIRMWARE / "ports").iterdir()) if path.name not in _EMULATION_ONLY]
    common = [FIRMWARE / name for name in ("board.h", "driver.c", "call.h", "call.S", "count.c")]
    made = {
        path.relative_to(FIRMWARE).as_posix(): path.read_text(encoding="utf-8") for path in common + ports
    }
    made["Makefile"] = (FIRMWARE / "project.mk").read_text(encoding="utf-8")
    made |= _machines()
    made["project.h"] = f"#include <stdint.h>\n{shapes(project.kernels)}"
    made["project.c"] = _tables(project)
    for kernel in project.kernels:
        place = f"kernels/{kernel.entry}"
        made |= {f"{place}/{name}": text for name, text in kernel.sources.items()}
        made[f"{place}/adapter.c"] = kernel.adapter
    made["kernels.mk"] = "\n".join(map(_rules, project.kernels)) + "\n"
    return made


_EMULATION_ONLY = ("linux.c", "from_file.c")


def _machines() -> dict[str, str]:
    """A makefile for each processor that QEMU has a board of, with the flags that ``emulate`` has for it.

    It is named after the board; of several processors on one board all but the first add their own name.
    """
    made = dict[str, str]()
    for processor in processors():
        if not processor.bare_metal:
            continue
        qemu, option, name = processor.emulator[:3]
        own = f"ports/{name}.mk"
        made[own if own not in made else f"ports/{name}-{processor.name}.mk"] = (
            f"PROCESSOR := {processor.name}\nTARGET := {' '.join(processor.flags)}\n"
            f"BOARD := {' '.join(processor.board)}\nQEMU := {qemu} {option} {name}\ninclude ports/mps2.mk\n"
        )
    return made


def _rules(kernel: Kernel) -> str:
    place = f"kernels/{kernel.entry}"
    names = [*sorted(name for name in kernel.sources if name.endswith(".c")), "adapter.c"]
    folders = {f"{place}/{name}".rpartition("/")[0] for name in kernel.sources} | {place}
    objects = f"$(BUILD)/{place}/%.o"
    lines = [
        f"KERNELS += {kernel.entry}",
        f"SOURCES += {' '.join(f'{place}/{name}' for name in names)}",
        f"{objects}: INCLUDES = {' '.join(f'-I{folder}' for folder in sorted(folders))}",
    ]
    if kernel.solver:  # somebody else's C, whose warnings are not this project's
        lines.append(f"{objects}: WARNINGS = -w")
    return "\n".join(lines)


def _tables(project: Project) -> str:
    """project.c: the demands, the methods, and what a reader of the log must know."""
    kernels, scalar = project.kernels, project.kernels[0].scalar
    calls = {each.name: kernels[0].calls(each.taus, *each.limits) for each in project.sets}
    own = range(len(calls)), range(len(calls), len(calls) + len(project.thrusts))
    calls |= project.thrusts
    passes = -(-CALLS // max(map(len, calls.values())))
    facts = [f'    "{fact}",' for fact in _facts(project)]
    declared = [f"int ask_{kernel.entry}(const scalar *tau, scalar *f);" for kernel in kernels]
    methods = []
    for kernel in kernels:
        sets = own[kernel.method == esc.METHOD]
        asked = f"ask_{kernel.entry}, {kernel.levels}, {sets.start}, {len(sets)}"
        methods.append(f'    {{ "{kernel.method}", {asked} }},')
    demands = [
        f'    {{ "{name}", {len(rows)}, {rows.shape[1]}, calls{i} }},'
        for i, (name, rows) in enumerate(calls.items())
    ]
    counts = {"method": len(kernels), "fact": len(facts), "demands": len(calls)}
    lines = [
        "/* Generated by thrustbench; do not edit. Demands are in the vehicle's frame,",
        f" * {described(project.vehicle.frame)}. */",
        '#include "board.h"',
        "",
        *(_table(f"calls{i}", rows, scalar) for i, rows in enumerate(calls.values())),
        *declared,
        "const struct board_method project_methods[] = {",
        *methods,
        "};",
        "static const struct board_demands demands[] = {",
        *demands,
        "};",
        "const struct board_demands *const project_demands = demands;",
        "const char *const project_facts[] = {",
        *facts,
        "};",
        *(f"const uint32_t project_{name}_count = {count};" for name, count in counts.items()),
        f"#ifndef BOARD_PASSES\n#define BOARD_PASSES {passes}\n#endif",
        "const uint32_t project_passes = BOARD_PASSES;",
        "#ifdef BOARD_STACK",
        "uint32_t board_stack_bytes;",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _table(name: str, calls: FloatArray, scalar: Scalar) -> str:
    rows = (f"    {', '.join(number(value, scalar) for value in row)}," for row in calls.tolist())
    return f"static const scalar {name}[] = {{\n" + "\n".join(rows) + "\n};"


def _facts(project: Project) -> list[str]:
    """Facts that a log must hold besides measurements, so that its reader needs nothing else."""
    first = project.kernels[0]
    known = pack_vehicle(project.vehicle, currents=False)  # no C takes a cap
    arrays = {key: value.tolist() for key, value in known.items()}
    packed = base64.b64encode(zlib.compress(json.dumps(arrays).encode(), 9)).decode()
    return [
        f"commit {machine.commit() or '-'}",
        f"seed {project.seed}",
        f"scalar {first.scalar}",
        f"limits {project.limits}",
        *[f"faults {project.faults}"] * (project.faults != "one"),
        *(f"method {_described(kernel)}" for kernel in project.kernels),
        *(f"demands {demands.name} {_rate(demands)}{_log(demands)}" for demands in project.sets),
        *(f"demands {name} -" for name in project.thrusts),
        *(f"vehicle {packed[i : i + _PIECE]}" for i in range(0, len(packed), _PIECE)),
    ]


def _described(kernel: Kernel) -> str:
    return f"{kernel.method} {kernel.twin or '-'} {kernel.solver or '-'} {kernel.levels}"


def _log(demands: DemandSet) -> str:
    return f" {demands.left_out} {demands.beyond} {demands.beyond_longest}" if demands.given else ""


def _rate(demands: DemandSet) -> str:
    return "-" if demands.rate_hz is None else repr(float(demands.rate_hz))
