// A stand-in, written here, for PX4's class of this name: as much of its shape as px4.cpp asks for, and none of its code.
#pragma once

#include <array>

namespace matrix
{
template <int N> struct Vector : std::array<float, N> {
};
template <int M, int N> struct Matrix {
    float data[M][N] = {};
    float operator()(int r, int i) const { return data[r][i]; }
    float &operator()(int r, int i) { return data[r][i]; }
};
} // namespace matrix

class ControlAllocation
{
public:
    static constexpr int NUM_ACTUATORS = 16;
    static constexpr int NUM_AXES = 6; // roll, pitch, yaw, thrust x, y, z
    using ActuatorVector = matrix::Vector<NUM_ACTUATORS>;
    using ControlVector = matrix::Vector<NUM_AXES>;
    using EffectivenessMatrix = matrix::Matrix<NUM_AXES, NUM_ACTUATORS>;

    virtual ~ControlAllocation() = default;
    virtual void allocate() = 0;
    virtual void setEffectivenessMatrix(const EffectivenessMatrix &effectiveness, const ActuatorVector &trim,
                                        const ActuatorVector &linearization_point, int num_actuators,
                                        bool update_normalization_scale)
    {
        (void)linearization_point;
        (void)update_normalization_scale;
        _effectiveness = effectiveness;
        _actuator_trim = trim;
        _num_actuators = num_actuators;
    }
    void setActuatorMin(const ActuatorVector &min) { _actuator_min = min; }
    void setActuatorMax(const ActuatorVector &max) { _actuator_max = max; }
    void setControlSetpoint(const ControlVector &control) { _control_sp = control; }
    const ActuatorVector &getActuatorSetpoint() const { return _actuator_sp; }
    ControlVector getAllocatedControl() const
    {
        ControlVector made{};
        for (int r = 0; r < NUM_AXES; r++) {
            for (int i = 0; i < _num_actuators; i++) {
                made[r] += _effectiveness(r, i) * (_actuator_sp[i] - _actuator_trim[i]);
            }
        }
        return made;
    }

protected:
    EffectivenessMatrix _effectiveness{};
    ActuatorVector _actuator_trim{}, _actuator_min{}, _actuator_max{}, _actuator_sp{};
    ControlVector _control_sp{};
    int _num_actuators{0};
};
