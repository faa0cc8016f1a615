"""The point nearest to the origin between pairs of planes, on its own."""

import numpy as np
import pytest

from alloc.nullspace.region import prepare

TOLERANCE = 1e-9


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize(
    ("low", "high", "holds"),
    [
        (-1.0, 1.0, True),
        (0.1 * TOLERANCE, 1.0, True),
        (10 * TOLERANCE, 1.0, False),
        (-1.0, -0.1 * TOLERANCE, True),
        (-1.0, -10 * TOLERANCE, False),
    ],
)
def test_a_row_that_no_z_moves_holds_or_fails_whatever_z_is(
    d: int, low: float, high: float, holds: bool
) -> None:
    region = prepare(np.vstack([np.eye(d), np.zeros(d)]), TOLERANCE)
    z, _ = region.nearest([*d * [-1.0], low], [*d * [1.0], high])
    assert z == (d * [0.0] if holds else None)
