/* libthrustbench: thrust allocation for a matrix that is known at run time.
 *
 * tb_prepare makes an allocator of a vehicle, once, at boot; tb_without of the same vehicle when thrusters fail. The
 * other functions answer a wanted wrench tau at the control rate. No heap, no static data, no recursion, no library;
 * every loop has a bound that k, n and the dimension of the null space d = n - rank give. Two macros, the same for all
 * files, bound the sizes: TB_N_MAX thrusters, TB_K_MAX axes. TB_FLOAT makes all numbers single precision.
 * C99 and later, C++11 and later; not for -ffast-math.
 */
#ifndef LIBTHRUSTBENCH_H
#define LIBTHRUSTBENCH_H

#if TB_K_MAX < 1 || TB_K_MAX > 6 || TB_N_MAX < TB_K_MAX || TB_N_MAX < 2 || TB_N_MAX > 32
#error "TB_K_MAX is 1 to 6, TB_N_MAX 2 to 32 and no less than TB_K_MAX."
#endif

#include <float.h>

#ifdef TB_FLOAT
typedef float tb_real;
#if defined FLT_MANT_DIG && FLT_MANT_DIG < 24
#error "A float of this compiler has fewer than 24 bits."
#endif
#else
typedef double tb_real;
#if defined DBL_MANT_DIG && DBL_MANT_DIG < 53
#error "A double of this compiler has fewer than 53 bits; define TB_FLOAT for all files."
#endif
#endif

#ifndef THRUSTBENCH_STATUSES
#define THRUSTBENCH_STATUSES
enum {
    TB_SOLVED = 0,
    TB_PARTIAL = 1,
    TB_INFEASIBLE = 2,
    TB_NOT_CONVERGED = 3, /* no thrusts that keep what a status promises were found; f is left alone */
    TB_NO_SUCH_FAULT = -1,
    TB_NOT_FINITE = -2
};
#endif
enum {
    TB_BAD_ARGUMENT = -3,   /* a size, a weight, a readiness or a limit that no vehicle has; or nothing is prepared */
    TB_NEARLY_SINGULAR = -4 /* T nearly loses rank: rounding alone would miss wrenches */
};

/* Most facets of what thrusters can do, and what is stored of them; tb_scaled and tb_priority need them. */
#define TB_CHOOSE(n, j)                                                                                         \
    ((j) == 0   ? 1                                                                                             \
     : (j) == 1 ? (n)                                                                                           \
     : (j) == 2 ? (n) * ((n)-1) / 2                                                                             \
     : (j) == 3 ? (n) * ((n)-1) * ((n)-2) / 6                                                                   \
     : (j) == 4 ? (n) * ((n)-1) * ((n)-2) / 6 * ((n)-3) / 4                                                     \
                : (n) * ((n)-1) * ((n)-2) / 6 * ((n)-3) / 4 * ((n)-4) / 5)
#define TB_LESS(a, b) ((a) < (b) ? (a) : (b))
#ifndef TB_FACETS_MAX
#define TB_FACETS_MAX TB_CHOOSE(TB_N_MAX, TB_LESS(TB_K_MAX - 1, TB_N_MAX / 2))
#endif
#ifndef TB_ENTRIES_MAX
#define TB_ENTRIES_MAX (TB_N_MAX * TB_CHOOSE(TB_N_MAX - 1, TB_LESS(TB_K_MAX - 1, (TB_N_MAX - 1) / 2)))
#endif

/* A facet, as a call reads it: how far a wrench goes along it, in units in which its entries' sizes add up to 1; limits
 * ahead and astern, from zero thrust; 1 over that sum where the largest size is 1; and where its entries end. */
struct tb_facet {
    tb_real normal[TB_K_MAX], margin[2], weight;
    int end;
};

/* A vehicle as the calls need it. Made by tb_prepare; nothing in it is for its user. */
struct tb_allocator {
    int k, n, m, rank, blocks, facets; /* m thrusters work; facets is negative where they are too many */
    int levels, level[TB_K_MAX];       /* of priority: which level each axis belongs to */
    int crossed;                       /* whether H has entries beside its diagonal */
    tb_real scale, slack, exact;       /* largest limit; excess that counts as met; thrusts that rounding leaves exact */
    tb_real unit[TB_K_MAX];            /* 1 / length of a row of T */
    tb_real A[TB_K_MAX][TB_N_MAX];     /* T P, rows of unit length */
    tb_real H[TB_N_MAX][TB_N_MAX], readiness[TB_N_MAX], f_min[TB_N_MAX], f_max[TB_N_MAX];
    int at[TB_N_MAX]; /* thrusters that work, block by block, then those that no z moves */
    int begin[TB_N_MAX + 1], astern[TB_N_MAX], d[TB_N_MAX]; /* of each block; of one dimension those that it moves astern */
    tb_real G[TB_N_MAX][TB_K_MAX], N[TB_N_MAX][TB_N_MAX]; /* rows in the order of `at` */
    tb_real per[TB_N_MAX]; /* 1 / N of a block of one dimension, 1 / |N|^2 of a row of others */
    tb_real pushed[TB_K_MAX][TB_K_MAX], lost[TB_K_MAX][TB_K_MAX], step[TB_K_MAX][TB_K_MAX];
    struct tb_facet facet[TB_FACETS_MAX]; /* entries: thrusters, TB_N_MAX more where turned round, and the size of each */
    unsigned char of[TB_ENTRIES_MAX];
    tb_real along[TB_ENTRIES_MAX];
    tb_real inner; /* least of the vehicle's limits: no margin is less */
    int gone; /* directions that a demand must not ask for: rows of `lost`, none of them weak */
    int parts; /* allocators behind this one in its array, each of one direction less: tb_strong */
    tb_real w; /* share to which the next one's direction counts */
};

#ifdef __cplusplus
extern "C" {
#endif

/* Prepares an allocator. Returns TB_SOLVED, TB_BAD_ARGUMENT or TB_NEARLY_SINGULAR; then calls answer TB_BAD_ARGUMENT.
 *
 * T          k rows of n, row by row: thrusts to wrench; a row shorter than 1e-9 of the longest (with TB_FLOAT 1e-5)
 *            counts as pushed by nothing: choose units in which it is longer
 * H          n rows of n, the effort f'Hf that is least, symmetric positive definite; NULL: all thrusters alike
 * readiness  1 ready, 0 off, between them weakened, n; NULL: all ready
 * f_min, f_max  the vehicle's limits [N], n each
 */
int tb_prepare(struct tb_allocator *a, int k, int n, const tb_real *T, const tb_real *H, const tb_real *readiness,
               const tb_real *f_min, const tb_real *f_max);

/* The same vehicle with the thrusters off whose bits are set in `mask` (1UL << i, i from 0 to n - 1), beside those that
 * tb_prepare was told are off; 0 brings all others back. Returns and is bounded as tb_prepare, or TB_NO_SUCH_FAULT for
 * a bit of no thruster; then too calls answer TB_BAD_ARGUMENT. It knows no survey: a direction counts wholly, as by a
 * file's `weak: 0`, or not at all where no thruster pushes it. To change vehicles under a running loop, copy, change the
 * copy, and swap pointers. */
int tb_without(struct tb_allocator *a, unsigned long mask);

/* How well a vehicle's geometry is known. A direction is weak where thrusters do no more along it than twice what errors
 * of this size make of nothing (rms): less than the vehicle's drawing and its survey differ by.
 *
 * T          as tb_prepare got it
 * poses      all six rows of T, n each, in the order of `axis`, where T has some of them only; NULL: T is all that is known
 * axis       of each row of T: 0 surge, 1 sway, 2 heave, 3 roll, 4 pitch, 5 yaw
 * mm, deg    tolerance of positions along each axis and of directions about each; a tape measure's: 3 and 0.3
 * relative   tolerance of T's entries, a share of the largest of their row, in place of mm and deg; 0: those. Of columns
 *            that are no thrust along a line it is 0.01 then
 * weak       share of the strongest direction up to which one is weak, in place of all these, up to 0.5; 0: these decide
 * room       number of allocators that stand behind the one to prepare in its array, k - 1 at most
 */
struct tb_survey {
    const tb_real *T, *poses;
    const int *axis;
    tb_real mm, deg, relative, weak;
    int room;
};

/* tb_without for a vehicle with a survey: leaves weak directions out of every demand. Call it once behind tb_prepare,
 * with a mask of 0, then at each failure in place of tb_without; NULL is tb_without. Behind a call that left a
 * direction out, tb_without and NULL can't bring it back, and calls then say TB_SOLVED of demands along that direction:
 * tb_prepare first. All calls answer for what is strong, tb_nullspace too, and say TB_SOLVED where that is made. From
 * twice its error to four times a direction counts by a share w from 0 to 1 in tb_scaled and tb_priority, so that
 * nothing steps: their answer is f0 + w (f1 - f0), of an allocator without the direction and of this one, TB_SOLVED
 * where both are. Each such direction takes one of the `room` allocators and the time of one more call, the least one
 * first; beyond the room, and in other calls, it counts wholly from twice its error on, and answers step there. Copy
 * and swap all of the array.
 * Returns and is bounded as tb_prepare, once for each allocator; TB_BAD_ARGUMENT for a survey that is none, and for
 * one that could make all of the whole vehicle of nothing. */
int tb_strong(struct tb_allocator *a, unsigned long mask, const struct tb_survey *survey);

/* Levels for tb_priority: level[j] of axis j counts from 0, and no number is left out; else TB_BAD_ARGUMENT, and
 * nothing changes. tb_prepare puts all in one. */
int tb_levels(struct tb_allocator *a, const int *level);

/* The calls: tau (k) [N, N m]; f_min, f_max (n) the limits of this call [N], NULL: the vehicle's; f (n) [N].
 *
 *   TB_SOLVED         f makes tau, inside the limits
 *   TB_PARTIAL        f lies inside the limits and makes a part of tau (not tb_nullspace); share says how much, of each
 *                     level, and leaves out what no working thruster pushes
 *   TB_INFEASIBLE     no f inside the limits makes tau (tb_nullspace), or limits cross; f is left alone
 *   TB_NOT_CONVERGED  see above (tb_nullspace)
 *   TB_NOT_FINITE     tau or a limit is NaN, infinite, or too large to add up; f is left alone
 *   TB_BAD_ARGUMENT   nothing is prepared, or there are more facets than room (tb_scaled, tb_priority)
 */
int tb_nullspace(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                 tb_real *f);
int tb_scaled(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max, tb_real *f,
              tb_real *share);
int tb_priority(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                tb_real *f, tb_real *share);
int tb_clip(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max, tb_real *f);
int tb_redistribute(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                    tb_real *f);

#ifdef __cplusplus
}
#endif

#endif
