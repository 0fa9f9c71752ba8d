// What would halve the interval of an RMS, against its budget.
#include "tools/analyze/halving.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/residual.h"

namespace haptometer::tools {
namespace {

using dsp::Evaluation;
using dsp::RmsCause;

// an RMS of 10 um over 4 s, with the parts of its budget in um
dsp::BandAnalysis Analysed(double noise, double floor, double drift, bool has_file) {
  dsp::BandAnalysis analysis;
  analysis.answered = true;
  dsp::BandNumbers& numbers = analysis.numbers.emplace();
  numbers.part.window = {1, 5};
  dsp::RmsEstimate& rms = numbers.rms;
  rms.rms_m = 10e-6;
  rms.standard_uncertainty_m = std::hypot(noise, floor, drift) * 1e-6;
  rms.lower_m = rms.rms_m - 1.96 * rms.standard_uncertainty_m;
  rms.upper_m = rms.rms_m + 1.96 * rms.standard_uncertainty_m;
  rms.budget = {{RmsCause::kNoise, Evaluation::kStatistical, noise * 1e-6},
                {RmsCause::kNoiseFloor, Evaluation::kStatistical, floor * 1e-6},
                {RmsCause::kDrift, Evaluation::kBound, drift * 1e-6}};
  if (has_file) {
    numbers.floor.emplace().duration_s = 10;
    numbers.floor->from = dsp::NoiseSource::kFile;
  }
  return analysis;
}

// variances fall as 1 / length: four times as long
TEST(HowToHalve, NoiseAloneNeedsFourTimesTheLength) {
  const Halving halving = HowToHalve(*Analysed(0.3, 0, 0, false).numbers);
  EXPECT_REL(*halving.window_s, 16, 1e-12, "a quotient");
  EXPECT_FALSE(halving.floor_s.has_value());
}

TEST(HowToHalve, TheUncertaintyAtTheLengthIsHalf) {
  const auto analysis = Analysed(0.5, 0.3, 0.2, true);
  const Halving halving = HowToHalve(*analysis.numbers);
  // 0.095 - 0.09 - 0.04 is below 0
  EXPECT_FALSE(halving.window_s.has_value());
  EXPECT_FALSE(halving.floor_s.has_value());
  const Halving better = HowToHalve(*Analysed(0.1, 0.5, 0.1, true).numbers);
  const double floor = 0.25 * 10 / *better.floor_s;
  EXPECT_REL(0.01 + floor + 0.01, (0.01 + 0.25 + 0.01) / 4, 1e-12, "the budget's squares");
  const Halving longer = HowToHalve(*Analysed(0.5, 0.1, 0.1, true).numbers);
  EXPECT_REL(0.25 * 4 / *longer.window_s + 0.02, 0.27 / 4, 1e-12, "the budget's squares");
}

TEST(HowToHalve, WhatNoLengthChangesIsNamed) {
  const Halving halving = HowToHalve(*Analysed(0.1, 0, 0.4, false).numbers);
  EXPECT_FALSE(halving.window_s.has_value());
  EXPECT_EQ(halving.largest, RmsCause::kDrift);
}

std::string_view KindOf(const dsp::BandAnalysis& analysis) {
  document::Section section;
  AddHalving(analysis, "", section);
  return section.findings.empty() ? "" : section.findings.front().kind;
}

TEST(AddHalving, IsSaidOfWideIntervalsAlone) {
  EXPECT_EQ(KindOf(Analysed(0.3, 0, 0, false)), "interval-halved-by-length");
  EXPECT_EQ(KindOf(Analysed(0.1, 0.5, 0.1, true)), "interval-halved-by-floor");
  EXPECT_EQ(KindOf(Analysed(0.1, 0, 0.4, false)), "interval-not-halved");
  EXPECT_EQ(KindOf(Analysed(0.04, 0, 0, false)), "");  // +-0.8 %
  auto refused = Analysed(0.3, 0, 0, false);
  refused.answered = false;
  EXPECT_EQ(KindOf(refused), "");
}

}  // namespace
}  // namespace haptometer::tools
