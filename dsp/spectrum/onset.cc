#include "dsp/spectrum/onset.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "base/error.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kSqrt2 = std::numbers::sqrt2;
constexpr double kLow = 0.1;
// of the window, to either side of a crossing
constexpr double kSlopeReach = 0.125;
constexpr double kTopSlopeReach = 0.5;
constexpr double kHalf = 0.5;
constexpr double kHigh = 0.9;
constexpr double kNoisesBelowLow = 3;
constexpr double kLeastResolvedRise = 2.0 / 3;  // of the window's own
// greatest deviations over the window's own rise, measured on closed forms, as deviations of an
// even distribution
constexpr double kTimeBias = 0.18 / std::numbers::sqrt3;
constexpr double kRiseBias = 0.12 / std::numbers::sqrt3;

// the values between two times; empty where they reach outside
std::span<const double> Between(const Envelope& envelope, double begin_s, double end_s) {
  const double first = std::ceil((begin_s - envelope.start_s) / envelope.step_s);
  const double last = std::floor((end_s - envelope.start_s) / envelope.step_s);
  const auto size = static_cast<double>(envelope.amplitude.size());
  if (!(first >= 0 && last >= first && last < size)) return {};
  return std::span(envelope.amplitude)
      .subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(last - first) + 1);
}

// The envelope's power above the quiet part's, as a share of the steady amplitude, by index.
class Levels {
 public:
  Levels(std::span<const double> amplitude, double quiet, double steady)
      : amplitude_(amplitude), quiet_square_(quiet * quiet), steady_(steady) {}

  [[nodiscard]] std::size_t size() const { return amplitude_.size(); }
  [[nodiscard]] double operator[](std::size_t k) const {
    const double square = amplitude_[k] * amplitude_[k] - quiet_square_;
    return std::sqrt(std::max(0.0, square)) / steady_;
  }
  // where between k and k + 1 the straight line passes `level`
  [[nodiscard]] double Crossing(std::size_t k, double level) const {
    const double below = (*this)[k];
    return static_cast<double>(k) + (level - below) / ((*this)[k + 1] - below);
  }

 private:
  std::span<const double> amplitude_;
  double quiet_square_;
  double steady_;
};

// first k >= begin with levels[k] < level <= levels[k + 1]
std::optional<double> FirstRise(const Levels& levels, std::size_t begin, double level) {
  for (std::size_t k = begin; k + 1 < levels.size(); ++k) {
    if (levels[k] < level && levels[k + 1] >= level) return levels.Crossing(k, level);
  }
  return std::nullopt;
}

// the last such k <= end
std::optional<double> LastRise(const Levels& levels, std::size_t end, double level) {
  for (std::size_t k = end + 1; k-- > 0;) {
    if (k + 1 < levels.size() && levels[k] < level && levels[k + 1] >= level) {
      return levels.Crossing(k, level);
    }
  }
  return std::nullopt;
}

// crossings of the low, half and high level, in steps
struct Crossings {
  double low = 0;
  double half = 0;
  double high = 0;
};

std::optional<Crossings> FindCrossings(const Levels& levels, std::size_t begin, double low_level) {
  const auto half = FirstRise(levels, begin, kHalf);
  if (!half) return std::nullopt;
  const auto at_half = static_cast<std::size_t>(*half);
  const auto low = LastRise(levels, at_half, low_level);
  const auto high = FirstRise(levels, at_half, kHigh);
  if (!low || !high) return std::nullopt;
  return Crossings{*low, *half, *high};
}

// levels per step about `at`, over `reach` steps on either side
double SlopeAt(const Levels& levels, double at, double reach) {
  const auto last = static_cast<double>(levels.size() - 1);
  const auto before = static_cast<std::size_t>(std::max(0.0, std::floor(at - reach)));
  const auto after = static_cast<std::size_t>(std::min(last, std::ceil(at + reach)));
  return (levels[after] - levels[before]) / static_cast<double>(after - before);
}

// what `interval_s` of a rise from low to high of `measured_s` would be without the window's own
double WithoutOwnRise(double interval_s, double measured_s, double own_rise_s) {
  if (!(measured_s > own_rise_s)) return 0;
  const double own = own_rise_s / measured_s;
  return interval_s * std::sqrt(1 - own * own);
}

// standard uncertainty of a crossing of these levels, in seconds
// whose slope is taken over a part of the window on either side
double NoiseOfCrossing(const Levels& levels, double at, double noise, double part,
                       const Envelope& envelope) {
  const double slope =
      SlopeAt(levels, at, std::max(1.0, part * envelope.support_s / envelope.step_s));
  return slope > 0 ? noise / slope * envelope.step_s : envelope.support_s;
}

// rise_s, or why it is not known; `measured` is from low to high
void DescribeRise(double measured_s, double noise_s, double own_rise_s, Edge& edge) {
  const double square = measured_s * measured_s - own_rise_s * own_rise_s;
  const double rise_s = std::sqrt(std::max(0.0, square));
  if (edge.low_level > kLow) return;
  if (rise_s < kLeastResolvedRise * own_rise_s) {
    edge.rise_at_most_s = kLeastResolvedRise * own_rise_s + 2 * noise_s;
    return;
  }
  edge.rise_s = rise_s;
  edge.rise_uncertainty_s = std::hypot(noise_s * measured_s / rise_s, kRiseBias * own_rise_s);
}

}  // namespace

std::optional<Edge> FindOnset(const Envelope& envelope, const EdgeSearch& search) {
  HAPTOMETER_CHECK(envelope.amplitude.empty() || envelope.step_s > 0, "step_s = {}",
                   envelope.step_s);
  if (envelope.amplitude.empty()) return std::nullopt;
  const auto quiet = Between(envelope, search.quiet_begin_s, search.quiet_end_s);
  const auto steady = Between(envelope, search.steady_begin_s, search.steady_end_s);
  if (quiet.empty() || steady.empty()) return std::nullopt;

  Edge edge;
  edge.quiet_amplitude = Rms(quiet);
  const double power = Rms(steady) * Rms(steady) - edge.quiet_amplitude * edge.quiet_amplitude;
  if (!(power > 0)) return std::nullopt;
  edge.steady_amplitude = std::sqrt(power);
  edge.low_level = std::max(kLow, kNoisesBelowLow * edge.quiet_amplitude / edge.steady_amplitude);
  if (!(edge.low_level < kHalf)) return std::nullopt;

  const Levels levels(envelope.amplitude, edge.quiet_amplitude, edge.steady_amplitude);
  const auto begin = static_cast<std::size_t>(quiet.data() - envelope.amplitude.data());
  const auto found = FindCrossings(levels, begin, edge.low_level);
  if (!found) return std::nullopt;

  // one of the two parts of the quiet amplitude lies along the tone
  const double noise = edge.quiet_amplitude / edge.steady_amplitude / kSqrt2;
  const double noise_s = NoiseOfCrossing(levels, found->low, noise, kSlopeReach, envelope);
  // most rises are flatter at the top, where noise shows in the slope
  const double noise_of_two_s =
      std::hypot(noise_s, NoiseOfCrossing(levels, found->high, noise, kTopSlopeReach, envelope));
  const double measured_s = (found->high - found->low) * envelope.step_s;
  const double half_s = envelope.start_s + found->half * envelope.step_s;
  const double low_s = (found->half - found->low) * envelope.step_s;  // before the half level
  edge.time_s = half_s - WithoutOwnRise(low_s, measured_s, envelope.own_rise_s);
  const double early_s =
      WithoutOwnRise(low_s + noise_s, measured_s + noise_of_two_s, envelope.own_rise_s);
  const double late_s =
      WithoutOwnRise(low_s - noise_s, measured_s - noise_of_two_s, envelope.own_rise_s);
  edge.time_uncertainty_s =
      std::hypot(noise_s, 0.5 * (early_s - late_s), kTimeBias * envelope.own_rise_s);
  DescribeRise(measured_s, noise_of_two_s, envelope.own_rise_s, edge);
  return edge;
}

std::optional<Edge> FindDecay(const Envelope& envelope, const EdgeSearch& search) {
  if (envelope.amplitude.empty()) return std::nullopt;
  Envelope reversed = envelope;
  std::ranges::reverse(reversed.amplitude);
  const double end_s =
      envelope.start_s + static_cast<double>(envelope.amplitude.size() - 1) * envelope.step_s;
  const double turn_s = envelope.start_s + end_s;  // time t becomes turn_s - t
  auto edge = FindOnset(reversed, {turn_s - search.quiet_end_s, turn_s - search.quiet_begin_s,
                                   turn_s - search.steady_end_s, turn_s - search.steady_begin_s});
  if (edge) edge->time_s = turn_s - edge->time_s;
  return edge;
}

}  // namespace haptometer::dsp
