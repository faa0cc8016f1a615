"""What llvm-mca says of the cycles of a kernel's costliest call, beside our interval: docs/embedded.md.

llvm-mca knows no branches, so each that was executed counts as one cycle; what its model of a processor does
not know is left out, counted and named. Run with ``python -m bench.studies.second_opinion``.
"""

import re
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

from alloc import load_vehicle
from alloc.native.code import Scalar
from bench.chips.count import count
from bench.chips.cycles import cycles
from bench.chips.image import link
from bench.chips.kernels import build_kernel
from bench.chips.toolchain import run, target
from bench.chips.trace import trace
from bench.demands import build_demands

VEHICLES = ("ukwial", "bluerov2-heavy", "supply-vessel")
METHODS = ("pinv@native", "clip@native", "nullspace@native", "priority@native")
PROCESSORS: tuple[tuple[str, str, Scalar], ...] = (
    ("cortex-m4f", "cortex-m4", "float"),
    ("cortex-m7", "cortex-m7", "double"),
)
_LINE = re.compile(r"^ *([0-9a-f]+):\t([^@;\n]*)", re.M)


def opinion(lines: list[str], processor: str) -> int | None:
    """Cycles of these lines of assembly once through; None where the model lacks one of them."""
    command = ["llvm-mca", "-mtriple=thumbv7em-none-eabihf", f"-mcpu={processor}", "-iterations=1"]
    # What would be under a condition is executed here, whatever the condition.
    done = subprocess.run(command, input="\n".join(lines) + "\n", capture_output=True, text=True)
    found = re.search(r"Total Cycles: +(\d+)", done.stdout)
    return int(found[1]) if found and not done.returncode else None


def without_condition(line: str) -> str:
    """The line as it stands outside of an IT block."""
    return re.sub(r"^(v?[a-z]+?)(eq|ne|mi|pl|gt|le|lt|ge|hi|ls|cs|cc|vs|vc)((?:\.\w+)*\t)", r"\1\3", line)


def main() -> None:
    """Print a line for each kernel, and what the models do not know."""
    unknown: dict[str, Counter[str]] = {processor: Counter() for _, processor, _ in PROCESSORS}
    for name, method in ((v, m) for v in VEHICLES for m in METHODS):
        vehicle = load_vehicle(name)
        taus = build_demands("active", vehicle, 0, 20).taus
        for where, processor, scalar in PROCESSORS:
            with tempfile.TemporaryDirectory() as folder:
                image = link(build_kernel(method, vehicle, scalar), target(where), Path(folder))
                counted = count(image, taus)
                ours = cycles(image, taus, counted)
                followed = trace(image, taus, counted.instructions)
                text = run([f"{image.target.tools}objdump", "-d", "--no-show-raw-insn", str(image.path)])
            lines = {int(address, 16): line.strip() for address, line in _LINE.findall(text)}
            executed = [followed.known[i] for i in followed.calls[0].tolist()]
            plain = [one for one in executed if not one.name.startswith(("b", "cb", "tb", "it", "pop"))]
            asked = [
                without_condition(lines[one.address]) if one.conditional else lines[one.address]
                for one in plain
            ]
            knows = {line: opinion([line], processor) is not None for line in set(asked)}
            lacking = [line for line in asked if not knows[line]]
            unknown[processor].update(line.split("\t")[0] for line in lacking)
            known = opinion([line for line in asked if knows[line]], processor) or 0
            branches = len(executed) - len(plain)
            said = f"ours {ours}, llvm-mca {known + branches}, {len(lacking)} not known"
            print(f"{name} {method} {where} {scalar}: {said}", flush=True)
    for processor, names in unknown.items():
        print(f"{processor} lacks: {', '.join(f'{name} ({times})' for name, times in names.most_common())}")


if __name__ == "__main__":
    main()
