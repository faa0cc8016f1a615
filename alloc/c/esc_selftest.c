/* The same for every vehicle; in front of this stand the cases and a vehicle's numbers. */

#if AT_CALL
/* Limits as NAME_to_esc cuts them: a thrust beyond its curve makes the end of that. */
static void cut(const struct call *one, SCALAR low[N], SCALAR high[N])
{
    SCALAR bottom[N], top[N], least[N], most[N];
    COMMAND command[N];
    for (int j = 0; j < N; j++) {
        bottom[j] = -BEYOND;
        top[j] = BEYOND;
    }
    SEND(bottom, bottom, top, one->volts, command, least);
    SEND(top, bottom, top, one->volts, command, most);
    for (int j = 0; j < N; j++) {
        const SCALAR a = one->f_min[j], b = one->f_max[j];
        const int crossed = !(a <= b);
        low[j] = crossed ? a : a < least[j] ? least[j] : a > most[j] ? most[j] : a;
        high[j] = crossed ? b : b < least[j] ? least[j] : b > most[j] ? most[j] : b;
    }
}
#endif

/* True if NAME_esc sends or makes something else than a case says. */
static int differs(const struct call *one, SCALAR *worst)
{
    SCALAR made[N];
    COMMAND command[N];
    const int status = SEND(one->f, one->f_min, one->f_max, one->volts, command, made);
    int bad = status != one->status;
    for (int j = 0; j < N; j++) {
        const SCALAR apart = made[j] - one->made[j], error = apart < ZERO ? -apart : apart;
        *worst = error > *worst ? error : *worst;
        bad |= command[j] < one->command[j] - NEAR || command[j] > one->command[j] + NEAR;
        bad |= !(error <= ALLOWED);
    }
    if (bad) {
        printf("status %d, expected %d: ", status, one->status);
    }
    return bad;
}

/* True if NAME_to_esc does something else for a wrench than the kernel and NAME_esc after each other. */
static int parts(const struct call *one, const SCALAR tau[K], int fault)
{
    SCALAR f[N], made[N], other[N];
    COMMAND command[N], sent[N];
#if LEVELS
    SCALAR share[LEVELS];
#endif
#if AT_CALL
    SCALAR low[N], high[N];
    cut(one, low, high);
#endif
    const int found = ALLOCATE(tau, low, high, fault, f, share);
    const int both = ALLOCATE_AND_SEND(tau, one->f_min, one->f_max, fault, one->volts, sent, other, share);
    const int answered = found == TB_SOLVED || found == TB_PARTIAL;
    const int apart = answered ? SEND(f, one->f_min, one->f_max, one->volts, command, made) : found;
    int bad = answered ? fault < 0 && both != (apart == TB_SOLVED ? found : apart) : both != found;
    for (int j = 0; j < N; j++) {
        const COMMAND expected = answered && j != fault ? command[j] : neutral[j];
        const SCALAR makes = answered && j != fault ? made[j] : ZERO;
        bad |= sent[j] < expected || sent[j] > expected || other[j] < makes || other[j] > makes;
    }
    return bad;
}

int main(void)
{
    const size_t count = sizeof cases / sizeof cases[0];
    SCALAR tau[K], worst = ZERO;
    int wrong = 0;
    for (size_t i = 0; i < count; i++) {
        const int fault = (int)(i % (FAULTS + 2)) - 1; /* the last there is not */
        if (differs(&cases[i], &worst)) {
            printf("case %lu\n", (unsigned long)i);
            wrong++;
        }
        for (int j = 0; j < K; j++) {
            tau[j] = cases[i].f[j % N] * (i % 3 == 0 ? ONE : TENTH); /* some can't be met */
        }
        if (parts(&cases[i], tau, fault)) {
            printf("case %lu: both calls after each other do something else\n", (unsigned long)i);
            wrong++;
        }
    }
    printf("%s_esc: %lu cases; %d wrong, largest error %.3g N\n", NAME, (unsigned long)count, wrong, (double)worst);
    return wrong != 0;
}
