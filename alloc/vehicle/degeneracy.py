"""Thresholds for rank, dependence and zero, defined once.

A vehicle's ``rank``, by RANK_TOLERANCE, decides which directions it pushes; all other code asks the vehicle.
T is used as given; dependence that its rounding hides is not guessed, and a result that was divided by a thin
minor is checked afterwards. A facet of nearly dependent columns is kept, since any normal gives a true
inequality, and thrusts are compared with T f before they are returned.

Each other threshold answers one question of rounding, at its own cost of a wrong answer. Answers keep their
promises with all of them ten times larger or smaller. All are shares of numbers scaled to about 1: rows of T
of unit length, wrenches in units of ``wrench_scale``, bases with N'HN = I. Tolerances of answers are in
``alloc.kernels.tolerance``.
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
"""Size that counts as zero after sums of sums, as in T* tau or a decomposition: a dozen additions leave
1e-15, times cond(T) < 1e3. An entry of this size that is left out costs the wrench a thousandth of what is
promised."""

ROUNDED = 1e-14
"""Rest that one sum of products leaves of zero, relative to the largest of them."""


def independent(sigma: NDArray[np.floating[Any]], size: float = 1.0) -> int:
    """Number of directions that singular values ``sigma`` (r,) tell apart, with rows of length ``size``."""
    return int(np.count_nonzero(sigma > RANK_TOLERANCE * size))
