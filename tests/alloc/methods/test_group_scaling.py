"""Scaling group by group, against what a board that runs the flown firmware answered to a thousand demands.

The board printed a hash of all its answers (github.com/Suchit-Arunkumar/AUV-Thruster-Allocation,
results/nucleo_bench.json). ``flown`` and ``uniform`` calculate in single precision what the project
describes, and their hashes are the board's, so they stand for its answers to the last bit.
"""

import numpy as np
import pytest

from alloc import Status, build, load_vehicle
from alloc.closed_forms.inverse import generalized_inverse
from alloc.methods.group_scaling import groups
from flown_cycles import asked, pulses

VEHICLE = load_vehicle("tiburon")
FLOAT = np.float32
FLOWN_HASH, UNIFORM_HASH = 0x8FFA1F75, 0x9B3F2F6B
ROUNDED = generalized_inverse(VEHICLE).round(4)
"""The flown firmware has four decimals of the pseudoinverse."""
UPWARD, REST = slice(0, 4), slice(4, 8)


def fitted(part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A group's thrusts divided by the largest where that is above 1, and whether it was."""
    most = np.abs(part).max(axis=1, keepdims=True)
    return np.where(most > 1, part / most, part), most[:, 0] > 1


def flown(taus: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Thrusts (N, 8) and which groups were scaled (N,), bit by bit."""
    B, (x, y, z, roll, pitch, yaw) = ROUNDED.astype(FLOAT), taus.T[:, :, None]
    upward, a = fitted((B[:, 2] * z + B[:, 3] * roll + B[:, 4] * pitch)[:, UPWARD])
    across, b = fitted((B[:, 0] * x + B[:, 1] * y)[:, REST])
    turning, c = fitted((B[:, 5] * yaw)[:, REST])
    return np.hstack([upward, (across + turning).clip(-1, 1)]), (a + 2 * b + 4 * c).astype(np.uint8)


def uniform(taus: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """T* tau over its largest thrust where that is above 1; and 8 where it was."""
    G = generalized_inverse(VEHICLE)
    B, F = np.where(np.abs(G) < 1e-9, 0.0, G).astype(FLOAT), np.zeros((len(taus), 8), FLOAT)
    for j in range(6):
        F = F + B[:, j] * taus[:, j : j + 1]
    F, scaled = fitted(F)
    return F, (8 * scaled).astype(np.uint8)


def fnv(rows: list[bytes]) -> int:
    """The 32-bit hash FNV-1a of all bytes."""
    found = 2166136261
    for byte in b"".join(rows):
        found = (found ^ byte) * 16777619 & 0xFFFFFFFF
    return found


def test_the_flown_rule_as_described_gives_the_board_s_answers_bit_for_bit() -> None:
    """The hash covers thrusts, pulse widths with and without slew, and which groups were scaled."""
    F, scaled = flown(asked())
    aimed, sent = pulses(F)
    told = zip(F, aimed, sent[1:], scaled, strict=True)
    assert fnv([part.tobytes() for parts in told for part in parts]) == FLOWN_HASH


def test_the_scaled_generalized_inverse_gives_the_board_s_answers_bit_for_bit() -> None:
    F, scaled = uniform(asked())
    rows = [f.tobytes() + flags.tobytes() for f, flags in zip(F, scaled, strict=True)]
    assert fnv(rows) == UNIFORM_HASH


@pytest.mark.parametrize("method", ["group-scaling", "group-scaling@native"])
def test_group_scaling_is_what_has_flown_up_to_the_rounding_of_its_table(method: str) -> None:
    """Four decimals of T* move a thrust by at most 5e-5 for each unit of a demand on its group's axes."""
    taus = asked()
    F, status = build(method, VEHICLE).many(taus)
    theirs, scaled = flown(taus)
    doubt = 5e-5 * np.abs(taus).sum(axis=1, keepdims=True)
    # Division by the largest thrust of a group moves it by twice that at most, of two groups by four times.
    assert (np.abs(F - theirs) <= 4 * doubt + 1e-6).all()
    assert np.abs(F - theirs).max() < 1e-3
    assert (status == Status.PARTIAL).all()  # coupling is left out also where nothing saturates
    assert np.count_nonzero(scaled) == 721


def test_shrink_is_what_that_project_calls_its_second_version() -> None:
    taus = asked()
    F, status = build("shrink", VEHICLE).many(taus)
    theirs, scaled = uniform(taus)
    np.testing.assert_allclose(F, theirs, atol=2e-6)  # ten roundings in single precision
    assert np.count_nonzero(status == Status.PARTIAL) == np.count_nonzero(scaled) == 726


def test_where_blocks_share_nothing_no_group_leaves_anything_out() -> None:
    """Surge, sway, yaw of bluerov2-heavy have thrusters of their own, and so have heave, roll, pitch."""
    heavy = load_vehicle("bluerov2-heavy")
    np.testing.assert_allclose(sum(groups(heavy)), generalized_inverse(heavy), atol=1e-12)
    F, status = build("group-scaling", heavy).many(0.1 * np.diag(heavy.T @ heavy.f_max))
    assert set(status) == {Status.SOLVED}
    np.testing.assert_allclose(F @ heavy.T.T, 0.1 * np.diag(heavy.T @ heavy.f_max), atol=1e-9)


def test_each_group_is_scaled_for_itself_before_they_are_added() -> None:
    """Sway five times too large shrinks itself to full thrust, and leaves heave alone."""
    heavy = load_vehicle("bluerov2-heavy")
    tau = np.array([0.0, 5 * 4 * 0.707 * 40, 100.0, 0, 0, 0])
    made = heavy.T @ build("group-scaling", heavy)(tau).f
    np.testing.assert_allclose(made, [0, 4 * 0.707 * 40, 100.0, 0, 0, 0], atol=1e-9)
