"""What counts as met in C of either scalar."""

from alloc.allocation import WRENCH_TOLERANCE
from alloc.nullspace import allocator as nullspace
from alloc.program import Scalar

TOLERANCE: dict[Scalar, float] = {"double": nullspace.TOLERANCE, "float": 4e-6}
"""Excess over a limit that still counts as met, relative to the largest limit [-]. Float rounds at 6e-8; some
70 times that is left for the sums."""
MET: dict[Scalar, float] = {"double": WRENCH_TOLERANCE, "float": 1e-5}
"""What a SOLVED wrench may miss, relative to ``wrench_scale`` [-]; in single precision some hundred
roundings."""
