#pragma once

#include <vector>

namespace haptometer::fit {

/// `values` with holes (NaN) bridged by straight lines: for start values only.
[[nodiscard]] std::vector<double> Filled(const std::vector<double>& values);

/// The amplitude at a resonance in the period that follows each sample, times half of its samples;
/// shorter than `values` by a period. It begins to rise a period before a blow, and noise of any
/// single sample does not move it. `middle_v` is taken off first.
[[nodiscard]] std::vector<double> FollowingAmplitude(const std::vector<double>& values,
                                                     double middle_v, double period_samples);

}  // namespace haptometer::fit
