"""One kernel, everything that can be shown of it."""

import tempfile
import time
from pathlib import Path

from alloc.native import digest
from bench.harness import machine
from bench.prove import safety, tools
from bench.prove.certificate import ASSUMPTIONS, Certificate
from bench.prove.harness import Subject


def prove(of: Subject) -> Certificate:
    """The certificate of a kernel; raises NotInstalled where Frama-C is missing."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="thrustbench-") as folder:
        claims = safety.claims(of, Path(folder))
    return Certificate(
        vehicle=of.vehicle.name,
        method=of.kernel,
        scalar=of.scalar,
        limits=of.limits,
        function=of.name,
        sha256=digest(of.name, of.files),
        thrustbench=machine.commit(),
        tools={name: tools.version(name) for name in tools.PACKAGES},
        assumptions=ASSUMPTIONS,
        claims=claims,
        seconds=round(time.perf_counter() - begin, 1),
    )
