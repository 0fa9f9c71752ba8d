#pragma once

#include <algorithm>

namespace haptometer::sim {

/// The tolerances of SmoothMotion that a scene with smooth effects is played with, one after the
/// other: a hundred times a tenth of scene.tolerance (1e-12 to 1e-4), that tenth, and where the
/// answer is not good enough ever a hundred times less, down to 1e-12.
class SolverLadder {
 public:
  explicit SolverLadder(double scene_tolerance)
      : asked_(scene_tolerance),
        tolerance_(std::clamp(kPart * scene_tolerance, kLeast, kMost)),
        before_(kFiner * tolerance_) {}

  [[nodiscard]] double tolerance() const { return tolerance_; }
  /// Of the run before.
  [[nodiscard]] double before() const { return before_; }
  /// How many times less the tolerance is than that of the run before.
  [[nodiscard]] double finer() const { return before_ / tolerance_; }
  /// Whether an error is a quarter of what is asked for, or no less tolerance is left.
  [[nodiscard]] bool EndsWith(double error) const {
    return error <= kErrorPart * asked_ || tolerance_ <= kLeast;
  }
  void Refine() {
    before_ = tolerance_;
    tolerance_ = std::max(tolerance_ / kFiner, kLeast);
  }

 private:
  static constexpr double kPart = 0.1;
  static constexpr double kErrorPart = 0.25;
  static constexpr double kLeast = 1e-12;
  static constexpr double kMost = 1e-4;
  static constexpr double kFiner = 100;

  double asked_;
  double tolerance_;
  double before_;
};

}  // namespace haptometer::sim
