#include "bench/fit_rungs.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

#include "base/median.h"
#include "dsp/spectrum/fft.h"
#include "fit/poles.h"
#include "sim/ring_down.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer::fit {
namespace {

// what follows the largest voltage, about the record's median
std::vector<double> BehindThePeak(const ImpulseRecord& record) {
  const double middle_v = Median(record.voltage_v);
  const auto peak = std::ranges::max_element(
      record.voltage_v, {}, [middle_v](double v) { return std::abs(v - middle_v); });
  std::vector<double> values(peak, record.voltage_v.end());
  for (double& value : values) value -= middle_v;
  return values;
}

// where the power crosses `level` from `peak` on in steps of `step`, in lines
std::optional<double> Crossing(const std::vector<double>& power, std::size_t peak, int step,
                               double level) {
  const auto size = static_cast<std::ptrdiff_t>(power.size());
  for (auto k = static_cast<std::ptrdiff_t>(peak); k + step >= 0 && k + step < size; k += step) {
    const double here = power[static_cast<std::size_t>(k)];
    const double next = power[static_cast<std::size_t>(k + step)];
    if (next < level) return static_cast<double>(k) + step * (here - level) / (here - next);
  }
  return std::nullopt;
}

// the model's residuals over one record, for Ceres to differentiate
struct AutomaticResiduals {
  const RingDownSamples* record;
  double mass_kg;
  double resistance_ohm;
  double inductance_h;

  template <typename T>
  bool operator()(const T* shared, const T* own, T* residuals) const {
    using std::exp;
    const sim::RingDown<T> circuit({.stiffness_n_per_m = exp(shared[0]),
                                    .damping_n_s_per_m = exp(shared[1]),
                                    .force_constant_squared_n2_per_a2 = shared[2],
                                    .mass_kg = T(mass_kg),
                                    .coil_resistance_ohm = T(resistance_ohm),
                                    .inductance_h = inductance_h,
                                    .load_ohm = record->load_ohm});
    const T voltage = record->polarity * exp(own[0]);
    for (std::size_t n = 0; n < record->times_s.size(); ++n) {
      const T since_s = record->times_s[n] - own[1];
      residuals[n] = (own[2] - voltage * VoltageRatio(circuit, since_s) - record->voltages_v[n]) /
                     record->noise_v;
    }
    return true;
  }
};

constexpr int kSharedFree = 3;
constexpr int kOwnFree = 3;

double Cost(const JointProblem& joint, const RingDownPoint& point) {
  double sum = 0;
  for (const double residual : joint.problem.Residuals(point)) sum += residual * residual;
  return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

struct Step {
  std::vector<double> change;
  double share = 0;  // of the residuals' length that it changes
};

Step GaussNewtonStep(const JointProblem& joint, const RingDownPoint& point) {
  const Jacobian at = joint.problem.Linearise(point);
  std::vector<Eigen::Index> columns;
  for (std::size_t k = 0; k < joint.is_free.size(); ++k) {
    if (joint.is_free[k]) columns.push_back(static_cast<Eigen::Index>(k));
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> all(at.values.data(), static_cast<Eigen::Index>(at.rows),
                                       static_cast<Eigen::Index>(at.columns));
  const Eigen::MatrixXd slopes = all(Eigen::all, columns);
  const Eigen::Map<const Eigen::VectorXd> residuals(at.residuals.data(), slopes.rows());
  const Eigen::VectorXd solved = -slopes.colPivHouseholderQr().solve(residuals);
  Step step{std::vector<double>(at.columns, 0.0), (slopes * solved).norm() / residuals.norm()};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    step.change[static_cast<std::size_t>(columns[k])] = solved[static_cast<Eigen::Index>(k)];
  }
  return step;
}

RingDownPoint Moved(const RingDownPoint& point, const Step& step, double share) {
  std::vector<double> columns = ToColumns(point);
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] += share * step.change[k];
  return FromColumns(columns);
}

}  // namespace

Constants ConstantsOf(const PolePair& open, const PolePair& loaded, const ActuatorKnowns& knowns,
                      double load_ohm) {
  const double mass = knowns.moving_mass_kg->value;
  const double square = 2 * mass * (loaded.decay_per_s - open.decay_per_s) *
                        (knowns.resistance_ohm->value + load_ohm);
  return {mass * (open.stiffness_per_s2 + loaded.stiffness_per_s2) / 2, 2 * mass * open.decay_per_s,
          square > 0 ? std::sqrt(square) : 0};
}

std::optional<PolePair> PolesBySpectrum(const ImpulseRecord& record) {
  std::vector<double> values = BehindThePeak(record);
  values.resize(std::bit_ceil(8 * values.size()));
  const auto lines = dsp::RealSpectrum(values);
  std::vector<double> power(lines.size());
  std::ranges::transform(lines, power.begin(), [](const auto& line) { return std::norm(line); });
  const auto peak = static_cast<std::size_t>(std::ranges::max_element(power) - power.begin());
  if (peak == 0 || peak + 1 == power.size()) return std::nullopt;
  const double curvature = power[peak - 1] - 2 * power[peak] + power[peak + 1];
  const double offset = 0.5 * (power[peak - 1] - power[peak + 1]) / curvature;
  const auto below = Crossing(power, peak, -1, power[peak] / 2);
  const auto above = Crossing(power, peak, 1, power[peak] / 2);
  if (!below || !above) return std::nullopt;
  const double per_line =
      2 * std::numbers::pi / (static_cast<double>(values.size()) * record.step_s);
  const double angular = (static_cast<double>(peak) + offset) * per_line;
  const double decay = (*above - *below) * per_line / 2;
  return PolePair{decay, angular * angular + decay * decay};
}

std::optional<PolePair> PolesByPencil(const ImpulseRecord& record) {
  return EstimatePoles(BehindThePeak(record), record.step_s);
}

std::optional<JointProblem> MakeJointProblem(const RecordPair& records,
                                             const ActuatorKnowns& knowns) {
  const auto model = MakeDropTestModel(records, knowns);
  if (!model) return std::nullopt;
  JointProblem joint{MakeProblem(*model), {}, {}};
  joint.start = StartPoint(*model, false, &joint.problem);
  joint.is_free = UnknownColumns(*model, joint.problem);
  return joint;
}

double SpectrumLine(const ImpulseRecord& record) {
  return StrongestFrequency(BehindThePeak(record), record.step_s).value_or(1);
}

void StartFrom(double frequency_hz, JointProblem* joint) {
  constexpr double kQuality = 30;
  constexpr double kForceConstantSquared = 0.25;
  const double angular = 2 * std::numbers::pi * frequency_hz;
  auto& shared = joint->start.shared;
  const double log_mass = shared[Index(Shared::kMass)];
  shared[Index(Shared::kStiffness)] = log_mass + 2 * std::log(angular);
  shared[Index(Shared::kDamping)] = log_mass + std::log(angular / kQuality);
  shared[Index(Shared::kForceConstantSquared)] = kForceConstantSquared;
}

Constants ConstantsAt(const RingDownPoint& point) {
  const double square = point.shared[Index(Shared::kForceConstantSquared)];
  return {std::exp(point.shared[Index(Shared::kStiffness)]),
          std::exp(point.shared[Index(Shared::kDamping)]), square > 0 ? std::sqrt(square) : 0};
}

bool MinimiseByGaussNewton(const JointProblem& joint, RingDownPoint* point) {
  constexpr int kMostSteps = 200;
  constexpr int kMostHalvings = 30;
  constexpr double kNoChange = 1e-10;
  double cost = Cost(joint, *point);
  for (int k = 0; k < kMostSteps; ++k) {
    const Step step = GaussNewtonStep(joint, *point);
    if (!std::isfinite(step.share)) return false;
    if (step.share < kNoChange) return true;
    double share = 1;
    RingDownPoint tried = Moved(*point, step, share);
    int halvings = 0;
    for (; halvings < kMostHalvings && !(Cost(joint, tried) < cost); ++halvings) {
      share /= 2;
      tried = Moved(*point, step, share);
    }
    if (halvings == kMostHalvings) return step.share < std::sqrt(kNoChange);
    *point = tried;
    cost = Cost(joint, tried);
  }
  return false;
}

bool MinimiseByAutomaticDerivatives(const JointProblem& joint, const ActuatorKnowns& knowns,
                                    double tolerance, RingDownPoint* point) {
  ceres::Problem problem;
  using Function =
      ceres::AutoDiffCostFunction<AutomaticResiduals, ceres::DYNAMIC, kSharedFree, kOwnFree>;
  const auto& records = joint.problem.records();
  for (std::size_t r = 0; r < records.size(); ++r) {
    auto* function = new Function(
        new AutomaticResiduals{&records[r], knowns.moving_mass_kg->value,
                               knowns.resistance_ohm->value, knowns.inductance_h->value},
        static_cast<int>(records[r].times_s.size()));
    problem.AddResidualBlock(function, nullptr, point->shared.data(), point->own[r].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 1000;
  options.function_tolerance = tolerance;
  options.parameter_tolerance = tolerance;
  options.gradient_tolerance = tolerance;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.termination_type == ceres::CONVERGENCE;
}

ImpulseRecord Averaged(const ImpulseRecord& record, std::size_t block) {
  ImpulseRecord fewer = record;
  fewer.voltage_v.clear();
  for (std::size_t n = 0; n + block <= record.voltage_v.size(); n += block) {
    double sum = 0;
    for (std::size_t k = n; k < n + block; ++k) sum += record.voltage_v[k];
    fewer.voltage_v.push_back(sum / static_cast<double>(block));
  }
  fewer.start_s += 0.5 * static_cast<double>(block - 1) * record.step_s;
  fewer.step_s *= static_cast<double>(block);
  return fewer;
}

ImpulseRecord Decimated(const ImpulseRecord& record, std::size_t block) {
  ImpulseRecord fewer = record;
  fewer.voltage_v.clear();
  for (std::size_t n = 0; n < record.voltage_v.size(); n += block) {
    fewer.voltage_v.push_back(record.voltage_v[n]);
  }
  fewer.step_s *= static_cast<double>(block);
  return fewer;
}

}  // namespace haptometer::fit
