#!/usr/bin/env bash
# eiquadprog calls a demand beyond reach unbounded, and never infeasible.
#
# Guess: of EiquadprogFast's statuses INFEASIBLE is for problems without a point; UNBOUNDED for those without a least
#   cost, which a positive definite H excludes.
# Seen (eiquadprog 1.3.2): each of 1,000 demands beyond the limits ends with UNBOUNDED, and none with INFEASIBLE: it is
#   the dual problem that has no bound. The older solve_quadprog of the same library returns an infinite cost. All of
#   1,000 demands within them are OPTIMAL.
# Consequence: a switch that takes UNBOUNDED for a mistake in H, or INFEASIBLE alone for "beyond reach", is wrong for
#   each demand beyond reach.
# Source of T: four horizontal thrusters of a small ROV, angles and arms rounded.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet --disable-pip-version-check eiquadprog==1.3.2 cmeel-eigen==3.4.1 --no-deps
prefix=$(echo "$folder"/env/lib/python3*/site-packages/cmeel.prefix)
cat > "$folder/ask.cpp" <<'CPP'
#include <eiquadprog/eiquadprog-fast.hpp>
#include <eiquadprog/eiquadprog.hpp>

#include <iostream>

using namespace eiquadprog::solvers;

int main()
{
    Eigen::MatrixXd H = Eigen::MatrixXd::Identity(4, 4), T(3, 4), limits(8, 4);
    T << 0.87, 0.87, -0.87, -0.87, 0.48, -0.48, 0.48, -0.48, 0.33, -0.33, -0.33, 0.33;
    limits << H, -H;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(4), one = Eigen::VectorXd::Ones(8);
    EiquadprogFast solver;
    solver.reset(4, 3, 8);
    int optimal = 0, unbounded = 0, other = 0, infinite = 0;
    for (int i = 0; i < 1000; i++) {
        const Eigen::VectorXd within = T * Eigen::VectorXd::Random(4), beyond = within.normalized() * 4;
        Eigen::VectorXd f(4), g = zero;
        optimal += solver.solve_quadprog(H, zero, T, -within, limits, one, f) == EIQUADPROG_FAST_OPTIMAL;
        const auto status = solver.solve_quadprog(H, zero, T, -beyond, limits, one, f);
        unbounded += status == EIQUADPROG_FAST_UNBOUNDED;
        other += status != EIQUADPROG_FAST_UNBOUNDED;
        Eigen::MatrixXd copy = H;
        Eigen::VectorXi active(11);
        size_t size;
        infinite += std::isinf(solve_quadprog(copy, g, T.transpose(), -beyond, limits.transpose(), one, f, active, size));
    }
    std::cout << "eiquadprog " EIQUADPROG_VERSION ": within reach " << optimal << " optimal; beyond it " << unbounded
              << " unbounded, " << other << " otherwise, " << infinite << " of infinite cost by the older function\n";
    return optimal == 1000 && unbounded == 1000 && other == 0 && infinite == 1000 ? 0 : 1;
}
CPP
c++ -std=c++17 -O2 -w "-I$prefix/include" "-I$prefix/include/eigen3" "$folder/ask.cpp" "-L$prefix/lib" -leiquadprog \
  "-Wl,-rpath,$prefix/lib" -o "$folder/ask"
"$folder/ask"
