#include "dsp/filter/zero_phase.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "dsp/filter/cascade.h"

namespace haptometer::dsp {
namespace {

constexpr double kPaddingRemainder = 1e-12;

// `signal` with `padding` continued samples before and after it
std::vector<double> Continued(std::span<const double> signal, std::size_t padding,
                              Continuation continuation) {
  std::vector<double> padded(signal.size() + 2 * padding);
  std::ranges::copy(signal, padded.begin() + static_cast<std::ptrdiff_t>(padding));
  // how far the signal can be turned about its ends; beyond that the last turned value stays
  const std::size_t reach =
      continuation == Continuation::kOdd ? std::min(padding, signal.size() - 1) : 0;
  const double first = signal.front();
  const double last = signal.back();
  const std::size_t after = padding + signal.size();
  for (std::size_t k = 1; k <= padding; ++k) {
    const std::size_t turned = std::min(k, reach);
    padded[padding - k] = turned == 0 ? first : 2 * first - signal[turned];
    padded[after + k - 1] = turned == 0 ? last : 2 * last - signal[signal.size() - 1 - turned];
  }
  return padded;
}

}  // namespace

std::size_t RingingSamples(const FilterDesign& design, double remainder) {
  HAPTOMETER_CHECK(remainder > 0 && remainder < 1, "remainder = {}", remainder);
  return static_cast<std::size_t>(
      std::ceil(-std::log(remainder) / SlowestDecayPerS(design) * design.rate_hz));
}

std::vector<double> FilterZeroPhase(const FilterDesign& design, std::span<const double> signal,
                                    Continuation continuation) {
  if (signal.empty()) return {};
  const std::size_t padding = RingingSamples(design, kPaddingRemainder);
  std::vector<double> padded = Continued(signal, padding, continuation);

  // forward, then the same over the turned result; each pass starts as if its first value had stood
  // for ever
  for (int pass = 0; pass < 2; ++pass) {
    Cascade cascade(design);
    cascade.StartFrom(padded.front());
    cascade.Process(padded, padded);
    std::ranges::reverse(padded);
  }

  const auto begin = padded.begin() + static_cast<std::ptrdiff_t>(padding);
  return {begin, begin + static_cast<std::ptrdiff_t>(signal.size())};
}

}  // namespace haptometer::dsp
