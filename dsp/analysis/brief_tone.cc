#include "dsp/analysis/brief_tone.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "dsp/analysis/raw_tile.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

constexpr double kGlanceSamplesPerUpper = 8;  // kept of a period of the upper corner
constexpr double kTilePeriods = 12;           // of the lower corner
constexpr double kLeastPeriods = 3;           // of a tone in a window
constexpr double kLeastPeriodsOn = 3.5;       // and as far as it goes on
constexpr std::size_t kMostStepsInTile = 4;   // in a tile
constexpr std::size_t kMostWindowHalvings = 5;
constexpr std::size_t kLeastWindowValues = 8;
constexpr double kFalseAlarm = 1e-4;     // of a record
constexpr double kElsewhere = 0.3;       // of a tone's amplitude: there it goes on
constexpr double kNoiseDeviations = 4;   // of noise, by which a tone is less there
constexpr double kNoisePowers = 80;      // by which a tone is above noise
constexpr double kMedianSquare = 0.455;  // of normally distributed noise of variance 1
constexpr double kMostOf = 0.42;
constexpr double kWander = 0.05;  // of a tone's frequency
constexpr std::size_t kMostGlances = 31;
constexpr std::size_t kLeastGlances = 8;
constexpr std::size_t kPausesIn = 8;  // one of so many, at least, where a tone does not go on
constexpr double kGlancePeriods = 2;  // of the lower corner, at most
constexpr std::size_t kMostTiles = 64;
constexpr std::size_t kLoudTiles = 8;
constexpr double kLoudS = 8e-3;
constexpr std::size_t kMostAsked = 16;

// a tone in samples [begin, end) of a tile
struct Seen {
  std::size_t begin = 0;
  std::size_t end = 0;
  double frequency_hz = 0;
  double amplitude_m = 0;
  double uncertainty_m = 0;  // of the amplitude
  double duration_s = 0;

  // a sum of squares
  [[nodiscard]] double energy_m2() const {
    return 0.5 * amplitude_m * amplitude_m * static_cast<double>(end - begin);
  }
};

// whether noise hardly ever gives such a fit in one of so many bins: with v pairs of independent
// values about it, (1 + x / v)^-v for an amplitude of x in units of 2 u^2
bool StandsOut(const SineFit& fit, double bins, double false_alarm) {
  const double v = 0.5 * fit.degrees_of_freedom;
  const double x = 0.5 * std::pow(fit.amplitude / fit.amplitude_uncertainty, 2);
  return bins * std::pow(1 + x / v, -v) < false_alarm;
}

std::optional<Seen> ToneIn(const RawTile& tile, std::size_t begin, std::size_t size,
                           const BandPass& band, double false_alarm) {
  const double duration_s = static_cast<double>(size) / tile.rate_hz();
  const double lowest_hz = std::max(tile.clear_hz(), kLeastPeriods / duration_s);
  if (lowest_hz >= band.upper_hz) return std::nullopt;
  const auto fit = StrongestTone(std::span(tile.values_m()).subspan(begin, size),
                                 {tile.rate_hz(), lowest_hz, band.upper_hz, 0, false_alarm});
  const double bins = std::max(1.0, (band.upper_hz - lowest_hz) * duration_s);
  if (!fit || !StandsOut(*fit, bins, false_alarm)) return std::nullopt;
  return Seen{
      begin,     begin + size, fit->frequency_hz, fit->amplitude, fit->amplitude_uncertainty,
      duration_s};
}

// tones in the windows of a tile
std::vector<Seen> TonesOf(const RawTile& tile, const BandPass& band, double false_alarm) {
  std::vector<Seen> tones;
  for (std::size_t halving = 0; halving <= kMostWindowHalvings; ++halving) {
    const std::size_t size = tile.values_m().size() >> halving;
    if (size < kLeastWindowValues) break;
    for (std::size_t begin = 0; begin + size <= tile.values_m().size(); begin += (size + 1) / 2) {
      if (const auto tone = ToneIn(tile, begin, size, band, false_alarm)) tones.push_back(*tone);
    }
  }
  return tones;
}

// The same once steps are taken out that explain more than any tone does: a step leaves a tile a
// swing at the lowest tones.
std::vector<Seen> TonesBesideSteps(RawTile& tile, const BandPass& band, double false_alarm) {
  std::vector<Seen> tones = TonesOf(tile, band, false_alarm);
  for (std::size_t step = 0; step < kMostStepsInTile && !tones.empty(); ++step) {
    const double most_m2 = std::ranges::max_element(tones, {}, &Seen::energy_m2)->energy_m2();
    if (!tile.TakeOutStep(most_m2)) break;
    tones = TonesOf(tile, band, false_alarm);
  }
  return tones;
}

// the square of a tone's amplitude in samples
double PowerAt(std::span<const double> samples, double rate_hz, double frequency_hz) {
  const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * frequency_hz / rate_hz);
  std::complex<double> phasor = 1;
  std::complex<double> sum = 0;
  for (const double x : samples) {
    sum += x * phasor;
    phasor *= turn;
  }
  return 4 * std::norm(sum) / std::pow(static_cast<double>(samples.size()), 2);
}

// the most of PowerAt within kWander of `frequency_hz`
double PowerAbout(std::span<const double> samples, double rate_hz, double frequency_hz) {
  const double step_hz = 0.5 * rate_hz / static_cast<double>(samples.size());
  const auto steps = static_cast<int>(kWander * frequency_hz / step_hz);
  double most = 0;
  for (int k = -steps; k <= steps; ++k) {
    most = std::max(most, PowerAt(samples, rate_hz, frequency_hz + k * step_hz));
  }
  return most;
}

// short windows of what has settled, evenly spread; every n-th of their samples, which hold the
// band
struct Glances {
  std::vector<std::vector<double>> windows_m;
  double rate_hz = 0;
};

Result<Glances> ReadGlances(const BandSignal& signal, const BandPass& band) {
  const std::size_t settled = signal.settled_end() - signal.settled_begin();
  const auto longest = static_cast<std::size_t>(kGlancePeriods / band.lower_hz * signal.rate_hz());
  const std::size_t size = std::max(std::min(longest, settled / kLeastGlances), std::size_t{1});
  const auto stride = static_cast<std::size_t>(
      std::max(1.0, signal.rate_hz() / (kGlanceSamplesPerUpper * band.upper_hz)));
  Glances glances;
  glances.rate_hz = signal.rate_hz() / static_cast<double>(stride);
  glances.windows_m.resize(std::min(kMostGlances, 2 * (settled / size) - 1));
  std::vector<double> samples(size);
  for (std::size_t k = 0; k < glances.windows_m.size(); ++k) {
    const std::size_t at =
        signal.settled_begin() + (settled - size) * k / (glances.windows_m.size() - 1);
    if (auto read = signal.Read(at, samples); !read) return std::unexpected(read.error());
    for (std::size_t i = 0; i < size; i += stride) glances.windows_m[k].push_back(samples[i]);
  }
  return glances;
}

// what all windows of what has settled but the quietest eighth are above
template <typename PowerOf>
double QuietPower(const Glances& glances, const PowerOf& power_of) {
  std::vector<double> powers;
  powers.reserve(glances.windows_m.size());
  for (const std::vector<double>& window : glances.windows_m) powers.push_back(power_of(window));
  const auto low = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / kPausesIn);
  std::ranges::nth_element(powers, low);
  return *low;
}

// the amplitude of a tone, or of noise, that all of what has settled but a short part is above
double LeastAmplitude(const Glances& glances, const Seen& tone) {
  return std::sqrt(QuietPower(glances, [&](const std::vector<double>& window) {
    return PowerAbout(window, glances.rate_hz, tone.frequency_hz);
  }));
}

// the mean of PowerAt from half an octave below a frequency to half an octave above it
double NoisePowerAbout(std::span<const double> samples, double rate_hz, double frequency_hz) {
  const double step_hz = rate_hz / static_cast<double>(samples.size());
  const double lowest_hz = frequency_hz / std::numbers::sqrt2;
  const auto steps = static_cast<int>(lowest_hz / step_hz);
  double sum = 0;
  for (int k = 0; k <= steps; ++k) sum += PowerAt(samples, rate_hz, lowest_hz + k * step_hz);
  return sum / (steps + 1);
}

// whether a tone is more than noise of any colour gives where the record is most quiet
bool IsAboveNoise(const Glances& glances, const Seen& tone) {
  const double noise = QuietPower(glances, [&](const std::vector<double>& window) {
    return NoisePowerAbout(window, glances.rate_hz, tone.frequency_hz);
  });
  const double glance_s = static_cast<double>(glances.windows_m[0].size()) / glances.rate_hz;
  return tone.amplitude_m * tone.amplitude_m > kNoisePowers * noise * glance_s / tone.duration_s;
}

// whether a tone is in all of what has settled, as far as noise lets that be told
bool GoesOn(const Glances& glances, const Seen& tone) {
  const double glance_s = static_cast<double>(glances.windows_m[0].size()) / glances.rate_hz;
  const double noise_m = tone.uncertainty_m * std::sqrt(2 * tone.duration_s / glance_s);
  const double least_m = tone.amplitude_m - kNoiseDeviations * (tone.uncertainty_m + noise_m);
  return LeastAmplitude(glances, tone) > std::min(kElsewhere * tone.amplitude_m, least_m);
}

// how far a tone goes on from its window, in a tile: where two periods of it hold half of it
BriefTone Grown(const RawTile& tile, const Seen& tone) {
  const auto size = std::min(tile.values_m().size(),
                             static_cast<std::size_t>(2 * tile.rate_hz() / tone.frequency_hz) + 1);
  const auto is_on = [&](std::size_t at) {
    return PowerAt(std::span(tile.values_m()).subspan(at, size), tile.rate_hz(),
                   tone.frequency_hz) > 0.25 * tone.amplitude_m * tone.amplitude_m;
  };
  const std::size_t last = tile.values_m().size() - size;
  const std::size_t middle = std::min(last, (tone.begin + tone.end - size) / 2);
  std::size_t begin = middle;
  while (begin > 0 && is_on(begin - 1)) --begin;
  std::size_t end = middle;
  while (end < last && is_on(end + 1)) ++end;
  // a block is on from where half of it is, and at the tile's ends as a whole
  const std::size_t first = begin == 0 ? 0 : begin + size / 2;
  const std::size_t past = end == last ? tile.values_m().size() : end + (size + 1) / 2;
  return {{tile.Time(std::min(first, past)), tile.Time(past)},
          tone.frequency_hz,
          tone.amplitude_m / std::numbers::sqrt2};
}

// where tiles begin, the last one at the signal's end
std::vector<std::size_t> TilesOf(std::size_t size, std::size_t tile) {
  std::vector<std::size_t> begins;
  for (std::size_t begin = 0; begin + tile < size; begin += tile / 2) begins.push_back(begin);
  begins.push_back(size - tile);
  return begins;
}

// the highest power over kLoudS in a tile of filtered samples
double LoudnessOf(const BandSignal& signal, std::size_t begin, std::size_t size) {
  const std::size_t cell = signal.cell_samples();
  const auto cells = static_cast<std::size_t>(
      std::max(1.0, kLoudS * signal.rate_hz() / static_cast<double>(cell)));
  double loudest = 0;
  double sum = 0;
  for (std::size_t k = begin / cell; k < (begin + size) / cell; ++k) {
    sum += signal.cells()[k].square_sum;
    if (k >= begin / cell + cells) sum -= signal.cells()[k - cells].square_sum;
    loudest = std::max(loudest, sum);
  }
  return loudest;
}

// of many tiles those that touch an unsettled end, and the loudest others
std::vector<std::size_t> FewTiles(const BandSignal& signal, std::vector<std::size_t> begins,
                                  std::size_t tile) {
  if (begins.size() <= kMostTiles) return begins;
  std::vector<std::size_t> few;
  std::vector<std::pair<double, std::size_t>> others;
  for (const std::size_t begin : begins) {
    if (begin < signal.settled_begin() || begin + tile > signal.settled_end()) {
      few.push_back(begin);
    } else {
      others.emplace_back(LoudnessOf(signal, begin, tile), begin);
    }
  }
  const std::size_t kept = std::min(kLoudTiles, others.size());
  std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(kept),
                            std::ranges::greater{});
  for (std::size_t k = 0; k < kept; ++k) few.push_back(others[k].second);
  return few;
}

// whether a tone is most of what a tile holds beside noise: what rings about a bump is not
bool IsMostOf(const RawTile& tile, const BriefTone& tone) {
  std::vector<double> squares(tile.values_m().size());
  std::ranges::transform(tile.values_m(), squares.begin(), [](double x) { return x * x; });
  const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::ranges::nth_element(squares, middle);
  const double noise = *middle / kMedianSquare * static_cast<double>(squares.size());
  return tone.rms_m * tone.rms_m * tone.window.duration_s() * tile.rate_hz() >
         kMostOf * (sum - noise);
}

// Whether its power swells in the middle as what a polynomial leaves of a bump does: the middle
// third has more than twice what the outer two have.
bool Swells(const RawTile& tile, const BriefTone& tone) {
  const auto third = static_cast<std::size_t>(tone.window.duration_s() * tile.rate_hz() / 3);
  const auto first =
      static_cast<std::size_t>(std::round((tone.window.begin_s - tile.Time(0)) * tile.rate_hz()));
  const auto power = [&](std::size_t from) {
    double sum = 0;
    for (std::size_t k = from; k < from + third; ++k) {
      sum += tile.values_m()[k] * tile.values_m()[k];
    }
    return sum;
  };
  return power(first + third) > power(first) + power(first + 2 * third);
}

// the tone of most energy in a tile that is on for a part of the signal only; none beside one that
// fills the tile and goes on
std::optional<BriefTone> BriefIn(RawTile& tile, const Glances& glances, const BandPass& band,
                                 double false_alarm) {
  const auto whole = ToneIn(tile, 0, tile.values_m().size(), band, false_alarm);
  if (whole && LeastAmplitude(glances, *whole) > kElsewhere * whole->amplitude_m) {
    return std::nullopt;
  }
  std::vector<Seen> tones = TonesBesideSteps(tile, band, false_alarm);
  std::ranges::sort(tones, std::ranges::greater{}, &Seen::energy_m2);
  for (const Seen& tone : std::span(tones).first(std::min(kMostAsked, tones.size()))) {
    const BriefTone grown = Grown(tile, tone);
    if (grown.window.duration_s() * tone.frequency_hz < kLeastPeriodsOn) continue;
    if (Swells(tile, grown) || !IsMostOf(tile, grown) || !IsAboveNoise(glances, tone)) continue;
    if (!GoesOn(glances, tone)) return grown;
  }
  return std::nullopt;
}

}  // namespace

Result<std::optional<BriefTone>> FindBriefTone(const BandSignal& signal, const BandPass& band) {
  if (signal.settled_end() - signal.settled_begin() < kLeastGlances) return std::nullopt;
  const auto glances = ReadGlances(signal, band);
  if (!glances) return std::unexpected(glances.error());
  const auto size = std::min(
      signal.size(), static_cast<std::size_t>(kTilePeriods / band.lower_hz * signal.rate_hz()));
  const std::vector<std::size_t> begins = FewTiles(signal, TilesOf(signal.size(), size), size);
  const double windows = std::exp2(kMostWindowHalvings + 2) * static_cast<double>(begins.size());
  std::optional<BriefTone> most;
  for (const std::size_t begin : begins) {
    auto tile = RawTile::Read(signal, begin, begin + size, band);
    if (!tile) return std::unexpected(tile.error());
    if (!tile->IsRidOfWhatLiesBelow()) continue;
    const auto tone = BriefIn(*tile, *glances, band, kFalseAlarm / windows);
    const auto energy = [](const BriefTone& brief) {
      return brief.rms_m * brief.rms_m * brief.window.duration_s();
    };
    if (tone && (!most || energy(*tone) > energy(*most))) most = tone;
  }
  return most;
}

}  // namespace haptometer::dsp
