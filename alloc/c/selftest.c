/* The same for every kernel; in front of this stand the cases and a vehicle's numbers. */

/* True if thrusts f, less others, make another wrench than tau, by more than a part of the most. */
static int misses(const SCALAR *f, const SCALAR *less, const SCALAR *tau, SCALAR part)
{
    int bad = 0;
    for (int r = 0; r < K; r++) {
        SCALAR wrench = ZERO;
        for (int j = 0; j < N; j++) {
            wrench += T[r][j] * (less ? f[j] - less[j] : f[j]);
        }
        wrench -= tau ? tau[r] : ZERO;
        bad |= !(wrench <= part * most[r] && -wrench <= part * most[r]);
    }
    return bad;
}

#if LEVELS
static SCALAR effort(const SCALAR *f)
{
    SCALAR sum = ZERO;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            sum += f[i] * H[i][j] * f[j];
        }
    }
    return sum;
}

/* True if thrusts f make the wrench of others, inside limits, with no more effort. */
static int as_good(const SCALAR *f, const SCALAR *other, const SCALAR *f_min, const SCALAR *f_max)
{
    int good = !misses(f, other, NULL, SAME_WRENCH);
    good &= effort(f) <= effort(other) * SAME_EFFORT;
    for (int j = 0; j < N; j++) {
        good &= !(f[j] < f_min[j]) && !(f[j] > f_max[j]); /* NaN is the limit of one that is off */
    }
    return good;
}
#endif

static SCALAR difference(SCALAR a, SCALAR b)
{
    return a - b < ZERO ? b - a : a - b;
}

int main(void)
{
    const size_t count = sizeof cases / sizeof cases[0];
    SCALAR worst = ZERO;
    unsigned long undecided = 0;
    int wrong = 0;
    SCALAR f[N];
#if LEVELS
    SCALAR share[LEVELS];
#endif
    for (size_t i = 0; i < count; i++) {
        for (int j = 0; j < N; j++) {
            f[j] = UNTOUCHED;
        }
#if LEVELS
        for (int j = 0; j < LEVELS; j++) {
            share[j] = UNTOUCHED;
        }
#endif
        const int status = CALL(cases[i]);
        int bad = status == TB_SOLVED && misses(f, NULL, cases[i].tau, ONE);
        if (cases[i].undecided) {
            undecided++;
        } else {
            bad |= status != cases[i].status && status != cases[i].other;
            bad |= (status == TB_SOLVED || status == TB_PARTIAL) && misses(f, cases[i].f, NULL, ONE);
            int apart = 0;
            for (int j = 0; j < N; j++) {
                const SCALAR error = difference(f[j], cases[i].f[j]);
                worst = error > worst ? error : worst;
                bad |= !(error <= JUMP);
                apart |= !(error <= cases[i].allowed);
            }
#if LEVELS
            apart = apart && !(status == TB_PARTIAL && as_good(f, cases[i].f, LIMITS(cases[i])));
            for (int j = 0; j < LEVELS; j++) {
                bad |= !(difference(share[j], cases[i].share[j]) <= cases[i].allowed_share);
            }
#endif
            bad |= apart;
        }
        if (bad) {
            printf("case %lu, fault %d: status %d, expected %d\n", (unsigned long)i, cases[i].fault,
                   status, cases[i].status);
            wrong++;
        }
    }
    printf("%s: %lu cases, %lu asked", NAME, (unsigned long)count, (unsigned long)count - undecided);
    if (undecided) {
        printf(", %lu undecided because rounding alone changes status or thrusts", undecided);
    }
    printf("; %d wrong, largest error %.3g N\n", wrong, (double)worst);
    printf("made with %s.h and %s.c of SHA-256 %s\n", NAME, NAME, DIGEST);
    return wrong != 0;
}
