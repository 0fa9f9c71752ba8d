#include "dsp/analysis/record_facts.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

// a sample's time must be known to this part of a period
constexpr double kTimeUncertaintyPeriods = 0.1;

}  // namespace

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
  facts.observable_upper_hz = facts.fresh_rate_hz / kLeastRatePerUpperCorner;

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

void CheckObservable(const trial::Record& head, const Segments& segments, const BandPass& band,
                     BandAnalysis* analysis) {
  const RecordFacts& facts = analysis->record;
  const double needed_hz = kLeastRatePerUpperCorner * band.upper_hz;
  if (facts.fresh_rate_hz < needed_hz) {
    analysis->findings.Refuse(FindingKind::kTooFewReadings,
                              {{"new_readings_per_s", facts.fresh_rate_hz},
                               {"observable_hz", facts.observable_upper_hz},
                               {"lower_hz", band.lower_hz},
                               {"upper_hz", band.upper_hz},
                               {"needed_per_s", needed_hz}});
  }
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

void RemarkFaults(const trial::Record& head, BandAnalysis* analysis) {
  using enum FindingKind;
  constexpr std::array<std::pair<FaultKind, FindingKind>, kFaultKindCount> kKinds{
      {{FaultKind::kClipped, kClipped},
       {FaultKind::kHeld, kHeld},
       {FaultKind::kSpike, kSpikes},
       {FaultKind::kStep, kSteps}}};
  const Faults& faults = analysis->faults;
  for (const auto& [fault, kind] : kKinds) {
    if (faults.Count(fault) == 0) continue;
    const auto first = std::ranges::find(faults.list, fault, &Fault::kind);
    Finding found{.severity = Severity::kDoubt,
                  .kind = kind,
                  .numbers = {{"count", faults.Count(fault)},
                              {"readings", faults.Rows(fault)},
                              {"first_s", trial::TimeOf(head, first->first_row)}}};
    if (kind != kClipped) found.numbers.emplace_back("size_m", std::abs(first->size));
    analysis->findings.Add(std::move(found));
  }
}

}  // namespace haptometer::dsp
