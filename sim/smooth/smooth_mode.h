#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "sim/linear/excitation.h"
#include "sim/piecewise/guard.h"
#include "sim/smooth/semilinear_solver.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {

/// The highest frequency among a piece's tones; 0 without any.
[[nodiscard]] double HighestFrequencyHz(const ExcitationPiece& piece);

/// One mode of a smooth system under a piece of its excitation: y = [x, theta], theta where the
/// coil heats. g is the spring's force beyond the linear one's, of the deflection, and where the
/// coil heats the voltage across the rise of its resistance and its power over C, of current and
/// theta. The integrals are the input, each dissipating element (J), each of the squared rows
/// (times s) and i^2 (A^2 s); none where no energies are asked for.
///
/// Time counts from `origin_s`, where the mode was entered, so that it has its digits for what is
/// near.
class SmoothMode final : public SemilinearProblem {
 public:
  SmoothMode(const SmoothSystem& system, std::size_t mode, const ExcitationPiece& piece,
             bool with_energy);

  /// From here on: a piece, which goes on smoothly beyond its end, and where the mode is entered.
  void Begin(const ExcitationPiece& piece, long double origin_s);

  [[nodiscard]] const Linear& linear() const override { return linear_; }
  /// The coil's resistance in steps of a fifth.
  [[nodiscard]] int Linearise(const ConstVector& y) override;
  void Inputs(double t_s, Vector u) const override;
  void Feedback(const ConstVector& u, const ConstVector& readings, Vector g) const override;
  [[nodiscard]] Eigen::Index integrals() const override;
  void IntegralRate(const ConstVector& u, const ConstVector& y, Vector rate) const override;

  [[nodiscard]] Eigen::Index states() const;
  /// y'.
  [[nodiscard]] Eigen::VectorXd Rate(double t_s, const Eigen::VectorXd& y) const;

  /// g, g', g'', g''' of a guard. Of a gap all are exact; of a force without inductance what the
  /// coil's heating changes is left out, and of a fed input its third derivative.
  [[nodiscard]] GuardJet Jet(std::size_t guard, double t_s, const Eigen::VectorXd& y) const;
  /// g alone.
  [[nodiscard]] double Value(std::size_t guard, double t_s, const Eigen::VectorXd& y) const;
  /// A watched number.
  [[nodiscard]] double Value(const WatchedNumber& number, double t_s,
                             const Eigen::VectorXd& y) const;
  /// The coil's current in A.
  [[nodiscard]] double Current(double t_s, const Eigen::VectorXd& y) const;
  /// The mode's quadratic form and the spring's energy.
  [[nodiscard]] double StoredEnergy(double t_s, const Eigen::VectorXd& y) const;

  /// How large each state becomes within the first period, by the linear part: the magnitudes of
  /// (s I - A)^-1 (B u + w x0) at s = (0.1 + j) w, with a tenth of damping so that it always
  /// exists; summed over the piece's terms.
  [[nodiscard]] Eigen::VectorXd ScaleFrom(const Eigen::VectorXd& y) const;
  /// The rise at which the coil would stay under the currents of that scale; 0 where no heat
  /// leaves.
  [[nodiscard]] double LastRise(const Eigen::VectorXd& scale) const;
  /// How large the integrals become in a radian of the drive at that scale: all energies the same.
  [[nodiscard]] Eigen::VectorXd IntegralScale(const Eigen::VectorXd& scale) const;

 private:
  [[nodiscard]] const Mode& mode() const { return system_->linear.modes[mode_]; }
  [[nodiscard]] Eigen::Index n() const { return mode().a.rows(); }
  // u, u' or u''
  [[nodiscard]] Eigen::Vector3d InputsThen(double t_s, std::size_t derivative = 0) const;
  [[nodiscard]] double Pace() const;
  // bounds of u over the piece; the source of one term
  [[nodiscard]] Eigen::Vector3d LargestInputs() const;
  [[nodiscard]] Eigen::Vector3d SourceOf(const ExcitationTerm& term) const;
  [[nodiscard]] double PaceOf(const ExcitationTerm& term) const;
  [[nodiscard]] double LargestCurrent(const Eigen::VectorXd& scale) const;
  // R(theta) - R0 and the current
  struct Coil {
    double rise_ohm = 0;
    double current_a = 0;
    double held_back = 1;  // d current / d (current without the rise)
  };
  [[nodiscard]] Coil CoilAt(double volt, const Eigen::Ref<const Eigen::VectorXd>& y) const;
  [[nodiscard]] double RisePerKelvin() const;
  [[nodiscard]] double HeldBack(double rise_ohm) const {
    return 1 / (1 + mode().current_per_volt * rise_ohm);
  }
  [[nodiscard]] Eigen::MatrixXd Jacobian(double t_s, const Eigen::VectorXd& y) const;
  void SetLinear();
  [[nodiscard]] Eigen::RowVectorXd RowOfPositions(const Eigen::RowVectorXd& row) const;

  const SmoothSystem* system_;
  std::size_t mode_;
  bool with_energy_;
  Eigen::MatrixXd inputs_;  // (n, kInputs)
  Linear linear_;
  int linearisation_ = 0;
  double linear_rise_ohm_ = 0;  // R(theta) - R0 that is part of linear_
  ExcitationPiece piece_;
  std::array<Eigen::MatrixXd, 3> rows_;  // (kInputs, m): u, u', u'' of the piece's signals
  mutable Eigen::VectorXd signals_;      // work space
  long double origin_s_ = 0;
};

}  // namespace haptometer::sim
