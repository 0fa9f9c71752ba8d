#include "dsp/analysis/sensor_gain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "dsp/spectrum/sine_fit.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"
#include "trial/sensor_head.h"

namespace haptometer::dsp {
namespace {

trial::Metadata Averaging(std::optional<double> sampling_s, std::optional<int> averages) {
  trial::Metadata metadata;
  metadata.sampling_s = sampling_s;
  metadata.averages = averages;
  return metadata;
}

TEST(SensorGain, TheFactorySettingAt225Hz) {
  const SensorAveraging sensor = AveragingOf(Averaging(0.33e-3, 16), 3000, 3000);
  EXPECT_EQ(sensor.knowledge, SensorKnowledge::kKnown);
  EXPECT_ABS(*GainAt(sensor, 225), 0.15, 5e-3, "the facts' digits");
}

TEST(SensorGain, NothingKnownIsSaid) {
  for (const auto& metadata : {Averaging({}, {}), Averaging(1e-3, {}), Averaging({}, 16),
                               Averaging(0.0, 16), Averaging(1e-3, 0)}) {
    const SensorAveraging sensor = AveragingOf(metadata, 1000, 1000);
    EXPECT_EQ(sensor.knowledge, SensorKnowledge::kUnknown);
    EXPECT_EQ(sensor.sampling_s, 0);
    EXPECT_GE(sensor.averages, 1);
    EXPECT_FALSE(GainAt(sensor, 100));
    EXPECT_FALSE(GainsOver(sensor, 20, 500));
  }
}

TEST(SensorGain, OneAverageIsNone) {
  const SensorAveraging sensor = AveragingOf(Averaging({}, 1), 1000, 1000);
  EXPECT_EQ(sensor.knowledge, SensorKnowledge::kNone);
  EXPECT_EQ(*GainAt(sensor, 499), 1);
}

// the oracle: readings held for five rows, and a sine fitted to the rows
TEST(SensorGain, HeldReadingsLoseWhatAFitFinds) {
  const double rate_hz = 5000;
  for (const double hz : {20.0, 123.0, 225.0}) {
    std::vector<double> rows = Samples(rate_hz, 5000, 0, {{1, hz, 0.3}});
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = rows[k - k % 5];
    const SensorAveraging sensor = AveragingOf(Averaging({}, 1), rate_hz, 1000);
    EXPECT_EQ(sensor.repeats, 5);
    const SineFit fit = FitSineAt(rows, {rate_hz, 0}, hz);
    EXPECT_REL(fit.amplitude, *GainAt(sensor, hz), 1e-12, "whole periods: images are orthogonal");
  }
}

TEST(SensorGain, BoundsHoldOverTheBand) {
  const SensorAveraging sensor = AveragingOf(Averaging(0.33e-3, 16), 3000, 3000);
  const auto bounds = GainsOver(sensor, 20, 500);
  ASSERT_TRUE(bounds);
  EXPECT_EQ(bounds->greatest, *GainAt(sensor, 20));
  EXPECT_LT(bounds->least, 1e-3) << "a zero lies in the band";
}

TEST(SensorGain, FewerAveragesThatWouldDo) {
  for (const double hz : {45.0, 90.0, 225.0, 400.0}) {
    const int most = MostAverages(hz, 0.33e-3);
    EXPECT_GE(trial::AveragingGain(hz, 0.33e-3, most), kLeastSensorGain);
    EXPECT_LT(trial::AveragingGain(hz, 0.33e-3, most + 1), kLeastSensorGain);
  }
}

// A ratio within 2 % of a whole number is that number, another one the next above.
TEST(SensorGain, RowsOfAReadingAreAWholeNumber) {
  const auto repeats = [](double ratio) {
    return AveragingOf(Averaging({}, 1), ratio * 1000, 1000).repeats;
  };
  EXPECT_EQ(repeats(1), 1);
  EXPECT_EQ(repeats(1.0199), 1);
  EXPECT_EQ(repeats(1.0202), 2);
  EXPECT_EQ(repeats(2.0398), 2);
  EXPECT_EQ(repeats(2.0402), 3);
  EXPECT_EQ(repeats(1.97), 2);
  EXPECT_EQ(repeats(5.09), 5);
  EXPECT_EQ(repeats(5.11), 6);
  EXPECT_EQ(repeats(0.9), 1);
  const SensorAveraging held = AveragingOf(Averaging({}, 1), 3000, 1000);
  EXPECT_EQ(held.knowledge, SensorKnowledge::kKnown);
  EXPECT_EQ(held.rate_hz, 3000);
}

// averages of 0.5 ms and rows of 0.2 ms, of which a reading fills three
TEST(SensorGain, AveragingAndHoldingMultiply) {
  const SensorAveraging sensor = AveragingOf(Averaging(0.5e-3, 4), 5000, 5000 / 3.0);
  EXPECT_EQ(sensor.averages, 4);
  EXPECT_EQ(sensor.repeats, 3);
  const auto mean = [](int count, double period_s) {
    const double x = std::numbers::pi * 170 * period_s;
    return std::sin(count * x) / (count * std::sin(x));
  };
  EXPECT_REL(*GainAt(sensor, 170), mean(4, 0.5e-3) * mean(3, 0.2e-3), 1e-14, "rounding");
}

// A sine that passes a zero of the gain within the band: its largest value lies at the lower end,
// its least one at the zero, 1 / (4 x 1 ms), or next to it on the grid.
TEST(SensorGain, BoundsAreOfTheWholeBand) {
  const SensorAveraging sensor = AveragingOf(Averaging(1e-3, 4), 10e3, 10e3);
  const auto bounds = GainsOver(sensor, 200, 300);
  ASSERT_TRUE(bounds);
  EXPECT_LT(bounds->least, 1e-12) << "250 Hz is on the grid";
  EXPECT_REL(bounds->greatest, std::max(*GainAt(sensor, 200), *GainAt(sensor, 300)), 1e-13,
             "an end");
  const auto above = GainsOver(sensor, 260, 300);
  EXPECT_REL(above->greatest, *GainAt(sensor, 300), 1e-13, "it rises behind the zero");
  EXPECT_REL(above->least, *GainAt(sensor, 260), 1e-13, "the lower end");
}

TEST(SensorGain, OneAverageIsTheLeast) {
  // 1 / (f T) averages last a period: three of them, of which two leave cos(pi f T) = 0.5
  EXPECT_EQ(MostAverages(1 / (3.01 * 1e-3), 1e-3), 2);
  EXPECT_EQ(MostAverages(1 / (2.99 * 1e-3), 1e-3), 1);
  EXPECT_EQ(MostAverages(5000, 1e-3), 1);
}

}  // namespace
}  // namespace haptometer::dsp
