/* Calls somebody's allocator with copies in a room of its own, and looks at what it leaves behind.
 *
 * Between the arrays of a call lie walls of a known number. An allocator that wrote into one, or left the processor in
 * another rounding mode, ends the process with a line that names it: no answer that comes later could be trusted.
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

enum { TAU, F_MIN, F_MAX, F, SHARE, ARRAYS };
static const char *const names[ARRAYS] = {"tau", "f_min", "f_max", "f", "share"};
static const tba_real wall[WALL] = {STONES};

struct context {
    int (*call)(void *allocator, const struct tba_input *input, struct tba_output *output);
    void *allocator;
    void (*reset)(void *allocator); /* before each call; NULL for none */
    const char *name;
    int k, n, shares;
    tba_real *room; /* tau (k), f_min, f_max, f (n each) and the shares, with a wall of WALL stones around each */
};

static void end(const struct context *c, const char *what, const char *where)
{
    fflush(NULL);
    fprintf(stderr, "%s: %s%s; mend it\n", c->name, what, where);
    abort();
}

int foreign_call(const struct context *c, const double *tau, const double *f_min, const double *f_max, double *f,
                 double *share)
{
    const int size[ARRAYS] = {c->k, c->n, c->n, c->n, c->shares};
    tba_real *array[ARRAYS], *at = c->room + WALL;
    for (int i = 0; i < ARRAYS; i++) {
        array[i] = at;
        at += size[i] + WALL;
    }
    for (int j = 0; j < c->k; j++) {
        array[TAU][j] = (tba_real)tau[j];
    }
    for (int i = 0; i < c->n; i++) {
        array[F][i] = (tba_real)NAN; /* an answer that is not written is none, not the last one */
    }
    for (int i = 0; f_min != NULL && i < c->n; i++) {
        array[F_MIN][i] = inward(f_min[i], 0);
        array[F_MAX][i] = inward(f_max[i], 1);
    }
    const struct tba_input input = {sizeof input, array[TAU], f_min != NULL ? array[F_MIN] : NULL,
                                    f_min != NULL ? array[F_MAX] : NULL};
    struct tba_output output = {sizeof output, array[F], c->shares ? array[SHARE] : NULL};
    if (c->reset != NULL) {
        c->reset(c->allocator);
    }
    const int status = c->call(c->allocator, &input, &output);

    at = c->room;
    for (int i = 0; i <= ARRAYS; i++) {
        if (memcmp(at, wall, sizeof wall) != 0) {
            end(c, i == 0 ? "wrote before " : "wrote beyond ", names[i == 0 ? TAU : i - 1]);
        }
        at += WALL + (i < ARRAYS ? size[i] : 0);
    }
    const volatile double one = 1.0, more = 0.75 * DBL_EPSILON, less = 0.25 * DBL_EPSILON;
    if (one + more != 1.0 + DBL_EPSILON || one + less != 1.0) {
        end(c, "left the processor in another rounding mode", "");
    }
    for (int i = 0; i < c->n; i++) {
        f[i] = array[F][i];
    }
    for (int i = 0; i < c->shares; i++) {
        share[i] = array[SHARE][i];
    }
    return status >= 0 && status <= TBA_NOT_CONVERGED ? status : TBA_NOT_CONVERGED;
}

/* Stands for an allocator that takes no time: a call of it is the way in. */
int foreign_nothing(void *allocator, const struct tba_input *input, struct tba_output *output)
{
    (void)allocator;
    (void)input;
    (void)output;
    return TBA_SOLVED;
}
