#include "dsp/analysis/slow_record.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "dsp/analysis/window_choice.h"
#include "dsp/spectrum/sine_fit.h"
#include "trial/record.h"

namespace haptometer::dsp {
namespace {

constexpr double kTimeUncertaintyPeriods = 0.1;
constexpr double kWorstUncertainty = 100;  // times that of a tone seen at all phases
// a tone whose amplitude falls below the first part of its top pauses; above the second it is on
constexpr double kPause = 0.3;
constexpr double kOn = 0.5;
constexpr double kClear = 5;  // uncertainties
constexpr std::size_t kLeastBlock = 16;
constexpr std::size_t kMostBlocks = 64;

// why the times are not sufficient; nothing where they are
std::optional<Finding> TimesWillNotDo(const trial::Record& head, double frequency_hz) {
  if (head.times_are_known) return std::nullopt;
  if (head.timing == trial::Timing::kPolled) {
    return Finding{.kind = FindingKind::kPolledTimes};
  }
  double worst_s = 0;
  for (const trial::Stretch& stretch : head.stretches) {
    worst_s = std::max(worst_s, stretch.time_uncertainty_s);
  }
  if (worst_s < kTimeUncertaintyPeriods / frequency_hz) return std::nullopt;
  return Finding{.kind = FindingKind::kTimesUnfitForTone,
                 .numbers = {{"time_uncertainty_s", worst_s},
                             {"frequency_hz", frequency_hz},
                             {"limit_s", kTimeUncertaintyPeriods / frequency_hz}}};
}

// whether the readings contain the tone at more than one phase: at a multiple of the rate only
// rounding separates it from the offset, and u(amplitude) far exceeds s sqrt(2 / N)
bool ToldApart(const SineFit& fit, std::size_t readings) {
  const double usual = fit.residual_rms * std::sqrt(2 / static_cast<double>(readings));
  return fit.converged && fit.amplitude_uncertainty <= kWorstUncertainty * usual;
}

// blocks [begin, end) of the longest run that is on, without the blocks in which it is switched
std::pair<std::size_t, std::size_t> LongestOn(const std::vector<double>& amplitudes, double top) {
  std::pair<std::size_t, std::size_t> best{0, 0};
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= amplitudes.size(); ++k) {
    if (k < amplitudes.size() && amplitudes[k] >= kOn * top) continue;
    const std::size_t first = begin > 0 ? begin + 1 : 0;
    const std::size_t last = k < amplitudes.size() && k > 0 ? k - 1 : k;
    if (last > first && last - first > best.second - best.first) best = {first, last};
    begin = k + 1;
  }
  return best;
}

// Readings [first, last) in which the tone is on: all, unless it pauses for a block or more.
std::pair<std::size_t, std::size_t> DrivenReadings(std::span<const double> values,
                                                   std::span<const double> times_s,
                                                   double frequency_hz) {
  const std::size_t size = std::max(kLeastBlock, values.size() / kMostBlocks);
  std::vector<double> amplitudes(values.size() / size);
  double top = 0;
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    // the amplitude in each block, with a slope beside it
    const SineFit fit = FitSineAtTimes(values.subspan(k * size, size),
                                       times_s.subspan(k * size, size), frequency_hz, 1);
    if (!ToldApart(fit, size)) return {0, values.size()};
    amplitudes[k] = fit.amplitude;
    if (fit.amplitude > kClear * fit.amplitude_uncertainty) top = std::max(top, fit.amplitude);
  }
  const auto pauses = [&](double amplitude) { return amplitude < kPause * top; };
  if (std::ranges::none_of(amplitudes, pauses)) return {0, values.size()};
  const auto [begin, end] = LongestOn(amplitudes, top);
  if (end <= begin) return {0, values.size()};
  return {begin * size, end == amplitudes.size() ? values.size() : end * size};
}

// The best fit within ten bins of a known frequency, every quarter of a bin, if it leaves less than
// half of what the fit at that frequency leaves; of at most 2^14 readings from the first on.
std::optional<SineFit> BetterNearby(std::span<const double> values, std::span<const double> times_s,
                                    const SineFit& at) {
  constexpr std::size_t kMost = std::size_t{1} << 14U;
  constexpr int kSteps = 40;
  constexpr double kLess = 0.5;
  const std::size_t count = std::min(values.size(), kMost);
  const double bin_hz = 1 / (times_s[count - 1] - times_s.front());
  const auto fitted = [&](double frequency_hz) {
    return FitSineAtTimes(values.first(count), times_s.first(count), frequency_hz, 1);
  };
  SineFit best = fitted(at.frequency_hz);
  const double limit = kLess * best.residual_rms * best.residual_rms;
  for (int step = -kSteps; step <= kSteps; ++step) {
    const SineFit fit = fitted(at.frequency_hz + 0.25 * step * bin_hz);
    if (fit.converged && fit.residual_rms < best.residual_rms) best = fit;
  }
  if (!(best.residual_rms * best.residual_rms < limit)) return std::nullopt;
  return best;
}

}  // namespace

Result<void> FitKnownTone(const Displacement& displacement, const BandQuestion& question,
                          BandAnalysis* analysis) {
  const trial::Record& head = displacement.source.head();
  const std::optional<double> frequency_hz = question.drive_frequency_hz;
  if (!frequency_hz || !(*frequency_hz > 0)) return {};
  if (const auto why = TimesWillNotDo(head, *frequency_hz)) {
    analysis->findings.Add(*why);
    return {};
  }
  const std::size_t rows = std::min(head.rows, kMostFitted);
  std::vector<double> values(rows);
  std::vector<trial::SampleStatus> statuses(rows);
  if (auto read = displacement.source.Read(displacement.channel, 0, values, statuses); !read) {
    return read;
  }
  // a repeated reading is no new one
  std::vector<double> times_s;
  times_s.reserve(rows);
  std::size_t kept = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (statuses[row] != trial::SampleStatus::kOk || !std::isfinite(values[row])) continue;
    times_s.push_back(head.times_are_known ? head.raw_times_s[row] : trial::TimeOf(head, row));
    values[kept++] = values[row];
  }
  values.resize(kept);
  // amplitude of the driven readings only: a pause would reduce it
  const auto [first, last] = DrivenReadings(values, times_s, *frequency_hz);
  if (last - first < kept) {
    analysis->findings.Note(
        FindingKind::kKnownTonePauses,
        {{"frequency_hz", *frequency_hz}, {"from_s", times_s[first]}, {"to_s", times_s[last - 1]}});
    kept = last - first;
  }
  KnownTone tone;
  const auto driven = std::span<const double>(values).subspan(first, kept);
  const auto driven_s = std::span<const double>(times_s).subspan(first, kept);
  tone.fit = FitSineAtTimes(driven, driven_s, *frequency_hz, 1);
  // above half the rate of new readings the tone is an alias
  tone.aliased = *frequency_hz > analysis->record.fresh_rate_hz / 2;
  if (!ToldApart(tone.fit, kept)) {
    analysis->findings.Note(FindingKind::kKnownToneAtRate, {{"frequency_hz", *frequency_hz}});
    return {};
  }
  // a tone nearby that explains more: the stated frequency is not the drive's
  if (const auto better = BetterNearby(driven, driven_s, tone.fit)) {
    analysis->findings.Doubt(FindingKind::kKnownToneElsewhere,
                             {{"frequency_hz", *frequency_hz},
                              {"better_hz", better->frequency_hz},
                              {"amplitude_m", better->amplitude}});
  }
  analysis->findings.Note(tone.aliased ? FindingKind::kKnownToneAlias : FindingKind::kKnownTone,
                          {{"frequency_hz", *frequency_hz}, {"amplitude_m", tone.fit.amplitude}});
  analysis->known_tone = tone;
  return {};
}

}  // namespace haptometer::dsp
