#include "dsp/analysis/window/window_numbers.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "base/band.h"
#include "base/jobs.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/window/measured_window.h"
#include "dsp/analysis/window/window_remarks.h"
#include "dsp/readings/clipping.h"
#include "dsp/readings/digitisation.h"
#include "dsp/readings/faults.h"
#include "dsp/readings/straight_lines.h"
#include "dsp/spectrum/envelope.h"
#include "dsp/spectrum/kinematics.h"
#include "dsp/spectrum/slow_motion.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBesideRows = 128;  // twice the most taps of a differentiator

// the stated errors (k = 2) of what was interpolated in the window, as RMS over it
double BridgedRms(const MeasuredWindow& window) {
  double square_sum = 0;
  for (const Bridge& bridge :
       window.signal().samples().BridgesWithin(window.chosen.begin, window.rows)) {
    square_sum += bridge.error_square;
  }
  return 2 * std::sqrt(square_sum / static_cast<double>(window.rows));
}

// what the sensor's averaging did at the tone, and whether it is divided out
void DescribeSensor(MeasuredWindow& window) {
  SensorNumbers& sensor = window.numbers.sensor;
  sensor.averaging = AveragingOf(window.head.metadata, window.analysis.record.rate_hz,
                                 window.analysis.record.fresh_rate_hz);
  sensor.gain_in_band = GainsOver(sensor.averaging, window.band().lower_hz, window.band().upper_hz);
  if (sensor.averaging.knowledge == SensorKnowledge::kUnknown) {
    return window.analysis.findings.Doubt(FindingKind::kAveragingUnknown);
  }
  sensor.amplitude_verified = true;
  // of a drive without a single tone, in the middle of where it moves
  const StateInterval& state = window.chosen.part.state;
  if (!window.numbers.tone && !window.chosen.part.from_drive) {
    if (sensor.gain_in_band->least < 1) {
      window.analysis.findings.Note(
          FindingKind::kGainInBand,
          {{"least", sensor.gain_in_band->least}, {"greatest", sensor.gain_in_band->greatest}});
    }
    return;
  }
  // averaging reduces the tone by a known gain; a noticeable one is divided out, below 0.5 refused
  const double frequency_hz = window.numbers.tone ? window.numbers.tone->fit.frequency_hz
                                                  : 0.5 * (state.from_hz + state.to_hz);
  sensor.gain_at_tone = GainAt(sensor.averaging, frequency_hz);
  const double gain = *sensor.gain_at_tone;
  sensor.divided_out = gain < 1 && gain >= kNoticeable;
  if (sensor.divided_out) window.power.sensor_gain = gain;
  if (gain < kLeastSensorGain) {
    sensor.amplitude_verified = false;
    const int most =
        sensor.averaging.averages > 1 ? MostAverages(frequency_hz, sensor.averaging.sampling_s) : 1;
    window.analysis.findings.Refuse(FindingKind::kGainTooLow, {{"gain", gain},
                                                               {"frequency_hz", frequency_hz},
                                                               {"least_gain", kLeastSensorGain},
                                                               {"averages", most}});
  } else if (gain < 1) {
    window.analysis.findings.Note(FindingKind::kGainCorrected, {{"gain", gain}});
  }
}

// readings that the record adds because its source is slower, k rows for each on average, show less
// of the band: held, they reduce a tone to sin(pi f k T) / (k sin(pi f T)); on straight lines, to
// the square of that, or of sin(x) / x where k is no whole number (of few phases, as 7/2, the loss
// is then 2 % of itself too large)
void JudgeSource(MeasuredWindow& window, std::span<const double> samples) {
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  const double cycles = frequency_hz / window.rate_hz();
  const double share = RepeatedShare(samples);
  const double rows = share > 0 ? 1 / (1 - share) : RowsBetweenReadings(samples, cycles);
  if (rows == 0) return;
  RecordFacts& record = window.analysis.record;
  record.fresh_rate_hz = std::min(record.fresh_rate_hz, window.rate_hz() / rows);
  record.observable_upper_hz = HighestObservableHz(record.fresh_rate_hz);
  const double angle = std::numbers::pi * cycles;
  const double row_gain = share > 0 || rows == std::round(rows) ? std::sin(angle) : angle;
  const double held_gain = std::abs(std::sin(rows * angle) / (rows * row_gain));
  Findings& findings = window.analysis.findings;
  if (share > 0) {
    findings.Doubt(FindingKind::kSourceIsSlower, {{"share", share},
                                                  {"new_readings_per_s", record.fresh_rate_hz},
                                                  {"frequency_hz", frequency_hz},
                                                  {"loss", 1 - held_gain}});
  } else {
    findings.Doubt(FindingKind::kStraightLines, {{"new_readings_per_s", record.fresh_rate_hz},
                                                 {"frequency_hz", frequency_hz},
                                                 {"loss", 1 - held_gain * held_gain}});
  }
  CheckNewReadings(window.band(), &window.analysis);
}

// a limit that noise was added to
void DoubtClipping(const Clipping& clipping, Findings* findings) {
  Finding finding{.severity = Severity::kDoubt,
                  .kind = FindingKind::kLimited,
                  .numbers = {{"share", clipping.share}}};
  if (clipping.low_rail) finding.numbers.emplace_back("lowest_m", *clipping.low_rail);
  if (clipping.high_rail) finding.numbers.emplace_back("highest_m", *clipping.high_rail);
  finding.numbers.emplace_back("beyond_m", clipping.beyond);
  findings->Add(std::move(finding));
}

// clipped values reduce the RMS: the answer is refused, its value a lower limit; of the middle of a
// long window
Result<void> JudgeClipping(MeasuredWindow& window) {
  const UsedPart& part = window.numbers.part;
  const std::size_t rows = ClippedRows(window.analysis.faults, part.first_row, part.rows);
  double share = static_cast<double>(rows) / static_cast<double>(part.rows);
  if (window.numbers.tone) {
    std::vector<double> samples(FittedOf(window.rows));
    const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
    HAPTOMETER_TRY(window.signal().samples().ReadMeasured(first, samples));
    JudgeSource(window, samples);
    const Clipping clipping =
        FindClipping(samples, window.rate_hz(), window.numbers.tone->fit.frequency_hz);
    if (clipping.verdict == ClippingVerdict::kUndecided) {
      window.analysis.findings.Doubt(FindingKind::kMayBeClipped, {{"share", clipping.share}});
    }
    if (clipping.verdict == ClippingVerdict::kBelowNoise) {
      DoubtClipping(clipping, &window.analysis.findings);
    }
    if (clipping.verdict == ClippingVerdict::kClipped) share = std::max(share, clipping.share);
  }
  if (share <= kMostClipped) return {};
  window.numbers.is_lower_limit = true;
  window.analysis.findings.Refuse(FindingKind::kWindowClipped, {{"share", share}});
  return {};
}

// when the drive began, and what it takes
Result<void> DescribeDrive(const trial::RowSource& source, MeasuredWindow& window) {
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  HAPTOMETER_LET(const auto onset, FindDriveOnset(source, window.chosen, frequency_hz));
  window.numbers.onset = onset;
  HAPTOMETER_LET(const auto found, MeasureElectrical(source, window.numbers.part.first_row,
                                                     window.rows, window.rate_hz(), frequency_hz));
  window.numbers.electrical = found.state;
  if (found.why_not) window.analysis.findings.Add(*found.why_not);
  return {};
}

// velocity and acceleration of the window's filtered samples, or of their middle, with the samples
// beside them
Result<void> DescribeMotion(MeasuredWindow& window) {
  const BandSignal& signal = window.signal();
  const std::size_t size = FittedOf(window.rows);
  const std::size_t first = window.chosen.begin + (window.rows - size) / 2;
  // samples beside the window, as far as they are free of transients
  const std::size_t before = std::min(first - signal.settled_begin(), kBesideRows);
  const std::size_t after = std::min(signal.settled_end() - first - size, kBesideRows);
  std::vector<double> samples(before + size + after);
  HAPTOMETER_TRY(signal.Read(first - before, samples));
  auto motion =
      DescribeKinematics(samples, signal.rate_hz(), window.band().upper_hz, before, before + size);
  if (!motion) return {};
  // from samples that were read to rows of the record
  const std::size_t row = signal.first_row() + first - before;
  motion->begin += row;
  motion->end += row;
  window.numbers.kinematics = *std::move(motion);
  return {};
}

// a line below the band that the window does not resolve from its tone is that tone, at the corner
void DropOwnTone(MeasuredWindow& window) {
  const auto& tone = window.numbers.tone;
  auto& below = window.numbers.below_band;
  if (!tone || !below) return;
  const double apart_hz = std::abs(tone->fit.frequency_hz - below->frequency_hz);
  if (apart_hz * window.samples.duration_s() < 1) below.reset();
}

// A doubt where the amplitude of a tone at the band's foot is not one: blocks there are as long as
// bursts and their pauses together, and show a mean of both. The amplitude in three periods
// scatters by sqrt(1/d - 1) of its mean in bursts of duty d, by 0.48 in a beat of two equal tones.
void DoubtUnsteadyFoot(MeasuredWindow& window) {
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  if (!window.chosen.part.from_drive || frequency_hz > kFootReach * window.band().lower_hz ||
      window.analysis.findings.Has(FindingKind::kDriveUnsteady)) {
    return;
  }
  const Envelope envelope = DemodulateTone(
      window.samples.values_m, {.rate_hz = window.samples.rate_hz, .tone_hz = frequency_hz});
  if (envelope.amplitude.size() < kFewest) return;
  const Eigen::Map<const Eigen::ArrayXd> amplitudes(
      envelope.amplitude.data(), static_cast<Eigen::Index>(envelope.amplitude.size()));
  const double mean = amplitudes.mean();
  const double scatter = std::sqrt((amplitudes - mean).square().mean()) / mean;
  if (scatter <= kSteadyWithin) return;
  window.analysis.findings.Doubt(FindingKind::kDriveUnsteady, {{"drift", scatter}});
}

// A tone beside the band, stronger than all in it, may be the drive: a doubt where the band has no
// tone, and where most of what was measured is what the filter leaves of it. Neither is so where
// the band's own tone is most of that.
Result<void> DoubtBesideBand(const MeasuredWindow& window, BandAnalysis* analysis) {
  const BandNumbers& numbers = window.numbers;
  const double measured_m = numbers.rms.as_measured_m;
  const double most_m = std::sqrt(kMajority) * measured_m;
  if (numbers.tone && numbers.tone->sine_rms_m > most_m) return {};
  const auto doubt = [&](FindingKind kind, double frequency_hz, double amplitude_m,
                         bool may_be_drive) {
    const double rms_m = amplitude_m / std::numbers::sqrt2;
    const double left_m = rms_m * std::norm(Response(window.signal().design(), frequency_hz));
    if (rms_m < measured_m || !(may_be_drive || left_m > most_m)) return;
    analysis->findings.Doubt(kind, {{"amplitude_m", amplitude_m}, {"frequency_hz", frequency_hz}});
  };
  // a hand's tremor is no drive
  const auto& below = numbers.below_band;
  if (below && below->frequency_hz > kTremorUpper_hz) {
    doubt(FindingKind::kToneBelowBand, below->frequency_hz, below->amplitude_m, !numbers.tone);
  }
  HAPTOMETER_LET(const auto above, FindAboveBand(window.signal(), window.band().upper_hz,
                                                 analysis->record.observable_upper_hz));
  if (above) {
    doubt(FindingKind::kAboveBand, above->frequency_hz, above->amplitude, !numbers.tone);
  }
  return {};
}

}  // namespace

Result<void> MeasureWindow(const Displacement& displacement, const std::vector<BandSignal>& all,
                           const ChosenPart& chosen, const BandQuestion& question,
                           BandAnalysis* analysis) {
  const trial::Record& head = displacement.source.head();
  MeasuredWindow window{.head = head,
                        .step_m = head.channels[displacement.channel].resolution,
                        .chosen = chosen,
                        .question = question,
                        .analysis = *analysis};
  // the tone is sought in filtered samples, fewer of them where the rate is far above the band
  HAPTOMETER_LET(window.samples, SamplesOf(window));
  // two independent steps on two threads: the window itself, and motion below the band
  const auto describe_window = [&]() -> Result<void> {
    const auto tone = ToneOf(window);
    window.rows = WholePeriods(window, tone);
    DescribePart(window);
    if (tone) {
      window.numbers.tone.emplace();
      window.numbers.tone->fit = *tone;
    }
    return MeasurePower(window);
  };
  const auto describe_below = [&]() -> Result<void> {
    HAPTOMETER_LET(const auto below_band, FindBelowBand(*chosen.signal, analysis->band.lower_hz));
    window.numbers.below_band = below_band;
    return {};
  };
  const int threads = displacement.threads;
  HAPTOMETER_TRY(RunBeside(threads, {describe_window, describe_below}));
  DropOwnTone(window);
  window.numbers.whole_rms_m = WholeRms(all);
  window.numbers.bridged_rms_m = BridgedRms(window);
  DescribeSensor(window);
  // floor and clipping are required by the estimate of the RMS, the estimate by the tone's share
  HAPTOMETER_TRY(TakeFloor(window));
  HAPTOMETER_TRY(BoundSteps(window));
  HAPTOMETER_TRY(JudgeClipping(window));
  HAPTOMETER_LET(const auto bounds, BoundsOf(window));
  window.numbers.rms = EstimateRms(window.power, bounds);
  const bool has_tone = window.numbers.tone.has_value();
  if (has_tone) FinishTone(window);
  if (has_tone) DoubtUnsteadyFoot(window);
  HAPTOMETER_TRY(DoubtBesideBand(window, analysis));
  // harmonics, kinematics and drive do not depend on each other
  const auto described = RunBeside(
      threads,
      {[&] { return has_tone ? DescribeHarmonics(window) : Result<void>(); },
       [&] { return DescribeMotion(window); },
       [&] { return has_tone ? DescribeDrive(displacement.source, window) : Result<void>(); }});
  if (!described) return described;
  window.numbers.delay = chosen.delay;
  analysis->numbers = std::move(window.numbers);
  RemarkWindow(all, chosen, question, analysis);
  return {};
}

}  // namespace haptometer::dsp
