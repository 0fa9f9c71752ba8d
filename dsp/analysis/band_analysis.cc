#include "dsp/analysis/band_analysis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/jobs.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/clean_rows.h"
#include "dsp/analysis/raw_summary.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/regular_grid.h"
#include "dsp/analysis/segments.h"
#include "dsp/analysis/slow_record.h"
#include "dsp/analysis/window_choice.h"
#include "dsp/analysis/window_numbers.h"

namespace haptometer::dsp {

namespace {

// farther than any target, and small enough for squares and their products
constexpr double kFarthestM = 1e30;

// the band and the window must be possible; whether the record has them is an answer, not an error
Result<void> CheckQuestion(const BandQuestion& question) {
  const auto possible = DesignBandPass(question.band, 4 * question.band.upper_hz);
  if (!possible) return std::unexpected(possible.error());
  if (question.choice == WindowChoice::kGiven &&
      !(question.window.end_s > question.window.begin_s)) {
    return Usage("window",
                 fmt::format("{:g} s to {:g} s is not an interval of time", question.window.begin_s,
                             question.window.end_s),
                 "give its begin, then its end, as 1s:3s");
  }
  return {};
}

// errors of a record without any measurement, or with readings that are no displacement
Result<void> CheckReadings(const trial::Record& head, const RawSummary& summary,
                           const RecordFacts& facts) {
  if (head.rows == 0) return CannotAnswer("", "holds no readings", "record again");
  if (facts.measured == 0) {
    return CannotAnswer(
        "",
        fmt::format("none of its {} readings is a measurement ({})", head.rows, Unmeasured(facts)),
        "check the target and the sensor's range");
  }
  const double farthest_m = std::max(-summary.least, summary.most);
  if (farthest_m > kFarthestM) {
    return CannotAnswer("", fmt::format("a reading of {:.3g} m is not a displacement", farthest_m),
                        "convert the column to metres, and its error codes to no value");
  }
  return {};
}

// notes on segments, excluded ends, interpolation and motion below the band
void AddRemarks(const std::vector<BandSignal>& all, const BandSignal& used,
                BandAnalysis* analysis) {
  const BandNumbers& numbers = *analysis->numbers;
  if (all.size() > 1) {
    analysis->findings.Note(FindingKind::kSegments, {{"segments", all.size()}});
  }
  const double rate_hz = used.rate_hz();
  analysis->findings.Note(
      FindingKind::kSegmentEnds,
      {{"first_s", static_cast<double>(used.settled_begin()) / rate_hz},
       {"last_s", static_cast<double>(used.size() - used.settled_end()) / rate_hz},
       {"segment_s", static_cast<double>(used.size()) / rate_hz}});
  if (analysis->record.bridged > 0) {
    analysis->findings.Note(FindingKind::kInterpolated, {{"interpolated", analysis->record.bridged},
                                                         {"rms_m", numbers.bridged_rms_m}});
  }
  if (!numbers.below_band) return;
  const BelowBand& below = *numbers.below_band;
  analysis->findings.Note(
      below.modelled ? FindingKind::kBelowBandModelled : FindingKind::kBelowBand,
      {{"amplitude_m", below.amplitude_m},
       {"frequency_hz", below.frequency_hz},
       {"leaked_m", below.leaked_rms_m}});
}

// the filtered signal on the record's rows, NaN outside of the segments
Result<void> KeepFiltered(const std::vector<BandSignal>& all, BandAnalysis* analysis) {
  analysis->filtered_m.assign(analysis->record.rows, std::numeric_limits<double>::quiet_NaN());
  for (const BandSignal& signal : all) {
    const std::span rows = std::span(analysis->filtered_m).subspan(signal.first_row());
    if (auto read = signal.Read(0, rows.first(signal.size())); !read) return read;
  }
  return {};
}

// filters, chooses the part and measures it, where enough of it is free of transients
Result<void> AnswerBand(const Displacement& displacement, const Segments& segments,
                        const BandQuestion& question, BandAnalysis* analysis) {
  const auto all = FilterSettledEnough(displacement, segments, question, analysis);
  if (!all) return std::unexpected(all.error());
  if (all->empty()) return {};
  const auto chosen = ChoosePart(*all, question, analysis);
  if (!chosen) return std::unexpected(chosen.error());
  if (*chosen) {
    // readings that rarely change are no measurement of vibration
    const auto stuck = WhyStuck(displacement, **chosen, *analysis);
    if (!stuck) return std::unexpected(stuck.error());
    if (*stuck) {
      analysis->findings.Add(**stuck);
      return {};
    }
    const auto measured = MeasureWindow(displacement, *all, **chosen, question, analysis);
    if (!measured) return measured;
    AddRemarks(*all, *(*chosen)->signal, analysis);
    RemarkImpossibleRms(analysis);
    analysis->answered = !analysis->findings.Refused();
  }
  return question.keep_filtered ? KeepFiltered(*all, analysis) : Result<void>{};
}

// drift and tremor from all rows, where they are uniformly spaced
std::optional<SlowMotion> SlowMotionOf(const trial::Record& head, const RawSummary& summary) {
  if (head.stretches.size() != 1) return std::nullopt;
  const auto cell_rows = static_cast<double>(summary.cell_rows);
  return DescribeSlowMotion(summary.cell_means, head.stretches.front().rate_hz / cell_rows);
}

// converts rows to those of the source, whose rows may be absent
void CountRows(const CleanRows& clean, std::size_t rows, BandAnalysis* analysis) {
  if (!clean.AnyAbsent()) return;
  const auto convert = [&](std::size_t& first, std::size_t& count) {
    const std::size_t end = clean.RowOf(first + count);
    first = clean.RowOf(first);
    count = end - first;
  };
  for (Fault& fault : analysis->faults.list) convert(fault.first_row, fault.rows);
  if (analysis->numbers) {
    UsedPart& part = analysis->numbers->part;
    convert(part.first_row, part.rows);
    if (auto& motion = analysis->numbers->kinematics) {
      motion->begin = clean.RowOf(motion->begin);
      motion->end = clean.RowOf(motion->end);
    }
  }
  // in place: a row is never before its own number in the source
  for (std::size_t k = 0; k < analysis->filtered_m.size(); ++k) {
    const std::size_t row = clean.RowOf(k);
    if (row < rows && !clean.IsAbsent(k)) analysis->filtered_m[row] = analysis->filtered_m[k];
  }
  if (!analysis->filtered_m.empty()) analysis->filtered_m.resize(rows);
  analysis->record.rows = rows;
}

// the answer for rows as they are; `why_not`, if there is one, is a refusal of the band
Result<BandAnalysis> AnalyzeRows(const trial::RowSource& source, BandQuestion question, int threads,
                                 const std::optional<Finding>& why_not) {
  const std::optional<double>& stated_hz = source.head().metadata.drive_frequency_hz;
  if (!question.drive_frequency_hz) question.drive_frequency_hz = stated_hz;
  const auto channel = AnalyzedChannel(source.head());
  if (!channel) return std::unexpected(channel.error());

  BandAnalysis analysis;
  analysis.band = question.band;
  // segments without artifacts; everything else reads parts of them again
  const auto clean = Clean(source, *channel, threads);
  if (!clean) return std::unexpected(clean.error());
  const trial::Record& head = clean->rows->head();
  analysis.faults = clean->faults;
  DescribeRecord(head, clean->segments, clean->summary, &analysis);
  if (auto checked = CheckReadings(head, clean->summary, analysis.record); !checked) {
    return std::unexpected(checked.error());
  }
  RemarkArtifacts(*clean, &analysis);
  RemarkDoubts(head, clean->summary, &analysis);
  // a record of one value has no vibration and no noise
  if (const auto stuck = WhyStuck(clean->summary)) {
    analysis.findings.Add(*stuck);
    CountRows(*clean->rows, source.head().rows, &analysis);
    return analysis;
  }
  if (why_not) analysis.findings.Add(*why_not);
  CheckObservable(head, clean->segments, question.band, &analysis);
  const Displacement displacement{*clean->rows, *channel, threads};
  std::optional<SlowMotion> slow_motion;
  // motion below the band is answered also where the band is refused
  const auto done = RunBeside(
      threads, {[&]() -> Result<void> {
                  slow_motion = SlowMotionOf(head, clean->summary);
                  return {};
                },
                [&] {
                  // a refused band still permits a fit at a known frequency
                  return analysis.findings.Refused()
                             ? FitKnownTone(displacement, question, &analysis)
                             : AnswerBand(displacement, clean->segments, question, &analysis);
                }});
  if (!done) return std::unexpected(done.error());
  analysis.slow_motion = slow_motion;
  CountRows(*clean->rows, source.head().rows, &analysis);
  return analysis;
}

// the figures of a grid
void RemarkGrid(const RegularGrid& grid, BandAnalysis* analysis) {
  analysis->findings.Note(FindingKind::kRegularGrid, {{"jitter_s", grid.jitter_s},
                                                      {"largest_jitter_s", grid.largest_jitter_s},
                                                      {"readings_per_s", grid.rate_hz},
                                                      {"readings", grid.record.rows},
                                                      {"missing", grid.dropped},
                                                      {"excluded", grid.left_out},
                                                      {"error", grid.error_bound}});
}

}  // namespace

Result<BandAnalysis> AnalyzeBand(const trial::Record& record, const BandQuestion& question) {
  return AnalyzeBand(trial::RecordRows(record), question);
}

Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source, const BandQuestion& question,
                                 int threads) {
  if (auto checked = CheckQuestion(question); !checked) return std::unexpected(checked.error());
  // non-uniform times are put on a grid first; without a grid the reason is part of the answer
  if (!source.head().times_are_known) return AnalyzeRows(source, question, threads, {});
  const auto grid = OnRegularGrid(source, question.band.upper_hz);
  if (!grid) return std::unexpected(grid.error());
  if (grid->refusal) return AnalyzeRows(source, question, threads, grid->refusal);
  auto analysis = AnalyzeRows(trial::RecordRows(grid->record), question, threads, {});
  if (analysis) RemarkGrid(*grid, &*analysis);
  return analysis;
}

std::optional<NoiseFloor> FloorOf(const BandAnalysis& drive_off, const std::string& source) {
  if (!drive_off.numbers) return std::nullopt;
  NoiseFloor floor{.power = drive_off.numbers->power,
                   .duration_s = drive_off.numbers->part.window.duration_s(),
                   .file = source};
  floor.rate_hz = drive_off.record.rate_hz;
  std::ranges::copy_if(
      drive_off.findings.list(), std::back_inserter(floor.refusals), [](const Finding& found) {
        return found.severity == Severity::kRefusal && found.kind != FindingKind::kNoDrive;
      });
  if (const auto& tone = drive_off.numbers->tone) {
    floor.tone_hz = tone->fit.frequency_hz;
    floor.tone_amplitude_m = tone->fit.amplitude;
  }
  return floor;
}

namespace {

constexpr double kSameRate = 0.01;       // relative
constexpr double kSameFrequency = 0.01;  // relative: a drive is set again no better

}  // namespace

std::vector<Finding> FloorDoubts(const BandNumbers& numbers, double rate_hz) {
  if (!numbers.floor || !(numbers.floor->rate_hz > 0)) return {};
  const NoiseFloor& floor = *numbers.floor;
  // refusals of the drive-off trial are doubts of its use as a floor
  std::vector<Finding> doubts = floor.refusals;
  if (std::abs(floor.rate_hz - rate_hz) > kSameRate * rate_hz) {
    doubts.push_back({.kind = FindingKind::kFloorOfOtherRate,
                      .numbers = {{"floor_per_s", floor.rate_hz}, {"readings_per_s", rate_hz}}});
  }
  // a tone in the floor: the drive was on, or a disturbance was there
  if (floor.tone_hz) {
    const bool is_same =
        numbers.tone && std::abs(*floor.tone_hz - numbers.tone->fit.frequency_hz) <=
                            kSameFrequency * numbers.tone->fit.frequency_hz;
    doubts.push_back(
        {.kind = is_same ? FindingKind::kFloorHasTheTone : FindingKind::kFloorHasTone,
         .numbers = {{"amplitude_m", floor.tone_amplitude_m}, {"frequency_hz", *floor.tone_hz}}});
  }
  for (Finding& doubt : doubts) {
    doubt.severity = Severity::kDoubt;
    doubt.subject = floor.file;
  }
  return doubts;
}

void RemarkFloor(const BandNumbers& numbers, BandAnalysis* analysis) {
  if (!numbers.floor) return analysis->findings.Note(FindingKind::kNoFloor);
  for (Finding& doubt : FloorDoubts(numbers, analysis->record.rate_hz)) {
    analysis->findings.Add(std::move(doubt));
  }
  const double floor_m = *numbers.rms.floor_m;
  // floor above the signal: no number; floor not exceeded: an upper limit
  if (numbers.rms.floor_contradicts) {
    analysis->findings.Add(
        {.severity = Severity::kRefusal,
         .kind = FindingKind::kFloorAboveSignal,
         .numbers = {{"floor_m", floor_m}, {"measured_m", numbers.rms.as_measured_m}},
         .subject = numbers.floor->file});
  } else if (numbers.rms.below_floor) {
    analysis->findings.Note(FindingKind::kBelowFloor,
                            {{"floor_m", floor_m}, {"at_most_m", numbers.rms.at_most_m}});
  }
}

}  // namespace haptometer::dsp
