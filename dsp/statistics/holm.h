#pragma once

#include <optional>
#include <span>
#include <vector>

namespace haptometer::dsp {

/// Holm's adjusted p values, in the order of `p`: p(k), k-th smallest of m, becomes
///   max over j <= k of min(1, (m - j + 1) p(j))
/// Rejecting those below alpha keeps the chance of any false rejection below alpha, however the
/// tests depend on each other (S. Holm, Scandinavian Journal of Statistics 6(2), 1979).
[[nodiscard]] std::vector<double> HolmAdjusted(std::span<const double> p);

/// The same over the tests that there are: nothing stays nothing, and does not count.
[[nodiscard]] std::vector<std::optional<double>> HolmOverTested(
    std::span<const std::optional<double>> p);

}  // namespace haptometer::dsp
