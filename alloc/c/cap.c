/* The same for every vehicle; what is in front of this has the vehicle's numbers. */
struct now { /* of each curve the row of the voltage below a call's, and the share of the next row */
    int row[CURVES];
    SCALAR up[CURVES];
};

static void find(SCALAR volts, struct now *now)
{
#if LAW
    (void)volts;
    now->row[0] = 0;
    now->up[0] = ZERO;
#else
    for (int c = 0; c < CURVES; c++) {
        const int last = rows[c + 1] - 1;
        int row = rows[c];
        while (row < last && volts >= row_volts[row + 1]) {
            row++;
        }
        now->row[c] = row;
        now->up[c] = row == last || !(volts > row_volts[row]) ? ZERO
                     : (volts - row_volts[row]) / (row_volts[row + 1] - row_volts[row]);
    }
#endif
}

#if !LAW
/* The piece of a row on which thrust f lies; the outermost have no end. */
static const struct piece *lies(int row, SCALAR f)
{
    const SCALAR place = (f - spans[row].first) * spans[row].per;
    const int cell = place > ZERO ? (place < CELLS - 1 ? (int)place : CELLS - 1) : 0;
    const struct piece *piece = &pieces[cells[row][cell]], *const last = &pieces[cells[row][cell + 2]];
    while (piece < last && f >= piece[1].f) {
        piece++;
    }
    return piece;
}
#endif

/* Current of thruster i at thrust f [A], and its slope [A/N]. */
static SCALAR amps(const struct now *now, int i, SCALAR f, SCALAR *slope)
{
#if LAW
    const SCALAR size = f < ZERO ? -f : f, factor = f < ZERO ? -astern[i] : ahead[i];
    const SCALAR rise = size > ZERO ? factor * ROOT(size, i) : ZERO;
    (void)now;
    *slope = power[i] * rise;
    return rise * f;
#else
    const int c = CURVES > 1 ? curve[i] : 0, row = now->row[c];
    const SCALAR up = now->up[c];
    const struct piece *piece = lies(row, f);
    SCALAR current = piece->amps + piece->slope * (f - piece->f);
    *slope = piece->slope;
    if (up > ZERO) {
        piece = lies(row + 1, f);
        current += up * (piece->amps + piece->slope * (f - piece->f) - current);
        *slope += up * (piece->slope - *slope);
    }
    return current;
#endif
}

/* Current of all thrusters at f + t step [A], and its slope in t. */
static SCALAR total(const struct now *now, const SCALAR f[N], const SCALAR step[N], SCALAR t, SCALAR *slope)
{
    SCALAR current = ZERO;
    *slope = ZERO;
    for (int i = 0; i < N; i++) {
        SCALAR rise;
        current += amps(now, i, f[i] + t * step[i], &rise);
        *slope += rise * step[i];
    }
    return current;
}

struct point { /* thrusts on the path, their current [A], the part of the demand they are of, and what they make */
    SCALAR f[N], amps, at, share[LEVELS];
};

/* Part of the chord from a point within a cap to one beyond at which the current is the cap, after so many of
 * Newton's steps. The current is convex, so that a step ends beyond, and steps from there come nearer. They
 * begin about where it would be if current grew with the power 3/2 of thrust. */
static SCALAR reaches(const struct now *now, SCALAR cap, SCALAR near, const struct point *within,
                      const struct point *beyond, int steps)
{
    const SCALAR rises = beyond->amps - within->amps, left = cap - within->amps;
    SCALAR step[N], slope, t;
    if (!(left > ZERO)) {
        return ZERO;
    }
    t = (rises + 5 * left) / (5 * rises + left);
    for (int i = 0; i < N; i++) {
        step[i] = beyond->f[i] - within->f[i];
    }
    for (int k = 0; k < steps; k++) {
        const SCALAR over = total(now, within->f, step, t, &slope) - cap, before = t;
        if ((over <= near && (k > 0 || over >= -near)) || !(slope > ZERO)) {
            break;
        }
        t -= over / slope;
        t = t > ZERO ? (t < ONE ? t : ONE) : ZERO;
        if (t == before) { /* by rounding */
            break;
        }
    }
    return t;
}

/* The point between two. */
static void mix(const struct point *within, const struct point *beyond, SCALAR t, struct point *mixed)
{
    for (int i = 0; i < N; i++) {
        mixed->f[i] = within->f[i] + t * (beyond->f[i] - within->f[i]);
    }
    mixed->at = within->at + t * (beyond->at - within->at);
    for (int l = 0; l < LEVELS; l++) {
        mixed->share[l] = within->share[l] + t * (beyond->share[l] - within->share[l]);
    }
}

ENTRY
{
    static const SCALAR none[N] = {ZERO};
    struct now now;
    struct point within, beyond, found, chord;
    SCALAR low[N], high[N], begin[K], asked[K], part[LEVELS], slope;
    const SCALAR near = SPARE * cap, goal = cap - HALF * near;
    int is_straight = STRAIGHT, rests = 1, status;
    if (!(cap - cap == ZERO && volts - volts == ZERO)) {
        return TB_NOT_FINITE;
    }
    status = ALLOCATE(tau, beyond.f, beyond.share);
    if (status != TB_SOLVED && status != TB_PARTIAL) {
        return status;
    }
    find(volts, &now);
    beyond.at = ZERO;
    for (int l = 0; l < LEVELS; l++) {
        beyond.at = beyond.share[l] > beyond.at ? beyond.share[l] : beyond.at;
        within.share[l] = ZERO;
    }
    beyond.amps = total(&now, beyond.f, none, ZERO, &slope);
    if (beyond.amps <= cap) {
        for (int i = 0; i < N; i++) {
            f[i] = beyond.f[i];
        }
        for (int l = 0; l < LEVELS; l++) {
            share[l] = beyond.share[l];
        }
        return status;
    }
    for (int i = 0; i < N; i++) { /* rest, or where limits exclude it a little inside the nearer one */
        const int off = i == fault || !ready[i];
        const SCALAR least = off ? ZERO : f_min[i], most = off ? ZERO : f_max[i];
        const SCALAR away = least > -most ? least : -most, width = (most - least) * INSET;
        const SCALAR inset = away > ZERO ? (width < away ? width : away) : ZERO;
        const SCALAR up = least + inset > ZERO ? least + inset : ZERO;
        low[i] = least;
        high[i] = most;
        within.f[i] = up < most - inset ? up : most - inset;
        rests &= within.f[i] == ZERO;
        is_straight &= TOUCHES_NOT(beyond.f[i], least, most);
    }
    within.at = ZERO;
    within.amps = rests && NOTHING_AT_REST ? ZERO : total(&now, within.f, none, ZERO, &slope);
    if (!(within.amps <= cap)) {
        return TB_INFEASIBLE;
    }
    is_straight &= rests;
    for (int r = 0; r < K; r++) {
        begin[r] = ZERO;
        for (int i = 0; i < N && !rests; i++) {
            begin[r] += T[r][i] * within.f[i];
        }
    }
    if (!rests) {
        status = ALLOCATE(begin, within.f, part);
        if (status != TB_SOLVED && status != TB_PARTIAL) {
            return status;
        }
        within.amps = total(&now, within.f, none, ZERO, &slope);
    }
    /* Thrusts are linear in the share between the points where one of them meets a limit. So where a point
     * of the path lies on the chord, the chord is the path. */
    for (int k = 0; k < STEPS && !is_straight; k++) {
        const SCALAR along = k % 3 < 2 ? reaches(&now, goal, near / 4, &within, &beyond, 2) : HALF;
        int is_inside = STRAIGHT && rests;
        mix(&within, &beyond, along, &chord);
        if (!(chord.at > within.at && chord.at < beyond.at)) {
            break;
        }
        for (int r = 0; r < K; r++) {
            asked[r] = begin[r] + chord.at * (tau[r] - begin[r]);
        }
        status = ALLOCATE(asked, found.f, part);
        if (status != TB_SOLVED && status != TB_PARTIAL) {
            break;
        }
        found.at = chord.at;
        for (int l = 0; l < LEVELS; l++) {
            found.share[l] = found.at * part[l];
        }
        is_straight = 1;
        for (int i = 0; i < N; i++) {
            const SCALAR apart = found.f[i] - chord.f[i];
            is_straight &= apart <= BENT && apart >= -BENT;
            is_inside &= TOUCHES_NOT(found.f[i], low[i], high[i]);
        }
        if (is_straight) {
            break;
        }
        if (is_inside) { /* no limit is met from rest on, and none up to the first one */
            SCALAR far = beyond.at / found.at;
            for (int i = 0; i < N; i++) {
                const SCALAR x = found.f[i];
                if (x > ZERO && far * x > high[i]) {
                    far = high[i] / x;
                } else if (x < ZERO && far * x < low[i]) {
                    far = low[i] / x;
                }
            }
            for (int i = 0; i < N; i++) {
                const SCALAR x = far * found.f[i];
                found.f[i] = x < low[i] ? low[i] : x > high[i] ? high[i] : x;
            }
            found.at *= far;
            for (int l = 0; l < LEVELS; l++) {
                found.share[l] *= far;
            }
        }
        found.amps = total(&now, found.f, none, ZERO, &slope);
        if (found.amps > cap) {
            beyond = found;
            is_straight = is_inside;
        } else {
            within = found;
            if (within.amps >= cap - near) {
                break;
            }
        }
    }
    if (is_straight) {
        mix(&within, &beyond, reaches(&now, goal, near / 4, &within, &beyond, NEWTON), &found);
        within = found;
    }
    for (int i = 0; i < N; i++) {
        f[i] = within.f[i];
    }
    for (int l = 0; l < LEVELS; l++) {
        share[l] = within.share[l];
    }
    return TB_PARTIAL;
}
