// The amplifier as its own reference, through the emulator, on a manual clock.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <random>

#include "acquire/emulator/dl_unit.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "tests/acquire/device_transport.h"
#include "tests/residual.h"
#include "tools/calibrate/calibration_answer.h"
#include "tools/calibrate/reference_points.h"

namespace haptometer::tools {
namespace {

namespace emulator = acquire::emulator;
using ::testing::HasSubstr;

constexpr double kGain = 0.9985;
constexpr double kOffsetV = 1.2e-3;

// A DAQ at the analog output: lines of volts at 200 Hz with 2 mV of noise, on the same clock, late
// by `delay_s`.
class VirtualDaq final : public acquire::Transport {
 public:
  VirtualDaq(Clock& clock, emulator::MovingHead head, unsigned seed, double delay_s)
      : clock_(clock), head_(std::move(head)), engine_(seed), delay_s_(delay_s) {}

  acquire::ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override {
    for (; next_ <= clock_.Now(); next_ += 5'000'000) {
      const double volts =
          emulator::AnalogVolts(head_.head, head_.displacement(SecondsFromNs(next_) - delay_s_));
      waiting_ += fmt::format("{:.6f}\n", volts + 2e-3 * normal_(engine_));
    }
    if (waiting_.empty()) {
      clock_.SleepUntil(deadline);
      return {acquire::ReadState::kTimeout, 0};
    }
    const std::size_t taken = std::min(waiting_.size(), buffer.size());
    std::copy_n(waiting_.begin(), taken, buffer.begin());
    waiting_.erase(0, taken);
    return {acquire::ReadState::kBytes, taken};
  }
  Result<void> Write(std::string_view /*bytes*/, MonotonicNs /*deadline*/) override { return {}; }
  std::string Source() const override { return "virtual DAQ"; }
  const std::string& name() const override { return name_; }

 private:
  Clock& clock_;
  emulator::MovingHead head_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  double delay_s_;
  MonotonicNs next_ = 0;
  std::string waiting_;
  std::string name_ = "daq";
};

struct Run {
  Result<ReferencePoints> found;
  trial::Metadata reference;
};

// what is measured of a target that moves as `displacement` says, by an IL-030 of 16 averages
Run Measure(trial::Displacement displacement, unsigned seed, StillQuestion question = {},
            double delay_s = 0) {
  ManualClock clock;
  const emulator::MovingHead head{.head = trial::Il030(),
                                  .displacement = std::move(displacement),
                                  .seed = seed,
                                  .analog = {.gain_error = kGain, .offset_error_v = kOffsetV}};
  emulator::DlRs1aUnit unit({.baud = 38400, .head = head});
  acquire::KeyenceIl amplifier(std::make_unique<tests::DeviceTransport>(unit, clock),
                               {.baud = 38400}, clock);
  const std::atomic<bool> stop = false;
  EXPECT_TRUE(amplifier.Start(stop));
  VirtualDaq daq(clock, head, seed + 1000, delay_s);
  auto found = CollectPoints(amplifier, daq, clock, stop, question,
                             [](WindowState, const ReferencePoints&) {});
  return {std::move(found), amplifier.header().metadata};
}

// seven places from -4 to 4 mm, each held for `held_s`, 0.5 s of motion between them
double StairsOf(double t_s, double held_s) {
  constexpr double kPlaces[] = {0, 2e-3, 4e-3, 1.3e-3, -1.3e-3, -4e-3, -2e-3, 0};
  const double step_s = held_s + 0.5;
  const auto place = static_cast<std::size_t>(std::clamp(t_s / step_s, 0.0, 6.0));
  const double in_step_s = t_s - step_s * static_cast<double>(place);
  const double moved = std::clamp((in_step_s - held_s) / 0.5, 0.0, 1.0);
  return std::lerp(kPlaces[place], kPlaces[place + 1], place == 6 ? 0 : moved);
}

double Stairs(double t_s) { return StairsOf(t_s, 4.5); }

TEST(CalibrateReference, GainAndOffsetOfTheDaqAreFoundAndTheirIntervalsHold) {
  int daq_held = 0;
  int gain_held = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto run = Measure(Stairs, seed);
    ASSERT_TRUE(run.found) << run.found.error().Text();
    ASSERT_EQ(run.found->points.size(), 7U) << seed;
    const auto points = PointsOf(*run.found, run.reference, 7);
    ASSERT_TRUE(points);
    const auto answer = AnswerOf(*points);
    ASSERT_TRUE(answer && answer->daq);
    const fit::StraightLine& daq = answer->daq->line;
    const fit::StraightLine& gain = answer->fit.line;
    EXPECT_REL(daq.slope, kGain, 1e-3, "the bar: 0.1 %");
    EXPECT_REL(gain.slope, 1e-3, 1e-3, "the bar: 0.1 %");
    EXPECT_ABS(daq.intercept, kOffsetV, 3e-3, "noise of seven means: 1 um is 1 mV");
    daq_held += std::abs(daq.slope - kGain) < daq.coverage_95 * daq.slope_uncertainty ? 1 : 0;
    gain_held += std::abs(gain.slope - 1e-3) < gain.coverage_95 * gain.slope_uncertainty ? 1 : 0;
  }
  // 95 % of 200 and 2.6 standard deviations of a binomial
  EXPECT_GE(daq_held, 182);
  EXPECT_LE(daq_held, 197);
  EXPECT_GE(gain_held, 182);
  EXPECT_LE(gain_held, 197);
  RecordProperty("daq_held", daq_held);
  RecordProperty("gain_held", gain_held);
}

TEST(CalibrateReference, EveryPointIsAPlaceAtRest) {
  const auto run = Measure(Stairs, 7);
  ASSERT_TRUE(run.found);
  constexpr double kPlaces[] = {0, 2e-3, 4e-3, 1.3e-3, -1.3e-3, -4e-3, -2e-3};
  for (std::size_t i = 0; i < run.found->points.size(); ++i) {
    EXPECT_ABS(run.found->points[i].displacement_m.mean, kPlaces[i], 5e-6, "noise of a mean");
  }
  EXPECT_GT(run.found->moving, 0U);
  EXPECT_EQ(run.reference.averages, 16);
  EXPECT_EQ(run.reference.head, "IL-030");
}

// A DAQ's buffer: its samples of the place before are still when the amplifier is at the next one.
TEST(CalibrateReference, ADaqThatIsLateIsNotPairedWithTheWrongPlace) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto run = Measure([](double t_s) { return StairsOf(t_s, 8); }, seed, {}, 2);
    ASSERT_TRUE(run.found);
    const auto points = PointsOf(*run.found, run.reference, 7);
    ASSERT_TRUE(points);
    const auto answer = AnswerOf(*points);
    ASSERT_TRUE(answer);
    EXPECT_LT(answer->fit.nonlinearity, 10e-6) << "places lie 1.3 mm and more apart";
  }
}

TEST(CalibrateReference, ATargetThatMovesIsNotAccepted) {
  const StillQuestion question{.timeout_s = 60};
  const std::pair<const char*, trial::Displacement> motions[] = {
      {"a ramp of 0.1 mm/s", [](double t_s) { return -4e-3 + 1e-4 * t_s; }},
      {"a creep of 20 um/s", [](double t_s) { return 2e-5 * t_s; }},
      {"a swing of 0.1 mm at 0.4 Hz", [](double t_s) { return 1e-4 * std::sin(2.5 * t_s); }},
      {"vibration of 50 um", [](double t_s) { return 5e-5 * std::sin(2 * 3.14159 * 7.3 * t_s); }},
      {"steps each 0.9 s", [](double t_s) { return 1e-3 * std::fmod(std::floor(t_s / 0.9), 5); }}};
  for (const auto& [name, motion] : motions) {
    const auto run = Measure(motion, 3, question);
    ASSERT_TRUE(run.found);
    EXPECT_TRUE(run.found->points.empty()) << name;
    const auto points = PointsOf(*run.found, run.reference, 7);
    ASSERT_FALSE(points);
    EXPECT_THAT(points.error().Text(), HasSubstr("0 of 7 points were still: the target moved"));
  }
}

TEST(CalibrateReference, AProgramThatEndedIsTold) {
  ReferencePoints without;
  without.input_ended = true;
  const auto points = PointsOf(without, {}, 7);
  ASSERT_FALSE(points);
  EXPECT_THAT(points.error().Text(), HasSubstr("--input: its program ended after 0 of 7 points"));
  // samples that end at once
  struct Ended final : acquire::Transport {
    acquire::ReadOutcome Read(std::span<char>, MonotonicNs) override {
      return {acquire::ReadState::kGone, 0};
    }
    Result<void> Write(std::string_view, MonotonicNs) override { return {}; }
    std::string Source() const override { return "none"; }
    const std::string& name() const override { return name_; }
    std::string name_ = "none";
  } none;
  ManualClock clock;
  emulator::DlRs1aUnit unit(
      {.baud = 38400, .head = {.head = trial::Il030(), .displacement = Stairs}});
  acquire::KeyenceIl amplifier(std::make_unique<tests::DeviceTransport>(unit, clock),
                               {.baud = 38400}, clock);
  const std::atomic<bool> stop = false;
  const auto found =
      CollectPoints(amplifier, none, clock, stop, {}, [](WindowState, const ReferencePoints&) {});
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->input_ended);
}

TEST(CalibrateReference, TheErrorLevelIsNamedAndIsNoReading) {
  // beyond the measuring range of 10 mm
  const auto run = Measure([](double /*t_s*/) { return 11e-3; }, 3, {.timeout_s = 20});
  ASSERT_TRUE(run.found);
  EXPECT_TRUE(run.found->points.empty());
  EXPECT_GT(run.found->error_level, 0U);
  const auto points = PointsOf(*run.found, run.reference, 7);
  ASSERT_FALSE(points);
  EXPECT_THAT(points.error().Text(), HasSubstr("+5.5 V, the amplifier's error level"));
}

TEST(CalibrateReference, OnePlaceIsOnePoint) {
  const auto run = Measure([](double /*t_s*/) { return 1e-3; }, 3, {.timeout_s = 20});
  ASSERT_TRUE(run.found);
  EXPECT_EQ(run.found->points.size(), 1U);
  EXPECT_THAT(PointsOf(*run.found, run.reference, 7).error().Text(),
              HasSubstr("the target stayed where it was"));
}

}  // namespace
}  // namespace haptometer::tools
