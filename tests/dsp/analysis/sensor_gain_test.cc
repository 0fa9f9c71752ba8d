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
  for (const auto& metadata : {Averaging({}, {}), Averaging(1e-3, {}), Averaging({}, 16)}) {
    const SensorAveraging sensor = AveragingOf(metadata, 1000, 1000);
    EXPECT_EQ(sensor.knowledge, SensorKnowledge::kUnknown);
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

}  // namespace
}  // namespace haptometer::dsp
