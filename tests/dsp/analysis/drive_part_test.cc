#include "dsp/analysis/drive_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "dsp/filter/zero_phase.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 2e3;
constexpr double kRms = 1e-6;

// amplitude of a 150 Hz tone over time, in white noise of `noise`, band-passed, in cells of 10 rows
struct Vibration {
  std::vector<double> filtered;
  std::vector<double> cells;

  [[nodiscard]] PowerCourse course() const { return {cells, 0, 10 / kRateHz}; }
};

Vibration Vibrating(double duration_s, const std::function<double(double)>& rms_at, double noise,
                    std::uint64_t seed) {
  const auto rows = static_cast<std::size_t>(duration_s * kRateHz);
  std::vector<double> values = Samples(kRateHz, rows, 0, {{std::sqrt(2.0), 150, 0.4}});
  Noise gaussian(seed);
  for (std::size_t k = 0; k < rows; ++k) {
    values[k] = values[k] * rms_at(static_cast<double>(k) / kRateHz) + noise * gaussian();
  }
  Vibration vibration;
  vibration.filtered = FilterZeroPhase(Designed({}, kRateHz), values);
  for (std::size_t k = 0; k + 10 <= rows; k += 10) {
    double sum = 0;
    for (std::size_t i = k; i < k + 10; ++i) {
      sum += vibration.filtered[i] * vibration.filtered[i] / 10;
    }
    vibration.cells.push_back(sum);
  }
  return vibration;
}

DriveParts PartsOf(const Vibration& vibration) { return FindDriveParts(vibration.course(), {}); }

double MeanSquare(const Vibration& vibration, const TimeWindow& window) {
  double sum = 0;
  std::size_t count = 0;
  for (auto k = static_cast<std::size_t>(std::ceil(window.begin_s * kRateHz));
       static_cast<double>(k) < window.end_s * kRateHz; ++k, ++count) {
    sum += vibration.filtered[k] * vibration.filtered[k];
  }
  return sum / static_cast<double>(count);
}

TEST(DrivePart, TwoOfThreeSecondsGiveTheOnPartsRms) {
  const auto gate = [](double t_s) { return t_s >= 0.5 && t_s < 2.5 ? kRms : 0; };
  for (const double noise : {0.0, 1e-9, 1e-7, 1e-6}) {
    const Vibration vibration = Vibrating(3, gate, noise, 3);
    const DriveParts parts = PartsOf(vibration);
    ASSERT_EQ(parts.course, DriveCourse::kGated) << noise;
    ASSERT_EQ(parts.on.size(), 1U) << noise;
    const TimeWindow steady = parts.on[0].steady;
    EXPECT_ABS(parts.on[0].whole.begin_s, 0.5, 0.06, "one block");
    EXPECT_ABS(parts.on[0].whole.end_s, 2.5, 0.06, "one block");
    EXPECT_GT(steady.duration_s(), 1.6) << noise;
    EXPECT_TRUE(parts.on[0].is_steady);
    // white noise's share in the band is 0.47 of its power
    const double power = kRms * kRms + 0.47 * noise * noise;
    EXPECT_REL(MeanSquare(vibration, steady), power, noise == 1e-6 ? 0.15 : 0.02, "noise; edges");
    ASSERT_EQ(parts.quiet.size(), 2U) << noise;
    EXPECT_LT(parts.quiet[0].end_s, 0.45);
    EXPECT_GT(parts.quiet[1].begin_s, 2.55);
  }
}

TEST(DrivePart, AToneUnderItsFloorIsStillFound) {
  const auto gate = [](double t_s) { return t_s >= 1 && t_s < 3 ? kRms : 0; };
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    // floor in band 1.18 times the tone: 5.9 um under 5 um
    const DriveParts parts = PartsOf(Vibrating(4, gate, 1.18e-6 / std::sqrt(0.47), seed));
    if (parts.course != DriveCourse::kGated) continue;
    ++found;
    EXPECT_ABS(parts.Longest()->whole.begin_s, 1, 0.16, "three blocks");
  }
  EXPECT_GE(found, 39);
}

TEST(DrivePart, AlwaysOnAndNeverOnKeepOneLevel) {
  for (const double rms : {kRms, 0.0}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const DriveParts parts = PartsOf(Vibrating(2, [&](double) { return rms; }, 0.3e-6, seed));
      EXPECT_EQ(parts.course, DriveCourse::kUnchanging) << seed;
      EXPECT_TRUE(parts.on.empty() && parts.quiet.empty());
    }
  }
  const auto steady = [](double) { return kRms; };
  EXPECT_EQ(PartsOf(Vibrating(2, steady, 0, 1)).why.value().kind, FindingKind::kOneLevel);
}

TEST(DrivePart, SeveralBurstsAreCountedAndTheLongestTaken) {
  const auto bursts = [](double t_s) {
    const bool on = (t_s > 1 && t_s < 1.5) || (t_s > 2 && t_s < 3) || (t_s > 4 && t_s < 4.3);
    return on ? kRms : 0;
  };
  const DriveParts parts = PartsOf(Vibrating(5, bursts, 0.2e-6, 9));
  ASSERT_EQ(parts.on.size(), 3U);
  EXPECT_EQ(parts.Longest(), &parts.on[1]);
  EXPECT_EQ(parts.why.value().kind, FindingKind::kStandsOut);
  EXPECT_EQ(NumberOf(*parts.why, "parts"), 3);
}

TEST(DrivePart, AKnockIsNoDrive) {
  const auto knock = [](double t_s) { return t_s > 1 && t_s < 1.02 ? 20 * kRms : 0; };
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const DriveParts parts = PartsOf(Vibrating(3, knock, 0.2e-6, seed));
    EXPECT_EQ(parts.course, DriveCourse::kUnchanging) << seed;
    EXPECT_TRUE(parts.on.empty()) << seed;
  }
}

TEST(DrivePart, OnsetAndDecayAreNotSteady) {
  const auto slow = [](double t_s) {
    if (t_s < 0.5) return 0.0;
    return t_s < 2.5 ? kRms * (1 - std::exp(-(t_s - 0.5) / 0.08))
                     : kRms * std::exp(-(t_s - 2.5) / 0.08);
  };
  const Vibration vibration = Vibrating(3, slow, 0.01e-6, 2);
  const DriveParts parts = PartsOf(vibration);
  ASSERT_FALSE(parts.on.empty());
  const TimeWindow steady = parts.Longest()->steady;
  EXPECT_GT(steady.begin_s, 0.7);
  EXPECT_LT(steady.end_s, 2.51);
  EXPECT_REL(MeanSquare(vibration, steady), kRms * kRms, 0.01, "what is left of the onset");
}

TEST(DrivePart, ARampIsNotSteady) {
  const auto ramp = [](double t_s) { return t_s < 1 ? 0 : kRms * (0.5 + 0.25 * (t_s - 1)); };
  const DriveParts parts = PartsOf(Vibrating(3, ramp, 0.02e-6, 2));
  ASSERT_FALSE(parts.on.empty());
  EXPECT_FALSE(parts.Longest()->is_steady);
  EXPECT_GT(parts.Longest()->drift, 0.1);
}

TEST(DrivePart, ADriveChannelDecides) {
  // the tone decays slowly after the drive has ended; a second, stronger disturbance is not driven
  const auto motion = [](double t_s) {
    if (t_s > 3.2 && t_s < 4) return 3 * kRms;
    if (t_s < 1) return 0.0;
    return t_s < 2.5 ? kRms : kRms * std::exp(-(t_s - 2.5) / 0.1);
  };
  const Vibration vibration = Vibrating(4, motion, 0.05e-6, 4);
  std::vector<double> volts(vibration.cells.size(), 0.0);
  for (std::size_t k = 0; k < volts.size(); ++k) {
    const double t_s = static_cast<double>(k) * 10 / kRateHz;
    if (t_s >= 1 && t_s < 2.5) volts[k] = 12.5;
  }
  const DriveParts parts = FindDriveParts({volts, 0, 10 / kRateHz}, vibration.course(), {});
  ASSERT_EQ(parts.on.size(), 1U);
  EXPECT_ABS(parts.on[0].whole.begin_s, 1, 1e-9, "a block's edge");
  EXPECT_ABS(parts.on[0].whole.end_s, 2.5, 1e-9, "a block's edge");
  EXPECT_REL(parts.on[0].mean_square, kRms * kRms, 0.02, "noise and edges");
}

TEST(DrivePart, ShortOrSilentRecordsHaveNoParts) {
  EXPECT_EQ(FindDriveParts({{}, 0, 1e-3}, {}).why.value().kind, FindingKind::kTooShortForParts);
  const std::vector<double> silence(2000, 0.0);
  EXPECT_EQ(FindDriveParts({silence, 0, 1e-3}, {}).course, DriveCourse::kUnchanging);
}

}  // namespace
}  // namespace haptometer::dsp
