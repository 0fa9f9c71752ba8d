#include "dsp/analysis/settled_glances.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "base/error.h"
#include "dsp/analysis/raw_tile.h"
#include "dsp/analysis/tone_in_values.h"
#include "dsp/analysis/used_part.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kMostGlances = 31;
constexpr std::size_t kPausesIn = 8;  // one of so many, at least, where a tone does not continue
constexpr std::size_t kMostSteady = 4;
constexpr double kGlancePeriods = 2;  // of the lower corner, at most

// largest SquaredAmplitude within SettledGlances::kWander of a frequency, in steps of half a bin
double PowerAbout(std::span<const double> values, double rate_hz, double frequency_hz) {
  const double step_hz = 0.5 * rate_hz / static_cast<double>(values.size());
  const auto steps = static_cast<int>(SettledGlances::kWander * frequency_hz / step_hz);
  double most = 0;
  for (int k = -steps; k <= steps; ++k) {
    most = std::max(most, SquaredAmplitude(values, rate_hz, frequency_hz + k * step_hz));
  }
  return most;
}

// mean of SquaredAmplitude from half an octave below a frequency to half an octave above it
double NoisePowerAbout(std::span<const double> values, double rate_hz, double frequency_hz) {
  const double step_hz = rate_hz / static_cast<double>(values.size());
  const double lowest_hz = frequency_hz / std::numbers::sqrt2;
  const auto steps = static_cast<int>(lowest_hz / step_hz);
  double sum = 0;
  for (int k = 0; k <= steps; ++k)
    sum += SquaredAmplitude(values, rate_hz, lowest_hz + k * step_hz);
  return sum / (steps + 1);
}

// the power that all windows but the quietest eighth exceed
template <typename PowerOf>
double QuietPower(const std::vector<std::vector<double>>& windows, const PowerOf& power_of) {
  std::vector<double> powers;
  powers.reserve(windows.size());
  for (const std::vector<double>& window : windows) powers.push_back(power_of(window));
  const auto low = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / kPausesIn);
  std::ranges::nth_element(powers, low);
  return *low;
}

// whether a tone is in each eighth of some values, except for one between the ends, in which a tone
// that drifts may cancel
bool IsInAll(std::span<const double> values, double rate_hz, const SineFit& tone) {
  const std::size_t size = values.size() / kPausesIn;
  if (size == 0) return false;
  const double least = std::pow(SettledGlances::kElsewhere * tone.amplitude, 2);
  std::size_t without = 0;
  for (std::size_t k = 0; k < kPausesIn; ++k) {
    const auto eighth = values.subspan(k * size, size);
    if (SquaredAmplitude(eighth, rate_hz, tone.frequency_hz) >= least) continue;
    if (k == 0 || k + 1 == kPausesIn || ++without > 1) return false;
  }
  return true;
}

}  // namespace

Result<SettledGlances> SettledGlances::Read(const BandSignal& signal, const BandPass& band) {
  const std::size_t settled = signal.settled_end() - signal.settled_begin();
  HAPTOMETER_CHECK(settled >= kLeastSettled, "{} samples free of transients", settled);
  const auto longest = static_cast<std::size_t>(kGlancePeriods / band.lower_hz * signal.rate_hz());
  const std::size_t size = std::max(std::min(longest, settled / kLeastSettled), std::size_t{1});
  const std::size_t every = SamplesAValue(signal.rate_hz(), band);
  // uniformly spread windows of at most two periods of the lower corner, up to 31 of them
  SettledGlances glances;
  glances.rate_hz_ = signal.rate_hz() / static_cast<double>(every);
  glances.windows_m_.resize(std::min(kMostGlances, 2 * (settled / size) - 1));
  std::vector<double> samples(size);
  for (std::size_t k = 0; k < glances.windows_m_.size(); ++k) {
    const std::size_t at =
        signal.settled_begin() + (settled - size) * k / (glances.windows_m_.size() - 1);
    if (auto read = signal.Read(at, samples); !read) return std::unexpected(read.error());
    for (std::size_t i = 0; i < size; i += every) glances.windows_m_[k].push_back(samples[i]);
  }
  return glances;
}

double SettledGlances::duration_s() const {
  return static_cast<double>(windows_m_.front().size()) / rate_hz_;
}

double SettledGlances::LeastAmplitude(double frequency_hz) const {
  return std::sqrt(QuietPower(windows_m_, [&](const std::vector<double>& window) {
    return PowerAbout(window, rate_hz_, frequency_hz);
  }));
}

double SettledGlances::NoisePower(double frequency_hz) const {
  return QuietPower(windows_m_, [&](const std::vector<double>& window) {
    return NoisePowerAbout(window, rate_hz_, frequency_hz);
  });
}

// subtracts steady tones, which would cover a brief one
void SettledGlances::TakeOut(std::span<const SteadyTone> tones) {
  for (const SteadyTone& tone : tones) {
    const Turns turns = TurnsOf(tone.frequency_hz, rate_hz_, windows_m_.front().size());
    for (std::vector<double>& window : windows_m_) TakeOutNearest(turns, window);
  }
}

Result<std::vector<SteadyTone>> FindSteadyTones(const BandSignal& signal, const BandPass& band) {
  const auto read = ReadMiddle(signal, signal.settled_begin(), signal.settled_end());
  if (!read) return std::unexpected(read.error());
  const std::size_t every = SamplesAValue(signal.rate_hz(), band);
  const double rate_hz = signal.rate_hz() / static_cast<double>(every);
  std::vector<double> values;
  values.reserve(read->size() / every + 1);
  for (std::size_t k = 0; k < read->size(); k += every) values.push_back((*read)[k]);
  std::vector<SteadyTone> steady;
  // the strongest tone first; one that pauses ends the search
  for (std::size_t k = 0; k < kMostSteady; ++k) {
    const auto tone = StrongestTone(values, {rate_hz, band.lower_hz, band.upper_hz});
    if (!tone || !IsInAll(values, rate_hz, *tone)) break;
    steady.push_back({tone->frequency_hz, tone->amplitude});
    TakeOutNearest(TurnsOf(tone->frequency_hz, rate_hz, values.size()), values);
  }
  return steady;
}

}  // namespace haptometer::dsp
