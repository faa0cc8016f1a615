// eiquadprog's EiquadprogFast behind thrustbench_allocator.h: eq. 4-5, posed as docs/solvers.md says, or, with
// NEWTONS, as the vehicle's numbers are. Its status is a claim: T f = tau is asked of every answer, and its own
// multipliers have to prove what it calls infeasible, as alloc/rivals/wrapper.c does; with CLAIMED neither.
#include <eiquadprog/eiquadprog-fast.hpp>

#include "thrustbench_allocator.h"

namespace {
using namespace eiquadprog::solvers;
using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
using Column = Eigen::Map<const VectorXd>;
constexpr double MET = 1e-6, PART = 1e-2, LOST = 1e-9, DOUBT = 1e-13;
#ifdef NEWTONS
constexpr bool SCALED = false;
#else
constexpr bool SCALED = true;
#endif
#ifdef CLAIMED
constexpr bool CHECKED = false;
#else
constexpr bool CHECKED = true;
#endif

struct Allocator {
    std::vector<int> on; // thrusters that work
    MatrixXd T, H, A, G, b_of_tau, lost;
    VectorXd low, high, unit, per_axis, g, b, h, x;
    EiquadprogFast solver;

    explicit Allocator(const tba_vehicle &v) : low(Column(v.f_min, v.n)), high(Column(v.f_max, v.n))
    {
        for (int i = 0; i < v.n; i++)
            if (v.readiness[i] > 0)
                on.push_back(i);
        const int m = int(on.size());
        const MatrixXd whole = Rows(v.T, v.k, v.n), TP = whole * Column(v.readiness, v.n).asDiagonal();
        const double f_scale = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
        VectorXd rows = whole.rowwise().norm();
        rows = (rows.array() > LOST * rows.maxCoeff()).select(rows, rows.maxCoeff());
        per_axis = (rows * f_scale).cwiseInverse();
        T = TP(Eigen::all, on);
        H = Rows(v.H, v.n, v.n)(on, on);
        const double cheapest = H.diagonal().minCoeff();
        unit.setOnes(m);
        if (SCALED) {
            unit = f_scale * (cheapest / H.diagonal().array()).pow(1.0 / 3);
            H = (unit / f_scale).asDiagonal() * H * (unit / f_scale).asDiagonal() / cheapest;
        }
        const MatrixXd even = rows.cwiseInverse().asDiagonal() * T * unit.asDiagonal();
        const Eigen::JacobiSVD<MatrixXd> svd(even, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const auto p = (svd.singularValues().array() > LOST * svd.singularValues()[0]).count();
        lost = svd.matrixU().rightCols(v.k - p).transpose() * per_axis.asDiagonal();
        A = svd.matrixV().leftCols(p).transpose();
        b_of_tau = svd.singularValues().head(p).cwiseInverse().asDiagonal()
                   * svd.matrixU().leftCols(p).transpose() * rows.cwiseInverse().asDiagonal();
        if (!SCALED && p == v.k) {
            A = T;
            b_of_tau.setIdentity(v.k, v.k);
        }
        G.resize(2 * m, m);
        G << MatrixXd::Identity(m, m), -MatrixXd::Identity(m, m);
        g.setZero(m);
        h.resize(2 * m);
        solver.reset(m, p, 2 * m);
    }

    // Whether y'b lies beyond all that y'A x can be within the limits, by more than rounding; or -y.
    bool proven() const
    {
        const Eigen::Index m = x.size();
        const Eigen::ArrayXd lb = -h.head(m), ub = h.tail(m);
        const VectorXd y = solver.getLagrangeMultipliers().head(A.rows()), reach = lb.abs() + ub.abs();
        const Eigen::ArrayXd c = A.transpose() * y;
        const double along = -y.dot(b), most = (c * lb).max(c * ub).sum(), least = (c * lb).min(c * ub).sum();
        const double terms = y.cwiseAbs().dot(b.cwiseAbs() + A.cwiseAbs() * reach);
        return along - most > DOUBT * terms || least - along > DOUBT * terms;
    }

    int call(const tba_input &input, tba_output &output)
    {
        const Column tau(input.tau, T.rows());
        const Column bottom(input.f_min ? input.f_min : low.data(), low.size());
        const Column top(input.f_max ? input.f_max : high.data(), high.size());
        const VectorXd least = bottom(on), most = top(on);
        if ((least.array() > most.array()).any() || (lost.rows() && (lost * tau).cwiseAbs().maxCoeff() > LOST))
            return TBA_INFEASIBLE;
        b = -b_of_tau * tau;
        h << -least.cwiseQuotient(unit), most.cwiseQuotient(unit);
        switch (solver.solve_quadprog(H, g, A, b, G, h, x)) {
        case EIQUADPROG_FAST_OPTIMAL:
            break;
        case EIQUADPROG_FAST_INFEASIBLE:
        case EIQUADPROG_FAST_UNBOUNDED: // of the dual problem: H is positive definite
            return !CHECKED || proven() ? TBA_INFEASIBLE : TBA_NOT_CONVERGED;
        default:
            return TBA_NOT_CONVERGED;
        }
        VectorXd f = x.cwiseProduct(unit);
        double miss = 0;
        if (CHECKED) {
            f = f.cwiseMin(most).cwiseMax(least);
            miss = per_axis.cwiseProduct(T * f - tau).norm();
            if (!(miss <= PART))
                return TBA_NOT_CONVERGED;
        }
        std::fill_n(output.f, low.size(), 0.0);
        for (size_t i = 0; i < on.size(); i++)
            output.f[on[i]] = f[Eigen::Index(i)];
        return miss <= MET ? TBA_SOLVED : TBA_PARTIAL;
    }
};
} // namespace

extern "C" {
int tba_interface(void) { return TBA_INTERFACE; }

const tba_promise *tba_promises(void)
{
    static const tba_promise promise = {sizeof promise, "hard", CHECKED, 1e-9};
    return &promise;
}

void *tba_prepare(const tba_vehicle *vehicle, const char **) { return new Allocator(*vehicle); }

void tba_free(void *allocator) { delete static_cast<Allocator *>(allocator); }

int tba_call(void *allocator, const tba_input *input, tba_output *output)
{
    return static_cast<Allocator *>(allocator)->call(*input, *output);
}
}
