// Stand-ins, written here, for what ros2.cpp takes of rclcpp and ros2_control: their shapes, and none of their code.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace rclcpp
{
struct Time {
    double at{0};
};
struct Duration {
    double length{0};
    double seconds() const { return length; }
};
struct Parameters : std::map<std::string, std::vector<double>> {
    std::vector<double> as_double_array(const std::string &name) const
    {
        const auto found = find(name);
        return found == end() ? std::vector<double>{} : found->second;
    }
};
} // namespace rclcpp

namespace controller_interface
{
enum class return_type { OK, ERROR };
enum class CallbackReturn { SUCCESS, FAILURE };

class ControllerInterface
{
public:
    virtual ~ControllerInterface() = default;
    virtual CallbackReturn on_configure() = 0;
    virtual return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;

    rclcpp::Parameters parameters;
    std::vector<double> reference;          // the wanted wrench
    std::vector<double> state_interfaces;   // of each thruster: its thrust now, NaN once it has failed
    std::vector<double> command_interfaces; // of each thruster: the thrust it shall give
};
} // namespace controller_interface
