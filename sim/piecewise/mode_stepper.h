#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/error.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"
#include "sim/piecewise/energy_ledger.h"
#include "sim/piecewise/guard.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// An output step has 2^50 ticks: below 1e-16 s at 10 Hz and more, below 1e-19 s at 10 kHz.
inline constexpr int kFinestLevel = 50;
inline constexpr std::uint64_t kTicks = std::uint64_t{1} << kFinestLevel;
/// Long steps reach over 2^40 outputs.
inline constexpr std::size_t kLongPowers = 41;

/// The matrices of one mode under one shape of excitation, each made when first asked for, so that
/// a mode that is never entered costs nothing. Not for sharing between threads.
class ModeStepper {
 public:
  /// Outputs come at rate_hz; system and shape must outlive this.
  ModeStepper(const PiecewiseLinearSystem& system, const Mode& mode, const ExcitationShape& shape,
              double rate_hz);

  [[nodiscard]] const Mode& mode() const { return *mode_; }
  /// DrivenStep over 2^-level / rate_hz, 0 <= level <= kFinestLevel. Each from an exponential of
  /// its own: squaring the smallest would lose what distinguishes it from 1.
  [[nodiscard]] const Eigen::MatrixXd& Step(int level) {
    const Eigen::MatrixXd& step = steps_[PlaceOf(level)];
    return step.size() > 0 ? step : MadeStep(level);
  }
  /// LongDrivenStep over 2^power outputs.
  [[nodiscard]] const LongMatrix& LongStep(std::size_t power);
  /// EnergyOver of Step(level).
  [[nodiscard]] const StepEnergy& Energy(int level) {
    const StepEnergy& energy = energies_[PlaceOf(level)];
    return energy.input_j.size() > 0 ? energy : MadeEnergy(level);
  }
  /// The bounds of the mode's guards hold over 2^-CoarsestLevel() of an output step.
  [[nodiscard]] std::vector<GuardBound>& Guards() {
    return guards_.size() == mode_->guards.size() ? guards_ : MadeGuards();
  }
  [[nodiscard]] int CoarsestLevel() const { return coarsest_level_; }
  /// The bounds of the mode's watched numbers, which hold over 2^-WatchLevel() of an output step.
  [[nodiscard]] std::vector<GuardBound>& Watched() {
    return watched_.size() == mode_->watched.size() ? watched_ : MadeWatched();
  }
  [[nodiscard]] int WatchLevel() const { return watch_level_; }

 private:
  [[nodiscard]] static std::size_t PlaceOf(int level) {
    HAPTOMETER_CHECK(level >= 0 && level <= kFinestLevel, "level {}", level);
    return static_cast<std::size_t>(level);
  }
  const Eigen::MatrixXd& MadeStep(int level);
  const StepEnergy& MadeEnergy(int level);
  std::vector<GuardBound>& MadeGuards();
  std::vector<GuardBound>& MadeWatched();
  [[nodiscard]] GuardBound BoundOf(const Eigen::RowVectorXd& row, double offset,
                                   const Eigen::RowVectorXd& feed, int level) const;

  static constexpr std::size_t kLevels = kFinestLevel + 1;
  const PiecewiseLinearSystem* system_;
  const Mode* mode_;
  const ExcitationShape* shape_;
  double rate_hz_;
  double step_s_;
  Eigen::MatrixXd generator_;
  LongMatrix long_generator_;  // where the mode has a rest; else empty
  int coarsest_level_ = 0;
  std::vector<GuardBound> guards_;
  int watch_level_ = 0;
  std::vector<GuardBound> watched_;
  std::array<Eigen::MatrixXd, kLevels> steps_;
  std::array<StepEnergy, kLevels> energies_;
  std::array<LongMatrix, kLongPowers> long_steps_;
};

}  // namespace haptometer::sim
