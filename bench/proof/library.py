"""libthrustbench, everything that can be shown of it: for all vehicles that it has room for."""

import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path

from alloc import Vehicle, library
from alloc.program import Scalar
from bench.harness import machine
from bench.proof import tools
from bench.proof.proof import ASSUMPTIONS, Claim, Proof, not_shown
from bench.proof.safety.library import claims

ANSWERS = (
    "On random vehicles, failures and demands thrusts lie inside the limits, SOLVED makes tau, shares make"
    " what they say, and NaN is refused."
)
WRITTEN = "No decision of these calls depends on memory that was never written."


def prove_library(
    scalar: Scalar = "double", vehicle: Vehicle | None = None, say: Callable[[str], None] = lambda _: None
) -> tuple[Proof, dict[str, str]]:
    """The proof of the library with room for a vehicle (None: its usual room), and the C that it is about.

    Raises NotInstalled where Frama-C is missing. ``say`` is told what is looked at next.
    """
    begin = time.perf_counter()
    n_max, k_max = library.room(vehicle)
    made = library.files(scalar, n_max, k_max)
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        say("memory, status and indices, a minute or more")
        shown = claims(made, n_max, Path(folder))
        numbers = list[Claim]()
        if all(claim.verdict == "shown" for claim in shown):  # C that may write anywhere is not run
            say("answers on random vehicles")
            test = library.selftest()
            answers, memory = _tried({**made, **test}, Path(folder) / "tried")
            shown.append(answers)
            numbers.append(memory)
    proof = Proof(
        vehicle=f"every vehicle of up to {n_max} thrusters and {k_max} axes",
        method="The library",
        scalar=scalar,
        limits="call",
        function=library.NAME,
        files=sorted(made),
        sha256=sha256("".join(made[name] for name in sorted(made)).encode()).hexdigest(),
        thrustbench=machine.commit(),
        tools={"frama-c": tools.version("frama-c")},
        assumptions=ASSUMPTIONS,
        claims=shown,
        numbers=numbers,
        seconds=round(time.perf_counter() - begin, 1),
    )
    return proof, made


def _tried(files: Mapping[str, str], folder: Path) -> tuple[Claim, Claim]:
    """Output of the self-test, and of Valgrind while it runs."""
    passed, said = tools.tried(files, folder)
    if not passed:
        return not_shown(ANSWERS, said), not_shown(WRITTEN, ["the self-test fails"])
    answers = Claim(claim=ANSWERS, verdict="tested", by="the self-test", words=said[:1])
    if not shutil.which("valgrind"):
        return answers, not_shown(WRITTEN, ["needs valgrind: apt-get install valgrind"])
    watched = tools.run(["sh", "-c", "valgrind -q --error-exitcode=9 ./tried && echo passed"], folder).split(
        "\n"
    )
    if "passed" not in watched:
        return answers, not_shown(WRITTEN, watched)
    return answers, Claim(claim=WRITTEN, verdict="tested", by="Valgrind, the self-test", words=watched[:1])
