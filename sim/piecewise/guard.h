#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/error.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"

namespace haptometer::sim {

/// g and its first three derivatives by time.
using GuardJet = std::array<double, 4>;

/// What is certain about a guard over an interval that it begins at g >= 0.
enum class GuardVerdict : std::uint8_t {
  kClear,    ///< g >= 0 all the way
  kCrosses,  ///< g falls through zero exactly once
  kDips,     ///< g is convex with its minimum inside: its value there decides
  kUnknown,  ///< the interval is too long to tell
};

/// Bounds of |g''|, |g'''|, |g''''| over an interval.
using GuardBounds = std::array<double, 3>;

/// The decision, from the ends of the interval [0, h] and bounds M2, M3, M4 that hold all over it.
/// By Taylor's theorem, for g(0) >= 0:
///
///   min(g(0), g(h)) > M2 h^2/8        clear (g lies at most M2 h^2/8 below its chord)
///   g'(0) > M2 h/2                    clear (g >= g(0) + s (g'(0) - M2 s/2))
///   g'(0) or g'(h) < -M2 h            g falls all the way: g(h) decides
///   |g''(0)| or |g''(h)| > M3 h       g'' keeps its sign. Concave: the lesser end is the least
///                                     value, and g(h) < 0 means one crossing. Convex: clear if g
///                                     rises at 0, g(h) decides if it falls at h, else it dips
///   g'''(0) > M4 h, g'(0), g''(0) >= 0   clear
///   otherwise                         unknown: halve the interval
///
/// None of it needs a sample to hit anything: a double crossing or a graze cannot hide.
[[nodiscard]] GuardVerdict Judge(const GuardJet& begin, const GuardJet& end,
                                 const GuardBounds& bounds, double h_s);

/// The rule of accumulation (sim/linear/mode.h): how long the bounces take that follow an impact,
/// behind which the gap has the jet `after`, where all of them are lower than `height`; nothing
/// where they are to be played one by one.
[[nodiscard]] std::optional<double> TimeToRest(const Bounce& bounce, const GuardJet& after,
                                               double height);

/// A guard g = row z + offset of z' = G z, z = [x, w] (excitation.h), with its derivatives
/// g^(k) = row G^k z and bounds of them over any interval up to a horizon.
///
/// |row G^k exp(G s) z| <= beta_k |z| with beta_k >= |row G^k exp(G s)| entry by entry for all s in
/// [0, horizon]: the largest values on a grid of spacing r, 4 r |G|_1 <= 1 (balanced), times
/// exp(|G| r), which covers what lies between (|y exp(G r)| <= |y| exp(|G| r)), times 1 + 2^-20 for
/// rounding. Sines enter by their amplitudes, so that the bound holds at any phase.
class GuardBound {
 public:
  /// The longest horizon that set-up covers with 256 points of the grid: 64 / |G|_1, balanced.
  [[nodiscard]] static double LongestHorizon(const Eigen::MatrixXd& generator);

  /// `row` has the entries of z, the last of which are the `pairs`' (ExcitationShape). Cost:
  /// horizon |G|_1 / 16 us or so.
  GuardBound(const Eigen::MatrixXd& generator, const Eigen::RowVectorXd& row, double offset,
             const ExcitationShape& shape, double horizon_s);

  [[nodiscard]] double Value(const Eigen::VectorXd& x, const Eigen::VectorXd& w) const {
    HAPTOMETER_CHECK(x.size() + w.size() == row_.size(), "{} of {}", x.size(), row_.size());
    const double value = Eigen::VectorXd::Map(row_.data(), x.size()).dot(x) + offset_;
    return feeds_ ? value + row_.tail(w.size()).dot(w) : value;
  }
  [[nodiscard]] GuardJet Jet(const Eigen::VectorXd& x, const Eigen::VectorXd& w) const;
  /// M2 alone, from the state at the interval's beginning and LargestSignals.
  [[nodiscard]] double SecondBound(const Eigen::VectorXd& x, const Eigen::VectorXd& largest) const {
    HAPTOMETER_CHECK(x.size() + largest.size() == second_bound_.size(), "{} of {}", x.size(),
                     second_bound_.size());
    const double* bound = second_bound_.data();
    return Eigen::VectorXd::Map(bound, x.size()).dot(x.cwiseAbs()) +
           Eigen::VectorXd::Map(bound + x.size(), largest.size()).dot(largest);
  }
  /// All three. M3 and M4 are set up when first asked for.
  [[nodiscard]] GuardBounds Bounds(const Eigen::VectorXd& x, const Eigen::VectorXd& largest);
  /// What rounding may make of a value that is zero: 2^-44 of the sum's terms in x.
  [[nodiscard]] double Noise(const Eigen::VectorXd& x) const;

 private:
  [[nodiscard]] Eigen::MatrixXd LargestOver(Eigen::MatrixXd rows) const;

  Eigen::MatrixXd generator_;
  std::vector<Eigen::Index> pairs_;  // of z
  double horizon_s_;
  Eigen::VectorXd row_;  // (n + m)
  double offset_;
  bool feeds_;                     // w counts in the value itself
  Eigen::MatrixXd derivatives_;    // (4, n + m): row G^k
  Eigen::VectorXd second_bound_;   // (n + m): beta_2; of a pair in its first
  Eigen::MatrixXd higher_bounds_;  // (2, n + m): beta_3, beta_4; empty until asked for
};

/// Where in [from, 1] a polynomial, c0 + c1 u + c2 u^2 ..., first falls below zero; nothing if it
/// never does.
///
/// Decided by the signs of its Bernstein coefficients (Descartes' rule: none negative, no fall; one
/// change of sign, one root), halving what they leave open. So two crossings close together cannot
/// hide, and it always ends: 2^-52 is as far as places are told apart. Returned is the last place
/// at which the polynomial is not yet negative, or `from`.
///
/// Coefficients that are not finite count as no fall. Cost: degree^2 flops where the polynomial
/// stays clear of zero.
[[nodiscard]] std::optional<double> FirstFall(const Eigen::VectorXd& coefficients, double from);

/// Extends a range by what the polynomial comes to inside [from, to], its ends left out.
///
/// Its Bernstein coefficients bound it: parts that lie within the range, or in which the
/// coefficients only rise or only fall, hold nothing new; others are halved down to 2^-26, where an
/// extreme is flat to rounding.
void ExtendRange(const Eigen::VectorXd& coefficients, double from, double to, ValueRange& range);

/// The polynomial's value at u.
[[nodiscard]] double PolynomialValue(const Eigen::VectorXd& coefficients, double u);

/// Where in [0, to] the polynomial, negative at `to`, was last not negative; `to` if it never was.
[[nodiscard]] double LastAbove(const Eigen::VectorXd& coefficients, double to);

}  // namespace haptometer::sim
