#include "fit/ring_down_problem.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <cmath>
#include <memory>
#include <utility>

#include "base/check.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

// the circuit of one record from logarithmic parameters
template <typename T>
sim::RingDown<T> Circuit(const RingDownSamples& record, double inductance_h, const T* shared) {
  using std::exp;
  return sim::RingDown<T>({.stiffness_n_per_m = exp(shared[Index(Shared::kStiffness)]),
                           .damping_n_s_per_m = exp(shared[Index(Shared::kDamping)]),
                           .force_constant_n_per_a = exp(shared[Index(Shared::kForceConstant)]),
                           .mass_kg = record.mass_ratio * exp(shared[Index(Shared::kMass)]),
                           .coil_resistance_ohm = exp(shared[Index(Shared::kResistance)]),
                           .inductance_h = inductance_h,
                           .load_ohm = record.load_ohm});
}

// the model's voltage; the blow's direction is such that the first half period has `polarity`
template <typename T>
T Voltage(const sim::RingDown<T>& circuit, double polarity, const T* own, double time_s) {
  using std::exp;
  const T since_impact_s = time_s - own[Index(Own::kImpact)];
  return own[Index(Own::kOffset)] -
         polarity * exp(own[Index(Own::kSpeed)]) * circuit.VoltagePerSpeed(since_impact_s);
}

struct Residual {
  const RingDownSamples* record;
  double inductance_h;

  // false, a rejected step, where a trial point is so far away that the voltage overflows
  template <typename T>
  bool operator()(const T* shared, const T* own, T* residuals) const {
    using std::isfinite;
    const auto circuit = Circuit(*record, inductance_h, shared);
    for (std::size_t n = 0; n < record->times_s.size(); ++n) {
      residuals[n] =
          (Voltage(circuit, record->polarity, own, record->times_s[n]) - record->voltages_v[n]) /
          record->noise_v;
      if (!isfinite(residuals[n])) return false;
    }
    return true;
  }
};

using Cost = ceres::AutoDiffCostFunction<Residual, ceres::DYNAMIC, kSharedCount, kOwnCount>;

std::unique_ptr<Cost> MakeCost(const RingDownSamples& record, double inductance_h) {
  return std::make_unique<Cost>(new Residual{&record, inductance_h},
                                static_cast<int>(record.times_s.size()));
}

// the block's held components as a manifold, a constant block, or nothing to do
void Hold(ceres::Problem& problem, double* block, const std::vector<bool>& is_free) {
  std::vector<int> held;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (!is_free[k]) held.push_back(static_cast<int>(k));
  }
  if (held.size() == is_free.size()) {
    problem.SetParameterBlockConstant(block);
  } else if (!held.empty()) {
    problem.SetManifold(block, new ceres::SubsetManifold(static_cast<int>(is_free.size()), held));
  }
}

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

std::size_t RowCount(const std::vector<RingDownSamples>& records) {
  std::size_t rows = 0;
  for (const auto& record : records) rows += record.times_s.size();
  return rows;
}

}  // namespace

RingDownProblem::RingDownProblem(std::vector<RingDownSamples> records, double inductance_h)
    : records_(std::move(records)), inductance_h_(inductance_h) {}

SolverReport RingDownProblem::Minimise(const RingDownFreedom& freedom, RingDownPoint* point) const {
  HAPTOMETER_CHECK(point->own.size() == records_.size() && freedom.speed.size() == records_.size(),
                   "{} records, {} points, {} speeds", records_.size(), point->own.size(),
                   freedom.speed.size());
  ceres::Problem problem;
  for (std::size_t r = 0; r < records_.size(); ++r) {
    problem.AddResidualBlock(MakeCost(records_[r], inductance_h_).release(), nullptr,
                             point->shared.data(), point->own[r].data());
    Hold(problem, point->own[r].data(), {freedom.speed[r], true, true});
  }
  Hold(problem, point->shared.data(),
       std::vector<bool>(freedom.shared.begin(), freedom.shared.end()));

  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(), &problem, &summary);
  return {.converged = summary.termination_type == ceres::CONVERGENCE,
          .termination = summary.message,
          .iterations = static_cast<int>(summary.iterations.size())};
}

Jacobian RingDownProblem::Linearise(const RingDownPoint& point) const {
  Jacobian jacobian;
  jacobian.rows = RowCount(records_);
  jacobian.columns = kSharedCount + kOwnCount * records_.size();
  jacobian.values.assign(jacobian.rows * jacobian.columns, 0.0);
  jacobian.residuals.resize(jacobian.rows);

  std::size_t first_row = 0;
  for (std::size_t r = 0; r < records_.size(); ++r) {
    const std::size_t rows = records_[r].times_s.size();
    std::vector<double> shared(rows * kSharedCount);
    std::vector<double> own(rows * kOwnCount);
    const std::array<const double*, 2> parameters{point.shared.data(), point.own[r].data()};
    std::array<double*, 2> blocks{shared.data(), own.data()};
    MakeCost(records_[r], inductance_h_)
        ->Evaluate(parameters.data(), jacobian.residuals.data() + first_row, blocks.data());
    // scatter the two blocks into the rows of the whole
    for (std::size_t n = 0; n < rows; ++n) {
      double* row = jacobian.values.data() + (first_row + n) * jacobian.columns;
      for (std::size_t k = 0; k < kSharedCount; ++k) row[k] = shared[n * kSharedCount + k];
      for (std::size_t k = 0; k < kOwnCount; ++k) {
        row[kSharedCount + kOwnCount * r + k] = own[n * kOwnCount + k];
      }
    }
    first_row += rows;
  }
  return jacobian;
}

std::vector<double> RingDownProblem::Residuals(const RingDownPoint& point) const {
  std::vector<double> residuals(RowCount(records_));
  std::size_t first_row = 0;
  for (std::size_t r = 0; r < records_.size(); ++r) {
    const Residual residual{&records_[r], inductance_h_};
    residual(point.shared.data(), point.own[r].data(), residuals.data() + first_row);
    first_row += records_[r].times_s.size();
  }
  return residuals;
}

std::vector<double> RingDownProblem::Voltages(const RingDownPoint& point, std::size_t record,
                                              const std::vector<double>& times_s) const {
  const auto circuit = Circuit(records_[record], inductance_h_, point.shared.data());
  std::vector<double> voltages(times_s.size());
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    voltages[n] = Voltage(circuit, records_[record].polarity, point.own[record].data(), times_s[n]);
  }
  return voltages;
}

}  // namespace haptometer::fit
