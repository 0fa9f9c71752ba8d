#include "sim/mode_stepper.h"

#include <cmath>

#include "base/check.h"
#include "sim/driven_step.h"

namespace haptometer::sim {

namespace {

std::size_t PlaceOf(int level) {
  HAPTOMETER_CHECK(level >= 0 && level <= kFinestLevel, "level {}", level);
  return static_cast<std::size_t>(level);
}

}  // namespace

ModeStepper::ModeStepper(const PiecewiseLinearSystem& system, const Mode& mode,
                         const ExcitationShape& shape, double rate_hz)
    : system_(&system),
      mode_(&mode),
      shape_(&shape),
      rate_hz_(rate_hz),
      step_s_(1 / rate_hz),
      generator_(DrivenGenerator(mode.a, mode.Inputs(), shape)) {
  if (mode.a_rest.size() > 0) long_generator_ = LongDrivenGenerator(mode, shape);
  if (mode.guards.empty()) return;
  const double longest_s = GuardBound::LongestHorizon(generator_);
  while (coarsest_level_ < kFinestLevel && std::ldexp(step_s_, -coarsest_level_) > longest_s) {
    ++coarsest_level_;
  }
}

const Eigen::MatrixXd& ModeStepper::Step(int level) {
  Eigen::MatrixXd& step = steps_[PlaceOf(level)];
  if (step.size() > 0) return step;
  const double length_s = std::ldexp(step_s_, -level);
  const Eigen::Index signals = shape_->generator.rows();
  if (long_generator_.size() == 0) {
    step = DrivenStep(generator_, length_s, signals);
  } else {
    const auto long_length_s = static_cast<long double>(length_s);
    step = LongDrivenStep(long_generator_, long_length_s, signals).cast<double>();
  }
  return step;
}

const LongMatrix& ModeStepper::LongStep(std::size_t power) {
  LongMatrix& step = long_steps_[power];
  if (step.size() > 0) return step;
  const long double outputs = std::ldexp(1.0L, static_cast<int>(power));
  const LongMatrix generator =
      long_generator_.size() > 0 ? long_generator_ : generator_.cast<long double>().eval();
  step = LongDrivenStep(generator, outputs / static_cast<long double>(rate_hz_),
                        shape_->generator.rows());
  return step;
}

const StepEnergy& ModeStepper::Energy(int level) {
  StepEnergy& energy = energies_[PlaceOf(level)];
  if (energy.input_j.size() == 0) {
    energy = EnergyOver(*mode_, system_->squared_rows, generator_, shape_->rows,
                        std::ldexp(step_s_, -level));
  }
  return energy;
}

std::vector<GuardBound>& ModeStepper::Guards() {
  if (guards_.size() == mode_->guards.size()) return guards_;
  guards_.reserve(mode_->guards.size());
  const Eigen::Index n = mode_->a.rows();
  for (const Guard& guard : mode_->guards) {
    const Eigen::Index m = shape_->generator.rows();
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(n + m);
    row.head(n) = guard.row;
    if (guard.feed.size() > 0) row.tail(m) = guard.feed * shape_->rows;
    guards_.emplace_back(generator_, row, guard.offset, *shape_,
                         std::ldexp(step_s_, -coarsest_level_));
  }
  return guards_;
}

}  // namespace haptometer::sim
