#include "dsp/analysis/band_analysis.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/raw_summary.h"
#include "dsp/analysis/record_facts.h"
#include "dsp/analysis/segments.h"
#include "dsp/analysis/slow_record.h"
#include "dsp/analysis/used_part.h"
#include "dsp/analysis/window_numbers.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kUmPerM = 1e6;

Result<std::size_t> DisplacementOf(const trial::Record& head) {
  const trial::Channel* first = head.Find(trial::ChannelRole::kDisplacement);
  if (first == nullptr) {
    return CannotAnswer("", "holds no displacement channel", "name one displacement_m");
  }
  for (std::size_t k = 0; k < head.channels.size(); ++k) {
    const trial::Channel& channel = head.channels[k];
    if (channel.role == trial::ChannelRole::kDisplacement && channel.unit == "m") return k;
  }
  return CannotAnswer("", fmt::format("its displacement has the unit '{}'", first->unit),
                      "convert it to metres");
}

// the band and the window must be possible; whether the record has them is an answer, not an error
Result<void> CheckQuestion(const BandQuestion& question) {
  const auto possible = DesignBandPass(question.band, 4 * question.band.upper_hz);
  if (!possible) return std::unexpected(possible.error());
  if (question.choice == WindowChoice::kGiven &&
      !(question.window.end_s > question.window.begin_s)) {
    return Usage("window",
                 fmt::format("{:g} s to {:g} s is no stretch of time", question.window.begin_s,
                             question.window.end_s),
                 "give its begin, then its end, as 1s:3s");
  }
  return {};
}

// what one pass over all rows finds
struct Pass {
  Segments segments;
  RawSummary summary;
};

Result<Pass> PassOver(const trial::RowSource& source, std::size_t channel,
                      const BandQuestion& question, int threads, BandAnalysis* analysis) {
  const trial::Record& head = source.head();
  const trial::Channel& displacement = head.channels[channel];
  RawSummarizer summarizer(head);
  FaultScanner scanner({displacement.range_min, displacement.range_max, displacement.resolution});
  auto segments = SplitIntoSegments(
      source, channel, question.band.upper_hz,
      [&](std::size_t first_row, std::span<const double> values,
          std::span<const SampleStatus> statuses) {
        summarizer.Feed(values, statuses);
        scanner.Feed(first_row, values, statuses);
      },
      threads);
  if (!segments) return std::unexpected(segments.error());
  analysis->faults = scanner.Finish();
  return Pass{std::move(*segments), summarizer.Finish()};
}

// what the reader of the numbers must know of how they came about
void AddRemarks(const std::vector<BandSignal>& all, const BandSignal& used,
                BandAnalysis* analysis) {
  const BandNumbers& numbers = *analysis->numbers;
  if (all.size() > 1) {
    analysis->remarks.push_back(fmt::format(
        "gaps split the record into {} pieces; the window is in one of them", all.size()));
  }
  const double rate_hz = used.rate_hz();
  analysis->remarks.push_back(
      fmt::format("ends not settled: {:.3f} s and {:.3f} s of a piece of {:.3f} s",
                  static_cast<double>(used.settled_begin()) / rate_hz,
                  static_cast<double>(used.size() - used.settled_end()) / rate_hz,
                  static_cast<double>(used.size()) / rate_hz));
  if (analysis->record.bridged > 0) {
    analysis->remarks.push_back(
        fmt::format("{} readings bridged; this adds about {:.2g} um at most",
                    analysis->record.bridged, numbers.bridged_rms_m * kUmPerM));
  }
  if (!numbers.below_band) return;
  analysis->remarks.push_back(fmt::format(
      "{:.4g} um at {:.3g} Hz lie below the band; {:.2g} um RMS of that leak into it{}",
      numbers.below_band->amplitude_m * kUmPerM, numbers.below_band->frequency_hz,
      numbers.below_band->leaked_rms_m * kUmPerM,
      numbers.below_band->modelled ? "; taken as going on before and after the record" : ""));
}

// the filtered signal beside the record's rows
Result<void> KeepFiltered(const std::vector<BandSignal>& all, BandAnalysis* analysis) {
  analysis->filtered_m.assign(analysis->record.rows, std::numeric_limits<double>::quiet_NaN());
  for (const BandSignal& signal : all) {
    const std::span rows = std::span(analysis->filtered_m).subspan(signal.first_row());
    if (auto read = signal.Read(0, rows.first(signal.size())); !read) return read;
  }
  return {};
}

// filters, and measures the window where enough settles
Result<void> AnswerBand(const Displacement& displacement, const Segments& segments,
                        const BandQuestion& question, BandAnalysis* analysis) {
  const auto all = FilterSettledEnough(displacement, segments, question, analysis);
  if (!all) return std::unexpected(all.error());
  if (all->empty()) return {};
  const auto chosen = ChoosePart(displacement.source, *all, question, analysis);
  if (!chosen) return std::unexpected(chosen.error());
  if (*chosen) {
    const auto measured = MeasureWindow(displacement.source.head(),
                                        displacement.source.head().channels[displacement.channel],
                                        *all, **chosen, question, analysis);
    if (!measured) return measured;
    AddRemarks(*all, *(*chosen)->signal, analysis);
    analysis->answered = analysis->reasons.empty();
  }
  return question.keep_filtered ? KeepFiltered(*all, analysis) : Result<void>{};
}

}  // namespace

Result<BandAnalysis> AnalyzeBand(const trial::Record& record, const BandQuestion& question) {
  return AnalyzeBand(trial::RecordRows(record), question);
}

Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source, const BandQuestion& question,
                                 int threads) {
  if (auto checked = CheckQuestion(question); !checked) return std::unexpected(checked.error());
  const trial::Record& head = source.head();
  const auto channel = DisplacementOf(head);
  if (!channel) return std::unexpected(channel.error());

  BandAnalysis analysis;
  analysis.band = question.band;
  const auto pass = PassOver(source, *channel, question, threads, &analysis);
  if (!pass) return std::unexpected(pass.error());
  DescribeRecord(head, pass->segments, pass->summary, &analysis);
  if (analysis.record.measured == 0) {
    if (head.rows == 0) return CannotAnswer("", "holds no readings", "record again");
    return CannotAnswer("",
                        fmt::format("none of its {} readings is a measurement ({})", head.rows,
                                    Unmeasured(analysis.record)),
                        "check the target and the sensor's range");
  }
  RemarkFaults(head, &analysis);
  if (head.stretches.size() == 1) {
    const auto cell_rows = static_cast<double>(pass->summary.cell_rows);
    analysis.slow_motion =
        DescribeSlowMotion(pass->summary.cell_means, head.stretches.front().rate_hz / cell_rows);
  }

  CheckObservable(head, pass->segments, question.band, &analysis);
  const Displacement displacement{source, *channel, threads};
  const auto done = analysis.reasons.empty()
                        ? AnswerBand(displacement, pass->segments, question, &analysis)
                        : FitKnownTone(displacement, question, &analysis);
  if (!done) return std::unexpected(done.error());
  return analysis;
}

std::optional<NoiseFloor> FloorOf(const BandAnalysis& drive_off, const std::string& source) {
  if (!drive_off.numbers) return std::nullopt;
  return NoiseFloor{drive_off.numbers->power, drive_off.numbers->part.window.duration_s(), source};
}

}  // namespace haptometer::dsp
