// Shaped like a controller of ros2_control, against stand-ins of our own for its headers: the matrix is a parameter,
// update() answers within slew rates, leaves out thrusters that failed, and hands back what was not delivered.
#include "controller_interface.hpp"
#include "libthrustbench.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

using controller_interface::CallbackReturn;
using controller_interface::return_type;

class ThrustController : public controller_interface::ControllerInterface
{
public:
    CallbackReturn on_configure() override
    {
        T_ = numbers("T");
        low_ = numbers("f_min");
        high_ = numbers("f_max");
        slew_ = numbers("slew");
        n_ = low_.size();
        k_ = n_ ? T_.size() / n_ : 0;
        const bool fits = k_ * n_ == T_.size() && high_.size() == n_ && slew_.size() == n_ && n_ <= TB_N_MAX &&
                          k_ <= TB_K_MAX;
        if (!fits || tb_prepare(&allocator_, static_cast<int>(k_), static_cast<int>(n_), T_.data(), nullptr, nullptr,
                                low_.data(), high_.data()) != TB_SOLVED) {
            return CallbackReturn::FAILURE;
        }
        failed_ = 0;
        return CallbackReturn::SUCCESS;
    }

    return_type update(const rclcpp::Time &, const rclcpp::Duration &period) override
    {
        tb_real tau[TB_K_MAX], low[TB_N_MAX], high[TB_N_MAX], f[TB_N_MAX];
        std::copy_n(reference.begin(), k_, tau);
        unsigned long failed = 0;
        for (std::size_t i = 0; i < n_; i++) {
            const tb_real now = tb_real(state_interfaces[i]), step = slew_[i] * tb_real(period.seconds());
            failed |= std::isfinite(now) ? 0UL : 1UL << i;
            low[i] = std::isfinite(now) ? std::min(std::max(low_[i], now - step), high_[i]) : 0;
            high[i] = std::isfinite(now) ? std::max(std::min(high_[i], now + step), low_[i]) : 0;
        }
        if (failed != failed_) { // bounded, so this may happen in a period
            if (tb_without(&allocator_, failed) != TB_SOLVED) {
                return return_type::ERROR;
            }
            failed_ = failed;
        }
        const int status = tb_scaled(&allocator_, tau, low, high, f, &share);
        if (status != TB_SOLVED && status != TB_PARTIAL) {
            return return_type::ERROR;
        }
        std::copy(f, f + n_, command_interfaces.begin());
        for (std::size_t r = 0; r < k_; r++) {
            rest[r] = tau[r] - std::inner_product(f, f + n_, &T_[r * n_], tb_real(0));
        }
        return return_type::OK;
    }

    // Not delivered, by axis: the controllers in front of this one hold their integrators where it is not zero but for
    // rounding. A share of 1 does not say so: it is of what the thrusters that are left can push.
    tb_real rest[TB_K_MAX]{};
    tb_real share{0};

private:
    std::vector<tb_real> numbers(const std::string &name) const
    {
        const auto given = parameters.as_double_array(name);
        return {given.begin(), given.end()};
    }

    tb_allocator allocator_{};
    std::vector<tb_real> T_, low_, high_, slew_;
    std::size_t k_{0}, n_{0};
    unsigned long failed_{0};
};

using Failed = std::vector<std::size_t>;

int main()
{
    static ThrustController controller;
    controller.parameters["T"] = {0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 30, 22, -22, -30, -8, 8};
    controller.parameters["f_min"] = {-2e5, -2e5, -2e5, -2e5, -798720, -798720};
    controller.parameters["f_max"] = {2e5, 2e5, 2e5, 2e5, 798720, 798720};
    controller.parameters["slew"] = std::vector<double>(6, 2e6);
    if (controller.on_configure() != CallbackReturn::SUCCESS) {
        return 1;
    }
    controller.reference = {3e5, -4e5, 2e6};
    controller.state_interfaces.assign(6, 0.0);
    controller.command_interfaces.assign(6, 0.0);
    for (int period = 0; period < 4; period++) {
        if (controller.update({}, {0.05}) != return_type::OK) {
            return 2;
        }
        std::printf("%.17g", double(controller.share));
        std::for_each_n(controller.rest, 3, [](tb_real axis) { std::printf(" %.17g", double(axis)); });
        for (double f : controller.command_interfaces) {
            std::printf(" %.17g", f);
        }
        std::printf("\n");
        controller.state_interfaces = controller.command_interfaces; // as if thrusters followed at once
        for (std::size_t i : period == 0 ? Failed{} : period == 1 ? Failed{1} : Failed{1, 4, 5}) {
            controller.state_interfaces[i] = std::nan("");
        }
    }
    return 0;
}
