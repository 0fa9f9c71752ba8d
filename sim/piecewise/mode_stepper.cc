#include "sim/piecewise/mode_stepper.h"

#include <cmath>

namespace haptometer::sim {

ModeStepper::ModeStepper(const PiecewiseLinearSystem& system, const Mode& mode,
                         const ExcitationShape& shape, double rate_hz)
    : system_(&system),
      mode_(&mode),
      shape_(&shape),
      rate_hz_(rate_hz),
      step_s_(1 / rate_hz),
      generator_(DrivenGenerator(mode.a, mode.Inputs(), shape)) {
  if (mode.a_rest.size() > 0) long_generator_ = LongDrivenGenerator(mode, shape);
  if (mode.guards.empty() && mode.watched.empty()) return;
  // the level at which a step is within the horizon of the guards' bounds
  const double longest_s = GuardBound::LongestHorizon(generator_);
  while (watch_level_ < kFinestLevel && std::ldexp(step_s_, -watch_level_) > longest_s) {
    ++watch_level_;
  }
  if (!mode.guards.empty()) coarsest_level_ = watch_level_;
}

const Eigen::MatrixXd& ModeStepper::MadeStep(int level) {
  Eigen::MatrixXd& step = steps_[PlaceOf(level)];
  const double length_s = std::ldexp(step_s_, -level);
  const Eigen::Index signals = shape_->generator.rows();
  // with known rounding errors of the model the step is computed in long double
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
  // 2^power outputs, for states from the anchor
  const long double outputs = std::ldexp(1.0L, static_cast<int>(power));
  const LongMatrix generator =
      long_generator_.size() > 0 ? long_generator_ : generator_.cast<long double>().eval();
  step = LongDrivenStep(generator, outputs / static_cast<long double>(rate_hz_),
                        shape_->generator.rows());
  return step;
}

const StepEnergy& ModeStepper::MadeEnergy(int level) {
  StepEnergy& energy = energies_[PlaceOf(level)];
  energy = EnergyOver(*mode_, system_->squared_rows, generator_, shape_->rows,
                      std::ldexp(step_s_, -level));
  return energy;
}

GuardBound ModeStepper::BoundOf(const Eigen::RowVectorXd& row, double offset,
                                const Eigen::RowVectorXd& feed, int level) const {
  const Eigen::Index n = mode_->a.rows(), m = shape_->generator.rows();
  Eigen::RowVectorXd whole = Eigen::RowVectorXd::Zero(n + m);
  // a row of z = [x, w]: inputs are rows of the signals
  whole.head(n) = row;
  if (feed.size() > 0) whole.tail(m) = feed * shape_->rows;
  return {generator_, whole, offset, *shape_, std::ldexp(step_s_, -level)};
}

std::vector<GuardBound>& ModeStepper::MadeGuards() {
  guards_.reserve(mode_->guards.size());
  for (const Guard& guard : mode_->guards) {
    guards_.push_back(BoundOf(guard.row, guard.offset, guard.feed, coarsest_level_));
  }
  return guards_;
}

std::vector<GuardBound>& ModeStepper::MadeWatched() {
  watched_.reserve(mode_->watched.size());
  for (const WatchedNumber& number : mode_->watched) {
    watched_.push_back(BoundOf(number.row, number.offset, number.feed, watch_level_));
  }
  return watched_;
}

}  // namespace haptometer::sim
