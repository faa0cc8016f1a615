"""Walsh matrix, T = Q W_f, whole and with thrusters off (eq. 18-28, Appendix A); no limits.

The paper's case is four identical thrusters around the centre of gravity. Its derivation needs less:
the entries of a row of T that are not zero have one size |t|, and the rows are orthogonal. A vehicle
whose horizontal and vertical four each look like the paper's (section 2) meets that too.
"""

import numpy as np

from alloc.allocation import FloatArray
from alloc.closed_forms.linear import TOLERANCE
from alloc.errors import NotApplicable
from alloc.vehicle import RANK_TOLERANCE, Vehicle


def walsh_matrix(n: int) -> FloatArray:
    """(n, n) Walsh matrix in dyadic (Paley) order, as the paper's W_4 (Appendix A).

    Built from H_2N = [[H, H], [H, -H]], H_1 = [1]; row i of W is row "i with its bits reversed" of
    H. So W = W' and W W' = n I. Raises NotApplicable unless n is a power of two.
    """
    if n < 1 or n & (n - 1):
        raise NotApplicable(f"walsh: no Walsh matrix has {n} rows; their number is a power of two")
    hadamard = np.ones((1, 1))
    order = np.zeros(1, dtype=int)
    while len(hadamard) < n:
        hadamard = np.block([[hadamard, hadamard], [hadamard, -hadamard]])
        order = np.concatenate([2 * order, 2 * order + 1])
    return hadamard[order]


def factor(vehicle: Vehicle) -> tuple[FloatArray, FloatArray]:
    """T = diag(q) W_f (eq. 19): q (k,), the first entry of each row that is not 0; W_f (k, n) of 0, +-1.

    Raises NotApplicable, naming the premise that fails.
    """
    name, T, H = vehicle.name, vehicle.T, vehicle.H
    if not np.array_equal(H, H[0, 0] * np.eye(vehicle.n)):
        raise NotApplicable(
            f"walsh: {name}: H is not a multiple of the identity, so f is not the least effort"
        )
    weakened = np.flatnonzero((vehicle.readiness > 0) & (vehicle.readiness < 1))
    if weakened.size:
        raise NotApplicable(
            f"walsh: {name}: {vehicle.called(int(weakened[0]))} is weakened; P must be 0 or 1 (eq. 20)"
        )
    q = np.zeros(vehicle.k)
    W_f = np.zeros(T.shape)
    for i, row in enumerate(T):
        axis = vehicle.dof[i]
        # The tolerance is the promise of the closed forms: larger differences in a row would show in f.
        used = np.flatnonzero(np.abs(row) > TOLERANCE * np.abs(row).max())
        if not used.size:
            raise NotApplicable(f"walsh: {name}: no thruster moves {axis}, so Q is singular (eq. 21)")
        q[i] = row[used[0]]
        if np.abs(np.abs(row[used] / q[i]) - 1).max() > TOLERANCE:
            raise NotApplicable(f"walsh: {name}: the entries of {axis} in T are not +-equal (eq. 18)")
        if used.size & (used.size - 1):
            raise NotApplicable(f"walsh: {name}: {used.size} thrusters move {axis}; it takes a power of two")
        W_f[i, used] = np.sign(row[used] / q[i])
    products = W_f @ W_f.T
    for i, j in np.argwhere(np.triu(products, 1)):
        pair = f"{vehicle.dof[i]} and {vehicle.dof[j]}"
        raise NotApplicable(f"walsh: {name}: the rows {pair} of T are not orthogonal (eq. 18)")
    return q, W_f


def faultless_inverse(q: FloatArray, W_f: FloatArray) -> FloatArray:
    """(n, k) G of f = 1/m W [0; Q^-1 tau], m thrusters a row; all m = 4 in the paper (eq. 25).

    The other rows of W meet the zeros, so W_f suffices. Since T T' = m Q^2, G is the T* of eq. 10.
    """
    inverse: FloatArray = W_f.T / (np.abs(W_f).sum(axis=1) * q)
    return inverse


def faulty_inverse(q: FloatArray, W_f: FloatArray, vehicle: Vehicle) -> FloatArray:
    """(n, k) G of f' = W_f'^-1 Q^-1 tau over the thrusters that work, 0 for the others (eq. 26-28).

    W_f' is square in the paper; where it is not, the right inverse gives the least effort. Where rank is
    lost, "nearest" counts in rows of T scaled to unit length, as for every closed form.
    """
    on = vehicle.working
    rows = 1.0 / np.sqrt(np.abs(W_f).sum(axis=1))
    inverse = np.zeros((vehicle.n, vehicle.k))
    inverse[on] = np.linalg.pinv(rows[:, None] * W_f[:, on], rcond=RANK_TOLERANCE) * (rows / q)
    return inverse


def walsh_inverse(vehicle: Vehicle) -> FloatArray:
    """(n, k) G of f = G tau, without any decomposition of T; raises NotApplicable.

    The paper's point is that f takes additions only. numpy pays per call, not per addition, so
    here the signs go into G and f costs one product as with ``pinv``; see docs/theory.md.
    """
    q, W_f = factor(vehicle)
    ready = len(vehicle.working) == vehicle.n
    return faultless_inverse(q, W_f) if ready else faulty_inverse(q, W_f, vehicle)
