// A control loop with the matrix from a file, and two thrusters that fail while it runs.
//
// Usage: failures MATRIX, where MATRIX has k and n, then k rows of T, then f_min and f_max. A worker prepares the
// allocator for what is left beside the loop, which swaps one pointer when it is done: no period is longer for it.
#include "libthrustbench.h"

#include <array>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <vector>

class Allocation {
public:
    bool boot(int k, int n, const std::vector<tb_real> &T, const std::vector<tb_real> &low,
              const std::vector<tb_real> &high)
    {
        return tb_prepare(&made_[0], k, n, T.data(), nullptr, nullptr, low.data(), high.data()) == TB_SOLVED;
    }

    // Called by the worker, one call at a time: `failed` has a bit for each thruster that is off,
    // bit 0 for the first. False where there is no such thruster, or nothing can be prepared for those that are left.
    bool without(unsigned long failed)
    {
        const tb_allocator *now = active_.load();
        tb_allocator &next = made_[now == &made_[0] ? 1 : 0];
        next = *now;
        if (tb_without(&next, failed) != TB_SOLVED) {
            return false; // the old one goes on
        }
        active_.store(&next);
        return true;
    }

    // Called by the loop. Status 0: all of tau is delivered; 1: the integrators of the controller stop.
    int operator()(const tb_real *tau, tb_real *f, tb_real *share) const
    {
        return tb_scaled(active_.load(), tau, nullptr, nullptr, f, share);
    }

private:
    std::array<tb_allocator, 2> made_{};
    std::atomic<const tb_allocator *> active_{&made_[0]};
};

int main(int, char **arguments)
{
    static Allocation allocate;
    std::ifstream file(arguments[1]);
    int k = 0, n = 0;
    if (!(file >> k >> n) || k < 1 || k > TB_K_MAX || n < 1 || n > TB_N_MAX) {
        return 2;
    }
    std::vector<tb_real> T(static_cast<std::size_t>(k * n)), low(static_cast<std::size_t>(n)), high = low;
    for (auto *values : {&T, &low, &high}) {
        for (tb_real &value : *values) {
            file >> value;
        }
    }
    if (!file || !allocate.boot(k, n, T, low, high)) {
        return 2;
    }
    const unsigned long failures[] = {0, 1UL << 0, 1UL << 0 | 1UL << 5}; // none, then one, then a second
    const std::array<tb_real, 6> tau{30, -20, 40, 2, -1, 5};
    for (const unsigned long failed : failures) {
        std::array<tb_real, TB_N_MAX> f{};
        tb_real share = 0;
        if (!allocate.without(failed)) {
            return 3;
        }
        const int status = allocate(tau.data(), f.data(), &share);
        std::printf("%d %.17g", status, static_cast<double>(share));
        for (int i = 0; i < n; i++) {
            std::printf(" %.17g", static_cast<double>(f[static_cast<std::size_t>(i)]));
        }
        std::printf("\n");
    }
    return 0;
}
