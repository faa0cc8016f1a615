/* Calls generated kernels from Python with as little in between as CPython allows.
 *
 * One callable type, vehicle-independent: it holds the addresses of a method's two kernels, one with the
 * vehicle's limits in it and one that takes those of the call, takes its arguments through the vectorcall
 * protocol, and makes the Allocation (a tuple subclass) without running Python code. Anything but plain float64
 * arrays of numbers up to LARGEST_DEMAND goes through the functions that check the arguments of every method
 * alike, which decide and word the errors.
 */
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <structmember.h>

#include <numpy/arrayobject.h>

typedef int (*fixed_kernel)(const double *tau, int fault, double *f);
typedef int (*call_kernel)(const double *tau, const double *f_min, const double *f_max, int fault, double *f);
typedef int (*fixed_levels)(const double *tau, int fault, double *f, double *share);
typedef int (*call_levels)(const double *tau, const double *f_min, const double *f_max, int fault, double *f,
                           double *share);
typedef int (*context_kernel)(const void *context, const double *tau, const double *f_min, const double *f_max,
                              double *f, double *share);
/* What a call may have beside its demand and limits; NULL where it is left out. */
struct more {
    const double *f_previous, *f_desired, *cap, *volts;
};
typedef int (*more_kernel)(const void *context, const double *tau, const double *f_min, const double *f_max,
                           const struct more *more, double *f, double *share);
typedef void (*abreast)(const double *tau, const double *f_min, const double *f_max, long step, double *f,
                        signed char *status);
typedef void (*context_abreast)(const void *context, const double *tau, const double *f_min, const double *f_max,
                                long step, double *f, signed char *status);

enum { WHOLE = -1 }; /* the fault of a vehicle as it is: its own faults are in the C */
enum { FIRST_WITHOUT_THRUST = 2, LAST_STATUS = 3, MOST_LEVELS = 16 };

/* Python objects that an allocator holds, in the order of `fields`. */
enum {
    ALLOCATION, CHECKED, CHECKED_MANY, LIMITS, LIMITS_MANY, F_MIN, F_MAX, STATUSES, ITERATIONS, SOLVER_S,
    NO_SHARE, RESIDUAL, FORMULATION, LIMITED, TOLERANCE, WORST_CASE_STEPS, LIBRARY, TOGETHER, THRUSTS,
    SUPPLY, STATED_RESIDUAL, PLACES, RESTS, MIDDLES, HELD
};
static const char *const fields[HELD] = {
    "allocation", "checked", "checked_many", "limits", "limits_many", "f_min", "f_max", "statuses", "iterations",
    "solver_s", "no_share", "residual", "formulation", "limited", "tolerance", "worst_case_steps", "library",
    "together", "thrusts", "supply", "stated_residual", "places", "rests", "middles",
};

typedef struct {
    PyObject_HEAD
    vectorcallfunc vectorcall;
    void *fixed;
    void *call;
    void *context; /* first argument of `call`, which then answers both forms of limits, as `side_by_side` does; or NULL */
    void *more; /* the same with what a call may have more; NULL for a method that takes nothing more */
    void *side_by_side[2]; /* the same for ABREAST demands, once asked for and where there is code for that */
    int asked[2];
    int k;
    int n;
    int levels;
    int state;
    double nothing; /* force up to which a thruster that turns has no angle */
    PyObject *held[HELD];
} Native;

enum { TAU, LOW, HIGH, PREVIOUS, DESIRED, CAP, VOLTS, ARGUMENTS };
static const char *const argument[ARGUMENTS] = {"tau", "f_min", "f_max", "f_previous", "f_desired", "cap", "volts"};
static PyObject *argument_name[ARGUMENTS];

static int is_plain(PyObject *object, int ndim, npy_intp last)
{
    if (!PyArray_CheckExact(object)) {
        return 0;
    }
    PyArrayObject *array = (PyArrayObject *)object;
    return PyArray_NDIM(array) == ndim && PyArray_TYPE(array) == NPY_DOUBLE && PyArray_ISCARRAY_RO(array) &&
           PyArray_DIM(array, ndim - 1) == last;
}

/* Whether all entries are numbers up to LARGEST_DEMAND: as integers, sizes of doubles have the order of their
 * values, and infinity and NaN lie above them all. A difference below zero sets the sign, without a branch. */
static int fit(const double *values, npy_intp count)
{
    const double largest = LARGEST_DEMAND;
    uint64_t most, beyond = 0;
    memcpy(&most, &largest, sizeof most);
    for (npy_intp i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, values + i, sizeof bits);
        beyond |= most - (bits & (UINT64_MAX >> 1));
    }
    return beyond >> 63 == 0;
}

static int all_fit(PyObject *array)
{
    return fit(PyArray_DATA((PyArrayObject *)array), PyArray_SIZE((PyArrayObject *)array));
}

/* `made` as a contiguous array; takes the reference. */
static PyArrayObject *contiguous(PyObject *made)
{
    PyObject *plain = made != NULL ? PyArray_FROM_OTF(made, NPY_DOUBLE, NPY_ARRAY_CARRAY_RO) : NULL;
    Py_XDECREF(made);
    return (PyArrayObject *)plain;
}

/* A new reference to object, or to what `check` makes of it, as a contiguous array; NULL with an error set. */
static PyArrayObject *demand(PyObject *object, PyObject *check, int ndim, int k)
{
    if (is_plain(object, ndim, k) && all_fit(object)) {
        return (PyArrayObject *)Py_NewRef(object);
    }
    return contiguous(PyObject_CallFunction(check, "Oi", object, k));
}

/* The limits of one call, or of `count` calls where that is not negative: new references to contiguous arrays.
 *
 * Returns 0 with an error set where they are refused. A step is what leads from one call's limits to the next's.
 */
static int limits(const Native *self, PyObject *given[2], npy_intp count, PyArrayObject *made[2], npy_intp step[2])
{
    int plain = 1;
    for (int side = 0; side < 2 && plain; side++) {
        PyObject *array = given[side] != Py_None ? given[side] : self->held[F_MIN + side];
        step[side] = 0;
        if (count >= 0 && is_plain(array, 2, self->n) && PyArray_DIM((PyArrayObject *)array, 0) == count) {
            step[side] = self->n;
        } else {
            plain = is_plain(array, 1, self->n);
        }
        plain = plain && all_fit(array);
        made[side] = (PyArrayObject *)array;
    }
    if (plain) {
        Py_INCREF(made[0]);
        Py_INCREF(made[1]);
        return 1;
    }
    PyObject *both = count < 0 ? PyObject_CallFunction(self->held[LIMITS], "OO", given[0], given[1])
                               : PyObject_CallFunction(self->held[LIMITS_MANY], "nOO", count, given[0], given[1]);
    if (both == NULL) {
        return 0;
    }
    for (int side = 0; side < 2; side++) {
        made[side] = contiguous(Py_NewRef(PyTuple_GetItem(both, side)));
        step[side] = count < 0 ? 0 : self->n;
    }
    Py_DECREF(both);
    if (made[0] == NULL || made[1] == NULL) {
        Py_XDECREF(made[0]);
        Py_XDECREF(made[1]);
        return 0;
    }
    return 1;
}

/* The first `most` of a call's arguments; borrowed, None where left out. Returns 0 with an error set. */
static int parsed(PyObject *const *args, Py_ssize_t count, PyObject *names, int most, PyObject *given[ARGUMENTS])
{
    given[0] = NULL;
    for (int i = 1; i < ARGUMENTS; i++) {
        given[i] = Py_None;
    }
    const Py_ssize_t named = names != NULL ? PyTuple_GET_SIZE(names) : 0;
    for (Py_ssize_t i = 0; i < count && i < most; i++) {
        given[i] = args[i];
    }
    int wrong = count > most;
    for (Py_ssize_t i = 0; i < named; i++) {
        PyObject *name = PyTuple_GET_ITEM(names, i);
        int which = 0;
        while (which < most && argument_name[which] != name) {
            which++;
        }
        for (int j = 0; which == most && j < most; j++) { /* a name that was not interned */
            which = PyUnicode_Compare(argument_name[j], name) == 0 ? j : most;
        }
        wrong = wrong || which == most || which < count;
        if (!wrong) {
            given[which] = args[count + i];
        }
    }
    for (Py_ssize_t i = 0; wrong && i < named; i++) {
        PyObject *errors = PyUnicode_CompareWithASCIIString(PyTuple_GET_ITEM(names, i), "cap") == 0
                               ? PyImport_ImportModule("alloc.errors")
                               : NULL;
        PyObject *refusal = errors != NULL ? PyObject_GetAttrString(errors, "DemandError") : NULL;
        Py_XDECREF(errors);
        if (refusal != NULL) {
            PyErr_SetString(refusal, "cap: compiled methods take none; use scaled or frugal");
            Py_DECREF(refusal);
            return 0;
        }
    }
    if (wrong || given[0] == NULL) {
        PyErr_SetString(PyExc_TypeError, "an allocator takes tau and, where they are not the vehicle's, f_min and f_max");
        return 0;
    }
    return 1;
}

static inline int solve(const Native *self, const double *tau, const double *f_min, const double *f_max,
                        const struct more *more, double *f, double *share)
{
    int status;
    if (more != NULL) {
        status = ((more_kernel)self->more)(self->context, tau, f_min, f_max, more, f, share);
    } else if (self->context != NULL) {
        status = ((context_kernel)self->call)(self->context, tau, f_min, f_max, f, share);
    } else if (f_min == NULL) {
        status = self->levels ? ((fixed_levels)self->fixed)(tau, WHOLE, f, share)
                              : ((fixed_kernel)self->fixed)(tau, WHOLE, f);
    } else {
        status = self->levels ? ((call_levels)self->call)(tau, f_min, f_max, WHOLE, f, share)
                              : ((call_kernel)self->call)(tau, f_min, f_max, WHOLE, f);
    }
    if (status >= 0 && status < FIRST_WITHOUT_THRUST) {
        return status;
    }
    for (int i = 0; i < self->n; i++) {
        f[i] = Py_NAN;
    }
    for (int i = 0; i < self->levels; i++) {
        share[i] = 0.0;
    }
    return status < 0 ? LAST_STATUS : status; /* arguments are checked before, so none is negative */
}

/* Row `from` and those behind it, as many as are answered at once; returns how many. */
static npy_intp solve_some(const Native *self, const double *tau, const double *f_min, const double *f_max,
                           const npy_intp step[2], npy_intp left, double *f, npy_int8 *status)
{
    double share[MOST_LEVELS];
    void *const many = self->side_by_side[f_min != NULL];
    if (many == NULL || left < ABREAST || step[0] != step[1]) {
        *status = (npy_int8)solve(self, tau, f_min, f_max, NULL, f, share);
        return 1;
    }
    if (self->context != NULL) {
        ((context_abreast)many)(self->context, tau, f_min, f_max, (long)step[0], f, status);
    } else {
        ((abreast)many)(tau, f_min, f_max, (long)step[0], f, status);
    }
    for (npy_intp i = 0; i < ABREAST; i++) {
        if (status[i] < 0) { /* what it sums up is not finite */
            const double *low = f_min != NULL ? f_min + i * step[0] : NULL;
            const double *high = f_max != NULL ? f_max + i * step[1] : NULL;
            status[i] = (npy_int8)solve(self, tau + i * self->k, low, high, NULL, f + i * self->n, share);
        }
    }
    return ABREAST;
}

/* Has the code for ABREAST demands made, once. Returns 0 with an error set. */
static int ask(Native *self, int at_call)
{
    if (!self->asked[at_call]) {
        PyObject *address = PyObject_CallFunction(self->held[TOGETHER], "s", at_call ? "call" : "fixed");
        if (address == NULL) {
            return 0;
        }
        self->side_by_side[at_call] = PyLong_AsVoidPtr(address);
        self->asked[at_call] = 1;
        Py_DECREF(address);
    }
    return !PyErr_Occurred();
}

static PyObject *shares(const Native *self, const double *share)
{
    PyObject *made = PyTuple_New(self->levels);
    for (int i = 0; made != NULL && i < self->levels; i++) {
        PyTuple_SET_ITEM(made, i, PyFloat_FromDouble(share[i]));
    }
    return made;
}

enum { FIELDS = 10 }; /* of an Allocation */

/* Forces, angles and middles of sectors of thrusters, where some turn, as `alloc.vehicle.azimuth.polar`: of each,
 * `places` has its component along x, and that along y, or -1. Returns 0 with an error set. */
static int turned(const Native *self, const double *f, PyObject *answer)
{
    npy_intp m = PyArray_SIZE((PyArrayObject *)self->held[RESTS]);
    const int *place = PyArray_DATA((PyArrayObject *)self->held[PLACES]);
    const double *rest = PyArray_DATA((PyArrayObject *)self->held[RESTS]);
    double *made[2];
    for (int field = 0; field < 2; field++) {
        PyObject *array = PyArray_SimpleNewFromDescr(1, &m, PyArray_DescrFromType(NPY_DOUBLE));
        if (array == NULL) {
            return 0;
        }
        made[field] = PyArray_DATA((PyArrayObject *)array);
        PyTuple_SET_ITEM(answer, 7 + field, array);
    }
    for (npy_intp i = 0; i < m; i++, place += 2) {
        const int turns = place[1] >= 0;
        const double x = f[place[0]] + 0.0, y = turns ? f[place[1]] + 0.0 : 0.0;
        const double force = turns ? hypot(x, y) : x;
        const int none = turns && force <= self->nothing;
        made[0][i] = none ? 0.0 : force;
        made[1][i] = !turns ? NAN : none ? rest[i] : atan2(y, x) * (180.0 / 3.14159265358979323846);
    }
    PyTuple_SET_ITEM(answer, 9, Py_NewRef(self->held[MIDDLES]));
    return 1;
}

/* The Allocation of one call; limits are NULL where they are the vehicle's, and so is `more` where there is nothing. */
static inline PyObject *answered(const Native *self, const double *tau, const double *f_min, const double *f_max,
                                 const struct more *more)
{
    PyTypeObject *allocation = (PyTypeObject *)self->held[ALLOCATION];
    npy_intp n = self->n;
    PyObject *f = PyArray_SimpleNewFromDescr(1, &n, PyArray_DescrFromType(NPY_DOUBLE));
    PyObject *answer = f != NULL ? allocation->tp_alloc(allocation, FIELDS) : NULL;
    if (answer == NULL) {
        Py_XDECREF(f);
        return NULL;
    }
    double share[MOST_LEVELS];
    const int status = solve(self, tau, f_min, f_max, more, PyArray_DATA((PyArrayObject *)f), share);
    PyTuple_SET_ITEM(answer, 0, f);
    PyTuple_SET_ITEM(answer, 1, Py_NewRef(PyTuple_GET_ITEM(self->held[STATUSES], status)));
    PyTuple_SET_ITEM(answer, 2, Py_NewRef(self->held[ITERATIONS]));
    PyTuple_SET_ITEM(answer, 3, Py_NewRef(self->held[SOLVER_S]));
    PyObject *delivered = self->levels ? shares(self, share) : Py_NewRef(self->held[NO_SHARE]);
    PyTuple_SET_ITEM(answer, 4, delivered);
    PyTuple_SET_ITEM(answer, 5, Py_NewRef(self->held[RESIDUAL]));
    const int turns = self->held[RESTS] != Py_None;
    for (int i = 6; i < (turns ? 7 : FIELDS); i++) { /* no amps either */
        PyTuple_SET_ITEM(answer, i, Py_NewRef(self->held[NO_SHARE]));
    }
    if (delivered == NULL || (turns && !turned(self, PyArray_DATA((PyArrayObject *)f), answer))) {
        Py_CLEAR(answer);
    }
    return answer;
}

/* Thrusts of an argument; NULL where it is left out. Returns 0 with an error set, else `held` is to be released. */
static int thrusts(const Native *self, PyObject *const given[ARGUMENTS], int which, PyArrayObject **held,
                   const double **values)
{
    PyObject *object = given[which];
    if (object == Py_None) {
        return 1;
    }
    *held = is_plain(object, 1, self->n) && all_fit(object)
                ? (PyArrayObject *)Py_NewRef(object)
                : contiguous(PyObject_CallFunction(self->held[THRUSTS], "Ois", object, self->n, argument[which]));
    *values = *held != NULL ? PyArray_DATA(*held) : NULL;
    return *held != NULL;
}

/* The Allocation of a call that has more than its demand and limits. */
static PyObject *answered_more(const Native *self, const double *tau, const double *f_min, const double *f_max,
                               PyObject *const given[ARGUMENTS])
{
    double cap = 0.0, volts = 0.0;
    PyArrayObject *held[2] = {NULL, NULL};
    struct more more = {NULL, NULL, given[CAP] != Py_None ? &cap : NULL, given[VOLTS] != Py_None ? &volts : NULL};
    PyObject *answer = NULL, *supply = NULL;
    int good = thrusts(self, given, PREVIOUS, &held[0], &more.f_previous) &&
               thrusts(self, given, DESIRED, &held[1], &more.f_desired);
    if (good && (more.cap != NULL || more.volts != NULL)) {
        supply = PyObject_CallFunction(self->held[SUPPLY], "OO", given[CAP], given[VOLTS]);
        good = supply != NULL && PyArg_ParseTuple(supply, "dd", &cap, &volts);
    }
    if (good) {
        answer = answered(self, tau, f_min, f_max, &more);
    }
    Py_XDECREF(supply);
    Py_XDECREF(held[0]);
    Py_XDECREF(held[1]);
    return answer;
}

static __attribute__((noinline)) PyObject *called_with(const Native *self, PyObject *const *args, Py_ssize_t count,
                                                       PyObject *names)
{
    PyObject *given[ARGUMENTS], *answer = NULL;
    PyArrayObject *ends[2] = {NULL, NULL};
    npy_intp step[2];
    if (!parsed(args, count, names, self->more != NULL ? ARGUMENTS : PREVIOUS, given)) {
        return NULL;
    }
    int has_more = 0;
    for (int i = PREVIOUS; i < ARGUMENTS; i++) {
        has_more |= given[i] != Py_None;
    }
    PyArrayObject *tau = demand(given[0], self->held[CHECKED], 1, self->k);
    if (tau == NULL) {
        return NULL;
    }
    if ((given[LOW] == Py_None && given[HIGH] == Py_None) || limits(self, given + LOW, -1, ends, step)) {
        const double *low = ends[0] != NULL ? PyArray_DATA(ends[0]) : NULL;
        const double *high = ends[1] != NULL ? PyArray_DATA(ends[1]) : NULL;
        answer = has_more ? answered_more(self, PyArray_DATA(tau), low, high, given)
                          : answered(self, PyArray_DATA(tau), low, high, NULL);
        Py_XDECREF(ends[0]);
        Py_XDECREF(ends[1]);
    }
    Py_DECREF(tau);
    return answer;
}

static PyObject *native_call(PyObject *callable, PyObject *const *args, size_t nargsf, PyObject *names)
{
    const Native *self = (const Native *)callable;
    if (PyVectorcall_NARGS(nargsf) != 1 || names != NULL) {
        return called_with(self, args, PyVectorcall_NARGS(nargsf), names);
    }
    PyArrayObject *tau = demand(args[0], self->held[CHECKED], 1, self->k);
    if (tau == NULL) {
        return NULL;
    }
    PyObject *answer = answered(self, PyArray_DATA(tau), NULL, NULL, NULL);
    Py_DECREF(tau);
    return answer;
}

static PyObject *native_many(PyObject *object, PyObject *const *args, Py_ssize_t count, PyObject *names)
{
    Native *self = (Native *)object;
    PyObject *given[ARGUMENTS];
    if (!parsed(args, count, names, PREVIOUS, given)) {
        return NULL;
    }
    PyArrayObject *ends[2] = {NULL, NULL};
    npy_intp step[2] = {0, 0};
    /* A plain array is looked through in chunks just before they are answered, while they are in the cache. */
    PyArrayObject *taus = is_plain(given[0], 2, self->k) ? (PyArrayObject *)Py_NewRef(given[0])
                                                         : demand(given[0], self->held[CHECKED_MANY], 2, self->k);
    int good = 1;
    if (taus == NULL) {
        return NULL;
    }
    npy_intp shape[2] = {PyArray_DIM(taus, 0), self->n};
    if ((given[1] != Py_None || given[2] != Py_None) && !limits(self, given + 1, shape[0], ends, step)) {
        Py_DECREF(taus);
        return NULL;
    }
    const int ready = shape[0] < ABREAST || ask(self, ends[0] != NULL);
    PyObject *F = ready ? PyArray_SimpleNew(2, shape, NPY_DOUBLE) : NULL;
    PyObject *statuses = ready ? PyArray_SimpleNew(1, shape, NPY_INT8) : NULL;
    if (F != NULL && statuses != NULL) {
        const double *tau = PyArray_DATA(taus);
        const double *low = ends[0] != NULL ? PyArray_DATA(ends[0]) : NULL;
        const double *high = ends[1] != NULL ? PyArray_DATA(ends[1]) : NULL;
        double *f = PyArray_DATA((PyArrayObject *)F);
        npy_int8 *status = PyArray_DATA((PyArrayObject *)statuses);
        /* A library that keeps something between its calls must not be called by two threads at a time. */
        PyThreadState *const free_for_others = self->state ? NULL : PyEval_SaveThread();
        for (npy_intp i = 0, done; i < shape[0] && good; i += done) {
            const npy_intp left = shape[0] - i;
            if (i % ABREAST == 0) {
                good = fit(tau + i * self->k, (left < ABREAST ? left : ABREAST) * self->k);
            }
            done = solve_some(self, tau + i * self->k, low, high, step, left, f + i * self->n, status + i);
            low = low != NULL ? low + done * step[0] : NULL;
            high = high != NULL ? high + done * step[1] : NULL;
        }
        if (free_for_others != NULL) {
            PyEval_RestoreThread(free_for_others);
        }
    }
    if (ready && !good) { /* says which row it is that does not fit */
        Py_XDECREF(PyObject_CallFunction(self->held[CHECKED_MANY], "Oi", taus, self->k));
    }
    Py_DECREF(taus);
    Py_XDECREF(ends[0]);
    Py_XDECREF(ends[1]);
    if (F == NULL || statuses == NULL || !good) { /* an error is set */
        Py_XDECREF(F);
        Py_XDECREF(statuses);
        return NULL;
    }
    return Py_BuildValue("NN", F, statuses);
}

/* Native(fixed, call, context, more, k, n, levels, state, nothing, {field: object}): addresses of the kernels and of what
 * they are called with, sizes, whether calls change data of the library, the force that has no angle, and what
 * `fields` names. */
static PyObject *native_new(PyTypeObject *type, PyObject *args, PyObject *names)
{
    PyObject *fixed, *call, *context, *more, *objects;
    int k, n, levels, state;
    double nothing;
    if (names != NULL ||
        !PyArg_ParseTuple(args, "O!O!O!O!iiipdO!", &PyLong_Type, &fixed, &PyLong_Type, &call, &PyLong_Type, &context,
                          &PyLong_Type, &more, &k, &n, &levels, &state, &nothing, &PyDict_Type, &objects)) {
        return NULL;
    }
    if (levels > MOST_LEVELS) {
        return PyErr_Format(PyExc_ValueError, "%d levels; the binding has room for %d", levels, MOST_LEVELS);
    }
    Native *self = (Native *)type->tp_alloc(type, 0);
    for (int i = 0; self != NULL && i < HELD; i++) {
        PyObject *object = PyDict_GetItemString(objects, fields[i]);
        if (object == NULL) {
            PyErr_SetString(PyExc_KeyError, fields[i]);
            Py_CLEAR(self);
        } else {
            self->held[i] = Py_NewRef(object);
        }
    }
    if (self != NULL) {
        self->fixed = PyLong_AsVoidPtr(fixed);
        self->call = PyLong_AsVoidPtr(call);
        self->context = PyLong_AsVoidPtr(context);
        self->more = PyLong_AsVoidPtr(more);
        self->vectorcall = native_call;
        self->k = k;
        self->n = n;
        self->levels = levels;
        self->state = state;
        self->nothing = nothing;
    }
    return (PyObject *)self;
}

static void native_dealloc(PyObject *object)
{
    PyTypeObject *type = Py_TYPE(object);
    for (int i = 0; i < HELD; i++) {
        Py_XDECREF(((Native *)object)->held[i]);
    }
    type->tp_free(object);
    Py_DECREF(type);
}

static PyMemberDef members[] = {
    {"__vectorcalloffset__", T_PYSSIZET, offsetof(Native, vectorcall), READONLY, NULL},
    {"formulation", T_OBJECT_EX, offsetof(Native, held[FORMULATION]), READONLY, "Which optimum it returns."},
    {"limited", T_OBJECT_EX, offsetof(Native, held[LIMITED]), READONLY, "Whether f is promised inside the limits."},
    {"tolerance", T_OBJECT_EX, offsetof(Native, held[TOLERANCE]), READONLY, "Promised distance to the optimum."},
    {"worst_case_steps", T_OBJECT_EX, offsetof(Native, held[WORST_CASE_STEPS]), READONLY,
     "Steps no demand exceeds; None where the method has none."},
    {"stated_residual", T_OBJECT_EX, offsetof(Native, held[STATED_RESIDUAL]), READONLY,
     "(k,) T P f - tau of the last call, as somebody's library stated it; None for other methods."},
    {NULL, 0, 0, 0, NULL},
};

static PyMethodDef methods[] = {
    {"many", (PyCFunction)(void (*)(void))native_many, METH_FASTCALL | METH_KEYWORDS,
     "Allocate taus (N, k): thrusts (N, n) [N] and statuses (N,); f_min, f_max (n,) or (N, n) [N]."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot slots[] = {
    {Py_tp_doc, "Generated kernels as an allocator."},
    {Py_tp_new, native_new},
    {Py_tp_dealloc, native_dealloc},
    {Py_tp_call, PyVectorcall_Call},
    {Py_tp_methods, methods},
    {Py_tp_members, members},
    {0, NULL},
};

static PyType_Spec spec = {
    "thrustbench_binding.Native",
    sizeof(Native),
    0,
    Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_VECTORCALL,
    slots,
};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "thrustbench_binding", "Calls generated kernels.", -1, NULL, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit_thrustbench_binding(void)
{
    import_array();
    for (int i = 0; i < ARGUMENTS; i++) {
        argument_name[i] = PyUnicode_InternFromString(argument[i]);
    }
    PyObject *module = PyModule_Create(&definition);
    PyObject *type = module != NULL ? PyType_FromSpec(&spec) : NULL;
    if (type == NULL || PyModule_AddObject(module, "Native", type) < 0) {
        Py_XDECREF(type);
        Py_XDECREF(module);
        return NULL;
    }
    return module;
}
