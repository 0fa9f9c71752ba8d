#include "tools/acquire/check/check_findings.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

void FindValues(const trial::Channel& channel, CheckFindings& findings) {
  std::size_t hold = 0;
  std::optional<double> last;
  for (std::size_t row = 0; row < channel.values.size(); ++row) {
    if (!trial::IsMeasurement(channel.statuses[row])) continue;
    const double value = channel.values[row];
    hold = last == value ? hold + 1 : 1;
    last = value;
    ++findings.measured;
    findings.longest_hold = std::max(findings.longest_hold, hold);
    findings.least_m = std::min(findings.least_m.value_or(value), value);
    findings.greatest_m = std::max(findings.greatest_m.value_or(value), value);
  }
}

}  // namespace

CheckFindings FindingsOf(const trial::Record& record, const acquire::RecordingSummary& summary,
                         const dsp::BandPass& band) {
  CheckFindings findings{.summary = summary};
  const auto number = trial::DisplacementChannel(record);
  HAPTOMETER_CHECK(number, "a record without displacement");
  const trial::Channel& channel = record.channels[*number];
  findings.resolution_m = channel.resolution;
  FindValues(channel, findings);
  for (const trial::Stretch& stretch : record.stretches) {
    findings.time_uncertainty_s = std::max(findings.time_uncertainty_s, stretch.time_uncertainty_s);
  }
  dsp::BandQuestion question;
  question.band = band;
  question.choice = dsp::WindowChoice::kAll;  // at rest: no drive is looked for
  question.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(record, question);
  if (!analysis) {
    findings.no_noise_because = analysis.error().what;
    return findings;
  }
  findings.duration_s = analysis->record.duration_s;
  findings.fresh_rate_hz = analysis->record.fresh_rate_hz;
  findings.level_m = analysis->record.offset_m;
  if (!analysis->answered) {
    // without its remedy: the list has its own
    const std::string& reason = analysis->reasons.front();
    findings.no_noise_because = reason.substr(0, reason.find(": "));
  }
  if (!analysis->numbers) return findings;
  findings.noise_m = analysis->numbers->residual_rms_m;
  if (analysis->numbers->tone) {
    findings.tone_hz = analysis->numbers->tone->fit.frequency_hz;
    findings.tone_rms_m = analysis->numbers->tone->fit.amplitude / std::numbers::sqrt2;
  }
  return findings;
}

}  // namespace haptometer::tools
