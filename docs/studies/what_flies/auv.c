/* alloc_wrench_to_thrust, or another FUNCTION of AUV-Thruster-Allocation, behind thrustbench_allocator.h.
 *
 * Its matrix is that of `tiburon`, constant, and its thrusts lie in -1 to 1: it takes no other vehicle, no fault,
 * and no limits of the call.
 */
#include <math.h>
#include <string.h>

#include "alloc_v2.h"
#include "thrustbench_allocator.h"

uint8_t FUNCTION(const float wrench[ALLOC_N_DOF], float thrust[ALLOC_N_THR]);

int tba_interface(void)
{
    return TBA_INTERFACE;
}

void *tba_prepare(const struct tba_vehicle *vehicle, const char **reason)
{
    static char made;
    int fits = strcmp(vehicle->name, "tiburon") == 0;
    for (int i = 0; fits && i < vehicle->n; i++) {
        fits = vehicle->readiness[i] == 1 && vehicle->f_min[i] == -1 && vehicle->f_max[i] == 1;
    }
    *reason = "its matrix is that of tiburon with all thrusters";
    return fits ? &made : NULL;
}

int tba_call(void *allocator, const struct tba_input *input, struct tba_output *output)
{
    (void)allocator;
    return FUNCTION(input->tau, output->f) == 0 ? TBA_SOLVED : TBA_PARTIAL;
}
