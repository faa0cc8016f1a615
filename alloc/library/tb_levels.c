/* As far towards the demand as the limits let, level by level, at least effort: tb_scaled, tb_priority. */
#include "tb_internal.h"

#define KEEP TB_R(0.99) /* a level that others follow stops at this share of the way to the edge */
#define OWN TB_R(0.3)   /* of a direction's length, the share on a level's axes above which it is the level's own */
#define INSET TB_R(0.05) /* where limits exclude zero, a start lies this share of their width inside */

int tb_levels(struct tb_allocator *a, const int *level)
{
    int most = 0, used = 0, own[TB_K_MAX] = {0};
    for (int j = 0; j < a->k && a->n > 0; j++) {
        if (level[j] < 0 || level[j] >= a->k) {
            return TB_BAD_ARGUMENT;
        }
        own[j] = level[j];
        most = level[j] > most ? level[j] : most;
        used |= 1 << level[j];
    }
    if (a->n < 1 || used != (1 << (most + 1)) - 1) {
        return TB_BAD_ARGUMENT;
    }
    for (int p = a->parts; p >= 0; p--) {
        for (int j = 0; j < TB_K_MAX; j++) {
            a[p].level[j] = own[j];
        }
        a[p].levels = most + 1;
        if (a[p].m >= 0) {
            tb_find_steps(a + p);
        }
    }
    return TB_SOLVED;
}

/* The step of a level is its columns of `step` times what is missing.
 *
 * Where the thrusters push every direction `step` is 1. Else, with F an orthonormal basis of what they push and earlier
 * levels leave, and S the rows of the level, it is F (S F)+ in the level's own directions: nearest on the level's axes.
 */
void tb_find_steps(struct tb_allocator *a)
{
    tb_real F[TB_K_MAX][TB_K_MAX], S[TB_K_MAX][TB_N_MAX], U[TB_K_MAX][TB_K_MAX], turned[TB_K_MAX];
    int axes[TB_K_MAX] = {0}, left = a->rank;
    for (int r = 0; r < a->k; r++) {
        for (int s = 0; s < a->k; s++) {
            a->step[r][s] = TB_R(r == s && a->rank == a->k);
            F[r][s] = a->pushed[r][s];
        }
    }
    for (int l = 0; l < a->levels && a->rank < a->k; l++) {
        int size = 0, kept = 0;
        for (int s = 0; s < a->k; s++) {
            if (a->level[s] == l) {
                axes[size++] = s;
            }
        }
        for (int j = 0; j < left; j++) {
            for (int i = 0; i < size; i++) {
                S[j][i] = F[j][axes[i]];
            }
            for (int i = 0; i < left; i++) {
                U[j][i] = TB_R(i == j);
            }
        }
        tb_orthogonal(left, size, S, U);
        /* F turned as S is: rows of which too little lies on the level are left for later levels. */
        for (int r = 0; r < a->k; r++) {
            kept = 0;
            for (int j = 0; j < left; j++) {
                turned[j] = 0;
                for (int i = 0; i < left; i++) {
                    turned[j] += U[j][i] * F[i][r];
                }
            }
            for (int j = 0; j < left; j++) {
                const tb_real square = tb_product(S[j], S[j], size);
                if (!(square > OWN * OWN)) {
                    F[kept++][r] = turned[j];
                    continue;
                }
                for (int i = 0; i < size; i++) {
                    const tb_real part = turned[j] * S[j][i] / square;
                    a->step[r][axes[i]] += part * a->unit[axes[i]] / a->unit[r];
                }
            }
        }
        left = kept;
    }
}

/* Where a way begins: 0 where limits allow it, else a little inside the end nearest to it. */
static tb_real start(tb_real low, tb_real high)
{
    const tb_real away = low > -high ? low : -high, width = INSET * (high - low);
    const tb_real inset = away <= 0 ? TB_R(0) : away < width ? away : width;
    const tb_real least = low + inset > 0 ? low + inset : TB_R(0);
    return least < high - inset ? least : high - inset;
}

/* The largest share of the step that stays inside, as alloc.reach.edge.share. `room` is what each thruster has left
 * ahead, then astern, then ahead again. Where the way has not `begun` limits are the vehicle's own, from zero thrust. Sizes
 * of a facet add up to 1, so that no margin is less than the least room, `inner`: most facets are seen to be too far. */
static tb_real share_of(const struct tb_allocator *a, const tb_real step[TB_K_MAX], const tb_real room[3 * TB_N_MAX],
                        tb_real inner, int begun, tb_real tiny, tb_real keep)
{
    const tb_real s0 = step[0], s1 = tb_entry(step, a->k, 1), s2 = tb_entry(step, a->k, 2);
    const tb_real s3 = tb_entry(step, a->k, 3), s4 = tb_entry(step, a->k, 4), s5 = tb_entry(step, a->k, 5);
    const tb_real nothing = tiny / TB_N_MAX; /* no weight is less than 1 / TB_N_MAX */
    tb_real beta = 1 / keep, near = keep * inner > nothing ? keep * inner : nothing;
    for (int f = 0; f < a->facets; f++) {
        const struct tb_facet *one = &a->facet[f];
        const tb_real along = tb_row(one->normal, s0, s1, s2, s3, s4, s5), size = tb_abs(along);
        if (size <= near) {
            continue;
        }
        tb_real slack = one->margin[along > 0 ? 0 : 1];
        if (begun) {
            const tb_real *side = along > 0 ? room : room + TB_N_MAX;
            const int end = one->end;
            slack = 0;
            for (int e = f > 0 ? a->facet[f - 1].end : 0; e < end; e++) {
                slack += a->along[e] * side[a->of[e]];
            }
        }
        const tb_real left = slack > 0 ? slack : TB_R(0);
        if (left < beta * size && size > keep * left + tiny * one->weight) {
            beta = left / size;
            near = beta > 0 ? inner / beta : TB_LARGEST;
            near = near > nothing ? near : nothing;
        }
    }
    const tb_real taken = keep * beta;
    return taken < 1 - TB_EDGE ? taken : TB_R(1);
}

/* The share of a step that some thruster's limits, `low` and `high` from where it is, may stop: 1 of one that is rounding. */
static tb_real reached(const struct tb_allocator *a, const tb_real step[TB_K_MAX], const tb_real low[TB_N_MAX],
                       const tb_real high[TB_N_MAX], int begun, tb_real least, tb_real keep)
{
    tb_real room[3 * TB_N_MAX], size = 0, inner = begun ? TB_LARGEST : a->inner;
    for (int r = 0; r < a->k; r++) {
        size = tb_abs(step[r]) * a->unit[r] > size ? tb_abs(step[r]) * a->unit[r] : size;
    }
    if (!(size > TB_PARALLEL * least)) {
        return 1;
    }
    for (int p = 0; p < a->m && begun; p++) {
        const tb_real ahead = high[p], astern = -low[p], less = ahead < astern ? ahead : astern;
        room[p] = room[p + 2 * TB_N_MAX] = ahead;
        room[p + TB_N_MAX] = astern;
        inner = less < inner ? less : inner;
    }
    return share_of(a, step, room, inner, begun, TB_PARALLEL * (size > least ? size : least), keep);
}

/* Goes level by level: thrusts `way` in all, of which share[l] of each level's, within what f0 (NULL: nothing) leaves. */
static void go(const struct tb_allocator *a, const int *level, int levels, tb_real *missing, const tb_real *f0,
               const struct tb_thrusts *t, int begun, tb_real *way, tb_real *share)
{
    const int known = levels == 1 && f0 == NULL; /* t->x is the step */
    const tb_real *x = t->x;
    tb_real step[TB_K_MAX], own[TB_N_MAX], low[TB_N_MAX], high[TB_N_MAX], least = a->scale;
    for (int p = 0; p < a->m; p++) {
        const tb_real from = f0 == NULL ? TB_R(0) : f0[p];
        low[p] = t->low[p] - from;
        high[p] = t->high[p] - from;
        least = tb_abs(from) > least ? tb_abs(from) : least;
    }
    for (int l = 0; l < levels; l++) {
        const tb_real keep = l + 1 < levels ? KEEP : TB_R(1);
        int fits = 1; /* without help of the null space */
        for (int r = 0; r < a->k; r++) {
            step[r] = levels == 1 || level[r] == l ? missing[r] : TB_R(0);
        }
        for (int r = 0; r < a->k && levels > 1 && a->rank < a->k; r++) {
            step[r] = 0;
            for (int s = 0; s < a->k; s++) {
                step[r] += level[s] == l ? a->step[r][s] * missing[s] : TB_R(0);
            }
        }
        share[l] = 1;
        if (!known) {
            const tb_real s0 = step[0], s1 = tb_entry(step, a->k, 1), s2 = tb_entry(step, a->k, 2);
            const tb_real s3 = tb_entry(step, a->k, 3), s4 = tb_entry(step, a->k, 4), s5 = tb_entry(step, a->k, 5);
            for (int p = 0; p < a->m; p++) {
                own[p] = tb_row(a->G[p], s0, s1, s2, s3, s4, s5);
            }
            x = own;
        }
        for (int p = 0; p < a->m && fits; p++) {
            fits = x[p] <= keep * high[p] && x[p] >= keep * low[p];
        }
        if (!fits) {
            share[l] = reached(a, step, low, high, begun || l > 0, least, keep);
        }
        for (int p = 0; p < a->m; p++) {
            const tb_real by = share[l] * x[p];
            way[p] = l ? way[p] + by : by;
            low[p] -= by;
            high[p] -= by;
        }
        for (int r = 0; r < a->k && l + 1 < levels && a->rank < a->k; r++) { /* else it is some other level's alone */
            missing[r] -= share[l] * step[r];
        }
    }
}

/* Thrusts for a part of a way. */
static void along(const struct tb_allocator *a, const tb_real *base, tb_real part, const tb_real *way,
                  struct tb_thrusts *t)
{
    for (int p = 0; p < a->m; p++) {
        t->x[p] = base == NULL ? part * way[p] : base[p] + part * way[p];
    }
}

/* The answer of a way through levels; level[j] is that of axis j. */
static int towards(const struct tb_allocator *a, const int *level, int levels, const tb_real *tau,
                   const tb_real *f_min, const tb_real *f_max, tb_real *f, tb_real *share)
{
    static const tb_real back[] = {1, TB_R(1 - 1e-6), TB_R(1 - 1e-3), TB_R(0.9), TB_R(0.5)};
    struct tb_thrusts t;
    tb_real missing[TB_K_MAX], part[TB_K_MAX], f0[TB_N_MAX], way[TB_N_MAX], base[TB_N_MAX];
    int inside = 1, rests = 1, whole = 1, found = 0, crossing = 0, finite = 1;
    const int status = tb_enter(a, tau, f_min, f_max, &t);
    if (status == TB_SOLVED && a->facets < 0) {
        return TB_BAD_ARGUMENT;
    }
    for (int r = 0; r < a->k && status == TB_SOLVED; r++) {
        missing[r] = tau[r];
        finite &= tb_abs(missing[r]) <= TB_LARGEST;
    }
    if (status != TB_SOLVED || !finite) {
        return tb_refused(a, tau, status);
    }
    for (int p = 0; p < a->m; p++) {
        const tb_real low = t.low[p], high = t.high[p];
        inside &= t.x[p] >= low && t.x[p] <= high;
        rests &= low <= 0 && high >= 0;
    }
    if (inside && levels == 1 && a->rank == a->k) { /* T* tau, the best of all that make tau */
        share[0] = 1;
        tb_move_inside(a, &t);
        tb_leave(a, &t, f);
        return tb_meets(a, tau, &t, 0) ? TB_SOLVED : TB_PARTIAL;
    }
    for (int p = 0; p < a->m && !rests; p++) {
        base[p] = 0;
        f0[p] = t.low[p] <= 0 && t.high[p] >= 0 ? TB_R(0) : start(t.low[p], t.high[p]);
        crossing |= !(t.low[p] <= t.high[p]);
    }
    if (crossing) {
        return TB_INFEASIBLE;
    }
    for (int r = 0; r < a->k && !rests; r++) {
        tb_real begun = 0;
        for (int p = 0; p < a->m; p++) {
            begun += a->A[r][a->at[p]] * f0[p];
        }
        missing[r] -= begun / a->unit[r];
        for (int p = 0; p < a->m; p++) {
            base[p] += a->G[p][r] * (begun / a->unit[r]);
        }
    }
    go(a, level, levels, missing, rests ? NULL : f0, &t, !rests || f_min != NULL || f_max != NULL, way, part);
    /* Where rounding leaves no thrusts for the end of the way, they are those of a part of it. */
    for (int i = 0; i < 5 && !found && (i == 0 || levels == 1 || a->rank == a->k); i++) {
        along(a, rests ? NULL : base, back[i], way, &t);
        found = tb_nearest(a, &t, TB_LARGEST) == TB_SOLVED;
        if (found && !(tb_move_inside(a, &t) <= TB_HELD * a->scale)) {
            along(a, rests ? NULL : base, back[i], way, &t);
            found = tb_again(a, NULL, &t, TB_HELD);
        }
        if (found) {
            for (int l = 0; l < levels; l++) {
                share[l] = back[i] * part[l];
                whole &= share[l] >= 1;
            }
        }
    }
    for (int p = 0; p < a->m && !found; p++) {
        t.x[p] = rests ? TB_R(0) : f0[p];
    }
    for (int l = 0; l < levels && !found; l++) {
        share[l] = 0;
    }
    tb_leave(a, &t, f);
    if (a->gone < a->k - a->rank) { /* of weak directions tau is not met: the way ends elsewhere */
        return found && whole && tb_asks_no_lost(a, tau) ? TB_SOLVED : TB_PARTIAL;
    }
    return found && whole && tb_meets(a, tau, &t, 0) ? TB_SOLVED : TB_PARTIAL;
}

/* f0 + w (f1 - f0) of each part and the one before it, from the one that leaves out most directions; shares alike. */
static int mixed(const struct tb_allocator *a, int levels, const tb_real *tau, const tb_real *f_min,
                 const tb_real *f_max, tb_real *f, tb_real *share)
{
    tb_real sum[TB_N_MAX + TB_K_MAX] = {0}, past[TB_N_MAX + TB_K_MAX] = {0}, one[TB_N_MAX + TB_K_MAX];
    int worst = TB_SOLVED;
    for (int p = a->parts; p >= 0; p--) {
        const tb_real w = p < a->parts ? a[p].w : TB_R(1);
        const int status = towards(a + p, a->level, levels, tau, f_min, f_max, one, one + TB_N_MAX);
        if (status != TB_SOLVED && status != TB_PARTIAL) {
            return status;
        }
        worst = status > worst ? status : worst;
        for (int i = 0; i < TB_N_MAX + levels; i++) {
            if (i < a->n || i >= TB_N_MAX) {
                sum[i] += w * (one[i] - past[i]);
                past[i] = one[i];
            }
        }
    }
    for (int i = 0; i < a->n; i++) { /* rounding may lead out of limits that all parts keep */
        const tb_real low = f_min == NULL ? a->f_min[i] : f_min[i], high = f_max == NULL ? a->f_max[i] : f_max[i];
        const int on = tb_abs(one[i]) > 0 || tb_abs(sum[i]) > 0;
        f[i] = !on ? TB_R(0) : sum[i] < low ? low : sum[i] > high ? high : sum[i];
    }
    for (int l = 0; l < levels; l++) {
        share[l] = sum[TB_N_MAX + l] < 1 ? sum[TB_N_MAX + l] : TB_R(1);
    }
    return worst;
}

int tb_scaled(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max, tb_real *f,
              tb_real *share)
{
    return a->parts > 0 ? mixed(a, 1, tau, f_min, f_max, f, share)
                        : towards(a, a->level, 1, tau, f_min, f_max, f, share);
}

int tb_priority(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                tb_real *f, tb_real *share)
{
    return a->parts > 0 ? mixed(a, a->levels, tau, f_min, f_max, f, share)
                        : towards(a, a->level, a->levels, tau, f_min, f_max, f, share);
}
