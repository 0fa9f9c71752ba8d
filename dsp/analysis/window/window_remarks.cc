#include "dsp/analysis/window/window_remarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "dsp/analysis/decision_limits.h"

namespace haptometer::dsp {
namespace {

// a cause's share of the variance, by RmsCause
constexpr std::array<std::string_view, kRmsCauseCount> kShareNames{
    "noise_share",        "noise_floor_share", "noise_kept_share",  "below_band_share",
    "quantisation_share", "bridged_share",     "filter_ends_share", "beat_share",
    "drive_edges_share",  "steps_share",       "foot_share",        "hum_share",
    "drift_share",        "calibration_share",
};

// a doubt where the interval is wide, with its largest cause
void RemarkInterval(const ChosenPart& chosen, BandAnalysis* analysis) {
  const RmsEstimate& rms = analysis->numbers->rms;
  const double half_width_m = 0.5 * (rms.upper_m - rms.lower_m);
  if (chosen.refusal || rms.below_floor || half_width_m <= kWideShare * rms.rms_m) return;
  Finding wide{.severity = Severity::kDoubt,
               .kind = FindingKind::kWideInterval,
               .numbers = {{"share", half_width_m / rms.rms_m}}};
  if (rms.standard_uncertainty_m > 0) {
    const UncertaintyLine& largest = LargestLine(rms.budget);
    const double part = largest.standard_uncertainty_m / rms.standard_uncertainty_m;
    wide.numbers.emplace_back(kShareNames.at(static_cast<std::size_t>(largest.cause)),
                              kSameWithin * std::round(part * part / kSameWithin));
  }
  analysis->findings.Add(std::move(wide));
}

// notes on segments, excluded ends, interpolation and motion below the band
void RemarkSegments(const std::vector<BandSignal>& all, const BandSignal& used,
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
    Finding found{.severity = Severity::kNote,
                  .kind = FindingKind::kInterpolated,
                  .numbers = {{"interpolated", analysis->record.bridged}},
                  .subject = {}};
    // none may lie in the window
    if (numbers.bridged_rms_m > 0) found.numbers.emplace_back("rms_m", numbers.bridged_rms_m);
    analysis->findings.Add(std::move(found));
  }
  if (!numbers.below_band) return;
  const BelowBand& below = *numbers.below_band;
  analysis->findings.Note(
      below.modelled ? FindingKind::kBelowBandModelled : FindingKind::kBelowBand,
      {{"amplitude_m", below.amplitude_m},
       {"frequency_hz", below.frequency_hz},
       {"leaked_m", below.leaked_rms_m}});
}

// A doubt where one sine through the window has a smaller amplitude than those through its blocks,
// which hardly leave anything: noise increases theirs by less than 0.2 % then.
void RemarkVarying(const UsedPart& part, BandAnalysis* analysis) {
  const StateInterval& state = part.state;
  const double amplitude_m = std::numbers::sqrt2 * analysis->numbers->tone->sine_rms_m;
  const double power = 0.5 * state.level_m * state.level_m;
  if (!part.from_drive || state.residual > (1 - kExplained) * power) return;
  if (amplitude_m >= (1 - kNoticeable) * state.level_m) return;
  analysis->findings.Doubt(FindingKind::kToneVaries,
                           {{"level_m", state.level_m}, {"amplitude_m", amplitude_m}});
}

// the filter's slope at the tone, and whether it is the drive that the file states
void RemarkTone(const ChosenPart& chosen, const BandQuestion& question, BandAnalysis* analysis) {
  const BandNumbers& numbers = *analysis->numbers;
  const double frequency_hz = numbers.tone->fit.frequency_hz;
  const double gain = std::norm(Response(chosen.signal->design(), frequency_hz));
  if (gain < 1 - kSameWithin) {
    analysis->findings.Note(
        FindingKind::kCornerLoss,
        {{"frequency_hz", frequency_hz}, {"gain", gain}, {"rms_m", numbers.rms.rms_m / gain}});
  }
  const auto stated_hz = question.drive_frequency_hz;
  if (stated_hz && std::abs(frequency_hz - *stated_hz) > kSameWithin * *stated_hz) {
    analysis->findings.Doubt(FindingKind::kOtherDrive,
                             {{"frequency_hz", frequency_hz}, {"expected_hz", *stated_hz}});
  }
  // hum at the drive's own frequency is not sought: it adds to the drive or cancels it
  const bool alone = numbers.floor && numbers.floor->from != NoiseSource::kBeside;
  if (stated_hz && IsOfMains(frequency_hz, kMainsWithinHz) && !alone) {
    analysis->findings.Doubt(
        FindingKind::kMainsFrequency,
        {{"frequency_hz", frequency_hz}, {"amplitude_m", numbers.tone->amplitude_m}});
  }
}

// the refusal of a window without a drive states what there was, and what a drive is below
void RefuseWithoutDrive(const ChosenPart& chosen, BandAnalysis* analysis) {
  if (!chosen.refusal) return;
  const BandNumbers& numbers = *analysis->numbers;
  Finding refusal = *chosen.refusal;
  if (refusal.kind == FindingKind::kNoDrive) {
    refusal.numbers = {{"noise_m", numbers.rms.as_measured_m}, {"at_most_m", numbers.rms.upper_m}};
  }
  analysis->findings.Add(std::move(refusal));
}

// hum: what was subtracted, where it was not seen alone, and where it may hide in the drive
void RemarkHum(const ChosenPart& chosen, BandAnalysis* analysis) {
  const BandNumbers& numbers = *analysis->numbers;
  const std::vector<SteadyLine>& hum = numbers.hum;
  if (hum.empty() || !chosen.part.from_drive) return;
  const FindingNumber frequency{"frequency_hz", hum.front().frequency_hz};
  const FindingNumber amplitude{"amplitude_m", hum.front().amplitude_m()};
  const bool seen_alone = numbers.floor && numbers.floor->from != NoiseSource::kBeside;
  analysis->findings.Add({.severity = seen_alone ? Severity::kNote : Severity::kDoubt,
                          .kind = FindingKind::kHumSubtracted,
                          .numbers = {frequency, amplitude, {"lines", hum.size()}}});
  // a multiple of the mains within the drive's bins; a pause shows what hum has there
  const double reach_hz = std::max(kMainsWithinHz, kReachBins / numbers.part.window.duration_s());
  const double tone_hz = chosen.part.state.from_hz;
  const double order = std::round(tone_hz / hum.front().frequency_hz);
  const double multiple_hz = order * hum.front().frequency_hz;
  const bool is_hidden = order == 1 || (order > 1 && !seen_alone);
  if (is_hidden && std::abs(tone_hz - multiple_hz) < reach_hz) {
    analysis->findings.Doubt(
        FindingKind::kHumAtDrive,
        {{"frequency_hz", multiple_hz}, {"mains_hz", hum.front().frequency_hz}, amplitude});
  }
}

void RemarkFloor(BandAnalysis* analysis) {
  const BandNumbers& numbers = *analysis->numbers;
  if (!numbers.floor) {
    Finding unknown{.severity = Severity::kNote, .kind = FindingKind::kNoFloor};
    // it may be all of the RMS
    if (numbers.kept_noise_m < numbers.rms.as_measured_m) {
      unknown.numbers = {{"noise_m", numbers.kept_noise_m}};
    }
    return analysis->findings.Add(std::move(unknown));
  }
  for (Finding& doubt : FloorDoubts(numbers, analysis->record.rate_hz)) {
    analysis->findings.Add(std::move(doubt));
  }
  const double floor_m = *numbers.rms.floor_m;
  // floor above the signal, or a drive in it that is more than what it leaves: no number; floor not
  // exceeded: an upper limit
  const bool is_drive =
      numbers.rms.below_floor && numbers.floor->has_drive && floor_m >= numbers.rms.rms_m;
  if (numbers.rms.floor_contradicts || is_drive) {
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

}  // namespace

const UncertaintyLine& LargestLine(std::span<const UncertaintyLine> budget) {
  HAPTOMETER_CHECK(!budget.empty(), "a budget of {} lines", budget.size());
  return *std::ranges::max_element(budget, {}, &UncertaintyLine::standard_uncertainty_m);
}

std::optional<NoiseFloor> FloorOf(const BandAnalysis& drive_off, const std::string& source) {
  if (!drive_off.numbers) return std::nullopt;
  NoiseFloor floor{.power = drive_off.numbers->power,
                   .duration_s = drive_off.numbers->part.window.duration_s(),
                   .file = source};
  floor.rate_hz = drive_off.record.rate_hz;
  floor.has_drive = drive_off.numbers->part.from_drive;
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

std::vector<Finding> FloorDoubts(const BandNumbers& numbers, double rate_hz) {
  if (!numbers.floor || !(numbers.floor->rate_hz > 0)) return {};
  const NoiseFloor& floor = *numbers.floor;
  // refusals of the drive-off trial are doubts of its use as a floor
  std::vector<Finding> doubts = floor.refusals;
  if (std::abs(floor.rate_hz - rate_hz) > kSameWithin * rate_hz) {
    doubts.push_back({.kind = FindingKind::kFloorOfOtherRate,
                      .numbers = {{"floor_per_s", floor.rate_hz}, {"readings_per_s", rate_hz}}});
  }
  // a tone in the floor: the drive was on, or a disturbance was there
  if (floor.tone_hz) {
    const bool is_same =
        numbers.tone && std::abs(*floor.tone_hz - numbers.tone->fit.frequency_hz) <=
                            kSameWithin * numbers.tone->fit.frequency_hz;
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

void RemarkWindow(const std::vector<BandSignal>& all, const ChosenPart& chosen,
                  const BandQuestion& question, BandAnalysis* analysis) {
  if (analysis->numbers->tone) {
    RemarkTone(chosen, question, analysis);
    RemarkVarying(chosen.part, analysis);
  }
  RemarkHum(chosen, analysis);
  RefuseWithoutDrive(chosen, analysis);
  RemarkFloor(analysis);
  RemarkInterval(chosen, analysis);
  RemarkSegments(all, *chosen.signal, analysis);
}

}  // namespace haptometer::dsp
