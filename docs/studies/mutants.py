"""Which one-line breaks of alloc and bench the tests find: ``python docs/studies/mutants.py [WORD]...``.

Each mutant is put into a copy of the tree, and there the tests of its room are run, for the library also
the contract of all methods. ``--whole`` runs all tests instead, ``--tree COMMIT`` takes another commit's
tree, and words choose mutants by name. A mutant's line is looked for in both packages, so that its file may
move; one that does not stand exactly once counts as a survivor. Exit code 1 where a mutant survives.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
CONTRACT = "tests/alloc/methods"
"""The tests that every method of the catalogue has to pass."""
UNSHRUNK = """
from hypothesis import HealthCheck, Phase, settings
phases = [Phase.explicit, Phase.generate]
busy = [HealthCheck.too_slow]
settings.register_profile(
    "unshrunk", deadline=None, derandomize=True, phases=phases, suppress_health_check=busy
)
"""
"""A plug-in of pytest's: one counterexample is enough, the smallest takes minutes."""


class Mutant(NamedTuple):
    """One change of the source.

    Attributes
    ----------
    name : what was broken
    line : text that stands once in the two packages
    instead : what stands in its place
    also : tests that see it, where those of its room do not
    """

    name: str
    line: str
    instead: str
    also: tuple[str, ...] = ()


MUTANTS = (
    # alloc
    Mutant("moments of thrusters have the other sign", "np.cross(arms, e).T", "np.cross(e, arms).T"),
    Mutant(
        "the other frame turns another axis",
        'if axis in ("surge", "roll") else -1.0',
        'if axis in ("surge", "pitch") else -1.0',
    ),
    Mutant(
        "the rates of rising and falling thrust are swapped",
        "return f - self.down * dt, f + self.up * dt",
        "return f - self.up * dt, f + self.down * dt",
    ),
    Mutant(
        "of several upper limits the highest counts",
        "return np.max(lows, axis=0), np.min(highs, axis=0)",
        "return np.max(lows, axis=0), np.max(highs, axis=0)",
    ),
    Mutant(
        "limits of a call pass whatever their size",
        "and hypot(*low.tolist(), *high.tolist()) <= most",
        "and hypot(*low.tolist(), *high.tolist()) < 1e300",
    ),
    Mutant(
        "text is taken for numbers",
        'if kind == "O" and any(isinstance(value, (str, bytes)) for value in values.flat):',
        "if False:",
    ),
    Mutant(
        "a frozen thruster stays at the wrong limit",
        "frozen[i] = low if x < low else high",
        "frozen[i] = high if x < low else low",
    ),
    Mutant(
        "walsh divides by the wrong number of thrusters",
        "W_f.T / (np.abs(W_f).sum(axis=1) * q)",
        "W_f.T / (W_f.shape[1] * q + 0.0 * W_f.sum(axis=1))",
    ),
    Mutant(
        "a level after the first starts from the first one's demand",
        "                missing = missing - s * step\n",
        "",
    ),
    Mutant(
        "a demand within rounding of the edge is proven infeasible",
        "(wanted - farthest > doubt)",
        "(wanted - farthest > -doubt)",
    ),
    Mutant(
        "a slack weighs by another unit", "vehicle.slack_weights / rows**2", "vehicle.slack_weights / rows"
    ),
    Mutant("the gap takes the wrong bound", "-r * above[:, None]", "-r * below[:, None]"),
    Mutant("the exact method goes to the far bound", "b = lo if s < lo else hi", "b = hi if s < lo else lo"),
    Mutant(
        "a row that no z moves is not checked",
        "if lower[row] > tolerance or upper[row] < -tolerance:",
        "if lower[row] > tolerance:",
    ),
    Mutant(
        "an iteration cap of DAQP counts as infeasible",
        "-4: Status.NOT_CONVERGED,  # iteration cap",
        "-4: Status.INFEASIBLE,  # iteration cap",
    ),
    Mutant(
        "a solver's word for infeasible is believed",
        "status = Status.INFEASIBLE if proven else Status.NOT_CONVERGED",
        "status = Status.INFEASIBLE if proven or claimed else Status.NOT_CONVERGED",
    ),
    Mutant(
        "a live solver's thrusts are not cut at the upper limit", "        np.minimum(f, high, out=f)\n", ""
    ),
    Mutant(
        "a soft answer is not held to its tolerance",
        "self._soft.distance(f / self._unit, b, lb, ub) <= self.tolerance",
        "self._soft.distance(f / self._unit, b, lb, ub) <= 1.0",
    ),
    Mutant(
        "check takes kilometres for metres",
        "if arms.max() < SHORTEST_ARM:",
        "if arms.max() < 0 * SHORTEST_ARM:",
    ),
    # bench
    Mutant(
        "the judge overlooks small violations of limits",
        "~(seen.violation <= 0.0)",
        "~(seen.violation <= 0.1)",
    ),
    Mutant(
        "the judge compares newtons with a relative tolerance",
        "near = farthest <= tolerance * f_scale",
        "near = farthest <= tolerance",
    ),
    Mutant(
        "the judge looks at the first answers of a demand only",
        "demand = np.arange(len(F)) % len(demands.taus)",
        "demand = np.minimum(np.arange(len(F)), len(demands.taus) - 1)",
    ),
    Mutant(
        "an angle stays in radians",
        "np.where(directed, np.degrees(angle), np.nan)",
        "np.where(directed, angle, np.nan)",
    ),
    Mutant("infeasible demands begin inside the set", "BEYOND = (1.02, 2.0)", "BEYOND = (0.98, 2.0)"),
    Mutant(
        "the first demand of a file is dropped",
        "    return dict(zip(places, values, strict=True)), lines",
        "    return dict(zip(places, values[:, 1:], strict=True)), lines",
    ),
    Mutant(
        "a log's upper limits widen the vehicle's",
        "high[:, i] = np.minimum(high[:, i], values)",
        "high[:, i] = np.maximum(high[:, i], values)",
    ),
    Mutant(
        "the steal time is read from another column",
        "return int(fields[8]) if len(fields) > 8 else None",
        "return int(fields[7]) if len(fields) > 8 else None",
    ),
    Mutant(
        "calls on cold caches count among the single ones",
        "    samples.singles.clear()  # the first pass of a fast call ran on cold caches\n",
        "",
    ),
    Mutant(
        "what is measured once is measured in no repeat",
        "            if repeat > 0:\n",
        "            if repeat >= 0:\n",
    ),
    Mutant("a quantile is given with one call beyond it", "BEYOND = 10\n", "BEYOND = 1\n"),
    Mutant("a control period is in milliseconds", "return 1e6 / self.rate_hz", "return 1e3 / self.rate_hz"),
    Mutant(
        "late calls are counted from the limit on",
        "bisect_right(self.times, limit_us, key",
        "bisect_right(self.times, limit_us - 1e-9, key",
    ),
    Mutant(
        "the least share of answered demands is the largest",
        'got a finite f; losses are of these.", worst=min)',
        'got a finite f; losses are of these.", worst=max)',
    ),
    Mutant(
        "the gate overlooks wrong answers",
        "(lost or wrong, Outcome.REGRESSION,",
        "(lost, Outcome.REGRESSION,",
    ),
    Mutant(
        "the gate's interval is one-sided",
        "stdtrit(len(m) - 1, (1 + CONFIDENCE) / 2)",
        "stdtrit(len(m) - 1, CONFIDENCE)",
    ),
    Mutant(
        "a layout is beaten by one that is worse in something",
        "if not (front <= points[i]).all(axis=1).any():",
        "if not (front <= points[i]).any(axis=1).any():",
    ),
    Mutant(
        "files of one name overwrite each other on their way to another host",
        'files[f"{number}/{place}"] = path.read_bytes()\n'
        '            packed.append(f"{option}{equals}{number}/',
        'files[f"0/{place}"] = path.read_bytes()\n            packed.append(f"{option}{equals}0/',
    ),
    Mutant(
        "a board that counts instructions is taken for one with a clock",
        "    if not heard.board.ticks_per_s:\n",
        "    if False:\n",
    ),
    Mutant(
        "worst instructions are the least",
        "return row.instructions[-1][0] if row",
        "return row.instructions[0][0] if row",
    ),
)


def mutated(tree: Path, mutant: Mutant) -> tuple[Path, str]:
    """Put a mutant into a tree; returns the file and its text as it was. Raises LookupError."""
    files = sorted(path for package in ("alloc", "bench") for path in (tree / package).rglob("*.py"))
    found = [(path, text) for path in files if mutant.line in (text := path.read_text(encoding="utf-8"))]
    if len(found) != 1 or found[0][1].count(mutant.line) != 1:
        places = sum(text.count(mutant.line) for _, text in found)
        raise LookupError(f"{mutant.name}: its line stands {places} times in the packages: {mutant.line!r}")
    path, text = found[0]
    path.write_text(text.replace(mutant.line, mutant.instead), encoding="utf-8")
    return path, text


def stages(tree: Path, path: Path) -> list[list[str]]:
    """The tests that a change of this file asks for, likely ones first.

    Those of its room that name the file or what it is called, the others of its room, and for the library the
    contract of all methods.
    """
    room = tree / "tests" / path.relative_to(tree).parent
    while not room.is_dir():
        room = room.parent
    names = ".".join(path.relative_to(tree).with_suffix("").parts), f"test_{path.stem}.py"
    files = sorted(room.rglob("test_*.py"))
    near = [file for file in files if file.name == names[1] or names[0] in file.read_text(encoding="utf-8")]
    others = [file for file in files if file not in near]
    found = [[str(file.relative_to(tree)) for file in part] for part in (near, others) if part]
    return [*found, [CONTRACT]] if path.is_relative_to(tree / "alloc") else found


def notices(tree: Path, tests: list[str]) -> str:
    """The first test that fails in a tree, without its parameters; empty where all pass."""
    kernels = os.environ.get("THRUSTBENCH_CACHE", str(ROOT / "build" / "kernels"))
    own = {"PYTHONPATH": str(tree), "THRUSTBENCH_CACHE": kernels}
    (tree / "unshrunk.py").write_text(UNSHRUNK, encoding="utf-8")
    options = [
        "-x",
        "-q",
        "-p",
        "no:cacheprovider",
        "-p",
        "unshrunk",
        "--hypothesis-profile=unshrunk",
        "--tb=no",
    ]
    command = [sys.executable, "-m", "pytest", *options, *tests]
    ran = subprocess.run(command, cwd=tree, env=os.environ | own, capture_output=True, text=True)
    if ran.returncode in (0, pytest.ExitCode.NO_TESTS_COLLECTED):
        return ""
    failed = [str(name) for name in re.findall(r"^(?:FAILED|ERROR) ([^\s\[]+)", ran.stdout, re.MULTILINE)]
    if not failed and "ImportError while loading conftest" in ran.stderr:
        return "tests/conftest.py"
    if not failed:
        raise RuntimeError(f"pytest ended with {ran.returncode}:\n{ran.stdout[-2000:]}{ran.stderr[-2000:]}")
    return failed[0]


def main() -> int:
    """Print a line a mutant; 1 where one survives."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", help="only mutants with one of these words in their names")
    parser.add_argument("--whole", action="store_true", help="run all tests, not only those of the room")
    parser.add_argument("--tree", default="HEAD", help="the commit whose tree is broken")
    options = parser.parse_args()
    chosen = [m for m in MUTANTS if not options.words or any(word in m.name for word in options.words)]
    survivors = 0
    print("| mutant | the first test that finds it |\n|:--|:--|", flush=True)
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = Path(folder) / "tree"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(tree)], check=True)
        subprocess.run(
            ["git", "-C", str(tree), "-c", "advice.detachedHead=false", "checkout", "--quiet", options.tree],
            check=True,
        )
        for mutant in chosen:
            try:
                path, text = mutated(tree, mutant)
            except LookupError as error:
                survivors += 1
                print(f"| {mutant.name} | NONE: {error.args[0]} |", flush=True)
                continue
            tests = (
                [["tests"]]
                if options.whole
                else [*stages(tree, path), *([[*mutant.also]] * any(mutant.also))]
            )
            found = next(filter(None, (notices(tree, some) for some in tests)), "")
            path.write_text(text, encoding="utf-8")
            survivors += not found
            print(f"| {mutant.name} | {found or f'NONE: {path.relative_to(tree)}'} |", flush=True)
    print(f"\n{len(chosen) - survivors} of {len(chosen)} found")
    return int(survivors > 0)


if __name__ == "__main__":
    raise SystemExit(main())
