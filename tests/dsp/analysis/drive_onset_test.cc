// Onset and latency through AnalyzeBand; the oracle is the closed form of the rise.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr std::size_t kRows = 30'000;
constexpr double kToneHz = 225;
constexpr double kOnS = 1.03374;  // between two rows
constexpr double kOffS = 2.5;
constexpr double kRiseTauS = 0.02;
const double kTenthS = -kRiseTauS * std::log(0.9);  // from the drive to 10 %

double Turn(double t_s, double phase) {
  return std::sin(2 * std::numbers::pi * kToneHz * t_s + phase);
}

// 10 um (1 - exp(-(t - on) / tau)) on 30 mm and 50 um of tremor, with noise
trial::Record Rising(double phase, double noise_m = 5e-8, std::uint64_t seed = 5) {
  std::vector<double> values = Samples(kRateHz, kRows, 0.03, {{5e-5, 8.3, 0.7}});
  Noise noise(seed);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    if (t_s >= kOnS && t_s < kOffS) {
      values[k] += 1e-5 * (1 - std::exp(-(t_s - kOnS) / kRiseTauS)) * Turn(t_s, phase);
    }
    values[k] += noise_m * noise();
  }
  return RecordOf(std::move(values), kRateHz);
}

template <typename Value>
void AddChannel(trial::Record& record, trial::ChannelRole role, const std::string& unit,
                const Value& value) {
  trial::Channel channel = record.channels[0];
  channel.name = Name(role);
  channel.role = role;
  channel.unit = unit;
  for (std::size_t k = 0; k < record.rows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    channel.values[k] = value(t_s, t_s >= kOnS && t_s < kOffS);
  }
  record.channels.push_back(std::move(channel));
}

TEST(DriveOnset, ARiseAfterAVoltageHasItsLatencyWithinWhatIsStated) {
  for (int k = 0; k < 8; ++k) {
    const double phase = k * std::numbers::pi / 4;
    trial::Record record = Rising(phase);
    Noise noise(6);
    AddChannel(record, trial::ChannelRole::kVoltage, "V", [&](double t_s, bool on) {
      return 0.2 + 0.01 * noise() + (on ? 2 * Turn(t_s, phase + 1) : 0);
    });
    const auto analysis = AnalyzeBand(record, {});
    ASSERT_TRUE(analysis && analysis->answered && analysis->numbers->onset);
    const OnsetNumbers& onset = *analysis->numbers->onset;
    EXPECT_ABS(onset.edge.time_s, kOnS + kTenthS, 2 * onset.edge.time_uncertainty_s, "as stated");
    ASSERT_TRUE(onset.drive_s && onset.latency_s);
    EXPECT_ABS(*onset.drive_s, kOnS, 2 * onset.drive_uncertainty_s, "the interval, and noise");
    EXPECT_LT(onset.drive_uncertainty_s, 1e-4);
    EXPECT_ABS(*onset.latency_s, kTenthS, 2 * onset.latency_uncertainty_s, "as stated");
    EXPECT_LT(onset.latency_uncertainty_s, 2e-3);
    EXPECT_REL(*onset.edge.rise_s, kRiseTauS * std::log(9), 0.05, "the window's own rise");
  }
}

// 0.5 um of noise, any phase of the tone; all but that of the rise contain bounds
TEST(DriveOnset, IntervalsUnderNoiseHoldTheTruth) {
  const int repetitions = Repetitions(12);
  int onset_held = 0;
  int drive_held = 0;
  int latency_held = 0;
  int rise_held = 0;
  for (int k = 1; k <= repetitions; ++k) {
    const double phase = 0.7 * k;
    const auto seed = static_cast<std::uint64_t>(k);
    trial::Record record = Rising(phase, 5e-7, seed);
    Noise noise(seed + 1'000'000);
    AddChannel(record, trial::ChannelRole::kVoltage, "V", [&](double t_s, bool on) {
      return 0.2 + 0.01 * noise() + (on ? 2 * Turn(t_s, phase + 1) : 0);
    });
    const auto analysis = AnalyzeBand(record, {});
    ASSERT_TRUE(analysis && analysis->answered && analysis->numbers->onset) << k;
    const OnsetNumbers& onset = *analysis->numbers->onset;
    ASSERT_TRUE(onset.drive_s && onset.latency_s && onset.edge.rise_s) << k;
    const auto holds = [](double value, double truth, double uncertainty) {
      return std::abs(value - truth) <= 1.96 * uncertainty ? 1 : 0;
    };
    onset_held += holds(onset.edge.time_s, kOnS + kTenthS, onset.edge.time_uncertainty_s);
    drive_held += holds(*onset.drive_s, kOnS, onset.drive_uncertainty_s);
    latency_held += holds(*onset.latency_s, kTenthS, onset.latency_uncertainty_s);
    rise_held += holds(*onset.edge.rise_s, kRiseTauS * std::log(9), onset.edge.rise_uncertainty_s);
  }
  ExpectCoverage("onset", onset_held, repetitions, 100);
  ExpectCoverage("drive's begin", drive_held, repetitions, 100);
  ExpectCoverage("latency", latency_held, repetitions, 100);
  ExpectCoverage("rise", rise_held, repetitions);
}

TEST(DriveOnset, ATriggerIsKnownToARow) {
  trial::Record record = Rising(0.3);
  AddChannel(record, trial::ChannelRole::kTrigger, "V",
             [](double, bool on) { return on ? 5.0 : 0.0; });
  const auto analysis = AnalyzeBand(record, {});
  ASSERT_TRUE(analysis && analysis->numbers->onset && analysis->numbers->onset->drive_s);
  const OnsetNumbers& onset = *analysis->numbers->onset;
  EXPECT_ABS(*onset.drive_s, kOnS, 0.5 / kRateHz + 1e-12, "half a row");
  EXPECT_ABS(onset.drive_uncertainty_s, 0.5 / kRateHz / std::numbers::sqrt3, 1e-12, "a row");
}

TEST(DriveOnset, WithoutADriveChannelThereIsNoLatency) {
  const auto analysis = AnalyzeBand(Rising(0), {});
  ASSERT_TRUE(analysis && analysis->numbers->onset);
  EXPECT_FALSE(analysis->numbers->onset->drive_s);
  EXPECT_FALSE(analysis->numbers->onset->latency_s);
}

TEST(DriveOnset, IsNotDeterminedWithoutAQuietPartBefore) {
  const auto analysis = AnalyzeBand(RecordOf(Samples(kRateHz, kRows, 0, {{1e-5, 225}}), 1e4), {});
  ASSERT_TRUE(analysis && analysis->answered);
  EXPECT_FALSE(analysis->numbers->onset);
  EXPECT_EQ(analysis->numbers->part.why.kind, FindingKind::kOneState);
}

TEST(DriveOnset, ANoisyVoltageTellsNoLatency) {
  trial::Record record = Rising(0);
  Noise noise(6);
  AddChannel(record, trial::ChannelRole::kVoltage, "V",
             [&](double t_s, bool on) { return noise() + (on ? 2 * Turn(t_s, 0) : 0); });
  const auto analysis = AnalyzeBand(record, {});
  ASSERT_TRUE(analysis && analysis->numbers->onset);
  EXPECT_FALSE(analysis->numbers->onset->drive_s);
}

// The first row at which |value| exceeds `limit`, from the row of the drive's begin on.
std::size_t FirstBeyond(const trial::Record& record, double rest, double limit) {
  std::size_t row = 10'338;  // kOnS
  while (std::abs(record.channels[1].values[row] - rest) <= limit) ++row;
  return row;
}

// A sine of 2 V about 0.2 V that begins at any phase: the row before the first beyond a tenth of
// it, and asin(0.1) / pi periods, are the interval whose middle is stated.
TEST(DriveOnset, OfACleanVoltageIsARowAndTheSinesWayToATenth) {
  for (int k = 0; k < 8; ++k) {
    const double phase = k * std::numbers::pi / 4;
    trial::Record record = Rising(0);
    AddChannel(record, trial::ChannelRole::kVoltage, "V",
               [&](double t_s, bool on) { return 0.2 + (on ? 2 * Turn(t_s, phase) : 0); });
    const auto analysis = AnalyzeBand(record, {});
    ASSERT_TRUE(analysis && analysis->numbers->onset && analysis->numbers->onset->drive_s);
    const OnsetNumbers& onset = *analysis->numbers->onset;
    const double width_s = (1 + std::asin(0.1) / std::numbers::pi * kRateHz / kToneHz) / kRateHz;
    EXPECT_REL(onset.drive_uncertainty_s, width_s / 2 / std::numbers::sqrt3, 1e-4,
               "rows beside the crests, the tone's fit");
    const auto row = static_cast<double>(FirstBeyond(record, 0.2, 0.2));
    EXPECT_ABS(*onset.drive_s, row / kRateHz - width_s / 2, 2e-8, "the same");
    EXPECT_ABS(*onset.latency_s, onset.edge.time_s - *onset.drive_s, 1e-15, "a difference");
    EXPECT_REL(onset.latency_uncertainty_s,
               std::hypot(onset.edge.time_uncertainty_s, onset.drive_uncertainty_s), 1e-15,
               "of both");
  }
}

// At rest the voltage takes +-0.15 V: the drive begins beyond twice that. Up to half of the drive's
// 2 V it is told from rest.
TEST(DriveOnset, TwiceTheVoltageAtRestIsItsLimit) {
  for (const double rest_v : {0.15, 0.495, 0.505}) {
    trial::Record record = Rising(0);
    int turn = 0;
    AddChannel(record, trial::ChannelRole::kVoltage, "V", [&](double t_s, bool on) {
      return on ? 2 * Turn(t_s, 1) : ++turn % 2 == 0 ? rest_v : -rest_v;
    });
    const auto analysis = AnalyzeBand(record, {});
    ASSERT_TRUE(analysis && analysis->numbers->onset);
    const OnsetNumbers& onset = *analysis->numbers->onset;
    ASSERT_EQ(onset.drive_s.has_value(), rest_v < 0.5) << rest_v;
    if (!onset.drive_s) continue;
    const double width_s = (1 + std::asin(rest_v) / std::numbers::pi * kRateHz / kToneHz) / kRateHz;
    EXPECT_REL(onset.drive_uncertainty_s, width_s / 2 / std::numbers::sqrt3, 1e-3,
               "the mean of some thousand rows at rest, crests");
    const auto row = static_cast<double>(FirstBeyond(record, 0, 2 * rest_v));
    EXPECT_ABS(*onset.drive_s, row / kRateHz - width_s / 2, 1e-7, "the same");
  }
}

// The steady amplitude is that of the drive's own window, of 0.4 s here, not of a second.
TEST(DriveOnset, OfAShortDriveIsThatOfItsOwnLevel) {
  std::vector<double> values(kRows, 0.03);
  Noise noise(5);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    if (t_s >= kOnS && t_s < kOnS + 0.5) {
      values[k] += 1e-5 * (1 - std::exp(-(t_s - kOnS) / kRiseTauS)) * Turn(t_s, 0.4);
    }
    values[k] += 5e-9 * noise();
  }
  const auto analysis = AnalyzeBand(RecordOf(std::move(values), kRateHz), {});
  ASSERT_TRUE(analysis && analysis->answered && analysis->numbers->onset);
  const Edge& edge = analysis->numbers->onset->edge;
  EXPECT_REL(edge.steady_amplitude, 1e-5, 0.02, "what the rise has not reached");
  EXPECT_ABS(edge.time_s, kOnS + kTenthS, 2 * edge.time_uncertainty_s, "as stated");
  ASSERT_TRUE(edge.rise_s);
  EXPECT_REL(*edge.rise_s, kRiseTauS * std::log(9), 0.05, "the window's own rise");
}

}  // namespace
}  // namespace haptometer::dsp
