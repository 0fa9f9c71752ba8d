#include "fit/least_squares.h"

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.h"

namespace haptometer::fit {
namespace {

// the whole problem as one block of residuals over one block of parameters
class Block : public ceres::CostFunction {
 public:
  explicit Block(const LeastSquares& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.residuals));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.parameters));
  }

  bool Evaluate(double const* const* points, double* residuals, double** jacobians) const override {
    std::span<double> jacobian;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      jacobian = {jacobians[0], problem_.residuals * problem_.parameters};
    }
    return problem_.evaluate({points[0], problem_.parameters}, {residuals, problem_.residuals},
                             jacobian);
  }

 private:
  const LeastSquares& problem_;
};

ceres::Solver::Options SolverOptions() {
  constexpr double kRounding = 1e-15;
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 1000;
  options.function_tolerance = kRounding;
  options.parameter_tolerance = kRounding;
  options.gradient_tolerance = kRounding;
  options.max_num_consecutive_invalid_steps = 20;
  options.logging_type = ceres::SILENT;
  return options;
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// the full Gauss-Newton step over the free parameters, in units of their columns' lengths
struct NewtonStep {
  std::vector<double> change;  // per parameter
  double length = 0;           // of the change of the residuals
};

NewtonStep StepFrom(const LeastSquares& problem, const std::vector<bool>& is_free,
                    const std::vector<double>& point) {
  const Jacobian at = Linearise(problem, point);
  std::vector<Eigen::Index> columns;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (is_free[k]) columns.push_back(static_cast<Eigen::Index>(k));
  }
  const Eigen::Map<const RowMajor> whole(at.values.data(), static_cast<Eigen::Index>(at.rows),
                                         static_cast<Eigen::Index>(at.columns));
  Eigen::MatrixXd scaled = whole(Eigen::all, columns);
  Eigen::VectorXd lengths = scaled.colwise().norm();
  lengths = (lengths.array() > 0).select(lengths, 1.0);
  scaled *= lengths.cwiseInverse().asDiagonal();
  const Eigen::Map<const Eigen::VectorXd> residuals(at.residuals.data(), scaled.rows());
  const Eigen::VectorXd step = -scaled.colPivHouseholderQr().solve(residuals);
  NewtonStep newton{std::vector<double>(point.size(), 0.0), (scaled * step).norm()};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto position = static_cast<Eigen::Index>(k);
    newton.change[static_cast<std::size_t>(columns[k])] = step[position] / lengths[position];
  }
  return newton;
}

// A cost that no longer changes leaves the point uncertain to the root of rounding; steps that
// solve J'r = 0 reach rounding itself. Taken while each is shorter than the one before: where
// residuals are large the way is slow.
void Polish(const LeastSquares& problem, const std::vector<bool>& is_free,
            std::vector<double>* point) {
  constexpr int kMostSteps = 50;
  constexpr double kFlat = 1e-9;  // what the cost may rise by and still be flat
  double previous = std::numeric_limits<double>::infinity();
  std::vector<double> best = *point;
  std::vector<double> residuals(problem.residuals);
  const auto cost_at = [&](const std::vector<double>& at) {
    if (!problem.evaluate(at, residuals, {})) return std::numeric_limits<double>::infinity();
    return Eigen::Map<const Eigen::VectorXd>(residuals.data(),
                                             static_cast<Eigen::Index>(residuals.size()))
        .squaredNorm();
  };
  const double most = cost_at(best) * (1 + kFlat);
  for (int k = 0; k < kMostSteps; ++k) {
    const NewtonStep step = StepFrom(problem, is_free, best);
    if (!(step.length < 0.9 * previous) || step.length == 0) break;
    *point = best;
    previous = step.length;
    std::ranges::transform(best, step.change, best.begin(), std::plus<>());
    if (!(cost_at(best) <= most)) break;
  }
}

}  // namespace

SolverReport Minimise(const LeastSquares& problem, const std::vector<bool>& is_free,
                      std::vector<double>* point) {
  HAPTOMETER_CHECK(point->size() == problem.parameters && is_free.size() == problem.parameters,
                   "{} parameters, {} values, {} flags", problem.parameters, point->size(),
                   is_free.size());
  std::vector<int> held;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (!is_free[k]) held.push_back(static_cast<int>(k));
  }
  if (held.size() == is_free.size()) return {true, "nothing is free", 0};

  ceres::Problem whole;
  whole.AddResidualBlock(new Block(problem), nullptr, point->data());
  if (!held.empty()) {
    whole.SetManifold(point->data(),
                      new ceres::SubsetManifold(static_cast<int>(is_free.size()), held));
  }
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(), &whole, &summary);
  if (summary.termination_type == ceres::CONVERGENCE) Polish(problem, is_free, point);
  return {.converged = summary.termination_type == ceres::CONVERGENCE,
          .termination = summary.message,
          .iterations = static_cast<int>(summary.iterations.size())};
}

Jacobian Linearise(const LeastSquares& problem, const std::vector<double>& point) {
  Jacobian jacobian{problem.residuals, problem.parameters, {}, {}};
  jacobian.values.resize(problem.residuals * problem.parameters);
  jacobian.residuals.resize(problem.residuals);
  const bool defined = problem.evaluate(point, jacobian.residuals, jacobian.values);
  HAPTOMETER_CHECK(defined, "{} residuals are not defined here", problem.residuals);
  return jacobian;
}

}  // namespace haptometer::fit
