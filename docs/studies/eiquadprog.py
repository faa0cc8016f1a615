"""Worth of eiquadprog, C++ without a Python module, as a rival: ``python docs/studies/eiquadprog.py FOLDER``.

FOLDER gets its wheel and Eigen's by pip, and libraries made of ``eiquadprog.cpp`` and these: in newtons and
in the units of this suite, with the check of docs/rivals.md and as the solver claims. ``thrustbench run
--method FOLDER/eiquadprog.so`` times and judges one. The study asks the demands of ``rivals.py fixed`` on
each shipped vehicle, and those of ``campaign.py`` on random ones.
"""

import subprocess
import sys
from collections import Counter
from pathlib import Path
from zipfile import ZipFile

import numpy as np

from alloc import build, list_vehicles, load_vehicle
from bench.demands.generated import drawn_demands, generate_vehicle
from bench.results.text import table, three
from campaign import QUICK, judged
from rivals import Outcomes, outcomes
from rivals import asked as shipped

WHEELS = ("eiquadprog==1.3.2", "cmeel-eigen==3.4.1")
BUILDS = {
    "eiquadprog": (),
    "eiquadprog-newtons": ("-DNEWTONS",),
    "eiquadprog-claimed": ("-DCLAIMED",),
    "eiquadprog-newtons-claimed": ("-DNEWTONS", "-DCLAIMED"),
}
"""Options of the compiler by the library's name."""
HERE = Path(__file__)
INTERFACE = HERE.parents[2] / "alloc" / "foreign"
N, VEHICLES = 1000, 500
"""Demands of each class on a shipped vehicle, and random vehicles."""


def prepared(folder: Path) -> dict[str, Path]:
    """Fetch what is missing and build; the library of each name."""
    prefix = folder / "cmeel.prefix"
    if not prefix.exists():
        pip = [sys.executable, "-m", "pip", "--quiet", "download", "--no-deps", "--dest", str(folder)]
        subprocess.run([*pip, *WHEELS], check=True)
        for wheel in folder.glob("*.whl"):
            ZipFile(wheel).extractall(folder)
    places = [f"-I{INTERFACE}", f"-I{prefix}/include", f"-I{prefix}/include/eigen3"]
    linked = [f"-L{prefix}/lib", "-leiquadprog", f"-Wl,-rpath,{prefix}/lib"]
    for name, options in BUILDS.items():
        command = ["c++", "-std=c++17", "-O2", "-DNDEBUG", "-shared", "-fPIC", *options, *places]
        command += [str(HERE.with_suffix(".cpp")), *linked, "-o", str(folder / f"{name}.so")]
        subprocess.run(command, check=True)
    return {name: folder / f"{name}.so" for name in BUILDS}


def on_shipped(library: Path) -> list[str]:
    """Results on all shipped vehicles together, in the order of ``Outcomes``."""
    found = []
    for vehicle in map(load_vehicle, list_vehicles()):
        questions = shipped(vehicle, N, "fixed")
        F, status = build(str(library), vehicle).many(*questions[:3])
        found.append(outcomes(vehicle, *questions, F, status.astype(np.intp)))
    *numbers, distance, refused = zip(*found, strict=True)
    return [*(str(sum(each)) for each in numbers), three(max(distance)), str(sum(refused))]


def main(folder: Path) -> None:
    """Build, ask and print."""
    libraries = prepared(folder)
    lines = [[name, *on_shipped(library)] for name, library in libraries.items()]
    print(f"Shipped vehicles:\n\n{table(('library', *Outcomes._fields), lines)}\n", flush=True)
    found = {name: Counter[str]() for name in libraries}
    for number in range(VEHICLES):
        vehicle, rng = generate_vehicle(number)
        sets = drawn_demands(vehicle, rng)
        for name, library in libraries.items():
            found[name].update(judged(vehicle, str(library), sets, QUICK))
    faults = sorted({fault for own in found.values() for fault in own})
    lines = [[name, *(str(own[fault]) for fault in faults)] for name, own in found.items()]
    print(f"{VEHICLES} random vehicles:\n\n{table(('library', *faults), lines)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
