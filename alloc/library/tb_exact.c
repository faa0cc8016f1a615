/* The exact optimum: f = G tau + N z with the shortest z that respects the limits, block by block. */
#include "tb_internal.h"

enum { CAP = 8 }; /* steps for each slab and dimension; a random search over vehicles saw fewer than 2 */

int tb_enter(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
             struct tb_thrusts *t)
{
    const int m = a->m, k = a->k;
    tb_real sum = 0, crossing = 0;
    if (a->n < 1 || m < 0) {
        return TB_BAD_ARGUMENT;
    }
    f_min = f_min == NULL ? a->f_min : f_min;
    f_max = f_max == NULL ? a->f_max : f_max;
    if (m == 0 || a->rank < k) {
        sum = tb_product(tau, tau, k); /* which G may not look at */
    }
    for (int p = 0; p < m; p++) {
        const int i = a->at[p];
        const tb_real x = tb_product(a->G[p], tau, k), low = f_min[i], high = f_max[i], width = high - low;
        t->x[p] = x;
        t->low[p] = low;
        t->high[p] = high;
        sum += x + width;
        crossing = width < crossing ? width : crossing;
    }
    if (!(sum - sum == 0)) { /* what is NaN or infinite makes a sum so */
        return TB_NOT_FINITE;
    }
    return crossing < 0 ? TB_INFEASIBLE : TB_SOLVED;
}

/* One dimension: 0 clamped into the interval that all rows allow. The first rows look ahead, the others astern. */
static int clamped(const struct tb_allocator *a, struct tb_thrusts *t, int begin, int end, tb_real slack)
{
    tb_real low = -TB_LARGEST, high = TB_LARGEST, most = 0;
    for (int p = begin; p < end; p++) {
        const tb_real per = a->N[p][1], below = (t->low[p] - t->x[p]) * per, above = (t->high[p] - t->x[p]) * per;
        const tb_real least = per > 0 ? below : above, largest = per > 0 ? above : below;
        low = least > low ? least : low;
        high = largest < high ? largest : high;
    }
    if (low > high) {
        for (int p = begin; p < end; p++) {
            most = tb_abs(a->N[p][0]) > most ? tb_abs(a->N[p][0]) : most;
        }
        if ((low - high) * most > slack) {
            return TB_INFEASIBLE;
        }
        low = high = TB_R(0.5) * (low + high);
    }
    const tb_real z = low > 0 ? low : high < 0 ? high : TB_R(0);
    for (int p = begin; p < end; p++) {
        t->x[p] += a->N[p][0] * z;
    }
    return TB_SOLVED;
}

/* Rows that hold as equations, with what they cost: A_W' = Q R, multipliers u. */
struct active {
    int q, row[TB_N_MAX];
    tb_real side[TB_N_MAX], u[TB_N_MAX], Q[TB_N_MAX][TB_N_MAX], R[TB_N_MAX][TB_N_MAX];
};

/* What Q leaves of g (d) as h, with its coefficients c; twice, for what rounding leaves the first time. */
static tb_real left_over(const struct active *w, int d, const tb_real *g, tb_real *h, tb_real *c)
{
    for (int j = 0; j < d; j++) {
        h[j] = g[j];
        c[j] = 0;
    }
    for (int again = 0; again < 2; again++) {
        for (int j = 0; j < w->q; j++) {
            const tb_real along = tb_product(w->Q[j], h, d);
            c[j] += along;
            for (int l = 0; l < d; l++) {
                h[l] -= along * w->Q[j][l];
            }
        }
    }
    return tb_product(h, h, d);
}

static void append(struct active *w, int d, const tb_real *h, const tb_real *c, tb_real length)
{
    for (int l = 0; l < d; l++) {
        w->Q[w->q][l] = h[l] / length;
        w->R[w->q][l] = c[l];
    }
    w->R[w->q][w->q] = length;
    w->q++;
}

/* Takes a row out, and makes Q and R of those behind it again. */
static void take_out(struct active *w, int d, tb_real N[TB_N_MAX][TB_N_MAX], int begin, int out)
{
    const int count = w->q;
    tb_real g[TB_N_MAX], h[TB_N_MAX], c[TB_N_MAX];
    w->q = out;
    for (int j = out + 1; j < count; j++) {
        w->row[j - 1] = w->row[j];
        w->side[j - 1] = w->side[j];
        w->u[j - 1] = w->u[j];
        for (int l = 0; l < d; l++) {
            g[l] = w->side[j - 1] * N[begin + w->row[j - 1]][l];
        }
        const tb_real square = left_over(w, d, g, h, c);
        append(w, d, h, c, tb_root(square > TB_EPS * TB_EPS ? square : TB_EPS * TB_EPS));
    }
}

/* More dimensions: the dual active set of Goldfarb and Idnani (1983). z goes from 0, the best of all, to the nearest
 * point of one violated slab after another; each step makes it dearer, so no set of rows comes twice. */
static int active_set(const struct tb_allocator *a, struct tb_thrusts *t, int begin, int end, int d, tb_real slack)
{
    struct active w;
    tb_real N[TB_N_MAX][TB_N_MAX], z[TB_N_MAX], g[TB_N_MAX], h[TB_N_MAX], c[TB_N_MAX];
    int held[TB_N_MAX], left = CAP * (end - begin + d);
    const int m = end - begin;
    w.q = 0;
    for (int i = 0; i < m; i++) {
        held[i] = 0;
    }
    for (int p = begin; p < end; p++) {
        for (int l = 0; l < d; l++) {
            N[p][l] = a->N[p][l];
        }
    }
    for (int l = 0; l < d; l++) {
        z[l] = 0;
    }
    while (left > 0) {
        tb_real worst = 4 * TB_EPS * a->scale, side = 1, cost = 0;
        int chosen = -1;
        for (int i = 0; i < m; i++) {
            const int p = begin + i;
            const tb_real s = t->x[p] + tb_product(N[p], z, d);
            if (!held[i] && (t->low[p] - s > worst || s - t->high[p] > worst)) {
                side = t->low[p] - s > worst ? TB_R(1) : TB_R(-1);
                worst = side > 0 ? t->low[p] - s : s - t->high[p];
                chosen = i;
            }
        }
        if (chosen < 0) {
            for (int p = begin; p < end; p++) {
                t->x[p] += tb_product(N[p], z, d);
            }
            return TB_SOLVED;
        }
        const int row = begin + chosen;
        for (int l = 0; l < d; l++) {
            g[l] = side * N[row][l];
        }
        for (int done = 0; !done && left > 0; left--) {
            const tb_real square = left_over(&w, d, g, h, c), s = t->x[row] + tb_product(N[row], z, d);
            const tb_real short_of = side > 0 ? t->low[row] - s : s - t->high[row];
            const tb_real whole = tb_product(g, g, d);
            const int free = w.q < d && square > TB_ZERO * TB_ZERO * whole;
            tb_real r[TB_N_MAX], step = free ? short_of / square : TB_LARGEST;
            int out = -1;
            for (int j = w.q - 1; j >= 0; j--) {
                r[j] = c[j];
                for (int l = j + 1; l < w.q; l++) {
                    r[j] -= w.R[l][j] * r[l];
                }
                r[j] /= w.R[j][j];
            }
            for (int j = 0; j < w.q; j++) {
                if (r[j] > TB_EPS && w.u[j] < step * r[j]) {
                    step = w.u[j] / r[j];
                    out = j;
                }
            }
            if (!free && out < 0) { /* no z holds all of these rows */
                if (short_of > slack) {
                    return TB_INFEASIBLE;
                }
                held[chosen] = done = 1;
                continue;
            }
            for (int j = 0; j < w.q; j++) {
                w.u[j] -= step * r[j];
            }
            for (int l = 0; l < d && free; l++) {
                z[l] += step * h[l];
            }
            cost += step;
            if (out >= 0) {
                held[w.row[out]] = 0;
                take_out(&w, d, N, begin, out);
                continue;
            }
            w.row[w.q] = chosen;
            w.side[w.q] = side;
            w.u[w.q] = cost;
            append(&w, d, h, c, tb_root(square));
            held[chosen] = done = 1;
        }
    }
    return TB_NOT_CONVERGED;
}

/* Moves thrusts to the least effort that makes the same wrench inside limits. */
int tb_nearest(const struct tb_allocator *a, struct tb_thrusts *t, tb_real slack)
{
    int status = TB_SOLVED;
    for (int b = 0; b < a->blocks && status == TB_SOLVED; b++) {
        status = a->d[b] == 1 ? clamped(a, t, a->begin[b], a->begin[b + 1], slack)
                              : active_set(a, t, a->begin[b], a->begin[b + 1], a->d[b], slack);
    }
    for (int p = a->begin[a->blocks]; p < a->m && status == TB_SOLVED; p++) {
        if (t->low[p] - t->x[p] > slack || t->x[p] - t->high[p] > slack) {
            status = TB_INFEASIBLE;
        }
    }
    return status;
}

/* Moves thrusts onto limits that rounding took them across. T (G tau + N z) is tau whatever z is, so the sum of these
 * moves, which it returns, is what the wrench errs by. */
tb_real tb_move_inside(const struct tb_allocator *a, struct tb_thrusts *t)
{
    tb_real moved = 0, size = 0;
    for (int p = 0; p < a->m; p++) {
        const tb_real x = t->x[p];
        tb_real y = x > t->low[p] ? x : t->low[p];
        y = y < t->high[p] ? y : t->high[p];
        t->x[p] = y;
        moved += tb_abs(x - y);
        size += tb_abs(y);
    }
    t->size = size;
    return moved;
}

/* Whether T f = tau holds within what SOLVED may miss, for thrusts that were `moved` in all. */
int tb_meets(const struct tb_allocator *a, const tb_real *tau, const struct tb_thrusts *t, tb_real moved)
{
    if (moved <= TB_HELD * a->scale && t->size <= a->exact && a->rank == a->k) {
        return 1;
    }
    for (int r = 0; r < a->k; r++) {
        tb_real sum = -tau[r] * a->unit[r];
        for (int p = 0; p < a->m; p++) {
            sum += a->A[r][a->at[p]] * t->x[p];
        }
        if (!(tb_abs(sum) <= TB_MET * a->scale)) {
            return 0;
        }
    }
    return 1;
}

void tb_leave(const struct tb_allocator *a, const struct tb_thrusts *t, tb_real *f)
{
    for (int i = 0; i < a->n && a->m < a->n; i++) {
        f[i] = 0;
    }
    for (int p = 0; p < a->m; p++) {
        f[a->at[p]] = t->x[p];
    }
}

int tb_nullspace(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                 tb_real *f)
{
    struct tb_thrusts t;
    int status = tb_enter(a, tau, f_min, f_max, &t);
    for (int j = 0; status == TB_SOLVED && j < a->k - a->rank; j++) {
        if (tb_abs(tb_product(a->lost[j], tau, a->k)) > TB_TOLERANCE) {
            return TB_INFEASIBLE;
        }
    }
    if (status == TB_SOLVED) {
        status = tb_nearest(a, &t, a->slack);
    }
    if (status != TB_SOLVED) {
        return status;
    }
    if (!tb_meets(a, tau, &t, tb_move_inside(a, &t))) {
        return TB_NOT_CONVERGED;
    }
    tb_leave(a, &t, f);
    return TB_SOLVED;
}
