// FollowChannel against records whose vibration follows the drive channel by a known delay.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "dsp/analysis/drive_channel.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

constexpr double kRateHz = 10e3;
constexpr double kToneHz = 225;
constexpr double kDurationS = 9;
constexpr double kNoiseM = 30e-9;

struct Gate {
  double begin_s = 0;
  double end_s = 0;
};
// 1 s apart or more, so that changes correspond for delays of 0.3 s
const std::vector<Gate> kGates{{1.5, 3.0}, {4.2, 5.4}, {6.5, 7.7}};

// shorter than the delay that is tried with them, almost
const std::vector<Gate> kBursts{{1.5, 1.8}, {4.2, 4.5}, {6.5, 6.8}};

bool IsOn(double t_s, const std::vector<Gate>& gates = kGates) {
  bool on = false;
  for (const Gate& gate : gates) on = on || (t_s >= gate.begin_s && t_s < gate.end_s);
  return on;
}

// A vibration of 1 um, `delay_s` behind the gates.
trial::Record Vibration(double delay_s, const std::vector<Gate>& gates = kGates) {
  std::vector<double> values(static_cast<std::size_t>(kDurationS * kRateHz));
  Noise noise(3);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    values[k] = 0.03 + kNoiseM * noise();
    if (IsOn(t_s - delay_s, gates))
      values[k] += 1e-6 * std::sin(2 * std::numbers::pi * kToneHz * t_s);
  }
  return RecordOf(std::move(values), kRateHz);
}

// The record with a channel of volts or a trigger, the value at time t by `value`.
template <typename Value>
trial::Record WithChannel(trial::Record record, trial::ChannelRole role, const Value& value) {
  trial::Channel channel = record.channels[0];
  channel.name = "drive";
  channel.role = role;
  channel.unit = role == trial::ChannelRole::kVoltage ? "V" : "";
  for (std::size_t k = 0; k < record.rows; ++k) {
    channel.values[k] = value(static_cast<double>(k) / kRateHz);
  }
  record.channels.push_back(std::move(channel));
  return record;
}

double Volts(double t_s) {
  return IsOn(t_s) ? 2 * std::sin(2 * std::numbers::pi * kToneHz * t_s) : 0;
}

ChannelCourse Follow(const trial::Record& record) {
  const trial::RecordRows rows(record);
  const Segments segments = SplitAtHoles(rows, 0, {}).value();
  const Segment& segment = segments.parts.at(0);
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segment}, Designed({}, segment.rate_hz), 1).value();
  const auto course = FollowChannel(rows, 1, signal, {}, kToneHz);
  EXPECT_TRUE(course);
  return course ? *course : ChannelCourse{};
}

// The phases at which two sines of 225 Hz are switched are known to 0.25 ms each.
void ExpectDelay(const ChannelCourse& course, double delay_s) {
  ASSERT_TRUE(course.delay);
  std::printf("[delay] %g s: error %.2e s, u %.2e s, %zu changes\n", delay_s,
              course.delay->delay_s - delay_s, course.delay->uncertainty_s, course.delay->changes);
  EXPECT_EQ(course.delay->changes, 2 * kGates.size());
  EXPECT_LE(std::abs(course.delay->delay_s - delay_s), 2 * course.delay->uncertainty_s) << delay_s;
  EXPECT_LT(course.delay->uncertainty_s, 0.5e-3) << delay_s;
}

// Intervals on of the channel, not of the vibration.
void ExpectGates(const ChannelCourse& course) {
  ASSERT_EQ(course.on.size(), kGates.size());
  for (std::size_t k = 0; k < kGates.size(); ++k) {
    EXPECT_NEAR(course.on[k].begin_s, kGates[k].begin_s, 0.01);  // about half a period
    EXPECT_NEAR(course.on[k].end_s, kGates[k].end_s, 0.01);
  }
}

TEST(FollowChannel, ADelayLiesWithinItsUncertainty) {
  for (const double delay_s : {-0.3, 0.0, 0.05, 0.3}) {
    const ChannelCourse course =
        Follow(WithChannel(Vibration(delay_s), trial::ChannelRole::kVoltage, Volts));
    ExpectDelay(course, delay_s);
    ExpectGates(course);
  }
}

TEST(FollowChannel, ATriggerIsFollowedToo) {
  for (const double delay_s : {0.0, 0.05}) {
    const ChannelCourse course =
        Follow(WithChannel(Vibration(delay_s), trial::ChannelRole::kTrigger,
                           [](double t_s) { return IsOn(t_s) ? 5.0 : 0.0; }));
    ExpectDelay(course, delay_s);
    ExpectGates(course);
  }
}

// The vibration rises nearer to the channel's fall than to its rise: like goes with like.
TEST(FollowChannel, RisesCorrespondToRises) {
  const ChannelCourse course =
      Follow(WithChannel(Vibration(0.25, kBursts), trial::ChannelRole::kTrigger,
                         [](double t_s) { return IsOn(t_s, kBursts) ? 5.0 : 0.0; }));
  ExpectDelay(course, 0.25);
}

// Errors over stated uncertainties, of a burst with random delay, frequency, phases and noise.
void ExpectPulls(trial::ChannelRole role, double noise_m) {
  const int repetitions = Repetitions(tests::kIsSanitized ? 20 : 100);
  double squares = 0;
  double sum = 0;
  double uncertainty_s = 0;
  for (int seed = 1; seed <= repetitions; ++seed) {
    Noise noise(static_cast<std::uint64_t>(seed));
    const double delay_s = 0.02 * noise();
    const double tone_hz = 225 + 10 * noise();
    const double begin_s = 1 + 0.05 * noise();
    const double end_s = 2 + 0.05 * noise();
    const double phase = 10 * noise();
    const double volts_phase = 10 * noise();
    const double turn = 2 * std::numbers::pi * tone_hz;
    std::vector<double> values(static_cast<std::size_t>(3 * kRateHz));
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double t_s = static_cast<double>(k) / kRateHz;
      values[k] = noise_m * noise();
      const bool on = t_s - delay_s >= begin_s && t_s - delay_s < end_s;
      if (on) values[k] += 1e-6 * std::sin(turn * t_s + phase);
    }
    const ChannelCourse course =
        Follow(WithChannel(RecordOf(std::move(values), kRateHz), role, [&](double t_s) {
          if (t_s < begin_s || t_s >= end_s) return 0.0;
          return role == trial::ChannelRole::kTrigger ? 5.0 : std::sin(turn * t_s + volts_phase);
        }));
    ASSERT_TRUE(course.delay) << seed;
    const double pull = (course.delay->delay_s - delay_s) / course.delay->uncertainty_s;
    squares += pull * pull / repetitions;
    sum += pull / repetitions;
    uncertainty_s += course.delay->uncertainty_s / repetitions;
  }
  std::printf("[pull] noise %g m: %.2f +- %.2f, u %.2e s\n", noise_m, sum, std::sqrt(squares),
              uncertainty_s);
  // of 100 seeds the root mean square is known to 7 %
  EXPECT_GT(std::sqrt(squares), 0.8);
  EXPECT_LT(std::sqrt(squares), 1.2);
}

TEST(FollowChannel, TheUncertaintyOfADelayIsThatOfItsErrors) {
  for (const double noise_m : {0.0, 0.3e-6, 1e-6}) {
    ExpectPulls(trial::ChannelRole::kVoltage, noise_m);
    ExpectPulls(trial::ChannelRole::kTrigger, noise_m);
  }
}

TEST(FollowChannel, ADeadChannelHasNoDelay) {
  for (const double level_v : {0.0, 0.125}) {
    const ChannelCourse course = Follow(WithChannel(Vibration(0), trial::ChannelRole::kVoltage,
                                                    [&](double /*t_s*/) { return level_v; }));
    EXPECT_FALSE(course.delay) << level_v;
  }
}

// Noise of a dead input: its power changes nowhere.
TEST(FollowChannel, AChannelOfNoiseHasNoDelay) {
  Noise noise(11);
  const ChannelCourse course = Follow(WithChannel(Vibration(0), trial::ChannelRole::kVoltage,
                                                  [&](double /*t_s*/) { return 1e-3 * noise(); }));
  EXPECT_FALSE(course.delay);
}

// Always on: one interval from the first to the last of what has settled, and nothing to compare.
TEST(FollowChannel, AChannelThatIsAlwaysOnHasNoDelay) {
  const ChannelCourse course =
      Follow(WithChannel(Vibration(0), trial::ChannelRole::kVoltage, [](double t_s) {
        return 2 * std::sin(2 * std::numbers::pi * kToneHz * t_s);
      }));
  EXPECT_FALSE(course.delay);
  ASSERT_EQ(course.on.size(), 1U);
  EXPECT_LT(course.on[0].begin_s, 0.5);
  EXPECT_GT(course.on[0].end_s, kDurationS - 0.5);
}

}  // namespace
}  // namespace haptometer::dsp
