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
    int first = begins[row], last = begins[row + 1] - 1;
    while (first < last) {
        const int middle = first + (last - first + 1) / 2;
        if (f >= pieces[middle].f) {
            first = middle;
        } else {
            last = middle - 1;
        }
    }
    return &pieces[first];
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
    const int row = now->row[curve[i]];
    const SCALAR up = now->up[curve[i]];
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

/* Part of the chord from thrusts within a cap to others beyond at which their current is the cap. The current
 * is convex, so that Newton's steps from beyond stay there. */
static SCALAR reaches(const struct now *now, SCALAR cap, SCALAR near, const SCALAR within[N], const SCALAR beyond[N])
{
    SCALAR step[N], slope, t = ONE;
    for (int i = 0; i < N; i++) {
        step[i] = beyond[i] - within[i];
    }
    for (int k = 0; k < NEWTON; k++) {
        const SCALAR over = total(now, within, step, t, &slope) - cap;
        if (over <= near || !(slope > ZERO)) {
            break;
        }
        t -= over / slope;
        if (!(t > ZERO)) {
            return ZERO;
        }
    }
    return t;
}

ENTRY
{
    static const SCALAR none[N] = {ZERO};
    struct now now;
    SCALAR within[N], beyond[N], found[N], begin[K], asked[K];
    SCALAR least = ZERO, most = ZERO, part = ONE, delivered = ZERO, slope;
    const SCALAR near = SPARE * cap;
    int is_straight = STRAIGHT, rests = 1, status;
    if (!(cap - cap == ZERO && volts - volts == ZERO)) {
        return TB_NOT_FINITE;
    }
    status = ALLOCATE(tau, beyond, &most);
    if (status != TB_SOLVED && status != TB_PARTIAL) {
        return status;
    }
    find(volts, &now);
    if (total(&now, beyond, none, ZERO, &slope) <= cap) {
        for (int i = 0; i < N; i++) {
            f[i] = beyond[i];
        }
        share[0] = most;
        return status;
    }
    for (int i = 0; i < N; i++) { /* rest, or where limits exclude it a little inside the nearer one */
        const int off = i == fault || !ready[i];
        const SCALAR low = off ? ZERO : f_min[i], high = off ? ZERO : f_max[i];
        const SCALAR away = low > -high ? low : -high, width = (high - low) * INSET;
        const SCALAR inset = away > ZERO ? (width < away ? width : away) : ZERO;
        const SCALAR up = low + inset > ZERO ? low + inset : ZERO;
        within[i] = up < high - inset ? up : high - inset;
        rests &= within[i] == ZERO;
        /* Rounding may leave a thrust that is at a limit just inside of it. */
        is_straight &= (low + TOUCH < beyond[i] && beyond[i] < high - TOUCH) || beyond[i] == ZERO;
    }
    if (!(total(&now, within, none, ZERO, &slope) <= cap)) {
        return TB_INFEASIBLE;
    }
    is_straight &= rests;
    for (int r = 0; r < K; r++) {
        begin[r] = ZERO;
        for (int i = 0; i < N && !rests; i++) {
            begin[r] += T[r][i] * within[i];
        }
    }
    if (!rests) {
        status = ALLOCATE(begin, within, &part);
        if (status != TB_SOLVED && status != TB_PARTIAL) {
            return status;
        }
    }
    /* Thrusts are linear in the share between the points where one of them meets a limit. */
    for (int k = 0; k < STEPS; k++) {
        const SCALAR along = k % 3 < 2 ? reaches(&now, cap - HALF * near, near / 4, within, beyond) : HALF;
        const SCALAR at = least + along * (most - least);
        SCALAR over;
        if (!(at > least && at < most)) {
            break;
        }
        if (is_straight) {
            part = ONE;
            for (int i = 0; i < N; i++) {
                found[i] = within[i] + along * (beyond[i] - within[i]);
            }
        } else {
            for (int r = 0; r < K; r++) {
                asked[r] = begin[r] + at * (tau[r] - begin[r]);
            }
            status = ALLOCATE(asked, found, &part);
            if (status != TB_SOLVED && status != TB_PARTIAL) {
                break;
            }
        }
        over = total(&now, found, none, ZERO, &slope) - cap;
        for (int i = 0; i < N; i++) {
            *(over > ZERO ? &beyond[i] : &within[i]) = found[i];
        }
        if (over > ZERO) {
            most = at;
        } else {
            least = at;
            delivered = at * part;
            if (over >= -near) {
                break;
            }
        }
    }
    for (int i = 0; i < N; i++) {
        f[i] = within[i];
    }
    share[0] = delivered;
    return TB_PARTIAL;
}
