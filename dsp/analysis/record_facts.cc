#include "dsp/analysis/record_facts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kUmPerM = 1e6;
// a sample's time must be known to this part of a period
constexpr double kTimeUncertaintyPeriods = 0.1;

}  // namespace

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

  const auto longest = std::ranges::max_element(head.stretches, {}, &trial::Stretch::rows);
  facts.rate_hz = longest->rate_hz;
  for (const trial::Stretch& stretch : head.stretches) {
    facts.duration_s += static_cast<double>(stretch.rows) / stretch.rate_hz;
  }
  const auto repeated = segments.by_status[static_cast<std::size_t>(SampleStatus::kRepeated)];
  facts.fresh_rate_hz =
      facts.rate_hz * (1 - static_cast<double>(repeated) / static_cast<double>(segments.measured));
  facts.observable_upper_hz = facts.fresh_rate_hz / kLeastRatePerUpperCorner;

  if (facts.measured < facts.rows) {
    analysis->remarks.push_back(fmt::format("left out: {} of {} readings ({})",
                                            facts.rows - facts.measured, facts.rows,
                                            Unmeasured(facts)));
  }
  if (repeated > 0) {
    analysis->remarks.push_back(
        fmt::format("{} of {} readings were handed out a second time", repeated, facts.measured));
  }
}

void CheckObservable(const trial::Record& head, const Segments& segments, const BandPass& band,
                     BandAnalysis* analysis) {
  const RecordFacts& facts = analysis->record;
  const double needed_hz = kLeastRatePerUpperCorner * band.upper_hz;
  if (facts.fresh_rate_hz < needed_hz) {
    analysis->reasons.push_back(fmt::format(
        "{:.4g} new readings/s show vibration up to {:.4g} Hz; {:g}-{:g} Hz needs {:g}/s: "
        "use a free-running output, or the analog output and a DAQ",
        facts.fresh_rate_hz, facts.observable_upper_hz, band.lower_hz, band.upper_hz, needed_hz));
  }
  // a reading that was asked for is of unknown age; a free-running source has a clock of its own,
  // however its arrivals scatter
  if (head.timing != trial::Timing::kPolled) return;
  const double limit_s = kTimeUncertaintyPeriods / band.upper_hz;
  for (const Segment& segment : segments.parts) {
    if (segment.time_uncertainty_s < limit_s) continue;
    analysis->reasons.push_back(
        fmt::format("each reading's time is uncertain by {:.3g} ms; motion at {:g} Hz needs less "
                    "than {:.3g} ms: "
                    "use a sensor that samples on a clock of its own",
                    segment.time_uncertainty_s * 1e3, band.upper_hz, limit_s * 1e3));
    break;
  }
}

void RemarkFaults(const trial::Record& head, BandAnalysis* analysis) {
  const Faults& faults = analysis->faults;
  for (const FaultKind kind :
       {FaultKind::kClipped, FaultKind::kHeld, FaultKind::kSpike, FaultKind::kStep}) {
    if (faults.Count(kind) == 0) continue;
    const auto first = std::ranges::find(faults.list, kind, &Fault::kind);
    std::string text = fmt::format("{} {}, {} readings in all, the first at {:.4f} s",
                                   faults.Count(kind), Words(kind, faults.Count(kind)),
                                   faults.Rows(kind), trial::TimeOf(head, first->first_row));
    if (kind != FaultKind::kClipped) {
      text += fmt::format(" ({:.3g} um)", std::abs(first->size) * kUmPerM);
    }
    analysis->remarks.push_back(text + "; not repaired");
  }
}

}  // namespace haptometer::dsp
