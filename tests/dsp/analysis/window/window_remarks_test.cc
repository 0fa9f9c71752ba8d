// What is said of a window's numbers: each finding with its numbers, and on both sides of its
// limit.
#include "dsp/analysis/window/window_remarks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <optional>
#include <vector>

#include "tests/dsp/analysis/window/made_window.h"
#include "tests/dsp/findings.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRound = 1e-13;

// a window of 2 s with numbers, a tone of 1 um at 150.4 Hz, and a drive there
struct Remarked : MadeWindow {
  Remarked() : MadeWindow(TwoSeconds()) {
    BandNumbers& numbers = analysis.numbers.emplace();
    numbers.part.window = {0, 2};
    numbers.tone.emplace().fit.frequency_hz = 150.4;
    numbers.tone->amplitude_m = 1e-6;
    numbers.rms.rms_m = 0.7e-6;
    numbers.rms.lower_m = 0.69e-6;
    numbers.rms.upper_m = 0.71e-6;
    numbers.rms.floor_m = 2e-8;
    numbers.rms.as_measured_m = 0.72e-6;
    chosen.part.from_drive = true;
    chosen.part.state.from_hz = chosen.part.state.to_hz = 150.4;
  }
  [[nodiscard]] BandNumbers& numbers() { return *analysis.numbers; }
  // all findings, made anew
  const Findings& Remarks() {
    analysis.findings = {};
    std::vector<BandSignal> all;
    for (std::size_t k = 0; k < signals; ++k) all.push_back(signal);
    RemarkWindow(all, chosen, question, &analysis);
    return analysis.findings;
  }
  std::size_t signals = 1;
};

bool Has(Remarked& made, FindingKind kind) { return made.Remarks().Has(kind); }

void ExpectFloor(Remarked& made, NoiseSource from) {
  made.numbers().floor = NoiseFloor{.power = {}, .from = from};
}

TEST(RemarkTone, ALossAtACornerIsToldBeyondOnePercent) {
  Remarked made;
  const auto gain = [&](double frequency_hz) {
    return std::norm(Response(made.signal.design(), frequency_hz));
  };
  // the frequency at which 1 % is lost
  double lost_hz = 20;
  double kept_hz = 60;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (lost_hz + kept_hz);
    (gain(middle) < 0.99 ? lost_hz : kept_hz) = middle;
  }
  made.numbers().tone->fit.frequency_hz = 0.999 * lost_hz;
  const Finding loss = FirstOf(made.Remarks(), FindingKind::kCornerLoss);
  EXPECT_REL(NumberOf(loss, "gain"), gain(0.999 * lost_hz), kRound, "two passes");
  EXPECT_REL(NumberOf(loss, "rms_m"), 0.7e-6 / gain(0.999 * lost_hz), kRound, "divided by it");
  EXPECT_EQ(NumberOf(loss, "frequency_hz"), 0.999 * lost_hz);
  made.numbers().tone->fit.frequency_hz = 1.001 * kept_hz;
  EXPECT_FALSE(Has(made, FindingKind::kCornerLoss));
}

TEST(RemarkTone, AnotherDriveThanStatedIsToldBeyondOnePercent) {
  Remarked made;
  EXPECT_FALSE(Has(made, FindingKind::kOtherDrive)) << "none is stated";
  for (const double off : {-0.0101, -0.0099, 0.0099, 0.0101}) {
    made.question.drive_frequency_hz = 150.4 / (1 + off);
    // of the stated one
    EXPECT_EQ(Has(made, FindingKind::kOtherDrive), std::abs(off) > 0.01) << off;
  }
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kOtherDrive, "frequency_hz"), 150.4);
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kOtherDrive, "expected_hz"), 150.4 / 1.0101);
}

// A stated drive within 1 Hz of a multiple of the mains may be hum, unless its pause was seen.
TEST(RemarkTone, AStatedDriveAtTheMainsIsADoubt) {
  Remarked made;
  EXPECT_FALSE(Has(made, FindingKind::kMainsFrequency)) << "not stated";
  for (const double frequency_hz : {148.99, 149.01, 150.99, 151.01, 180.99, 181.01}) {
    made.question.drive_frequency_hz = frequency_hz;
    made.numbers().tone->fit.frequency_hz = frequency_hz;
    const bool near = std::abs(std::remainder(frequency_hz, 30)) < 1;
    EXPECT_EQ(Has(made, FindingKind::kMainsFrequency), near) << frequency_hz;
  }
  made.numbers().tone->fit.frequency_hz = 150.99;
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kMainsFrequency, "amplitude_m"), 1e-6);
  ExpectFloor(made, NoiseSource::kBeside);
  EXPECT_TRUE(Has(made, FindingKind::kMainsFrequency));
  ExpectFloor(made, NoiseSource::kQuiet);
  EXPECT_FALSE(Has(made, FindingKind::kMainsFrequency));
}

TEST(RemarkHum, IsADoubtUnlessItWasSeenAlone) {
  Remarked made;
  EXPECT_FALSE(Has(made, FindingKind::kHumSubtracted));
  made.numbers().hum = {{60, 3e-7, 4e-7}, {120, 0, 1e-7}};
  const Finding doubt = FirstOf(made.Remarks(), FindingKind::kHumSubtracted);
  EXPECT_EQ(doubt.severity, Severity::kDoubt);
  EXPECT_EQ(NumberOf(doubt, "frequency_hz"), 60);
  EXPECT_REL(NumberOf(doubt, "amplitude_m"), 5e-7, kRound, "of 3 and 4");
  EXPECT_EQ(NumberOf(doubt, "lines"), 2);
  ExpectFloor(made, NoiseSource::kQuiet);
  EXPECT_EQ(FirstOf(made.Remarks(), FindingKind::kHumSubtracted).severity, Severity::kNote);
  ExpectFloor(made, NoiseSource::kBeside);
  EXPECT_EQ(FirstOf(made.Remarks(), FindingKind::kHumSubtracted).severity, Severity::kDoubt);
  made.chosen.part.from_drive = false;
  EXPECT_FALSE(Has(made, FindingKind::kHumSubtracted)) << "no drive that it could hide in";
}

// within five bins of the drive, 0.5 Hz each of 2 s, or within 1 Hz
TEST(RemarkHum, AMultipleAtTheDriveIsADoubt) {
  Remarked made;
  made.numbers().hum = {{50.01, 3e-7, 4e-7}};
  const auto at_drive = [&](double drive_hz, double window_s) {
    made.chosen.part.state.from_hz = drive_hz;
    made.numbers().part.window = {1, 1 + window_s};
    return Has(made, FindingKind::kHumAtDrive);
  };
  EXPECT_TRUE(at_drive(150.03 + 2.49, 2));
  EXPECT_FALSE(at_drive(150.03 + 2.51, 2));
  EXPECT_TRUE(at_drive(150.03 - 2.49, 2));
  EXPECT_TRUE(at_drive(150.03 + 0.995, 20));
  EXPECT_FALSE(at_drive(150.03 + 1.005, 20));
  EXPECT_FALSE(at_drive(24.9, 0.19)) << "below the hum there is no multiple";
  EXPECT_TRUE(at_drive(150.03, 2));
  const Finding hidden = FirstOf(made.Remarks(), FindingKind::kHumAtDrive);
  EXPECT_REL(NumberOf(hidden, "frequency_hz"), 150.03, kRound, "the third multiple");
  EXPECT_EQ(NumberOf(hidden, "mains_hz"), 50.01);
  ExpectFloor(made, NoiseSource::kQuiet);
  EXPECT_FALSE(at_drive(150.03, 2)) << "the pause shows hum at the multiple";
  EXPECT_TRUE(at_drive(50.5, 2)) << "beside the line itself it shows another line";
}

TEST(RefuseWithoutDrive, StatesTheNoiseAndWhatADriveIsBelow) {
  Remarked made;
  made.chosen.refusal = {.severity = Severity::kRefusal, .kind = FindingKind::kNoDrive};
  const Finding none = FirstOf(made.Remarks(), FindingKind::kNoDrive);
  EXPECT_EQ(NumberOf(none, "noise_m"), 0.72e-6);
  EXPECT_EQ(NumberOf(none, "at_most_m"), 0.71e-6);
  made.chosen.refusal = {.severity = Severity::kRefusal,
                         .kind = FindingKind::kNothingSteady,
                         .numbers = {{"on_s", 3.0}}};
  const Finding unsteady = FirstOf(made.Remarks(), FindingKind::kNothingSteady);
  ASSERT_EQ(unsteady.numbers.size(), 1U);
  EXPECT_EQ(NumberOf(unsteady, "on_s"), 3);
}

TEST(RemarkFloor, SaysWhetherThereIsOneAndWhatItLeaves) {
  Remarked made;
  // noise that is all of the RMS is not said twice
  made.numbers().kept_noise_m = 0.72e-6;
  EXPECT_TRUE(FirstOf(made.Remarks(), FindingKind::kNoFloor).numbers.empty());
  made.numbers().kept_noise_m = 0.1e-6;
  EXPECT_EQ(NumberOf(FirstOf(made.Remarks(), FindingKind::kNoFloor), "noise_m"), 0.1e-6);
  made.numbers().floor = NoiseFloor{.power = {}, .file = "off.bin"};
  EXPECT_FALSE(Has(made, FindingKind::kNoFloor));
  EXPECT_FALSE(Has(made, FindingKind::kBelowFloor));
  made.numbers().rms.below_floor = true;
  made.numbers().rms.at_most_m = 9e-8;
  const Finding note = FirstOf(made.Remarks(), FindingKind::kBelowFloor);
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_EQ(NumberOf(note, "floor_m"), 2e-8);
  EXPECT_EQ(NumberOf(note, "at_most_m"), 9e-8);
  // a drive in the floor that is more than what it leaves
  made.numbers().floor->has_drive = true;
  made.numbers().rms.floor_m = 0.701e-6;
  const Finding refusal = FirstOf(made.Remarks(), FindingKind::kFloorAboveSignal);
  EXPECT_EQ(refusal.severity, Severity::kRefusal);
  EXPECT_EQ(refusal.subject, "off.bin");
  EXPECT_EQ(NumberOf(refusal, "floor_m"), 0.701e-6);
  EXPECT_EQ(NumberOf(refusal, "measured_m"), 0.72e-6);
  made.numbers().rms.floor_m = 0.699e-6;
  EXPECT_FALSE(Has(made, FindingKind::kFloorAboveSignal)) << "less than what it leaves";
  made.numbers().rms.below_floor = false;
  made.numbers().rms.floor_contradicts = true;
  EXPECT_TRUE(Has(made, FindingKind::kFloorAboveSignal));
}

TEST(FloorOf, TakesAllOfTheWindowItsToneAndItsRefusals) {
  Remarked made;
  made.numbers().power = {4e-14, 1e-30};
  made.numbers().part.window = {1, 2.5};
  made.numbers().part.from_drive = true;
  made.numbers().tone->fit.amplitude = 3e-7;
  made.analysis.findings.Refuse(FindingKind::kNoDrive);
  made.analysis.findings.Refuse(FindingKind::kWindowClipped);
  made.analysis.findings.Doubt(FindingKind::kAveragingUnknown);
  const auto floor = FloorOf(made.analysis, "off.bin");
  ASSERT_TRUE(floor);
  EXPECT_EQ(floor->power.mean_square, 4e-14);
  EXPECT_EQ(floor->power.variance, 1e-30);
  EXPECT_EQ(floor->duration_s, 1.5);
  EXPECT_EQ(floor->file, "off.bin");
  EXPECT_EQ(floor->from, NoiseSource::kFile);
  EXPECT_EQ(floor->rate_hz, 10e3);
  EXPECT_EQ(floor->tone_hz, 150.4);
  EXPECT_EQ(floor->tone_amplitude_m, 3e-7);
  EXPECT_TRUE(floor->has_drive);
  ASSERT_EQ(floor->refusals.size(), 1U) << "that no drive was on is what a floor is for";
  EXPECT_EQ(floor->refusals[0].kind, FindingKind::kWindowClipped);
  made.analysis.numbers.reset();
  EXPECT_FALSE(FloorOf(made.analysis, "off.bin"));
}

// the kinds of the doubts of a floor at `rate_hz` with a tone at `tone_hz`, of a trial at 1 kHz
// with a tone at 200 Hz
std::vector<Finding> DoubtsOf(double rate_hz, std::optional<double> tone_hz) {
  BandNumbers numbers;
  numbers.tone.emplace().fit.frequency_hz = 200;
  numbers.floor = NoiseFloor{.power = {}, .file = "off.bin"};
  numbers.floor->rate_hz = rate_hz;
  numbers.floor->tone_hz = tone_hz;
  numbers.floor->tone_amplitude_m = 3e-7;
  return FloorDoubts(numbers, 1000);
}

TEST(FloorDoubts, AnotherRateIsOneBeyondAPercent) {
  EXPECT_TRUE(DoubtsOf(1009.9, {}).empty());
  EXPECT_TRUE(DoubtsOf(990.1, {}).empty());
  for (const double rate_hz : {1010.1, 989.9}) {
    const auto doubts = DoubtsOf(rate_hz, {});
    ASSERT_EQ(doubts.size(), 1U) << rate_hz;
    EXPECT_EQ(doubts[0].kind, FindingKind::kFloorOfOtherRate);
    EXPECT_EQ(doubts[0].severity, Severity::kDoubt);
    EXPECT_EQ(doubts[0].subject, "off.bin");
    EXPECT_EQ(NumberOf(doubts[0], "floor_per_s"), rate_hz);
    EXPECT_EQ(NumberOf(doubts[0], "readings_per_s"), 1000);
  }
  EXPECT_TRUE(DoubtsOf(0, 200).empty()) << "not of a file";
}

TEST(FloorDoubts, AToneIsTheTrialsOwnWithinAPercent) {
  for (const double tone_hz : {197.99, 198.01, 201.99, 202.01}) {
    const auto doubts = DoubtsOf(1000, tone_hz);
    ASSERT_EQ(doubts.size(), 1U) << tone_hz;
    EXPECT_EQ(doubts[0].kind, std::abs(tone_hz - 200) < 2 ? FindingKind::kFloorHasTheTone
                                                          : FindingKind::kFloorHasTone);
    EXPECT_EQ(NumberOf(doubts[0], "frequency_hz"), tone_hz);
    EXPECT_EQ(NumberOf(doubts[0], "amplitude_m"), 3e-7);
  }
}

TEST(FloorDoubts, RefusalsOfTheDriveOffTrialAreDoubtsOfItsUse) {
  BandNumbers numbers;
  EXPECT_TRUE(FloorDoubts(numbers, 1000).empty());
  numbers.floor = NoiseFloor{.power = {}, .file = "off.bin", .rate_hz = 1000};
  numbers.floor->refusals = {
      {.severity = Severity::kRefusal, .kind = FindingKind::kWindowClipped, .numbers = {}}};
  const auto doubts = FloorDoubts(numbers, 1000);
  ASSERT_EQ(doubts.size(), 1U);
  EXPECT_EQ(doubts[0].severity, Severity::kDoubt);
  EXPECT_EQ(doubts[0].subject, "off.bin");
}

// Half of the interval is 2.5 % of the RMS of 0.7 um: 17.5 nm.
TEST(RemarkInterval, IsADoubtBeyondTwoAndAHalfPercent) {
  Remarked made;
  made.numbers().rms.lower_m = 0.68e-6;
  made.numbers().rms.upper_m = 0.68e-6 + 2 * 17.6e-9;
  const Finding doubt = FirstOf(made.Remarks(), FindingKind::kWideInterval);
  EXPECT_REL(NumberOf(doubt, "share"), 17.6 / 700, 1e-12, "a difference of limits");
  made.numbers().rms.below_floor = true;
  EXPECT_FALSE(Has(made, FindingKind::kWideInterval)) << "an upper limit has no interval";
  made.numbers().rms.below_floor = false;
  made.chosen.part.from_drive = false;
  EXPECT_TRUE(Has(made, FindingKind::kWideInterval)) << "of a stated window too";
  made.chosen.refusal = {.severity = Severity::kRefusal, .kind = FindingKind::kNoDrive};
  EXPECT_FALSE(Has(made, FindingKind::kWideInterval)) << "no RMS";
  made.chosen.refusal.reset();
  made.numbers().rms.upper_m = 0.68e-6 + 2 * 17.4e-9;
  EXPECT_FALSE(Has(made, FindingKind::kWideInterval));
}

// 3, 4 and 12 of 13: 144 of 169 parts of the variance.
TEST(RemarkInterval, NamesTheLargestCauseWithItsShareOfTheVariance) {
  constexpr const char* kNames[] = {"noise_share",       "noise_floor_share",  "noise_kept_share",
                                    "below_band_share",  "quantisation_share", "bridged_share",
                                    "filter_ends_share", "beat_share",         "drive_edges_share",
                                    "steps_share",       "foot_share",         "hum_share",
                                    "drift_share",       "calibration_share"};
  static_assert(std::size(kNames) == kRmsCauseCount);
  for (std::size_t k = 0; k < kRmsCauseCount; ++k) {
    Remarked made;
    RmsEstimate& rms = made.numbers().rms;
    rms.lower_m = 0.6e-6;
    rms.upper_m = 0.8e-6;
    const auto other = [&](std::size_t away) {
      return static_cast<RmsCause>((k + away) % kRmsCauseCount);
    };
    rms.budget = {{other(1), Evaluation::kBound, 3e-9},
                  {other(0), Evaluation::kBound, 12e-9},
                  {other(2), Evaluation::kStatistical, 4e-9}};
    rms.standard_uncertainty_m = 13e-9;
    const Finding doubt = FirstOf(made.Remarks(), FindingKind::kWideInterval);
    ASSERT_EQ(doubt.numbers.size(), 2U) << k;
    EXPECT_REL(NumberOf(doubt, kNames[k]), 0.85, kRound, "144 / 169, to a hundredth");
    EXPECT_EQ(LargestLine(rms.budget).cause, other(0));
  }
}

TEST(RemarkSegments, SaysWhatHasNotSettledAndHowManyThereAre) {
  Remarked made;
  const Finding ends = FirstOf(made.Remarks(), FindingKind::kSegmentEnds);
  EXPECT_REL(NumberOf(ends, "first_s"), static_cast<double>(made.signal.settled_begin()) / 10e3,
             kRound, "rounding");
  EXPECT_REL(NumberOf(ends, "last_s"),
             static_cast<double>(20'000 - made.signal.settled_end()) / 10e3, kRound, "rounding");
  EXPECT_GT(NumberOf(ends, "first_s"), 0.05) << "a period of the lower corner";
  EXPECT_EQ(NumberOf(ends, "segment_s"), 2);
  EXPECT_FALSE(Has(made, FindingKind::kSegments));
  made.signals = 2;
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kSegments, "segments"), 2);
}

TEST(RemarkSegments, SaysWhatWasInterpolatedAndWhatLiesBelow) {
  Remarked made;
  EXPECT_FALSE(Has(made, FindingKind::kInterpolated));
  made.analysis.record.bridged = 1;
  made.numbers().bridged_rms_m = 4e-9;
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kInterpolated, "interpolated"), 1);
  EXPECT_EQ(NumberOf(made.Remarks(), FindingKind::kInterpolated, "rms_m"), 4e-9);
  for (const bool modelled : {false, true}) {
    made.numbers().below_band = BelowBand{8.3, 5e-4, 1e-8, modelled};
    const Finding below = FirstOf(
        made.Remarks(), modelled ? FindingKind::kBelowBandModelled : FindingKind::kBelowBand);
    EXPECT_EQ(NumberOf(below, "amplitude_m"), 5e-4);
    EXPECT_EQ(NumberOf(below, "frequency_hz"), 8.3);
    EXPECT_EQ(NumberOf(below, "leaked_m"), 1e-8);
  }
}

}  // namespace
}  // namespace haptometer::dsp
