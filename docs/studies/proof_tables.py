"""What was proven of the C: ``python docs/studies/proof_tables.py [DIR]``.

DIR [runs/proof] holds the folders that ``thrustbench prove`` wrote, at any depth. What was not proven is left
empty. Also printed: how many claims are shown, and which worst paths stay an interval.
"""

import sys
from collections import Counter
from itertools import groupby
from pathlib import Path

import msgspec

from alloc import list_vehicles
from bench.proof import Proof
from bench.proof.equation import EQUATION
from bench.results.text import table

KERNELS = ("nullspace", "clip", "scaled", "priority", "pinv", "walsh", "shrink", "redistribute")


def main(folder: Path) -> None:
    """Print the tables."""
    files = sorted(folder.rglob("proof.json"))
    proofs = [msgspec.json.decode(path.read_bytes(), type=Proof) for path in files]
    known = {(each.vehicle, each.method, each.scalar): each for each in proofs}
    for scalar in dict.fromkeys(each.scalar for each in proofs):
        targets = {path.target for each in proofs for path in each.worst_paths if each.scalar == scalar}
        made = {(vehicle, kernel): each for (vehicle, kernel, of), each in known.items() if of == scalar}
        print(f"Equation, {scalar}: part of what SOLVED may miss, and in brackets roundings of |T| |f|\n")
        print(_table({key: _missed(each) for key, each in made.items()}))
        for name in sorted(targets):
            print(f"Most instructions of any call, {scalar}, {name}\n")
            print(_table({key: _worst(each, name) for key, each in made.items()}))
    _summary(proofs)


def _table(cells: dict[tuple[str, str], str]) -> str:
    rows = [
        [vehicle, *(cells.get((vehicle, kernel), "") for kernel in KERNELS)] for vehicle in list_vehicles()
    ]
    return table(["vehicle", *KERNELS], rows)


def _missed(proof: Proof) -> str:
    """The largest of all faults."""
    verdict = next(each.verdict for each in proof.numbers if each.claim == EQUATION)
    if verdict != "shown":
        return verdict
    promise, roundings = (
        max(each) for each in zip(*((row.promise, row.roundings) for row in proof.misses), strict=True)
    )
    return f"{promise:.2g} ({roundings:.0f})"


def _worst(proof: Proof, target: str) -> str:
    for each in proof.worst_paths:
        if each.target == target:
            return str(each)
    return "not shown"


def _summary(proofs: list[Proof]) -> None:
    for scalar, some in groupby(sorted(proofs, key=lambda each: each.scalar), key=lambda each: each.scalar):
        group = list(some)
        verdicts = Counter(claim.verdict for each in group for claim in each.claims)
        worst = [(each, path) for each in group for path in each.worst_paths]
        seconds, exact = sum(each.seconds for each in group), sum(path.exact for _, path in worst)
        print(f"{scalar}: {len(group)} kernels, claims {dict(verdicts)}, {seconds:.0f} s")
        print(f"  worst paths that are exact: {exact} of {len(worst)}")
        print(f"  MISRA without a reason: {sum(not rule.reason for each in group for rule in each.misra)}")
        for each, path in worst:
            if not path.exact:
                print(f"  {each.function} on {path.target}: {path}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "runs/proof"))
