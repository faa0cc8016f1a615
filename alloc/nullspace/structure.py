"""Vehicle's constants: G, and a null-space basis N split into independent blocks."""

from dataclasses import dataclass

import numpy as np

from alloc.allocation import FloatArray, IndexArray
from alloc.closed_forms.inverse import generalized_inverse
from alloc.vehicle import Vehicle
from alloc.vehicle.degeneracy import COLLINEAR, NOTHING, ROUNDED


@dataclass(frozen=True, eq=False)
class Block:
    """A part of the null space that shares no thruster and no cost term with any other part.

    Attributes
    ----------
    rows : (m,) thrusters that it moves, in the order in which steps take them
    N : (m, d) its basis, N'HN = I [sqrt(1/H)]
    """

    rows: IndexArray
    N: FloatArray


@dataclass(frozen=True, eq=False)
class Structure:
    """All thrusts that meet a wrench: f = G tau + N z, in blocks of z.

    Attributes
    ----------
    G : (n, k) T* of eq. 9
    blocks : the parts of N
    fixed : thrusters that no z moves
    unreachable : (k - rank, k) rows u with u'tau = 0 for every wrench the thrusters can make;
        scaled so that |u'tau| is relative to ``vehicle.wrench_scale``
    """

    G: FloatArray
    blocks: tuple[Block, ...]
    fixed: IndexArray
    unreachable: FloatArray


def decompose(vehicle: Vehicle) -> Structure:
    """Find G, N and its finest split for this vehicle, its H and its faults."""
    working = vehicle.working
    scale = 1.0 / vehicle.row_lengths
    A = scale[:, None] * vehicle.TP[:, working]
    U, _, Vt = np.linalg.svd(A)
    rank = vehicle.rank
    blocks = split(Vt[rank:].T, vehicle.H[np.ix_(working, working)], A)
    moved = {int(working[row]) for block in blocks for row in block.rows}
    return Structure(
        G=generalized_inverse(vehicle),
        blocks=tuple(Block(working[block.rows], block.N) for block in blocks),
        fixed=np.array([i for i in range(vehicle.n) if i not in moved], dtype=np.intp),
        unreachable=U[:, rank:].T * (scale / vehicle.f_scale),
    )


def split(N: FloatArray, H: FloatArray, A: FloatArray) -> list[Block]:
    """Split N (m, d), a basis of the null space of A (k, m), into blocks that share no row and no cost.

    These are the finest blocks without a common row and a common term of z'N'HNz. In a reduced echelon
    basis the columns that hang together by common rows are the same whatever pivots are taken (they are the
    connected components of the matroid of N's rows), so the split depends on the vehicle alone.
    """
    B = _cleared(_echelon(N), A)
    metric = B.T @ H @ B
    size = np.sqrt(np.diag(metric))
    linked = (np.abs(metric) > NOTHING * np.outer(size, size)) | ((B != 0).T @ (B != 0))
    # ``linked`` says which two columns share something, its power which are linked over other columns. Equal
    # rows of the power are one block; sorted backwards, the block that holds the first column comes first.
    connected = np.linalg.matrix_power(linked, len(linked))
    blocks = []
    for columns in map(np.flatnonzero, np.unique(connected, axis=0)[::-1]):
        rows = np.flatnonzero(B[:, columns].any(axis=1))
        part = B[np.ix_(rows, columns)]
        L = np.linalg.cholesky(metric[np.ix_(columns, columns)])
        basis = np.linalg.solve(L, part.T).T
        sizes = np.linalg.norm(basis, axis=1)
        moved = sizes > ROUNDED * sizes.max()  # what is left moves a thruster by rounding, if at all
        rows, basis = rows[moved], basis[moved]
        order = _apart(basis)
        blocks.append(Block(rows[order], basis[order]))
    return blocks


def _apart(N: FloatArray) -> IndexArray:
    """The rows of N (m, d), first d of them that stand apart, each the longest that the earlier ones leave.

    Steps that begin with those rarely have to begin again. The others follow in their order, and one
    dimension needs none.
    """
    m, d = N.shape
    rest, first = N.copy(), list[int]()
    for _ in range(d if d > 1 else 0):
        sizes = np.linalg.norm(rest, axis=1)
        first.append(int(np.argmax(sizes > sizes.max() - NOTHING)))
        along = rest[first[-1]] / sizes[first[-1]]
        rest = rest - np.outer(rest @ along, along)
    return np.array([*first, *(i for i in range(m) if i not in first)], dtype=np.intp)


def _echelon(N: FloatArray) -> FloatArray:
    # Gauss-Jordan on columns, the largest remaining entry as pivot; the pivot rows end as unit rows.
    B = N.copy()
    free_rows = np.ones(len(B), dtype=bool)
    for column in range(B.shape[1]):
        rest = np.abs(B[:, column:]) * free_rows[:, None]
        row, offset = divmod(int(np.argmax(rest)), rest.shape[1])
        B[:, column], B[:, column + offset] = B[:, column + offset].copy(), B[:, column].copy()
        B[:, column] /= B[row, column]
        others = np.arange(B.shape[1]) != column
        B[:, others] -= np.outer(B[:, column], B[row, others])
        free_rows[row] = False
    return B


def _cleared(B: FloatArray, A: FloatArray) -> FloatArray:
    """B (m, d) with its entries of rounding zero, and with A B = 0 up to rounding all the same.

    Where A nearly loses rank rounding moves B by more than it moves A B, and thrusts have to make up for A B.
    So entries below NOTHING are left out where the others can do without them, and stay where they can't.
    """
    cleared = B.copy()
    for column in range(B.shape[1]):
        kept = np.abs(B[:, column]) > NOTHING
        only, part = A[:, kept], B[kept, column]
        U, sigma, Vt = np.linalg.svd(only, full_matrices=False)
        r = int(np.count_nonzero(sigma > COLLINEAR))
        part = part - Vt[:r].T @ (U[:, :r].T @ (only @ part) / sigma[:r])
        if np.abs(only @ part).max() <= ROUNDED:
            cleared[:, column] = 0.0
            cleared[kept, column] = part
    return cleared
