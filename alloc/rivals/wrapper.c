/* From a wrench to thrusts by a solver that rival_solve stands for, and a check of what it answers.
 *
 * rival.h says what the solver offers; tables.h has the vehicle's numbers, the sizes K, N, M, P and LOST, and
 * AT_CALL and CHECKED. A solver's status is a claim: with CHECKED the thrusts are clipped to the limits, T f =
 * tau says whether they make the wrench, and only a proof says that nothing does.
 */
#include "rival.h"
#include "tables.h"

enum { SOLVED = 0, PARTIAL = 1, INFEASIBLE = 2, NOT_CONVERGED = 3, NOT_FINITE = -2 };

#if CHECKED
static int finite(const real *values, int count)
{
    int good = 1;
    for (int i = 0; i < count; i++)
        good &= values[i] - values[i] == 0;
    return good;
}

static real size(real value)
{
    return value < 0 ? -value : value;
}

/* Whether y'b > sum of max(y'A_i lb_i, y'A_i ub_i), or the same of -y, by more than rounding may make: then no x
 * within the bounds meets A x = b, whatever y is. */
static int proven(const real *b, const real *low, const real *high, const real *y)
{
    real along = 0, most = 0, least = 0, sizes = 0;
    for (int j = 0; j < P; j++) {
        along += y[j] * b[j];
        sizes += size(y[j] * b[j]);
    }
    for (int i = 0; i < M; i++) {
        real c = 0, terms = 0;
        for (int j = 0; j < P; j++) {
            c += y[j] * A[j * M + i];
            terms += size(y[j] * A[j * M + i]);
        }
        most += c > 0 ? c * high[i] : c * low[i];
        least += c > 0 ? c * low[i] : c * high[i];
        sizes += terms * (size(low[i]) + size(high[i]));
    }
    return along - most > DOUBT * sizes || least - along > DOUBT * sizes;
}
#endif

#if AT_CALL
int ENTRY(const real *tau, const real *f_min, const real *f_max, real *f)
#else
int ENTRY(const real *tau, real *f)
#endif
{
    real b[P], x[M], y[P];
#if CHECKED
    if (!finite(tau, K))
        return NOT_FINITE;
#endif
#if AT_CALL
    real lb[M], ub[M];
    int crossed = 0;
    for (int i = 0; i < M; i++) {
        const real low = f_min[working[i]], high = f_max[working[i]];
#if CHECKED
        if (low - low != 0 || high - high != 0)
            return NOT_FINITE;
#endif
        crossed |= low > high;
        lb[i] = low * per_unit[i];
        ub[i] = high * per_unit[i];
    }
    if (crossed)
        return INFEASIBLE;
#endif
#if LOST
    for (int i = 0; i < LOST; i++) {
        real lost = 0;
        for (int j = 0; j < K; j++)
            lost += unreachable[i * K + j] * tau[j];
        if (!(lost <= UNREACHABLE && lost >= -UNREACHABLE))
            return INFEASIBLE;
    }
#endif
    for (int i = 0; i < P; i++) {
        b[i] = 0;
        for (int j = 0; j < K; j++)
            b[i] += b_of_tau[i * K + j] * tau[j];
    }
    const int claim = rival_solve(b, lb, ub, x, y);
#if CHECKED
    (void)claim;
    if (!finite(x, M)) /* a comparison with NaN would make a limit of it */
        return proven(b, lb, ub, y) ? INFEASIBLE : NOT_CONVERGED;
    real thrust[M], squares = 0;
    for (int i = 0; i < M; i++) {
        const real low = f_min[working[i]], high = f_max[working[i]], wanted = unit[i] * x[i];
        const real most = wanted < high ? wanted : high;
        thrust[i] = most > low ? most : low;
    }
    for (int j = 0; j < K; j++) {
        real miss = -per_axis[j] * tau[j];
        for (int i = 0; i < M; i++)
            miss += T[j * M + i] * thrust[i];
        squares += miss * miss;
    }
    if (!(squares <= PART * PART))
        return proven(b, lb, ub, y) ? INFEASIBLE : NOT_CONVERGED;
    for (int i = 0; i < N; i++)
        f[i] = 0;
    for (int i = 0; i < M; i++)
        f[working[i]] = thrust[i];
    return squares <= MET * MET ? SOLVED : PARTIAL;
#else
    for (int i = 0; i < N; i++)
        f[i] = 0;
    for (int i = 0; i < M; i++)
        f[working[i]] = unit[i] * x[i];
    return claim;
#endif
}
