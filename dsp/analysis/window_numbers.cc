#include "dsp/analysis/window_numbers.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "base/jobs.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_noise.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/window_remarks.h"
#include "dsp/filter/transient.h"
#include "dsp/readings/digitisation.h"
#include "dsp/readings/faults.h"
#include "dsp/spectrum/below_band_model.h"
#include "dsp/spectrum/kinematics.h"
#include "dsp/spectrum/tone.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// samples that show the steps of a converter
constexpr std::size_t kMostForSteps = std::size_t{1} << 16U;
constexpr std::size_t kBesideRows = 128;  // twice the most taps of a differentiator
// t's 97.5 % point for a density of 48 bins, 96 degrees of freedom
constexpr double kCoverage = 1.985;

// what is being measured, for the steps below
struct Window {
  const trial::Record& head;
  double step_m = 0;  // one step of the displacement's source
  const ChosenPart& chosen;
  const BandQuestion& question;
  BandAnalysis& analysis;
  BandNumbers numbers{};
  ThinnedSamples samples{};         // filtered, of the chosen part, or of its middle
  NoiseBeside beside{};             // of these
  double steps_m = 0;               // bound of what the converter's steps hide
  double hum_square = 0;            // mean square that hum adds
  std::optional<SineFit> second{};  // the strongest tone beside the tone
  double tone_variance = 0;         // of the tone's mean square
  std::optional<double> density{};  // of the noise at the drive, m2/Hz
  std::size_t rows = 0;             // of the window
  BandPower power{};

  [[nodiscard]] const BandSignal& signal() const { return *chosen.signal; }
  [[nodiscard]] double rate_hz() const { return signal().rate_hz(); }
  [[nodiscard]] double duration_s() const { return static_cast<double>(rows) / rate_hz(); }
  [[nodiscard]] const BandPass& band() const { return analysis.band; }
  [[nodiscard]] double bandwidth_hz() const { return band().upper_hz - band().lower_hz; }
};

// rows of the part's begin that hold whole periods of the tone: a part of a period biases its RMS
std::size_t WholePeriods(const Window& window, const std::optional<SineFit>& tone) {
  const std::size_t rows = window.chosen.end - window.chosen.begin;
  if (!tone) return rows;
  const double seconds = static_cast<double>(rows) / window.rate_hz();
  const double periods = std::floor(seconds * tone->frequency_hz);
  if (periods < 1) return rows;
  const double whole = std::round(periods / tone->frequency_hz * window.rate_hz());
  return std::min(rows, static_cast<std::size_t>(whole));
}

void DescribePart(Window& window) {
  UsedPart& part = window.numbers.part;
  part = window.chosen.part;
  part.first_row = window.signal().first_row() + window.chosen.begin;
  part.rows = window.rows;
  const double begin_s = TimeOfSample(window.signal(), window.chosen.begin);
  part.window = {begin_s, begin_s + window.duration_s()};
  for (const auto& [from, to] : window.chosen.excluded) {
    if (from >= window.chosen.begin + window.rows) continue;
    const std::size_t last = std::min(to, window.chosen.begin + window.rows);
    window.numbers.excluded.push_back(
        {TimeOfSample(window.signal(), from), TimeOfSample(window.signal(), last)});
  }
  window.numbers.hum = window.chosen.hum;
}

// `rows` samples from `begin` on that are not excluded
SampleRanges KeptOf(std::size_t begin, std::size_t rows, const SampleRanges& excluded) {
  SampleRanges kept;
  const std::size_t end = begin + rows;
  for (const auto& [from, to] : excluded) {
    if (std::min(from, end) > begin) kept.emplace_back(begin, std::min(from, end));
    begin = std::max(begin, to);
  }
  if (end > begin) kept.emplace_back(begin, end);
  return kept;
}

// mean square over the samples kept, `inset` away from each end of what is kept, from the sums of
// their cells
Result<double> MeanSquareKept(const Window& window, const SampleRanges& excluded,
                              std::size_t inset) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& [from, to] : KeptOf(window.chosen.begin, window.rows, excluded)) {
    if (to - from <= 2 * inset) continue;
    HAPTOMETER_LET(const double square_sum, window.signal().SquareSum(from + inset, to - inset));
    sum += square_sum;
    count += to - from - 2 * inset;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// Filtered samples of [begin, end), or of their middle, without hum; the hum's part of their mean
// square goes to `hum_square`.
Result<std::vector<double>> WithoutHum(const Window& window, std::size_t begin, std::size_t end,
                                       double* hum_square) {
  HAPTOMETER_LET(auto samples, ReadMiddle(window.signal(), begin, end));
  const std::size_t first = begin + (end - begin - samples.size()) / 2;
  const double with_hum = Rms(samples);
  SubtractLines(window.chosen.hum, window.rate_hz(), static_cast<double>(first), samples);
  if (!window.chosen.hum.empty()) *hum_square = std::pow(with_hum, 2) - std::pow(Rms(samples), 2);
  return samples;
}

// those of the longest part kept, thinned
Result<ThinnedSamples> SamplesOf(Window& window) {
  const ChosenPart& chosen = window.chosen;
  const auto kept = KeptOf(chosen.begin, chosen.end - chosen.begin, chosen.excluded);
  const auto [begin, end] =
      *std::ranges::max_element(kept, {}, [](const auto& one) { return one.second - one.first; });
  HAPTOMETER_LET(auto samples, WithoutHum(window, begin, end, &window.hum_square));
  return Thinned(std::move(samples), window.rate_hz(), window.signal().design(), window.band());
}

// whether a drive that is clear in every block moves by so many bins that no sine holds half of it
bool HasNoSingleTone(const Window& window, const SineFit& tone) {
  const StateInterval& state = window.chosen.part.state;
  if (!window.chosen.part.from_drive || state.coherence < kExplained) return false;
  const double moved_bins = std::abs(state.to_hz - state.from_hz) * window.samples.duration_s();
  double square = 0;
  for (const double value : window.samples.values_m) square += value * value;
  square /= static_cast<double>(window.samples.values_m.size());
  return moved_bins > kReachBins && tone.amplitude * tone.amplitude < square;
}

// subtracts the sine of a fit to all of `samples`
void Subtract(const SineFit& sine, double rate_hz, std::span<double> samples) {
  SubtractSine(kTwoPi * sine.frequency_hz / rate_hz, sine.amplitude * std::cos(sine.phase_rad),
               -sine.amplitude * std::sin(sine.phase_rad), 0, samples);
}

// The strongest tone of the samples; fitted again without the strongest one of the others, which
// moves it as a line below the band does (AddLeakedLine).
std::optional<SineFit> ToneOf(Window& window) {
  const double rate_hz = window.samples.rate_hz;
  const ToneSearch search{rate_hz, window.band().lower_hz, window.band().upper_hz,
                          window.bandwidth_hz()};
  const auto tone = StrongestTone(window.samples.values_m, search);
  if (!tone) return tone;
  std::vector<double> others = window.samples.values_m;
  Subtract(*tone, rate_hz, others);
  const auto second = StrongestTone(others, search);
  // nearer ones are the tone's own change
  const double least_hz = kReachBins / window.samples.duration_s();
  if (!second || std::abs(second->frequency_hz - tone->frequency_hz) < least_hz) return tone;
  std::vector<double> without = window.samples.values_m;
  Subtract(*second, rate_hz, without);
  const SineFit alone = FitSine(without, {rate_hz, window.bandwidth_hz(), 0}, tone->frequency_hz);
  window.second = second;
  return alone.converged ? alone : tone;
}

// Half width of what a part of a beat changes of the RMS: the squares of a1 cos(w1 t) + a2 cos(w2
// t) hold a1 a2 cos((w1 - w2) t), whose mean over T is a1 a2 / (pi df T) at most. Over whole
// periods of the tone its harmonics have none.
double BeatBound(const Window& window, double rms) {
  if (!window.second) return 0;
  const SineFit& tone = window.numbers.tone->fit;
  const SineFit& other = *window.second;
  const double harmonic_hz = std::round(other.frequency_hz / tone.frequency_hz) * tone.frequency_hz;
  const double bin_hz = 1 / window.samples.duration_s();
  if (harmonic_hz > 0 && std::abs(other.frequency_hz - harmonic_hz) < bin_hz) return 0;
  const double apart_hz = std::abs(other.frequency_hz - tone.frequency_hz);
  return tone.amplitude * other.amplitude /
         (2 * rms * std::numbers::pi * apart_hz * window.duration_s());
}

// ranges about the drive, and about its harmonics or not, that hold no bins of noise
std::vector<FrequencyRange> DriveRanges(const Window& window, bool harmonics) {
  const UsedPart& part = window.chosen.part;
  const double reach_hz = std::max(kDriveReachHz, kReachBins / window.samples.duration_s());
  std::vector<FrequencyRange> ranges;
  const auto add = [&](double from_hz, double to_hz) {
    const auto [low_hz, high_hz] = std::minmax(from_hz, to_hz);
    for (int n = 1; n * low_hz - reach_hz < window.band().upper_hz; ++n) {
      if (n == 1 || harmonics) ranges.push_back({n * low_hz - reach_hz, n * high_hz + reach_hz});
    }
  };
  if (part.from_drive) add(part.state.from_hz, part.state.to_hz);
  if (window.numbers.tone) {
    add(window.numbers.tone->fit.frequency_hz, window.numbers.tone->fit.frequency_hz);
  }
  return ranges;
}

// the window's mean square, its tone, and the noise beside the drive
Result<void> MeasurePower(Window& window) {
  // exact mean square over the window, from the sums of its cells
  HAPTOMETER_LET(const auto square, MeanSquareKept(window, window.chosen.excluded, 0));
  const double mean_square = std::max(0.0, square - window.hum_square);
  // variance from the fitted samples, scaled from their duration to that of the window
  const BandNoise whole =
      MeasureNoise(window.samples.values_m, window.samples.rate_hz, NoiseReachHz(window.band()));
  const double longer = window.samples.duration_s() / window.duration_s();
  window.numbers.power = {mean_square, whole.power.variance * longer};
  const std::vector<FrequencyRange> drive = DriveRanges(window, true);
  // a short window's ranges may leave no noise: the median resists harmonics
  for (const bool harmonics : {true, false}) {
    window.beside =
        MeasureNoiseBeside(window.samples.values_m, window.samples.rate_hz,
                           window.signal().design(), window.band(), DriveRanges(window, harmonics));
    if (window.beside.is_known) break;
  }
  window.numbers.residual_rms_m = std::sqrt(whole.power.mean_square);  // all of it without a tone
  if (window.numbers.tone) {
    const TonePower split =
        SplitTone(window.samples, window.numbers.tone->fit, window.band(), window.duration_s());
    window.numbers.residual_rms_m = std::sqrt(split.rest.power.mean_square);
    window.tone_variance = split.variance;
    // of a tone that stands alone, what it and its harmonics leave is noise; else at most that is
    const NoisePower beyond =
        BeyondNoise(split.rest, window.beside, window.signal().design(), window.band(), drive);
    const double rest = split.rest.power.mean_square;
    const double left = std::max(0.0, rest - beyond.mean_square);
    double& noise = window.beside.power.mean_square;
    double& variance = window.beside.variance_of_rest;
    const bool is_alone = left - noise <= kFalseAlarmDeviations * std::sqrt(variance) &&
                          beyond.mean_square <= kFalseAlarmDeviations * std::sqrt(beyond.variance);
    noise = is_alone ? left : std::min(noise, rest);
    // and of samples of the window that were not fitted
    if (is_alone) variance = beyond.variance + variance * std::max(0.0, 1 - longer);
    // a band that holds no bins beside the drive: all that the tone leaves is noise
    if (!window.beside.is_known) {
      noise = rest;
      variance = split.rest.power.variance;
    }
    // beside a tone alone: the density next to it
    if (split.mean_square > kExplained * mean_square || !window.beside.is_known) {
      window.density = split.density;
    }
  }
  if (!window.density && window.chosen.part.from_drive) {
    const double drive_hz = window.chosen.part.state.from_hz;
    window.density = window.beside.DensityAt(drive_hz) *
                     std::pow(std::norm(Response(window.signal().design(), drive_hz)), 2);
  }
  HAPTOMETER_LET(const auto extremes, window.signal().ExtremesOf(
                                          window.chosen.begin, window.chosen.begin + window.rows));
  window.numbers.peak_to_peak_m = extremes.most - extremes.least;
  return {};
}

// what the sensor's averaging did at the tone, and whether it is divided out
void DescribeSensor(Window& window) {
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

// noise of samples without drive; what the drive's tone leaves there is no noise, and said
NoisePower QuietPower(Window& window, std::vector<double> samples) {
  if (window.numbers.tone) {
    const double tone_hz = window.numbers.tone->fit.frequency_hz;
    const SineFit left = FitSineAt(samples, {window.rate_hz(), window.bandwidth_hz(), 0}, tone_hz);
    if (left.converged && left.amplitude > kClearUncertainties * left.amplitude_uncertainty) {
      window.analysis.findings.Note(
          FindingKind::kQuietHasDrive,
          {{"amplitude_m", left.amplitude}, {"frequency_hz", left.frequency_hz}});
      const double duration_s = static_cast<double>(samples.size()) / window.rate_hz();
      return SplitTone({std::move(samples), window.rate_hz()}, left, window.band(), duration_s)
          .rest.power;
    }
  }
  return MeasureNoise(samples, window.rate_hz(), NoiseReachHz(window.band())).power;
}

// whether readings are clipped in samples [begin, end), or as near to them as a drive's edges ring:
// the edges of what is clipped, as tremor at an end of the range, reach all of the band
bool IsNearClipped(const Window& window, std::size_t begin, std::size_t end) {
  const auto reach =
      static_cast<std::size_t>(kQuietPeriods / window.band().lower_hz * window.rate_hz());
  const std::size_t first = begin - std::min(begin, reach);
  const std::size_t last = std::min(end + reach, window.signal().size());
  return ClippedRows(window.analysis.faults, window.signal().first_row() + first, last - first) > 0;
}

// noise of the intervals without drive, pooled by their durations; nothing where these are short
Result<std::optional<NoiseFloor>> NoiseOfQuiet(Window& window) {
  std::vector<WeightedPower> parts;
  NoiseFloor floor;
  floor.from = NoiseSource::kQuiet;
  const double least_s = kLeastWindowPeriods / window.band().lower_hz;
  for (const TimeWindow& quiet : window.chosen.part.quiet) {
    const auto [begin, end] = SettledWithin(window.signal(), quiet);
    const double part_s = static_cast<double>(end - begin) / window.rate_hz();
    if (part_s < least_s / 2) continue;
    if (IsNearClipped(window, begin, end)) continue;
    double of_hum = 0;
    HAPTOMETER_LET(auto samples, WithoutHum(window, begin, end, &of_hum));
    const NoisePower power = QuietPower(window, std::move(samples));
    // of which all that is beside the drive explains next to nothing: disturbed
    if ((1 - kExplained) * power.mean_square > std::pow(window.numbers.residual_rms_m, 2)) continue;
    parts.push_back({power, part_s});
    floor.quiet.push_back(
        {TimeOfSample(window.signal(), begin), TimeOfSample(window.signal(), end)});
    floor.duration_s += part_s;
  }
  if (floor.duration_s < least_s) return std::nullopt;
  floor.power = Pooled(parts);
  return floor;
}

// Noise from the question's file, the intervals without drive, or the spectrum beside the drive;
// then what is drive:  mean square - noise, with the variance 2 drive S / T of its beat with noise.
Result<void> TakeFloor(Window& window) {
  std::optional<NoiseFloor> floor = window.question.floor;
  if (!floor && window.chosen.part.from_drive) {
    HAPTOMETER_LET(floor, NoiseOfQuiet(window));
    if (!floor) {
      floor = NoiseFloor{.power = window.beside.power,
                         .duration_s = window.duration_s(),
                         .from = NoiseSource::kBeside};
    }
  }
  const double mean_square = window.numbers.power.mean_square;
  BandPower& power = window.power;
  if (!floor || !window.density) {
    power.rest = window.numbers.power;
    if (floor) power.floor = floor->power;
  } else {
    const double noise = std::min(mean_square, floor->power.mean_square);
    power.tone_mean_square = mean_square - noise;
    power.tone_variance = 2 * power.tone_mean_square * *window.density / window.duration_s();
    // the window's own noise scatters about the floor's as it does over that duration
    power.rest = {noise, floor->power.variance * floor->duration_s / window.duration_s()};
    power.floor = {floor->power.mean_square, floor->power.variance};
    if (floor->from == NoiseSource::kBeside) {
      power.rest.variance = window.beside.variance_of_rest;
      power.floor = {noise, 0};
    }
    // what is wrong in the noise is divided by the sensor's gain along with the drive
    const double gain_fourth = std::pow(power.sensor_gain, 4);
    power.rest.variance /= gain_fourth;
    power.floor->variance /= gain_fourth;
  }
  window.numbers.floor = std::move(floor);
  return {};
}

// share of the window's power that steps inside it make
double StepShare(const Window& window) {
  const UsedPart& part = window.numbers.part;
  return StepPower(window.analysis.faults, part.first_row, part.rows, window.band(),
                   window.rate_hz()) /
         window.numbers.power.mean_square;
}

// readings that the record repeats because its source is slower: held for k rows on average, they
// reduce a tone to sin(pi f k T) / (k sin(pi f T)), and show less of the band
void JudgeRepeats(Window& window, std::span<const double> samples) {
  const double share = RepeatedShare(samples);
  if (share == 0) return;
  RecordFacts& record = window.analysis.record;
  const double held = 1 / (1 - share);
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  const double angle = std::numbers::pi * frequency_hz / window.rate_hz();
  const double gain = std::abs(std::sin(held * angle) / (held * std::sin(angle)));
  record.fresh_rate_hz = std::min(record.fresh_rate_hz, window.rate_hz() / held);
  record.observable_upper_hz = record.fresh_rate_hz / kLeastRatePerUpperCorner;
  window.analysis.findings.Doubt(FindingKind::kSourceIsSlower,
                                 {{"share", share},
                                  {"new_readings_per_s", record.fresh_rate_hz},
                                  {"frequency_hz", frequency_hz},
                                  {"loss", 1 - gain}});
  CheckNewReadings(window.band(), &window.analysis);
}

// clipped values reduce the RMS: the answer is refused, its value a lower limit; of the middle of a
// long window
Result<void> JudgeClipping(Window& window) {
  const UsedPart& part = window.numbers.part;
  const std::size_t rows = ClippedRows(window.analysis.faults, part.first_row, part.rows);
  double share = static_cast<double>(rows) / static_cast<double>(part.rows);
  if (window.numbers.tone) {
    std::vector<double> samples(FittedOf(window.rows));
    const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
    HAPTOMETER_TRY(window.signal().samples().ReadMeasured(first, samples));
    JudgeRepeats(window, samples);
    const Clipping clipping =
        FindClipping(samples, window.rate_hz(), window.numbers.tone->fit.frequency_hz);
    if (clipping.verdict == ClippingVerdict::kUndecided) {
      window.analysis.findings.Doubt(FindingKind::kMayBeClipped, {{"share", clipping.share}});
    }
    if (clipping.verdict == ClippingVerdict::kClipped) share = std::max(share, clipping.share);
  }
  if (share <= kMostClipped) return {};
  window.numbers.is_lower_limit = true;
  window.analysis.findings.Refuse(FindingKind::kWindowClipped, {{"share", share}});
  return {};
}

// change of the RMS of a driven part if each end of what is kept moves inwards by a period of the
// lower corner, as its edges and bumps ring in the filter, or if all that may be bumps is excluded
Result<double> EdgeBound(const Window& window) {
  if (!window.chosen.part.from_drive) return 0;
  const auto period = static_cast<std::size_t>(window.rate_hz() / window.band().lower_hz);
  if (window.rows < 4 * period) return 0;
  HAPTOMETER_LET(const double inside, MeanSquareKept(window, window.chosen.excluded, period));
  HAPTOMETER_LET(const double between, MeanSquareKept(window, window.chosen.may_be_bumps, 0));
  // with the hum in all
  const double rms = std::sqrt(window.numbers.power.mean_square + window.hum_square);
  const auto change = [&](double square) { return square > 0 ? std::sqrt(square) - rms : 0; };
  const bool has_bumps = !window.chosen.may_be_bumps.empty();
  return std::hypot(change(inside), has_bumps ? change(between) : 0);
}

// what rounding to steps may hide of the drive: half width of the RMS's error, m
Result<void> BoundSteps(Window& window) {
  if (!window.chosen.part.from_drive) return {};
  std::vector<double> samples(std::min(window.rows, kMostForSteps));
  const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
  HAPTOMETER_TRY(window.signal().samples().Read(first, samples));
  const double step = std::max(StepOf(samples), window.step_m);
  // noise before the rounding, over all frequencies: what is above the rounding's own
  const double density = window.beside.DensityAt(window.band().upper_hz);
  const double noise = std::sqrt(std::max(0.0, density * window.rate_hz() / 2 - step * step / 12));
  const double rms = std::sqrt(window.power.tone_mean_square);
  const double amplitude = rms * std::numbers::sqrt2;
  const double tone_hz = window.numbers.tone ? window.numbers.tone->fit.frequency_hz
                                             : window.chosen.part.state.from_hz;
  const double all_phases =
      QuantisationBound(step, amplitude, noise, static_cast<int>(window.band().upper_hz / tone_hz));
  const double few_phases =
      CommensurateBound(step, amplitude, noise, tone_hz / window.rate_hz(), window.rows);
  window.steps_m = std::hypot(all_phases, few_phases);
  if (window.steps_m > kNoticeable * rms) {
    window.analysis.findings.Doubt(FindingKind::kQuantised,
                                   {{"share", window.steps_m / rms}, {"step_m", step}});
  }
  return {};
}

// half widths (m) of errors that the scatter of the samples does not contain
std::vector<RmsBound> BoundsOf(const Window& window, double edges_m) {
  const BandNumbers& numbers = window.numbers;
  const double rms = std::sqrt(numbers.power.mean_square);
  std::vector<RmsBound> bounds;
  bounds.reserve(kRmsCauseCount);
  const auto add = [&](RmsCause cause, double half_width) {
    if (half_width > 0) bounds.push_back({cause, half_width});
  };
  if (rms == 0) return bounds;
  // leaked motion adds its power, l^2 / (2 rms), and interferes with the tone by l / (pi df T)
  if (numbers.below_band) {
    const double leaked = numbers.below_band->leaked_rms_m;
    const double apart_hz = window.band().lower_hz - numbers.below_band->frequency_hz;
    const double beat = std::min(1.0, 1 / (std::numbers::pi * apart_hz * window.duration_s()));
    add(RmsCause::kBelowBand, leaked * leaked / (2 * rms) + leaked * beat);
  }
  // step / sqrt(12), of which 2 B / rate lies in the band; far below the RMS it adds in squares
  const double steps =
      window.step_m / std::sqrt(12) * std::sqrt(2 * window.bandwidth_hz() / window.rate_hz());
  add(RmsCause::kQuantisation,
      std::max(window.steps_m, std::min(steps, steps * steps / (2 * rms))));
  add(RmsCause::kBridged, numbers.bridged_rms_m);
  add(RmsCause::kFilterEnds, kSettledError * rms);
  if (numbers.tone) add(RmsCause::kBeat, BeatBound(window, rms));
  add(RmsCause::kDriveEdges, edges_m);
  // a share s of the power changes the RMS by s / 2 of it
  add(RmsCause::kSteps, 0.5 * rms * StepShare(window));
  const UsedPart& part = window.chosen.part;
  if (!part.from_drive) return bounds;
  // motion below the band comes and goes: what was subtracted of it, here or in a quiet interval,
  // may be half off; what lies above the corner was subtracted in a quiet interval only
  const bool alone = numbers.floor && numbers.floor->from != NoiseSource::kBeside;
  const double above = (alone ? 0.5 : 1) * window.beside.foot_mean_square;
  add(RmsCause::kFoot, (above + 0.5 * window.beside.below_mean_square) / (2 * rms));
  add(RmsCause::kHum, (alone ? kSameWithin : 0.5) * std::abs(window.hum_square) / (2 * rms));
  if (part.state.Drifts()) {
    add(RmsCause::kDrift, 0.5 * std::abs(part.state.drift) * rms);
  }
  return bounds;
}

// Leakage from below the band is no noise: a line of amplitude a, D = 2 pi times its distance from
// the tone, moves the tone's fit over the duration T by 2 a / (T D) at most, its frequency by
// 12 a / (A T^2 D) (linear weights of the fit, against a sine); so does its mirror at negative
// frequencies. Of unknown phase, each adds 1 / sqrt(2) of that (GUM 4.3.5).
void AddLeakedLine(const Window& window, SineFit& fit) {
  if (!window.numbers.below_band) return;
  const BelowBand& below = *window.numbers.below_band;
  const double apart = 1 / (kTwoPi * (fit.frequency_hz - below.frequency_hz)) +
                       1 / (kTwoPi * (fit.frequency_hz + below.frequency_hz));
  const double seconds = window.samples.duration_s();
  const double leaked_m = below.leaked_rms_m;  // amplitude / sqrt(2)
  const double moved_m = 2 * leaked_m / seconds * apart;
  const double turned_hz = 12 * leaked_m / (fit.amplitude * seconds * seconds) * apart / kTwoPi;
  fit.amplitude_uncertainty = std::hypot(fit.amplitude_uncertainty, moved_m);
  fit.frequency_uncertainty_hz = std::hypot(fit.frequency_uncertainty_hz, turned_hz);
  // stated at the first sample, half the duration from the middle
  fit.phase_uncertainty_rad = std::hypot(fit.phase_uncertainty_rad, moved_m / fit.amplitude,
                                         std::numbers::pi * seconds * turned_hz);
}

// the tone before the filter and before the sensor, with uncertainties from the noise about it
void FinishTone(Window& window) {
  ToneNumbers& tone = *window.numbers.tone;
  SineFit& fit = tone.fit;
  // two passes: gain |H|^2
  const double gain = std::norm(Response(window.signal().design(), fit.frequency_hz));
  tone.sine_rms_m = fit.amplitude / std::numbers::sqrt2;
  tone.share_of_rms = tone.sine_rms_m / std::sqrt(window.numbers.power.mean_square);
  // noise near the tone differs from white noise: all uncertainties by the same factor
  if (window.tone_variance > 0) {
    const double shape = std::sqrt(window.tone_variance) / fit.amplitude /
                         std::max(fit.amplitude_uncertainty, 1e-300);
    fit.amplitude_uncertainty *= shape;
    fit.frequency_uncertainty_hz *= shape;
    fit.phase_uncertainty_rad *= shape;
  }
  // the fit is of filtered samples: leakage is added there, the filter's gain divided out after it
  AddLeakedLine(window, fit);
  // what steps may change of the RMS, they change of the amplitude: a rectangular distribution
  const double steps_m = window.steps_m * std::numbers::sqrt2 / std::numbers::sqrt3;
  fit.amplitude_uncertainty = std::hypot(fit.amplitude_uncertainty, steps_m);
  fit.amplitude /= gain;
  fit.amplitude_uncertainty /= gain;
  // the rate is a line through times: each of its ends may be off by their uncertainty
  const double segment_s = static_cast<double>(window.signal().size()) / window.rate_hz();
  const double rate_share =
      std::numbers::sqrt2 * window.signal().segment().time_uncertainty_s / segment_s;
  fit.frequency_uncertainty_hz =
      std::hypot(fit.frequency_uncertainty_hz, fit.frequency_hz * rate_share);

  // the sensor's gain last: amplitude at the target
  tone.amplitude_m = fit.amplitude / window.power.sensor_gain;
  tone.amplitude_uncertainty_m = fit.amplitude_uncertainty / window.power.sensor_gain;
  tone.amplitude_lower_m = tone.amplitude_m - kCoverage * tone.amplitude_uncertainty_m;
  tone.amplitude_upper_m = tone.amplitude_m + kCoverage * tone.amplitude_uncertainty_m;
  tone.frequency_lower_hz = fit.frequency_hz - kCoverage * fit.frequency_uncertainty_hz;
  tone.frequency_upper_hz = fit.frequency_hz + kCoverage * fit.frequency_uncertainty_hz;
  // v = w x, a = w^2 x, peak values
  const double turn = kTwoPi * fit.frequency_hz;
  tone.velocity_m_per_s = turn * tone.amplitude_m;
  tone.acceleration_m_per_s2 = turn * turn * tone.amplitude_m;

  // power beside the tone of a drive this weak is hardly told from noise: the interval holds both
  RmsEstimate& rms = window.numbers.rms;
  const bool has_drive = window.chosen.part.from_drive;
  if (has_drive && 0.5 * (rms.upper_m - rms.lower_m) > kWideShare * rms.rms_m) {
    const double least_m = tone.sine_rms_m * tone.amplitude_lower_m / fit.amplitude;
    rms.lower_m = std::clamp(least_m, 0.0, rms.lower_m);
  }
}

// harmonics of the tone in the samples before the filter, with a cubic drift; motion below the band
// that one model explains is subtracted first, because it would cover them
Result<void> DescribeHarmonics(Window& window) {
  const double frequency_hz = window.numbers.tone->fit.frequency_hz;
  const double upper_hz = window.analysis.record.observable_upper_hz;
  if (2 * frequency_hz > upper_hz) return {};
  std::vector<double> samples(FittedOf(window.rows));
  const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
  HAPTOMETER_TRY(window.signal().samples().Read(first, samples));
  if (window.numbers.below_band && window.samples.duration_s() <= kLongestModelledS) {
    const auto model = BelowBandModel::Fit(samples, window.rate_hz(), window.band().lower_hz,
                                           window.band().upper_hz);
    if (model) model->Subtract(0, samples);
  }
  // up to the tenth harmonic: 10.5 leaves a margin for the frequency's uncertainty
  Harmonics harmonics = FitHarmonics(samples, {window.rate_hz(), 0, kHighestDriftDegree},
                                     frequency_hz, std::min(upper_hz, 10.5 * frequency_hz));
  if (harmonics.converged) window.numbers.harmonics = std::move(harmonics);
  return {};
}

// when the drive began, and what it takes
Result<void> DescribeDrive(const trial::RowSource& source, Window& window) {
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
Result<void> DescribeMotion(Window& window) {
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

// without a tone in the band: a drive above it may be all that there is
Result<void> DoubtAboveBand(const Window& window, BandAnalysis* analysis) {
  HAPTOMETER_LET(const auto above, FindAboveBand(*window.chosen.signal, window.band().upper_hz,
                                                 analysis->record.observable_upper_hz));
  if (!above || above->amplitude / std::numbers::sqrt2 < window.numbers.rms.as_measured_m)
    return {};
  analysis->findings.Doubt(FindingKind::kAboveBand, {{"amplitude_m", above->amplitude},
                                                     {"frequency_hz", above->frequency_hz}});
  return {};
}

}  // namespace

Result<void> MeasureWindow(const Displacement& displacement, const std::vector<BandSignal>& all,
                           const ChosenPart& chosen, const BandQuestion& question,
                           BandAnalysis* analysis) {
  const trial::Record& head = displacement.source.head();
  Window window{.head = head,
                .step_m = head.channels[displacement.channel].resolution,
                .chosen = chosen,
                .question = question,
                .analysis = *analysis};
  // the tone is sought in filtered samples, fewer of them where the rate is far above the band
  HAPTOMETER_LET(window.samples, SamplesOf(window));
  // two independent steps on two threads: the window itself, and motion below the band
  const auto describe_window = [&]() -> Result<void> {
    auto tone = ToneOf(window);
    if (tone && HasNoSingleTone(window, *tone)) tone.reset();
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
  window.numbers.whole_rms_m = WholeRms(all);
  // squared errors of interpolation, as RMS over the window
  window.numbers.bridged_rms_m = std::sqrt(chosen.signal->segment().bridged_error_square_sum /
                                           static_cast<double>(window.rows));
  DescribeSensor(window);
  // floor and clipping are required by the estimate of the RMS, the estimate by the tone's share
  HAPTOMETER_TRY(TakeFloor(window));
  HAPTOMETER_TRY(BoundSteps(window));
  HAPTOMETER_TRY(JudgeClipping(window));
  HAPTOMETER_LET(const auto edges, EdgeBound(window));
  window.numbers.rms = EstimateRms(window.power, BoundsOf(window, edges));
  const bool has_tone = window.numbers.tone.has_value();
  if (has_tone) FinishTone(window);
  if (!has_tone) HAPTOMETER_TRY(DoubtAboveBand(window, analysis));
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
