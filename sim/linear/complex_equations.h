#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

namespace haptometer::sim {

/// |z| of each entry, sqrt(re^2 + im^2), to 2 ulp where that is from 1e-146 to 1e154: Eigen's own
/// is the C library's, whose last bit depends on the processor.
[[nodiscard]] Eigen::MatrixXd Magnitudes(const Eigen::MatrixXcd& matrix);

/// The factors of a complex matrix M = P + jQ, by its real form
///
///   [P, -Q; Q, P] [Re x; Im x] = [Re b; Im b],
///
/// whose pivots are chosen without the C library's |z|: the bytes are the same on each x86-64.
/// Cost: some us for (7, 7).
class ComplexEquations {
 public:
  /// (n, n), finite.
  explicit ComplexEquations(const Eigen::MatrixXcd& matrix);

  /// x of M x = b, (n); not finite where M is singular.
  [[nodiscard]] Eigen::VectorXcd Solve(const Eigen::VectorXcd& right) const;
  [[nodiscard]] Eigen::MatrixXd InverseParts() const;  ///< (n, 2n): [Re M^-1, Im M^-1]
  /// An estimate of 1 / (|M| |M^-1|) in the real form's 1-norm; 0 or not finite: singular.
  [[nodiscard]] double ReciprocalCondition() const { return factors_.rcond(); }

 private:
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
};

}  // namespace haptometer::sim
