/* thrustbench_allocator.h: what an allocator exports so that thrustbench can ask, judge and time it.
 *
 * Copy this file, write what it declares and is not optional in C, C++ or Rust, build a shared library, and name it:
 *
 *     cc -O2 -shared -fPIC my_allocator.c -o my_allocator.so
 *     thrustbench run --vehicle bluerov2-heavy --plugin my_allocator.so --method nullspace --quick
 *
 * Each struct begins with its size as its writer knows it. Later versions append members: never read or write one
 * beyond `size`. A pointer to what is not known is NULL. Neither side
 * frees what the other allocated; what a call gets is valid during the call.
 *
 * SPDX-License-Identifier: MIT
 */
#ifndef THRUSTBENCH_ALLOCATOR_H
#define THRUSTBENCH_ALLOCATOR_H

#include <stddef.h>

#ifdef TBA_FLOAT /* define it for all files of a library in single precision */
typedef float tba_real;
#else
typedef double tba_real;
#endif

/* What tba_interface returns: the version of this file, and the size of the library's numbers. */
#define TBA_INTERFACE (0x100 + (int)sizeof(tba_real))

/* What tba_call returns; any other number counts as TBA_NOT_CONVERGED. */
enum {
    TBA_SOLVED = 0,       /* f makes tau */
    TBA_PARTIAL = 1,      /* f makes a part of tau */
    TBA_INFEASIBLE = 2,   /* there is no such f, or f_min lies above f_max; f is not read */
    TBA_NOT_CONVERGED = 3 /* no answer was found; f is not read */
};

struct tba_vehicle {
    size_t size;
    int k, n;                     /* controlled axes, 1 to 6, and thrusters */
    const tba_real *T;            /* k rows of n: thrusts to wrench, forces [-], moments [m] */
    const tba_real *H;            /* n rows of n: the effort f'Hf that is least */
    const tba_real *readiness;    /* n: 1 ready, 0 off, between them weakened; f makes T diag(readiness) f */
    const tba_real *f_min, *f_max; /* n: limits [N]; both 0 for a thruster that is off */
    const int *level;             /* k: the priority of each axis, 0 what must hold first */
    const char *const *dof;       /* k: surge, sway, heave, roll, pitch, yaw */
    const char *frame;            /* frd: y to starboard, z down; flu: y to port, z up */
    const char *name;
};

struct tba_input {
    size_t size;
    const tba_real *tau;           /* k: the wanted wrench [N, N m] */
    const tba_real *f_min, *f_max; /* n: limits of this call [N], both or neither; NULL: the vehicle's */
    const tba_real *f_previous;    /* n: thrusts of the call before [N] */
    const tba_real *f_desired;     /* n: thrusts that are preferred [N]; NULL: 0 */
    const tba_real *cap;           /* 1: the most current of all thrusters together [A]; NULL: none */
    const tba_real *volts;         /* 1: voltage of the battery [V]; NULL: the nominal one */
};

struct tba_output {
    size_t size;
    tba_real *f;     /* n: thrusts [N] */
    tba_real *share; /* one a level, 0 to 1: what f makes of tau; NULL unless the promised formulation has shares */
    tba_real *residual; /* k: T diag(readiness) f - tau [N, N m], written with each f or never */
};

struct tba_promise {
    size_t size;
    const char *formulation; /* whose right answer f is, as `thrustbench list` names it; NULL: a rule of its own */
    int limited;             /* whether each f lies inside the limits */
    double tolerance;        /* how far f may be from the right answer, over the largest limit */
    int capped;              /* whether each f keeps a cap; else no call has one */
};

#ifdef __cplusplus
extern "C" {
#endif

/* TBA_INTERFACE, as this library was compiled. */
int tba_interface(void);

/* An allocator for a vehicle, or NULL and *reason, a text that outlives the call. The struct and what it points to
 * stay as they are as long as the allocator is called. */
void *tba_prepare(const struct tba_vehicle *vehicle, const char **reason);

/* The thrusts for one wrench. Calls come one after the other; the answer depends on this call's input alone, to the
 * bit, unless tba_reset is there. What is timed is this function on its caller's arrays (floats are converted) and
 * one copy of f; one call of 256, and the first 256, get all in copies between guards. */
int tba_call(void *allocator, const struct tba_input *input, struct tba_output *output);

/* Optional: what answers are held to. Without it, no more than to stay within the largest limit of the least-effort
 * thrusts where those fit. */
const struct tba_promise *tba_promises(void);

/* Optional, for an allocator with a memory, as a warm start is: forget all calls. Such a one is judged cold, with a
 * reset before each call, and warm, without. */
void tba_reset(void *allocator);

/* Optional: from now on each thruster is as ready as this says (n: 1 ready, 0 off, between them weakened), without
 * preparing anew; an answer other than 0 refuses it. A thruster that is off has limits of 0, whatever tba_prepare got.
 * Where it is there, a vehicle with a failure is prepared whole and told the failure by it. */
int tba_fault(void *allocator, const tba_real *readiness);

/* Optional: answers `count` calls at once, as that many tba_call do. The arrays of call i begin at i times their
 * length (tau + i * k, f + i * n …), and its status is status[i]. */
void tba_many(void *allocator, int count, const struct tba_input *input, struct tba_output *output, int *status);

/* Optional: the allocator will not be called again. */
void tba_free(void *allocator);

#ifdef __cplusplus
}
#endif

#endif
