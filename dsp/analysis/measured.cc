#include "dsp/analysis/measured.h"

#include <array>
#include <cstdint>
#include <cstring>

namespace haptometer::dsp {

// both loops keep several results apart, so that no step waits for the one before it

bool AllOk(std::span<const trial::SampleStatus> statuses) {
  static_assert(static_cast<int>(trial::SampleStatus::kOk) == 0);
  std::array<std::uint64_t, 4> seen{};
  while (statuses.size() >= sizeof seen) {
    std::array<std::uint64_t, 4> words;
    std::memcpy(words.data(), statuses.data(), sizeof words);
    for (std::size_t lane = 0; lane < words.size(); ++lane) seen[lane] |= words[lane];
    statuses = statuses.subspan(sizeof words);
  }
  for (const trial::SampleStatus status : statuses) seen[0] |= static_cast<std::uint64_t>(status);
  return (seen[0] | seen[1] | seen[2] | seen[3]) == 0;
}

bool AllFinite(std::span<const double> values) {
  // x - x is 0, or NaN where x is none or infinite
  std::array<double, 8> sums{};
  while (values.size() >= sums.size()) {
    for (std::size_t lane = 0; lane < sums.size(); ++lane)
      sums[lane] += values[lane] - values[lane];
    values = values.subspan(sums.size());
  }
  for (const double value : values) sums[0] += value - value;
  double sum = 0;
  for (const double lane : sums) sum += lane;
  return sum == 0;
}

}  // namespace haptometer::dsp
