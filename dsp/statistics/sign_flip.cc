#include "dsp/statistics/sign_flip.h"

#include <cmath>
#include <cstdint>

namespace haptometer::dsp {
namespace {

// the sum with the signs of `flips`, bit i for value i
double SignedSum(std::span<const double> values, std::uint32_t flips) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += ((flips >> i) & 1U) != 0 ? -values[i] : values[i];
  }
  return sum;
}

}  // namespace

std::optional<double> SignFlipP(std::span<const double> differences) {
  const std::size_t n = differences.size();
  if (n == 0 || n > kMostSignFlips) return std::nullopt;
  double all = 0;
  for (const double difference : differences) all += std::abs(difference);
  const double reached = std::abs(SignedSum(differences, 0)) - 1e-12 * all;
  // the last sign stays: flipping all of them changes no |sum|
  const std::uint32_t choices = 1U << (n - 1);
  std::uint32_t as_large = 0;
  for (std::uint32_t flips = 0; flips < choices; ++flips) {
    if (std::abs(SignedSum(differences, flips)) >= reached) ++as_large;
  }
  return static_cast<double>(as_large) / choices;
}

}  // namespace haptometer::dsp
