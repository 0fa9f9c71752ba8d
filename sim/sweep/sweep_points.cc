#include "sim/sweep/sweep_points.h"

#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "base/elementary_functions.h"
#include "base/error.h"
#include "base/toml.h"

namespace haptometer::sim {

SweepValue NumberValue(double number) {
  std::string text = fmt::format("{}", number + 0.0);  // no -0
  return {.literal = text, .text = text};
}

SweepValue PlainValue(std::string_view word) {
  return {.literal = std::string(word), .text = std::string(word)};
}

SweepValue TextValue(std::string_view text) {
  return {.literal = TomlString(text), .text = std::string(text)};
}

double ValueAt(const SweepRange& range, double numerator, double denominator) {
  // end n / n rounds: 0.10000000000000002 for 0.1 and n = 3
  if (numerator == denominator) return range.end;
  // the mean of both ends, weighted by the part of the range
  if (range.spacing == Spacing::kLinear) {
    return (range.begin * (denominator - numerator) + range.end * numerator) / denominator;
  }
  // rounding grows with the exponent of a power: 30000.000000000015 in double
  const DoubleDouble ratio = DoubleDouble{range.end, 0} / DoubleDouble{range.begin, 0};
  const DoubleDouble way = DoubleDouble{numerator, 0} / DoubleDouble{denominator, 0};
  return ScaledPow(range.begin, ratio, way);
}

std::size_t CountOf(const SweepAxis& axis) {
  if (const auto* range = std::get_if<SweepRange>(&axis.values)) return range->count;
  return std::get<std::vector<SweepValue>>(axis.values).size();
}

SweepValue ValueOf(const SweepAxis& axis, std::size_t index) {
  HAPTOMETER_CHECK(index < CountOf(axis), "value {} of {}", index, CountOf(axis));
  const auto* range = std::get_if<SweepRange>(&axis.values);
  if (range == nullptr) return std::get<std::vector<SweepValue>>(axis.values)[index];
  return NumberValue(
      ValueAt(*range, static_cast<double>(index), static_cast<double>(range->count - 1)));
}

std::string WordOf(const SweepAxis& axis) {
  if (const auto* range = std::get_if<SweepRange>(&axis.values)) {
    const std::string_view log = range->spacing == Spacing::kLogarithmic ? "log:" : "";
    const std::string ends = fmt::format("{}{}:{}", log, range->begin, range->end);
    return range->count == 0 ? ends : fmt::format("{}:{}", ends, range->count);
  }
  std::string word;
  for (const SweepValue& value : std::get<std::vector<SweepValue>>(axis.values)) {
    if (!word.empty()) word += ',';
    word += value.text;
  }
  return word;
}

namespace {

// Philox4x32-10: Salmon et al. 2011, section 4.3
constexpr std::uint64_t kMultiplier0 = 0xD2511F53;
constexpr std::uint64_t kMultiplier1 = 0xCD9E8D57;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9;
constexpr std::uint32_t kWeyl1 = 0xBB67AE85;
constexpr int kPhiloxRounds = 10;

std::uint32_t Upper(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32U); }
std::uint32_t Lower(std::uint64_t word) { return static_cast<std::uint32_t>(word); }

}  // namespace

std::array<std::uint32_t, 4> CounterRandom(const std::array<std::uint32_t, 4>& counter,
                                           std::uint64_t key) {
  std::array<std::uint32_t, 4> word = counter;
  std::uint32_t key0 = Lower(key);
  std::uint32_t key1 = Upper(key);
  for (int round = 0; round < kPhiloxRounds; ++round) {
    // a round: two products of 32 x 32 bits, their halves exchanged and mixed with the key
    const std::uint64_t product0 = kMultiplier0 * word[0];
    const std::uint64_t product1 = kMultiplier1 * word[2];
    word = {Upper(product1) ^ word[1] ^ key0, Lower(product1), Upper(product0) ^ word[3] ^ key1,
            Lower(product0)};
    // the key follows a Weyl sequence
    key0 += kWeyl0;
    key1 += kWeyl1;
  }
  return word;
}

namespace {

constexpr std::uint32_t kShuffleRounds =
    8;  // Luby and Rackoff prove 4 for large halves; ours are small
constexpr std::uint64_t kMostSamples = 1ULL << 30U;
constexpr std::uint32_t kPlaceBits = 22;  // with 30 of the part they are exact in a double

// the use of a random number: the fourth word of its counter
enum class Purpose : std::uint32_t { kPermutation = 0, kPlace = 1 };

std::uint32_t Random(std::uint32_t first, std::uint32_t second, std::uint32_t axis, Purpose purpose,
                     std::uint64_t seed) {
  return CounterRandom({first, second, axis, static_cast<std::uint32_t>(purpose)}, seed)[0];
}

}  // namespace

std::uint64_t LatinHypercube::PartOf(std::uint32_t axis, std::uint64_t point) const {
  HAPTOMETER_CHECK(samples >= 1 && samples <= kMostSamples && point < samples, "point {} of {}",
                   point, samples);
  // a Feistel network permutes 2 half_bits bits, the fewest even number that holds all points
  const auto bits = static_cast<std::uint32_t>(std::bit_width(samples - 1));
  const std::uint32_t half_bits = bits < 2 ? 1 : (bits + 1) / 2;
  const std::uint32_t mask = (1U << half_bits) - 1;
  std::uint64_t part = point;
  do {
    auto left = static_cast<std::uint32_t>(part >> half_bits);
    std::uint32_t right = static_cast<std::uint32_t>(part) & mask;
    // each round mixes one half by a random function of the other, which can be inverted
    for (std::uint32_t round = 0; round < kShuffleRounds; ++round) {
      const std::uint32_t mixed =
          left ^ (Random(right, round, axis, Purpose::kPermutation, seed) & mask);
      left = right;
      right = mixed;
    }
    part = (std::uint64_t{left} << half_bits) | right;
    // cycle walking: results beyond the samples are permuted again until one is below
  } while (part >= samples);
  return part;
}

double LatinHypercube::PlaceInPart(std::uint32_t axis, std::uint64_t point) const {
  const std::uint32_t steps =
      Random(static_cast<std::uint32_t>(point), 0, axis, Purpose::kPlace, seed) >>
      (32U - kPlaceBits);
  // the middle of one of 2^22 steps
  return (steps + 0.5) / static_cast<double>(1U << kPlaceBits);
}

SweepPoints::SweepPoints(std::vector<SweepAxis> axes, const std::optional<LatinHypercube>& sampling)
    : axes_(std::move(axes)), sampling_(sampling) {
  HAPTOMETER_CHECK(!axes_.empty(), "a sweep without axes");
  for (const SweepAxis& axis : axes_) {
    const bool is_range = std::holds_alternative<SweepRange>(axis.values);
    const std::size_t count = CountOf(axis);
    HAPTOMETER_CHECK(is_range && sampling ? count == 0 : count > 0, "{}: {} values", axis.key,
                     count);
    if (sampling) continue;
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
    // saturates instead of an overflow
    size_ = size_ > kMost / count ? kMost : size_ * count;
  }
  if (sampling) size_ = sampling->samples;
}

SweepValue SweepPoints::SampledValue(std::size_t axis, std::uint64_t point) const {
  const auto number = static_cast<std::uint32_t>(axis);
  const std::uint64_t part = sampling_->PartOf(number, point);
  const auto* range = std::get_if<SweepRange>(&axes_[axis].values);
  if (range == nullptr) {
    // a list's values share the parts equally
    return ValueOf(axes_[axis], part * CountOf(axes_[axis]) / sampling_->samples);
  }
  const double place = static_cast<double>(part) + sampling_->PlaceInPart(number, point);
  return NumberValue(ValueAt(*range, place, static_cast<double>(sampling_->samples)));
}

std::vector<SweepValue> SweepPoints::At(std::uint64_t point) const {
  HAPTOMETER_CHECK(point < size_, "point {} of {}", point, size_);
  std::vector<SweepValue> values(axes_.size());
  std::uint64_t rest = point;
  // mixed radix, the last axis fastest
  for (std::size_t axis = axes_.size(); axis-- > 0;) {
    if (sampling_) {
      values[axis] = SampledValue(axis, point);
      continue;
    }
    const std::uint64_t count = CountOf(axes_[axis]);
    values[axis] = ValueOf(axes_[axis], rest % count);
    rest /= count;
  }
  return values;
}

}  // namespace haptometer::sim
