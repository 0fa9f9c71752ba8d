#include "dsp/analysis/tone_power.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// subtracts a line from uniformly spaced samples
void TakeLine(const Harmonic& line, double rate_hz, std::vector<double>& rest) {
  const PhasorBlocks phasors(2 * std::numbers::pi * line.frequency_hz / rate_hz);
  const double c = line.amplitude * std::cos(line.phase_rad);
  const double s = line.amplitude * std::sin(line.phase_rad);
  std::array<double, PhasorBlocks::kBlock> cosines;
  std::array<double, PhasorBlocks::kBlock> sines;
  for (std::size_t begin = 0; begin < rest.size(); begin += PhasorBlocks::kBlock) {
    const std::size_t count = std::min(PhasorBlocks::kBlock, rest.size() - begin);
    phasors.Fill(static_cast<double>(begin), std::span(cosines).first(count),
                 std::span(sines).first(count));
    for (std::size_t k = 0; k < count; ++k) rest[begin + k] -= c * cosines[k] - s * sines[k];
  }
}

// the tone and its harmonics that exceed the noise; the tone alone where they cannot be fitted
std::vector<Harmonic> LinesOf(const ThinnedSamples& samples, const SineFit& tone,
                              const BandPass& band) {
  const Harmonics lines =
      FitHarmonics(samples.values_m, {samples.rate_hz, band.upper_hz - band.lower_hz, 0},
                   tone.frequency_hz, band.upper_hz);
  std::vector<Harmonic> taken;
  if (lines.converged) taken = lines.harmonics;
  std::erase_if(taken, [](const Harmonic& line) { return line.order > 1 && !line.stands_out; });
  if (taken.empty()) {
    taken.push_back({1, tone.frequency_hz, tone.amplitude, tone.amplitude_uncertainty,
                     tone.phase_rad, tone.phase_uncertainty_rad, true});
  }
  return taken;
}

}  // namespace

TonePower SplitTone(const ThinnedSamples& samples, const SineFit& tone, const BandPass& band,
                    double window_s) {
  const std::vector<Harmonic> lines = LinesOf(samples, tone, band);
  std::vector<double> rest = samples.values_m;
  for (const Harmonic& line : lines) TakeLine(line, samples.rate_hz, rest);
  const BandNoise noise = MeasureNoise(rest, samples.rate_hz, NoiseReachHz(band));
  TonePower split{.density = noise.DensityNear(tone.frequency_hz, band.lower_hz, band.upper_hz),
                  .rest = noise.power};
  for (const Harmonic& line : lines) {
    // S / T: the noise's mean square in a line of width 1 / T
    const double square =
        noise.DensityNear(line.frequency_hz, band.lower_hz, band.upper_hz) / window_s;
    // mean square a^2 / 2 less that of the noise; Var(a^2 / 2) = a^2 u^2, u^2 = S / T
    split.mean_square += 0.5 * line.amplitude * line.amplitude - square;
    split.variance += line.amplitude * line.amplitude * square;
  }
  return split;
}

}  // namespace haptometer::dsp
