#include "dsp/analysis/brief_tone.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "dsp/analysis/raw_tile.h"
#include "dsp/analysis/settled_glances.h"
#include "dsp/analysis/tone_in_values.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// Where "measured" stands below, each property of a tone was printed for all tones that meet the
// other five, the best one of a record: in 1533 records without a drive (NoPartIsDriven, 16
// repetitions) and in 318 with one (UnsettledDrive, 1 repetition) whose voltage was not used.

// the shortest tile in which a polynomial up to 0.75 of 20 Hz leaves most of the band (clear_hz),
// and many times what a drive that is too short to reach steady state lasts
constexpr double kTileS = 0.6;
constexpr double kLeastTilePeriods = 12;  // of the lower corner: the same, of other bands
constexpr double kMostTilePeriods = 48;   // of the lower corner: degrees cost size x degree^2
// of a tone in a window: with two a bump and its rebound are a tone
constexpr double kLeastPeriods = 3;
// and as far as it continues; measured: 4.6 or more with a drive, without one 3.8 or less in three
// of four (11 records, most of them bumps)
constexpr double kLeastPeriodsOn = 3.5;
constexpr std::size_t kMostStepsInTile = 4;
constexpr std::size_t kMostWindowHalvings = 5;  // to 19 ms: what is shorter is a bump
constexpr std::size_t kLeastWindowValues = 8;   // twice as many as a fit has parameters
constexpr double kFalseAlarm = 1e-4;            // of a record
constexpr double kNoiseDeviations = 4;          // 3e-5 of normally distributed noise is farther off
// By which a tone's power is above the noise's. Of some 5000 bins and windows the highest of white
// noise passes 18 times its mean with 1e-4; the quietest eighth of 31 windows is a third to a
// quarter of that mean. Measured without a drive: 17 in the middle, 85 in 1 of 100; with one 270
// and more.
constexpr double kNoisePowers = 80;
constexpr double kMedianSquare = 0.455;  // of normally distributed noise of variance 1
// Of what power a tile has beside noise. Measured with a drive: 0.62 and more; without one 0.02 or
// less in three of four, the others bumps.
constexpr double kMostOf = 0.42;
// part of its steady amplitude up to which a steady tone is subtracted from a tile: if it has more
// there, a step or a drive of its frequency would be fitted too, and remains as it is
constexpr double kMostOfSteady = 1.5;
constexpr std::size_t kMostTiles = 64;  // a third of a second's work
constexpr std::size_t kLoudTiles = 8;
constexpr double kLoudS = 8e-3;         // less than half of the shortest window
constexpr std::size_t kMostAsked = 16;  // windows of one drive are among the first

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

// whether noise rarely gives such a fit in one of so many bins: with v pairs of independent
// values about it, (1 + x / v)^-v for an amplitude of x in units of 2 u^2
bool StandsOut(const SineFit& fit, double bins, double false_alarm) {
  const double v = 0.5 * fit.degrees_of_freedom;
  const double x = 0.5 * std::pow(fit.amplitude / fit.amplitude_uncertainty, 2);
  return bins * std::pow(1 + x / v, -v) < false_alarm;
}

// the strongest tone of at least three periods in a window, above what the polynomial removed
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

// tones in windows of a tile: whole, halves, quarters .. that overlap by half
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

// The same after steps are removed that explain more than any tone: a step less its polynomial is
// an oscillation at the lowest frequencies.
std::vector<Seen> TonesBesideSteps(RawTile& tile, const BandPass& band, double false_alarm) {
  std::vector<Seen> tones = TonesOf(tile, band, false_alarm);
  // a step counts only with more energy than the strongest tone
  for (std::size_t step = 0; step < kMostStepsInTile && !tones.empty(); ++step) {
    const double most_m2 = std::ranges::max_element(tones, {}, &Seen::energy_m2)->energy_m2();
    if (!tile.TakeOutStep(most_m2)) break;
    tones = TonesOf(tile, band, false_alarm);
  }
  return tones;
}

// samples free of transients with which a tile's tones are compared
struct Settled {
  SettledGlances glances;
  std::vector<SteadyTone> steady;  // subtracted from the reference windows and every tile
};

// whether a tone exceeds the noise, of any spectrum, in the quietest part of the record
bool IsAboveNoise(const SettledGlances& glances, const Seen& tone) {
  const double noise = glances.NoisePower(tone.frequency_hz);
  return tone.amplitude_m * tone.amplitude_m >
         kNoisePowers * noise * glances.duration_s() / tone.duration_s;
}

// whether a tone, known to 1 / duration, is the remainder of a steady one that drifts
bool IsLeftOf(const SteadyTone& gone, const Seen& tone) {
  const double away_hz = std::abs(tone.frequency_hz - gone.frequency_hz);
  return away_hz < SettledGlances::kWander * gone.frequency_hz + 1 / tone.duration_s &&
         gone.amplitude_m > SettledGlances::kElsewhere * tone.amplitude_m;
}

// whether a tone is in all samples free of transients, as far as noise permits that decision
bool GoesOn(const Settled& settled, const Seen& tone) {
  const auto left_of = [&](const SteadyTone& gone) { return IsLeftOf(gone, tone); };
  if (std::ranges::any_of(settled.steady, left_of)) return true;
  const double glance_s = settled.glances.duration_s();
  // the noise's amplitude falls with the root of the duration
  const double noise_m = tone.uncertainty_m * std::sqrt(2 * tone.duration_s / glance_s);
  const double least_m = tone.amplitude_m - kNoiseDeviations * (tone.uncertainty_m + noise_m);
  return settled.glances.LeastAmplitude(tone.frequency_hz) >
         std::min(SettledGlances::kElsewhere * tone.amplitude_m, least_m);
}

// how far a tone continues beyond its window, in a tile: where two periods of it hold half of it
BriefTone Grown(const RawTile& tile, const Seen& tone) {
  const auto size = std::min(tile.values_m().size(),
                             static_cast<std::size_t>(2 * tile.rate_hz() / tone.frequency_hz) + 1);
  // running sums give the amplitude of any block in two operations
  const ToneSums sums(tile.values_m(), tile.rate_hz(), tone.frequency_hz);
  const auto is_on = [&](std::size_t at) {
    return sums.SquaredAmplitudeOf(at, size) > 0.25 * tone.amplitude_m * tone.amplitude_m;
  };
  const std::size_t last = tile.values_m().size() - size;
  // outwards from the middle of the window until a block has less than half of the amplitude
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

// the highest energy over kLoudS in a tile of filtered samples
double LoudnessOf(const BandSignal& signal, std::size_t begin, std::size_t size) {
  const std::size_t cell = signal.cell_samples();
  const auto cells = static_cast<std::size_t>(
      std::max(1.0, kLoudS * signal.rate_hz() / static_cast<double>(cell)));
  double loudest = 0;
  double sum = 0;
  // a moving sum over `cells` cells
  for (std::size_t k = begin / cell; k < (begin + size) / cell; ++k) {
    sum += signal.cells()[k].square_sum;
    if (k >= begin / cell + cells) sum -= signal.cells()[k - cells].square_sum;
    loudest = std::max(loudest, sum);
  }
  return loudest;
}

// of many tiles those that reach into a part with transients, and the loudest others
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

// whether a tone has most of a tile's power beside noise: ringing about a bump has not
bool IsMostOf(const RawTile& tile, const BriefTone& tone) {
  std::vector<double> squares(tile.values_m().size());
  std::ranges::transform(tile.values_m(), squares.begin(), [](double x) { return x * x; });
  const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
  // noise from the median of squares: 0.455 of the variance
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::ranges::nth_element(squares, middle);
  const double noise = *middle / kMedianSquare * static_cast<double>(squares.size());
  // energy of the tone against kMostOf of all energy without noise
  return tone.rms_m * tone.rms_m * tone.window.duration_s() * tile.rate_hz() >
         kMostOf * (sum - noise);
}

// Whether its power is concentrated in its middle, as that of a bump less its polynomial: the
// middle third has more than the outer two together. A drive has half of that, measured: 0.42 to
// 0.89 in 99 of 100.
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

// where a tile lies
struct TilePlace {
  const BriefSearch* search = nullptr;
  std::size_t begin = 0;  // sample
  const TileShape* shape = nullptr;
};

// Whether a tone of a tile is in the filtered samples too, where there are any: what remains of
// strong motion below the band at a tile's ends is not. A filter's own edges may be.
// Measured: a drive has 0.95 and more of its amplitude there.
Result<bool> IsFilteredToo(const TilePlace& place, const Seen& tone) {
  if (place.search->signal == nullptr) return true;
  const BandSignal& signal = *place.search->signal;
  const std::size_t every = place.shape->samples_a_value();
  std::vector<double> samples((tone.end - tone.begin) * every);
  if (auto read = signal.Read(place.begin + tone.begin * every, samples); !read) {
    return std::unexpected(read.error());
  }
  const double square = SquaredAmplitude(samples, signal.rate_hz(), tone.frequency_hz);
  return square > SettledGlances::kElsewhere * SettledGlances::kElsewhere * tone.amplitude_m *
                      tone.amplitude_m;
}

// the tone of most energy in a tile that is on for a part of the record only; cheap tests first
Result<std::optional<BriefTone>> BriefIn(const TilePlace& place, const Settled& settled,
                                         const BandPass& band, double false_alarm) {
  auto tile = RawTile::Read(place.search->samples, place.begin, *place.shape);
  if (!tile) return std::unexpected(tile.error());
  // steady tones first, so that they cover no brief one
  for (const SteadyTone& tone : settled.steady) {
    tile->TakeOutTone(tone.frequency_hz, kMostOfSteady * tone.amplitude_m);
  }
  std::vector<Seen> tones = TonesBesideSteps(*tile, band, false_alarm);
  std::ranges::sort(tones, std::ranges::greater{}, &Seen::energy_m2);
  for (const Seen& tone : std::span(tones).first(std::min(kMostAsked, tones.size()))) {
    const BriefTone grown = Grown(*tile, tone);
    if (grown.window.duration_s() * tone.frequency_hz < kLeastPeriodsOn) continue;
    if (Swells(*tile, grown) || !IsMostOf(*tile, grown)) continue;
    if (!IsAboveNoise(settled.glances, tone) || GoesOn(settled, tone)) continue;
    const auto filtered = IsFilteredToo(place, tone);
    if (!filtered) return std::unexpected(filtered.error());
    if (*filtered) return grown;
  }
  return std::nullopt;
}

// a segment in tiles
struct Tiled {
  std::size_t tile = 0;             // samples
  std::vector<std::size_t> begins;  // those that are searched
};

// tiles to search in a segment; none where they have too few samples for the polynomial
Tiled TiledOf(const BriefSearch& search, const BandPass& band) {
  const double rate_hz = search.samples.rate_hz();
  const double tile_s =
      std::clamp(kTileS, kLeastTilePeriods / band.lower_hz, kMostTilePeriods / band.lower_hz);
  Tiled tiled{std::min(search.samples.size(), static_cast<std::size_t>(tile_s * rate_hz)), {}};
  if (!TileShape::IsPossible(tiled.tile, rate_hz, band)) return tiled;
  tiled.begins = TilesOf(search.samples.size(), tiled.tile);
  if (search.signal != nullptr) {
    tiled.begins = FewTiles(*search.signal, std::move(tiled.begins), tiled.tile);
  }
  return tiled;
}

// m2 s: mean square times duration
double EnergyOf(const BriefTone& tone) {
  return tone.rms_m * tone.rms_m * tone.window.duration_s();
}

// the tone of most energy, extended by the same tone in the tiles beside its own
std::optional<BriefTone> Joined(const std::vector<BriefTone>& in_order) {
  if (in_order.empty()) return std::nullopt;
  const auto most = std::ranges::max_element(in_order, {}, EnergyOf);
  BriefTone joined = *most;
  // the same frequency to 5 %, and windows that touch
  const auto joins = [&](const BriefTone& other) {
    if (std::abs(other.frequency_hz - most->frequency_hz) >
            SettledGlances::kWander * most->frequency_hz ||
        other.window.begin_s > joined.window.end_s || other.window.end_s < joined.window.begin_s) {
      return false;
    }
    joined.window.begin_s = std::min(joined.window.begin_s, other.window.begin_s);
    joined.window.end_s = std::max(joined.window.end_s, other.window.end_s);
    return true;
  };
  for (auto next = most + 1; next != in_order.end() && joins(*next);) ++next;
  for (auto before = most; before != in_order.begin() && joins(*(before - 1));) --before;
  return joined;
}

}  // namespace

Result<std::optional<BriefTone>> FindBriefTone(std::span<const BriefSearch> searches,
                                               const BandSignal& reference, const BandPass& band) {
  if (reference.settled_end() - reference.settled_begin() < SettledGlances::kLeastSettled) {
    return std::nullopt;
  }
  auto glances = SettledGlances::Read(reference, band);
  if (!glances) return std::unexpected(glances.error());
  auto steady = FindSteadyTones(reference, band);
  if (!steady) return std::unexpected(steady.error());
  Settled settled{std::move(*glances), std::move(*steady)};
  settled.glances.TakeOut(settled.steady);
  // the false alarm of the record is shared by all windows of all tiles
  std::vector<Tiled> tiled;
  double tiles = 0;
  for (const BriefSearch& search : searches) {
    tiled.push_back(TiledOf(search, band));
    tiles += static_cast<double>(tiled.back().begins.size());
  }
  const double false_alarm = kFalseAlarm / (std::exp2(kMostWindowHalvings + 2) * tiles);
  std::optional<BriefTone> most;
  for (std::size_t k = 0; k < tiled.size(); ++k) {
    if (tiled[k].begins.empty()) continue;
    const TileShape shape(tiled[k].tile, searches[k].samples.rate_hz(), band);
    std::vector<BriefTone> tones;
    for (const std::size_t begin : tiled[k].begins) {
      const auto tone = BriefIn({&searches[k], begin, &shape}, settled, band, false_alarm);
      if (!tone) return std::unexpected(tone.error());
      if (*tone) tones.push_back(**tone);
    }
    auto joined = Joined(tones);
    if (!joined || (most && EnergyOf(*joined) <= EnergyOf(*most))) continue;
    joined->search = k;
    most = joined;
  }
  return most;
}

}  // namespace haptometer::dsp
