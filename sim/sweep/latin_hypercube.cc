#include "sim/sweep/latin_hypercube.h"

#include <bit>

#include "base/error.h"
#include "sim/sweep/counter_random.h"

namespace haptometer::sim {
namespace {

constexpr std::uint32_t kRounds = 8;  // Luby and Rackoff prove 4 for large halves; ours are small
constexpr std::uint64_t kMostSamples = 1ULL << 30U;
constexpr std::uint32_t kPlaceBits = 22;  // with 30 of the part they are exact in a double

// what a random number is for: the last word of its counter
enum class Purpose : std::uint32_t { kPermutation = 0, kPlace = 1 };

std::uint32_t Random(std::uint32_t first, std::uint32_t second, std::uint32_t axis, Purpose purpose,
                     std::uint64_t seed) {
  return CounterRandom({first, second, axis, static_cast<std::uint32_t>(purpose)}, seed)[0];
}

}  // namespace

std::uint64_t LatinHypercube::PartOf(std::uint32_t axis, std::uint64_t point) const {
  HAPTOMETER_CHECK(samples >= 1 && samples <= kMostSamples && point < samples, "point {} of {}",
                   point, samples);
  const auto bits = static_cast<std::uint32_t>(std::bit_width(samples - 1));
  const std::uint32_t half_bits = bits < 2 ? 1 : (bits + 1) / 2;
  const std::uint32_t mask = (1U << half_bits) - 1;
  std::uint64_t part = point;
  do {
    auto left = static_cast<std::uint32_t>(part >> half_bits);
    std::uint32_t right = static_cast<std::uint32_t>(part) & mask;
    for (std::uint32_t round = 0; round < kRounds; ++round) {
      const std::uint32_t mixed =
          left ^ (Random(right, round, axis, Purpose::kPermutation, seed) & mask);
      left = right;
      right = mixed;
    }
    part = (std::uint64_t{left} << half_bits) | right;
  } while (part >= samples);
  return part;
}

double LatinHypercube::PlaceInPart(std::uint32_t axis, std::uint64_t point) const {
  const std::uint32_t steps =
      Random(static_cast<std::uint32_t>(point), 0, axis, Purpose::kPlace, seed) >>
      (32U - kPlaceBits);
  return (steps + 0.5) / static_cast<double>(1U << kPlaceBits);
}

}  // namespace haptometer::sim
