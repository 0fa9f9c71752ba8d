#pragma once

#include <cstddef>
#include <cstdint>

#include "fit/drop_test/ring_fit.h"

namespace haptometer::fit {

/// A disturbance that the residual of a fitted ring-down was tried for.
struct Suspect {
  enum class Kind : std::uint8_t { kNone, kDrift, kHum, kBlow, kNonlinear, kFriction };
  Kind kind = Kind::kNone;
  double value = 0;  ///< frequency in Hz, or time in s
  double amplitude_v = 0;
  bool is_positive = false;  ///< of the first column
  std::size_t first = 0;     ///< of an impact: the sample behind it
  double gain = 0;           ///< decrease of power per column, in mean squares of the residual
};

/// Least gain of dry friction, of one column whose sign is known: white noise exceeds it in 1 of
/// 4000 records.
inline constexpr double kLeastFrictionGain = 12;

/// Of the disturbances that are not yet part of a fit, the one that reduces the residual most, by
/// more than chance and of more than a least amplitude (disturbances.h); kNone where none does.
///
/// Each is tried by least squares of its own columns, with what the fitted columns already contain
/// projected out. Friction comes before impacts, which a motion that it stops resembles. Impacts
/// are tried half a period apart, then around the best of these.
/// @param samples those that `fit` is of
/// @param fit of a ring-down with its background
/// @param background of the fit
/// @param may_have_friction whether friction is tried
/// @param may_have_blows whether impacts are
[[nodiscard]] Suspect WorstSuspect(const RingSamples& samples, const RingFit& fit,
                                   const RingBackground& background, bool may_have_friction,
                                   bool may_have_blows);

/// Undamped period 2 pi/sqrt(q), s.
[[nodiscard]] double PeriodOf(const PolePair& poles);

}  // namespace haptometer::fit
