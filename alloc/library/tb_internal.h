/* What the files of libthrustbench share; not for its users. */
#ifndef TB_INTERNAL_H
#define TB_INTERNAL_H

#include "libthrustbench.h"
#include <stddef.h>

#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "Compile this file without -ffast-math and -Ofast: NaN would pass unseen."
#endif

#define TB_R(x) ((tb_real)(x))
/* Rounding; what counts as zero in a basis and as a lost direction; excess over a limit that counts as met, what a
 * SOLVED wrench may miss, moves onto limits that need no other look, a miss that nobody makes smaller, how near to an
 * edge a demand lies on it (shares of the largest limit), how much farther than its facet a step leads that runs in it,
 * and the pivot at which columns of unit length depend on each other. What rounding takes of a thrust is TB_DOUBT
 * roundings times the condition of T, for each thruster where TB_EACH says so; more than TB_LARGEST_DOUBT is refused
 * (alloc.vehicle.condition, alloc.kernels.tolerance). */
#ifdef TB_FLOAT
#define TB_EPS TB_R(1.2e-7)
#define TB_ZERO TB_R(2e-6)
#define TB_RANK TB_R(1e-5)
#define TB_TOLERANCE TB_R(4e-6)
#define TB_MET TB_R(1e-5)
#define TB_HELD TB_R(4e-6)
#define TB_BEST TB_R(1e-6)
#define TB_EDGE TB_R(4e-6)
#define TB_PARALLEL TB_R(2e-6)
#define TB_FLAT TB_R(2e-6)
#define TB_LARGEST TB_R(1e30)
#define TB_DOUBT TB_R(1)
#define TB_EACH(n) TB_R(1)
#define TB_LARGEST_DOUBT (2 * TB_MET)
#else
#define TB_EPS TB_R(2.3e-16)
#define TB_ZERO TB_R(1e-12)
#define TB_RANK TB_R(1e-9)
#define TB_TOLERANCE TB_R(1e-9)
#define TB_MET TB_R(1e-6)
#define TB_HELD TB_R(5e-10)
#define TB_BEST TB_R(5e-12)
#define TB_EDGE TB_R(1e-10)
#define TB_PARALLEL TB_R(1e-10)
#define TB_FLAT TB_R(1e-13)
#define TB_LARGEST TB_R(1e100)
#define TB_DOUBT TB_R(8)
#define TB_EACH(n) TB_R(n)
#define TB_LARGEST_DOUBT (TB_MET / 4)
#endif

/* Thrusts of one call, in the order of `at`. */
struct tb_thrusts {
    tb_real x[TB_N_MAX], low[TB_N_MAX], high[TB_N_MAX], size; /* the sum of |x| once inside */
};

static inline tb_real tb_abs(tb_real x)
{
#if defined __GNUC__ && defined TB_FLOAT
    return __builtin_fabsf(x);
#elif defined __GNUC__
    return __builtin_fabs(x);
#else
    return x < 0 ? -x : x;
#endif
}

static inline tb_real tb_product(const tb_real *a, const tb_real *b, int n)
{
    tb_real sum = 0;
    for (int i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Entry r of a wrench, and 0 behind its last. */
static inline tb_real tb_entry(const tb_real *tau, int k, int r)
{
    return r < k ? tau[r] : TB_R(0);
}

/* A row of G, filled up with zeros, times a wrench: without a loop, which would cost more than the products. */
static inline tb_real tb_row(const tb_real *g, tb_real t0, tb_real t1, tb_real t2, tb_real t3, tb_real t4, tb_real t5)
{
    tb_real sum = g[0] * t0;
    sum += TB_K_MAX > 1 ? g[1] * t1 : TB_R(0);
    sum += TB_K_MAX > 2 ? g[2] * t2 : TB_R(0);
    sum += TB_K_MAX > 3 ? g[3] * t3 : TB_R(0);
    sum += TB_K_MAX > 4 ? g[4] * t4 : TB_R(0);
    sum += TB_K_MAX > 5 ? g[5] * t5 : TB_R(0);
    return sum;
}

static inline int tb_is_finite(const tb_real *x, int n)
{
    int good = 1;
    for (int i = 0; i < n; i++) {
        good &= tb_abs(x[i]) <= TB_LARGEST;
    }
    return good;
}

#ifdef __cplusplus
extern "C" {
#endif

/* tb_factor.c */
tb_real tb_root(tb_real x);
void tb_orthogonal(int k, int m, tb_real W[TB_K_MAX][TB_N_MAX], tb_real U[TB_K_MAX][TB_K_MAX]);
int tb_null_basis(int rank, int m, tb_real V[TB_K_MAX][TB_N_MAX], tb_real N[TB_N_MAX][TB_N_MAX]);
void tb_shared(const struct tb_allocator *a, tb_real rest[TB_K_MAX], const int on[TB_N_MAX], tb_real x[TB_N_MAX]);
/* tb_facets.c */
void tb_find_facets(struct tb_allocator *a, tb_real doubt);
/* tb_levels.c */
void tb_find_steps(struct tb_allocator *a);
/* tb_exact.c */
int tb_enter(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
             struct tb_thrusts *t);
int tb_nearest(const struct tb_allocator *a, struct tb_thrusts *t, tb_real slack);
tb_real tb_move_inside(const struct tb_allocator *a, struct tb_thrusts *t);
int tb_asks_no_lost(const struct tb_allocator *a, const tb_real *tau);
int tb_meets(const struct tb_allocator *a, const tb_real *tau, const struct tb_thrusts *t, tb_real moved);
int tb_again(const struct tb_allocator *a, const tb_real *tau, struct tb_thrusts *t, tb_real miss);
int tb_refused(const struct tb_allocator *a, const tb_real *tau, int status);
void tb_leave(const struct tb_allocator *a, const struct tb_thrusts *t, tb_real *f);

#ifdef __cplusplus
}
#endif

#endif
