#pragma once

#include <limits>
#include <vector>

#include "fit/drop_test/prepared_record.h"

namespace haptometer::fit {

/// How the results of drops alike scatter.
struct DropScatter {
  /// Over what their own uncertainties explain: the Birge ratio sqrt(sum ((x - mean)/u)^2 / (n -
  /// 1)), Birge, Physical Review 40, 1932, p. 207. 1 where one drop stands alone, or where the
  /// scatter is within what 1 of 100 sets without further causes reaches.
  double birge_ratio = 1;
  double degrees = std::numeric_limits<double>::infinity();  ///< n - 1 where the ratio is above 1

  void TakeLarger(const DropScatter& other) {
    if (other.birge_ratio > birge_ratio) *this = other;
  }
};

/// How the drops of one actuator agree with each other and each with itself.
struct Consistency {
  DropScatter frequency;  ///< of the natural frequency, over drops with the same case and load
  DropScatter decay;      ///< of the decay rate, over the same
  /// By which the uncertainties of the fit of all drops together are too small: as the ratios, but
  /// against the noise of that fit, which has taken in part of the scatter already; and as much as
  /// dry friction that is fitted along, or what a later begin of a drop says, leaves open. At
  /// least 1.
  double frequency_widening = 1;
  double decay_widening = 1;
  Findings findings;  ///< doubts, and, as refusals, what makes the constants useless
};

/// One drop and what it must have in common with others to be compared.
struct ComparedDrop {
  const PreparedRecord* prepared = nullptr;
  double load_ohm = 0;
  double mass_ratio = 1;  ///< ringing mass over that of the others
  double noise_v = 0;     ///< that the fit of all drops together takes for this one's
};

/// Fits each drop's pole pair by itself (ring_fit.h), from the begin of its part and once more from
/// one decay time later.
///
/// Drops alike are compared by their Birge ratios, their chi^2 at 1 %. A drop whose resonance or
/// decay from the later start differs from the whole's by more than 4 standard deviations of that
/// difference (Hausman, Econometrica 46, 1978, p. 1251: the square is that of the later fit less
/// that of the whole) rings otherwise when it is small: a spring that stiffens or softens with
/// travel, friction, air. A drop that its own ring-down explains better than the fit of all
/// together does, by more than chance, contradicts the others. Records damped beyond 0.3 of
/// critical are not compared. Cost: two one-record fits a drop, some ms.
[[nodiscard]] Consistency CheckConsistency(const std::vector<ComparedDrop>& drops);

}  // namespace haptometer::fit
