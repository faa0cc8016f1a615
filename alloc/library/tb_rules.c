/* What practice does behind T*: tb_clip, and tb_redistribute, which shares what saturated thrusters leave undone. */
#include "tb_internal.h"

#ifdef TB_FLOAT
#define SPARE TB_TOLERANCE /* a thrust freezes where it is beyond a limit by more than this share of the largest */
#else
#define SPARE TB_R(1e-10)
#endif

/* Cuts thrusts at the limits and writes them; `off` is what they were moved by before. */
static int cut(const struct tb_allocator *a, const tb_real *tau, struct tb_thrusts *t, tb_real off, tb_real *f)
{
    const tb_real moved = tb_move_inside(a, t);
    if (moved < 0 || !(moved - moved == 0)) {
        return moved < 0 ? tb_refused(a, tau, TB_INFEASIBLE) : (int)TB_NOT_FINITE;
    }
    tb_leave(a, t, f);
    return tb_meets(a, tau, t, moved + off) ? TB_SOLVED : TB_PARTIAL;
}

int tb_clip(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max, tb_real *f)
{
    struct tb_thrusts t;
    const int status = tb_enter(a, tau, f_min, f_max, &t);
    return status == TB_SOLVED ? cut(a, tau, &t, 0, f) : tb_refused(a, tau, status);
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

int tb_redistribute(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                    tb_real *f)
{
    struct tb_thrusts t;
    tb_real frozen[TB_N_MAX], rest[TB_K_MAX];
    int on[TB_N_MAX], more = 1, passes = 0;
    const int status = tb_enter(a, tau, f_min, f_max, &t);
    if (status != TB_SOLVED || !tb_is_finite(tau, a->k)) {
        return tb_refused(a, tau, status);
    }
    for (int p = 0; p < a->m; p++) {
        on[p] = 1;
        frozen[p] = 0;
    }
    for (int pass = 0; pass < a->m && more; pass++) {
        more = 0;
        for (int p = 0; p < a->m; p++) {
            if (on[p] && !(t.x[p] >= t.low[p] - SPARE * a->scale && t.x[p] <= t.high[p] + SPARE * a->scale)) {
                frozen[p] = t.x[p] < t.low[p] ? t.low[p] : t.high[p];
                on[p] = 0;
                more = 1;
            }
        }
        for (int r = 0; r < a->k && more; r++) {
            rest[r] = tau[r] * a->unit[r];
            for (int p = 0; p < a->m; p++) {
                rest[r] -= a->A[r][a->at[p]] * frozen[p];
            }
        }
        if (more) {
            tb_shared(a, rest, on, t.x);
            passes++;
        }
        for (int p = 0; p < a->m; p++) {
            t.x[p] = on[p] ? t.x[p] : frozen[p];
        }
    }
    return cut(a, tau, &t, passes ? a->scale : 0, f);
}
