#pragma once
#include <eigen3/Eigen/Eigen>
namespace vortex::utils::types {
using Vector6d = Eigen::Matrix<double, 6, 1>;
}
