#include "dsp/analysis/frequency_move.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kMostBlocks = 48;
constexpr std::size_t kLeastBlocks = 8;
constexpr double kPeriods = 2.05;       // of the lower corner: the tone's search asks for two
constexpr double kSamplesPerUpper = 4;  // kept of a period of the upper corner
constexpr double kLeastSpan = 1.1;      // upper over lower end
constexpr double kMiddle = 0.2;         // from either end of the span
constexpr double kLeastInMiddle = 0.2;
constexpr double kLargestStep = 0.25;  // of the span
constexpr double kSmallSteps = 0.75;   // share of them
constexpr double kScatter = 0.01;      // of the span: a step that is none
constexpr std::size_t kLeastSteps = 5;
// places at non-uniform distances, which no repeated sweep passes in step
constexpr std::array kGlances{0.03, 0.21, 0.47, 0.68, 0.95};
constexpr double kStays = 1.01;  // upper over lower tone of those
constexpr double kOneWay = 0.8;  // share of steps in the direction of the one before

// blocks in which a tone is sought
struct Blocks {
  std::size_t samples = 0;
  std::size_t stride = 1;  // the signal is band-limited: every so many samples are used
  std::size_t count = 0;
};

Blocks BlocksOf(const BandSignal& signal, std::size_t size, const BandPass& band) {
  Blocks blocks;
  blocks.stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(signal.rate_hz() / (kSamplesPerUpper * band.upper_hz)));
  blocks.samples = static_cast<std::size_t>(kPeriods / band.lower_hz * signal.rate_hz()) + 1;
  // those of a short part overlap by half
  blocks.count = std::min(kMostBlocks, 2 * size / blocks.samples);
  if (blocks.samples > size) blocks.count = 0;
  return blocks;
}

// frequencies of the tones in blocks at these shares of the part, in order of time
Result<std::vector<double>> TonesAt(std::span<const double> shares, const BandSignal& signal,
                                    std::size_t begin, std::size_t size, const Blocks& blocks,
                                    const BandPass& band) {
  std::vector<double> samples(blocks.samples);
  std::vector<double> kept;
  std::vector<double> tones;
  tones.reserve(shares.size());
  for (const double share : shares) {
    const std::size_t at =
        begin + static_cast<std::size_t>(share * static_cast<double>(size - blocks.samples));
    if (auto read = signal.Read(at, samples); !read) return std::unexpected(read.error());
    kept.clear();
    // fewer samples per block: the signal has no power above its band
    for (std::size_t n = 0; n < samples.size(); n += blocks.stride) kept.push_back(samples[n]);
    const auto tone =
        StrongestTone(kept, {signal.rate_hz() / static_cast<double>(blocks.stride), band.lower_hz,
                             band.upper_hz, band.upper_hz - band.lower_hz});
    if (tone) tones.push_back(tone->frequency_hz);
  }
  return tones;
}

std::vector<double> EvenShares(std::size_t count) {
  std::vector<double> shares(count);
  for (std::size_t k = 0; k < count; ++k) {
    shares[k] = static_cast<double>(k) / static_cast<double>(count - 1);
  }
  return shares;
}

// whether all of the few places have a tone, within 1 % of each other
bool StayAtAGlance(std::span<const double> tones) {
  if (tones.size() < kGlances.size()) return false;
  const auto [least, most] = std::ranges::minmax(tones);
  return most <= kStays * least;
}

// steps from block to block larger than the scatter of a tone
std::vector<double> StepsOf(std::span<const double> tones, double span) {
  std::vector<double> steps;
  steps.reserve(tones.size());
  for (std::size_t k = 1; k < tones.size(); ++k) {
    const double step = tones[k] - tones[k - 1];
    if (std::abs(step) > kScatter * span) steps.push_back(step);
  }
  return steps;
}

// whether the frequencies change as those of a sweep, not as those of one tone, two tones or noise
bool Moves(std::span<const double> tones, double lowest, double highest) {
  if (highest < kLeastSpan * lowest) return false;
  const double span = highest - lowest;
  // two tones have blocks near the ends of the span only
  const auto in_middle = std::ranges::count_if(
      tones, [&](double f) { return f > lowest + kMiddle * span && f < highest - kMiddle * span; });
  const std::vector<double> steps = StepsOf(tones, span);
  if (steps.size() < kLeastSteps) return false;
  std::size_t small = 0;
  // a sweep has small steps, most of them in the direction of the one before
  std::size_t on_and_on = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (std::abs(steps[k]) <= kLargestStep * span) ++small;
    if (k > 0 && steps[k] * steps[k - 1] > 0) ++on_and_on;
  }
  const auto share = [](auto part, std::size_t of) {
    return static_cast<double>(part) / static_cast<double>(of);
  };
  return share(in_middle, tones.size()) >= kLeastInMiddle &&
         share(small, steps.size()) >= kSmallSteps && share(on_and_on, steps.size() - 1) >= kOneWay;
}

// the longest run of tones with small steps: outside of its band a sweep leaves noise only
std::span<const double> LongestRun(std::span<const double> tones, double span) {
  std::size_t best = 0;
  std::size_t best_size = 0;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= tones.size(); ++k) {
    if (k < tones.size() && std::abs(tones[k] - tones[k - 1]) <= kLargestStep * span) continue;
    if (k - begin > best_size) {
      best = begin;
      best_size = k - begin;
    }
    begin = k;
  }
  return tones.subspan(best, best_size);
}

}  // namespace

Result<std::optional<FrequencyMove>> FindFrequencyMove(const BandSignal& signal, std::size_t begin,
                                                       std::size_t end, const BandPass& band) {
  const Blocks blocks = BlocksOf(signal, end - begin, band);
  if (blocks.count < kLeastBlocks) return std::nullopt;
  // five blocks suffice where the tone stays: a tenth of the cost of all
  const auto glances = TonesAt(kGlances, signal, begin, end - begin, blocks, band);
  if (!glances) return std::unexpected(glances.error());
  if (StayAtAGlance(*glances)) return std::nullopt;
  const auto tones = TonesAt(EvenShares(blocks.count), signal, begin, end - begin, blocks, band);
  if (!tones) return std::unexpected(tones.error());
  if (tones->size() < kLeastBlocks) return std::nullopt;
  // 10th to 90th percentile: single outlying tones do not widen the span
  std::vector<double> sorted = *tones;
  std::ranges::sort(sorted);
  const double lowest = sorted[sorted.size() / 10];
  const double highest = sorted[sorted.size() - 1 - sorted.size() / 10];
  if (!Moves(*tones, lowest, highest)) return std::nullopt;
  const auto run = LongestRun(*tones, highest - lowest);
  const auto [least, most] = std::ranges::minmax(run);
  return run.back() > run.front() ? FrequencyMove{least, most} : FrequencyMove{most, least};
}

}  // namespace haptometer::dsp
