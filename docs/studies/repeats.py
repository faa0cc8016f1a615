"""First choices of ten runs of one command: two that differ must say that nothing is decided.

``python docs/studies/repeats.py [VEHICLE …]`` measures each vehicle ten times by ``thrustbench run --quick``,
a minute each, and prints the first choices. It ends with 1 where two differ and not all runs say so.
"""

import sys
from collections import Counter
from pathlib import Path
from subprocess import DEVNULL, run
from tempfile import TemporaryDirectory

from bench.report.verdict import opening_loop, opening_sizes, spoken_name
from bench.results.rows import read_run
from bench.results.size import possible_first

REPEATS = 10


def first_choice(vehicle: str, folder: Path) -> tuple[str, bool]:
    """First choice of a new run, and whether it says that so few decide nothing."""
    asked = ["run", "--quick", "--vehicle", vehicle, "--out", str(folder)]
    run([sys.executable, "-m", "bench", *asked], check=True, stdout=DEVNULL, stderr=DEVNULL)
    made = read_run(folder)
    sized = opening_sizes(made)
    return spoken_name(sized[0]), bool(possible_first(sized, opening_loop(made)))


def main(vehicles: list[str]) -> int:
    """Measure and print; 1 where first choices differ unsaid."""
    unsaid = 0
    for vehicle in vehicles:
        with TemporaryDirectory() as folder:
            seen = [first_choice(vehicle, Path(folder) / str(i)) for i in range(REPEATS)]
        counts = Counter(f"{name}{', open' if is_open else ''}" for name, is_open in seen)
        print(f"{vehicle}: {'; '.join(f'{n} × {what}' for what, n in counts.most_common())}", flush=True)
        differ = len({name for name, _ in seen}) > 1
        unsaid += differ and not all(is_open for _, is_open in seen)
    return min(unsaid, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ["ukwial", "bluerov2"]))
