"""Thresholds for rank, dependence and zero, defined once.

Which directions a vehicle pushes is one decision, its ``rank`` by RANK_TOLERANCE, and all that depends on it
asks the vehicle. Which sets of columns of a printed T would be dependent with more digits nobody decides: T
is taken as it stands, and nothing is divided by a thin minor without being looked at afterwards. A facet of
columns that nearly depend on each other is kept, as whatever its normal is it makes a true inequality; a thin
row of the null space comes first, so that others have the last word; and thrusts are held against T f before
they leave (``alloc.nullspace.allocator``, ``alloc.kernels.held``).

What is left are questions of rounding: does this set span a facet, is this row parallel to that plane, is
this sum zero. They differ in what a wrong answer costs, so each has a threshold of its own, with its reason
beside it; answers keep what they promise with all of them ten times larger or smaller.

All are shares of numbers that were brought to about 1 first: rows of T of unit length, wrenches in unit of
``wrench_scale``, bases with N'HN = I. What an answer may miss is another matter, above all but the first
(``alloc.kernels.tolerance``).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

RANK_TOLERANCE = 1e-9
"""Singular values of T below this count as zero, once its rows have unit length: the largest then lies
between 1 and sqrt(k). Published geometry carries at most five digits, so a true zero stands near 1e-16
and the smallest real singular values near 1e-2."""

COLLINEAR = 1e-11
"""A row of a basis of the null space of which a plane leaves this share is parallel to it, and rows that
differ by this share are parallel: it moves a thrust by a hundredth of what is promised."""

FLAT = 1e-13
"""Thrusters of unit length whose smallest singular value is below this span no facet, and unit normals that
are no more apart are the same. Rounding leaves 1e-15; what is left out costs as much as this."""

NOTHING = 1e-12
"""What counts as zero after sums of sums, as T* tau or a decomposition makes them: a dozen additions leave
1e-15, times cond(T) < 1e3. An entry of this size that is left out costs the wrench a thousandth of what is
promised."""

ROUNDED = 1e-14
"""What one sum of products leaves of zero, relative to the largest of them."""


def independent(sigma: NDArray[np.floating[Any]], size: float = 1.0) -> int:
    """How many directions singular values ``sigma`` (r,) tell apart, with rows of length ``size``."""
    return int(np.count_nonzero(sigma > RANK_TOLERANCE * size))
