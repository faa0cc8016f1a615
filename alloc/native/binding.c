/* Calls a generated kernel from Python with as little in between as CPython allows.
 *
 * One callable type, vehicle-independent: it holds the kernel's address, takes tau through the
 * vectorcall protocol, and makes the Allocation (a tuple subclass) without running Python code. Anything
 * but a plain float64 array of numbers up to LARGEST_DEMAND goes through alloc.allocation.checked, which
 * decides and words the errors for every method alike.
 */
#define PY_SSIZE_T_CLEAN
#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <Python.h>
#include <stddef.h>
#include <structmember.h>

#include <numpy/arrayobject.h>

typedef int (*kernel)(const double *tau, int fault, double *f);

enum { FIRST_WITHOUT_THRUST = 2, STATUSES = 4 };

typedef struct {
    PyObject_HEAD
    vectorcallfunc vectorcall;
    kernel solve;
    int fault;
    int k;
    int n;
    PyTypeObject *allocation;
    PyObject *statuses[STATUSES];
    PyObject *checked;
    PyObject *checked_many;
    PyObject *iterations;
    PyObject *solver_s;
    PyObject *share;
    PyObject *formulation;
    PyObject *limited;
    PyObject *tolerance;
    PyObject *worst_case_steps;
    PyObject *library;
} Native;

static int is_plain(PyObject *object, int ndim, npy_intp last)
{
    if (!PyArray_CheckExact(object)) {
        return 0;
    }
    PyArrayObject *array = (PyArrayObject *)object;
    return PyArray_NDIM(array) == ndim && PyArray_TYPE(array) == NPY_DOUBLE && PyArray_ISCARRAY_RO(array) &&
           PyArray_DIM(array, ndim - 1) == last;
}

static int all_fit(const double *values, npy_intp count)
{
    int fit = 1; /* NaN compares false, so it does not fit */
    for (npy_intp i = 0; i < count; i++) {
        fit &= (values[i] <= LARGEST_DEMAND) & (values[i] >= -LARGEST_DEMAND);
    }
    return fit;
}

/* A new reference to object, or to what `check` makes of it, as a contiguous array; NULL with an error set. */
static PyArrayObject *demand(PyObject *object, PyObject *check, int ndim, int k)
{
    if (is_plain(object, ndim, k) && all_fit(PyArray_DATA((PyArrayObject *)object),
                                             PyArray_SIZE((PyArrayObject *)object))) {
        Py_INCREF(object);
        return (PyArrayObject *)object;
    }
    PyObject *made = PyObject_CallFunction(check, "Oi", object, k);
    if (made == NULL) {
        return NULL;
    }
    PyObject *plain = PyArray_FROM_OTF(made, NPY_DOUBLE, NPY_ARRAY_CARRAY_RO);
    Py_DECREF(made);
    return (PyArrayObject *)plain;
}

static int solve(const Native *self, const double *tau, double *f)
{
    const int status = self->solve(tau, self->fault, f);
    if (status >= FIRST_WITHOUT_THRUST) {
        for (int i = 0; i < self->n; i++) {
            f[i] = Py_NAN;
        }
    }
    return status;
}

static PyObject *native_call(PyObject *callable, PyObject *const *args, size_t nargsf, PyObject *names)
{
    const Native *self = (const Native *)callable;
    if (PyVectorcall_NARGS(nargsf) != 1 || (names != NULL && PyTuple_GET_SIZE(names) != 0)) {
        PyErr_SetString(PyExc_TypeError, "an allocator takes one argument, tau");
        return NULL;
    }
    PyArrayObject *tau = demand(args[0], self->checked, 1, self->k);
    if (tau == NULL) {
        return NULL;
    }
    npy_intp n = self->n;
    PyObject *f = PyArray_SimpleNew(1, &n, NPY_DOUBLE);
    PyObject *answer = f != NULL ? self->allocation->tp_alloc(self->allocation, 5) : NULL;
    if (answer == NULL) {
        Py_XDECREF(f);
        Py_DECREF(tau);
        return NULL;
    }
    const int status = solve(self, PyArray_DATA(tau), PyArray_DATA((PyArrayObject *)f));
    Py_DECREF(tau);
    PyTuple_SET_ITEM(answer, 0, f);
    PyTuple_SET_ITEM(answer, 1, Py_NewRef(self->statuses[status]));
    PyTuple_SET_ITEM(answer, 2, Py_NewRef(self->iterations));
    PyTuple_SET_ITEM(answer, 3, Py_NewRef(self->solver_s));
    PyTuple_SET_ITEM(answer, 4, Py_NewRef(self->share));
    return answer;
}

static PyObject *native_many(PyObject *object, PyObject *argument)
{
    const Native *self = (const Native *)object;
    PyArrayObject *taus = demand(argument, self->checked_many, 2, self->k);
    if (taus == NULL) {
        return NULL;
    }
    npy_intp shape[2] = {PyArray_DIM(taus, 0), self->n};
    PyObject *F = PyArray_SimpleNew(2, shape, NPY_DOUBLE);
    PyObject *statuses = PyArray_SimpleNew(1, shape, NPY_INT8);
    if (F == NULL || statuses == NULL) {
        Py_XDECREF(F);
        Py_XDECREF(statuses);
        Py_DECREF(taus);
        return NULL;
    }
    const double *tau = PyArray_DATA(taus);
    double *f = PyArray_DATA((PyArrayObject *)F);
    npy_int8 *status = PyArray_DATA((PyArrayObject *)statuses);
    Py_BEGIN_ALLOW_THREADS
    for (npy_intp i = 0; i < shape[0]; i++) {
        status[i] = (npy_int8)solve(self, tau + i * self->k, f + i * self->n);
    }
    Py_END_ALLOW_THREADS
    Py_DECREF(taus);
    return Py_BuildValue("NN", F, statuses);
}

static PyObject *native_new(PyTypeObject *type, PyObject *args, PyObject *names)
{
    static char *keys[] = {"address", "fault", "k", "n", "allocation", "statuses", "checked",
                           "checked_many", "iterations", "solver_s", "share", "formulation", "limited", "tolerance",
                           "worst_case_steps", "library", NULL};
    Native *self = (Native *)type->tp_alloc(type, 0);
    PyObject *address, *statuses;
    if (self == NULL || !PyArg_ParseTupleAndKeywords(
                            args, names, "O!iiiO!O!OOOOOOOOOO", keys, &PyLong_Type, &address, &self->fault,
                            &self->k, &self->n, &PyType_Type, &self->allocation, &PyTuple_Type, &statuses,
                            &self->checked, &self->checked_many, &self->iterations, &self->solver_s, &self->share,
                            &self->formulation, &self->limited, &self->tolerance, &self->worst_case_steps,
                            &self->library)) {
        /* The fields are still borrowed references: free the object without releasing them. */
        if (self != NULL) {
            type->tp_free(self);
            Py_DECREF(type);
        }
        return NULL;
    }
    void *code = PyLong_AsVoidPtr(address);
    memcpy(&self->solve, &code, sizeof code);
    self->vectorcall = native_call;
    for (int i = 0; i < STATUSES; i++) {
        self->statuses[i] = Py_NewRef(PyTuple_GetItem(statuses, i));
    }
    PyObject *held[] = {(PyObject *)self->allocation, self->checked, self->checked_many, self->iterations,
                        self->solver_s, self->share, self->formulation, self->limited, self->tolerance,
                        self->worst_case_steps, self->library};
    for (size_t i = 0; i < sizeof held / sizeof held[0]; i++) {
        Py_INCREF(held[i]);
    }
    return (PyObject *)self;
}

static void native_dealloc(PyObject *object)
{
    Native *self = (Native *)object;
    PyTypeObject *type = Py_TYPE(object);
    PyObject *held[] = {(PyObject *)self->allocation, self->checked, self->checked_many, self->iterations,
                        self->solver_s, self->share, self->formulation, self->limited, self->tolerance,
                        self->worst_case_steps, self->library};
    for (size_t i = 0; i < sizeof held / sizeof held[0]; i++) {
        Py_DECREF(held[i]);
    }
    for (int i = 0; i < STATUSES; i++) {
        Py_DECREF(self->statuses[i]);
    }
    type->tp_free(object);
    Py_DECREF(type);
}

static PyMemberDef members[] = {
    {"__vectorcalloffset__", T_PYSSIZET, offsetof(Native, vectorcall), READONLY, NULL},
    {"formulation", T_OBJECT_EX, offsetof(Native, formulation), READONLY, "Which optimum it returns."},
    {"limited", T_OBJECT_EX, offsetof(Native, limited), READONLY, "Whether f is promised inside the limits."},
    {"tolerance", T_OBJECT_EX, offsetof(Native, tolerance), READONLY, "Promised distance to the optimum."},
    {"worst_case_steps", T_OBJECT_EX, offsetof(Native, worst_case_steps), READONLY,
     "Steps no demand exceeds; None where the method has none."},
    {NULL, 0, 0, 0, NULL},
};

static PyMethodDef methods[] = {
    {"many", native_many, METH_O, "Allocate taus (N, k): thrusts (N, n) [N] and statuses (N,)."},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot slots[] = {
    {Py_tp_doc, "A generated kernel as an allocator."},
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
    PyObject *module = PyModule_Create(&definition);
    PyObject *type = module != NULL ? PyType_FromSpec(&spec) : NULL;
    if (type == NULL || PyModule_AddObject(module, "Native", type) < 0) {
        Py_XDECREF(type);
        Py_XDECREF(module);
        return NULL;
    }
    return module;
}
