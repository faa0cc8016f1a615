// Two generated vehicles, in two scalars and by two methods, and a third one whose matrix is read at boot and of which
// two thrusters fail. Reads k, n, T, f_min, f_max and tau of that vehicle; prints status, share and thrusts, a call a line.
#include <stdio.h>

#include "bluerov2_heavy_scaled_call_float.h"
#include "libthrustbench.h"
#include "ukwial_nullspace.h"

// Names that none of those may take.
enum { SOLVED = 7, NOT_FINITE = 8 };
static int finite(int x) { return x; }
static int least(int x) { return x; }

template <typename Real, int n> static void print(int status, Real share, const Real (&f)[n])
{
    printf("%d %.17g", status, static_cast<double>(share));
    for (Real each : f) {
        printf(" %.17g", static_cast<double>(each));
    }
    printf("\n");
}

static bool read(tb_real *values, int count)
{
    for (int i = 0; i < count; i++) {
        double value = 0;
        if (scanf("%lf", &value) != 1) {
            return false;
        }
        values[i] = static_cast<tb_real>(value);
    }
    return true;
}

static int read_at_boot()
{
    static tb_allocator allocator;
    static tb_real T[TB_K_MAX * TB_N_MAX], low[TB_N_MAX], high[TB_N_MAX], tau[TB_K_MAX];
    int k = 0, n = 0;
    if (scanf("%d %d", &k, &n) != 2 || k < 1 || k > TB_K_MAX || n < 1 || n > TB_N_MAX || !read(T, k * n) ||
        !read(low, n) || !read(high, n) || !read(tau, k)) {
        return 2;
    }
    if (tb_prepare(&allocator, k, n, T, nullptr, nullptr, low, high) != TB_SOLVED) {
        return 3;
    }
    const unsigned long failures[] = {0, 1UL << 2, 1UL << 2 | 1UL << 5};
    for (const unsigned long failed : failures) {
        tb_real f[TB_N_MAX] = {}, share = 1;
        if (tb_without(&allocator, failed) != TB_SOLVED) {
            return 4;
        }
        const int exact = tb_nullspace(&allocator, tau, nullptr, nullptr, f);
        print(exact, share, f);
        const int part = tb_scaled(&allocator, tau, nullptr, nullptr, f, &share);
        print(part, share, f);
    }
    return 0;
}

int main()
{
    const double tau[] = {60, 40, 20};
    const float heavy[] = {10, -5, 20, 1, 2, -3}, low[] = {-9, -8, -7, -6, -5, -4, -3, -2}, high[] = {2, 3, 4, 5, 6, 7, 8, 9};
    for (int fault = -1; fault < 4; fault++) {
        double f[4] = {};
        const int status = ukwial_nullspace(tau, fault, f);
        print(status, 1.0, f);
    }
    for (int fault = -1; fault < 8; fault++) {
        float f[8] = {}, share[1] = {};
        const int status = bluerov2_heavy_scaled_call_float(heavy, low, high, fault, f, share);
        print(status, share[0], f);
    }
    if (finite(SOLVED) + least(NOT_FINITE) != 15) {
        return 1;
    }
    return read_at_boot();
}
