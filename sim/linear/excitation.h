#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "sim/linear/mode.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// One signal on one input, over a piece of time.
///
///   tone         amplitude sin(2 pi frequency_hz (t - origin_s) + phase_rad)
///   ramped tone  the same with amplitude + amplitude_per_s tau, tau counted from the piece's begin
///   polynomial   sum of derivatives[k] tau^k / k!, k up to degree
struct ExcitationTerm {
  enum class Kind : std::uint8_t { kTone, kRampedTone, kPolynomial };
  Kind kind = Kind::kTone;
  Eigen::Index input = kVoltage;  ///< or kFinger, whose rate follows by itself
  double amplitude = 0;
  double amplitude_per_s = 0;
  double frequency_hz = 0;
  double phase_rad = 0;
  double origin_s = 0;
  int degree = 0;
  std::array<double, 4> derivatives{};
};

/// Terms that hold for begin_s <= t < end_s.
struct ExcitationPiece {
  long double begin_s = 0;
  long double end_s = std::numeric_limits<long double>::infinity();
  std::vector<ExcitationTerm> terms;  ///< at least one
};

/// Everything that acts from outside, in pieces that follow each other from t = 0.
///
/// Within a piece the inputs are u = C w, w' = S w: sines, cosines, ramps and cubics obey linear
/// equations of their own, so the motion under them is exact (C. F. Van Loan, IEEE Trans. Autom.
/// Control 23, 395-404 (1978)). What is neither is held by cubics with a stated error.
class Excitation {
 public:
  explicit Excitation(const SineDrive& drive);
  Excitation(const Drive& drive, const std::vector<Tone>& finger);

  [[nodiscard]] std::size_t size() const { return before_.size() + knots_; }
  [[nodiscard]] ExcitationPiece Piece(std::size_t place) const;
  /// How far the voltage may be from what was asked for, in V: of a chirp h^4/384 max|v''''| (its
  /// cubics' spacing h follows from its tolerance), else 0.
  [[nodiscard]] double voltage_error_v() const { return voltage_error_v_; }

 private:
  struct Knot {
    double value = 0;
    double slope = 0;
  };
  void AddTones(const std::vector<Tone>& tones, Eigen::Index input, ExcitationPiece& piece) const;
  void AddOffset(double offset_v);
  void AddSilence(long double begin_s, long double end_s);
  void AddBurst(const Drive& drive);
  void AddPulse(const Drive& drive);
  void HoldChirp(const Drive& drive);
  void HoldSamples(const Drive& drive);

  std::vector<ExcitationPiece> before_;  // what is not held
  std::vector<ExcitationTerm> lasting_;  // in every piece: the offset and the finger's motion
  // the intervals between knots at held_from_s_ + k / held_rate_hz_, then silence
  std::size_t knots_ = 0;
  double held_from_s_ = 0;
  double held_rate_hz_ = 1;
  int held_degree_ = 1;
  std::function<Knot(std::size_t)> knot_;
  double voltage_error_v_ = 0;
};

/// How many cubics hold a chirp within its tolerance, a whole number; the same in each millisecond
/// where the chirp lasts whole ones.
[[nodiscard]] double CubicsOf(const Drive& chirp);

/// The equations that a piece's terms obey: w' = generator w, u = rows w.
///
/// w: of a tone [sin, cos]; of a ramped one [sin, cos, tau sin, tau cos]; of a polynomial its value
/// and derivatives. Amplitudes of tones stand in `rows`, so that pieces which differ in phase or in
/// a polynomial's coefficients share all matrices.
struct ExcitationShape {
  Eigen::MatrixXd generator;  ///< (m, m)
  Eigen::MatrixXd rows;       ///< (kInputs, m)
  /// First of each pair that turns as a sine and a cosine do: bounded by its magnitude.
  std::vector<Eigen::Index> pairs;
};

[[nodiscard]] ExcitationShape ShapeOf(const ExcitationPiece& piece);
/// Whether ShapeOf gives the same.
[[nodiscard]] bool SameShape(const ExcitationPiece& one, const ExcitationPiece& other);
/// w at a time within the piece.
void FillSignals(const ExcitationPiece& piece, long double t_s, Eigen::VectorXd& w);
/// Bounds of |w| that hold all over the piece: of a pair its magnitude in the first entry, 0 in the
/// second.
[[nodiscard]] Eigen::VectorXd LargestSignals(const ExcitationPiece& piece);

}  // namespace haptometer::sim
