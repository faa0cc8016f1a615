static const SCALAR OWN_A[K][N] = TP; /* rows of unit length */
static const SCALAR OWN_H[N][N] = HESSIAN;
static const SCALAR OWN_unit[K] = UNITS;

/* Least-effort thrusts over free thrusters that push nearest to `rest`, by two Gram-Schmidt processes.
 *
 * With H = L D L' over the free thrusters and w = L'f, effort is w'Dw and the wrench B w, B = A L'^-1. Rows of B,
 * the longest left over first, become orthogonal rows Q in the metric 1/D, B = R Q: what is left of the others
 * once a row is below RANK of the longest is rounding. Then w = D^-1 Q'y, and y makes R D' y nearest to rest,
 * which orthogonal columns of R answer. No square root is needed.
 */
static void OWN_shared(SCALAR rest[K], const int on[N], SCALAR f[N])
{
    SCALAR L[N][N], D[N], B[K][N], R[K][K], S[K][K], t[K], y[K], q2[K];
    int order[K], taken[K] = {0}, rank = 0;
    SCALAR longest = ZERO;
    for (int i = 0; i < N; i++) {
        D[i] = on[i] ? OWN_H[i][i] : ONE;
        for (int j = 0; j < i; j++) {
            SCALAR left = on[i] && on[j] ? OWN_H[i][j] : ZERO;
            for (int m = 0; m < j; m++) {
                left -= L[i][m] * L[j][m] * D[m];
            }
            L[i][j] = left / D[j];
            D[i] -= L[i][j] * left;
        }
    }
    for (int r = 0; r < K; r++) {
        for (int i = 0; i < N; i++) {
            SCALAR left = on[i] ? OWN_A[r][i] : ZERO;
            for (int m = 0; m < i; m++) {
                left -= L[i][m] * B[r][m];
            }
            B[r][i] = left;
        }
    }
    /*@ split rank; */ /* tells Frama-C to look at each rank by itself; compilers skip it */
    while (rank < K) {
        int next = -1;
        SCALAR most2 = RANK * longest;
        for (int r = 0; r < K; r++) {
            SCALAR size2 = ZERO;
            for (int i = 0; i < N && !taken[r]; i++) {
                size2 += B[r][i] * B[r][i] / D[i];
            }
            if (size2 > most2) {
                most2 = size2;
                next = r;
            }
        }
        if (next < 0) {
            break;
        }
        longest = rank ? longest : most2;
        taken[next] = 1;
        order[rank] = next;
        q2[rank] = most2;
        for (int r = 0; r < K; r++) {
            SCALAR along = r == next ? ONE : ZERO;
            for (int i = 0; i < N && !taken[r]; i++) {
                along += B[r][i] * B[next][i] / D[i] / most2;
            }
            for (int i = 0; i < N && !taken[r]; i++) {
                B[r][i] -= along * B[next][i];
            }
            R[r][rank] = along;
        }
        rank++;
    }
    for (int j = 0; j < rank; j++) {
        SCALAR size2 = ZERO;
        t[j] = ZERO;
        for (int r = 0; r < K; r++) {
            size2 += R[r][j] * R[r][j];
            t[j] += R[r][j] * rest[r];
        }
        t[j] /= size2;
        for (int r = 0; r < K; r++) {
            rest[r] -= t[j] * R[r][j];
        }
        for (int m = j + 1; m < rank; m++) {
            S[j][m] = ZERO;
            for (int r = 0; r < K; r++) {
                S[j][m] += R[r][j] * R[r][m] / size2;
            }
            for (int r = 0; r < K; r++) {
                R[r][m] -= S[j][m] * R[r][j];
            }
        }
    }
    for (int j = rank - 1; j >= 0; j--) {
        y[j] = t[j];
        for (int m = j + 1; m < rank; m++) {
            y[j] -= S[j][m] * y[m];
        }
    }
    for (int i = N - 1; i >= 0; i--) {
        f[i] = ZERO;
        for (int j = 0; j < rank; j++) {
            f[i] += y[j] / q2[j] * B[order[j]][i] / D[i];
        }
        for (int m = i + 1; m < N; m++) {
            f[i] -= L[m][i] * f[m];
        }
    }
}

/* Thrusts beyond a limit by more than rounding freeze there, and the free thrusters share what is left of tau, until all are inside. */
static void OWN_cascade(const SCALAR tau[K], const SCALAR low[N], const SCALAR high[N], const int working[N], SCALAR f[N])
{
    SCALAR frozen[N] = {ZERO}, rest[K];
    int on[N];
    for (int i = 0; i < N; i++) {
        on[i] = working[i];
    }
    for (int pass = 0; pass < N; pass++) {
        int more = 0;
        for (int i = 0; i < N; i++) {
            if (on[i] && !(f[i] >= low[i] - SPARE && f[i] <= high[i] + SPARE)) {
                frozen[i] = f[i] < low[i] ? low[i] : high[i];
                on[i] = 0;
                more = 1;
            }
        }
        if (!more) {
            return;
        }
        for (int r = 0; r < K; r++) {
            rest[r] = tau[r] * OWN_unit[r];
            for (int i = 0; i < N; i++) {
                rest[r] -= OWN_A[r][i] * frozen[i];
            }
        }
        OWN_shared(rest, on, f);
        for (int i = 0; i < N; i++) {
            f[i] = on[i] ? f[i] : frozen[i];
        }
    }
}
