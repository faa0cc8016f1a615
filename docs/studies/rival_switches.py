"""Switches of the generators of solvers' own C, each tried: ``python docs/studies/rival_switches.py [V]…``.

A row is one switch at one value, the others as alloc/rivals/generators sets them; double precision on a
Cortex-M7, instructions counted, so that a busy machine changes nothing. *as it is* is what the benchmark
takes: at level *default* every number of a solver's is its authors', whatever another would do. An answer is
SOLVED or PARTIAL, by equations; *brings a heap*: the linked image holds malloc. Each vehicle is asked 25
demands each of three classes; *median* and *worst* are over attainable ones.
"""

import re
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from alloc import Status, Vehicle, build, load_vehicle
from alloc.rivals import Files, load
from alloc.rivals.generators import osqp, qoco, qrqp
from alloc.solvers import Level
from alloc.solvers import osqp as osqp_binding
from bench.chips.count import count
from bench.chips.image import link
from bench.chips.kernels import build_kernel
from bench.chips.processors import Processor, processor
from bench.chips.toolchain import ToolError, run
from bench.demands import build_demands
from bench.results.text import table, three

VEHICLES = ("bluerov2-heavy", "tiburon", "supply-vessel", "ukwial")
ATTAINABLE, SEED, EACH = ("inactive", "active"), 16, 25
CURRENT = "as it is"


class Trial(NamedTuple):
    """One switch at one value.

    Attributes
    ----------
    solver, level, switch, value : what is tried
    patches : what makes it so; empty for the generator as it is
    """

    solver: str
    level: Level
    switch: str
    value: str
    patches: tuple[Any, ...] = ()


class Outcome(NamedTuple):
    """Answers and cost of a trial over all vehicles.

    Attributes
    ----------
    solved, partial : attainable demands with that status
    refused : of as many infeasible ones, proven so
    distance : largest distance of an answer to the optimum, relative to the largest limit [-]
    median, worst : instructions of an attainable demand
    heap : whether an image holds malloc
    """

    solved: int
    partial: int
    refused: int
    distance: float
    median: float
    worst: int
    heap: bool


def trials() -> list[Trial]:
    """All trials; the first of a solver and level is the generator as it is."""
    found: list[Trial] = []
    for level in ("tight", "default"):
        now = _osqp(level)
        found.append(Trial("osqp", level, CURRENT, "", now))
        fixed_step = _edited("osqp", r"osqp_update_rho\(&solver.*?\);", "(void)0;")
        vectors = patch.dict(osqp.SWITCHES, {"parameters": "vectors"}), fixed_step
        found.append(Trial("osqp", level, "parameters", "vectors", (*now, *vectors)))
    for switch in ("profiling_enable", "printing_enable", "interrupt_enable"):
        on = patch.dict(osqp.SWITCHES, {switch: True})
        found.append(Trial("osqp", "default", switch, "on", (*_osqp("default"), on)))
    for name, values in _OSQP.items():
        for value in values:
            told = _osqp("tight", **{name: value})
            if name == "rho":
                told = *told, patch.object(osqp_binding, "RHO", value)
            found.append(Trial("osqp", "tight", name, str(value), told))
    found += [Trial("qoco", "default", CURRENT, "")]
    ruiz = patch.dict(qoco.SWITCHES, {"generate_ruiz": True})
    found.append(Trial("qoco", "default", "generate_ruiz", "on", (ruiz,)))
    for name, texts in _QOCO.items():
        for text in texts:
            edit = _edited("qoco", rf"(settings\.(?:{name}) = )[^;]+", rf"\g<1>{text}")
            found.append(Trial("qoco", "default", name.replace("|", ", "), text, (edit,)))
    for solver in ("daqp", "daqp-reduced"):
        found += [Trial(solver, "default", CURRENT, "")]
        for name, texts in _DAQP.items():
            for text in texts:
                edit = _edited(solver, rf"(\.{name} = )[^,]+", rf"\g<1>{text}")
                found.append(Trial(solver, "default", name, text, (edit,)))
    anew = _edited("daqp", "int kept = 1;", "int kept = 0;")
    found.append(Trial("daqp", "default", "factors of the equations", "anew", (anew,)))
    found += [Trial("qrqp", "default", CURRENT, "")]
    for name, values in _QRQP.items():
        for value in values:
            set_so = patch.dict(qrqp.SETTINGS, {"double": qrqp.SETTINGS["double"] | {name: value}})
            found.append(Trial("qrqp", "default", name, str(value), (set_so,)))
    for name, value in _CASADI.items():
        found.append(Trial("qrqp", "default", name, str(value), (patch.dict(qrqp.SWITCHES, {name: value}),)))
    return found


_OSQP: dict[str, tuple[Any, ...]] = {
    "adaptive_rho": (0, 3),  # off; by the KKT error. 2 is by the clock
    "adaptive_rho_interval": (25, 100),
    "adaptive_rho_tolerance": (2.0, 10.0),
    "check_termination": (5, 10),
    "scaling": (10,),
    "alpha": (1.0, 1.8),
    "rho": (0.01, 1.0),
    "rho_is_vec": (False,),
    "check_dualgap": (True,),
    "sigma": (1e-8,),
}
_QOCO = {
    "iter_ref_iters": ("0", "2", "3", "5"),
    "kkt_static_reg": ("1e-7", "1e-9", "1e-10", "1e-13"),
    "kkt_dynamic_reg": ("1e-11",),
    "abstol|reltol": ("1e-5", "1e-6", "1e-9"),
    "max_iters": ("200",),
}
_DAQP = {
    "primal_tol": ("1e-10",),
    "pivot_tol": ("1e-6", "1e-10"),
    "refactor_tol": ("0", "1e-6"),
    "zero_tol": ("1e-9",),
}
_QRQP: dict[str, tuple[Any, ...]] = {
    "constr_viol_tol": (1e-6,),
    "dual_inf_tol": (1e-6,),
    "min_lam": (1e-9,),
}
_CASADI: dict[str, Any] = {"casadi_int": "long long int", "avoid_stack": True, "unroll_args": True}


def _osqp(level: Level, **numbers: Any) -> tuple[Any, ...]:
    return (patch.dict(osqp.SETTINGS, {"default": osqp.SETTINGS[level] | numbers}),)


def _edited(solver: str, pattern: str, text: str) -> Any:
    """The generator with that text in place of the pattern, which must be there."""
    module: Any = load(solver)
    generate: Callable[..., Files] = module.generate

    def edited(*given: Any) -> Files:
        files, times = generate(*given), 0
        parts = []
        for part in files:
            changed = {}
            for name, each in part.items():
                changed[name], found = re.subn(pattern, text, each)
                times += found
            parts.append(changed)
        if not times:
            raise LookupError(f"{solver}: no '{pattern}' in what it generates")
        return Files(*parts)

    return patch.object(module, "generate", edited)


def outcome(trial: Trial, vehicles: list[Vehicle], board: Processor) -> Outcome:
    """Ask all vehicles' demands; raises ToolError where the C does not link without an operating system."""
    statuses, costs, refused, distances, heap = [], [], 0, [0.0], False
    for vehicle in vehicles:
        sets = [build_demands(name, vehicle, SEED, EACH).taus for name in (*ATTAINABLE, "infeasible")]
        taus = np.concatenate(sets)
        able = np.arange(len(taus)) < len(taus) - len(sets[-1])
        with ExitStack() as stack:
            for each in trial.patches:
                stack.enter_context(each)
            kernel = build_kernel(f"qp/{trial.solver}@generated", vehicle, "double")
        with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
            image = link(kernel, board, Path(folder))
            symbols = run([f"{board.tools}nm", str(image.path)])
            heap |= bool(re.search(r" _?malloc(_r)?$", symbols, re.MULTILINE))
            counted = count(image, taus)
        exact, _ = build("nullspace", vehicle).many(taus)
        there = able & np.isin(counted.status, (Status.SOLVED, Status.PARTIAL))
        distances.append(float(np.abs(counted.F - exact)[there].max(initial=0.0)) / vehicle.f_scale)
        statuses.append(counted.status[able])
        costs.append(counted.instructions[able])
        refused += int((counted.status[~able] == Status.INFEASIBLE).sum())
    status, cost = np.concatenate(statuses), np.concatenate(costs)
    solved, partial = (int((status == each).sum()) for each in (Status.SOLVED, Status.PARTIAL))
    numbers = max(distances), float(np.median(cost)), int(cost.max())
    return Outcome(solved, partial, refused, *numbers, heap)


def verdict(found: Outcome, current: Outcome) -> str:
    """Reason why a switch is not taken, beside the generator as it is."""
    answered, now = found.solved + found.partial, current.solved + current.partial
    dearer = f"{found.median / current.median:.2f} and {found.worst / current.worst:.2f} times the cost"
    if found.heap and not current.heap:
        return f"brings a heap; {dearer}"
    if found.refused < current.refused and found.median < current.median and found.worst < current.worst:
        return f"proves {current.refused - found.refused} fewer infeasible, not its authors' number; {dearer}"
    if answered < now:
        return f"answers {now - answered} fewer; {dearer}"
    if found.solved != current.solved:
        farther = three(found.distance / current.distance)
        return f"{found.solved - current.solved:+d} solved, {farther} times as far from the optimum; {dearer}"
    return "no difference" if found[:-1] == current[:-1] else dearer


def main(names: list[str]) -> None:
    """Print a table for each solver and level."""
    vehicles, board = [load_vehicle(name) for name in names or VEHICLES], processor("cortex-m7")
    current: dict[str, Outcome] = {}
    lines: dict[str, list[list[str]]] = {}
    for trial in trials():
        solver = f"{trial.solver}, {trial.level}"
        label = f"`{trial.switch} {trial.value}`" if trial.value else trial.switch
        try:
            found = outcome(trial, vehicles, board)
        except ToolError:
            lines[solver].append([label, *[""] * 6, "does not link without an operating system"])
            continue
        why = "chosen" if trial.switch == CURRENT else verdict(found, current[solver])
        current.setdefault(solver, found)
        numbers = [str(each) for each in (found.solved, found.partial, found.refused)]
        costs = [three(each) for each in (found.distance, found.median, found.worst)]
        lines.setdefault(solver, []).append([label, *numbers, *costs, why])
        print(solver, *lines[solver][-1], sep=" | ", file=sys.stderr, flush=True)
    asked = len(vehicles) * EACH
    each = f"{len(ATTAINABLE) * asked} attainable demands and {asked} infeasible ones"
    print(f"Over {', '.join(vehicle.name for vehicle in vehicles)}: {each}.")
    headers = ("switch", "solved", "in part", "refused", "distance", "median", "worst", "chosen, or why not")
    for solver, rows in lines.items():
        print(f"\n## {solver}\n\n{table(headers, rows)}")


if __name__ == "__main__":
    main(sys.argv[1:])
