/* The facets of what thrusters can do, as sums over few of them.
 *
 * A normal c of a facet gives y = T'c with N'y = 0, zero for as many thrusters as can be: in a block of dimension d it
 * has d + 1 entries, and of a thruster that no z moves it is that thruster alone. A step with thrusts x stays inside as
 * long as its share of y'x is no more than y'(limits - f0).
 */
#include "tb_internal.h"

/* y (d + 1) with y'N = 0 over the chosen rows, its largest entry 1; 0 where more than one y does that. `unit` is 1 over
 * the length of each row of N. */
static int normal(const struct tb_allocator *a, int d, const int rows[TB_N_MAX], const tb_real unit[TB_N_MAX],
                  tb_real y[TB_N_MAX])
{
    tb_real M[TB_N_MAX][TB_N_MAX], most = 0; /* a column a row of N; the columns of pivots come first */
    int at[TB_N_MAX];
    for (int i = 0; i < TB_N_MAX; i++) {
        at[i] = i;
    }
    for (int i = 0; i <= d; i++) {
        for (int j = 0; j < d; j++) {
            M[j][i] = a->N[rows[i]][j] * unit[rows[i]];
        }
    }
    for (int j = 0; j < d; j++) {
        int row = j, column = j;
        tb_real pivot = 0;
        for (int r = j; r < d; r++) {
            for (int i = j; i <= d; i++) {
                if (tb_abs(M[r][i]) > tb_abs(pivot)) {
                    pivot = M[r][i];
                    row = r;
                    column = i;
                }
            }
        }
        if (!(tb_abs(pivot) > TB_FLAT)) {
            return 0;
        }
        const int chosen = at[column];
        at[column] = at[j];
        at[j] = chosen;
        for (int r = 0; r < d; r++) {
            const tb_real swapped = M[r][column];
            M[r][column] = M[r][j];
            M[r][j] = swapped;
        }
        for (int i = j; i <= d; i++) {
            const tb_real swapped = M[row][i] / pivot;
            M[row][i] = M[j][i];
            M[j][i] = swapped;
        }
        for (int r = 0; r < d; r++) {
            const tb_real share = M[r][j];
            for (int i = j + 1; i <= d && r != j; i++) {
                M[r][i] -= share * M[j][i];
            }
        }
    }
    y[at[d]] = unit[rows[at[d]]];
    for (int j = 0; j < d; j++) {
        const tb_real entry = -M[j][d];
        y[at[j]] = tb_abs(entry) > TB_FLAT ? entry * unit[rows[at[j]]] : TB_R(0);
    }
    for (int i = 0; i <= d; i++) {
        most = tb_abs(y[i]) > most ? tb_abs(y[i]) : most;
    }
    for (int i = 0; i <= d; i++) {
        y[i] /= most;
    }
    return 1;
}

/* Adds an entry to the last facet; returns 0 where there is no room. */
static int enter(struct tb_allocator *a, int *entries, int p, tb_real y, tb_real along)
{
    if (*entries >= TB_ENTRIES_MAX) {
        return 0;
    }
    a->of[*entries] = (unsigned char)(y > 0 ? p : p + TB_N_MAX);
    a->along[(*entries)++] = along;
    return 1;
}

#ifndef TB_FLOAT
/* Adds thrusters of which N or y leaves out what they push across the facet, c'T with c = G'y, as far as `doubt` knows
 * that. Their sizes are negative until all facets are found: they tell none from another. */
static int hardly(struct tb_allocator *a, int *entries, int count, const int *rows, const tb_real *y, tb_real doubt)
{
    tb_real c[TB_K_MAX];
    int good = 1;
    for (int r = 0; r < a->k; r++) {
        c[r] = 0;
        for (int i = 0; i < count; i++) {
            c[r] += y[i] * a->G[rows[i]][r];
        }
        c[r] /= a->unit[r];
    }
    for (int p = 0; p < a->m && good; p++) {
        tb_real push = 0;
        for (int r = 0; r < a->k; r++) {
            push += a->A[r][a->at[p]] * c[r];
        }
        for (int i = 0; i < count; i++) {
            push = rows[i] == p && y[i] != 0 ? TB_R(0) : push;
        }
        good = !(tb_abs(push) > doubt) || enter(a, entries, p, push, -tb_abs(push));
    }
    return good;
}
#endif

/* Adds a facet unless there is one over the same thrusters; returns 0 where there is no room. */
static int add(struct tb_allocator *a, int *entries, int first, int count, const int *rows, const tb_real *y,
               tb_real doubt)
{
    int size = 0;
    for (int i = 0; i < count; i++) {
        size += y[i] != 0;
    }
    /* Each choice of rows comes once, so that only where y is zero for one another choice may have led here. */
    for (int f = first; f < a->facets && size < count; f++) {
        const int end = a->facet[f].end;
        int at = f ? a->facet[f - 1].end : 0, same = end - at >= size;
        for (int i = 0; i < count && same; i++) {
            same = y[i] == 0 || (at < end && a->along[at] > 0 && a->of[at++] % TB_N_MAX == rows[i]);
        }
        if (same && !(at < end && a->along[at] > 0)) {
            return 1;
        }
    }
    if (a->facets >= TB_FACETS_MAX) {
        return 0;
    }
    int good = 1;
    for (int i = 0; i < count && good; i++) {
        good = y[i] == 0 || enter(a, entries, rows[i], y[i], tb_abs(y[i]));
    }
#ifndef TB_FLOAT
    good = good && hardly(a, entries, count, rows, y, doubt);
#else
    (void)doubt; /* what N and y leave out in single precision is rounding */
#endif
    a->facet[a->facets++].end = *entries;
    return good;
}

/* Rows one after another from place i on; the clamp is never needed, and keeps every one a row of N. */
static void count_on(int *rows, int i, int count, int row)
{
    for (; i < count; i++, row++) {
        rows[i] = row < TB_N_MAX ? row : TB_N_MAX - 1;
    }
}

/* Takes the next choice of `count` rows in front of `end`; 0 after the last. */
static int next(int *rows, int count, int end)
{
    for (int i = count - 1; i >= 0; i--) {
        if (rows[i] < end - count + i) {
            count_on(rows, i, count, rows[i] + 1);
            return 1;
        }
    }
    return 0;
}

/* Sizes of each facet that add up to 1, its normal, and its margins within the vehicle's limits. */
static void measure_facets(struct tb_allocator *a)
{
    a->inner = TB_LARGEST;
    for (int p = 0; p < a->m; p++) {
        const tb_real low = -a->f_min[a->at[p]], high = a->f_max[a->at[p]], least = low < high ? low : high;
        a->inner = least < a->inner ? least : a->inner;
    }
    for (int f = 0, begin = 0; f < a->facets; f++) {
        const int end = a->facet[f].end;
        tb_real sum = 0;
        for (int e = begin; e < end; e++) {
            sum += tb_abs(a->along[e]);
        }
        a->facet[f].weight = 1 / sum;
        a->facet[f].margin[0] = a->facet[f].margin[1] = 0;
        for (int r = 0; r < TB_K_MAX; r++) {
            a->facet[f].normal[r] = 0;
        }
        for (int e = begin; e < end; e++) {
            const int p = a->of[e] % TB_N_MAX, turned = a->of[e] >= TB_N_MAX, i = a->at[p];
            const tb_real size = a->along[e] = tb_abs(a->along[e]) * a->facet[f].weight;
            a->facet[f].margin[turned] += size * a->f_max[i];
            a->facet[f].margin[!turned] -= size * a->f_min[i];
            for (int r = 0; r < TB_K_MAX; r++) {
                a->facet[f].normal[r] += (turned ? -size : size) * a->G[p][r];
            }
        }
        begin = end;
    }
}

void tb_find_facets(struct tb_allocator *a, tb_real doubt)
{
    int rows[TB_N_MAX] = {0}, entries = 0, good = 1;
    tb_real y[TB_N_MAX], unit[TB_N_MAX];
    a->facets = 0;
    for (int b = 0; b < a->blocks && good; b++) {
        const int count = a->d[b] + 1, first = a->facets;
        int more = 1;
        if (count > TB_N_MAX || a->begin[b] + count > a->begin[b + 1]) {
            continue;
        }
        for (int p = a->begin[b]; p < a->begin[b + 1]; p++) {
            unit[p] = 1 / tb_root(tb_product(a->N[p], a->N[p], a->d[b]));
        }
        count_on(rows, 0, count, a->begin[b]);
        while (more && good) {
            good = !normal(a, count - 1, rows, unit, y) || add(a, &entries, first, count, rows, y, doubt);
            more = next(rows, count, a->begin[b + 1]);
        }
    }
    for (int p = a->begin[a->blocks]; p < a->m && good; p++) {
        y[0] = 1;
        rows[0] = p;
        good = add(a, &entries, a->facets, 1, rows, y, doubt);
    }
    measure_facets(a);
    a->facets = good ? a->facets : -1;
}
