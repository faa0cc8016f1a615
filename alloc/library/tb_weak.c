/* Weak directions: those along which a vehicle can do no more than its survey could have made of nothing.
 *
 * With A = D^-1 T P diag(max |f|), D = 1 for forces and the rms arm of all thrusters for moments, a left singular vector
 * u has the authority sigma. Errors dT of the survey's size make epsilon(u), the root mean square of
 * |u' D^-1 dT P diag(max |f|)|, of nothing (alloc.vehicle.weak). From WEAK to twice that a direction counts in part.
 */
#include "tb_internal.h"

#define WEAK TB_R(2)       /* largest sigma / epsilon of a weak direction */
#define RELATIVE TB_R(0.01) /* error of entries of a column that is no thrust along a line, of its row's largest */
#define UNIT TB_R(1e-3)    /* share by which the force of a thrust along a line may differ from the largest */
#define SHORT TB_R(0.24)   /* a row of T shorter than this, of one of the rms, counts as longer */
#define MOST TB_R(0.5)     /* largest share of the strongest direction that may be called weak */
#define RADIANS TB_R(0.017453292519943295)

/* D; the length of a row of the rms, in units of D; the force of a thrust along a line; and the weight P max |f| of each
 * thruster, over the largest limit and 0 where it is off. */
struct sizes {
    tb_real D[TB_K_MAX], rms, unit, weight[TB_N_MAX];
};

static int knows(const struct tb_allocator *a, const struct tb_survey *s)
{
    const tb_real tolerances[4] = {s->mm, s->deg, s->relative, s->weak};
    if (!tb_is_finite(s->T, a->k * a->n) || (s->poses != NULL && !tb_is_finite(s->poses, 6 * a->n)) ||
        !tb_is_finite(tolerances, 4)) {
        return 0;
    }
    for (int r = 0; r < a->k; r++) {
        int known = s->axis[r] >= 0 && s->axis[r] <= 5;
        for (int l = 0; l < r; l++) {
            known &= s->axis[l] != s->axis[r];
        }
        if (!known) {
            return 0;
        }
    }
    return s->room >= 0 && s->mm >= 0 && s->deg >= 0 && s->relative >= 0 && s->weak >= 0 && s->weak <= MOST;
}

/* Entry q of all six that one newton of thruster i makes, as far as they are known. */
static tb_real entry(const struct tb_allocator *a, const struct tb_survey *s, int q, int i)
{
    tb_real found = s->poses != NULL ? s->poses[q * a->n + i] : TB_R(0);
    for (int r = 0; r < a->k && s->poses == NULL; r++) {
        found = s->axis[r] == q ? s->T[r * a->n + i] : found;
    }
    return found;
}

static void measure(const struct tb_allocator *a, const struct tb_survey *s, unsigned long off, struct sizes *z)
{
    int controlled = 0;
    tb_real longest2 = 0, forces = 0, moments = 0, arm, square = 0;
    for (int i = 0; i < a->n; i++) {
        const tb_real low = tb_abs(a->f_min[i]), high = tb_abs(a->f_max[i]), far = low > high ? low : high;
        tb_real force2 = 0;
        for (int q = 0; q < 3; q++) {
            const tb_real force = entry(a, s, q, i), moment = entry(a, s, q + 3, i);
            force2 += force * force;
            moments += moment * moment;
        }
        forces += force2;
        longest2 = force2 > longest2 ? force2 : longest2;
        z->weight[i] = off >> i & 1UL ? TB_R(0) : a->readiness[i] * (far > 0 ? far : a->scale) / a->scale;
    }
    arm = forces > 0 && moments > 0 ? tb_root(moments / forces) : TB_R(1);
    for (int r = 0; r < a->k; r++) {
        z->D[r] = s->axis[r] < 3 ? TB_R(1) : arm;
        square += tb_product(s->T + r * a->n, s->T + r * a->n, a->n) / (z->D[r] * z->D[r]);
        controlled += s->axis[r] < 3;
    }
    z->rms = tb_root(square / 2);
    z->unit = (controlled == 3 || s->poses != NULL) && longest2 > 0 ? tb_root(longest2) : TB_R(1);
}

static void cross(const tb_real a[3], const tb_real b[3], tb_real c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Mean square of c'dT_i. A thrust e at r = e x m, with a moment p e of its own, that is turned by theta and moved by dr
 * changes c = [b; g] times its column by theta'(e x (b + g x r + p g)) + dr'(e x g). */
static tb_real doubt(const struct tb_allocator *a, const struct tb_survey *s, const struct sizes *z,
                     const tb_real c[TB_K_MAX], int i)
{
    const tb_real turn = RADIANS * s->deg, move = TB_R(1e-3) * s->mm;
    const tb_real share = s->relative > 0 ? s->relative : RELATIVE;
    tb_real e[3], m[3], b[3] = {0}, g[3] = {0}, r[3], lever[3], turned[3], moved[3], square = 0;
    for (int q = 0; q < 3; q++) {
        e[q] = entry(a, s, q, i) / z->unit;
        m[q] = entry(a, s, q + 3, i) / z->unit;
    }
    if (!(s->relative > 0) && tb_abs(tb_root(tb_product(e, e, 3)) - 1) <= UNIT) {
        for (int l = 0; l < a->k; l++) {
            for (int q = 0; q < 3; q++) {
                b[q] = s->axis[l] == q ? c[l] : b[q];
                g[q] = s->axis[l] == q + 3 ? c[l] : g[q];
            }
        }
        cross(e, m, r);
        cross(g, r, lever);
        for (int q = 0; q < 3; q++) {
            lever[q] += b[q] + tb_product(e, m, 3) * g[q];
        }
        cross(e, lever, turned);
        cross(e, g, moved);
        square = turn * turn * tb_product(turned, turned, 3) + move * move * tb_product(moved, moved, 3);
        return z->unit * z->unit * square / 3;
    }
    for (int l = 0; l < a->k; l++) {
        tb_real most = 0;
        for (int j = 0; j < a->n; j++) {
            most = tb_abs(s->T[l * a->n + j]) > most ? tb_abs(s->T[l * a->n + j]) : most;
        }
        square += c[l] * share * most * (c[l] * share * most);
    }
    return square / 3;
}

/* Finds the directions u, as rows of U, and the share w to which each counts; negative where no thruster pushes. */
static void mark(const struct tb_allocator *a, const struct tb_survey *s, const struct sizes *z,
                tb_real U[TB_K_MAX][TB_K_MAX], tb_real w[TB_K_MAX])
{
    tb_real W[TB_K_MAX][TB_N_MAX], sigma[TB_K_MAX], c[TB_K_MAX], size = 0, most = 0;
    for (int r = 0; r < a->k; r++) {
        for (int i = 0; i < a->n; i++) {
            W[r][i] = s->T[r * a->n + i] * z->weight[i] / z->D[r];
        }
        size += tb_product(W[r], W[r], a->n);
    }
    size = size > 0 ? tb_root(size) : TB_R(1);
    for (int r = 0; r < a->k; r++) {
        for (int i = 0; i < a->n; i++) {
            W[r][i] /= size;
        }
        for (int l = 0; l < a->k; l++) {
            U[r][l] = TB_R(r == l);
        }
    }
    tb_orthogonal(a->k, a->n, W, U);
    for (int j = 0; j < a->k; j++) {
        sigma[j] = tb_root(tb_product(W[j], W[j], a->n));
        most = sigma[j] > most ? sigma[j] : most;
    }
    for (int j = 0; j < a->k; j++) {
        tb_real epsilon2 = 0;
        for (int r = 0; r < a->k; r++) {
            c[r] = U[j][r] / z->D[r];
        }
        for (int i = 0; i < a->n; i++) {
            const tb_real weight = z->weight[i] / size;
            epsilon2 += weight > 0 ? doubt(a, s, z, c, i) * weight * weight : TB_R(0);
        }
        const tb_real largest = s->weak > 0 ? s->weak * most : WEAK * tb_root(epsilon2);
        const tb_real beyond = sigma[j] - largest;
        w[j] = beyond >= largest ? TB_R(1) : beyond > 0 ? beyond / largest : TB_R(0);
        w[j] = sigma[j] > TB_RANK * most ? w[j] : TB_R(-1);
    }
}

/* Prepares an allocator for what is left without the directions that `out` marks; `few` where some do not count. */
static int leave_out(struct tb_allocator *a, unsigned long mask, const struct tb_survey *s, const struct sizes *z,
                     tb_real U[TB_K_MAX][TB_K_MAX], const int out[TB_K_MAX], const int lost[TB_K_MAX], int few)
{
    tb_real S[TB_K_MAX], longest = 0, largest = 0;
    int status, pushed = 0, gone = 0;
    for (int i = 0; i < a->n; i++) {
        for (int r = 0; r < a->k; r++) {
            const tb_real size = tb_abs(s->T[r * a->n + i]) / z->D[r];
            largest = size > largest ? size : largest;
        }
    }
    for (int j = 0; j < a->k; j++) {
        pushed |= out[j];
    }
    for (int i = 0; i < a->n; i++) {
        for (int r = 0; r < a->k; r++) {
            S[r] = s->T[r * a->n + i] / z->D[r];
        }
        for (int j = 0; j < a->k; j++) {
            const tb_real along = out[j] && z->weight[i] > 0 ? tb_product(U[j], S, a->k) : TB_R(0);
            for (int r = 0; r < a->k; r++) {
                S[r] -= along * U[j][r];
            }
        }
        for (int r = 0; r < a->k; r++) { /* rounding is no thrust */
            const tb_real left = tb_abs(S[r]) > 4 * TB_EPS * largest ? S[r] * z->D[r] : TB_R(0);
            a->A[r][i] = pushed && z->weight[i] > 0 ? left : s->T[r * a->n + i];
        }
    }
    for (int r = 0; r < a->k; r++) {
        a->unit[r] = tb_root(tb_product(a->A[r], a->A[r], a->n));
        longest = a->unit[r] > longest ? a->unit[r] : longest;
    }
    for (int r = 0; r < a->k; r++) {
        const tb_real rms = z->rms * z->D[r];
        const tb_real own = !pushed && !(a->unit[r] > TB_RANK * longest) ? longest : a->unit[r], part = own / rms;
        /* As alloc.vehicle.weak: a shorter row counts as longer, up to the rms, since what it has is a survey's error. */
        const tb_real counts = part < SHORT ? rms * (1 - part * ((1 - SHORT) / SHORT)) : own;
        a->unit[r] = 1 / (few ? counts : own);
        for (int i = 0; i < a->n; i++) {
            a->A[r][i] *= a->readiness[i] * a->unit[r];
        }
    }
    status = tb_without(a, mask);
    for (int j = 0; j < a->k && gone < TB_K_MAX && pushed; j++) {
        tb_real square = 0;
        for (int r = 0; r < a->k && lost[j]; r++) { /* of length 1 where axes count by the lengths of their rows */
            const tb_real c = U[j][r] / z->D[r];
            a->lost[gone][r] = c;
            square += c * c / (a->unit[r] * a->unit[r]);
        }
        for (int r = 0; r < a->k && lost[j]; r++) {
            a->lost[gone][r] /= tb_root(square) * a->scale;
        }
        gone += lost[j] != 0;
    }
    a->gone = pushed ? gone : a->gone;
    return status;
}

/* Leaves an allocator whose calls refuse; returns the status. */
static int refused(struct tb_allocator *a, int status)
{
    a->m = -1;
    a->parts = 0;
    return status;
}

int tb_strong(struct tb_allocator *a, unsigned long mask, const struct tb_survey *s)
{
    struct sizes z;
    tb_real U[TB_K_MAX][TB_K_MAX], w[TB_K_MAX];
    int between[TB_K_MAX] = {0}, out[TB_K_MAX] = {0}, lost[TB_K_MAX] = {0};
    int count = 0, none = 0, whole = mask == 0, status;
    if (s == NULL) {
        return tb_without(a, mask);
    }
    if (a->n < 1 || s->T == NULL || s->axis == NULL || !knows(a, s)) {
        return refused(a, TB_BAD_ARGUMENT);
    }
    measure(a, s, mask, &z);
    mark(a, s, &z, U, w);
    for (int i = 0; i < a->n; i++) {
        whole &= a->readiness[i] >= 1;
    }
    for (int j = 0; j < a->k; j++) {
        none += !(w[j] > 0);
    }
    if (none == a->k && whole) { /* the survey could have made all of nothing */
        return refused(a, TB_BAD_ARGUMENT);
    }
    for (int j = 0; j < a->k; j++) { /* those that count in part, from the least to the most */
        int at = count;
        lost[j] = w[j] < 0;
        out[j] = none < a->k && w[j] >= 0 && !(w[j] > 0);
        if (w[j] > 0 && w[j] < 1) {
            for (; at > 0 && w[between[at - 1]] >= w[j]; at--) {
                between[at] = between[at - 1];
            }
            between[at] = j;
            count++;
        }
    }
    count -= count > 0 && count + none == a->k; /* something must count */
    status = leave_out(a, mask, s, &z, U, out, lost, none > 0 && none < a->k);
    for (int p = 1; p <= s->room && p <= count && status == TB_SOLVED; p++) {
        const int j = between[p - 1];
        a[p] = a[0];
        a[p - 1].w = w[j];
        out[j] = 1;
        status = leave_out(a + p, mask, s, &z, U, out, lost, 1);
        a->parts = p;
    }
    return status == TB_SOLVED ? status : refused(a, status);
}
