#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>

#include "sim/findings.h"
#include "sim/linear/mode.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/scene/scene.h"
#include "sim/smooth/smooth_motion.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {

/// The state at phase 0 of the drive, v = V sin(w t) at t = 0: a mode and its coordinates, without
/// a state that is always 1, then the coil's rise where it heats.
struct PeriodPoint {
  std::size_t mode = 0;
  Eigen::VectorXd x;
};

/// Means over the time that was played, integrated, not sampled.
struct PeriodMeans {
  Eigen::VectorXd mean_squares;   ///< of each of the system's positions (LinearModel's states)
  double travel_mean_square = 0;  ///< of xv - xa, in m^2
  double power_w = 0;             ///< taken from the source
  double coil_w = 0;              ///< of it into the coil's resistance
  Eigen::VectorXd largest;        ///< of |position|, over 64 outputs a period
  std::size_t events = 0;
};

/// Where a point is after some periods.
struct PeriodStep {
  PeriodPoint point;
  std::int64_t steps = 0;              ///< the work: intervals judged, or the solver's steps
  std::optional<PeriodMeans> means{};  ///< if asked for
};

/// The motion over whole periods of its drive, from phase 0 to phase 0; where it stalls, why.
class PeriodMap {
 public:
  /// Exact: PiecewiseMotion.
  PeriodMap(PiecewiseLinearSystem system, const SineDrive& drive);
  /// SmoothMotion at settings.tolerance.
  PeriodMap(SmoothSystem system, const SineDrive& drive, const SmoothSettings& settings);

  /// Is shown where a motion is after each of its periods.
  using Visit = std::function<void(const PeriodPoint&)>;

  /// Matrices of the exact motion are kept from one call to the next.
  [[nodiscard]] std::expected<PeriodStep, FindingKind> After(const PeriodPoint& point, int periods,
                                                             bool with_means = false,
                                                             const Visit& visit = {}) const;
  /// A state at phase 0 in a mode's coordinates as a point.
  [[nodiscard]] PeriodPoint PointOf(std::size_t mode, const Eigen::VectorXd& x,
                                    double temperature_rise_k = 0) const;
  /// The other way round.
  [[nodiscard]] PiecewiseStart StartOf(const PeriodPoint& point) const;
  /// How large each of a point's coordinates becomes: within a period (SmoothMode::ScaleFrom), the
  /// coil's rise in the end; never 0.
  [[nodiscard]] Eigen::VectorXd ScaleOf(const PeriodPoint& point) const;
  /// Relative: 1e-13 of the exact motion, the tolerance of the other.
  [[nodiscard]] double error() const { return error_; }
  /// Whether a point's last coordinate is the coil's temperature.
  [[nodiscard]] bool heats() const { return system_.heating.has_value(); }

 private:
  template <typename Motion>
  [[nodiscard]] std::expected<PeriodStep, FindingKind> Play(Motion& motion, int periods,
                                                            int outputs, bool with_means,
                                                            const Visit& visit) const;

  SmoothSystem system_;
  SineDrive drive_;
  std::optional<SmoothSettings> settings_;  // absent: exact
  double error_;
  // without means; their matrices are kept between calls
  mutable std::unique_ptr<PiecewiseMotion> exact_;
  mutable std::unique_ptr<SmoothMotion> smooth_;
};

}  // namespace haptometer::sim
