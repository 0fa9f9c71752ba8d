#pragma once

#include <array>
#include <cstdint>

namespace haptometer::sim {

/// 128 random bits that are a function of a counter and a key alone: no state, so the numbers of
/// one point of a sweep do not depend on which points are computed, where, or in which order.
///
/// Philox 4x32 with 10 rounds: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Parallel Random
/// Numbers: As Easy as 1, 2, 3, SC11, 2011, sections 3.3 and 4.3. Cost: about 10 ns.
[[nodiscard]] std::array<std::uint32_t, 4> CounterRandom(
    const std::array<std::uint32_t, 4>& counter, std::uint64_t key);

}  // namespace haptometer::sim
