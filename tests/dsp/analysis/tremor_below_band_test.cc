// A hand's tremor below the band, on records too short to settle: what is modelled, kept, stated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "dsp/filter/transient.h"
#include "dsp/filter/zero_phase.h"
#include "tests/dsp/analysis/answered.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr double kRootTwo = std::numbers::sqrt2;

TEST(TremorBelowTheBand, StrongTremorOnOneSecondIsModelledAndTheOrderKept) {
  const std::vector<double> in = Samples(kRateHz, 10'000, 0.03, {{1e-6, 100}, {5e-4, 8.3, 0.7}});
  const BandAnalysis analysis = Answer(RecordOf(in, kRateHz));
  ASSERT_TRUE(analysis.answered);
  EXPECT_EQ(analysis.band.order, 6);
  const Finding& below = analysis.findings.list().back();
  EXPECT_EQ(below.kind, FindingKind::kBelowBandModelled);
  EXPECT_REL(NumberOf(below, "amplitude_m"), 5e-4, 1e-4, "the fourth digit");
  EXPECT_REL(NumberOf(below, "frequency_hz"), 8.3, 6e-4, "the third digit");
  EXPECT_REL(NumberOf(below, "leaked_m"), 0.015e-6, 0.034, "the second digit");
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / kRootTwo, 1e-3, "the bar: leakage of order 6");
  EXPECT_LE(analysis.numbers->rms.lower_m, 1e-6 / kRootTwo);
  EXPECT_GE(analysis.numbers->rms.upper_m, 1e-6 / kRootTwo);
}

TEST(TremorBelowTheBand, OneSecondIsTheSameSamplesOfTheFilteredLongRecord) {
  const std::vector<double> whole = Samples(kRateHz, 50'000, 0.03, {{1e-6, 100}, {5e-4, 8.3, 0.7}});
  const std::vector<double> filtered = FilterZeroPhase(Designed({}, kRateHz), whole);
  const BandAnalysis analysis =
      Answer(RecordOf({whole.begin() + 20'000, whole.begin() + 30'000}, kRateHz));
  ASSERT_TRUE(analysis.answered);
  const UsedPart& part = analysis.numbers->part;
  double worst = 0;
  for (std::size_t row = part.first_row; row < part.first_row + part.rows; ++row) {
    worst = std::max(worst, std::abs(analysis.filtered_m[row] - filtered[20'000 + row]));
  }
  EXPECT_ABS(worst / analysis.numbers->rms.rms_m, 0, 1e-4, "the bar; settled to 2.5e-5");
  EXPECT_GT(part.window.duration_s(), 0.4);
}

TEST(TremorBelowTheBand, TheRemedyOfTooShortARecordHelps) {
  const std::vector<double> in = Samples(kRateHz, 19'500, 0.03, {{1e-6, 100}, {5e-4, 8.3, 0.7}});
  const BandAnalysis analysis = Answer(RecordOf(in, kRateHz));
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / kRootTwo, kSettledError,
             "what a settled sample may be wrong by");
}

TEST(TremorBelowTheBand, AnOrderThatWasAskedForIsKept) {
  // 1.4 periods of a slow motion: no model, a lower order where it may be taken
  const std::vector<double> in = Samples(kRateHz, 5'000, 0.03, {{1e-6, 100}, {2e-4, 2.1, 0.7}});
  const BandAnalysis lowered = Answer(RecordOf(in, kRateHz));
  ASSERT_TRUE(lowered.answered);
  EXPECT_LT(lowered.band.order, 6);
  EXPECT_EQ(NumberOf(lowered.findings, FindingKind::kOrderLowered, "asked_order"), 6);
  EXPECT_EQ(NumberOf(lowered.findings, FindingKind::kOrderLowered, "order"), lowered.band.order);
  BandQuestion fixed;
  fixed.may_lower_order = false;
  const BandAnalysis analysis = Answer(RecordOf(in, kRateHz), fixed);
  ASSERT_FALSE(analysis.answered);
  ASSERT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kTooShort));
  const Finding refusal = FirstOf(analysis.findings, FindingKind::kTooShort);
  EXPECT_EQ(NumberOf(refusal, "order"), 6);
  EXPECT_EQ(NumberOf(refusal, "needed_s"), 0.1);
  EXPECT_ABS(NumberOf(refusal, "record_s"), 2.0, 0.05, "the first decimal");
}

TEST(TremorBelowTheBand, TremorThatLeaksIsStated) {
  const std::vector<double> in = Samples(kRateHz, 50'000, 0.03, {{1e-6, 100}, {5e-4, 8.3}});
  BandQuestion question;
  question.band.order = 4;
  question.may_lower_order = false;
  const BandAnalysis analysis = Answer(RecordOf(in, kRateHz), question);
  ASSERT_TRUE(analysis.answered);
  const FilterDesign design = Designed(question.band, kRateHz);
  ASSERT_TRUE(analysis.numbers->below_band);
  EXPECT_REL(analysis.numbers->below_band->leaked_rms_m,
             5e-4 / kRootTwo * std::norm(Response(design, 8.3)), 1e-9, "the tremor's fit");
  // measured with it, stated without it
  EXPECT_REL(analysis.numbers->rms.as_measured_m, 1.287e-6 / kRootTwo, 2e-3,
             "part of a tremor period");
  EXPECT_LE(analysis.numbers->rms.lower_m, 1e-6 / kRootTwo);
  EXPECT_GE(analysis.numbers->rms.upper_m, 1e-6 / kRootTwo);
}

// what leaks of tremor bends a fit by more than noise that is not there
TEST(TremorBelowTheBand, WhatLeaksFromBelowIsInTheTonesUncertainty) {
  for (const double phase : {0.0, 0.7, 1.9}) {
    const trial::Record record =
        RecordOf(Samples(10e3, 47'000, 0.03, {{1e-6, 100, 1}, {5e-4, 8.3, phase}}), 10e3);
    const auto analysis = AnalyzeBand(record, {});
    ASSERT_TRUE(analysis && analysis->numbers && analysis->numbers->tone);
    const ToneNumbers& tone = *analysis->numbers->tone;
    EXPECT_GT(std::abs(tone.fit.frequency_hz - 100), 1e-8) << "else nothing is shown";
    EXPECT_LT(tone.frequency_lower_hz, 100);
    EXPECT_GT(tone.frequency_upper_hz, 100);
    EXPECT_LT(tone.amplitude_lower_m, 1e-6);
    EXPECT_GT(tone.amplitude_upper_m, 1e-6);
    EXPECT_LT(tone.fit.frequency_uncertainty_hz, 1e-4) << "a bound, not a shrug";
  }
}

}  // namespace
}  // namespace haptometer::dsp
