#include "dsp/filter/end_continuations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <tuple>

#include "dsp/filter/expected_motion.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// in time constants of the slowest pole
constexpr double kSeen = 12;
constexpr double kExpected = 8;
// of the rate: a tone above is no vibration but noise
constexpr double kFastestTone = 0.4;

struct OtherView {
  double seen;  // time constants
  int sines;
};
constexpr OtherView kOtherViews[] = {{18, 2}, {8, 1}};
static_assert(std::size(kOtherViews) == std::tuple_size_v<decltype(EndContinuations::doubts)>);

// the last `time_constants` of a signal, at most all of it
std::span<const double> Seen(const FilterDesign& design, std::span<const double> signal,
                             double time_constants) {
  const double samples = time_constants * design.rate_hz / SlowestDecayPerS(design);
  return signal.last(std::min(static_cast<std::size_t>(samples), signal.size()));
}

// the strongest tone beside the slow motion, by samples from the signal's last one
std::optional<ExpectedMotion> FindTone(const FilterDesign& design, std::span<const double> signal) {
  const std::vector<double> slow = FitExpectedMotion(signal, 1).From(0, signal.size());
  std::vector<double> rest(signal.begin(), signal.end());
  for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= slow[k];
  const double slowest_hz = kFastestExpectedRad / (2 * std::numbers::pi) * design.rate_hz /
                            static_cast<double>(signal.size());
  const double fastest_hz = kFastestTone * design.rate_hz;
  if (!(slowest_hz < fastest_hz)) return std::nullopt;
  const auto found = StrongestTone(rest, {design.rate_hz, slowest_hz, fastest_hz, 0});
  if (!found) return std::nullopt;
  const double rad_per_sample = 2 * std::numbers::pi * found->frequency_hz / design.rate_hz;
  const double phase_rad =
      found->phase_rad + rad_per_sample * static_cast<double>(signal.size() - 1);
  const ExpectedMotion::Sine sine{rad_per_sample, found->amplitude * std::cos(phase_rad),
                                  -found->amplitude * std::sin(phase_rad)};
  return ExpectedMotion{.sines = {sine}};
}

// slow motion by samples from the signal's last one, less that there
struct SlowChange {
  ExpectedMotion motion;
  double last;

  SlowChange(std::span<const double> signal, int sines)
      : motion(FitExpectedMotion(signal, sines)), last(static_cast<double>(signal.size() - 1)) {}
  // at `count` samples from `first` on
  [[nodiscard]] std::vector<double> From(double first, std::size_t count) const {
    std::vector<double> change = motion.From(last + first, count);
    const double at_last = motion.At(last);
    for (double& value : change) value -= at_last;
    return change;
  }
};

// the signal stays where it ends, less the odd continuation
std::vector<double> StaysLessOdd(std::span<const double> signal, std::size_t count) {
  std::vector<double> differences(count);
  for (std::size_t k = 0; k < count; ++k) {
    differences[k] = signal[signal.size() - 1 - std::min(k + 1, signal.size() - 1)] - signal.back();
  }
  return differences;
}

}  // namespace

EndContinuations ContinueEnd(const FilterDesign& design, std::span<const double> signal,
                             std::size_t count) {
  EndContinuations ends;
  ends.constant = StaysLessOdd(signal, count);
  const std::span<const double> seen = Seen(design, signal, kSeen);
  if (Seen(design, signal, kOtherViews[1].seen).size() < kLeastExpectedMotionSamples) return ends;
  const std::optional<ExpectedMotion> tone = FindTone(design, seen);
  // the means that slow motion is fitted to hold a little of the tone
  const std::span<const double> longest = Seen(design, signal, kOtherViews[0].seen);
  std::vector<double> toneless(longest.begin(), longest.end());
  if (tone) {
    const auto first = 1 - static_cast<double>(toneless.size());
    const std::vector<double> taken = tone->From(first, toneless.size());
    for (std::size_t k = 0; k < toneless.size(); ++k) toneless[k] -= taken[k];
  }
  const SlowChange slow(Seen(design, toneless, kSeen), 1);
  const SlowChange others[] = {{Seen(design, toneless, kOtherViews[0].seen), kOtherViews[0].sines},
                               {Seen(design, toneless, kOtherViews[1].seen), kOtherViews[1].sines}};
  const std::size_t ahead =
      std::min({Seen(design, signal, kExpected).size(), count, seen.size() - 1});
  const std::vector<double> change = slow.From(1, ahead);
  const std::vector<double> before = slow.From(-static_cast<double>(ahead), ahead);
  ends.expected = change;
  ends.fast.resize(ahead);
  for (std::size_t k = 0; k < ahead; ++k) ends.fast[k] = ends.constant[k] - before[ahead - 1 - k];
  if (tone) {
    const std::vector<double> turning = tone->From(1, ahead);
    const double at_last = tone->At(0);
    for (std::size_t k = 0; k < ahead; ++k) ends.expected[k] += turning[k] - at_last;
  }
  for (std::size_t other = 0; other < ends.doubts.size(); ++other) {
    ends.doubts[other] = others[other].From(1, ahead);
    for (std::size_t k = 0; k < ahead; ++k) ends.doubts[other][k] -= change[k];
  }
  return ends;
}

}  // namespace haptometer::dsp
