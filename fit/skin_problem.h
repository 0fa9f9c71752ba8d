#pragma once

#include <optional>
#include <vector>

#include "fit/grouped_noise.h"
#include "fit/skin_fit.h"

namespace haptometer::fit {

/// A sweep on the skin as least squares over ln Ks, ln Bs, m: residuals of the amplitudes (divided
/// by their relative standard uncertainties, or else by 1), then of the phases where they are
/// measured.
class SkinProblem {
 public:
  SkinProblem(sim::Actuator actuator, DriveQuantity drive, std::vector<SkinPoint> points);

  /// The problem; refers to this object.
  [[nodiscard]] LeastSquares Whole() const;
  [[nodiscard]] NoiseGroups Groups() const;
  /// The residuals with another actuator, for the response to its constants.
  [[nodiscard]] std::vector<double> ResidualsWith(const sim::Actuator& actuator,
                                                  const std::vector<double>& parameters) const;
  /// The amplitudes that the parameters give.
  [[nodiscard]] std::vector<double> Amplitudes(const std::vector<double>& parameters) const;

  [[nodiscard]] const std::vector<SkinPoint>& points() const { return points_; }
  [[nodiscard]] const sim::Actuator& actuator() const { return actuator_; }
  [[nodiscard]] bool has_phases() const { return has_phases_; }
  [[nodiscard]] bool has_uncertainties() const { return has_uncertainties_; }

  /// Turns all phases by pi: a coil's polarity is free.
  void TurnPhases();

 private:
  bool Evaluate(const sim::Actuator& actuator, std::span<const double> at,
                std::span<double> residuals, std::span<double> jacobian) const;
  [[nodiscard]] std::size_t Residuals() const;

  sim::Actuator actuator_;
  DriveQuantity drive_;
  std::vector<SkinPoint> points_;
  bool has_phases_;
  bool has_uncertainties_;
};

/// Solutions of the unweighted problem from the best cells of a grid (Ks 10 to 1e5 N/m, Bs 0.01 to
/// 100 N s/m, m 0 to 20 Mc), best first, those that differ by less than 1 % once.
struct SkinStart {
  std::vector<double> parameters;
  double cost = 0;
};
[[nodiscard]] std::vector<SkinStart> StartSkin(const SkinProblem& problem);

}  // namespace haptometer::fit
