"""Demands that generated C answers side by side: the same bits as one call after the other."""

import shutil
import subprocess
import sys

import numpy as np
import pytest

from alloc import Status, build, load_vehicle
from alloc.c import Target, missing
from alloc.c.bind import COUNT, side_by_side
from alloc.methods import recipe, recipes
from alloc.program import Where

needs_compiler = pytest.mark.skipif(bool(missing()), reason=missing())


@pytest.mark.parametrize("limits", ["fixed", "call"])
def test_kernels_without_a_branch_have_a_form_for_demands_side_by_side(limits: Where) -> None:
    vehicle = load_vehicle("bluerov2-heavy")
    straight = {
        name
        for name, each in recipes().items()
        if side_by_side(Target(vehicle=vehicle, method=each, limits=limits))
    }
    assert set(recipes()) - straight <= {"redistribute", "soft"}  # loops over data
    branched = Target(vehicle=load_vehicle("supply-vessel"), method=recipe("nullspace"), limits=limits)
    assert not side_by_side(branched)


@needs_compiler
@pytest.mark.parametrize("kernel", ["nullspace", "clip", "scaled", "pinv"])
def test_many_demands_get_the_bits_of_one_call_each(kernel: str, rng: np.random.Generator) -> None:
    """Attainable demands and others, limits that exclude zero or cross, and a rest that fills no block."""
    vehicle = load_vehicle("ukwial")
    allocate = build(f"{kernel}@native", vehicle)
    taus = rng.normal(size=(2 * COUNT + 5, vehicle.k)) * vehicle.wrench_scale
    ends = np.sort(rng.uniform(vehicle.f_min, vehicle.f_max, (2, len(taus), vehicle.n)), axis=0)
    ends[:, ::9] = ends[::-1, ::9]
    for low, high in [(None, None), (ends[0, 0] - 100.0, ends[1, 0] + 100.0), tuple(ends)]:
        F, status = allocate.many(taus, low, high)
        rows = [(None, None)] * len(taus) if low is None else np.broadcast_arrays(low, high, F)[:2]
        single = [
            allocate(tau, *limits)
            for tau, limits in zip(taus, rows if low is None else zip(*rows, strict=True), strict=True)
        ]
        np.testing.assert_array_equal(status, [int(one.status) for one in single])
        expected = np.array([one.f for one in single])
        np.testing.assert_array_equal(F.view(np.int64)[status < 2], expected.view(np.int64)[status < 2])
        assert np.isnan(F[status == Status.INFEASIBLE]).all()
    if kernel != "pinv":
        assert set(status.tolist()) >= {int(Status.INFEASIBLE)}


COUNTED = """
import numpy as np
from alloc import build, load_vehicle
vehicle = load_vehicle("ukwial")
allocate = build("nullspace@native", vehicle)
taus = np.ones((COUNT, vehicle.k))
limits = [np.tile(side, (COUNT, 1)) for side in (vehicle.f_min, vehicle.f_max)]
print(allocate(taus[0]).status, *{*allocate.many(taus)[1], *allocate.many(taus, *limits)[1]})
"""


@needs_compiler
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind (Debian: apt install valgrind) counts")
def test_valgrind_knows_every_instruction_of_a_native_method() -> None:
    """The gate's counts are its: at an instruction that it does not know, as AVX-512's, it ends by SIGILL."""
    program = COUNTED.replace("COUNT", str(2 * COUNT))
    valgrind = ["valgrind", "--vgdb=no", "--tool=none", "--quiet"]
    ended = subprocess.run([*valgrind, sys.executable, "-c", program], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["0", "0"]
