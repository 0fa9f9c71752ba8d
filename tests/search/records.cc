// Records of a tone with noise, rounding and an offset: what an analysis states of them holds the
// truth, or it is refused or doubted.
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/search/band_reference.h"
#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

// Six standard uncertainties: of 1e9 normal deviations two lie beyond, so chance does not reach it
// in 1e5 cases of three numbers.
constexpr double kFactor = 6;

struct Tone {
  double amplitude_m = 0;
  double frequency_hz = 0;
  double rate_hz = 0;
  double step_m = 0;
};

trial::Record RecordOf(std::vector<double> values_m, double rate_hz) {
  trial::Record record;
  record.rows = values_m.size();
  record.stretches = {{.rows = record.rows, .rate_hz = rate_hz}};
  trial::Channel channel{.name = "displacement", .role = trial::ChannelRole::kDisplacement};
  channel.unit = "m";
  channel.statuses.assign(record.rows, trial::SampleStatus::kOk);
  channel.values = std::move(values_m);
  record.channels.push_back(std::move(channel));
  return record;
}

// the drive is on behind a pause that may be there
trial::Record DrawRecord(const Tone& tone) {
  const double duration_s = Decades("duration_s", 0.3, 5);
  const double pause_s = Flag("has_pause") ? Even("pause_s", 0.1, 1) : 0;
  const double offset_m = Flag("has_offset") ? Decades("offset_m", 1e-6, 0.05) : 0;
  const double noise_m = tone.amplitude_m * Decades("noise_over_amplitude", 1e-4, 3);
  const double phase = Even("phase_turns", 0, 1);
  Noise noise(Whole("noise_seed", 0, 1'000'000));
  std::vector<double> values_m(static_cast<std::size_t>((pause_s + duration_s) * tone.rate_hz));
  for (std::size_t k = 0; k < values_m.size(); ++k) {
    const double t_s = static_cast<double>(k) / tone.rate_hz;
    const double turns = tone.frequency_hz * t_s + phase;
    const double motion_m =
        t_s < pause_s ? 0 : tone.amplitude_m * std::sin(2 * std::numbers::pi * turns);
    values_m[k] = Stepped(offset_m + motion_m + noise_m * noise(), tone.step_m);
  }
  return RecordOf(std::move(values_m), tone.rate_hz);
}

void CheckNumbers(const dsp::BandAnalysis& analysis, const Tone& tone) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  const BandReference band = MakeBandReference(analysis.band.order, 20, 500, tone.rate_hz, true);
  const auto gain = static_cast<double>(GainOfTwo(band, tone.frequency_hz, tone.rate_hz));
  const double rms_m = tone.amplitude_m * gain / std::numbers::sqrt2;
  // The window has whole samples: of a tone up to half a sample more or less than whole periods,
  // which moves its mean square by that share at most. The stated uncertainty leaves it out.
  const double part_m = rms_m / 4 / static_cast<double>(numbers.part.rows);
  Hold("RMS, in standard uncertainties",
       (numbers.rms.rms_m - rms_m) / (numbers.rms.standard_uncertainty_m + part_m / kFactor),
       kFactor);
  Require("the interval is in order",
          numbers.rms.lower_m <= numbers.rms.rms_m && numbers.rms.rms_m <= numbers.rms.upper_m);
  if (!numbers.tone) return;
  Hold("amplitude, in standard uncertainties",
       (numbers.tone->amplitude_m - tone.amplitude_m) / numbers.tone->amplitude_uncertainty_m,
       kFactor);
  const double half_hz = (numbers.tone->frequency_upper_hz - numbers.tone->frequency_lower_hz) / 2;
  Hold("frequency, in standard uncertainties",
       (numbers.tone->fit.frequency_hz - tone.frequency_hz) / (half_hz / 1.96), kFactor);
}

}  // namespace

bool RecordCase() {
  Tone tone;
  tone.amplitude_m = Decades("amplitude_m", 1e-8, 1e-3);
  tone.frequency_hz = Decades("frequency_hz", 20, 500);
  tone.rate_hz = Decades("rate_hz", 1300, 2e4);
  if (Flag("has_steps")) tone.step_m = tone.amplitude_m * Decades("step_over_amplitude", 1e-4, 3);
  const auto analysis = dsp::AnalyzeBand(DrawRecord(tone), {});
  if (!analysis || !analysis->answered) return false;
  Require("an answer has numbers", analysis->numbers.has_value());
  for (const dsp::Finding& finding : analysis->findings.list()) {
    // numbers are compared as the sensor hands them out, whatever it averages
    if (finding.kind == dsp::FindingKind::kAveragingUnknown) continue;
    if (finding.severity != Severity::kNote) return false;
  }
  CheckNumbers(*analysis, tone);
  return true;
}

}  // namespace haptometer::search
