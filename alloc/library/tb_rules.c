/* What practice does behind T*: tb_clip, and tb_redistribute, which shares what saturated thrusters leave undone. */
#include "tb_internal.h"

#ifdef TB_FLOAT
#define SPARE TB_TOLERANCE /* a thrust freezes where it is beyond a limit by more than this share of the largest */
#else
#define SPARE TB_R(1e-10)
#endif

/* Cuts thrusts at the limits and writes them; `off` is what they were moved by before. */
static int cut(const struct tb_allocator *a, const tb_real *tau, struct tb_thrusts *t, tb_real off, tb_real *f)
{
    const tb_real moved = tb_move_inside(a, t);
    if (moved < 0 || !(moved - moved == 0)) {
        return moved < 0 ? tb_refused(a, tau, TB_INFEASIBLE) : (int)TB_NOT_FINITE;
    }
    tb_leave(a, t, f);
    return tb_meets(a, tau, t, moved + off) ? TB_SOLVED : TB_PARTIAL;
}

int tb_clip(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max, tb_real *f)
{
    struct tb_thrusts t;
    const int status = tb_enter(a, tau, f_min, f_max, &t);
    return status == TB_SOLVED ? cut(a, tau, &t, 0, f) : tb_refused(a, tau, status);
}

int tb_redistribute(const struct tb_allocator *a, const tb_real *tau, const tb_real *f_min, const tb_real *f_max,
                    tb_real *f)
{
    struct tb_thrusts t;
    tb_real frozen[TB_N_MAX], rest[TB_K_MAX];
    int on[TB_N_MAX], more = 1, passes = 0;
    const int status = tb_enter(a, tau, f_min, f_max, &t);
    if (status != TB_SOLVED || !tb_is_finite(tau, a->k)) {
        return tb_refused(a, tau, status);
    }
    for (int p = 0; p < a->m; p++) {
        on[p] = 1;
        frozen[p] = 0;
    }
    for (int pass = 0; pass < a->m && more; pass++) {
        more = 0;
        for (int p = 0; p < a->m; p++) {
            if (on[p] && !(t.x[p] >= t.low[p] - SPARE * a->scale && t.x[p] <= t.high[p] + SPARE * a->scale)) {
                frozen[p] = t.x[p] < t.low[p] ? t.low[p] : t.high[p];
                on[p] = 0;
                more = 1;
            }
        }
        for (int r = 0; r < a->k && more; r++) {
            rest[r] = tau[r] * a->unit[r];
            for (int p = 0; p < a->m; p++) {
                rest[r] -= a->A[r][a->at[p]] * frozen[p];
            }
        }
        if (more) {
            tb_shared(a, rest, on, t.x);
            passes++;
        }
        for (int p = 0; p < a->m; p++) {
            t.x[p] = on[p] ? t.x[p] : frozen[p];
        }
    }
    return cut(a, tau, &t, passes ? a->scale : 0, f);
}
