struct OWN_ends { /* of a curve at the voltage of a call */
    SCALAR low, high, scale; /* what the outermost commands make [N], and what makes cells of a thrust */
    int astern, ahead;       /* those commands in steps from neutral */
};

struct OWN_now { /* the curves at the voltage of a call */
    const SCALAR *at;            /* of each knot thrust [N]ADDED */
    SCALAR up, down;             /* shares of the next voltage and of this one */
    const FIRST (*first)[CELLS]; /* of each cell of thrusts the first piece that may hold one */
    struct OWN_ends ends[CURVES];
};

struct OWN_step { /* a step along a piece of the curve */
    int j, n;                   /* how many from neutral, and from where the piece begins */
    SCALAR below, rise, length; /* where that is [N], how far the piece rises [N], and in how many steps */
    SCALAR makes;               /* [N] */
};

/* Thrust of a knot at the voltage of the call [N]. */
OWN_INLINE SCALAR OWN_thrust(const struct OWN_now *now, const SCALAR *at)
{
    THRUST
}

/* Finds the curves at a voltage; returns whether nothing was measured there. */
OWN_INLINE int OWN_find(SCALAR volts, struct OWN_now *now)
{
    FOUND
    now->first = OWN_first[row];
    for (int c = 0; c < CURVES; c++) {
        struct OWN_ends *const ends = &now->ends[c];
        const SCALAR *const from = now->at + BEGIN, *const to = now->at + LAST;
        ends->low = OWN_thrust(now, from);
        ends->high = OWN_thrust(now, to);
        ends->scale = SCALE;OUTERMOST
    }
    return outside;
}

/* The step whose thrust is nearest to x, which lies on the curve. */
OWN_INLINE struct OWN_step OWN_nearest(const struct OWN_now *now, OF_CURVE SCALAR x)
{
    int k = now->first[CURVE][(int)(MIDDLE + x * now->ends[CURVE].scale) & LAST_CELL];
    SCALAR below = OWN_thrust(now, now->at + k), above = OWN_thrust(now, now->at + k + 1);
    while (above < x && k < LAST_PIECE) {
        k++;
        below = above;
        above = OWN_thrust(now, now->at + k + 1);
    }
    const int from = OWN_step[k];
    const SCALAR length = (SCALAR)(OWN_step[k + 1] - from);
    const SCALAR rise = above - below, along = LEAST(SIZE((x - below) / (rise + TINY)), ONE);
    const int n = (int)(along * length + HALF);
    const struct OWN_step step = {from + n, n, below, rise, length, below + rise * ((SCALAR)n / length)};
    return step;
}

/* Takes a step to limits, where x lies, if it is outside of them: to the next one towards them, and of two that both lie
 * outside to the smaller thrust. Where only rounding is in the way the step stays. */
OWN_INLINE void OWN_hold(struct OWN_step *step, SCALAR low, SCALAR high)
{
    int by = 0;
    if (step->makes > high) {
        by = high >= step->makes - SPARE ? 0 : -1;
        step->makes = by == 0 ? high : step->makes;
    } else if (step->makes < low) {
        by = low <= step->makes + SPARE ? 0 : 1;
        step->makes = by == 0 ? low : step->makes;
    }
    if (by != 0) {
        const int j = step->j + by;
        const SCALAR makes = step->below + step->rise * ((SCALAR)(step->n + by) / step->length);TAKEN
    }
}
