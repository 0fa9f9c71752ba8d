#include "dsp/analysis/floor_remarks.h"

#include <cmath>
#include <utility>

namespace haptometer::dsp {
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
