/* Thruster i's share of the wrench that is left, where i and those of a set may move; sets without i, as bits, in order. */
static const SCALAR OWN_aims[N][SETS][COLUMNS] = AIMS;
static const SCALAR OWN_T[N][K] = COLUMNS_OF_T;
static const SCALAR OWN_per_axis[K] = PER_AXIS;

static SCALAR OWN_cut(SCALAR x, SCALAR low, SCALAR high)
{
    return x < low ? low : x > high ? high : x;
}

static SCALAR OWN_size(SCALAR x)
{
    return x < ZERO ? -x : x;
}

/* The thrust that thruster i would take of the wrench that is left, were it free beside those that are. */
static SCALAR OWN_aim(int i, int free, const SCALAR rest[K], SCALAR f)
{
    const SCALAR *const row = OWN_aims[i][(free >> (i + 1) << i) | (free & ((1 << i) - 1))];
    SCALAR sum = free >> i & 1 ? ZERO : row[K] * f;
    //each K sum += row[_] * rest[_];
    return sum;
}

/* The aims of all, which the free ones have of what those that are held leave of tau. */
static void OWN_all_aims(const SCALAR tau[K], const SCALAR f[N], int free, SCALAR aim[N])
{
    SCALAR rest[K];
    //each K rest[_] = tau[_];
    for (int i = 0; i < N; i++) {
        if (!(free >> i & 1)) {
            const SCALAR held = f[i];
            //each K rest[_] -= OWN_T[i][_] * held;
        }
    }
    //each N aim[_] = OWN_aim(_, free, rest, f[_]);
}

/* Frees the held thruster that is farthest from its aim, by more than slack; 0 where there is none, and f is the optimum.
 * Before that all go to the aims of the free ones, or as far as the first limit in the way, whose thruster is then held. */
static int OWN_step(const SCALAR tau[K], const SCALAR low[N], const SCALAR high[N], const int working[N], SCALAR slack, int *free, SCALAR f[N])
{
    SCALAR aim[N], most = ONE;
    int first = -1;
    OWN_all_aims(tau, f, *free, aim);
    for (int i = 0; i < N; i++) {
        if (*free >> i & 1) {
            const SCALAR end = OWN_cut(aim[i], low[i], high[i]);
            if (!(OWN_size(aim[i] - end) <= slack)) {
                const SCALAR share = (end - f[i]) / (aim[i] - f[i]);
                if (first < 0 || !(share >= most)) {
                    first = i;
                    most = share;
                }
            }
        }
    }
    for (int i = 0; i < N; i++) {
        if (*free >> i & 1) {
            f[i] = OWN_cut(first < 0 ? aim[i] : f[i] + most * (aim[i] - f[i]), low[i], high[i]);
        }
    }
    if (first >= 0) {
        f[first] = OWN_cut(aim[first], low[first], high[first]);
        *free &= ~(1 << first);
        return 1;
    }
    most = slack;
    for (int i = 0; i < N; i++) {
        if (working[i] && !(*free >> i & 1)) {
            const SCALAR away = OWN_size(OWN_cut(aim[i], low[i], high[i]) - f[i]);
            if (!(away <= most)) {
                first = i;
                most = away;
            }
        }
    }
    if (first >= 0) {
        *free |= 1 << first;
    }
    return first >= 0;
}

/* The f whose every entry is its aim cut at the limits; f[N] is 0 then, and 1 where that takes more than N TURNS steps. */
static void OWN_weighted(const SCALAR tau[K], const SCALAR low[N], const SCALAR high[N], const int working[N], SCALAR f[N + 1])
{
    SCALAR aim[N], slack, most = ZERO, asked = ZERO;
    int free = 0, all = 0;
    //each N all |= working[_] ? 1 << _ : 0;
    OWN_all_aims(tau, f, all, aim);
    for (int j = 0; j < K; j++) {
        const SCALAR size = OWN_size(tau[j] * OWN_per_axis[j]);
        asked = size > asked ? size : asked;
    }
    for (int i = 0; i < N; i++) {
        if (working[i]) {
            f[i] = OWN_cut(aim[i], low[i], high[i]);
            most = OWN_size(f[i]) > most ? OWN_size(f[i]) : most;
        }
    }
    slack = ROUNDED * (most + F_SCALE * (ONE + asked));
    for (int i = 0; i < N; i++) {
        free |= (working[i] && OWN_size(aim[i] - f[i]) <= slack ? 1 : 0) << i;
    }
    f[N] = ZERO;
    if (free == all) {
        return;
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < TURNS; j++) {
            if (!OWN_step(tau, low, high, working, slack, &free, f)) {
                return;
            }
        }
    }
    f[N] = ONE;
}
