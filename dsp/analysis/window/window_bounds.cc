#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/window/measured_window.h"
#include "dsp/filter/transient.h"
#include "dsp/readings/digitisation.h"
#include "dsp/readings/faults.h"

namespace haptometer::dsp {
namespace {

// samples that show the steps of a converter
constexpr std::size_t kMostForSteps = std::size_t{1} << 16U;

// Half width of what a part of a beat changes of the RMS: the squares of a1 cos(w1 t) + a2 cos(w2
// t) hold a1 a2 cos((w1 - w2) t), whose mean over T is a1 a2 / (pi df T) at most; a modulation has
// a sideband as far on the other side, whose beat adds. Over whole periods of the tone its
// harmonics have none.
double BeatBound(const MeasuredWindow& window, double rms) {
  if (!window.second) return 0;
  const SineFit& tone = window.numbers.tone->fit;
  const SineFit& other = *window.second;
  const double harmonic_hz = std::round(other.frequency_hz / tone.frequency_hz) * tone.frequency_hz;
  const double bin_hz = 1 / window.samples.duration_s();
  if (harmonic_hz > 0 && std::abs(other.frequency_hz - harmonic_hz) < bin_hz) return 0;
  const double apart_hz = std::abs(other.frequency_hz - tone.frequency_hz);
  return tone.amplitude * (other.amplitude + window.mirrored_m) /
         (2 * rms * std::numbers::pi * apart_hz * window.duration_s());
}

// Half width of what errors e of interpolated samples change of the RMS, by the mean of 2 s e + e^2
// over the window. Interpolation gives what is to be expected of a sample: the mean square lacks
// the errors' own in the band, of which their spectrum is nowhere above their absolute covariances.
// The sum of s e has at most 2 rms^2, a tone's largest square, times these covariances as its
// variance, of which twice the root counts.
double BridgedBound(const MeasuredWindow& window, double rms) {
  double square_sum = 0;
  double covariance_sum = 0;
  for (const Bridge& bridge :
       window.signal().samples().BridgesWithin(window.chosen.begin, window.rows)) {
    square_sum += bridge.error_square;
    covariance_sum += bridge.covariance_sum;
  }
  const double in_band =
      std::min(square_sum, 2 * window.bandwidth_hz() / window.rate_hz() * covariance_sum);
  return (in_band / (2 * rms) + 2 * std::sqrt(2 * covariance_sum)) /
         static_cast<double>(window.rows);
}

// share of the window's power that steps inside it make
double StepShare(const MeasuredWindow& window) {
  const UsedPart& part = window.numbers.part;
  return StepPower(window.analysis.faults, part.first_row, part.rows, window.band(),
                   window.rate_hz()) /
         window.numbers.power.mean_square;
}

// change of the RMS of a driven part if each end of what is kept moves inwards by a period of the
// lower corner, as its edges and bumps ring in the filter, or if all that may be bumps is excluded
Result<double> EdgeBound(const MeasuredWindow& window) {
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

}  // namespace

Result<void> BoundSteps(MeasuredWindow& window) {
  if (!window.chosen.part.from_drive) return {};
  std::vector<double> samples(std::min(window.rows, kMostForSteps));
  const std::size_t first = window.chosen.begin + (window.rows - samples.size()) / 2;
  HAPTOMETER_TRY(window.signal().samples().Read(first, samples));
  const double step = std::max(StepOf(samples), window.step_m);
  // noise before the rounding, over all frequencies: what is above the rounding's own. An estimate
  // that is too large would hide what rounding does, hence one uncertainty below the best one
  const double density = window.beside.upper_density;
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

Result<std::vector<RmsBound>> BoundsOf(const MeasuredWindow& window) {
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
  add(RmsCause::kBridged, BridgedBound(window, rms));
  add(RmsCause::kFilterEnds, kSettledError * rms);
  const double without_noise =
      std::sqrt(std::max(0.0, rms * rms - std::pow(numbers.kept_noise_m, 2)));
  if (numbers.kept_noise_m > 0) {
    bounds.push_back({RmsCause::kNoiseKept, rms - without_noise, true});
  }
  // what other ends of the window would change: a stated one is measured as it is
  const bool is_chosen = window.question.choice == WindowChoice::kAuto;
  if (is_chosen && numbers.tone) add(RmsCause::kBeat, BeatBound(window, rms));
  if (is_chosen) {
    HAPTOMETER_LET(const double edges_m, EdgeBound(window));
    add(RmsCause::kDriveEdges, edges_m);
  }
  // a share s of the power changes the RMS by s / 2 of it
  add(RmsCause::kSteps, 0.5 * rms * StepShare(window));
  const UsedPart& part = window.chosen.part;
  if (!part.from_drive) return bounds;
  // motion below the band comes and goes: what was subtracted of it, here or in a quiet interval,
  // may be half off; what lies above the corner was subtracted in a quiet interval only
  const bool alone = numbers.floor && numbers.floor->from != NoiseSource::kBeside;
  const double above = (alone ? 0.5 : 1) * window.beside.foot_mean_square;
  if (numbers.floor) {
    add(RmsCause::kFoot, (above + 0.5 * window.beside.below_mean_square) / (2 * rms));
  }
  add(RmsCause::kHum, (alone ? kSameWithin : 0.5) * std::abs(window.hum_square) / (2 * rms));
  const double drift = part.state.Drifts() ? 0.5 * std::abs(part.state.drift) : 0;
  if (is_chosen) add(RmsCause::kDrift, (drift + part.state.modulation) * rms);
  return bounds;
}

}  // namespace haptometer::dsp
