#include "fit/thinned_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fit/drop_test_fit.h"
#include "fit/ring_start.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

tests::SyntheticDrop Fine() {
  tests::SyntheticDrop drop;
  drop.step_s = 0.26 / 250'000;  // 4300 samples a period
  return drop;
}

PolePair PolesOf(const ImpulseRecord& record) {
  const auto start = FindRingStart(record);
  EXPECT_TRUE(start);
  return start ? start->poles : PolePair{};
}

TEST(ThinnedRecord, KeepsThePolesAndTheAmplitudeToMillionths) {
  const auto record = tests::MakeRecordWithHeight(Fine());
  const auto thinned = Thinned(record, PolesOf(record));
  ASSERT_TRUE(thinned);
  EXPECT_EQ(thinned->block, 4U);
  EXPECT_EQ(thinned->clipped, 0U);
  const auto fit = FitDropTest({thinned->record}, tests::ThesisKnowns());
  ASSERT_TRUE(fit);
  EXPECT_REL(fit->stiffness.value, 2800.0, 1e-11, "a mean keeps the poles");
  EXPECT_REL(fit->damping.value, 0.0322, 1e-11, "a mean keeps the poles");
  // of four samples' mean: sin(4 x)/(4 sin x), x half a sample's phase
  const double lost = std::pow(M_PI / 4272.0, 2) * (4 * 4 - 1) / 6;
  EXPECT_ABS(fit->force_constant.value, 1 - lost, 1e-3 * lost, "4272 is rounded");
}

TEST(ThinnedRecord, ClippedBlocksAreNoMeasurement) {
  auto record = tests::MakeRecord(Fine());
  for (double& v : record.voltage_v) v = std::clamp(v, -0.3, 0.3);
  const auto thinned = Thinned(record, PolesOf(record));
  ASSERT_TRUE(thinned);
  const auto at_limits =
      std::ranges::count_if(record.voltage_v, [](double v) { return std::abs(v) >= 0.3; });
  EXPECT_EQ(thinned->clipped, static_cast<std::size_t>(at_limits));
  const auto lost =
      std::ranges::count_if(thinned->record.voltage_v, [](double v) { return std::isnan(v); });
  EXPECT_GE(4 * lost, at_limits);
}

TEST(ThinnedRecord, WhatAFitHasUseForStays) {
  const auto record = tests::MakeRecord({});
  EXPECT_FALSE(Thinned(record, PolesOf(record)));
  auto drop = Fine();
  drop.length_s = 0.06;  // fine, but short
  const auto brief = tests::MakeRecord(drop);
  EXPECT_FALSE(Thinned(brief, PolesOf(brief)));
}

}  // namespace
}  // namespace haptometer::fit
