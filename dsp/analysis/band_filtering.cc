#include "dsp/analysis/band_filtering.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/band.h"
#include "base/error.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/spectrum/decimated.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// a model is possible where the segment fits into memory
constexpr std::size_t kMostModelled = std::size_t{1} << 22U;
constexpr std::size_t kMostSearched = std::size_t{1} << 21U;
// rate over the band's lower corner, and fewest samples, that decimation leaves of these
constexpr double kSearchedRatePerLower = 16;
constexpr std::size_t kLeastSearched = std::size_t{1} << 16U;

Result<std::vector<double>> ReadAll(const SegmentSamples& samples) {
  std::vector<double> values(samples.size());
  HAPTOMETER_TRY(samples.Read(0, values));
  return values;
}

// the segment filtered as it is, or with a model of the motion below the band if more of it is then
// free of transients
Result<BandSignal> FilterOne(const SegmentSamples& samples, const FilterDesign& design,
                             const BandPass& band, int threads) {
  const KeptFrames frames = FramesToKeep(samples.size(), samples.rate_hz(), band);
  HAPTOMETER_LET(auto plain, BandSignal::Filter(samples, design, threads, frames));
  const double duration_s = static_cast<double>(samples.size()) / samples.rate_hz();
  if (SettledSeconds(plain) >= kMajority * duration_s || duration_s > kLongestModelledS ||
      samples.size() > kMostModelled) {
    return plain;
  }
  HAPTOMETER_LET(const auto values, ReadAll(samples));
  auto model = BelowBandModel::Fit(values, samples.rate_hz(), band.lower_hz, band.upper_hz);
  if (!model) return plain;
  HAPTOMETER_LET(auto beside,
                 BandSignal::Filter(samples, design, threads, frames, std::move(model)));
  return SettledSeconds(beside) > SettledSeconds(plain) ? std::move(beside) : std::move(plain);
}

// whether a window fits into it: a record of thousands of short segments is refused at once
bool LongEnough(const Segment& segment, double lower_hz) {
  return static_cast<double>(segment.size) / segment.rate_hz >= kLeastWindowPeriods / lower_hz;
}

// every segment with a sufficient rate and length, filtered on its own
Result<std::vector<BandSignal>> FilterAll(const Displacement& displacement,
                                          const Segments& segments, const BandPass& band) {
  std::vector<BandSignal> all;
  all.reserve(segments.parts.size());
  for (const Segment& segment : segments.parts) {
    if (!Observes(segment.rate_hz, band.upper_hz)) continue;
    if (!LongEnough(segment, band.lower_hz)) continue;
    Result<FilterDesign> design = DesignBandPass(band, segment.rate_hz);
    HAPTOMETER_CHECK(design, "{}", design.error().Text());
    HAPTOMETER_LET(auto signal, FilterOne({displacement.source, displacement.channel, segment},
                                          *design, band, displacement.threads));
    all.push_back(std::move(signal));
  }
  return all;
}

// decimated samples of `size` samples from `first` on, read piece by piece
Result<std::vector<double>> Decimated(const SegmentSamples& samples, std::size_t first,
                                      std::size_t size, const Decimator& decimator) {
  constexpr std::size_t kPiece = std::size_t{1} << 15U;
  const std::size_t at_once = std::max(std::size_t{1}, kPiece / decimator.factor());
  std::vector<double> slow;
  slow.reserve(decimator.SizeOf(size));
  std::vector<double> piece;
  while (slow.size() < decimator.SizeOf(size)) {
    const std::size_t count = std::min(at_once, decimator.SizeOf(size) - slow.size());
    // a piece overlaps the next by the taps of the decimator
    piece.resize((count - 1) * decimator.factor() + decimator.taps());
    HAPTOMETER_TRY(samples.Read(first + slow.size() * decimator.factor(), piece));
    const std::vector<double> more = decimator.Decimate(piece);
    slow.insert(slow.end(), more.begin(), more.end());
  }
  return slow;
}

// whether the leakage from below the band, a part 2 e of the power, changes the RMS by at most e
Result<bool> LeaksLittle(const BandSignal& signal, double lower_hz) {
  HAPTOMETER_LET(const auto below, FindBelowBand(signal, lower_hz));
  if (!below) return true;
  HAPTOMETER_LET(const auto square_sum,
                 signal.SquareSum(signal.settled_begin(), signal.settled_end()));
  const double leaked_rms_m = below->leaked_rms_m;
  const auto count = static_cast<double>(signal.settled_end() - signal.settled_begin());
  return leaked_rms_m * leaked_rms_m <= 2 * kSameWithin * square_sum / count;
}

// the refusal after filtering, with the duration that would suffice
Finding TooShort(const BandPass& band, double rate_hz, double settled_s, bool leaks) {
  const auto design = DesignBandPass(band, rate_hz);
  HAPTOMETER_CHECK(design, "{}", design.error().Text());
  // the transients at both ends of the filter as designed, decayed to 1e-12
  const double ringing_s = static_cast<double>(RingingSamples(*design, 1e-12)) / rate_hz;
  const double least_s = kLeastWindowPeriods / band.lower_hz;
  Finding found{.severity = Severity::kRefusal,
                .kind = FindingKind::kTooShort,
                .numbers = {{"settled_s", settled_s},
                            {"order", band.order},
                            {"needed_s", least_s},
                            {"record_s", 2 * ringing_s + least_s}}};
  if (leaks) found.numbers.emplace_back("lower_hz", band.lower_hz);
  return found;
}

}  // namespace

double SettledSeconds(const BandSignal& signal) {
  return static_cast<double>(signal.settled_end() - signal.settled_begin()) / signal.rate_hz();
}

const BandSignal& LongestSettled(const std::vector<BandSignal>& all) {
  return *std::ranges::max_element(all, {}, SettledSeconds);
}

Result<std::optional<BelowBand>> FindBelowBand(const BandSignal& signal, double lower_hz) {
  // the middle of a long segment represents it
  const std::size_t size = std::min(signal.size(), kMostSearched);
  // two periods are required by the search for a tone
  const double bin_hz = signal.rate_hz() / static_cast<double>(size);
  if (2 * bin_hz >= lower_hz) return std::nullopt;
  // a band far below the rate: decimated samples suffice
  const Decimator decimator(Decimator::FactorFor(size, signal.rate_hz(),
                                                 kSearchedRatePerLower * lower_hz, kLeastSearched),
                            signal.rate_hz());
  HAPTOMETER_LET(const auto slow,
                 Decimated(signal.samples(), (signal.size() - size) / 2, size, decimator));
  const double slowest_hz = 2 * decimator.rate_hz() / static_cast<double>(slow.size());
  const auto tone = StrongestTone(slow, {decimator.rate_hz(), slowest_hz, lower_hz, 0});
  // within half a bin of the corner it is in the band as well
  if (!tone || tone->frequency_hz > lower_hz - 0.5 * bin_hz) return std::nullopt;
  // the decimator's gain divided out, then |H|^2 of both passes for the leakage
  const double gain = std::norm(Response(signal.design(), tone->frequency_hz));
  const double amplitude_m = tone->amplitude / decimator.GainAt(tone->frequency_hz);
  return BelowBand{tone->frequency_hz, amplitude_m, amplitude_m * gain / std::numbers::sqrt2,
                   signal.model().has_value()};
}

Result<std::optional<SineFit>> FindAboveBand(const BandSignal& signal, double upper_hz,
                                             double most_hz) {
  if (upper_hz >= most_hz) return std::nullopt;
  std::vector<double> values(std::min(signal.size(), kMostSearched));
  HAPTOMETER_TRY(signal.samples().Read((signal.size() - values.size()) / 2, values));
  return StrongestTone(values, {signal.rate_hz(), upper_hz, most_hz, 0});
}

Result<std::vector<BandSignal>> FilterSettledEnough(const Displacement& displacement,
                                                    const Segments& segments,
                                                    const BandQuestion& question,
                                                    BandAnalysis* analysis) {
  const int asked = question.band.order;
  const int lowest = question.may_lower_order ? std::min(kLowestFallbackOrder, asked) : asked;
  double asked_settled_s = 0;
  bool leaks = false;
  // a lower order has shorter transients but leaks more; only the required order may leak freely
  for (int order = asked; order >= lowest && !leaks; --order) {
    analysis->band.order = order;
    auto all = FilterAll(displacement, segments, analysis->band);
    if (!all || all->empty()) {
      if (!all) return all;
      break;
    }
    const BandSignal& longest = LongestSettled(*all);
    if (order == asked) asked_settled_s = SettledSeconds(longest);
    if (SettledSeconds(longest) < kLeastWindowPeriods / question.band.lower_hz) continue;
    if (order == asked) return all;
    HAPTOMETER_LET(const auto leaks_little, LeaksLittle(longest, question.band.lower_hz));
    leaks = !leaks_little;
    if (leaks) continue;
    analysis->findings.Note(
        FindingKind::kOrderLowered,
        {{"asked_order", asked}, {"order", order}, {"settled_s", asked_settled_s}});
    return all;
  }
  analysis->band = question.band;
  analysis->findings.Add(TooShort(question.band, analysis->record.rate_hz, asked_settled_s, leaks));
  return std::vector<BandSignal>{};
}

}  // namespace haptometer::dsp
