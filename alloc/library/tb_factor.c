/* Rows made orthogonal, and a basis of what they are all orthogonal to. */
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
