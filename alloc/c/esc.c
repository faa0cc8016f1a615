/* The same for every vehicle; NAME stands for the kernel, and what is in front of this has the vehicle's numbers. */
#ifdef __GNUC__
#define NAME_esc_INLINE static inline __attribute__((always_inline))
#else
#define NAME_esc_INLINE static inline
#endif
#if NAME_esc_AT_CALL
#define NAME_esc_LIMITS const SCALAR f_min[NAME_esc_N], const SCALAR f_max[NAME_esc_N],
#define NAME_esc_OWN f_min, f_max,
#define NAME_esc_REACHED low, high,
#else
#define NAME_esc_LIMITS
#define NAME_esc_OWN
#define NAME_esc_REACHED
#endif
#if NAME_esc_LEVELS
#define NAME_esc_SHARES , SCALAR share[NAME_esc_LEVELS]
#define NAME_esc_SHARE , share
#else
#define NAME_esc_SHARES
#define NAME_esc_SHARE
#endif
#define NAME_esc_CUT 1     /* some thrust is not made */
#define NAME_esc_UNKNOWN 2 /* some thrust is no number */

struct NAME_esc_ends { /* of a curve at the voltage of a call */
    SCALAR low, high, scale; /* what the outermost commands make [N], and what makes cells of a thrust */
    int astern, ahead;       /* those commands in steps from neutral */
};

struct NAME_esc_now { /* the curves at the voltage of a call */
    const SCALAR *at;                                   /* of each knot thrust [N]; behind all, at the next voltage */
    SCALAR up, down;                                    /* shares of the next voltage and of this one */
    const NAME_esc_piece (*first)[NAME_esc_LAST_CELL + 1]; /* of each cell of thrusts the first piece that may hold one */
    struct NAME_esc_ends ends[NAME_esc_CURVES];
};

struct NAME_esc_step { /* a step along a piece of the curve */
    int j, n;                   /* how many from neutral, and from where the piece begins */
    SCALAR below, rise, length; /* where that is [N], how far the piece rises [N], and in how many steps */
    SCALAR makes;               /* [N] */
};

/* Thrust of a knot at the voltage of the call [N]. */
NAME_esc_INLINE SCALAR NAME_esc_thrust(const struct NAME_esc_now *now, const SCALAR *at)
{
#if NAME_esc_BY_VOLTS
    return now->down * at[0] + now->up * at[NAME_esc_KNOTS];
#else
    (void)now;
    return at[0];
#endif
}

/* Finds the curves at a voltage; returns whether nothing was measured there. */
NAME_esc_INLINE int NAME_esc_find(SCALAR volts, struct NAME_esc_now *now)
{
    const int outside = NAME_esc_OUTSIDE(volts);
#if NAME_esc_BY_VOLTS
    const int row = NAME_esc_ROW(volts);
    const SCALAR up = (volts - NAME_esc_volts[row]) * NAME_esc_per_volt[row];
    now->up = up < ONE ? (up > ZERO ? up : ZERO) : ONE;
    now->down = ONE - now->up;
    now->at = NAME_esc_f + NAME_esc_KNOTS * row;
#else
    const int row = 0;
    (void)volts;
    now->at = NAME_esc_f;
#endif
    now->first = NAME_esc_first[row];
    for (int c = 0; c < NAME_esc_CURVES; c++) {
        struct NAME_esc_ends *const ends = &now->ends[c];
        const SCALAR *const from = now->at + NAME_esc_BEGIN(c), *const to = now->at + NAME_esc_LAST(c);
        ends->low = NAME_esc_thrust(now, from);
        ends->high = NAME_esc_thrust(now, to);
        ends->scale = NAME_esc_MOST(ends) > NAME_esc_LEAST ? NAME_esc_REACH / NAME_esc_MOST(ends) : ZERO;
#if NAME_esc_FLAT
        int k = 0; /* of commands that make the same the one nearest to neutral is the outermost */
        while (from + k < to && !(NAME_esc_thrust(now, from + k + 1) > ends->low)) {
            k++;
        }
        ends->astern = ends->low < ZERO ? NAME_esc_step[NAME_esc_BEGIN(c) + k] : 0;
        k = 0;
        while (to - k > from && !(NAME_esc_thrust(now, to - k - 1) < ends->high)) {
            k++;
        }
        ends->ahead = ends->high > ZERO ? NAME_esc_step[NAME_esc_LAST(c) - k] : 0;
#else
        ends->astern = NAME_esc_step[NAME_esc_BEGIN(c)];
        ends->ahead = NAME_esc_step[NAME_esc_LAST(c)];
#endif
    }
    return outside;
}

/* The step whose thrust is nearest to x, which lies on the curve. */
NAME_esc_INLINE struct NAME_esc_step NAME_esc_nearest(const struct NAME_esc_now *now, int curve, SCALAR x)
{
    int k = now->first[curve][(int)(NAME_esc_MIDDLE + x * now->ends[curve].scale) & NAME_esc_LAST_CELL];
    SCALAR below = NAME_esc_thrust(now, now->at + k), above = NAME_esc_thrust(now, now->at + k + 1);
    while (above < x && k < NAME_esc_LAST(curve) - 1) {
        k++;
        below = above;
        above = NAME_esc_thrust(now, now->at + k + 1);
    }
    const int from = NAME_esc_step[k];
    const SCALAR length = (SCALAR)(NAME_esc_step[k + 1] - from);
    const SCALAR rise = above - below, along = tb_least_OF(tb_size_OF((x - below) / (rise + NAME_esc_TINY)), ONE);
    const int n = (int)(along * length + HALF);
    const struct NAME_esc_step step = {from + n, n, below, rise, length, below + rise * ((SCALAR)n / length)};
    return step;
}

/* Takes a step to limits, where x lies, if it is outside of them: to the next one towards them, and of two that both lie
 * outside to the smaller thrust. Where only rounding is in the way the step stays. */
NAME_esc_INLINE void NAME_esc_hold(struct NAME_esc_step *step, SCALAR low, SCALAR high)
{
    int by = 0;
    if (step->makes > high) {
        by = high >= step->makes - NAME_esc_SPARE ? 0 : -1;
        step->makes = by == 0 ? high : step->makes;
    } else if (step->makes < low) {
        by = low <= step->makes + NAME_esc_SPARE ? 0 : 1;
        step->makes = by == 0 ? low : step->makes;
    }
    if (by != 0) {
        const int j = step->j + by;
        const SCALAR makes = step->below + step->rise * ((SCALAR)(step->n + by) / step->length);
#if !NAME_esc_STOPS
        if (tb_size_OF(makes) < tb_size_OF(step->makes) || (makes >= low && makes <= high))
#endif
        {
            step->j = j > NAME_esc_LAST_STEP ? NAME_esc_LAST_STEP : j < NAME_esc_FIRST_STEP ? NAME_esc_FIRST_STEP : j;
            step->makes = makes;
        }
    }
}

#if NAME_esc_ALIKE
int NAME_esc(const SCALAR f[NAME_esc_N], SCALAR volts, NAME_esc_command command[NAME_esc_N], SCALAR f_made[NAME_esc_N])
#else
static int NAME_esc_send(const SCALAR f[NAME_esc_N], NAME_esc_LIMITS int fault, SCALAR volts,
                         NAME_esc_command command[NAME_esc_N], SCALAR f_made[NAME_esc_N])
#endif
{
    struct NAME_esc_now now;
    int state = NAME_esc_find(volts, &now);
#if NAME_esc_ALIKE
    SCALAR least[NAME_esc_CURVES], most[NAME_esc_CURVES];
    for (int c = 0; c < NAME_esc_CURVES; c++) {
        least[c] = now.ends[c].low > NAME_esc_LOW(0) ? now.ends[c].low : NAME_esc_LOW(0);
        most[c] = now.ends[c].high < NAME_esc_HIGH(0) ? now.ends[c].high : NAME_esc_HIGH(0);
    }
#endif
    for (int i = 0; i < NAME_esc_N; i++) {
        const int curve = NAME_esc_CURVE(i);
        const struct NAME_esc_ends *const ends = &now.ends[curve];
#if NAME_esc_HOLDS
        SCALAR low = NAME_esc_LOW(i), high = NAME_esc_HIGH(i);
#endif
        SCALAR x = f[i], made;
        int j, end = 0;
#if NAME_esc_ALIKE
        if (!(x > least[curve] && x < most[curve])) {
            const int known = x - x == ZERO;
            const int back = x < most[curve];
            const SCALAR wish = x;
            x = !known ? ZERO : back ? least[curve] : most[curve];
            state |= !known ? NAME_esc_UNKNOWN : tb_size_OF(x - wish) <= NAME_esc_SPARE ? 0 : NAME_esc_CUT;
            end = x == (back ? ends->low : ends->high) ? (back ? -1 : 1) : 0;
        }
#else
        if (!(x >= low && x <= high && x > ends->low && x < ends->high)) {
            const int known = x - x == ZERO;
            if (known && low <= high && i != fault) {
                const SCALAR wish = x;
                x = x < low ? low : x > high ? high : x;
                x = x < ends->low ? ends->low : x > ends->high ? ends->high : x;
                state |= tb_size_OF(x - wish) <= NAME_esc_SPARE ? 0 : NAME_esc_CUT;
                end = x == ends->high ? 1 : x == ends->low ? -1 : 0;
            } else { /* a thruster that is off has f = 0 */
                state |= !known ? NAME_esc_UNKNOWN : i == fault ? 0 : NAME_esc_CUT;
                x = low = high = ZERO;
            }
        }
#endif
        if (end == 0) {
            struct NAME_esc_step step = NAME_esc_nearest(&now, curve, x);
#if NAME_esc_HOLDS
            if (step.makes < low || step.makes > high) {
                NAME_esc_hold(&step, low, high);
            }
#endif
#if NAME_esc_STAY /* some thrusts in a dead band are too little for the smallest step */
            const int last = (int)step.length - 1;
            const int ahead = step.below == ZERO && step.n == 1;
            const int astern = step.below + step.rise == ZERO && step.n == last;
            if (NAME_esc_STAYS(curve) && (ahead || astern) && tb_size_OF(x) < tb_size_OF(step.makes)) {
#if NAME_esc_STOPS
                step.makes = ZERO;
#else
                step.makes = low <= ZERO && high >= ZERO ? ZERO : step.makes;
#endif
            }
#endif
            made = step.makes;
            if (made == ZERO) {
                state |= x == ZERO ? 0 : NAME_esc_CUT;
                j = 0;
            } else {
                j = step.j;
            }
        } else {
            made = end > 0 ? ends->high : ends->low;
            j = end > 0 ? ends->ahead : ends->astern;
        }
        command[i] = NAME_esc_SENT(i, j);
        f_made[i] = made;
    }
    return state >= NAME_esc_UNKNOWN ? TB_NOT_FINITE : state ? TB_PARTIAL : TB_SOLVED;
}

#if !NAME_esc_ALIKE
int NAME_esc(const SCALAR f[NAME_esc_N], NAME_esc_LIMITS SCALAR volts,
             NAME_esc_command command[NAME_esc_N], SCALAR f_made[NAME_esc_N])
{
    return NAME_esc_send(f, NAME_esc_OWN -1, volts, command, f_made);
}
#endif

#if NAME_esc_AT_CALL
/* Limits of a call cut at the ends of the curves at a voltage; those that cross are left to the kernel. */
static void NAME_esc_reach(NAME_esc_LIMITS SCALAR volts, SCALAR low[NAME_esc_N], SCALAR high[NAME_esc_N])
{
    struct NAME_esc_now now;
    (void)NAME_esc_find(volts, &now);
    for (int i = 0; i < NAME_esc_N; i++) {
        const struct NAME_esc_ends *const ends = &now.ends[NAME_esc_CURVE(i)];
        const SCALAR least = f_min[i], most = f_max[i];
        const int cut = least <= most;
        low[i] = !cut ? least : least < ends->low ? ends->low : least > ends->high ? ends->high : least;
        high[i] = !cut ? most : most < ends->low ? ends->low : most > ends->high ? ends->high : most;
    }
}
#endif

int NAME_to_esc(const SCALAR tau[NAME_esc_K], NAME_esc_LIMITS int fault, SCALAR volts,
                NAME_esc_command command[NAME_esc_N], SCALAR f_made[NAME_esc_N] NAME_esc_SHARES)
{
    SCALAR f[NAME_esc_N];
#if NAME_esc_AT_CALL
    SCALAR low[NAME_esc_N], high[NAME_esc_N];
    NAME_esc_reach(f_min, f_max, volts, low, high);
#endif
    const int found = NAME(tau, NAME_esc_REACHED fault, f NAME_esc_SHARE);
    if (found != TB_SOLVED && found != TB_PARTIAL) {
        for (int i = 0; i < NAME_esc_N; i++) {
            command[i] = NAME_esc_NEUTRAL(i);
            f_made[i] = ZERO;
        }
        return found;
    }
#if NAME_esc_ALIKE
    const int sent = NAME_esc(f, volts, command, f_made);
#else
    const int sent = NAME_esc_send(f, NAME_esc_OWN fault, volts, command, f_made);
#endif
    return sent == TB_SOLVED ? found : sent;
}
