// ALLOCATOR (QPAllocator or PseudoinverseAllocator) of vortexntnu/vortex-auv behind thrustbench_allocator.h.
//
// Its ROS node scales a wrench down first, then cuts thrusts at the limits, both by functions of its own that are
// called here in the same order. The limits are those it was made with: it takes none of the call.
#include "thrust_allocator_auv/pseudoinverse_allocator.hpp"
#include "thrust_allocator_auv/qp_allocator.hpp"
#include "thrust_allocator_auv/thrust_allocator_utils.hpp"
#include "thrustbench_allocator.h"

namespace {
constexpr double SLACK_WEIGHT = 2000.0; // auv_setup/config/robots/orca.yaml

struct Made {
    Eigen::VectorXd low, high, widest;
    ALLOCATOR allocator;
};
} // namespace

extern "C" {
int tba_interface(void)
{
    return TBA_INTERFACE;
}

void *tba_prepare(const tba_vehicle *vehicle, const char **reason)
{
    const int k = vehicle->k, n = vehicle->n;
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const Eigen::Map<const Eigen::VectorXd> ready(vehicle->readiness, n), low(vehicle->f_min, n), high(vehicle->f_max, n);
    AllocatorConfig config;
    config.extended_thrust_matrix = Eigen::Map<const Rows>(vehicle->T, k, n) * ready.asDiagonal();
    config.min_force = low;
    config.max_force = high;
    config.input_weight_matrix = Eigen::MatrixXd::Identity(n, n);
    config.slack_weight_matrix = SLACK_WEIGHT * Eigen::MatrixXd::Identity(k, k);
    try {
        return new Made{low, high, compute_max_wrench(config.extended_thrust_matrix, low, high), ALLOCATOR(config)};
    } catch (const std::exception &) {
        *reason = "it raises an exception for this matrix";
        return nullptr;
    }
}

int tba_call(void *allocator, const tba_input *input, tba_output *output)
try {
    auto &made = *static_cast<Made *>(allocator);
    const Eigen::Map<const Eigen::VectorXd> tau(input->tau, made.widest.size());
    const Eigen::VectorXd wanted = normalize_wrench_vector(tau, made.widest);
    const auto found = made.allocator.calculate_allocated_thrust(wanted);
    if (!found) {
        return TBA_NOT_CONVERGED;
    }
    for (int i = 0; i < found->size(); i++) {
        output->f[i] = std::min(std::max((*found)[i], made.low[i]), made.high[i]);
    }
    return TBA_PARTIAL;
} catch (const std::exception &) { // CasADi's, which its node does not catch
    return TBA_NOT_CONVERGED;
}
}
