/* What thrusts may do, f + Z z + E e: z moves them without a wrench, e [rows of T P of unit length] is the wrench that they miss. */
static const SCALAR OWN_Z[N][D] = NULL_SPACE;
static const SCALAR OWN_E[N][K] = INVERSE;
static const SCALAR OWN_least[N][2] = LEAST; /* of a row's length squared: what is no more is rounding */

/* Thruster j stays at `end`. The shortest e that takes it there, and for that the shortest z, move the others;
 * what then is left to them is orthogonal to what it could do, as a Gram-Schmidt process makes rows. */
static void OWN_leave(int j, SCALAR end, const int on[N], SCALAR Z[N][D], SCALAR E[N][K], SCALAR f[N])
{
    SCALAR of_z = ZERO, of_e = ZERO;
    for (int m = 0; m < D; m++) {
        of_z += Z[j][m] * Z[j][m];
    }
    for (int r = 0; r < K; r++) {
        of_e += E[j][r] * E[j][r];
    }
    const int freely = of_z > OWN_least[j][0];
    const SCALAR each = freely ? ONE / of_z : of_e > OWN_least[j][1] ? ONE / of_e : ZERO;
    for (int i = 0; i < N; i++) {
        SCALAR along = ZERO;
        if (on[i]) {
            for (int m = 0; m < D && freely; m++) {
                along += Z[i][m] * Z[j][m];
            }
            for (int r = 0; r < K && !freely; r++) {
                along += E[i][r] * E[j][r];
            }
            along *= each;
            for (int m = 0; m < D && freely; m++) {
                Z[i][m] -= along * Z[j][m];
            }
            for (int r = 0; r < K; r++) {
                E[i][r] -= along * E[j][r];
            }
            f[i] += along * (end - f[j]);
        }
    }
    f[j] = end;
}

//full static const SCALAR OWN_H[N][N] = HESSIAN;
//full 
//full /* y has the least effort of all thrusts; f that of the free ones alone, as if H did not couple them with others. */
//full static void OWN_alone(const int on[N], SCALAR Z[N][D], const SCALAR y[N], SCALAR f[N])
//full {
//full     SCALAR z[D];
//full     for (int m = 0; m < D; m++) {
//full         z[m] = ZERO;
//full         for (int i = 0; i < N; i++) {
//full             for (int j = 0; j < N && on[i]; j++) {
//full                 z[m] += on[j] ? ZERO : Z[i][m] * OWN_H[i][j] * y[j];
//full             }
//full         }
//full     }
//full     for (int i = 0; i < N; i++) {
//full         f[i] = y[i];
//full         for (int m = 0; m < D && on[i]; m++) {
//full             f[i] += Z[i][m] * z[m];
//full         }
//full     }
//full }
//full 
/* Thrusts beyond a limit by more than rounding freeze there, and the free thrusters share what is left of tau, until all are inside.
 * At most N freeze, each for 2 (N + 1) (D + K) products at most where H couples none. */
static void OWN_cascade(const SCALAR low[N], const SCALAR high[N], const int working[N], SCALAR f[N])
{
    SCALAR Z[N][D], E[N][K], end[N];
    int on[N], leaving[N], more = 0;
    //full SCALAR MOVED[N];
    for (int i = 0; i < N; i++) {
        more |= working[i] && !(f[i] >= low[i] - SPARE && f[i] <= high[i] + SPARE);
    }
    if (!more) {
        return;
    }
    more = 0;
    for (int i = 0; i < N; i++) {
        on[i] = 1;
        leaving[i] = 0;
        end[i] = ZERO;
        //full MOVED[i] = f[i];
        for (int m = 0; m < D; m++) {
            Z[i][m] = OWN_Z[i][m];
        }
        for (int r = 0; r < K; r++) {
            E[i][r] = OWN_E[i][r];
        }
    }
    for (int j = 0; j < N; j++) {
        if (!working[j]) {
            on[j] = 0;
            OWN_leave(j, ZERO, on, Z, E, MOVED);
        }
    }
    for (int turn = 0; turn < N; turn++) { /* each freezes one, all those that one look finds before the next look */
        int j = 0;
        for (int i = 0; i < N && !more; i++) {
            leaving[i] = on[i] && !(f[i] >= low[i] - SPARE && f[i] <= high[i] + SPARE);
            end[i] = f[i] < low[i] ? low[i] : high[i];
        }
        more = 0;
        for (int i = 0; i < N; i++) {
            more += leaving[i];
            j = leaving[i] ? i : j;
        }
        if (!more) {
            return;
        }
        on[j] = 0;
        leaving[j] = 0;
        more--;
        OWN_leave(j, end[j], on, Z, E, MOVED);
        //full OWN_alone(on, Z, MOVED, f);
    }
}
