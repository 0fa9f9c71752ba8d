#pragma once

namespace haptometer::dsp {

/// From `lower` to `upper`, in the unit of what it encloses. All confidence intervals of
/// dsp/statistics are two-sided, of level 95 %.
struct Interval {
  double lower = 0;
  double upper = 0;
};

inline constexpr double kConfidence = 0.95;

}  // namespace haptometer::dsp
