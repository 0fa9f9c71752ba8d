// FollowChannel against records whose vibration follows the drive channel by a known delay.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "dsp/analysis/drive_channel.h"
#include "dsp/readings/segments.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/repetitions.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

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

// ---- Uncertainties of a delay without noise, by differences in which all else cancels.

constexpr double kPi = std::numbers::pi;

// A vibration of 1 um that lasts as the gates, each `delays_s` later.
trial::Record SilentVibration(const std::vector<double>& delays_s) {
  std::vector<double> values(static_cast<std::size_t>(kDurationS * kRateHz), 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    bool on = false;
    for (std::size_t gate = 0; gate < kGates.size(); ++gate) {
      on = on || IsOn(t_s - delays_s[gate], {kGates[gate]});
    }
    if (on) values[k] = 1e-6 * std::sin(2 * kPi * kToneHz * t_s);
  }
  return RecordOf(std::move(values), kRateHz);
}

// the variance of the delay, the tone taken for `tone_hz`
double VarianceOf(const trial::Record& record, double tone_hz) {
  const trial::RecordRows rows(record);
  const Segments segments = SplitAtHoles(rows, 0, {}).value();
  const BandSignal signal =
      BandSignal::Filter({rows, 0, segments.parts.at(0)}, Designed({}, kRateHz), 1).value();
  const ChannelCourse course = FollowChannel(rows, 1, signal, {}, tone_hz).value();
  EXPECT_TRUE(course.delay);
  return course.delay ? course.delay->uncertainty_s * course.delay->uncertainty_s : 0;
}

double OfPhase(double tone_hz) { return 1 / (4 * kPi * tone_hz * std::numbers::sqrt2); }

// The median of six differences has pi / 2 times the variance of their mean.
constexpr double kOfSix = kPi / 2 / 6;

// A voltage's change and the vibration's are each uncertain by 1 / (4 pi f sqrt(2)).
TEST(FollowChannel, APhaseThatIsUnknownIsInTheUncertainty) {
  const trial::Record record =
      WithChannel(SilentVibration({0, 0, 0}), trial::ChannelRole::kVoltage, Volts);
  const double expected = kOfSix * 2 * (std::pow(OfPhase(150), 2) - std::pow(OfPhase(225), 2));
  EXPECT_REL(VarianceOf(record, 150) - VarianceOf(record, 225), expected, 1e-9,
             "a difference of variances");
}

// A trigger's is not filtered: (1 / d1 + 1 / d2) / (4 pi^2), d the tone's distances to the corners.
// Its own change is sharp, and the vibration's has half of the variance that it has beside its
// like.
TEST(FollowChannel, ATriggersChangeIsDelayedByTheFilterAtMost) {
  const trial::Record motion = SilentVibration({0, 0, 0});
  const double of_voltage =
      VarianceOf(WithChannel(motion, trial::ChannelRole::kVoltage, Volts), kToneHz);
  const trial::Record trigger = WithChannel(motion, trial::ChannelRole::kTrigger,
                                            [](double t_s) { return IsOn(t_s) ? 5.0 : 0.0; });
  const auto filter = [](double below_hz, double above_hz) {
    return (1 / below_hz + 1 / above_hz) / (4 * kPi * kPi);
  };
  EXPECT_REL(2 * VarianceOf(trigger, kToneHz) - of_voltage,
             2 * kOfSix * std::pow(filter(205, 275), 2), 0.01, "rounding of the cells' places");
  // 30 Hz lies 10 Hz above the corner, 490 Hz as far below: 20 Hz is the least that counts
  for (const double tone_hz : {30.0, 490.0}) {
    const double change = kOfSix * (std::pow(filter(20, 470), 2) + std::pow(OfPhase(tone_hz), 2) -
                                    std::pow(filter(205, 275), 2) - std::pow(OfPhase(kToneHz), 2));
    EXPECT_REL(VarianceOf(trigger, tone_hz) - VarianceOf(trigger, kToneHz), change, 1e-9,
               "a difference of variances");
  }
}

// Noise of the power q of the step adds (w / B) q (1 + q), w a period of 20 Hz and B 480 Hz. Here
// it is a second tone that never pauses; what both turn by in 50 ms are whole half periods.
TEST(FollowChannel, PowerThatNeverPausesIsInTheUncertainty) {
  trial::Record record = SilentVibration({0, 0, 0});
  for (std::size_t k = 0; k < record.rows; ++k) {
    const double t_s = static_cast<double>(k) / kRateHz;
    record.channels[0].values[k] = (IsOn(t_s) ? 1e-6 * std::sin(2 * kPi * 220 * t_s) : 0) +
                                   std::sqrt(0.5) * 1e-6 * std::sin(2 * kPi * 120 * t_s);
  }
  const trial::Record driven =
      WithChannel(std::move(record), trial::ChannelRole::kVoltage,
                  [](double t_s) { return IsOn(t_s) ? 2 * std::sin(2 * kPi * 220 * t_s) : 0; });
  const double noise = 0.05 / 480 * 0.5 * 1.5;
  EXPECT_REL(VarianceOf(driven, 220), kOfSix * (2 * std::pow(OfPhase(220), 2) + noise), 0.01,
             "56 cells of 0.9 ms stand for 50 ms; what rings in the filter");
}

// Differences of 44.4, 48.9 and 53.3 ms, whole half periods: their own scatter counts (Birge).
TEST(FollowChannel, DelaysThatScatterAreUncertainByTheirScatter) {
  constexpr double kHalfPeriod = 0.5 / kToneHz;
  const trial::Record record =
      WithChannel(SilentVibration({20 * kHalfPeriod, 22 * kHalfPeriod, 24 * kHalfPeriod}),
                  trial::ChannelRole::kVoltage, Volts);
  const ChannelCourse course = Follow(record);
  ASSERT_TRUE(course.delay);
  EXPECT_EQ(course.delay->changes, 6U);
  EXPECT_NEAR(course.delay->delay_s, 22 * kHalfPeriod, 5e-5);  // what rings in the filter
  // two are 2 half periods below, two above the median; five degrees of freedom
  const double variance = kOfSix * 4 * std::pow(2 * kHalfPeriod, 2) / 5;
  EXPECT_REL(std::pow(course.delay->uncertainty_s, 2), variance, 0.03, "1.5 % of a difference");
}

// ---- A channel of few levels beside a vibration that never pauses.

trial::Record Unceasing() {
  return RecordOf(
      Samples(kRateHz, static_cast<std::size_t>(kDurationS * kRateHz), 0, {{1e-6, kToneHz}}),
      kRateHz);
}

// the channel is 0 but from 2 s to 2.6 s, where it takes two values in turn
std::vector<TimeWindow> OnOf(double one_v, double other_v, double resolution_v) {
  int turn = 0;
  trial::Record record = WithChannel(Unceasing(), trial::ChannelRole::kVoltage, [&](double t_s) {
    if (t_s < 2 || t_s >= 2.6) return 0.0;
    return ++turn % 2 == 0 ? one_v : other_v;
  });
  record.channels[1].resolution = resolution_v;
  return Follow(record).on;
}

TEST(FollowChannel, OfTwoStepsTheVibrationSaysWhetherItIsADrive) {
  // 0 and 1, 0 to 2 steps: flickers, and on throughout; 0 to 3: on where it says so
  for (const auto& on : {OnOf(1e-3, 1e-3, 0), OnOf(1e-3, 2e-3, 0), OnOf(1e-3, 1e-3, 0.5e-3)}) {
    ASSERT_EQ(on.size(), 1U);
    EXPECT_NEAR(on[0].begin_s, 0, 1e-9);
    EXPECT_NEAR(on[0].end_s, kDurationS, 1e-3);  // a cell
  }
  for (const auto& on : {OnOf(2e-3, 3e-3, 0), OnOf(1.5e-3, 1.5e-3, 0.5e-3)}) {
    ASSERT_EQ(on.size(), 1U);
    EXPECT_NEAR(on[0].begin_s, 2, 0.005);  // half of the power, by cells
    EXPECT_NEAR(on[0].end_s, 2.6, 0.005);
  }
}

// What flickers by its last digit is 0: a burst of 0.2 s, less than the 5 % of the record that give
// the top of its power, is on although the digit is so for 4 s.
TEST(FollowChannel, PowerOfOneStepIsNone) {
  for (const double flicker_v : {1e-3, 1.01e-3}) {
    trial::Record record = WithChannel(Unceasing(), trial::ChannelRole::kVoltage, [&](double t_s) {
      if (t_s >= 6 && t_s < 6.2) return 10e-3;
      return t_s >= 1 && t_s < 5 ? flicker_v : 0;
    });
    record.channels[1].resolution = 1e-3;
    const std::vector<TimeWindow> on = Follow(record).on;
    ASSERT_EQ(on.size(), flicker_v > 1e-3 ? 2U : 1U);
    EXPECT_NEAR(on.back().begin_s, 6, 0.03);  // half of the mean's 50 ms
  }
}

// ---- FollowDrive: the part from 1.2 s on of a vibration that never pauses, and a trigger that is
// on from 1 s to 3.5 s.

struct Followed {
  explicit Followed(double end_s, bool may_cut = true, double begin_s = 1.2) {
    record = WithChannel(Unceasing(), trial::ChannelRole::kTrigger,
                         [](double t_s) { return t_s >= 1 && t_s < 3.5 ? 5.0 : 0.0; });
    const trial::RecordRows rows(record);
    const Segments segments = SplitAtHoles(rows, 0, {}).value();
    const BandSignal signal =
        BandSignal::Filter({rows, 0, segments.parts.at(0)}, Designed({}, kRateHz), 1).value();
    chosen.signal = &signal;
    chosen.begin = static_cast<std::size_t>(std::lround(begin_s * kRateHz));
    chosen.end = static_cast<std::size_t>(std::lround(end_s * kRateHz));
    chosen.excluded = {{15'000, 16'000}, {40'000, 41'000}};
    chosen.part.from_drive = true;
    chosen.part.state.from_hz = chosen.part.state.to_hz = kToneHz;
    EXPECT_TRUE(FollowDrive(rows, may_cut, chosen, &analysis));
    chosen.signal = nullptr;
  }
  [[nodiscard]] bool IsContradicted() const {
    return analysis.findings.Has(FindingKind::kDriveContradicted);
  }

  trial::Record record;
  ChosenPart chosen;
  BandAnalysis analysis;
};

// Off for a period of 20 Hz, 50 ms, at most is what the filter rings. A cell lasts 0.9 ms.
TEST(FollowDrive, AChannelThatIsOffForMoreThanAPeriodContradicts) {
  EXPECT_FALSE(Followed(3.5485).IsContradicted());
  const Followed off(3.5515, false);
  const Finding doubt = FirstOf(off.analysis.findings, FindingKind::kDriveContradicted);
  EXPECT_EQ(doubt.severity, Severity::kDoubt);
  EXPECT_EQ(doubt.subject, "drive");
  EXPECT_ABS(NumberOf(doubt, "off_s"), 0.0515, 1e-3, "a cell");
  EXPECT_REL(NumberOf(doubt, "from_s"), 1.2, 1e-12, "rounding");
  EXPECT_REL(NumberOf(doubt, "to_s"), 3.5515, 1e-12, "rounding");
  EXPECT_EQ(off.chosen.end, 35'515U) << "a window that was asked for stays";
}

TEST(FollowDrive, ThePartIsCutToAPeriodWithinTheChannel) {
  const Followed cut(4.5);
  EXPECT_EQ(cut.chosen.begin, 12'000U);
  EXPECT_ABS(static_cast<double>(cut.chosen.end), 34'500, 10, "3.5 s less 50 ms, to a cell");
  ASSERT_EQ(cut.chosen.excluded.size(), 1U) << "the bump at 4 s lies outside";
  EXPECT_EQ(cut.chosen.excluded[0].first, 15'000U);
  const Followed both(4.5, true, 0.6);
  EXPECT_ABS(static_cast<double>(both.chosen.begin), 10'500, 10, "1 s and 50 ms, to a cell");
}

// 2.3 s on are half of 4.6 s.
TEST(FollowDrive, HalfOfThePartMustBeOn) {
  EXPECT_LT(Followed(5.78).chosen.end, 35'000U);
  const Followed less(5.82);
  EXPECT_EQ(less.chosen.end, 58'200U);
  EXPECT_TRUE(less.IsContradicted());
}

// A delay beyond a period of 20 Hz, 50 ms.
TEST(FollowDrive, ALongDelayIsNoted) {
  for (const double delay_s : {0.048, -0.048, 0.052, -0.052}) {
    const trial::Record record = WithChannel(SilentVibration({delay_s, delay_s, delay_s}),
                                             trial::ChannelRole::kVoltage, Volts);
    const trial::RecordRows rows(record);
    const Segments segments = SplitAtHoles(rows, 0, {}).value();
    const BandSignal signal =
        BandSignal::Filter({rows, 0, segments.parts.at(0)}, Designed({}, kRateHz), 1).value();
    ChosenPart chosen{&signal, 17'000, 29'000};
    chosen.part.from_drive = true;
    chosen.part.state.from_hz = kToneHz - 3;
    chosen.part.state.to_hz = kToneHz + 3;
    BandAnalysis analysis;
    ASSERT_TRUE(FollowDrive(rows, true, chosen, &analysis));
    ASSERT_TRUE(chosen.delay);
    EXPECT_NEAR(chosen.delay->delay_s, delay_s, 5e-4);
    const bool is_long = std::abs(delay_s) > 0.05;
    ASSERT_EQ(analysis.findings.Has(FindingKind::kDriveDelayed), is_long) << delay_s;
    if (!is_long) continue;
    const Finding note = FirstOf(analysis.findings, FindingKind::kDriveDelayed);
    EXPECT_EQ(NumberOf(note, "delay_s"), chosen.delay->delay_s);
    EXPECT_EQ(NumberOf(note, "uncertainty_s"), chosen.delay->uncertainty_s);
  }
}

TEST(DriveChannel, IsAVoltageBeforeACurrentBeforeATrigger) {
  trial::Record record = RecordOf({0, 0}, kRateHz);
  EXPECT_FALSE(DriveChannel(record));
  using enum trial::ChannelRole;
  for (const auto& [role, expected] :
       {std::pair(kTrigger, 1U), {kCurrent, 2U}, {kVoltage, 3U}, {kCurrent, 3U}, {kVoltage, 3U}}) {
    trial::Channel channel;
    channel.role = role;
    record.channels.push_back(channel);
    EXPECT_EQ(DriveChannel(record), expected);
  }
}

}  // namespace
}  // namespace haptometer::dsp
