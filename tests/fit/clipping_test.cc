#include "fit/clipping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace haptometer::fit {
namespace {

constexpr double kPeriodSamples = 40;

// a ring-down of amplitude 1 and Q = 60, rounded to `step` and cut at `limit`
std::vector<double> RingDown(double step, double limit) {
  std::vector<double> values;
  for (int n = 0; n < 1200; ++n) {
    const double angle = 2 * std::numbers::pi * n / kPeriodSamples;
    double v = std::exp(-angle / 120) * std::sin(angle + 0.3);
    if (step > 0) v = std::round(v / step) * step;
    values.push_back(std::clamp(v, -limit, limit));
  }
  return values;
}

std::size_t Masked(std::vector<double> values) { return MaskRails(values, kPeriodSamples); }

TEST(MaskRails, LeavesWholePeaksAlone) {
  EXPECT_EQ(Masked(RingDown(0, 2)), 0U);
  for (const double step : {1e-4, 0.0078125, 0.1}) {
    SCOPED_TRACE(step);
    EXPECT_EQ(Masked(RingDown(step, 2)), 0U) << "a rounded peak is flat for a while";
  }
}

TEST(MaskRails, TakesOutEverySampleAtALimit) {
  for (const double step : {0.0, 0.0078125}) {
    SCOPED_TRACE(step);
    auto values = RingDown(step, 0.796875);  // whole steps of 1/128
    const auto at_limit = static_cast<std::size_t>(
        std::ranges::count_if(values, [](double v) { return std::abs(v) == 0.796875; }));
    EXPECT_EQ(MaskRails(values, kPeriodSamples), at_limit);
    EXPECT_GT(at_limit, 20U);
    EXPECT_EQ(static_cast<std::size_t>(
                  std::ranges::count_if(values, [](double v) { return std::isnan(v); })),
              at_limit);
  }
}

TEST(MaskRails, OneLimitAloneIsEnough) {
  auto values = RingDown(0, 2);
  for (double& v : values) v = std::min(v, 0.8);
  EXPECT_GT(MaskRails(values, kPeriodSamples), 10U);
  EXPECT_LT(*std::ranges::min_element(values), -0.85) << "the other side is whole";
}

TEST(MaskRails, AConstantRecordHasNoRails) {
  EXPECT_EQ(Masked(std::vector<double>(100, 1.0)), 0U);
  EXPECT_EQ(Masked({}), 0U);
}

TEST(ConverterStep, IsTheDistanceOfNeighbouringCodes) {
  EXPECT_DOUBLE_EQ(ConverterStep(RingDown(0.0078125, 2)), 0.0078125);
  EXPECT_EQ(ConverterStep(RingDown(0, 2)), 0) << "not rounded";
  EXPECT_EQ(ConverterStep({1, 1, 1}), 0) << "one value has no neighbour";
  EXPECT_DOUBLE_EQ(ConverterStep({0, 2, 6, std::nan("")}), 2) << "codes may be missing";
  EXPECT_EQ(ConverterStep({0, 2, 5}), 0) << "2.5 steps of 2 are none";
}

}  // namespace
}  // namespace haptometer::fit
