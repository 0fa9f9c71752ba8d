#include "dsp/analysis/record_facts.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/band.h"
#include "base/median.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/statistics/distributions.h"
#include "trial/record.h"

namespace haptometer::dsp {

using trial::SampleStatus;

namespace {

// the channels with their units, such as "'Laser (mm/s)' (unit not known), 'voltage' (V)"
std::string NamesOf(const std::vector<trial::Channel>& channels) {
  std::string names;
  for (const trial::Channel& channel : channels) {
    names += fmt::format("{}'{}' ({})", names.empty() ? "" : ", ", channel.name,
                         channel.unit.empty() ? "unit not known" : channel.unit);
  }
  return names;
}

}  // namespace

Result<std::size_t> AnalyzedChannel(const trial::Record& head) {
  const trial::Channel* first = head.Find(trial::ChannelRole::kDisplacement);
  if (first == nullptr && head.channels.empty()) {
    return CannotAnswer("", "holds no displacement channel", "name one displacement_m");
  }
  if (first == nullptr) {
    return CannotAnswer(
        "", fmt::format("holds no displacement channel, but {}", NamesOf(head.channels)),
        "name a displacement by the unit of its numbers, as displacement_m, displacement_mm or "
        "displacement_um, after a conversion from any other unit; a calibration gives the "
        "displacement of a sensor's voltage");
  }
  if (const auto channel = trial::DisplacementChannel(head)) return *channel;
  return CannotAnswer("", fmt::format("its displacement has the unit '{}'", first->unit),
                      "convert it to metres");
}

void NoteOtherDisplacements(const trial::Record& head, std::size_t channel, Findings* findings) {
  std::string others;
  for (std::size_t c = 0; c < head.channels.size(); ++c) {
    const trial::Channel& other = head.channels[c];
    if (c == channel || other.role != trial::ChannelRole::kDisplacement) continue;
    others += (others.empty() ? "" : ", ") + other.name;
  }
  if (others.empty()) return;
  findings->Note(FindingKind::kOtherDisplacements,
                 {{"channel", head.channels[channel].name}, {"others", others}});
}

// numbers of rows by status as text, such as "late 3, over 1"
std::string Unmeasured(const RecordFacts& facts) {
  std::string text;
  std::size_t named = 0;
  for (std::size_t s = 0; s < facts.by_status.size(); ++s) {
    const auto status = static_cast<SampleStatus>(s);
    if (trial::IsMeasurement(status) || facts.by_status[s] == 0) continue;
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", trial::Name(status), facts.by_status[s]);
    named += facts.by_status[s];
  }
  // rows with a valid status but without a finite value
  const std::size_t rest = facts.rows - facts.measured - named;
  if (rest > 0) text += fmt::format("{}without a value {}", text.empty() ? "" : ", ", rest);
  return text;
}

void DescribeRecord(const trial::Record& head, const Segments& segments, const RawSummary& summary,
                    BandAnalysis* analysis) {
  RecordFacts& facts = analysis->record;
  facts.rows = head.rows;
  facts.measured = segments.measured;
  facts.bridged = segments.bridged;
  facts.segments = segments.parts.size();
  facts.by_status = segments.by_status;
  if (summary.measured == 0) return;
  facts.offset_m = summary.mean;
  facts.peak_to_peak_m = summary.most - summary.least;

  // the rate that lasts longest stands for the record
  const auto longest = std::ranges::max_element(head.stretches, {}, &trial::Stretch::rows);
  facts.rate_hz = longest->rate_hz;
  for (const trial::Stretch& stretch : head.stretches) {
    facts.duration_s += static_cast<double>(stretch.rows) / stretch.rate_hz;
  }
  // repeated readings contain no new information: they reduce the rate
  const auto repeated = segments.by_status[static_cast<std::size_t>(SampleStatus::kRepeated)];
  facts.fresh_rate_hz =
      facts.rate_hz * (1 - static_cast<double>(repeated) / static_cast<double>(segments.measured));
  facts.observable_upper_hz = HighestObservableHz(facts.fresh_rate_hz);

  if (facts.measured < facts.rows) {
    analysis->findings.Note(FindingKind::kExcluded, {{"excluded", facts.rows - facts.measured},
                                                     {"readings", facts.rows},
                                                     {"statuses", Unmeasured(facts)}});
  }
  if (repeated > 0) {
    analysis->findings.Note(FindingKind::kRepeated,
                            {{"repeated", repeated}, {"readings", facts.measured}});
  }
}

void CheckNewReadings(const BandPass& band, BandAnalysis* analysis) {
  const RecordFacts& facts = analysis->record;
  if (!Observes(facts.fresh_rate_hz, band.upper_hz)) {
    analysis->findings.Refuse(FindingKind::kTooFewReadings,
                              {{"new_readings_per_s", facts.fresh_rate_hz},
                               {"observable_hz", facts.observable_upper_hz},
                               {"lower_hz", band.lower_hz},
                               {"upper_hz", band.upper_hz},
                               {"needed_per_s", NeededRateHz(band.upper_hz)}});
  }
}

void CheckObservable(const trial::Record& head, const Segments& segments, const BandPass& band,
                     BandAnalysis* analysis) {
  CheckNewReadings(band, analysis);
  // a reading that was asked for is of unknown age; a free-running source has a clock of its own,
  // however its arrivals scatter
  if (head.timing != trial::Timing::kPolled) return;
  const double limit_s = kTimeUncertaintyPeriods / band.upper_hz;
  for (const Segment& segment : segments.parts) {
    if (segment.time_uncertainty_s < limit_s) continue;
    analysis->findings.Refuse(FindingKind::kTimesUncertain,
                              {{"time_uncertainty_s", segment.time_uncertainty_s},
                               {"upper_hz", band.upper_hz},
                               {"limit_s", limit_s}});
    break;
  }
}

void RemarkArtifacts(const CleanChannel& clean, BandAnalysis* analysis) {
  using enum FindingKind;
  for (const NoReadingCode& code : clean.codes) {
    analysis->findings.Note(kNoReadingCodes, {{"value_m", code.value}, {"readings", code.rows}});
  }
  constexpr std::array<std::pair<FaultKind, FindingKind>, kFaultKindCount> kKinds{
      {{FaultKind::kClipped, kClipped},
       {FaultKind::kHeld, kHeld},
       {FaultKind::kSpike, kSpikes},
       {FaultKind::kStep, kSteps}}};
  const Faults& faults = analysis->faults;
  for (const auto& [fault, kind] : kKinds) {
    if (faults.Count(fault) == 0) continue;
    const auto first = std::ranges::find(faults.list, fault, &Fault::kind);
    // what is excluded and interpolated is in the budget
    const bool is_corrected = fault == FaultKind::kSpike;
    Finding found{.severity = is_corrected ? Severity::kNote : Severity::kDoubt,
                  .kind = kind,
                  .numbers = {{"count", faults.Count(fault)},
                              {"readings", faults.Rows(fault)},
                              {"first_s", trial::TimeOf(clean.rows->head(), first->first_row)}}};
    if (kind != kClipped) found.numbers.emplace_back("size_m", std::abs(first->size));
    analysis->findings.Add(std::move(found));
  }
}

Result<std::optional<Finding>> WhyStuck(const Displacement& displacement, const ChosenPart& part,
                                        const BandAnalysis& analysis) {
  const double lower_hz = analysis.band.lower_hz;
  // vibration in the band changes its value at least twice in a period of the lower corner
  const auto least_changes = [&](double seconds) { return 2 * lower_hz * seconds; };
  if (static_cast<double>(analysis.faults.runs) >= least_changes(analysis.record.duration_s)) {
    return std::nullopt;
  }
  const std::size_t first = part.signal->first_row() + part.begin;
  const std::size_t rows = part.end - part.begin;
  // only a record with few changes is read again, over the chosen part
  std::size_t changes = 0;
  double last = std::numeric_limits<double>::quiet_NaN();
  const auto see = [&](std::size_t, double value, SampleStatus status) {
    if (!IsMeasured(value, status)) return;
    if (std::isfinite(last) && value != last) ++changes;
    last = value;
  };
  HAPTOMETER_TRY(ForEachValue(displacement.source, displacement.channel, first, rows, see));
  const double seconds = static_cast<double>(rows) / part.signal->rate_hz();
  if (static_cast<double>(changes) >= least_changes(seconds)) return std::nullopt;
  return Finding{.severity = Severity::kRefusal,
                 .kind = FindingKind::kStuckInWindow,
                 .numbers = {{"window_s", seconds},
                             {"from_s", TimeOfSample(*part.signal, part.begin)},
                             {"changes", changes},
                             {"readings", rows},
                             {"lower_hz", lower_hz}}};
}

namespace {

constexpr double kScalloped = 1.03;  // 1 / sinc(1/8): a tone an eighth of a bin off
constexpr std::size_t kLeastBlock = 16;
constexpr std::size_t kMostBlocks = 64;

// why the times are not sufficient; nothing where they are
std::optional<Finding> TimesWillNotDo(const trial::Record& head, double frequency_hz) {
  if (head.times_are_known) return std::nullopt;
  if (head.timing == trial::Timing::kPolled) {
    return Finding{.kind = FindingKind::kPolledTimes};
  }
  double worst_s = 0;
  for (const trial::Stretch& stretch : head.stretches) {
    worst_s = std::max(worst_s, stretch.time_uncertainty_s);
  }
  if (worst_s < kTimeUncertaintyPeriods / frequency_hz) return std::nullopt;
  return Finding{.kind = FindingKind::kTimesUnfitForTone,
                 .numbers = {{"time_uncertainty_s", worst_s},
                             {"frequency_hz", frequency_hz},
                             {"limit_s", kTimeUncertaintyPeriods / frequency_hz}}};
}

// whether the readings contain the tone at more than one phase: at a multiple of the rate only
// rounding separates it from the offset, and u(amplitude) far exceeds s sqrt(2 / N)
bool ToldApart(const SineFit& fit, std::size_t readings) {
  const double usual = fit.residual_rms * std::sqrt(2 / static_cast<double>(readings));
  return fit.converged && fit.amplitude_uncertainty <= kWorstUncertainty * usual;
}

// blocks [begin, end) of the longest run that is on, without the blocks in which it is switched
std::pair<std::size_t, std::size_t> LongestOn(const std::vector<double>& amplitudes, double top) {
  std::pair<std::size_t, std::size_t> best{0, 0};
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= amplitudes.size(); ++k) {
    if (k < amplitudes.size() && amplitudes[k] >= kMajority * top) continue;
    const std::size_t first = begin > 0 ? begin + 1 : 0;
    const std::size_t last = k < amplitudes.size() && k > 0 ? k - 1 : k;
    if (last > first && last - first > best.second - best.first) best = {first, last};
    begin = k + 1;
  }
  return best;
}

// Readings [first, last) in which the tone is on: all, unless it pauses for a block or more.
std::pair<std::size_t, std::size_t> DrivenReadings(std::span<const double> values,
                                                   std::span<const double> times_s,
                                                   double frequency_hz) {
  const std::size_t size = std::max(kLeastBlock, values.size() / kMostBlocks);
  std::vector<double> amplitudes(values.size() / size);
  double top = 0;
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    // the amplitude in each block, with a slope beside it
    const SineFit fit = FitSineAtTimes(values.subspan(k * size, size),
                                       times_s.subspan(k * size, size), frequency_hz, 1);
    if (!ToldApart(fit, size)) return {0, values.size()};
    amplitudes[k] = fit.amplitude;
    if (fit.amplitude > kClearUncertainties * fit.amplitude_uncertainty)
      top = std::max(top, fit.amplitude);
  }
  const auto pauses = [&](double amplitude) { return amplitude < kMajority * top; };
  if (std::ranges::none_of(amplitudes, pauses)) return {0, values.size()};
  const auto [begin, end] = LongestOn(amplitudes, top);
  if (end <= begin) return {0, values.size()};
  return {begin * size, end == amplitudes.size() ? values.size() : end * size};
}

// Readings [first, last), the most of `times_s` without a pause of ten intervals between them.
std::pair<std::size_t, std::size_t> WithoutPause(std::span<const double> times_s) {
  constexpr double kPauseIntervals = 10;
  std::vector<double> intervals_s;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    intervals_s.push_back(times_s[k] - times_s[k - 1]);
  }
  const double longest_s = kPauseIntervals * UpperMedian(intervals_s);
  std::pair<std::size_t, std::size_t> best{0, 0};
  std::size_t first = 0;
  for (std::size_t k = 1; k <= times_s.size(); ++k) {
    if (k < times_s.size() && intervals_s[k - 1] <= longest_s) continue;
    if (k - first > best.second - best.first) best = {first, k};
    first = k;
  }
  return best;
}

// The best fit within ten bins of a known frequency, every quarter of a bin, if it leaves less than
// half of what the fit at that frequency leaves; of at most 2^14 readings without a pause, whose
// bins a pause would narrow.
std::optional<SineFit> BetterNearby(std::span<const double> values, std::span<const double> times_s,
                                    const SineFit& at) {
  constexpr std::size_t kMost = std::size_t{1} << 14U;
  constexpr int kSteps = 40;
  // noise alone halves what is left at one of 80 frequencies with 80 0.5^((40 - 5)/2) = 4e-4
  constexpr std::size_t kLeastBeside = 40;
  const auto [first, last] = WithoutPause(times_s);
  const std::size_t count = std::min(last - first, kMost);
  if (count < kLeastBeside) return std::nullopt;
  const auto looked = values.subspan(first, count);
  const auto looked_s = times_s.subspan(first, count);
  const double bin_hz = 1 / (looked_s.back() - looked_s.front());
  const auto fitted = [&](double frequency_hz) {
    return FitSineAtTimes(looked, looked_s, frequency_hz, 1);
  };
  SineFit best = fitted(at.frequency_hz);
  const double limit = kMajority * best.residual_rms * best.residual_rms;
  for (int step = -kSteps; step <= kSteps; ++step) {
    const SineFit fit = fitted(at.frequency_hz + 0.25 * step * bin_hz);
    if (fit.converged && fit.residual_rms < best.residual_rms) best = fit;
  }
  if (!(best.residual_rms * best.residual_rms < limit)) return std::nullopt;
  return best;
}

}  // namespace

Result<void> FitKnownTone(const Displacement& displacement, const BandQuestion& question,
                          BandAnalysis* analysis) {
  const trial::Record& head = displacement.source.head();
  const std::optional<double> frequency_hz = question.drive_frequency_hz;
  if (!frequency_hz || !(*frequency_hz > 0)) return {};
  if (const auto why = TimesWillNotDo(head, *frequency_hz)) {
    analysis->findings.Add(*why);
    return {};
  }
  const std::size_t rows = std::min(head.rows, kMostFitted);
  std::vector<double> values(rows);
  std::vector<trial::SampleStatus> statuses(rows);
  HAPTOMETER_TRY(displacement.source.Read(displacement.channel, 0, values, statuses));
  // a repeated reading is no new one
  std::vector<double> times_s;
  times_s.reserve(rows);
  std::size_t kept = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    if (statuses[row] != trial::SampleStatus::kOk || !std::isfinite(values[row])) continue;
    times_s.push_back(head.times_are_known ? head.raw_times_s[row] : trial::TimeOf(head, row));
    values[kept++] = values[row];
  }
  values.resize(kept);
  // amplitude of the driven readings only: a pause would reduce it
  const auto [first, last] = DrivenReadings(values, times_s, *frequency_hz);
  if (last - first < kept) {
    analysis->findings.Note(
        FindingKind::kKnownTonePauses,
        {{"frequency_hz", *frequency_hz}, {"from_s", times_s[first]}, {"to_s", times_s[last - 1]}});
    kept = last - first;
  }
  KnownTone tone;
  const auto driven = std::span<const double>(values).subspan(first, kept);
  const auto driven_s = std::span<const double>(times_s).subspan(first, kept);
  tone.fit = FitSineAtTimes(driven, driven_s, *frequency_hz, 1);
  // above half the rate of new readings the tone is an alias
  tone.aliased = *frequency_hz > analysis->record.fresh_rate_hz / 2;
  if (!ToldApart(tone.fit, kept)) {
    analysis->findings.Note(FindingKind::kKnownToneAtRate, {{"frequency_hz", *frequency_hz}});
    return {};
  }
  // a tone nearby that explains more: the stated frequency is not the drive's
  if (const auto better = BetterNearby(driven, driven_s, tone.fit)) {
    // which of both is the drive is not known: the interval holds both amplitudes
    tone.fit.amplitude_uncertainty =
        std::hypot(tone.fit.amplitude_uncertainty,
                   std::abs(kScalloped * better->amplitude - tone.fit.amplitude) / kNormalCritical);
    analysis->findings.Doubt(FindingKind::kKnownToneElsewhere,
                             {{"frequency_hz", *frequency_hz},
                              {"better_hz", better->frequency_hz},
                              {"amplitude_m", better->amplitude}});
  }
  analysis->findings.Note(tone.aliased ? FindingKind::kKnownToneAlias : FindingKind::kKnownTone,
                          {{"frequency_hz", *frequency_hz}, {"amplitude_m", tone.fit.amplitude}});
  analysis->known_tone = tone;
  return {};
}

}  // namespace haptometer::dsp
