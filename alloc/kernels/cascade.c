/* What thrusts may do, f + Z z + E e: z moves them without a wrench, e [rows of T P of unit length] is the wrench that they miss. */
static const SCALAR OWN_Z[N][D] = NULL_SPACE;
static const SCALAR OWN_E[N][K] = INVERSE;
enum { OWN_LEAVES = 2 }; /* in on[]: found beyond a limit, and yet to freeze */
static const SCALAR OWN_least[N][2] = LEAST; /* of a row's length squared: what is no more is rounding */

/* Thruster j stays at `end`. The shortest e that takes it there, and for that the shortest z, move the others;
 * what then is left to them is orthogonal to what it could do, as a Gram-Schmidt process makes rows. */
static void OWN_leave(int j, SCALAR end, const int on[N], SCALAR Z[N][D], SCALAR E[N][K], SCALAR f[N])
{
    const SCALAR by = end - f[j];
    SCALAR of_z = ZERO, of_e = ZERO;
    //each D const SCALAR z_ = Z[j][_];
    //each K const SCALAR e_ = E[j][_];
    //each D of_z += z_ * z_;
    //each K of_e += e_ * e_;
    if (of_z > OWN_least[j][0]) {
        const SCALAR each = ONE / of_z;
        for (int i = 0; i < N; i++) {
            if (on[i]) {
                SCALAR along = ZERO;
                //each D along += Z[i][_] * z_;
                along *= each;
                //each D Z[i][_] -= along * z_;
                //each K E[i][_] -= along * e_;
                f[i] += along * by;
            }
        }
    } else if (of_e > OWN_least[j][1]) {
        const SCALAR each = ONE / of_e;
        for (int i = 0; i < N; i++) {
            if (on[i]) {
                SCALAR along = ZERO;
                //each K along += E[i][_] * e_;
                along *= each;
                //each K E[i][_] -= along * e_;
                f[i] += along * by;
            }
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
    int on[N], more = 0, leaving = 0;
    //full SCALAR MOVED[N];
    for (int i = 0; i < N; i++) {
        more |= working[i] && !(f[i] >= low[i] - SPARE && f[i] <= high[i] + SPARE);
    }
    if (!more) {
        return;
    }
    for (int i = 0; i < N; i++) {
        on[i] = 1;
        end[i] = ZERO;
        //full MOVED[i] = f[i];
        //each D Z[i][_] = OWN_Z[i][_];
        //each K E[i][_] = OWN_E[i][_];
    }
    for (int j = 0; j < N; j++) {
        if (!working[j]) {
            on[j] = 0;
            OWN_leave(j, ZERO, on, Z, E, MOVED);
        }
    }
    for (int turn = 0; turn < N; turn++) { /* each freezes one, all those that one look finds before the next look */
        int j = 0;
        if (!leaving) {
            //each N if (on[_] && !(f[_] >= low[_] - SPARE && f[_] <= high[_] + SPARE)) { on[_] = OWN_LEAVES; end[_] = f[_] < low[_] ? low[_] : high[_]; leaving++; }
        }
        if (!leaving) {
            return;
        }
        //each N j = on[_] == OWN_LEAVES ? _ : j;
        leaving--;
        on[j] = 0;
        OWN_leave(j, end[j], on, Z, E, MOVED);
        //full OWN_alone(on, Z, MOVED, f);
    }
}
