/* Calls somebody's allocator, and looks at what it leaves behind.
 *
 * Between the arrays of a call lie walls of a known number, which nobody mends. An allocator that wrote into one, or
 * left the processor in another rounding mode, ends the process with a line that names it: no answer that comes later
 * could be trusted. The first EACH calls are guarded, then one of EACH: all that is given is copied between walls, and
 * these are looked at behind the call, and once more when the allocator ends. Other calls get their caller's arrays as
 * on board, so that what is timed is the allocator. Answers are always written between walls, where NaN stood.
 * Compiled for K axes and N thrusters, as generated C is.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrustbench_allocator.h"

#ifdef TBA_FLOAT
static tba_real inward(double limit, int upper)
{
    const float near = (float)limit;
    const float step = (near < 0.0f ? -near : near) * FLT_EPSILON + FLT_MIN;
    return upper ? ((double)near > limit ? near - step : near) : ((double)near < limit ? near + step : near);
}
#else
static tba_real inward(double limit, int upper)
{
    (void)upper;
    return limit;
}
#endif

#define noinline __attribute__((noinline))
enum { TAU, F_MIN, F_MAX, PREVIOUS, DESIRED, CAP, VOLTS, F, SHARE, RESIDUAL, STATUS, ARRAYS };
static const char *const names[ARRAYS] = {"tau", "f_min", "f_max", "f_previous", "f_desired", "cap",
                                          "volts", "f", "share", "residual", "status"};
static const tba_real wall[WALL] = {STONES};

struct context {
    int (*call)(void *allocator, const struct tba_input *input, struct tba_output *output);
    void (*many)(void *allocator, int count, const struct tba_input *input, struct tba_output *output, int *status);
    void *allocator;
    void (*reset)(void *allocator); /* before each call; NULL for none */
    const char *name;
    int shares;
    unsigned calls, unguarded; /* calls so far with a look, and those to come without */
    /* Arrays of one call, and of COUNT; before each of them lies a wall, and one at the end, which the last names. */
    tba_real *one[ARRAYS + 1], *several[ARRAYS + 1];
};

static void end(const struct context *c, const char *what, const char *where)
{
    fflush(NULL);
    fprintf(stderr, "%s: %s%s; mend it\n", c->name, what, where);
    abort();
}

/* Writes what `count` calls are given; limits of the next call lie `step` further on. */
static noinline void fill(tba_real *const array[], int count, const double *tau, const double *f_min,
                 const double *f_max, long step)
{
    for (int j = 0; j < count * K; j++) {
        array[TAU][j] = (tba_real)tau[j];
    }
    for (int b = 0; f_min != NULL && b < count; b++) {
        for (int i = 0; i < N; i++) {
            array[F_MIN][b * N + i] = inward(f_min[b * step + i], 0);
            array[F_MAX][b * N + i] = inward(f_max[b * step + i], 1);
        }
    }
}

/* An answer that is not written is none, not the last one. */
static inline void blank(const struct context *c, tba_real *const array[], int count)
{
    for (int i = 0; i < count * N; i++) {
        array[F][i] = (tba_real)NAN;
    }
    for (int i = 0; i < count * c->shares; i++) {
        array[SHARE][i] = (tba_real)NAN;
    }
    for (int j = 0; j < count * K; j++) {
        array[RESIDUAL][j] = (tba_real)NAN;
    }
}

/* Ends the process where a call left something behind. */
static noinline void look(const struct context *c, tba_real *const array[])
{
    for (int i = 0; i <= ARRAYS; i++) {
        if (memcmp(array[i] - WALL, wall, sizeof wall) != 0) {
            end(c, i == 0 ? "wrote before " : "wrote beyond ", names[i == 0 ? TAU : i - 1]);
        }
    }
    const volatile double one = 1.0, more = 0.75 * DBL_EPSILON, less = 0.25 * DBL_EPSILON;
    if (one + more != 1.0 + DBL_EPSILON || one + less != 1.0) {
        end(c, "left the processor in another rounding mode", "");
    }
}

/* Looks once more, since what the last calls broke is not seen yet. */
void foreign_end(const struct context *c)
{
    look(c, c->one);
    look(c, c->several);
}

static int known(int status)
{
    return status >= 0 && status <= TBA_NOT_CONVERGED ? status : TBA_NOT_CONVERGED;
}

/* Reads an answer one by one: a vector of numbers that were just stored singly has to wait for all of them. */
static inline int answered(const struct context *c, int status, double *restrict f, double *restrict share)
{
    const volatile tba_real *const made = c->one[F], *const delivered = c->one[SHARE];
    for (int i = 0; i < N; i++) {
        f[i] = made[i];
    }
    for (int i = 0; i < c->shares; i++) {
        share[i] = delivered[i];
    }
    return known(status);
}

/* What a call may have more; NULL where it is not known. */
struct more {
    const double *f_previous, *f_desired, *cap, *volts;
};

static const tba_real *copied(tba_real *into, const double *values, int count)
{
    for (int i = 0; values != NULL && i < count; i++) {
        into[i] = (tba_real)values[i];
    }
    return values != NULL ? into : NULL;
}

/* A call with copies of all that it gets, and a look at what it leaves. */
static noinline int guarded(struct context *c, const double *tau, const double *f_min, const double *f_max,
                            const struct more *more, double *restrict f, double *restrict share)
{
    tba_real *const *const array = c->one;
    const int limited = f_min != NULL;
    fill(array, 1, tau, f_min, f_max, 0);
    blank(c, array, 1);
    const struct tba_input input = {
        sizeof input,
        array[TAU],
        limited ? array[F_MIN] : NULL,
        limited ? array[F_MAX] : NULL,
        copied(array[PREVIOUS], more->f_previous, N),
        copied(array[DESIRED], more->f_desired, N),
        copied(array[CAP], more->cap, 1),
        copied(array[VOLTS], more->volts, 1),
    };
    struct tba_output output = {sizeof output, array[F], c->shares ? array[SHARE] : NULL, array[RESIDUAL]};
    if (c->reset != NULL) {
        c->reset(c->allocator);
    }
    const int status = c->call(c->allocator, &input, &output);
    look(c, array);
    c->calls++;
    c->unguarded = c->calls < EACH ? 0 : EACH;
    return answered(c, status, f, share);
}

static inline int called(struct context *c, const double *tau, const double *f_min, const double *f_max,
                         const struct more *more, double *restrict f, double *restrict share)
{
    if (sizeof(tba_real) != sizeof(double) || c->reset != NULL || c->unguarded == 0) {
        return guarded(c, tau, f_min, f_max, more, f, share);
    }
    c->unguarded--;
    blank(c, c->one, 1);
    const struct tba_input input = {
        sizeof input,
        (const tba_real *)tau,
        (const tba_real *)f_min,
        (const tba_real *)f_max,
        (const tba_real *)more->f_previous,
        (const tba_real *)more->f_desired,
        (const tba_real *)more->cap,
        (const tba_real *)more->volts,
    };
    struct tba_output output = {sizeof output, c->one[F], c->shares ? c->one[SHARE] : NULL, c->one[RESIDUAL]};
    return answered(c, c->call(c->allocator, &input, &output), f, share);
}

int foreign_more(struct context *c, const double *tau, const double *f_min, const double *f_max,
                 const struct more *more, double *restrict f, double *restrict share)
{
    return called(c, tau, f_min, f_max, more, f, share);
}

int foreign_call(struct context *c, const double *tau, const double *f_min, const double *f_max, double *restrict f,
                 double *restrict share)
{
    static const struct more nothing = {NULL, NULL, NULL, NULL};
    return called(c, tau, f_min, f_max, &nothing, f, share);
}

/* COUNT calls by tba_many. Nobody reads their shares. */
void foreign_many(const struct context *c, const double *tau, const double *f_min, const double *f_max, long step,
                  double *f, signed char *status)
{
    tba_real *const *const array = c->several;
    const int limited = f_min != NULL;
    int *said = (int *)array[STATUS];
    fill(array, COUNT, tau, f_min, f_max, step);
    blank(c, array, COUNT);
    for (int b = 0; b < COUNT; b++) {
        said[b] = TBA_NOT_CONVERGED;
    }
    const struct tba_input input = {sizeof input, array[TAU], limited ? array[F_MIN] : NULL,
                                    limited ? array[F_MAX] : NULL, NULL, NULL, NULL, NULL};
    struct tba_output output = {sizeof output, array[F], c->shares ? array[SHARE] : NULL, array[RESIDUAL]};
    c->many(c->allocator, COUNT, &input, &output, said);
    look(c, array);
    for (int i = 0; i < COUNT * N; i++) {
        f[i] = array[F][i];
    }
    for (int b = 0; b < COUNT; b++) {
        status[b] = (signed char)known(said[b]);
        for (int i = 0; status[b] > TBA_PARTIAL && i < N; i++) {
            f[b * N + i] = NAN;
        }
    }
}

/* Stands for an allocator that takes no time: a call of it is the way in. */
int foreign_nothing(void *allocator, const struct tba_input *input, struct tba_output *output)
{
    (void)allocator;
    (void)input;
    (void)output;
    return TBA_SOLVED;
}
