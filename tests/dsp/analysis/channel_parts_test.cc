#include "dsp/analysis/channel_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "trial/row_source.h"

namespace haptometer::dsp {
namespace {

constexpr double kChannelRateHz = 5e3;
constexpr std::size_t kChannelRows = 15000;
constexpr TimeWindow kUsedWindow{0.3, 2.7};

// 3 V at 60 Hz, or at `level` all the time, where `on` says
trial::Record ChannelOn(const std::vector<TimeWindow>& on, trial::ChannelRole role,
                        double level = 0) {
  const std::vector<double> tone = Samples(kChannelRateHz, kChannelRows, 0, {{3, 60, 0.2}});
  std::vector<double> values(kChannelRows, 0);
  for (std::size_t k = 0; k < kChannelRows; ++k) {
    const double t_s = static_cast<double>(k) / kChannelRateHz;
    for (const TimeWindow& part : on) {
      if (t_s >= part.begin_s && t_s < part.end_s) values[k] = level > 0 ? level : tone[k];
    }
  }
  trial::Record record = RecordOf(std::vector<double>(kChannelRows, 0), kChannelRateHz);
  trial::Channel channel = record.channels[0];
  channel.role = role;
  channel.values = std::move(values);
  record.channels.push_back(std::move(channel));
  return record;
}

std::vector<TimeWindow> ChannelPartsOf(const trial::Record& record,
                                       const TimeWindow& used = kUsedWindow) {
  const trial::RecordRows rows(record);
  const auto parts = FindChannelParts(rows, BandPass{}, used);
  EXPECT_TRUE(parts);
  return parts ? *parts : std::vector<TimeWindow>{};
}

TEST(ChannelParts, HaveTheirTimesToAMillisecond) {
  const std::vector<TimeWindow> on{{0.0374, 0.2212}, {1.031, 1.071}, {2.9, 3.0}};
  const std::vector<TimeWindow> parts = ChannelPartsOf(ChannelOn(on, trial::ChannelRole::kVoltage));
  ASSERT_EQ(parts.size(), on.size());
  for (std::size_t k = 0; k < on.size(); ++k) {
    // a cell, and a tenth of a half wave in which the voltage is near zero
    EXPECT_NEAR(parts[k].begin_s, on[k].begin_s, 2.5e-3) << k;
    EXPECT_NEAR(parts[k].end_s, on[k].end_s, 2.5e-3) << k;
  }
}

TEST(ChannelParts, AreNoneWhereTheUsedWindowLiesInOne) {
  EXPECT_TRUE(
      ChannelPartsOf(ChannelOn({{0.1, 1}}, trial::ChannelRole::kVoltage), {0.3, 0.9}).empty());
  EXPECT_FALSE(
      ChannelPartsOf(ChannelOn({{0.1, 1}}, trial::ChannelRole::kVoltage), {0.3, 1.1}).empty());
}

TEST(ChannelParts, AreNoneOfADriveThatIsNeverOff) {
  EXPECT_TRUE(ChannelPartsOf(ChannelOn({{0, 3}}, trial::ChannelRole::kVoltage)).empty());
  // half of the time, all along
  std::vector<TimeWindow> pulses;
  for (int k = 0; k < 30; ++k) pulses.push_back({0.1 * k, 0.1 * k + 0.05});
  EXPECT_TRUE(ChannelPartsOf(ChannelOn(pulses, trial::ChannelRole::kVoltage)).empty());
}

TEST(ChannelParts, ASpikeIsNone) {
  trial::Record record = ChannelOn({}, trial::ChannelRole::kVoltage);
  record.channels[1].values[7000] = 5;
  record.channels[1].values[7001] = -2;
  record.channels[1].values[9000] = 3.1;
  EXPECT_TRUE(ChannelPartsOf(record).empty());
}

TEST(ChannelParts, AShortTriggerMarksTheStart) {
  EXPECT_TRUE(ChannelPartsOf(ChannelOn({{0, 0.1}}, trial::ChannelRole::kTrigger, 5)).empty());
  EXPECT_EQ(ChannelPartsOf(ChannelOn({{0, 0.25}}, trial::ChannelRole::kTrigger, 5)).size(), 1U);
}

// its gate is behind the gap throughout
TEST(ChannelParts, ATriggerCountsFromItsLeastOfAllRows) {
  trial::Record record = ChannelOn({{2, 3}}, trial::ChannelRole::kTrigger, 5);
  record.stretches = {{0, 10000, 0, kChannelRateHz, 0}, {10000, 5000, 2.5, kChannelRateHz, 0}};
  const std::vector<TimeWindow> parts = ChannelPartsOf(record, {0.3, 1.7});
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].begin_s, 2.5, 1e-3);
}

}  // namespace
}  // namespace haptometer::dsp
