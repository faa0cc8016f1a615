/* A plain allocator: f = P T' (T P P T')^-1 tau, each thrust cut at its limit. Put your own in its place.
 *
 *     cc -std=c99 -O2 -shared -fPIC my_allocator.c -o my_allocator.so
 */
#include <stdlib.h>

#include "thrustbench_allocator.h"

enum { K = 6, N = 64 };

struct allocator {
    int k, n;
    tba_real G[N][K], f_min[N], f_max[N];
};

static const struct tba_promise promise = {sizeof(struct tba_promise), NULL, 1, 1.0, 0};

int tba_interface(void)
{
    return TBA_INTERFACE;
}

const struct tba_promise *tba_promises(void)
{
    return &promise;
}

/* Turns A, k by k and positive definite, into its inverse by Gauss and Jordan; returns 0 where it has none. */
static int invert(int k, tba_real A[K][K])
{
    for (int p = 0; p < k; p++) {
        const tba_real pivot = A[p][p];
        if (!(pivot > (tba_real)1e-9)) {
            return 0;
        }
        A[p][p] = 1;
        for (int j = 0; j < k; j++) {
            A[p][j] /= pivot;
        }
        for (int i = 0; i < k; i++) {
            const tba_real factor = A[i][p];
            for (int j = 0; i != p && j < k; j++) {
                A[i][j] = (j == p ? (tba_real)0 : A[i][j]) - factor * A[p][j];
            }
        }
    }
    return 1;
}

void *tba_prepare(const struct tba_vehicle *vehicle, const char **reason)
{
    const int k = vehicle->k, n = vehicle->n;
    tba_real TP[K][N], A[K][K];
    if (k > K || n > N) {
        *reason = "has more than 6 axes or 64 thrusters";
        return NULL;
    }
    for (int j = 0; j < k; j++) {
        for (int i = 0; i < n; i++) {
            TP[j][i] = vehicle->T[j * n + i] * vehicle->readiness[i];
        }
    }
    for (int j = 0; j < k; j++) {
        for (int l = 0; l < k; l++) {
            A[j][l] = 0;
            for (int i = 0; i < n; i++) {
                A[j][l] += TP[j][i] * TP[l][i];
            }
        }
    }
    struct allocator *made = invert(k, A) ? malloc(sizeof *made) : NULL;
    if (made == NULL) {
        *reason = "its thrusters do not push every axis";
        return NULL;
    }
    made->k = k;
    made->n = n;
    for (int i = 0; i < n; i++) {
        made->f_min[i] = vehicle->f_min[i];
        made->f_max[i] = vehicle->f_max[i];
        for (int j = 0; j < k; j++) {
            made->G[i][j] = 0;
            for (int l = 0; l < k; l++) {
                made->G[i][j] += TP[l][i] * A[l][j];
            }
        }
    }
    return made;
}

int tba_call(void *allocator, const struct tba_input *input, struct tba_output *output)
{
    const struct allocator *a = allocator;
    const tba_real *f_min = input->f_min != NULL ? input->f_min : a->f_min;
    const tba_real *f_max = input->f_max != NULL ? input->f_max : a->f_max;
    int status = TBA_SOLVED;
    for (int i = 0; i < a->n; i++) {
        tba_real f = 0;
        for (int j = 0; j < a->k; j++) {
            f += a->G[i][j] * input->tau[j];
        }
        if (f_min[i] > f_max[i]) {
            return TBA_INFEASIBLE;
        }
        if (f < f_min[i] || f > f_max[i]) {
            f = f < f_min[i] ? f_min[i] : f_max[i];
            status = TBA_PARTIAL;
        }
        output->f[i] = f;
    }
    return status;
}
