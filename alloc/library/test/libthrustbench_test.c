/* Self-test of libthrustbench: vehicles, failures and demands at random, answers held against their equations.
 *
 * What is asked of nullspace is made of thrusts inside the limits, so there is an answer, and none dearer than these.
 * Of scaled it is a multiple of such, so the share has a bound below. Exit code 0 where nothing is wrong. It prints
 * whole numbers only, so newlib-nano needs no -u _printf_float.
 */
#include "../libthrustbench.h"
#include <stddef.h>
#include <stdio.h>

#ifdef TB_FLOAT
#define CLOSE ((tb_real)1e-4)
#define EDGE ((tb_real)1e-3) /* so near to a limit rounding decides */
#else
#define CLOSE ((tb_real)2e-6)
#define EDGE ((tb_real)0)
#endif
enum { VEHICLES = 300, DEMANDS = 12, LEVELS = 2 };

static unsigned long seed = 2004;
static int k, n, wrong, asked, refused;
static tb_real T[TB_K_MAX * TB_N_MAX], H[TB_N_MAX * TB_N_MAX], ready[TB_N_MAX], low[TB_N_MAX], high[TB_N_MAX];
static tb_real length[TB_K_MAX], scale;
static struct tb_allocator allocator;

static tb_real infinity(void)
{
    tb_real x = (tb_real)1e30;
    for (int i = 0; i < 5; i++) {
        x *= x;
    }
    return x;
}

static tb_real uniform(tb_real from, tb_real to)
{
    seed = (seed * 1103515245UL + 12345UL) & 0x7fffffffUL;
    return from + (to - from) * ((tb_real)(seed >> 8) / (tb_real)0x7fffff);
}

static int below(int count)
{
    const int drawn = (int)uniform(0, (tb_real)count);
    return drawn < count ? drawn : count - 1;
}

static void check(int holds, const char *words, const char *method)
{
    asked++;
    if (!holds) {
        wrong += 1;
        if (wrong < 20) {
            printf("%s: %s (k %d, n %d)\n", method, words, k, n);
        }
    }
}

/* A vehicle: dense or half empty, alike thrusters, an axis nobody pushes, weak and dead thrusters, any effort. */
static void draw_vehicle(void)
{
    const int sparse = below(3) == 0, alike = below(4) == 0, lost = below(6) == 0, coupled = below(3) == 0;
    n = 1 + below(TB_N_MAX);
    k = 1 + below(TB_K_MAX);
    scale = 0;
    for (int i = 0; i < n; i++) {
        ready[i] = below(8) == 0 ? 0 : below(8) == 0 ? (tb_real)0.4 : 1;
        low[i] = -uniform(1, 50);
        high[i] = uniform(1, 50);
        scale = -low[i] > scale ? -low[i] : scale;
        scale = high[i] > scale ? high[i] : scale;
        for (int r = 0; r < k; r++) {
            const tb_real entry = sparse && below(2) ? 0 : uniform(-1, 1);
            T[r * n + i] = lost && r == 0 ? 0 : alike && i % 2 ? T[r * n + i - 1] : entry;
        }
        for (int j = 0; j <= i; j++) {
            H[i * n + j] = H[j * n + i] = i == j ? uniform(1, 3) : coupled ? uniform(0, (tb_real)0.1) : 0;
        }
    }
    for (int r = 0; r < k; r++) {
        length[r] = 0;
        for (int i = 0; i < n; i++) {
            length[r] += T[r * n + i] * T[r * n + i];
        }
        length[r] = length[r] > 1 ? length[r] : 1; /* no shorter than a root of it */
    }
}

static int off(unsigned long mask, int i)
{
    return !(ready[i] > 0) || (mask >> i & 1UL);
}

static tb_real effort(const tb_real *f)
{
    tb_real sum = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            sum += f[i] * H[i * n + j] * f[j];
        }
    }
    return sum;
}

/* Whether T P f is `share` of tau, of each axis that of its level; every `levels`-th axis has the same. */
static int makes(const tb_real *f, const tb_real *tau, const tb_real *share, int levels)
{
    int good = 1;
    for (int r = 0; r < k; r++) {
        tb_real sum = -share[r % levels] * tau[r];
        for (int i = 0; i < n; i++) {
            sum += T[r * n + i] * ready[i] * f[i];
        }
        good &= (sum < 0 ? -sum : sum) <= CLOSE * scale * length[r];
    }
    return good;
}

static int inside(const tb_real *f, const tb_real *f_min, const tb_real *f_max, unsigned long mask)
{
    int good = 1;
    for (int i = 0; i < n; i++) {
        good &= off(mask, i) ? f[i] == 0 : f[i] >= f_min[i] && f[i] <= f_max[i];
    }
    return good;
}

/* The vehicle's own limits, which are prepared, and the same as limits of the call, far beyond what can be made. */
static void own(const tb_real *tau, unsigned long mask)
{
    tb_real far[TB_K_MAX], f[TB_N_MAX], share[TB_K_MAX], given[TB_K_MAX];
    for (int r = 0; r < k; r++) {
        far[r] = 4 * tau[r];
    }
    check(tb_scaled(&allocator, far, NULL, NULL, f, share) == tb_scaled(&allocator, far, low, high, f, given) &&
              share[0] - given[0] <= CLOSE && given[0] - share[0] <= CLOSE,
          "limits of the call answer as the vehicle's own", "scaled");
    tb_priority(&allocator, far, low, high, f, given);
    tb_priority(&allocator, far, NULL, NULL, f, share);
    check(inside(f, low, high, mask) && share[0] - given[0] <= CLOSE && given[0] - share[0] <= CLOSE,
          "limits of the call answer as the vehicle's own", "priority");
}

/* A bit of a thruster that is not there, which leaves nothing prepared. */
static void no_such_fault(void)
{
    const tb_real tau[TB_K_MAX] = {0};
    tb_real f[TB_N_MAX];
    if (n < 32) {
        check(tb_without(&allocator, 1UL << n) == TB_NO_SUCH_FAULT, "no other thruster fails", "without");
        check(tb_nullspace(&allocator, tau, NULL, NULL, f) == TB_BAD_ARGUMENT, "nothing is prepared", "without");
    }
}

static void ask(unsigned long mask)
{
    tb_real f_min[TB_N_MAX], f_max[TB_N_MAX], made[TB_N_MAX], tau[TB_K_MAX], f[TB_N_MAX], share[TB_K_MAX];
    const tb_real times = below(2) ? 1 : 2, huge = infinity(), whole[] = {1};
    int status;
    for (int i = 0; i < n; i++) {
        f_min[i] = low[i] * uniform(0, 1);
        f_max[i] = high[i] * uniform(0, 1);
        made[i] = off(mask, i) ? 0 : below(2) ? uniform(f_min[i], f_max[i]) : below(2) ? f_min[i] : f_max[i];
        made[i] -= EDGE * made[i];
    }
    for (int r = 0; r < k; r++) {
        tau[r] = 0;
        for (int i = 0; i < n; i++) {
            tau[r] += T[r * n + i] * ready[i] * made[i];
        }
    }
    status = tb_nullspace(&allocator, tau, f_min, f_max, f);
    check(status == TB_SOLVED, "a wrench that can be made is", "nullspace");
    if (status == TB_SOLVED) {
        check(inside(f, f_min, f_max, mask), "thrusts lie inside the limits", "nullspace");
        check(makes(f, tau, whole, 1), "thrusts make tau", "nullspace");
        check(effort(f) <= effort(made) + CLOSE * scale * (scale + effort(made) / scale), "no thrusts are dearer",
              "nullspace");
    }
    for (int r = 0; r < k; r++) {
        tau[r] *= times;
    }
    status = tb_scaled(&allocator, tau, f_min, f_max, f, share);
    if (status != TB_BAD_ARGUMENT) {
        check(status == TB_SOLVED || status == TB_PARTIAL, "every demand is answered", "scaled");
        check(share[0] >= 1 / times - CLOSE && share[0] <= 1, "the share is what can be made", "scaled");
        check(inside(f, f_min, f_max, mask), "thrusts lie inside the limits", "scaled");
        check(makes(f, tau, share, 1), "thrusts make the share of tau", "scaled");
        status = tb_priority(&allocator, tau, f_min, f_max, f, share);
        check(status == TB_SOLVED || status == TB_PARTIAL, "every demand is answered", "priority");
        check(inside(f, f_min, f_max, mask), "thrusts lie inside the limits", "priority");
        check(status != TB_SOLVED || makes(f, tau, whole, 1), "thrusts make tau", "priority");
        /* Where a direction is lost, an axis gets what the others leave of it. */
        check(allocator.rank < k || makes(f, tau, share, LEVELS), "thrusts make each level's share", "priority");
        own(tau, mask);
    }
    for (int rule = 0; rule < 2; rule++) {
        status = (rule ? tb_redistribute : tb_clip)(&allocator, tau, f_min, f_max, f);
        check(status == TB_SOLVED || status == TB_PARTIAL, "every demand is answered", rule ? "redistribute" : "clip");
        check(inside(f, f_min, f_max, mask), "thrusts lie inside the limits", rule ? "redistribute" : "clip");
        check(status != TB_SOLVED || makes(f, tau, whole, 1), "thrusts make tau", rule ? "redistribute" : "clip");
    }
    f[0] = 12345;
    tau[below(k)] *= huge; /* infinite, or zero still */
    status = tb_nullspace(&allocator, tau, f_min, f_max, f);
    check(status == TB_SOLVED || f[0] == 12345, "what is refused is left alone", "nullspace");
    tau[0] = tau[0] * 0 + (huge - huge); /* NaN */
    check(tb_nullspace(&allocator, tau, f_min, f_max, f) == TB_NOT_FINITE, "NaN is refused", "nullspace");
}

int main(void)
{
    for (int vehicle = 0; vehicle < VEHICLES; vehicle++) {
        int level[TB_K_MAX], status;
        draw_vehicle();
        status = tb_prepare(&allocator, k, n, T, below(2) ? H : NULL, ready, low, high);
        if (status == TB_SOLVED && allocator.H[0][0] == 1) { /* all alike */
            for (int i = 0; i < n * n; i++) {
                H[i] = i % (n + 1) == 0;
            }
        }
        for (int r = 0; r < k; r++) {
            level[r] = r % LEVELS;
        }
        if (status != TB_SOLVED || tb_levels(&allocator, level) != TB_SOLVED) {
            refused++;
            continue;
        }
        no_such_fault();
        for (int demand = 0; demand < DEMANDS; demand++) {
            const unsigned long mask = demand % 3 == 2 ? 1UL << below(n) | 1UL << below(n) : 0;
            if (tb_without(&allocator, mask) == TB_SOLVED) {
                ask(mask);
            } else {
                refused++;
            }
        }
    }
    printf("%d checks, %d wrong, %d vehicles or failures refused\n", asked, wrong, refused);
    return wrong > 0 || asked < 10000 || refused > VEHICLES;
}
