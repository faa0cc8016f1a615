// FUNCTION (DP_LPCA or DPscaled_LPCA) of mengchaoheng/control_allocation behind thrustbench_allocator.h.
//
// Its sizes are those of a template: six axes and eight thrusters here. Limits are part of what it is made from, so
// limits of the call make another one.
#include <cstring>

#include "ControlAllocation.h"
#include "thrustbench_allocator.h"

namespace {
constexpr int K = 6, N = 8;
using Theirs = DP_LP_ControlAllocator<K, N>;

struct Made {
    float B[K][N];
    Theirs allocator;
};

Theirs within(const float (&B)[K][N], const tba_real *f_min, const tba_real *f_max)
{
    float low[N], high[N];
    for (int i = 0; i < N; i++) {
        low[i] = f_min[i];
        high[i] = f_max[i];
    }
    return Theirs(Aircraft<K, N>(B, high, low));
}

int answer(Theirs &allocator, const tba_real *tau, tba_real *f)
{
    float wanted[K], u[N], centred[N], rho = 0;
    for (int j = 0; j < K; j++) {
        wanted[j] = tau[j];
    }
    int error = 0;
    allocator.FUNCTION(wanted, u, error, rho);
    allocator.restoring(u, centred);
    for (int i = 0; i < N; i++) {
        f[i] = centred[i];
    }
    return error < 0 ? TBA_NOT_CONVERGED : TBA_PARTIAL; // above 0 its page promises the direction still
}
} // namespace

extern "C" {
int tba_interface(void)
{
    return TBA_INTERFACE;
}

void *tba_prepare(const tba_vehicle *vehicle, const char **reason)
{
    if (vehicle->k != K || vehicle->n != N) {
        *reason = "it is built for 6 axes and 8 thrusters";
        return nullptr;
    }
    float B[K][N];
    for (int j = 0; j < K; j++) {
        for (int i = 0; i < N; i++) {
            B[j][i] = vehicle->T[j * N + i] * vehicle->readiness[i];
        }
    }
    auto *made = new Made{{}, within(B, vehicle->f_min, vehicle->f_max)};
    std::memcpy(made->B, B, sizeof B);
    return made;
}

int tba_call(void *allocator, const tba_input *input, tba_output *output)
{
    auto &made = *static_cast<Made *>(allocator);
    if (input->f_min == nullptr) {
        return answer(made.allocator, input->tau, output->f);
    }
    Theirs other = within(made.B, input->f_min, input->f_max);
    return answer(other, input->tau, output->f);
}
}
