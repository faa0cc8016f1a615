/* Rows made orthogonal: a basis of what they are all orthogonal to, and the least thrusts that push somewhere. */
#include "tb_internal.h"

/* Of Jacobi's rotations, which converge quadratically: 100,000 random and 100,000 nearly symmetric vehicles of up to 12
 * thrusters took 7 and 9 at most. */
enum { SWEEPS = 30 };

/* Square root of x >= 0: Newton's steps from within 6 % of it, on a number from 1 to 4. */
tb_real tb_root(tb_real x)
{
    tb_real scale = 1;
    if (!(x > 0) || !(x <= TB_LARGEST)) {
        return 0;
    }
    for (int i = 0; i < 600 && x >= 4; i++) {
        x *= TB_R(0.25);
        scale *= 2;
    }
    for (int i = 0; i < 600 && x < 1; i++) {
        x *= 4;
        scale *= TB_R(0.5);
    }
    tb_real root = TB_R(0.7) + x * TB_R(0.34);
    for (int i = 0; i < 4; i++) {
        root = TB_R(0.5) * (root + x / root);
    }
    return root * scale;
}

/* Turns the rows of W (k, m), and those of U with them, until all are orthogonal: one-sided Jacobi, by which the
 * lengths become the singular values, small ones too with all their digits. */
void tb_orthogonal(int k, int m, tb_real W[TB_K_MAX][TB_N_MAX], tb_real U[TB_K_MAX][TB_K_MAX])
{
    int turned = 1;
    for (int sweep = 0; sweep < SWEEPS && turned; sweep++) {
        turned = 0;
        for (int i = 0; i < k; i++) {
            for (int j = i + 1; j < k; j++) {
                const tb_real p = tb_product(W[i], W[i], m), q = tb_product(W[j], W[j], m);
                const tb_real r = tb_product(W[i], W[j], m), small = 4 * TB_EPS * TB_EPS;
                if (p <= small || q <= small || r * r <= small * p * q) {
                    continue;
                }
                const tb_real zeta = (q - p) / (2 * r);
                const tb_real t = (zeta < 0 ? TB_R(-1) : TB_R(1)) / (tb_abs(zeta) + tb_root(1 + zeta * zeta));
                const tb_real c = 1 / tb_root(1 + t * t), s = c * t;
                turned = 1;
                for (int l = 0; l < m; l++) {
                    const tb_real w = W[i][l];
                    W[i][l] = c * w - s * W[j][l];
                    W[j][l] = s * w + c * W[j][l];
                }
                for (int l = 0; l < k; l++) {
                    const tb_real u = U[i][l];
                    U[i][l] = c * u - s * U[j][l];
                    U[j][l] = s * u + c * U[j][l];
                }
            }
        }
    }
}

/* A basis N (m, m - rank) of the null space of V, whose `rank` rows are orthonormal: in reduced echelon form, by
 * Gauss and Jordan with the largest entry as pivot. Changes V. Returns how many columns it has. */
int tb_null_basis(int rank, int m, tb_real V[TB_K_MAX][TB_N_MAX], tb_real N[TB_N_MAX][TB_N_MAX])
{
    int row_of[TB_N_MAX], columns = 0;
    for (int c = 0; c < TB_N_MAX; c++) {
        row_of[c] = -1;
    }
    for (int step = 0; step < rank; step++) {
        int row = step, column = 0;
        tb_real most = 0;
        for (int r = step; r < rank; r++) {
            for (int c = 0; c < m; c++) {
                if (row_of[c] < 0 && tb_abs(V[r][c]) > most) {
                    most = tb_abs(V[r][c]);
                    row = r;
                    column = c;
                }
            }
        }
        if (!(most > 0)) {
            break;
        }
        row_of[column] = step;
        for (int c = 0; c < m; c++) {
            const tb_real swapped = V[row][c];
            V[row][c] = V[step][c];
            V[step][c] = swapped;
        }
        const tb_real pivot = V[step][column];
        for (int c = 0; c < m; c++) {
            V[step][c] /= pivot;
        }
        for (int r = 0; r < rank; r++) {
            const tb_real share = V[r][column];
            for (int c = 0; c < m && r != step; c++) {
                V[r][c] -= share * V[step][c];
            }
        }
    }
    for (int c = 0; c < m; c++) {
        if (row_of[c] >= 0) {
            continue;
        }
        for (int i = 0; i < m; i++) {
            const tb_real entry = row_of[i] < 0 ? TB_R(i == c) : -V[row_of[i]][c];
            N[i][columns] = tb_abs(entry) <= TB_ZERO ? TB_R(0) : entry;
        }
        columns++;
    }
    return columns;
}

/* Least-effort thrusts x of the thrusters that are `on`, which push nearest to `rest` (axes in unit of row lengths).
 *
 * With H = L D L' over those thrusters and w = L'f, effort is w'Dw and the wrench B w, B = A L'^-1. Rows of B, the
 * longest left over first, become orthogonal in the metric 1/D, B = R Q: what is left of the others once a row is
 * below TB_RANK of the longest is rounding. Then w = D^-1 Q'y, and y makes R y nearest to rest, which orthogonal
 * columns of R answer.
 */
void tb_shared(const struct tb_allocator *a, tb_real rest[TB_K_MAX], const int on[TB_N_MAX], tb_real x[TB_N_MAX])
{
    tb_real L[TB_N_MAX][TB_N_MAX], D[TB_N_MAX], per[TB_N_MAX], B[TB_K_MAX][TB_N_MAX], R[TB_K_MAX][TB_K_MAX];
    tb_real S[TB_K_MAX][TB_K_MAX], y[TB_K_MAX], q2[TB_K_MAX], longest = 0;
    int order[TB_K_MAX] = {0}, taken[TB_K_MAX], place[TB_N_MAX] = {0}, m = 0, rank = 0;
    const int k = a->k;
    for (int p = 0; p < a->m; p++) {
        if (on[p]) {
            place[m++] = p;
        }
    }
    for (int i = 0; i < m; i++) {
        const int at = a->at[place[i]];
        D[i] = a->H[at][at];
        for (int j = 0; j < i && a->crossed; j++) {
            tb_real left = a->H[at][a->at[place[j]]];
            for (int l = 0; l < j; l++) {
                left -= L[i][l] * L[j][l] * D[l];
            }
            L[i][j] = left / D[j];
            D[i] -= L[i][j] * left;
        }
        per[i] = 1 / D[i];
        for (int r = 0; r < k; r++) {
            B[r][i] = a->A[r][at] - tb_product(L[i], B[r], a->crossed ? i : 0);
        }
    }
    for (int r = 0; r < k; r++) {
        taken[r] = 0;
    }
    while (rank < k) {
        int next = -1;
        tb_real most = TB_RANK * TB_RANK * longest;
        for (int r = 0; r < k; r++) {
            tb_real square = 0;
            for (int i = 0; i < m && !taken[r]; i++) {
                square += B[r][i] * B[r][i] * per[i];
            }
            if (square > most) {
                most = square;
                next = r;
            }
        }
        if (next < 0) {
            break;
        }
        longest = rank ? longest : most;
        taken[next] = 1;
        order[rank] = next;
        q2[rank] = most;
        for (int r = 0; r < k; r++) {
            tb_real along = 0;
            for (int i = 0; i < m && !taken[r]; i++) {
                along += B[r][i] * B[next][i] * per[i];
            }
            along = r == next ? TB_R(1) : along / most;
            for (int i = 0; i < m && !taken[r]; i++) {
                B[r][i] -= along * B[next][i];
            }
            R[r][rank] = along;
        }
        rank++;
    }
    for (int j = 0; j < rank; j++) {
        tb_real square = 0;
        y[j] = 0;
        for (int r = 0; r < k; r++) {
            square += R[r][j] * R[r][j];
            y[j] += R[r][j] * rest[r];
        }
        y[j] /= square;
        for (int r = 0; r < k; r++) {
            rest[r] -= y[j] * R[r][j];
        }
        for (int l = j + 1; l < rank; l++) {
            S[j][l] = 0;
            for (int r = 0; r < k; r++) {
                S[j][l] += R[r][j] * R[r][l];
            }
            S[j][l] /= square;
            for (int r = 0; r < k; r++) {
                R[r][l] -= S[j][l] * R[r][j];
            }
        }
    }
    for (int j = rank - 1; j >= 0; j--) {
        for (int l = j + 1; l < rank; l++) {
            y[j] -= S[j][l] * y[l];
        }
    }
    for (int j = 0; j < rank; j++) {
        y[j] /= q2[j];
    }
    for (int i = m - 1; i >= 0; i--) {
        tb_real sum = 0;
        for (int j = 0; j < rank; j++) {
            sum += y[j] * B[order[j]][i];
        }
        sum *= per[i];
        for (int l = i + 1; l < m && a->crossed; l++) {
            sum -= L[l][i] * x[place[l]];
        }
        x[place[i]] = sum;
    }
}
