// Which rows are chosen and what is said of them, through AnalyzeBand; the oracle is the record's
// making.
#include "dsp/analysis/window/window_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/analysis/window/made_window.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr double kPi = std::numbers::pi;

// 4 s of level(t) sin(2 pi turns(t)) in 10 nm of noise
trial::Record Turning(const std::function<double(double)>& level,
                      const std::function<double(double)>& turns) {
  std::vector<double> values(8000);
  Noise noise(3);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    values[k] = 0.03 + level(t_s) * std::sin(2 * kPi * turns(t_s)) + 1e-8 * noise();
  }
  return RecordOf(std::move(values), kRateHz);
}

double Steady(double t_s) { return 217 * t_s; }

// on from 1 s to 3 s
trial::Record Gated() {
  return Turning([](double t_s) { return t_s >= 1 && t_s < 3 ? 10e-6 : 0; }, Steady);
}

BandQuestion Given(double begin_s, double end_s) {
  BandQuestion question;
  question.choice = WindowChoice::kGiven;
  question.window = {begin_s, end_s};
  return question;
}

TEST(GivenWindow, OfADriveAndItsPauseIsMixed) {
  const trial::Record record = Gated();
  const BandAnalysis inside = Answer(record, Given(1.5, 2.5));
  EXPECT_FALSE(inside.findings.Has(FindingKind::kWindowMixed));
  EXPECT_FALSE(inside.findings.Has(FindingKind::kDriveOffInWindow));
  EXPECT_TRUE(inside.numbers->part.from_drive);
  const BandAnalysis mixed = Answer(record, Given(1.5, 3.5));
  const Finding doubt = FirstOf(mixed.findings, FindingKind::kWindowMixed);
  EXPECT_EQ(doubt.severity, Severity::kDoubt);
  EXPECT_REL(NumberOf(doubt, "window_s"), 2.0, 1e-12, "both ends are rows");
  EXPECT_ABS(NumberOf(doubt, "off_s"), 0.5, 0.075, "a block of 50 ms, and the filter's ringing");
  EXPECT_FALSE(mixed.numbers->part.from_drive);
}

TEST(GivenWindow, BesideADriveIsOff) {
  const BandAnalysis off = Answer(Gated(), Given(3.2, 3.7));
  EXPECT_TRUE(off.findings.Has(FindingKind::kDriveOffInWindow));
  EXPECT_FALSE(off.findings.Has(FindingKind::kWindowMixed));
  // where nothing is on at all there is no doubt
  const BandAnalysis none = Answer(Turning([](double) { return 0; }, Steady), Given(1.5, 2.5));
  EXPECT_FALSE(none.findings.Has(FindingKind::kDriveOffInWindow));
}

// What has not settled is left out, and said from two samples on.
TEST(GivenWindow, IsCutToWhatHasSettled) {
  const trial::Record record = Turning([](double) { return 10e-6; }, Steady);
  const BandAnalysis cut = Answer(record, Given(0, 2));
  const Finding note = FirstOf(cut.findings, FindingKind::kWindowShortened);
  EXPECT_EQ(note.severity, Severity::kNote);
  const double settled_s = cut.numbers->part.window.begin_s;
  EXPECT_GT(settled_s, 0.02);
  EXPECT_REL(NumberOf(note, "excluded_s"), settled_s, 1e-9, "a difference of times");
  EXPECT_EQ(NumberOf(note, "from_s"), 0);
  EXPECT_EQ(NumberOf(note, "to_s"), 2);
  EXPECT_FALSE(
      Answer(record, Given(settled_s - 0.9e-3, 2)).findings.Has(FindingKind::kWindowShortened));
  EXPECT_TRUE(
      Answer(record, Given(settled_s - 1.1e-3, 2)).findings.Has(FindingKind::kWindowShortened));
  EXPECT_EQ(cut.numbers->part.why.kind, FindingKind::kWindowAsked);
}

// Two periods of 20 Hz are 0.1 s.
TEST(GivenWindow, HoldsTwoPeriodsOfTheLowerCorner) {
  const trial::Record record = Turning([](double) { return 10e-6; }, Steady);
  EXPECT_TRUE(Answer(record, Given(2, 2.1)).answered);
  const BandAnalysis refused = Answer(record, Given(2, 2.0995));
  EXPECT_THAT(RefusalsIn(refused.findings), ::testing::ElementsAre(FindingKind::kWindowNotSettled));
  EXPECT_REL(NumberOf(refused.findings, FindingKind::kWindowNotSettled, "settled_s"), 0.0995, 1e-12,
             "199 rows");
}

// An amplitude that changes evenly by `change` of its mean over the record's 4 s; the state is of
// what has settled.
TEST(UnsteadyDrive, AChangeOfTheAmplitudeIsADoubtBeyondTwoPercent) {
  for (const double change : {-0.1, 0.018, 0.03, 0.1}) {
    const BandAnalysis analysis =
        Answer(Turning([&](double t_s) { return 10e-6 * (1 + change * (t_s / 4 - 0.5)); }, Steady));
    ASSERT_TRUE(analysis.answered) << change;
    const TimeWindow& time = analysis.numbers->part.state.time;
    const double middle_s = 0.5 * (time.begin_s + time.end_s);
    const double drift = change * time.duration_s() / 4 / (1 + change * (middle_s / 4 - 0.5));
    EXPECT_ABS(analysis.numbers->part.state.drift, drift, 1e-4, "10 nm of noise over 2500 values");
    const bool is_told = std::abs(drift) > 0.02;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kDriveUnsteady), is_told) << drift;
    if (!is_told) continue;
    EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kDriveUnsteady, "drift"),
              analysis.numbers->part.state.drift);
  }
}

// From 200 Hz by `change` of it over 4 s.
TEST(UnsteadyDrive, AFrequencyDriftsBeyondAPercentAndMovesBeyondTen) {
  for (const double change : {0.0095, 0.0135, 0.10, 0.14}) {
    const BandAnalysis analysis =
        Answer(Turning([](double) { return 10e-6; },
                       [&](double t_s) { return 200 * t_s * (1 + change * t_s / 8); }));
    ASSERT_TRUE(analysis.answered) << change;
    const StateInterval& state = analysis.numbers->part.state;
    const auto at = [&](double t_s) { return 200 * (1 + change * t_s / 4); };
    EXPECT_ABS(state.from_hz, at(state.time.begin_s), 0.05, "half a sample of the blocks' time");
    EXPECT_ABS(state.to_hz, at(state.time.end_s), 0.05, "half a sample of the blocks' time");
    const double moved = at(state.time.end_s) / at(state.time.begin_s) - 1;
    const bool moves = moved > 0.1;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kFrequencyMoves), moves) << moved;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kFrequencyDrifts), moved > 0.01 && !moves)
        << moved;
    if (moved < 0.01) continue;
    const FindingKind kind = moves ? FindingKind::kFrequencyMoves : FindingKind::kFrequencyDrifts;
    EXPECT_EQ(NumberOf(analysis.findings, kind, "from_hz"), state.from_hz);
    EXPECT_EQ(NumberOf(analysis.findings, kind, "to_hz"), state.to_hz);
  }
}

// A phase that swings by b about an even one leaves J0(b) of the amplitude in one sine through
// whole swings: 0.99 at 0.2, 0.94 at 0.5, 0.22 at 2.
TEST(UnsteadyDrive, AFrequencyThatVariesLeavesJ0OfTheAmplitudeInOneSine) {
  for (const double swing : {0.0, 0.2, 0.5, 1.2}) {
    const BandAnalysis analysis =
        Answer(Turning([](double) { return 10e-6; },
                       [&](double t_s) {
                         const double turns = std::sin(2 * std::numbers::pi * 2 * t_s);
                         return 200 * t_s + swing * turns / (2 * std::numbers::pi);
                       }));
    ASSERT_TRUE(analysis.answered) << swing;
    EXPECT_EQ(analysis.findings.Has(FindingKind::kToneVaries), swing >= 0.5) << swing;
    if (swing < 0.5) continue;
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kToneVaries, "level_m"), 10e-6, 0.01,
               "the phase's curvature over a block");
    EXPECT_REL(NumberOf(analysis.findings, FindingKind::kToneVaries, "amplitude_m"),
               10e-6 * std::cyl_bessel_j(0.0, swing), 0.02, "a tenth of a swing in 3.5 s");
  }
}

// a bump of 8 um at 30 Hz from `bump_s` on, on a drive that is on throughout
trial::Record Bumped(double bump_s) {
  trial::Record record = Turning([](double) { return 10e-6 * std::numbers::sqrt2; }, Steady);
  for (std::size_t k = 0; k < record.rows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz - bump_s;
    if (t_s < 0) continue;
    record.channels[0].values[k] += 8e-6 * std::exp(-t_s / 0.03) * std::sin(2 * kPi * 30 * t_s);
  }
  return record;
}

TEST(BumpsOfAWindow, AreCountedAndTimed) {
  const BandAnalysis analysis = Answer(Bumped(2.2));
  ASSERT_TRUE(analysis.answered);
  const Finding note = FirstOf(analysis.findings, FindingKind::kBumpsExcluded);
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_EQ(NumberOf(note, "count"), 1);
  ASSERT_EQ(analysis.numbers->excluded.size(), 1U);
  const TimeWindow& bump = analysis.numbers->excluded[0];
  EXPECT_LE(bump.begin_s, 2.2);
  EXPECT_GE(bump.end_s, 2.3) << "it is below 4 % then";
  EXPECT_REL(NumberOf(note, "from_s"), bump.begin_s, 1e-12, "rounding");
  EXPECT_REL(NumberOf(note, "excluded_s"), bump.duration_s(), 1e-12, "rounding");
  EXPECT_REL(analysis.numbers->rms.rms_m, 10e-6, 2e-4, "10 nm of noise, and what the bump leaves");
}

// Blocks count from where the signal has settled, here 0.2 s after its begin.
TEST(BumpsOfAWindow, AreSeenFromItsFirstBlockOn) {
  for (const double bump_s : {0.25, 0.32, 3.6}) {
    const BandAnalysis analysis = Answer(Bumped(bump_s));
    ASSERT_TRUE(analysis.answered) << bump_s;
    // it would add 0.5 um^2 s to 350 um^2 s: 7e-4 of the RMS
    EXPECT_REL(analysis.numbers->rms.rms_m, 10e-6, 2e-4, "what the bump leaves") << bump_s;
  }
}

TEST(TimeOfSample, CountsFromTheSegmentsStart) {
  MadeWindow made(TwoSeconds());
  made.segments.parts[0].start_s = 3;
  EXPECT_REL(TimeOfSample(made.signal, 2500), 3.25, 1e-15, "rounding");
  const std::size_t settled = made.signal.settled_begin();
  ASSERT_GT(settled, 100U);
  const auto within = [&](double begin_s, double end_s) {
    return SettledWithin(made.signal, {begin_s, end_s});
  };
  EXPECT_EQ(within(4, 4.5), std::make_pair(std::size_t{10'000}, std::size_t{15'000}));
  EXPECT_EQ(within(4.00004, 4.50006), std::make_pair(std::size_t{10'000}, std::size_t{15'001}))
      << "the nearest samples";
  EXPECT_EQ(within(3, 4), std::make_pair(settled, std::size_t{10'000}));
  EXPECT_EQ(within(4, 9), std::make_pair(std::size_t{10'000}, made.signal.settled_end()));
  EXPECT_EQ(within(4, 3.9), std::make_pair(std::size_t{10'000}, std::size_t{10'000}));
}

// 1.5 s of a tone of `share` of the drive that follows it, 10 um at 217 Hz
BandAnalysis BehindATone(double tone_hz, double share) {
  const BandAnalysis analysis =
      Answer(Turning([&](double t_s) { return t_s < 1.5 ? share * 10e-6 : 10e-6; },
                     [&](double t_s) { return t_s < 1.5 ? tone_hz * t_s : Steady(t_s); }));
  EXPECT_TRUE(analysis.answered && analysis.numbers) << tone_hz << ' ' << share;
  return analysis;
}

std::size_t QuietBehind(double tone_hz, double share) {
  const BandAnalysis analysis = BehindATone(tone_hz, share);
  if (!analysis.numbers) return 0;
  EXPECT_ABS(analysis.numbers->part.state.from_hz, 217, 1, "the longer state is the drive");
  return analysis.numbers->part.quiet.size();
}

// A steady tone may be there all the time: one of less than half of the drive, or one below it
// that is more than 8 Hz away.
TEST(QuietInterval, HoldsATonePerhapsBesideTheDrive) {
  EXPECT_EQ(QuietBehind(222, 0.48), 1U);
  EXPECT_EQ(QuietBehind(222, 0.52), 0U);
  EXPECT_EQ(QuietBehind(228, 0.52), 1U);
  EXPECT_EQ(QuietBehind(36, 0.95), 1U);
  EXPECT_EQ(QuietBehind(36, 1.05), 0U);
}

// Of a tone that the drive's window does not have, nothing is subtracted.
TEST(QuietInterval, OfAToneThatEndsWithItIsNoNoise) {
  for (const double tone_hz : {36.0, 100.0, 300.0}) {
    const BandAnalysis analysis = BehindATone(tone_hz, 0.5);
    ASSERT_TRUE(analysis.numbers && analysis.numbers->floor);
    EXPECT_EQ(analysis.numbers->floor->from, NoiseSource::kBeside) << tone_hz;
  }
}

}  // namespace
}  // namespace haptometer::dsp
