#pragma once

#include <optional>
#include <vector>

namespace haptometer::fit {

// What can be told of a record's values before its ring-down is known: for start values only.

/// `values` with holes (NaN) bridged by straight lines; the ends are continued.
[[nodiscard]] std::vector<double> Filled(const std::vector<double>& values);

/// The amplitude at a resonance in the period that follows each sample, times half of its samples;
/// shorter than `values` by a period. It begins to rise a period before a blow, and noise of any
/// single sample does not move it. `middle_v` is taken off first.
[[nodiscard]] std::vector<double> FollowingAmplitude(const std::vector<double>& values,
                                                     double middle_v, double period_samples);

/// Standard deviation of the white noise of single samples: of third differences d, the median of
/// abs(d) times 1.4826, over sqrt(1 + 9 + 9 + 1). A ringing of 20 samples a period and more leaves
/// less than 1 % of its amplitude there. At least 4 values, without holes. Cost: O(n).
[[nodiscard]] double NoiseOfSamples(const std::vector<double>& values);

/// `values` less what goes on all along, which may hold more power than a ring-down that ends: a
/// slow course (a polynomial of degree 4), and hum of 50 and 60 Hz where the record is long enough
/// to tell them apart (0.1 s). Holes (NaN) stay, and so does the mean. Nothing where these are
/// weak.
///
/// They are fitted by least squares to means of at most 1 ms, and are strong where they take more
/// than a fifth off the median of the mean squares of 16 equal stretches. A ringing of amplitude A
/// that falls by e^-x in the record is weaker in the spectrum than a sine of A/x and more, which is
/// at least 1.3 times its amplitude A e^(-x/2) in the median stretch: such a sine takes 65 % off. A
/// ringing near 50 Hz that dies away takes nothing off.
/// Cost: some 0.2 us a block, and 50 ns a sample where something is taken off.
[[nodiscard]] std::optional<std::vector<double>> WithoutWhatLasts(const std::vector<double>& values,
                                                                  double step_s);

}  // namespace haptometer::fit
