// A plain allocator: f = P T' (T P P T')^-1 tau, each thrust cut at its limit. Put your own in its place.
//
//     cmake -B build && cmake --build build
#include <algorithm>
#include <memory>
#include <vector>

#include "thrustbench_allocator.h"

namespace {

using Matrix = std::vector<std::vector<tba_real>>;

// Inverse of a positive definite matrix by Gauss and Jordan; empty where it has none.
Matrix inverse(Matrix A)
{
    const std::size_t k = A.size();
    for (std::size_t p = 0; p < k; p++) {
        const tba_real pivot = A[p][p];
        if (!(pivot > tba_real(1e-9))) {
            return {};
        }
        A[p][p] = 1;
        for (tba_real &entry : A[p]) {
            entry /= pivot;
        }
        for (std::size_t i = 0; i < k; i++) {
            if (i == p) {
                continue;
            }
            const tba_real factor = A[i][p];
            A[i][p] = 0;
            for (std::size_t j = 0; j < k; j++) {
                A[i][j] -= factor * A[p][j];
            }
        }
    }
    return A;
}

class Allocator {
public:
    explicit Allocator(const tba_vehicle &vehicle)
        : f_min_(vehicle.f_min, vehicle.f_min + vehicle.n), f_max_(vehicle.f_max, vehicle.f_max + vehicle.n)
    {
        const std::size_t k = std::size_t(vehicle.k), n = std::size_t(vehicle.n);
        Matrix TP(k, std::vector<tba_real>(n)), A(k, std::vector<tba_real>(k));
        for (std::size_t j = 0; j < k; j++) {
            for (std::size_t i = 0; i < n; i++) {
                TP[j][i] = vehicle.T[j * n + i] * vehicle.readiness[i];
            }
        }
        for (std::size_t j = 0; j < k; j++) {
            for (std::size_t l = 0; l < k; l++) {
                for (std::size_t i = 0; i < n; i++) {
                    A[j][l] += TP[j][i] * TP[l][i];
                }
            }
        }
        const Matrix I = inverse(A);
        if (I.empty()) {
            return;
        }
        G_.assign(n, std::vector<tba_real>(k));
        for (std::size_t i = 0; i < n; i++) {
            for (std::size_t j = 0; j < k; j++) {
                for (std::size_t l = 0; l < k; l++) {
                    G_[i][j] += TP[l][i] * I[l][j];
                }
            }
        }
    }

    bool works() const { return !G_.empty(); }

    int call(const tba_input &input, tba_output &output) const
    {
        const tba_real *f_min = input.f_min != nullptr ? input.f_min : f_min_.data();
        const tba_real *f_max = input.f_max != nullptr ? input.f_max : f_max_.data();
        int status = TBA_SOLVED;
        for (std::size_t i = 0; i < G_.size(); i++) {
            if (f_min[i] > f_max[i]) {
                return TBA_INFEASIBLE;
            }
            tba_real f = 0;
            for (std::size_t j = 0; j < G_[i].size(); j++) {
                f += G_[i][j] * input.tau[j];
            }
            output.f[i] = std::min(std::max(f, f_min[i]), f_max[i]);
            if (output.f[i] != f) {
                status = TBA_PARTIAL;
            }
        }
        return status;
    }

private:
    Matrix G_;
    std::vector<tba_real> f_min_, f_max_;
};

} // namespace

// No exception may pass these functions: their caller is C.
extern "C" {

int tba_interface(void)
{
    return TBA_INTERFACE;
}

const tba_promise *tba_promises(void)
{
    static const tba_promise promise = {sizeof(tba_promise), nullptr, 1, 1.0, 0};
    return &promise;
}

void *tba_prepare(const tba_vehicle *vehicle, const char **reason)
{
    std::unique_ptr<Allocator> made(new Allocator(*vehicle));
    if (!made->works()) {
        *reason = "its thrusters do not push every axis";
        return nullptr;
    }
    return made.release();
}

int tba_call(void *allocator, const tba_input *input, tba_output *output)
{
    return static_cast<const Allocator *>(allocator)->call(*input, *output);
}
}
