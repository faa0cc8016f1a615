/* Flies healthy dives as dives.py does, call by call with the generated allocator and its monitor.
 *
 * vehicle.h, which dives.py writes, has the vehicle's numbers, ALLOCATE, WATCH, SUSPECT and STATE.
 */
#include <math.h>
#include <stdint.h>
#include <stddef.h>

#include "vehicle.h"

#define WAVES 3

static double uniform(uint64_t *seed) /* 0 < x < 1, by xorshift64* */
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return ((double)((*seed * UINT64_C(2685821657736338717)) >> 11) + 0.5) / 9007199254740992.0;
}

static void add_noise(double x[K], double size, uint64_t *seed) /* normal, by Marsaglia's polar method */
{
    for (int j = 0; j < K; j += 2) {
        double a, b, square;
        do {
            a = 2.0 * uniform(seed) - 1.0;
            b = 2.0 * uniform(seed) - 1.0;
            square = a * a + b * b;
        } while (square >= 1.0 || square == 0.0);
        const double scale = size * sqrt(-2.0 * log(square) / square);
        x[j] += a * scale;
        if (j + 1 < K) {
            x[j + 1] += b * scale;
        }
    }
}

static void add_cross(double *out, const double *a, const double *b)
{
    out[0] += a[1] * b[2] - a[2] * b[1];
    out[1] += a[2] * b[0] - a[0] * b[2];
    out[2] += a[0] * b[1] - a[1] * b[0];
}

static void coriolis(const double v[K], double out[K]) /* C(v) v */
{
    double moved[6] = {0.0}, momentum[6] = {0.0}, whole[6] = {0.0};
    for (int j = 0; j < K; j++) {
        moved[axis[j]] = v[j];
        momentum[axis[j]] = mass[j] * v[j];
    }
    add_cross(whole, moved + 3, momentum);
    add_cross(whole + 3, moved + 3, momentum + 3);
    add_cross(whole + 3, moved, momentum);
    for (int j = 0; j < K; j++) {
        out[j] = whole[axis[j]];
    }
}

/* Accelerations under a wrench, at drag that is so many times the nominal, in water that moves. */
static void rate(const double wrench[K], const double v[K], const double drag[K], const double water[K],
                 double out[K])
{
    double turning[K];
    coriolis(v, turning);
    for (int j = 0; j < K; j++) {
        const double through = v[j] - water[j];
        const double damping = (linear[j] + quadratic[j] * fabs(through)) * through;
        out[j] = (wrench[j] - turning[j] - drag[j] * damping) * inverse[j];
    }
}

/* Largest log odds of one dive; drag, water (K), periods and phases (WAVES, K). Thrusts (steps, N), measured
 * accelerations and velocities (steps, K) are written where they are not NULL. */
double dive(const double drag[K], const double water[K], const double periods[], const double phases[],
            double noise, int steps, uint64_t seed, double *thrusts, double *a_rows, double *v_rows)
{
    static const double one[K] = ONES, still[K] = {0.0};
    const double row_s = 1.0 / RATE_HZ, fine_s = row_s / FINE;
    double wave[WAVES * K][4], v[K] = {0.0}, nominal[K] = {0.0}, largest_odds = 0.0;
    STATE state = {{0.0}, {0.0}, {0.0}, {{0.0}}, {0.0}, 0};
    for (int i = 0; i < WAVES * K; i++) {
        const double turned = 2.0 * 3.14159265358979323846 / periods[i] * row_s;
        const double start[4] = {sin(phases[i]), cos(phases[i]), sin(turned), cos(turned)};
        for (int each = 0; each < 4; each++) {
            wave[i][each] = start[each];
        }
    }
    for (int step = 0; step < steps; step++) {
        double wanted[K] = {0.0}, asked[K], seen[K], f[N], share[1], wrench[K], a[K], felt[K], odds;
        for (int i = 0; i < WAVES * K; i++) {
            double *w = wave[i];
            wanted[i % K] += largest[i % K] * w[0] / WAVES;
            const double sine = w[0] * w[3] + w[1] * w[2];
            w[1] = w[1] * w[3] - w[0] * w[2];
            w[0] = sine;
        }
        for (int j = 0; j < K; j++) {
            seen[j] = v[j];
        }
        add_noise(seen, 0.1 * noise, &seed);
        for (int j = 0; j < K; j++) {
            asked[j] = wanted[j] + GAIN * mass[j] * (nominal[j] - seen[j]);
        }
        (void)ALLOCATE(asked, f, share);
        for (int j = 0; j < K; j++) {
            wrench[j] = 0.0;
            for (int i = 0; i < N; i++) {
                wrench[j] += T[j][i] * f[i];
            }
        }
        rate(wrench, v, drag, water, a);
        add_noise(a, noise, &seed);
        coriolis(seen, felt);
        for (int j = 0; j < K; j++) {
            felt[j] += mass[j] * a[j] + (linear[j] + quadratic[j] * fabs(seen[j])) * seen[j];
        }
        (void)WATCH(&state, f, felt);
        (void)SUSPECT(&state, &odds);
        largest_odds = odds > largest_odds ? odds : largest_odds;
        for (int fine = 0; fine < FINE; fine++) {
            double change[K], wished[K];
            rate(wrench, v, drag, water, change);
            rate(wanted, nominal, one, still, wished);
            for (int j = 0; j < K; j++) {
                v[j] += fine_s * change[j];
                nominal[j] += fine_s * wished[j];
            }
        }
        for (int i = 0; thrusts != NULL && i < N; i++) {
            thrusts[step * N + i] = f[i];
        }
        for (int j = 0; thrusts != NULL && j < K; j++) {
            a_rows[step * K + j] = a[j];
            v_rows[step * K + j] = seen[j];
        }
    }
    return largest_odds;
}
