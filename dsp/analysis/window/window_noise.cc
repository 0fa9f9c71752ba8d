#include <algorithm>
#include <cmath>
#include <utility>

#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/window/measured_window.h"
#include "dsp/readings/faults.h"
#include "dsp/spectrum/sine_fit.h"

namespace haptometer::dsp {
namespace {

// ranges about the drive, and about its harmonics or not, that hold no bins of noise
std::vector<FrequencyRange> DriveRanges(const MeasuredWindow& window, bool harmonics) {
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

// noise of samples without drive; what the drive's tone leaves there is no noise, and said;
// nothing where it leaves most of its amplitude: the drive is on there, in more noise
std::optional<NoisePower> QuietPower(MeasuredWindow& window, std::vector<double> samples) {
  if (window.numbers.tone) {
    const SineFit& tone = window.numbers.tone->fit;
    const SineFit left =
        FitSineAt(samples, {window.rate_hz(), window.bandwidth_hz(), 0}, tone.frequency_hz);
    if (left.converged && left.amplitude > kClearUncertainties * left.amplitude_uncertainty) {
      if (left.amplitude > kMajority * tone.amplitude) return std::nullopt;
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
bool IsNearClipped(const MeasuredWindow& window, std::size_t begin, std::size_t end) {
  const auto reach =
      static_cast<std::size_t>(kQuietPeriods / window.band().lower_hz * window.rate_hz());
  const std::size_t first = begin - std::min(begin, reach);
  const std::size_t last = std::min(end + reach, window.signal().size());
  return ClippedRows(window.analysis.faults, window.signal().first_row() + first, last - first) > 0;
}

// noise of the intervals without drive, pooled by their durations; nothing where these are short
Result<std::optional<NoiseFloor>> NoiseOfQuiet(MeasuredWindow& window) {
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
    const std::optional<NoisePower> power = QuietPower(window, std::move(samples));
    // disturbed where it is more than all of the window, or where all that is beside the drive
    // explains next to nothing of it
    if (!power || power->mean_square > window.numbers.power.mean_square) continue;
    if ((1 - kExplained) * power->mean_square > std::pow(window.numbers.residual_rms_m, 2)) {
      continue;
    }
    parts.push_back({*power, part_s});
    floor.quiet.push_back(
        {TimeOfSample(window.signal(), begin), TimeOfSample(window.signal(), end)});
    floor.duration_s += part_s;
  }
  if (floor.duration_s < least_s) return std::nullopt;
  floor.power = Pooled(parts);
  return floor;
}

// What the tone leaves is noise where the band holds no bins beside it, or where the tone stands
// alone; else noise is at most that. The density is the one beside a tone that explains the window,
// or where no other is known.
void TakeRest(MeasuredWindow& window, const TonePower& split) {
  NoiseBeside& beside = window.beside;
  const NoisePower& rest = split.rest.power;
  if (split.mean_square > kExplained * window.numbers.power.mean_square || !beside.is_known) {
    window.density = split.density;
  }
  double& noise = beside.power.mean_square;
  double& variance = beside.variance_of_rest;
  if (!beside.is_known) {
    noise = rest.mean_square;
    variance = rest.variance;
    return;
  }
  // the tone stands alone where neither its harmonics nor the rest are clear of noise
  const NoisePower beyond = BeyondNoise(split.rest, beside, window.signal().design(), window.band(),
                                        DriveRanges(window, true));
  const double left = std::max(0.0, rest.mean_square - beyond.mean_square);
  const bool is_alone = left - noise <= kFalseAlarmDeviations * std::sqrt(variance) &&
                        beyond.mean_square <= kFalseAlarmDeviations * std::sqrt(beyond.variance);
  noise = is_alone ? left : std::min(noise, rest.mean_square);
  // and of samples of the window that were not fitted
  const double longer = window.samples.duration_s() / window.duration_s();
  if (is_alone) variance = beyond.variance + variance * std::max(0.0, 1 - longer);
}

bool HasSteadyTone(const MeasuredWindow& window) {
  const UsedPart& part = window.chosen.part;
  return window.numbers.tone && part.from_drive && part.state.is_steady;
}

// Whether what is beside the drive is noise: it is in a window that was chosen for its drive. In a
// stated one it may be vibration, unless it is beside a steady tone and no denser in any part than
// in the quietest.
bool IsNoiseBeside(const MeasuredWindow& window) {
  const NoiseBeside& beside = window.beside;
  if (window.question.choice == WindowChoice::kAuto) return true;
  return HasSteadyTone(window) && beside.is_known &&
         beside.power.mean_square - beside.flat_mean_square <=
             kFalseAlarmDeviations * std::sqrt(beside.power.variance);
}

// All that was measured, with the noise that may be in it: what is beside a steady tone; in any
// other window noise as dense throughout as in the quietest part, and motion below the band and in
// its foot; all of it where no part is known.
void KeepNoise(MeasuredWindow& window) {
  const NoiseBeside& beside = window.beside;
  const double mean_square = window.numbers.power.mean_square;
  window.power.rest = window.numbers.power;
  double noise = mean_square;
  double density = 0;
  if (HasSteadyTone(window)) {
    noise = std::min(noise, beside.power.mean_square);
    density = *window.density;
  } else if (beside.is_known) {
    noise = std::min(noise,
                     beside.flat_mean_square + beside.below_mean_square + beside.foot_mean_square);
    density = beside.least_density;
  }
  window.numbers.kept_noise_m = std::sqrt(noise);
  // its beat with the vibration, and its own scatter
  if (density > 0)
    window.power.rest.variance = (2 * mean_square - noise) * density / window.duration_s();
}

}  // namespace

Result<void> MeasurePower(MeasuredWindow& window) {
  // exact mean square over the window, from the sums of its cells
  HAPTOMETER_LET(const auto square, MeanSquareKept(window, window.chosen.excluded, 0));
  const double mean_square = std::max(0.0, square - window.hum_square);
  // variance from the fitted samples, scaled from their duration to that of the window
  const BandNoise whole =
      MeasureNoise(window.samples.values_m, window.samples.rate_hz, NoiseReachHz(window.band()));
  const double longer = window.samples.duration_s() / window.duration_s();
  window.numbers.power = {mean_square, whole.power.variance * longer};
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
    TakeRest(window, split);
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

Result<void> TakeFloor(MeasuredWindow& window) {
  std::optional<NoiseFloor> floor = window.question.floor;
  if (!floor && window.chosen.part.from_drive) {
    HAPTOMETER_LET(floor, NoiseOfQuiet(window));
    if (!floor && IsNoiseBeside(window)) {
      floor = NoiseFloor{.power = window.beside.power,
                         .duration_s = window.duration_s(),
                         .from = NoiseSource::kBeside};
    }
  }
  const double mean_square = window.numbers.power.mean_square;
  BandPower& power = window.power;
  if (!floor) {
    KeepNoise(window);
  } else {
    const double noise = std::min(mean_square, floor->power.mean_square);
    // of a floor its mean density, by its variance: integral of S^2 df / T
    const double density = window.density.value_or(
        noise > 0 ? floor->power.variance * floor->duration_s / floor->power.mean_square : 0);
    power.tone_mean_square = mean_square - noise;
    power.tone_variance = 2 * power.tone_mean_square * density / window.duration_s();
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

}  // namespace haptometer::dsp
