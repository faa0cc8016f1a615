/* All that depends on the vehicle alone: T*, a basis N of the null space in blocks, what no thruster pushes. */
#include "tb_internal.h"

/* L of L L' = M (d, d), in its lower half; 0 where M is not positive definite. */
static int cholesky(int d, tb_real M[TB_N_MAX][TB_N_MAX])
{
    for (int i = 0; i < d; i++) {
        for (int j = 0; j <= i; j++) {
            const tb_real left = M[i][j] - tb_product(M[i], M[j], j);
            if (j < i) {
                M[i][j] = left / M[j][j];
            } else if (left > TB_EPS * M[i][i]) {
                M[i][i] = tb_root(left);
            } else {
                return 0;
            }
        }
    }
    return 1;
}

/* Entry p of H x over the working thrusters `at`. */
static tb_real cost(const struct tb_allocator *a, int p, const tb_real x[TB_N_MAX])
{
    const tb_real *H = a->H[a->at[p]];
    tb_real sum = 0;
    for (int q = 0; q < a->m && a->crossed; q++) {
        sum += H[a->at[q]] * x[q];
    }
    return a->crossed ? sum : H[a->at[p]] * x[p];
}

/* M = B'H B over the working thrusters. */
static void metric(const struct tb_allocator *a, int d, tb_real B[TB_N_MAX][TB_N_MAX], tb_real M[TB_N_MAX][TB_N_MAX])
{
    for (int j = 0; j < d; j++) {
        tb_real x[TB_N_MAX];
        for (int l = 0; l < d; l++) {
            M[j][l] = 0;
        }
        for (int p = 0; p < a->m; p++) {
            x[p] = B[p][j];
        }
        for (int p = 0; p < a->m; p++) {
            const tb_real along = cost(a, p, x);
            for (int l = 0; l <= j; l++) {
                M[j][l] += B[p][l] * along;
            }
        }
    }
    for (int j = 0; j < d; j++) {
        for (int l = j + 1; l < d; l++) {
            M[j][l] = M[l][j];
        }
    }
}

/* Which columns of B hang together, by a common row or a common cost: `part` of each is the first of them. */
static void split(int m, int d, tb_real B[TB_N_MAX][TB_N_MAX], tb_real M[TB_N_MAX][TB_N_MAX], int part[TB_N_MAX])
{
    for (int j = 0; j < d; j++) {
        part[j] = j;
        for (int l = 0; l < j; l++) {
            int linked = M[j][l] * M[j][l] > TB_ZERO * TB_ZERO * M[j][j] * M[l][l];
            for (int p = 0; p < m && !linked; p++) {
                linked = B[p][j] != 0 && B[p][l] != 0;
            }
            const int one = part[j], other = part[l];
            for (int i = 0; i <= j && linked; i++) {
                if (part[i] == one || part[i] == other) {
                    part[i] = one < other ? one : other;
                }
            }
        }
    }
}

/* Puts the blocks of B one after another into a->N and a->at, each a basis with N'HN = 1. */
static int blocks(struct tb_allocator *a, int d, tb_real B[TB_N_MAX][TB_N_MAX])
{
    tb_real M[TB_N_MAX][TB_N_MAX], L[TB_N_MAX][TB_N_MAX];
    int part[TB_N_MAX], column[TB_N_MAX] = {0}, at[TB_N_MAX] = {0}, taken[TB_N_MAX] = {0}, filled = 0;
    metric(a, d, B, M);
    split(a->m, d, B, M, part);
    a->blocks = 0;
    a->begin[0] = 0;
    for (int first = 0; first < d; first++) {
        int size = 0;
        for (int j = first; j < d && part[first] == first; j++) {
            if (part[j] == first) {
                column[size++] = j;
            }
        }
        for (int i = 0; i < size; i++) {
            for (int j = 0; j < size; j++) {
                L[i][j] = M[column[i]][column[j]];
            }
        }
        if (!cholesky(size, L)) {
            return 0;
        }
        /* Of one dimension those that z moves ahead come first, so that a call needs no look at signs. */
        for (int astern = 0; astern < 2 && size > 0; astern++) {
            a->astern[a->blocks] = filled;
            for (int p = 0; p < a->m && filled < a->m; p++) {
                int moved = 0;
                for (int j = 0; j < size; j++) {
                    moved |= B[p][column[j]] != 0;
                }
                if (!moved || taken[p] || (size == 1 && (B[p][first] < 0) != astern)) {
                    continue;
                }
                taken[p] = 1;
                for (int j = 0; j < size; j++) {
                    a->N[filled][j] = (B[p][column[j]] - tb_product(a->N[filled], L[j], j)) / L[j][j];
                }
                a->per[filled] = 1 / (size == 1 ? a->N[filled][0] : tb_product(a->N[filled], a->N[filled], size));
                at[filled++] = a->at[p];
            }
        }
        if (size > 0) {
            a->d[a->blocks++] = size;
            a->begin[a->blocks] = filled;
        }
    }
    for (int p = 0; p < a->m && filled < a->m; p++) {
        if (!taken[p]) {
            at[filled++] = a->at[p];
        }
    }
    for (int p = 0; p < a->m; p++) {
        a->at[p] = at[p];
    }
    return 1;
}

/* G = A+ - N N'H A+, the least effort of all that push nearest to tau: A+ is W'U over squares of lengths. */
static void inverse(struct tb_allocator *a, const tb_real square[TB_K_MAX], tb_real U[TB_K_MAX][TB_K_MAX],
                    tb_real W[TB_K_MAX][TB_N_MAX])
{
    tb_real along[TB_K_MAX], plain[TB_N_MAX], costs[TB_N_MAX];
    for (int r = 0; r < a->k; r++) {
        for (int j = 0; j < a->rank; j++) {
            along[j] = U[j][r] / square[j];
        }
        for (int p = 0; p < a->m; p++) {
            plain[p] = 0;
            for (int j = 0; j < a->rank; j++) {
                plain[p] += W[j][a->at[p]] * along[j];
            }
            a->G[p][r] = plain[p];
        }
        for (int p = 0; p < a->m; p++) {
            costs[p] = cost(a, p, plain);
        }
        for (int b = 0; b < a->blocks; b++) {
            for (int j = 0; j < a->d[b]; j++) {
                tb_real share = 0;
                for (int p = a->begin[b]; p < a->begin[b + 1]; p++) {
                    share += a->N[p][j] * costs[p];
                }
                for (int p = a->begin[b]; p < a->begin[b + 1]; p++) {
                    a->G[p][r] -= a->N[p][j] * share;
                }
            }
        }
        for (int p = 0; p < a->m; p++) {
            a->G[p][r] *= a->unit[r];
        }
    }
    for (int p = 0; p < a->m; p++) {
        for (int r = a->k; r < TB_K_MAX; r++) {
            a->G[p][r] = 0;
        }
    }
}

/* What A G misses of a wrench that thrusters push, and A N of zero: rounding, or nothing may be answered. */
static tb_real missed(const struct tb_allocator *a)
{
    tb_real most = 0;
    for (int r = 0; r < a->k; r++) {
        for (int s = 0; s < a->k; s++) {
            tb_real sum = 0;
            for (int p = 0; p < a->m; p++) {
                sum += a->A[r][a->at[p]] * a->G[p][s];
            }
            sum = TB_R(r == s) - sum / a->unit[s];
            for (int j = 0; j < a->k - a->rank; j++) {
                sum -= a->lost[j][r] * a->lost[j][s] / (a->unit[r] * a->unit[s]) * a->scale * a->scale;
            }
            most = tb_abs(sum) > most ? tb_abs(sum) : most;
        }
        for (int b = 0; b < a->blocks; b++) {
            for (int j = 0; j < a->d[b]; j++) {
                tb_real sum = 0, size = 0;
                for (int p = a->begin[b]; p < a->begin[b + 1]; p++) {
                    sum += a->A[r][a->at[p]] * a->N[p][j];
                    size += tb_abs(a->N[p][j]);
                }
                most = tb_abs(sum) > most * size ? tb_abs(sum) / size : most;
            }
        }
    }
    return most;
}

/* Fills in what depends on which thrusters work. */
static int refresh(struct tb_allocator *a, unsigned long off)
{
    tb_real W[TB_K_MAX][TB_N_MAX], V[TB_K_MAX][TB_N_MAX], U[TB_K_MAX][TB_K_MAX], B[TB_N_MAX][TB_N_MAX];
    tb_real square[TB_K_MAX], least = 0, most = 0;
    a->m = a->rank = 0;
    for (int p = 0; p < TB_N_MAX; p++) {
        a->at[p] = 0;
    }
    for (int i = 0; i < a->n; i++) {
        if (a->readiness[i] > 0 && !(off >> i & 1UL)) {
            a->at[a->m++] = i;
        }
    }
    for (int r = 0; r < a->k; r++) {
        for (int p = 0; p < a->m; p++) {
            W[r][p] = a->A[r][a->at[p]];
        }
        for (int s = 0; s < a->k; s++) {
            U[r][s] = TB_R(r == s);
        }
    }
    tb_orthogonal(a->k, a->m, W, U);
    for (int j = 0, lost = 0; j < a->k; j++) {
        const tb_real length2 = tb_product(W[j], W[j], a->m);
        if (!(length2 > TB_RANK * TB_RANK)) {
            for (int r = 0; r < a->k; r++) {
                a->lost[lost][r] = U[j][r] * a->unit[r] / a->scale;
            }
            lost++;
            continue;
        }
        const int at = a->rank++;
        const tb_real length = tb_root(length2);
        square[at] = length2;
        most = length > most ? length : most;
        least = at == 0 || length < least ? length : least;
        for (int r = 0; r < a->k; r++) {
            U[at][r] = a->pushed[at][r] = U[j][r];
        }
        for (int p = 0; p < a->m; p++) {
            W[at][p] = W[j][p];
            V[at][p] = W[j][p] / length;
        }
    }
    a->gone = a->k - a->rank;
    const int d = tb_null_basis(a->rank, a->m, V, B);
    const tb_real doubt = TB_DOUBT * TB_EPS * (a->rank ? most / least : TB_R(1)) * TB_EACH(a->n);
    int places[TB_N_MAX] = {0}, there[TB_N_MAX] = {0};
    for (int p = 0; p < a->m; p++) {
        places[p] = a->at[p];
    }
    if (!blocks(a, d, B)) {
        return TB_NEARLY_SINGULAR;
    }
    /* Columns of W in the order of the blocks. */
    for (int p = 0; p < a->m; p++) {
        there[p] = p;
        for (int q = 0; q < a->m; q++) {
            there[p] = places[q] == a->at[p] ? q : there[p];
        }
    }
    for (int j = 0; j < a->rank; j++) {
        for (int p = 0; p < a->m; p++) {
            V[j][a->at[p]] = W[j][there[p]];
        }
    }
    inverse(a, square, U, V);
    a->slack = a->scale * (TB_TOLERANCE > doubt ? TB_TOLERANCE : doubt);
    a->exact = a->scale * (TB_MET > 16 * TB_R(a->n) * doubt ? TB_MET / 4 / doubt : 4 * TB_R(a->n));
    if (!(missed(a) <= TB_MET / 4) || !(doubt <= TB_LARGEST_DOUBT)) {
        return TB_NEARLY_SINGULAR;
    }
    tb_find_steps(a);
    tb_find_facets(a, doubt);
    if (a->facets < 0) { /* entries of little may have taken the room */
        tb_find_facets(a, TB_LARGEST);
    }
    return TB_SOLVED;
}

/* Whether these are a vehicle's numbers. */
static int sound(int k, int n, const tb_real *T, const tb_real *H, const tb_real *readiness, const tb_real *f_min,
                 const tb_real *f_max)
{
    if (!tb_is_finite(T, k * n) || (H != NULL && !tb_is_finite(H, n * n)) || !tb_is_finite(f_min, n) ||
        !tb_is_finite(f_max, n)) {
        return 0;
    }
    for (int i = 0; i < n; i++) {
        if (!(f_min[i] <= f_max[i]) || (readiness != NULL && !(readiness[i] >= 0 && readiness[i] <= 1))) {
            return 0;
        }
    }
    return 1;
}

int tb_prepare(struct tb_allocator *a, int k, int n, const tb_real *T, const tb_real *H, const tb_real *readiness,
               const tb_real *f_min, const tb_real *f_max)
{
    tb_real L[TB_N_MAX][TB_N_MAX], longest = 0;
    a->n = a->parts = 0;
    if (k < 1 || k > TB_K_MAX || n < 1 || n > TB_N_MAX || T == NULL || f_min == NULL || f_max == NULL ||
        !sound(k, n, T, H, readiness, f_min, f_max)) {
        return TB_BAD_ARGUMENT;
    }
    a->scale = 0;
    a->crossed = 0;
    for (int i = 0; i < n; i++) {
        a->readiness[i] = readiness == NULL ? TB_R(1) : readiness[i];
        a->f_min[i] = f_min[i];
        a->f_max[i] = f_max[i];
        a->scale = tb_abs(f_min[i]) > a->scale ? tb_abs(f_min[i]) : a->scale;
        a->scale = tb_abs(f_max[i]) > a->scale ? tb_abs(f_max[i]) : a->scale;
        for (int j = 0; j < n; j++) {
            a->H[i][j] = L[i][j] = H == NULL ? TB_R(i == j) : H[i * n + j];
            a->crossed |= i != j && L[i][j] != 0;
        }
    }
    for (int r = 0; r < k; r++) {
        a->unit[r] = tb_root(tb_product(T + r * n, T + r * n, n));
        longest = a->unit[r] > longest ? a->unit[r] : longest;
    }
    if (!(a->scale > 0) || !(longest > 0) || !cholesky(n, L)) {
        return TB_BAD_ARGUMENT;
    }
    for (int r = 0; r < k; r++) {
        a->unit[r] = 1 / (a->unit[r] > TB_RANK * longest ? a->unit[r] : longest);
        for (int i = 0; i < n; i++) {
            a->A[r][i] = T[r * n + i] * a->readiness[i] * a->unit[r];
        }
    }
    a->k = k;
    a->n = n;
    a->levels = 1;
    for (int r = 0; r < TB_K_MAX; r++) {
        a->level[r] = 0;
    }
    return tb_without(a, 0);
}

int tb_without(struct tb_allocator *a, unsigned long mask)
{
    if (a->n < 1) {
        return TB_BAD_ARGUMENT;
    }
    a->parts = 0;
    /* In two steps, as a shift by all bits of a type is undefined. */
    const int status = mask >> (a->n - 1) >> 1 ? (int)TB_NO_SUCH_FAULT : refresh(a, mask);
    a->m = status == TB_SOLVED ? a->m : -1; /* calls refuse */
    return status;
}
