#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace haptometer::dsp {

inline constexpr std::size_t kMostSignFlips = 20;

/// The exact two-sided sign-flip test of paired differences: the share of all 2^n choices of signs
/// whose |sum| reaches that of the differences as they are. The least p that n differences can give
/// is 2^(1-n): 0.0078 for 8.
///
/// Sums that differ by less than 1e-12 of the sum of |differences| count as equal (they are sums of
/// the same numbers in another rounding). Valid where the differences are symmetric about 0 under
/// the null hypothesis (R. A. Fisher, The Design of Experiments, 1935, 21). Nothing for no or more
/// than 20 values. Cost: n 2^(n-1) additions, 10 ms for 20.
[[nodiscard]] std::optional<double> SignFlipP(std::span<const double> differences);

}  // namespace haptometer::dsp
