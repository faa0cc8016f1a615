/* Times a kernel, or walks through it once for callgrind: loop DEMANDS ROUNDS REPEATS.
 *
 * DEMANDS holds WIDTH scalars a call. Each repeat goes ROUNDS times round all demands and prints ns of
 * CPU time per call; ROUNDS 0 makes each call once and prints nothing.
 */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "kernel.h"

static SCALAR demands[100000][WIDTH];

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void round_all(size_t count)
{
    SCALAR f[N];
    for (size_t i = 0; i < count; i++) {
        const SCALAR *tau = demands[i];
        (void)ANSWER(tau, f);
        __asm__ volatile("" ::"r"(f) : "memory"); /* the compiler must believe that f is read */
    }
}

int main(int argc, char **argv)
{
    FILE *file = argc == 4 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL) {
        return 2;
    }
    const size_t count = fread(demands, sizeof demands[0], sizeof demands / sizeof demands[0], file);
    const int rounds = atoi(argv[2]);
    fclose(file);
    round_all(count);
    for (int repeat = 0; repeat < atoi(argv[3]) && rounds > 0; repeat++) {
        const double start = now();
        for (int i = 0; i < rounds; i++) {
            round_all(count);
        }
        printf("%.6f\n", (now() - start) / rounds / (double)count);
    }
    return 0;
}
