#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/linear/mode.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// Where the energy went since the beginning: electrical in = stored now - stored at first
/// + dissipated + lost in impacts.
struct EnergyLedger {
  double initial_j = 0;                ///< stored at the beginning
  double stored_j = 0;                 ///< stored now
  double input_j = 0;                  ///< integral of v i: what the source gave
  double impact_j = 0;                 ///< lost in jumps of speed; negative would be a gain
  std::vector<double> dissipated_j{};  ///< as PiecewiseLinearSystem::dissipating_elements

  /// |input + initial - stored - dissipated - impact| over the larger of the initial energy and the
  /// throughput (what came in or went out, whichever is more); 0 where nothing ever moved.
  [[nodiscard]] double Imbalance() const;
};

/// Integrals over a step h as quadratic forms of z = [x, w] (excitation.h) at its beginning.
struct StepEnergy {
  Eigen::MatrixXd input_j;                      ///< (n + m, n + m)
  std::vector<Eigen::MatrixXd> dissipated_j{};  ///< the same; (0, 0) where an element rests
  std::vector<Eigen::MatrixXd> squares{};       ///< of the system's squared_rows, times s
};

/// The mode's energies over h, exact, not sampled: z' S z with
///
///   S(h) = integral of exp(G' s) Q exp(G s) over [0, h],  S(2h) = S(h) + exp(G' h) S(h) exp(G h)
///
/// from a step so short that its Taylor series has 16 terms. Where Q is a square the sums have one
/// sign and lose no digits. Cost: a doubling per factor of two in |G| h, 10 to 100 us.
[[nodiscard]] StepEnergy EnergyOver(const Mode& mode,
                                    const std::vector<Eigen::RowVectorXd>& squared_rows,
                                    const Eigen::MatrixXd& generator,
                                    const Eigen::MatrixXd& input_rows, double h_s);

}  // namespace haptometer::sim
