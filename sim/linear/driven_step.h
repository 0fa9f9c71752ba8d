#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

namespace haptometer::sim {

/// A matrix in units that make its rows and columns of equal size.
struct BalancedMatrix {
  Eigen::MatrixXd matrix;  ///< (n, n): D^-1 A D
  Eigen::VectorXd scale;   ///< (n): the diagonal of D, powers of two
};

/// Balances a square matrix by a diagonal of powers of two, which is exact in binary: a change of
/// units. B. N. Parlett and C. Reinsch, "Balancing a matrix for calculation of eigenvalues and
/// eigenvectors", Numer. Math. 13, 293-304 (1969), without their permutations.
[[nodiscard]] BalancedMatrix Balance(const Eigen::MatrixXd& a);

/// exp(A) of a square, finite matrix: balanced, then scaling and squaring with a Pade approximant
/// of degree up to 13 (N. J. Higham, SIAM J. Matrix Anal. Appl. 26, 1179-1193 (2005), as in Eigen).
///
/// Balancing comes first because the norm of a matrix in SI units says nothing: without it the
/// thesis's model loses 4-6 digits and C. Moler's example ("A Balancing Act for the Matrix
/// Exponential", 2012) comes out 18 % wrong in its first entry. Cost: a few microseconds for (9,
/// 9).
[[nodiscard]] Eigen::MatrixXd MatrixExponential(const Eigen::MatrixXd& a);

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

/// exp(A t) with the 64-bit mantissa of long double throughout, t included: the error eps |A| t of
/// a step over 10^8 periods of the fastest state is 2000 times smaller. Cost: 0.1 ms for (9, 9).
[[nodiscard]] LongMatrix LongMatrixExponential(const LongMatrix& a, long double t);

struct ExcitationShape;
struct Mode;

/// G of z = [x, w], z' = G z, for x' = A x + inputs u, u and w as `shape` has them: (n + m, n + m).
[[nodiscard]] Eigen::MatrixXd DrivenGenerator(const Eigen::MatrixXd& a,
                                              const Eigen::MatrixXd& inputs,
                                              const ExcitationShape& shape);

/// The mode's under an excitation of that shape, in long double and with what rounding left out of
/// a and b: for modes that have a rest.
[[nodiscard]] LongMatrix LongDrivenGenerator(const Mode& mode, const ExcitationShape& shape);

/// [sin w t, cos w t], the phase from the whole number of cycles on: exact to rounding at any time.
[[nodiscard]] Eigen::Vector2d DriveAt(double frequency_hz, long double t_s);

/// (n, n + 2): the states after h_s from the states before and the drive *after* the step.
///
/// exp(G h) = [[E, V], [0, R]], R the drive's turn over h; the step is [E, V R^-1]. What the bodies
/// still feel of the drive lies near the end of a long step, so its phase is not carried across
/// thousands of cycles. Cost: one exponential.
///
/// `signals`: how many the drive has, 2 of a sine; (n, n + signals).
[[nodiscard]] Eigen::MatrixXd DrivenStep(const Eigen::MatrixXd& generator, double h_s,
                                         Eigen::Index signals);

/// The same in long double, for steps so long that eps |G| h counts.
[[nodiscard]] LongMatrix LongDrivenStep(const LongMatrix& generator, long double h_s,
                                        Eigen::Index signals);

/// DriveAt at equal times start_s + i / rate_hz, cheaper where they are asked for one after the
/// other: each from the phase of the 32nd sample before it at most and a turn that is kept. What
/// it gives for a sample does not depend on what was asked before.
class DriveSequence {
 public:
  DriveSequence(double frequency_hz, double start_s, double rate_hz);
  [[nodiscard]] Eigen::Vector2d At(std::uint64_t sample) {
    const std::uint64_t k = sample % kTurns;
    if (sample - k != begin_sample_) Begin(sample - k);
    const Eigen::Vector2d& turn = turns_[k];
    return {begin_[0] * turn[1] + begin_[1] * turn[0], begin_[1] * turn[1] - begin_[0] * turn[0]};
  }

 private:
  static constexpr std::size_t kTurns = 32;
  void Begin(std::uint64_t sample);

  double frequency_hz_;
  long double start_s_;
  long double rate_hz_;
  std::array<Eigen::Vector2d, kTurns> turns_;
  Eigen::Vector2d begin_ = Eigen::Vector2d::Zero();
  std::uint64_t begin_sample_ = 0;
};

}  // namespace haptometer::sim
