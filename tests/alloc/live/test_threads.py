"""One allocator, several threads: each call gets the answer that it would get alone."""

import subprocess
import sys

from alloc import catalogue
from tests.places import ROOT

NAMES = sorted(entry.name for entry in catalogue() if not entry.missing and entry.solver and not entry.twin)

SCRIPT = """
import sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
from alloc import build, load_vehicle

sys.setswitchinterval(1e-6)  # a thousand times as often as usual, so that few calls are enough
vehicle = load_vehicle("ukwial")
rng = np.random.default_rng(0)
taus = rng.uniform(vehicle.f_min, vehicle.f_max, (60, vehicle.n)) @ vehicle.TP.T
taus *= rng.uniform(0.3, 1.5, (60, 1))  # attainable ones and others
with ThreadPoolExecutor(2) as pool:
    for name in sys.argv[1:]:
        print(name, flush=True)
        allocate = build(name, vehicle)
        alone = [allocate(tau) for tau in taus]
        for answers in pool.map(lambda _: [allocate(tau) for tau in taus], range(4)):
            for one, other in zip(alone, answers, strict=True):
                assert one.status == other.status, name
                # Two solves may differ in the last digits: ProxQP's depend on where memory lies.
                np.testing.assert_allclose(other.f, one.f, atol=1e-3, err_msg=name)
"""


def test_threads_that_share_an_allocator_get_the_answers_that_each_would_get_alone() -> None:
    """In a process of its own, since OSQP and HiGHS end theirs where two calls meet in one object."""
    command = [sys.executable, "-c", SCRIPT, *NAMES]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()) == (0, NAMES), done.stderr
