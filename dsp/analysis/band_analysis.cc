#include "dsp/analysis/band_analysis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "base/band.h"
#include "base/jobs.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/analysis/window/window_numbers.h"
#include "dsp/readings/clean_rows.h"
#include "dsp/readings/plausibility.h"
#include "dsp/readings/raw_summary.h"
#include "dsp/readings/regular_grid.h"
#include "dsp/readings/segments.h"
#include "trial/calibration.h"

namespace haptometer::dsp {

namespace {

// farther than any target, and small enough for squares and their products
constexpr double kFarthestM = 1e30;

// the band and the window must be possible; whether the record has them is an answer, not an error
Result<void> CheckQuestion(const BandQuestion& question) {
  HAPTOMETER_TRY(DesignBandPass(question.band, 4 * question.band.upper_hz));
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

// the filtered signal on the record's rows, NaN outside of the segments
Result<void> KeepFiltered(const std::vector<BandSignal>& all, BandAnalysis* analysis) {
  analysis->filtered_m.assign(analysis->record.rows, std::numeric_limits<double>::quiet_NaN());
  for (const BandSignal& signal : all) {
    const std::span rows = std::span(analysis->filtered_m).subspan(signal.first_row());
    HAPTOMETER_TRY(signal.Read(0, rows.first(signal.size())));
  }
  return {};
}

// filters, chooses the part and measures it, where enough of it is free of transients
Result<void> AnswerBand(const Displacement& displacement, const Segments& segments,
                        const BandQuestion& question, BandAnalysis* analysis) {
  HAPTOMETER_LET(const auto all, FilterSettledEnough(displacement, segments, question, analysis));
  if (all.empty()) return {};
  HAPTOMETER_LET(auto chosen, ChoosePart(all, question, analysis));
  if (chosen) {
    const bool may_cut = question.choice == WindowChoice::kAuto;
    HAPTOMETER_TRY(FollowDrive(displacement.source, may_cut, *chosen, analysis));
    // readings that rarely change are no measurement of vibration
    HAPTOMETER_LET(const auto stuck, WhyStuck(displacement, *chosen, *analysis));
    if (stuck) {
      analysis->findings.Add(*stuck);
      return {};
    }
    HAPTOMETER_TRY(MeasureWindow(displacement, all, *chosen, question, analysis));
    RemarkImplausibleRms(
        analysis->numbers->rms.as_measured_m,
        std::max(std::abs(analysis->record.offset_m), analysis->record.peak_to_peak_m),
        &analysis->findings);
    analysis->answered = !analysis->findings.Refused();
  }
  return question.keep_filtered ? KeepFiltered(all, analysis) : Result<void>{};
}

// drift and tremor from all rows, where they are uniformly spaced
std::optional<SlowMotion> SlowMotionOf(const trial::Record& head, const RawSummary& summary) {
  if (head.stretches.size() != 1) return std::nullopt;
  const auto cell_rows = static_cast<double>(summary.cell_rows);
  return DescribeSlowMotion(summary.cell_means, head.stretches.front().rate_hz / cell_rows);
}

// the gain's uncertainty, as asked or as the record's calibration states it: all lengths scale
// alike
Result<void> IncludeGain(const trial::Record& head, std::size_t channel,
                         const BandQuestion& question, BandAnalysis* analysis) {
  HAPTOMETER_LET(const auto stated,
                 trial::GainUncertaintyOf(head.metadata, head.channels[channel].name));
  analysis->gain_uncertainty = question.gain_uncertainty ? question.gain_uncertainty : stated;
  if (!analysis->gain_uncertainty) return {};
  const double relative = *analysis->gain_uncertainty;
  analysis->findings.Note(FindingKind::kCalibrationIncluded, {{"share", relative}});
  if (stated && question.gain_uncertainty) {
    analysis->findings.Note(FindingKind::kCalibrationReplaced, {{"share", *stated}});
  }
  const auto include = [relative](double length, double& uncertainty) {
    uncertainty = std::hypot(uncertainty, relative * length);
  };
  if (auto& known = analysis->known_tone) {
    include(known->fit.amplitude, known->fit.amplitude_uncertainty);
  }
  if (auto& slow = analysis->slow_motion) {
    include(slow->drift_per_s, slow->drift_uncertainty_per_s);
    include(slow->tremor_rms.value_or(0), slow->tremor_rms_uncertainty);
  }
  if (!analysis->numbers) return {};
  AddGainUncertainty(relative, analysis->numbers->rms);
  if (auto& tone = analysis->numbers->tone) {
    include(tone->amplitude_m, tone->amplitude_uncertainty_m);
    const Interval limits =
        WithGain(tone->amplitude_m, {tone->amplitude_lower_m, tone->amplitude_upper_m}, relative);
    tone->amplitude_lower_m = limits.lower;
    tone->amplitude_upper_m = limits.upper;
  }
  if (auto& found = analysis->numbers->harmonics) {
    for (Harmonic& one : found->harmonics) include(one.amplitude, one.amplitude_uncertainty);
  }
  return {};
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
  HAPTOMETER_LET(const auto channel, AnalyzedChannel(source.head()));

  BandAnalysis analysis;
  analysis.band = question.band;
  // segments without artifacts; everything else reads parts of them again
  HAPTOMETER_LET(const auto clean, Clean(source, channel, threads));
  const trial::Record& head = clean.rows->head();
  analysis.faults = clean.faults;
  NoteOtherDisplacements(head, channel, &analysis.findings);
  DescribeRecord(head, clean.segments, clean.summary, &analysis);
  HAPTOMETER_TRY(CheckReadings(head, clean.summary, analysis.record));
  RemarkArtifacts(clean, &analysis);
  HAPTOMETER_TRY(CheckCalibratedRange(*clean.rows, channel, clean.summary, &analysis.findings));
  const RecordFacts& facts = analysis.record;
  RemarkPlausibility(
      head, clean.summary,
      {facts.rate_hz, facts.fresh_rate_hz, facts.duration_s, NeededRateHz(question.band.upper_hz)},
      &analysis.findings);
  // a record of one value has no vibration and no noise
  if (const auto stuck = WhyStuck(clean.summary)) {
    analysis.findings.Add(*stuck);
    CountRows(*clean.rows, source.head().rows, &analysis);
    return analysis;
  }
  if (why_not) analysis.findings.Add(*why_not);
  CheckObservable(head, clean.segments, question.band, &analysis);
  const Displacement displacement{*clean.rows, channel, threads};
  std::optional<SlowMotion> slow_motion;
  // motion below the band is answered also where the band is refused
  const auto done = RunBeside(
      threads, {[&]() -> Result<void> {
                  slow_motion = SlowMotionOf(head, clean.summary);
                  return {};
                },
                [&] {
                  // a refused band still permits a fit at a known frequency
                  return analysis.findings.Refused()
                             ? FitKnownTone(displacement, question, &analysis)
                             : AnswerBand(displacement, clean.segments, question, &analysis);
                }});
  if (!done) return std::unexpected(done.error());
  analysis.slow_motion = slow_motion;
  HAPTOMETER_TRY(IncludeGain(head, channel, question, &analysis));
  CountRows(*clean.rows, source.head().rows, &analysis);
  return analysis;
}

// the figures of a grid
void RemarkGrid(const RegularGrid& grid, BandAnalysis* analysis) {
  analysis->findings.Note(FindingKind::kRegularGrid, {{"jitter_s", grid.jitter_s},
                                                      {"largest_jitter_s", grid.largest_jitter_s},
                                                      {"readings_per_s", grid.rate_hz},
                                                      {"readings", grid.readings},
                                                      {"missing", grid.dropped},
                                                      {"excluded", grid.left_out},
                                                      {"error", grid.error_bound}});
  if (grid.drift_s > 0) {
    analysis->findings.Note(FindingKind::kClockDrift,
                            {{"drift_s", grid.drift_s}, {"readings_per_s", grid.rate_hz}});
  }
}

}  // namespace

Result<BandAnalysis> AnalyzeBand(const trial::Record& record, const BandQuestion& question) {
  return AnalyzeBand(trial::RecordRows(record), question);
}

Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source, const BandQuestion& question,
                                 int threads) {
  HAPTOMETER_TRY(CheckQuestion(question));
  // non-uniform times are put on a grid first; without a grid the reason is part of the answer
  if (!source.head().times_are_known) return AnalyzeRows(source, question, threads, {});
  HAPTOMETER_LET(const auto grid, OnRegularGrid(source, question.band.upper_hz));
  if (grid.refusal) return AnalyzeRows(source, question, threads, grid.refusal);
  auto analysis = AnalyzeRows(trial::RecordRows(grid.record), question, threads, {});
  if (analysis) RemarkGrid(grid, &*analysis);
  return analysis;
}

namespace {

// samples of `window` in `segment`, at most `most` from its middle
WindowSamples PlaceOf(const Segment& segment, const TimeWindow& window, std::size_t most) {
  const double begin = std::round((window.begin_s - segment.start_s) * segment.rate_hz);
  const double wanted = std::round(window.duration_s() * segment.rate_hz);
  const auto first = std::min(static_cast<std::size_t>(begin), segment.size);
  const std::size_t size = std::min(static_cast<std::size_t>(wanted), segment.size - first);
  const std::size_t count = std::min(size, most);
  const std::size_t begin_of_middle = first + (size - count) / 2;
  WindowSamples samples;
  samples.rate_hz = segment.rate_hz;
  samples.start_s = segment.start_s + static_cast<double>(begin_of_middle) / segment.rate_hz;
  samples.values_m.resize(count);
  return samples;
}

// samples before the filter, from the segment that holds the window's middle
Result<WindowSamples> ReadFrom(const trial::RowSource& source, const BandAnalysis& analysis,
                               std::size_t most) {
  HAPTOMETER_LET(const auto channel, AnalyzedChannel(source.head()));
  HAPTOMETER_LET(const auto clean, Clean(source, channel));
  const Segments* segments = &clean.segments;
  const TimeWindow& window = analysis.numbers->part.window;
  const double middle_s = (window.begin_s + window.end_s) / 2;
  const auto holds_window = [&](const Segment& segment) {
    return middle_s >= segment.start_s &&
           middle_s < segment.start_s + static_cast<double>(segment.size) / segment.rate_hz;
  };
  const auto segment = std::ranges::find_if(segments->parts, holds_window);
  HAPTOMETER_CHECK(segment != segments->parts.end(), "{} s are in no segment", middle_s);
  WindowSamples samples = PlaceOf(*segment, window, most);
  const double first = std::round((samples.start_s - segment->start_s) * segment->rate_hz);
  HAPTOMETER_TRY(SegmentSamples(*clean.rows, channel, *segment)
                     .Read(static_cast<std::size_t>(first), samples.values_m));
  return samples;
}

}  // namespace

Result<WindowSamples> ReadWindow(const trial::RowSource& source, const BandAnalysis& analysis,
                                 std::size_t most) {
  HAPTOMETER_CHECK(analysis.numbers, "an analysis without a window");
  // as in AnalyzeBand: known times are put on the same grid first
  if (!source.head().times_are_known) return ReadFrom(source, analysis, most);
  HAPTOMETER_LET(const auto grid, OnRegularGrid(source, analysis.band.upper_hz));
  HAPTOMETER_CHECK(!grid.refusal, "an analysis of times without a grid");
  return ReadFrom(trial::RecordRows(grid.record), analysis, most);
}

}  // namespace haptometer::dsp
