// Shaped like a subclass of PX4's ControlAllocation, against a stand-in of our own for its header: what PX4 knows of
// the vehicle arrives in setEffectivenessMatrix, also after a failure, and allocate() answers within today's limits.
#include "ControlAllocation.hpp"
#include "libthrustbench.h"

#include <cstdio>
#include <type_traits>

static_assert(std::is_same<tb_real, float>::value, "PX4 calculates in single precision: compile all with TB_FLOAT");

class ControlAllocationExact : public ControlAllocation
{
public:
    void setEffectivenessMatrix(const EffectivenessMatrix &effectiveness, const ActuatorVector &trim,
                                const ActuatorVector &linearization_point, int num_actuators,
                                bool update_normalization_scale) override
    {
        ControlAllocation::setEffectivenessMatrix(effectiveness, trim, linearization_point, num_actuators,
                                                  update_normalization_scale);
        tb_real T[NUM_AXES * TB_N_MAX];
        const int n = num_actuators <= TB_N_MAX ? num_actuators : 0; // 0: refused, and said so by allocate()
        for (int r = 0; r < NUM_AXES; r++) {
            for (int i = 0; i < n; i++) {
                T[r * n + i] = effectiveness(r, i);
            }
        }
        tb_prepare(&_allocator, NUM_AXES, n, T, nullptr, nullptr, _actuator_min.data(), _actuator_max.data());
        const int level[NUM_AXES] = {0, 0, 2, 1, 1, 0}; // roll, pitch and heave first, yaw last
        tb_levels(&_allocator, level);
    }

    void allocate() override
    {
        tb_real f[TB_N_MAX], low[TB_N_MAX], high[TB_N_MAX];
        for (int i = 0; i < _num_actuators && i < TB_N_MAX; i++) { // limits of this moment, about the trim
            low[i] = _actuator_min[i] - _actuator_trim[i];
            high[i] = _actuator_max[i] - _actuator_trim[i];
        }
        status = tb_priority(&_allocator, _control_sp.data(), low, high, f, share);
        for (int i = 0; i < _num_actuators && i < TB_N_MAX; i++) {
            _actuator_sp[i] = _actuator_trim[i] + (status == TB_SOLVED || status == TB_PARTIAL ? f[i] : 0);
        }
    }

    // What the rate controllers' integrators are told not to wind up for.
    ControlVector unallocated() const
    {
        ControlVector rest = _control_sp;
        const ControlVector made = getAllocatedControl();
        for (int r = 0; r < NUM_AXES; r++) {
            rest[r] -= made[r];
        }
        return rest;
    }

    int status{TB_BAD_ARGUMENT};
    tb_real share[TB_K_MAX]{};

private:
    tb_allocator _allocator{};
};

int main()
{
    const float T[6][8] = {
        {0, 0, 0, 0, -0.21805f, 0.21805f, -0.21805f, 0.21805f}, {0, 0, 0, 0, -0.12f, -0.12f, 0.12f, 0.12f},
        {0.1888f, -0.1888f, -0.1888f, 0.1888f, 0, 0, 0, 0},     {-0.707f, -0.707f, 0.707f, 0.707f, 0, 0, 0, 0},
        {0.707f, -0.707f, 0.707f, -0.707f, 0, 0, 0, 0},         {0, 0, 0, 0, 1, 1, 1, 1},
    };
    static ControlAllocationExact allocation;
    ControlAllocation::EffectivenessMatrix B;
    ControlAllocation::ActuatorVector low{}, high{}, zero{};
    for (int i = 0; i < 8; i++) {
        low[i] = -40;
        high[i] = 60;
        for (int r = 0; r < 6; r++) {
            B(r, i) = T[r][i];
        }
    }
    allocation.setActuatorMin(low);
    allocation.setActuatorMax(high);
    ControlAllocation::ControlVector control{};
    control[0] = 4;
    control[2] = 25;
    control[3] = 90;
    control[5] = 120;
    allocation.setControlSetpoint(control);
    for (int failed = -1; failed < 1; failed++) { // whole, then without thruster 0, as PX4 tells it: a column of zeros
        for (int r = 0; r < 6 && failed >= 0; r++) {
            B(r, failed) = 0;
        }
        allocation.setEffectivenessMatrix(B, zero, zero, 8, true);
        allocation.allocate();
        std::printf("%d", allocation.status);
        for (int l = 0; l < 3; l++) {
            std::printf(" %.9g", static_cast<double>(allocation.share[l]));
        }
        for (int i = 0; i < 8; i++) {
            std::printf(" %.9g", static_cast<double>(allocation.getActuatorSetpoint()[i]));
        }
        for (float rest : allocation.unallocated()) {
            std::printf(" %.9g", static_cast<double>(rest));
        }
        std::printf("\n");
    }
    return 0;
}
