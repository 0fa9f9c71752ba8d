#include "dsp/analysis/slow_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/analysis/used_part.h"
#include "dsp/spectrum/sine_fit.h"
#include "trial/record.h"

namespace haptometer::dsp {
namespace {

constexpr double kTimeUncertaintyPeriods = 0.1;
constexpr double kWorstUncertainty = 100;  // times that of a tone seen at all phases
constexpr double kUmPerM = 1e6;

// why the times will not do; empty where they will
std::string TimesWillNotDo(const trial::Record& head, double frequency_hz) {
  if (head.times_are_known) return {};
  if (head.timing == trial::Timing::kPolled) {
    return "its readings are of unknown age, so no tone of known frequency is fitted either";
  }
  double worst_s = 0;
  for (const trial::Stretch& stretch : head.stretches) {
    worst_s = std::max(worst_s, stretch.time_uncertainty_s);
  }
  if (worst_s < kTimeUncertaintyPeriods / frequency_hz) return {};
  return fmt::format("times are uncertain by {:.3g} ms; a fit at {:g} Hz needs less than {:.3g} ms",
                     worst_s * 1e3, frequency_hz, kTimeUncertaintyPeriods / frequency_hz * 1e3);
}

// whether the readings see the tone at more than one phase: at a multiple of the rate only rounding
// tells it from the offset, and its uncertainty is far above that of as many readings of any phase
bool ToldApart(const SineFit& fit, std::size_t readings) {
  const double usual = fit.residual_rms * std::sqrt(2 / static_cast<double>(readings));
  return fit.converged && fit.amplitude_uncertainty <= kWorstUncertainty * usual;
}

}  // namespace

Result<void> FitKnownTone(const Displacement& displacement, const BandQuestion& question,
                          BandAnalysis* analysis) {
  const trial::Record& head = displacement.source.head();
  const std::optional<double> frequency_hz =
      question.drive_frequency_hz ? question.drive_frequency_hz : head.metadata.drive_frequency_hz;
  if (!frequency_hz || !(*frequency_hz > 0)) return {};
  if (const std::string why = TimesWillNotDo(head, *frequency_hz); !why.empty()) {
    analysis->remarks.push_back(why);
    return {};
  }
  const std::size_t rows = std::min(head.rows, kMostFitted);
  std::vector<double> values(rows);
  std::vector<trial::SampleStatus> statuses(rows);
  if (auto read = displacement.source.Read(displacement.channel, 0, values, statuses); !read) {
    return read;
  }
  // a reading handed out again is no new one
  std::vector<double> times_s;
  times_s.reserve(rows);
  std::size_t kept = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (statuses[row] != trial::SampleStatus::kOk || !std::isfinite(values[row])) continue;
    times_s.push_back(head.times_are_known ? head.raw_times_s[row] : trial::TimeOf(head, row));
    values[kept++] = values[row];
  }
  values.resize(kept);
  KnownTone tone;
  tone.fit = FitSineAtTimes(values, times_s, *frequency_hz, 1);
  tone.aliased = *frequency_hz > analysis->record.fresh_rate_hz / 2;
  if (!ToldApart(tone.fit, kept)) {
    analysis->remarks.push_back(fmt::format(
        "a tone at {:g} Hz cannot be told apart from the offset at this rate", *frequency_hz));
    return {};
  }
  analysis->remarks.push_back(fmt::format(
      "a tone at {:g} Hz, if that is what moves, has {:.4g} um amplitude{}; no answer for the band",
      *frequency_hz, tone.fit.amplitude * kUmPerM,
      tone.aliased ? ", seen as an alias together with all else there" : ""));
  analysis->known_tone = tone;
  return {};
}

}  // namespace haptometer::dsp
