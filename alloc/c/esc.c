struct OWN_now { /* the curves at the voltage of a call */
    const SCALAR *at;                  /* of each knot thrust [N]ADDED */
    SCALAR up;                         /* from one voltage to the next, 0 to 1 */
    SCALAR most[SIDES], scale[SIDES];  /* of each side the largest thrust [N], and what makes a bucket of a thrust */
};

/* Thrust of a knot at the voltage of the call [N]. */
static inline SCALAR OWN_thrust(const struct OWN_now *now, int knot)
{
    return THRUST;
}

/* Finds the curves at a voltage; returns whether nothing was measured there. */
static int OWN_find(SCALAR volts, struct OWN_now *now)
{
    FOUND
    for (int s = 0; s < SIDES; s++) {
        now->most[s] = OWN_thrust(now, OWN_last[s]);
        now->scale[s] = now->most[s] > ZERO ? BUCKETS / now->most[s] : ZERO;
    }
    return outside;
}

/* Steps from neutral that make the thrust nearest to a, which is 0 to most[s]; what they make goes to made [N]. */
static inline int OWN_steps(const struct OWN_now *now, int s, SCALAR a, INNER SCALAR outer, SCALAR *made)
{
    int k = OWN_start[s][(int)(a * now->scale[s]) & LAST_BUCKET];
    SCALAR below = OWN_thrust(now, k), above = OWN_thrust(now, k + 1);
    while (above < a && k < LAST_PIECE) {
        k++;
        below = above;
        above = OWN_thrust(now, k + 1);
    }
    int n = OWN_length[k];
    const SCALAR rise = (above - below + TINY) / (SCALAR)n, along = SIZE((a - below) / rise);
    n = along < MOST_STEPS ? (int)(along + HALF) : n;STAY
    SCALAR makes = below + (SCALAR)n * rise;WITHIN
    if (makes > outer) {
        if (makes - outer > SPARE && n > 0) {
            n--;
            makes = below + (SCALAR)n * rise;
        } else { /* rounding: a step that makes just the limit */
            makes = outer;
        }
    }
    n += OWN_step[k];
    *made = makes;
    return n < LAST_STEP ? n : LAST_STEP;
}
