"""Public allocators beside ours on the same demands: ``python docs/studies/what_flies.py FOLDER``.

FOLDER holds, or gets, a clone of each project of ``PROJECTS`` at its commit, and what is built of them; none
of it is part of this project. ``docs/studies/what_flies`` has a file for each that puts its function behind
thrustbench_allocator.h, and calls it as its project does. CasADi and Eigen are those of the package casadi;
Cargo gets nalgebra. Demands are 1,000 of the set ``uniform``, which can all be met, and 1,000 of
``infeasible``, which can't. Prints the table of docs/what-flies.md, and how far the answers
that wls-alloc keeps for 1,000 problems of its own lie from their optima here.
"""

import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from alloc import Allocator, NotApplicable, Vehicle, build, load_vehicle
from alloc.allocation import FloatArray
from bench.demands import DemandSet, build_demands
from bench.harness.conduct import misconduct
from bench.harness.timing import no_garbage_collection, sample
from bench.judging.loss import direction_error_deg, relative_wrench_error, share_along
from bench.results.text import table, three

HERE = Path(__file__).with_suffix("")
INTERFACE = Path(__file__).parents[2] / "alloc" / "foreign"
VEHICLES = ("tiburon", "bluerov2-heavy")
OURS = ("pinv@native", "clip@native", "scaled@native", "priority@native")
THETA, CONDITION = 2e-9, 4e5
"""Least weight of preferred controls, and bound of the condition, in the problems that wls-alloc keeps."""
SEED, N = 1, 1000
"""Seed, and number of demands of each set."""
MET = 0.01
"""Error of a wrench that counts as met, relative to the demand [-]."""
OUTSIDE = 1e-4
"""Excess over a limit that counts, relative to the largest limit [-]: a thousand roundings of a float."""
ROUNDS, ROUND_NS = 5, 100_000_000
"""Rounds in which allocators are timed one after the other, and the time of each in a round [ns]."""


class Project(NamedTuple):
    """Public repository: where it is, under which licence, and at which commit it was asked."""

    name: str
    licence: str
    commit: str


PROJECTS = (
    Project("Suchit-Arunkumar/AUV-Thruster-Allocation", "MIT", "8a94e72"),
    Project("vortexntnu/vortex-auv", "MIT", "8a0f2e81"),
    Project("mengchaoheng/control_allocation", "none stated", "5c24a37"),
    Project("mengchaoheng/PX4-Matrix", "BSD-3-Clause", "c991197"),
    Project("noidvan/wls-alloc", "MIT", "77310d0"),
)
C = "cc -std=c99 -O2 -shared -fPIC -DTBA_FLOAT -I{interface} -IAUV-Thruster-Allocation/include {here}/auv.c"
CPP = "c++ -std=c++20 -O2 -DNDEBUG -w -shared -fPIC -I{interface}"
VORTEX = "vortex-auv/motion/thrust_allocator_auv"
BUILDS = {
    **{
        f"auv-{name}": f"{C} AUV-Thruster-Allocation/src/alloc.c AUV-Thruster-Allocation/src/alloc_v2.c"
        f" -DFUNCTION=alloc_{function}wrench_to_thrust -o {{library}} -lm"
        for name, function in (("flown", ""), ("v2", "v2_"), ("v2p", "v2p_"))
    },
    **{
        f"vortex-{name}": f"{CPP} -DALLOCATOR={kind} -I{{here}}/stubs"
        f" -I{VORTEX}/include -I{{casadi}}/include {{here}}/vortex.cpp {VORTEX}/src/solvers/qp_allocator.cpp"
        f" {VORTEX}/src/solvers/pseudoinverse_allocator.cpp {{casadi}}/libcasadi.so -Wl,-rpath,{{casadi}}"
        " -o {library}"
        for name, kind in (("qp", "QPAllocator"), ("pinv", "PseudoinverseAllocator"))
    },
    **{
        f"ca-{name}": f"{CPP} -DTBA_FLOAT -DFUNCTION={function} -IPX4-Matrix"
        " -Icontrol_allocation/alloc_cpp/src/ControlAllocation {here}/dp_lpca.cpp -o {library}"
        for name, function in (("lp", "DP_LPCA"), ("lp-scaled", "DPscaled_LPCA"))
    },
    "wls-alloc": "cargo build --release --manifest-path {here}/wls/Cargo.toml --target-dir built/cargo"
    " --config 'patch.crates-io.wls-alloc.path=\"{folder}/wls-alloc\"'",
}
"""Command, run in FOLDER, that builds the library of each row, by the row's name."""


HEADERS = ("allocator", "missed", "share", "angle [°]", "beyond limits", "unanswered", "call [µs]")


class Row(NamedTuple):
    """Figures of one allocator.

    Attributes
    ----------
    missed : share of demands that can be met whose wrench is more than MET off, or that get none [-]
    share : mean over demands that can't be met of what is delivered along them, over the most there is [-]
    angle_deg : largest angle between wrench and demand among these [deg]
    beyond : answers with a thrust beyond a limit
    unanswered : demands of both kinds without thrusts
    call_us : median CPU time of a call for a demand that can be met, the way in included [us]
    conduct : what else is amiss, in words
    """

    missed: float
    share: float
    angle_deg: float
    beyond: int
    unanswered: int
    call_us: float
    conduct: str

    def cells(self) -> list[str]:
        """The row as text, in the order of HEADERS."""
        shares = [f"{self.missed:.1%}", f"{self.share:.3f}", f"{self.angle_deg:.0f}"]
        return [*shares, str(self.beyond), str(self.unanswered), three(self.call_us)]


def prepared(folder: Path) -> dict[str, Path]:
    """Clone what is missing and build every library; the library of each row."""
    import casadi

    for project in PROJECTS:
        if not (clone := folder / project.name.partition("/")[2]).exists():
            subprocess.run(["git", "clone", f"https://github.com/{project.name}", clone], check=True)
            subprocess.run(["git", "-C", clone, "checkout", "--quiet", project.commit], check=True)
    (folder / "built").mkdir(exist_ok=True)
    made = {}
    for name, command in BUILDS.items():
        made[name] = library = folder / "built" / f"{name}.so"
        words = {"interface": INTERFACE, "here": HERE, "folder": folder, "library": library}
        if not library.exists():
            filled = command.format(**words, casadi=Path(casadi.__file__).parent)
            subprocess.run(shlex.split(filled), cwd=folder, check=True)
            if (crate := folder / "built/cargo/release/libwls.so").exists() and not library.exists():
                crate.rename(library)
    return made


def allocators(vehicle: Vehicle, libraries: dict[str, Path]) -> dict[str, Allocator]:
    """Every allocator that takes a vehicle, public ones first, by its name."""
    made = {}
    for name, what in [*libraries.items(), *((name, name) for name in OURS)]:
        try:
            made[name] = build(str(what), vehicle)
        except NotApplicable as reason:
            print(f"- {name}: {reason}")
    return made


def rows(sets: Sequence[DemandSet], asked: dict[str, Allocator]) -> dict[str, Row]:
    """The row of each allocator, timed in turns; ``sets`` are demands that can be met, and others."""
    calls: dict[str, list[float]] = {name: [] for name in asked}
    with no_garbage_collection():
        for _ in range(ROUNDS):
            for name, allocator in asked.items():
                batches = sample(allocator, [list(sets[0].taus)], ROUND_NS, singles=0).batches
                calls[name] += [batch.cpu_ns / batch.calls / 1000 for batch in batches]
    return {name: _row(sets[0], sets[1], allocator, median(calls[name])) for name, allocator in asked.items()}


def _row(met: DemandSet, unmet: DemandSet, allocator: Allocator, call_us: float) -> Row:
    vehicle, taus = met.vehicle, np.vstack([met.taus, unmet.taus])
    answers = [allocator(tau) for tau in taus]
    near, far = np.split(np.array([answer.f for answer in answers]), [len(met.taus)])
    missed = ~(relative_wrench_error(vehicle, met.taus, near) <= MET)
    share = np.nan_to_num(share_along(vehicle, unmet.taus, far)) / unmet.alpha
    angle = direction_error_deg(vehicle, unmet.taus, far)
    slack = OUTSIDE * vehicle.f_scale
    F = np.vstack([near, far])
    beyond = ((vehicle.f_min - slack > F) | (vehicle.f_max + slack < F)).any(axis=1)
    conduct = "; ".join(misconduct(allocator, [list(taus)], answers, met))
    none = int(np.isnan(F).any(axis=1).sum())
    return Row(missed.mean(), share.mean(), np.nanmax(angle), int(beyond.sum()), none, call_us, conduct)


def recorded(folder: Path) -> FloatArray:
    """Distances of the answers that wls-alloc keeps from the optimum (N, 2): of wrench and thrusts [-].

    The weighted wrench is relative to the weighted demand, the farthest thrust to the widest range.

    The problem is its README's: min |A u - b| within bounds; A has the weighted effectiveness matrix above a
    small weighted unit matrix, b the weighted demand above as much of the preferred controls.
    """
    tests = folder / "wls-alloc/tests/regression"
    numbers = re.compile(r"-?\d+\.\d+e[+-]\d+")
    cases = np.array(numbers.findall((tests / "c_test_cases.rs").read_text()), float).reshape(1000, -1)
    kept = np.array(numbers.findall((tests / "c_ref.rs").read_text()), float).reshape(1000, -1)
    return np.array([_distances(case, u) for case, u in zip(cases, kept, strict=True)])


def _distances(case: FloatArray, u: FloatArray) -> tuple[float, float]:
    turned, wv, wu, v, low, high, _, preferred, _ = np.split(case, np.cumsum([24, 4, 6, 4, 6, 6, 6, 6]))
    A, wu = wv[:, None] * turned.reshape(6, 4).T, wu / wu.min()
    disk = np.abs(A @ A.T).sum(axis=1).max()
    gamma = np.sqrt(disk) * max(CONDITION**-0.5, THETA / wu.max())
    whole, b = np.vstack([A, gamma * np.diag(wu)]), np.concatenate([wv * v, gamma * wu * preferred])
    best: FloatArray = lsq_linear(whole, b, (low, high), method="bvls", tol=1e-14).x
    wrench = np.linalg.norm(A @ (u - best)) / np.linalg.norm(wv * v)
    return float(wrench), float(np.abs(u - best).max() / (high - low).max())


def main(folder: Path) -> None:
    """Build, ask and print."""
    libraries = prepared(folder)
    for name in VEHICLES:
        vehicle = load_vehicle(name)
        sets = [build_demands(each, vehicle, SEED, N) for each in ("uniform", "infeasible")]
        print(f"\n## {name}\n")
        found = rows(sets, allocators(vehicle, libraries))
        print(table(HEADERS, [[who, *row.cells()] for who, row in found.items()]))
        print(*(f"\n- {who}: {row.conduct}" for who, row in found.items() if row.conduct))
    wrench, thrust = recorded(folder).max(axis=0)
    print(f"\nkept by wls-alloc: wrenches within {wrench:.2g} of the optimum's, thrusts within {thrust:.2g}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
