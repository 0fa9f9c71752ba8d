#include "fit/drop_test/prepared_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/median.h"
#include "fit/drop_test/first_look.h"

namespace haptometer::fit {
namespace {

constexpr std::ptrdiff_t kLeastSamples = 32;

// undamped period in samples
double PeriodSamples(const ImpulseRecord& record, const RingStart& start) {
  return 2 * std::numbers::pi / (std::sqrt(start.poles.stiffness_per_s2) * record.step_s);
}

// the samples from `first` up to `end` as a record
ImpulseRecord Slice(const ImpulseRecord& record, std::size_t first, std::size_t end) {
  ImpulseRecord slice = record;
  const auto begin = record.voltage_v.begin();
  slice.voltage_v.assign(begin + static_cast<std::ptrdiff_t>(first),
                         begin + static_cast<std::ptrdiff_t>(end));
  slice.start_s = record.start_s + static_cast<double>(first) * record.step_s;
  return slice;
}

// start values on the part alone, which begins with an impact of its own
Result<RingStart> StartOfPart(const ImpulseRecord& record, const Disturbances& part) {
  auto start = FindRingStart(Slice(record, part.first_sample, part.end_sample));
  if (start) start->first_sample += part.first_sample;
  return start;
}

// What is known of the impact holds where the record shows it. Without anything quiet before it, it
// may lie periods before the record, and nothing shows its length, on which the speed depends.
void ForgetMissingBlow(PreparedRecord* prepared) {
  ImpulseRecord& record = prepared->record;
  const RingStart& start = prepared->start;
  const bool is_missing = start.quiet_samples == 0;
  if (record.drop_height_m && (is_missing || start.contact_may_be_longer)) {
    record.drop_height_m.reset();
    std::vector<FindingNumber> lengths{{"longest_s", start.longest_contact_s}};
    if (start.shortest_contact_s > 0) lengths.emplace_back("shortest_s", start.shortest_contact_s);
    prepared->part.found.Add(
        is_missing ? About(record.name, Severity::kNote, FindingKind::kHeightWithoutImpact)
                   : About(record.name, Severity::kDoubt, FindingKind::kHeightOfLongImpact,
                           std::move(lengths)));
  }
  if (record.release_current_a && record.is_cut_before && is_missing) {
    record.release_current_a.reset();
    prepared->part.found.Add(
        About(record.name, Severity::kNote, FindingKind::kCurrentWithoutRelease));
  }
}

Result<PreparedRecord> PrepareAsItIs(const ImpulseRecord& record) {
  auto start = FindRingStart(record);
  if (!start) return std::unexpected(start.error());
  PreparedRecord prepared{record, *start, {}, ConverterStep(record.voltage_v)};
  // clipped samples are excluded; the start is then found again without them
  const std::size_t clipped = MaskRails(prepared.record.voltage_v, PeriodSamples(record, *start));
  if (clipped > 0) {
    start = FindRingStart(prepared.record);
    if (!start) return std::unexpected(start.error());
    prepared.start = *start;
  }
  prepared.part = FindDisturbances(prepared.record, prepared.start);
  if (clipped > 0) {
    prepared.part.found.Add(
        About(record.name, Severity::kNote, FindingKind::kClipped, {{"samples", clipped}}));
  }
  if (!prepared.part.no_ring_down.empty()) {
    return CannotAnswer(record.name, prepared.part.no_ring_down,
                        "record one free ring-down, or choose the part of the record that is one");
  }
  // the part needs as many measured samples as a record
  const auto begin = prepared.record.voltage_v.begin();
  const auto measured =
      std::count_if(begin + static_cast<std::ptrdiff_t>(prepared.part.first_sample),
                    begin + static_cast<std::ptrdiff_t>(prepared.part.end_sample),
                    [](double v) { return std::isfinite(v); });
  if (measured < kLeastSamples) {
    return CannotAnswer(record.name,
                        fmt::format("holds only {} samples that a fit can use", measured),
                        "record three decay times of one free ring-down");
  }
  // with dry friction, the poles of the fit that includes it
  if (prepared.part.background.has_friction) prepared.start.poles = prepared.part.poles;
  if (!prepared.part.follows_a_later_blow) {
    ForgetMissingBlow(&prepared);
    return prepared;
  }

  // a part behind a later impact has start values of its own, and the noise before the first impact
  start = StartOfPart(prepared.record, prepared.part);
  if (!start) return std::unexpected(start.error());
  start->quiet_noise_v = prepared.start.quiet_noise_v;
  start->quiet_samples = prepared.start.quiet_samples;
  prepared.start = *start;
  // the difference without friction, from the part's new first sample on
  auto& more_v = prepared.part.linear_less_friction_v;
  const std::size_t skipped = start->first_sample - prepared.part.first_sample;
  more_v.erase(more_v.begin(),
               more_v.begin() + static_cast<std::ptrdiff_t>(std::min(skipped, more_v.size())));
  prepared.part.first_sample = start->first_sample;
  // the height belongs to the first impact
  if (prepared.record.drop_height_m) {
    prepared.record.drop_height_m.reset();
    prepared.part.found.Add(About(record.name, Severity::kNote, FindingKind::kHeightOfFirstImpact));
  }
  return prepared;
}

// The sample where a fast oscillation begins behind something slow, as a release behind a pull, and
// its period; nothing where none does. The record's differences determine which oscillation that
// is: slow motion is small in them.
struct Onset {
  std::size_t sample = 0;
  double period_samples = 0;
};

std::optional<Onset> OnsetBehindSlow(const ImpulseRecord& record) {
  constexpr double kCalm = 0.35;  // of the largest amplitude, before the onset
  constexpr double kSlow = 0.2;   // of the range behind the onset, at least before it
  const std::vector<double> values = Filled(record.voltage_v);
  std::vector<double> differences(values.size());
  for (std::size_t n = 1; n < values.size(); ++n) differences[n] = values[n] - values[n - 1];
  const auto frequency_hz = StrongestFrequency(differences, record.step_s);
  if (!frequency_hz) return std::nullopt;
  const double period = 1 / (*frequency_hz * record.step_s);
  // at least 4 samples per period and 6 periods
  if (period < 4 || 6 * period > static_cast<double>(values.size())) return std::nullopt;
  const auto amplitudes = FollowingAmplitude(differences, 0, period);
  const auto largest = std::ranges::max_element(amplitudes) - amplitudes.begin();
  // back from the largest amplitude to where it is half of that
  const auto whole = static_cast<std::ptrdiff_t>(std::ceil(period));
  std::ptrdiff_t risen = largest;
  while (risen > 0 && amplitudes[static_cast<std::size_t>(risen - 1)] >
                          0.5 * amplitudes[static_cast<std::size_t>(largest)]) {
    --risen;
  }
  // two periods before the onset, to compare with
  if (risen < 2 * whole) return std::nullopt;
  const auto before = std::max_element(amplitudes.begin(), amplitudes.begin() + risen - whole);
  if (*before > kCalm * amplitudes[static_cast<std::size_t>(largest)]) return std::nullopt;
  // behind silence it is an impact, which needs no such search
  const auto range = [&](std::ptrdiff_t first, std::ptrdiff_t end) {
    const auto [low, high] = std::minmax_element(values.begin() + first, values.begin() + end);
    return *high - *low;
  };
  const auto size = static_cast<std::ptrdiff_t>(values.size());
  // what precedes must move: at least kSlow of the range behind
  if (range(0, risen - whole) < kSlow * range(risen, size)) return std::nullopt;
  return Onset{static_cast<std::size_t>(risen), period};
}

}  // namespace

Result<PreparedRecord> PrepareRecord(const ImpulseRecord& record) {
  auto prepared = PrepareAsItIs(record);
  if (prepared || record.drop_height_m || record.release_current_a) return prepared;
  // what precedes a release may be no rest: the part behind it alone, from ever later on
  const auto onset = OnsetBehindSlow(record);
  if (!onset) return prepared;
  // the first part behind the onset that is one ring-down
  for (const double periods : {0.5, 1.0, 1.5, 2.0, 3.0}) {
    const auto first = onset->sample + static_cast<std::size_t>(periods * onset->period_samples);
    if (first + kLeastSamples > record.voltage_v.size()) break;
    auto later = PrepareAsItIs(Slice(record, first, record.voltage_v.size()));
    if (!later) continue;
    const double at_s =
        record.start_s +
        (static_cast<double>(onset->sample) + onset->period_samples / 2) * record.step_s;
    later->part.found.Add(About(record.name, Severity::kNote, FindingKind::kReleaseBehindSlow,
                                {{"at_s", at_s}, {"from_s", later->record.start_s}}));
    return later;
  }
  return prepared;
}

namespace {

constexpr double kRisen = 0.3;  // of the largest amplitude
constexpr double kFallen = 0.1;
constexpr double kLeastPeriods = 6;
constexpr std::size_t kLeastSplitSamples = 64;

// the period of the strongest oscillation, in samples
std::optional<double> PeriodOf(const std::vector<double>& values, double middle_v, double step_s) {
  std::vector<double> about_middle = values;
  for (double& value : about_middle) value -= middle_v;
  const auto frequency_hz = StrongestFrequency(about_middle, step_s);
  if (!frequency_hz) return std::nullopt;
  return 1 / (*frequency_hz * step_s);
}

// Where each drop's piece begins: half way from where the ringing had gone to the rise. `noise` is
// the deviation of each of an amplitude's two components.
std::vector<std::size_t> Begins(const std::vector<double>& amplitudes, std::size_t period,
                                double noise) {
  const double largest = *std::ranges::max_element(amplitudes);
  const double fallen_below = kFallen * largest;
  // noise alone lifts what had fallen by 5 deviations once in 3e5 periods: e^(-5^2/2)
  const double risen_above = std::max(kRisen * largest, fallen_below + 5 * noise);
  std::vector<std::size_t> begins{0};
  bool rings = false;
  std::size_t fallen = 0;  // samples that the amplitude has been small for
  for (std::size_t n = 0; n < amplitudes.size(); ++n) {
    // with hysteresis: it rings above the one amplitude, and has ended below the other
    fallen = amplitudes[n] < fallen_below ? fallen + 1 : 0;
    if (rings && fallen > period) {
      rings = false;
      begins.push_back(n);
    } else if (!rings && amplitudes[n] > risen_above) {
      // half way between the end of the previous ringing and this rise
      if (begins.size() > 1) begins.back() = (begins.back() + n) / 2;
      rings = true;
    }
  }
  // the last ringing is followed by none
  if (!rings && begins.size() > 1) begins.pop_back();
  return begins;
}

ImpulseRecord Piece(const ImpulseRecord& record, std::size_t begin, std::size_t end,
                    std::size_t number) {
  ImpulseRecord piece = Slice(record, begin, end);
  piece.name = fmt::format("{}, drop {}", record.name, number);
  if (number > 1) piece.drop_height_m.reset();
  return piece;
}

}  // namespace

std::vector<ImpulseRecord> SplitDrops(const ImpulseRecord& record) {
  const auto measured =
      std::ranges::count_if(record.voltage_v, [](double v) { return std::isfinite(v); });
  if (static_cast<std::size_t>(measured) < kLeastSplitSamples) return {record};
  const auto rest_v = WithoutWhatLasts(record.voltage_v, record.step_s);
  const std::vector<double> values = Filled(rest_v ? *rest_v : record.voltage_v);
  const double middle_v = Median(values);
  const auto period = PeriodOf(values, middle_v, record.step_s);
  if (!period || kLeastPeriods * *period > static_cast<double>(values.size())) return {record};
  const auto amplitudes = FollowingAmplitude(values, middle_v, *period);
  // a component is a sum over a period of noise times a cosine, whose square is a half on average
  const double noise = NoiseOfSamples(values) * std::sqrt(*period / 2);
  std::vector<std::size_t> begins = Begins(amplitudes, static_cast<std::size_t>(*period), noise);
  if (begins.size() < 2) return {record};
  begins.push_back(values.size());
  std::vector<ImpulseRecord> pieces;
  // a piece that is too short: the record is not divided
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    if (static_cast<double>(begins[k + 1] - begins[k]) < kLeastPeriods * *period) return {record};
    pieces.push_back(Piece(record, begins[k], begins[k + 1], k + 1));
  }
  return pieces;
}

namespace {

constexpr std::size_t kMostSamples = 100'000;
constexpr double kBlocksPerPeriod = 1000;

}  // namespace

std::optional<ThinnedRecord> Thinned(const ImpulseRecord& record, const PolePair& poles) {
  const double period = 2 * std::numbers::pi / (std::sqrt(poles.stiffness_per_s2) * record.step_s);
  const auto block = static_cast<std::size_t>(period / kBlocksPerPeriod);
  if (record.voltage_v.size() <= kMostSamples || block < 2) return std::nullopt;
  // rails first: a mean masks clipped samples
  auto values = record.voltage_v;
  ThinnedRecord thinned{record, block, MaskRails(values, period)};
  // a block's mean stands at the block's middle
  thinned.record.start_s += 0.5 * static_cast<double>(block - 1) * record.step_s;
  thinned.record.step_s *= static_cast<double>(block);
  thinned.record.voltage_v.clear();
  thinned.record.voltage_v.reserve(values.size() / block);
  for (std::size_t first = 0; first + block <= values.size(); first += block) {
    double sum = 0;
    for (std::size_t n = first; n < first + block; ++n) sum += values[n];
    thinned.record.voltage_v.push_back(sum / static_cast<double>(block));
  }
  return thinned;
}

namespace {

// a drop for the fit; what is sampled more finely than that has use for is averaged
Result<PreparedRecord> PrepareThinned(ImpulseRecord& drop, Findings& findings) {
  HAPTOMETER_LET(auto prepared, PrepareRecord(drop));
  auto thinned = Thinned(drop, prepared.start.poles);
  if (!thinned) return prepared;
  std::vector<FindingNumber> numbers{{"samples", drop.voltage_v.size()}, {"block", thinned->block}};
  if (thinned->clipped > 0) numbers.emplace_back("clipped", thinned->clipped);
  findings.Add(About(drop.name, Severity::kNote, FindingKind::kThinned, std::move(numbers)));
  const double noise_v = NoiseOfSamples(Filled(drop.voltage_v));
  const double step_v = prepared.step_v;
  drop = std::move(thinned->record);
  HAPTOMETER_LET(auto of_means, PrepareRecord(drop));
  // a converter's codes do not show in means
  of_means.step_v = step_v;
  of_means.averaged_noise_v = noise_v;
  return of_means;
}

}  // namespace

PreparedDrops PrepareDrops(const ImpulseRecord& recording) {
  PreparedDrops all;
  std::vector<ImpulseRecord> drops = SplitDrops(recording);
  all.drops = drops.size();
  const auto note = [&](FindingKind kind, std::vector<FindingNumber> numbers = {}) {
    all.findings.Add(About(recording.name, Severity::kNote, kind, std::move(numbers)));
  };
  if (drops.size() > 1) note(FindingKind::kSeveralDrops, {{"drops", drops.size()}});
  if (drops.size() > 1 && recording.drop_height_m) note(FindingKind::kHeightOfFirstDrop);
  for (ImpulseRecord& drop : drops) {
    auto prepared = PrepareThinned(drop, all.findings);
    if (!prepared) {
      all.left_out.push_back({std::move(drop), prepared.error()});
      continue;
    }
    all.records.push_back(std::move(drop));
    all.prepared.push_back(*std::move(prepared));
  }
  // if fewer than half of the drops can be fitted, none is
  if (2 * all.left_out.size() <= all.drops || all.records.empty()) return all;
  note(FindingKind::kTooFewDrops, {{"good", all.records.size()}, {"drops", all.drops}});
  all.records.clear();
  all.prepared.clear();
  return all;
}

}  // namespace haptometer::fit
