/* Calls somebody's allocator with copies in a room of its own, and looks at what it leaves behind.
 *
 * Between the arrays of a call lie walls of a known number. An allocator that wrote into one, or left the processor in
 * another rounding mode, ends the process with a line that names it: no answer that comes later could be trusted.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdint.h>
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

enum { TAU, F_MIN, F_MAX, F, SHARE, STATUS, ARRAYS };
static const char *const names[ARRAYS] = {"tau", "f_min", "f_max", "f", "share", "status"};
static const tba_real wall[WALL] = {STONES};
enum { WORDS = sizeof wall / sizeof(uint64_t) };

struct context {
    int (*call)(void *allocator, const struct tba_input *input, struct tba_output *output);
    void (*many)(void *allocator, int count, const struct tba_input *input, struct tba_output *output, int *status);
    void *allocator;
    void (*reset)(void *allocator); /* before each call; NULL for none */
    const char *name;
    int k, n, shares;
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
static void fill(tba_real *const array[], int k, int n, int count, const double *tau, const double *f_min,
                 const double *f_max, long step)
{
    for (int j = 0; j < count * k; j++) {
        array[TAU][j] = (tba_real)tau[j];
    }
    for (int i = 0; i < count * n; i++) {
        array[F][i] = (tba_real)NAN; /* an answer that is not written is none, not the last one */
    }
    for (int b = 0; f_min != NULL && b < count; b++) {
        for (int i = 0; i < n; i++) {
            array[F_MIN][b * n + i] = inward(f_min[b * step + i], 0);
            array[F_MAX][b * n + i] = inward(f_max[b * step + i], 1);
        }
    }
}

/* Ends the process where a call left something behind; else reads `count` answers. */
static void look(const struct context *c, tba_real *const array[], int count, double *f)
{
    uint64_t stones[WORDS], found[WORDS], broken = 0;
    memcpy(stones, wall, sizeof wall);
    for (int i = 0; i <= ARRAYS; i++) {
        memcpy(found, array[i] - WALL, sizeof wall);
        for (int s = 0; s < WORDS; s++) {
            broken |= found[s] ^ stones[s];
        }
    }
    for (int i = 0; broken && i <= ARRAYS; i++) {
        if (memcmp(array[i] - WALL, wall, sizeof wall) != 0) {
            end(c, i == 0 ? "wrote before " : "wrote beyond ", names[i == 0 ? TAU : i - 1]);
        }
    }
    const volatile double one = 1.0, more = 0.75 * DBL_EPSILON, less = 0.25 * DBL_EPSILON;
    if (one + more != 1.0 + DBL_EPSILON || one + less != 1.0) {
        end(c, "left the processor in another rounding mode", "");
    }
    for (int i = 0; i < count * c->n; i++) {
        f[i] = array[F][i];
    }
}

static int known(int status)
{
    return status >= 0 && status <= TBA_NOT_CONVERGED ? status : TBA_NOT_CONVERGED;
}

int foreign_call(const struct context *c, const double *tau, const double *f_min, const double *f_max, double *f,
                 double *share)
{
    tba_real *const *const array = c->one;
    const int limited = f_min != NULL;
    fill(array, c->k, c->n, 1, tau, f_min, f_max, 0);
    const struct tba_input input = {sizeof input, array[TAU], limited ? array[F_MIN] : NULL,
                                    limited ? array[F_MAX] : NULL};
    struct tba_output output = {sizeof output, array[F], c->shares ? array[SHARE] : NULL};
    if (c->reset != NULL) {
        c->reset(c->allocator);
    }
    const int status = c->call(c->allocator, &input, &output);
    look(c, array, 1, f);
    for (int i = 0; i < c->shares; i++) {
        share[i] = array[SHARE][i];
    }
    return known(status);
}

/* COUNT calls by tba_many. Nobody reads their shares. */
void foreign_many(const struct context *c, const double *tau, const double *f_min, const double *f_max, long step,
                  double *f, signed char *status)
{
    tba_real *const *const array = c->several;
    const int limited = f_min != NULL;
    int *said = (int *)array[STATUS];
    fill(array, c->k, c->n, COUNT, tau, f_min, f_max, step);
    for (int b = 0; b < COUNT; b++) {
        said[b] = TBA_NOT_CONVERGED;
    }
    const struct tba_input input = {sizeof input, array[TAU], limited ? array[F_MIN] : NULL,
                                    limited ? array[F_MAX] : NULL};
    struct tba_output output = {sizeof output, array[F], c->shares ? array[SHARE] : NULL};
    c->many(c->allocator, COUNT, &input, &output, said);
    look(c, array, COUNT, f);
    for (int b = 0; b < COUNT; b++) {
        status[b] = (signed char)known(said[b]);
        for (int i = 0; status[b] > TBA_PARTIAL && i < c->n; i++) {
            f[b * c->n + i] = NAN;
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
