/* The exact optimum: f = G tau + N z with the shortest z that respects the limits, block by block. */
#include "tb_internal.h"

/* Steps for each slab and dimension. Searches of 100,000 random and 100,000 nearly symmetric vehicles of up to 12
 * thrusters took 1.25 and 1.7 at most. */
enum { CAP = 8 };
enum { WIDER = 5, PASSES = 4 }; /* of limits, and of thrusts moved inside them */

/* x = G tau and the limits, in the order of `at`. A limit that is NaN or infinite makes the sum of widths so. */
int tb_enter(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
             struct tb_thrusts *t)
{
    const int m = a->m, k = a->k;
    tb_real widths = 0;
    if (a->n < 1 || m < 0) {
        return TB_BAD_ARGUMENT;
    }
    f_min = f_min == NULL ? a->f_min : f_min;
    f_max = f_max == NULL ? a->f_max : f_max;
    /* In variables, since what is written to t might be tau for all that a compiler knows. */
    const tb_real t0 = tau[0], t1 = tb_entry(tau, k, 1), t2 = tb_entry(tau, k, 2), t3 = tb_entry(tau, k, 3);
    const tb_real t4 = tb_entry(tau, k, 4), t5 = tb_entry(tau, k, 5);
    for (int p = 0; p < m; p++) {
        const int i = a->at[p];
        const tb_real low = f_min[i], high = f_max[i];
        t->x[p] = tb_row(a->G[p], t0, t1, t2, t3, t4, t5);
        t->low[p] = low;
        t->high[p] = high;
        widths += high - low;
    }
    return widths - widths == 0 ? TB_SOLVED : TB_NOT_FINITE;
}

/* The status of a call without an answer: whether tau is finite is asked only here, where no call that is answered
 * pays. NaN or infinity in tau leaves some x that no comparison finds inside. */
int tb_refused(const struct tb_allocator *a, const tb_real *tau, int status)
{
    return status == TB_BAD_ARGUMENT || tb_is_finite(tau, a->k) ? status : TB_NOT_FINITE;
}

/* One dimension: 0 clamped into the interval that all rows allow; those in front of `astern` look ahead. */
static int clamped(const struct tb_allocator *a, struct tb_thrusts *t, int begin, int astern, int end, tb_real slack)
{
    tb_real low = -TB_LARGEST, high = TB_LARGEST, most = 0;
    for (int p = begin; p < astern; p++) {
        const tb_real x = t->x[p], per = a->per[p], below = t->low[p] * per - x * per, above = t->high[p] * per - x * per;
        low = below > low ? below : low;
        high = above < high ? above : high;
    }
    for (int p = astern; p < end; p++) {
        const tb_real x = t->x[p], per = a->per[p], below = t->high[p] * per - x * per, above = t->low[p] * per - x * per;
        low = below > low ? below : low;
        high = above < high ? above : high;
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
    if (low > 0 || high < 0) {
        const tb_real z = low > 0 ? low : high;
        for (int p = begin; p < end; p++) {
            t->x[p] += a->N[p][0] * z;
        }
    }
    return TB_SOLVED;
}

/* Rows that hold as equations: A_W' = Q R with orthogonal columns Q, R with ones in its diagonal; multipliers u. */
struct active {
    int q, row[TB_N_MAX];
    tb_real side[TB_N_MAX], u[TB_N_MAX], square[TB_N_MAX], Q[TB_N_MAX][TB_N_MAX], R[TB_N_MAX][TB_N_MAX];
};

/* g'h of d >= 2 entries, the first two of them without a loop. */
static inline tb_real along_of(const tb_real *g, const tb_real *h, int d)
{
    tb_real sum = g[0] * h[0] + g[1] * h[1];
    for (int l = 2; l < d; l++) {
        sum += g[l] * h[l];
    }
    return sum;
}

/* What Q leaves of a row g (d), as h, with its coefficients c; again where little is left, for rounding's sake.
 * Returns the square of its length, and 0 where that is rounding: g is then a sum of the rows of Q. */
static tb_real left_over(const struct active *w, int d, const tb_real *g, tb_real side, tb_real *h, tb_real *c)
{
    tb_real whole = 0, square;
    for (int l = 0; l < d; l++) {
        h[l] = side * g[l];
        whole += g[l] * g[l];
    }
    square = whole;
    for (int again = 0; again < 2 && w->q > 0 && (!again || square < TB_R(0.01) * whole); again++) {
        for (int j = 0; j < w->q; j++) {
            const tb_real along = along_of(w->Q[j], h, d) / w->square[j];
            c[j] = again ? c[j] + along : along;
            for (int l = 0; l < d; l++) {
                h[l] -= along * w->Q[j][l];
            }
        }
        square = along_of(h, h, d);
    }
    return w->q < d && square > TB_ZERO * TB_ZERO * whole ? square : TB_R(0);
}

static void append(struct active *w, int d, const tb_real *h, const tb_real *c, tb_real square)
{
    for (int l = 0; l < d; l++) {
        w->Q[w->q][l] = h[l];
    }
    for (int j = 0; j < w->q; j++) {
        w->R[w->q][j] = c[j];
    }
    w->square[w->q++] = square;
}

/* Takes a row out, and makes Q and R of those behind it again. */
static void take_out(const struct tb_allocator *a, struct active *w, int d, int out)
{
    const int count = w->q;
    tb_real h[TB_N_MAX], c[TB_N_MAX];
    w->q = out;
    for (int j = out + 1; j < count; j++) {
        w->q = j - 1;
        w->row[j - 1] = w->row[j];
        w->side[j - 1] = w->side[j];
        w->u[j - 1] = w->u[j];
        const tb_real square = left_over(w, d, a->N[w->row[j]], w->side[j], h, c);
        append(w, d, h, c, square > 0 ? square : TB_ZERO * TB_ZERO);
    }
}

/* The row whose limit is exceeded most, beyond rounding, and on which side; -1 where none is. */
static int worst_of(const struct tb_thrusts *t, int begin, int end, unsigned long held, tb_real rounding, tb_real *side)
{
    int chosen = -1;
    for (int p = begin; p < end; p++) {
        const tb_real x = t->x[p], below = t->low[p] - x, above = x - t->high[p];
        if (below > rounding && !(held >> p & 1UL)) {
            rounding = below;
            *side = 1;
            chosen = p;
        }
        if (above > rounding && !(held >> p & 1UL)) {
            rounding = above;
            *side = -1;
            chosen = p;
        }
    }
    return chosen;
}

/* More dimensions: the dual active set of Goldfarb and Idnani (1983). z goes from 0, the best of all, to the nearest
 * point of one violated slab after another; each step makes it dearer, so no set of rows comes twice. */
static int active_set(const struct tb_allocator *a, struct tb_thrusts *t, int begin, int end, int d, tb_real slack)
{
    struct active w;
    tb_real h[TB_N_MAX], c[TB_N_MAX], r[TB_N_MAX];
    unsigned long held = 0; /* bits, of rows that are not to be looked at */
    int left = CAP * (end - begin + d);
    w.q = 0;
    for (int j = 0; j < TB_N_MAX; j++) {
        w.row[j] = 0;
    }
    while (left > 0) {
        tb_real side = 1, cost = 0;
        const int chosen = worst_of(t, begin, end, held, 4 * TB_EPS * a->scale, &side);
        if (chosen < 0) {
            return TB_SOLVED;
        }
        for (int done = 0; !done && left > 0; left--) {
            const tb_real square = left_over(&w, d, a->N[chosen], side, h, c), x = t->x[chosen];
            const tb_real short_of = side > 0 ? t->low[chosen] - x : x - t->high[chosen];
            tb_real step = square > 0 ? short_of / square : TB_LARGEST, rows = 1;
            int out = -1;
            for (int j = w.q - 1; j >= 0; j--) {
                r[j] = c[j];
                for (int l = j + 1; l < w.q; l++) {
                    r[j] -= w.R[l][j] * r[l];
                }
                rows += tb_abs(r[j]);
                if (r[j] > TB_EPS && w.u[j] < step * r[j]) {
                    step = w.u[j] / r[j];
                    out = j;
                }
            }
            if (!(square > 0) && out < 0) { /* no z holds all of these rows; each may be off by the slack */
                if (short_of > slack * rows) {
                    return TB_INFEASIBLE;
                }
                held |= 1UL << chosen;
                done = 1;
                continue;
            }
            for (int j = 0; j < w.q; j++) {
                w.u[j] -= step * r[j];
            }
            for (int p = begin; p < end && square > 0; p++) {
                t->x[p] += step * along_of(a->N[p], h, d);
            }
            cost += step;
            if (out >= 0) {
                held &= ~(1UL << w.row[out]);
                take_out(a, &w, d, out);
                continue;
            }
            if (w.q >= d) { /* never: rows that leave each other something are no more than dimensions */
                return TB_NOT_CONVERGED;
            }
            w.row[w.q] = chosen;
            w.side[w.q] = side;
            w.u[w.q] = cost;
            append(&w, d, h, c, square);
            held |= 1UL << chosen;
            done = 1;
        }
    }
    return TB_NOT_CONVERGED;
}

/* The row whose limit z exceeds most, beyond rounding, on which side and how far; -1 where none is. */
static int farthest(const struct tb_allocator *a, const struct tb_thrusts *t, int begin, int end, unsigned long held,
                    const tb_real z[2], tb_real *side, tb_real *excess)
{
    const tb_real z0 = z[0], z1 = z[1];
    tb_real most = 4 * TB_EPS * a->scale;
    int chosen = -1;
    for (int p = begin; p < end; p++) {
        const tb_real x = t->x[p] + a->N[p][0] * z0 + a->N[p][1] * z1, below = t->low[p] - x, above = x - t->high[p];
        if (below > most && !(held >> p & 1UL)) {
            most = below;
            *side = 1;
            chosen = p;
        }
        if (above > most && !(held >> p & 1UL)) {
            most = above;
            *side = -1;
            chosen = p;
        }
    }
    *excess = most;
    return chosen;
}

/* A row of N that holds as an equation, turned to the side that it came from, and its multiplier. */
struct edge {
    int row;
    tb_real n0, n1, u;
};

static void hold(struct edge *one, int row, tb_real n0, tb_real n1, tb_real u)
{
    one->row = row;
    one->n0 = n0;
    one->n1 = n1;
    one->u = u;
}

/* Two dimensions: the steps of `active_set` in closed form, with no, one or two rows held. */
static int plane(const struct tb_allocator *a, struct tb_thrusts *t, int begin, int end, tb_real slack)
{
    struct edge first = {0, 0, 0, 0}, second = {0, 0, 0, 0};
    tb_real z[2] = {0, 0};
    unsigned long held = 0;
    int q = 0, left = CAP * (end - begin + 2);
    while (left > 0) {
        tb_real side = 1, excess, cost = 0;
        const int chosen = farthest(a, t, begin, end, held, z, &side, &excess);
        if (chosen < 0) {
            for (int p = begin; p < end; p++) {
                t->x[p] += a->N[p][0] * z[0] + a->N[p][1] * z[1];
            }
            return TB_SOLVED;
        }
        const tb_real n0 = side * a->N[chosen][0], n1 = side * a->N[chosen][1], per = a->per[chosen];
        for (int done = 0; !done && left > 0; left--) {
            if (q == 0) {
                const tb_real step = excess * per;
                z[0] += step * n0;
                z[1] += step * n1;
                hold(&first, chosen, n0, n1, cost + step);
                held |= 1UL << chosen;
                q = done = 1;
                continue;
            }
            const tb_real across = first.n0 * n1 - first.n1 * n0;
            if (q == 2) { /* n = c first + d second: one of them goes, or no z holds all three */
                const tb_real det = first.n0 * second.n1 - first.n1 * second.n0;
                const tb_real c = (n0 * second.n1 - n1 * second.n0) / det, d = across / det;
                const int has_first = c > TB_EPS, has_second = d > TB_EPS;
                if (!has_first && !has_second) {
                    if (excess > slack * (1 + tb_abs(c) + tb_abs(d))) {
                        return TB_INFEASIBLE;
                    }
                    held |= 1UL << chosen;
                    done = 1;
                    continue;
                }
                const int out = has_first && (!has_second || first.u * d < second.u * c);
                const tb_real step = out ? first.u / c : second.u / d;
                held &= ~(1UL << (out ? first.row : second.row));
                first.u -= step * c;
                second.u -= step * d;
                if (out) {
                    hold(&first, second.row, second.n0, second.n1, second.u);
                }
                cost += step;
                q = 1;
                continue;
            }
            const tb_real own = a->per[first.row], c = (first.n0 * n0 + first.n1 * n1) * own;
            const tb_real height = across * own, square = height * across;
            const int is_new = square * per > TB_ZERO * TB_ZERO;
            if (!is_new && !(c > TB_EPS)) {
                if (excess > slack * (1 + tb_abs(c))) {
                    return TB_INFEASIBLE;
                }
                held |= 1UL << chosen;
                done = 1;
                continue;
            }
            tb_real step = is_new ? excess / square : TB_LARGEST;
            const int out = c > TB_EPS && first.u < step * c;
            step = out ? first.u / c : step;
            if (is_new) {
                z[0] -= step * height * first.n1;
                z[1] += step * height * first.n0;
                excess -= step * square;
            }
            cost += step;
            first.u -= step * c;
            if (out) {
                held &= ~(1UL << first.row);
                q = 0;
            } else {
                hold(&second, chosen, n0, n1, cost);
                held |= 1UL << chosen;
                q = 2;
                done = 1;
            }
        }
    }
    return TB_NOT_CONVERGED;
}

/* Moves thrusts to the least effort that makes the same wrench inside limits. */
int tb_nearest(const struct tb_allocator *a, struct tb_thrusts *t, tb_real slack)
{
    int status = TB_SOLVED;
    for (int b = 0; b < a->blocks && status == TB_SOLVED; b++) {
        const int begin = a->begin[b], end = a->begin[b + 1], d = a->d[b];
        status = d == 1   ? clamped(a, t, begin, a->astern[b], end, slack)
                 : d == 2 ? plane(a, t, begin, end, slack)
                          : active_set(a, t, begin, end, d, slack);
    }
    for (int p = a->begin[a->blocks]; p < a->m && status == TB_SOLVED; p++) {
        if (t->low[p] - t->x[p] > slack || t->x[p] - t->high[p] > slack) {
            status = TB_INFEASIBLE;
        }
    }
    return status;
}

/* Moves thrusts onto limits that rounding took them across. T (G tau + N z) is tau whatever z is, so the sum of these
 * moves, which it returns, is what the wrench errs by. Negative where limits cross: then no thrust is inside. */
tb_real tb_move_inside(const struct tb_allocator *a, struct tb_thrusts *t)
{
    tb_real moved = 0, size = 0;
    for (int p = 0; p < a->m; p++) {
        const tb_real x = t->x[p], low = t->low[p], high = t->high[p];
        size += tb_abs(x);
        if (x >= low && x <= high) {
            continue;
        }
        if (!(low <= high)) {
            return -1;
        }
        t->x[p] = x < low ? low : high;
        moved += tb_abs(x - t->x[p]);
    }
    t->size = size;
    return moved;
}

/* Thrusts where the steps from t went wrong by more than rounding: the same within wider limits (WIDER).
 *
 * A wrench on the edge leaves thrusts no room, so a step onto a thin row may go anywhere. Limits moved apart leave
 * some; thrusts are moved back from those, and thrusters that are free share what the wrench tau (NULL: that of t) then
 * misses. Returns whether it is missed by no more than `miss` times the largest limit; t is inside in any case.
 */
int tb_again(const struct tb_allocator *a, const tb_real *tau, struct tb_thrusts *t, tb_real miss)
{
    const tb_real wider[WIDER] = {TB_R(1e-3), TB_R(1e-2), TB_R(1e-1), 1, 10};
    tb_real wanted[TB_K_MAX], rest[TB_K_MAX], more[TB_N_MAX], best[TB_N_MAX], x[TB_N_MAX], least = TB_LARGEST;
    struct tb_thrusts wide;
    int on[TB_N_MAX];
    for (int r = 0; r < a->k; r++) {
        wanted[r] = tau == NULL ? TB_R(0) : tau[r] * a->unit[r];
        for (int p = 0; p < a->m && tau == NULL; p++) {
            wanted[r] += a->A[r][a->at[p]] * t->x[p];
        }
    }
    for (int p = 0; p < a->m; p++) {
        x[p] = best[p] = t->x[p];
    }
    for (int i = 0; i < WIDER && least > TB_BEST * a->scale; i++) {
        for (int p = 0; p < a->m; p++) {
            wide.x[p] = x[p];
            wide.low[p] = t->low[p] - wider[i] * TB_HELD * a->scale;
            wide.high[p] = t->high[p] + wider[i] * TB_HELD * a->scale;
        }
        if (tb_nearest(a, &wide, TB_LARGEST) != TB_SOLVED) {
            continue;
        }
        for (int p = 0; p < a->m; p++) {
            t->x[p] = wide.x[p];
        }
        for (int pass = 0; pass < PASSES; pass++) {
            tb_real missed = 0;
            tb_move_inside(a, t);
            for (int r = 0; r < a->k; r++) {
                rest[r] = wanted[r];
                for (int p = 0; p < a->m; p++) {
                    rest[r] -= a->A[r][a->at[p]] * t->x[p];
                }
                missed = tb_abs(rest[r]) > missed ? tb_abs(rest[r]) : missed;
            }
            for (int p = 0; p < a->m; p++) {
                on[p] = t->x[p] > t->low[p] && t->x[p] < t->high[p];
                best[p] = missed < least ? t->x[p] : best[p];
            }
            least = missed < least ? missed : least;
            if (pass + 1 == PASSES || least <= TB_BEST * a->scale) {
                break;
            }
            tb_shared(a, rest, on, more);
            for (int p = 0; p < a->m; p++) {
                t->x[p] += on[p] ? more[p] : TB_R(0);
            }
        }
    }
    for (int p = 0; p < a->m; p++) {
        t->x[p] = best[p];
    }
    tb_move_inside(a, t);
    return least <= miss * a->scale;
}

/* Whether tau asks for nothing along directions that no thruster pushes, and that are not just weak. */
int tb_asks_no_lost(const struct tb_allocator *a, const tb_real *tau)
{
    for (int j = 0; j < a->gone && j < TB_K_MAX; j++) {
        if (!(tb_abs(tb_product(a->lost[j], tau, a->k)) <= 2 * TB_HELD)) {
            return 0;
        }
    }
    return 1;
}

/* tb_meets of a vehicle with weak directions, which tau may ask for: what is pushed is compared, and nothing lost asked. */
static int meets_strong(const struct tb_allocator *a, const tb_real *tau, const struct tb_thrusts *t)
{
    tb_real miss[TB_K_MAX];
    for (int r = 0; r < a->k; r++) {
        miss[r] = -tau[r] * a->unit[r];
        for (int p = 0; p < a->m; p++) {
            miss[r] += a->A[r][a->at[p]] * t->x[p];
        }
    }
    for (int j = 0; j < a->rank; j++) {
        if (!(tb_abs(tb_product(a->pushed[j], miss, a->k)) <= 2 * TB_HELD * a->scale)) {
            return 0;
        }
    }
    return tb_asks_no_lost(a, tau);
}

/* Whether T f = tau holds within what SOLVED may miss, for thrusts that were `moved` in all. */
int tb_meets(const struct tb_allocator *a, const tb_real *tau, const struct tb_thrusts *t, tb_real moved)
{
    if (moved <= TB_HELD * a->scale && t->size <= a->exact && a->rank == a->k) {
        return 1;
    }
    if (a->gone < a->k - a->rank) {
        return meets_strong(a, tau, t);
    }
    for (int r = 0; r < a->k; r++) {
        tb_real sum = -tau[r] * a->unit[r];
        for (int p = 0; p < a->m; p++) {
            sum += a->A[r][a->at[p]] * t->x[p];
        }
        if (!(tb_abs(sum) <= 2 * TB_HELD * a->scale)) {
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
    tb_real moved;
    int near = 0, status = tb_enter(a, tau, f_min, f_max, &t);
    for (int j = 0; status == TB_SOLVED && j < a->gone && j < TB_K_MAX; j++) {
        if (!(tb_abs(tb_product(a->lost[j], tau, a->k)) <= TB_TOLERANCE)) {
            status = TB_INFEASIBLE;
        }
    }
    if (status == TB_SOLVED) {
        status = tb_nearest(a, &t, a->slack);
    }
    if (status != TB_SOLVED) {
        return tb_refused(a, tau, status);
    }
    moved = tb_move_inside(a, &t);
    if (moved > TB_HELD * a->scale) {
        tb_enter(a, tau, f_min, f_max, &t);
        near = tb_again(a, tau, &t, TB_MET);
    }
    if (moved < 0 || !tb_meets(a, tau, &t, moved)) {
        return tb_refused(a, tau, moved < 0 || near ? (int)TB_INFEASIBLE : (int)TB_NOT_CONVERGED);
    }
    tb_leave(a, &t, f);
    return TB_SOLVED;
}
