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

// a tone by samples from the signal's last one
class Tone {
 public:
  Tone(const SineFit& fit, double rate_hz, std::size_t size)
      : amplitude_(fit.amplitude),
        rad_per_sample_(2 * std::numbers::pi * fit.frequency_hz / rate_hz),
        phase_rad_(fit.phase_rad + rad_per_sample_ * static_cast<double>(size - 1)) {}
  [[nodiscard]] double At(double away) const {
    return amplitude_ * std::cos(rad_per_sample_ * away + phase_rad_);
  }

 private:
  double amplitude_;
  double rad_per_sample_;
  double phase_rad_;  // at the last sample
};

// the strongest tone beside the slow motion
std::optional<Tone> FindTone(const FilterDesign& design, std::span<const double> signal) {
  const ExpectedMotion slow = FitExpectedMotion(signal, 1);
  std::vector<double> rest(signal.begin(), signal.end());
  for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= slow.At(static_cast<double>(k));
  const double slowest_hz = kFastestExpectedRad / (2 * std::numbers::pi) * design.rate_hz /
                            static_cast<double>(signal.size());
  const double fastest_hz = kFastestTone * design.rate_hz;
  if (!(slowest_hz < fastest_hz)) return std::nullopt;
  const auto found = StrongestTone(rest, {design.rate_hz, slowest_hz, fastest_hz, 0});
  if (!found) return std::nullopt;
  return Tone(*found, design.rate_hz, signal.size());
}

// slow motion by samples from the signal's last one, less that there
struct SlowChange {
  ExpectedMotion motion;
  double last;

  SlowChange(std::span<const double> signal, int sines)
      : motion(FitExpectedMotion(signal, sines)), last(static_cast<double>(signal.size() - 1)) {}
  [[nodiscard]] double At(double away) const { return motion.At(last + away) - motion.At(last); }
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
  const std::optional<Tone> tone = FindTone(design, seen);
  // the means that slow motion is fitted to hold a little of the tone
  std::vector<double> toneless(signal.begin(), signal.end());
  for (std::size_t k = 0; tone && k < toneless.size(); ++k) {
    toneless[k] -= tone->At(static_cast<double>(k) - static_cast<double>(toneless.size() - 1));
  }
  const SlowChange slow(Seen(design, toneless, kSeen), 1);
  const SlowChange others[] = {{Seen(design, toneless, kOtherViews[0].seen), kOtherViews[0].sines},
                               {Seen(design, toneless, kOtherViews[1].seen), kOtherViews[1].sines}};
  ends.expected = ends.constant;
  ends.fast.resize(count);
  for (auto& doubt : ends.doubts) doubt.resize(count);
  const std::size_t ahead =
      std::min({Seen(design, signal, kExpected).size(), count, seen.size() - 1});
  for (std::size_t k = 0; k < ahead; ++k) {
    const auto away = static_cast<double>(k + 1);
    const double change = slow.At(away);
    ends.expected[k] += change + (tone ? tone->At(away) - tone->At(0) : 0.0);
    ends.fast[k] = ends.constant[k] - slow.At(-away);
    for (std::size_t other = 0; other < ends.doubts.size(); ++other) {
      ends.doubts[other][k] = others[other].At(away) - change;
    }
  }
  return ends;
}

}  // namespace haptometer::dsp
