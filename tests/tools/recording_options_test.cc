// The options of a recording: what is understood, and what is refused before anything is touched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/input_file.h"
#include "tools/acquire/recording.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using acquire::TriggerKind;
using ::testing::HasSubstr;

// --- the wall's time ---------------------------------------------------------------------------

class WallTime : public ::testing::Test {
 protected:
  void TearDown() override { Zone("UTC"); }
  static void Zone(const char* zone) {
    setenv("TZ", zone, 1);
    tzset();
  }
};

constexpr std::time_t kNoon = 1'772'366'400;  // 2026-03-01T12:00:00Z, by date -u -d @...

TEST_F(WallTime, ATimeOfDayIsTheNextOne) {
  Zone("UTC");
  EXPECT_EQ(ParseUntil("12:30", kNoon).value(), kNoon + 1800);
  EXPECT_EQ(ParseUntil("12:00:01", kNoon).value(), kNoon + 1);
  EXPECT_EQ(ParseUntil("12:00", kNoon).value(), kNoon + 86'400) << "now is not to come";
  EXPECT_EQ(ParseUntil("11:59:59", kNoon).value(), kNoon + 86'399);
}

TEST_F(WallTime, TomorrowMayBeInTheNextYear) {
  Zone("UTC");
  const std::time_t silvester = 1'798'761'599;  // 2026-12-31T23:59:59Z
  EXPECT_EQ(ParseUntil("00:00", silvester).value(), silvester + 1);
}

TEST_F(WallTime, ADateIsInLocalTime) {
  Zone("UTC");
  EXPECT_EQ(ParseUntil("2026-03-02T12:00", kNoon).value(), kNoon + 86'400);
  Zone("JST-9");
  EXPECT_EQ(ParseUntil("2026-03-02T12:00:30", kNoon).value(), kNoon + 54'030) << "15 h and 30 s";
}

TEST_F(WallTime, TheWallsClockCountsAcrossSummerTime) {
  // Berlin goes from 02:00 to 03:00 on 2026-03-29; written as a rule, so that no zone file is
  // needed
  Zone("CET-1CEST,M3.5.0,M10.5.0/3");
  const std::time_t evening = 1'774'738'800;  // 2026-03-28T23:00:00Z, midnight in Berlin
  EXPECT_EQ(ParseUntil("06:00", evening).value(), evening + 18'000) << "one hour is missing";
  const auto skipped = ParseUntil("2026-03-29T02:30", evening);
  ASSERT_FALSE(skipped);
  EXPECT_THAT(skipped.error().Text(), HasSubstr("the calendar here does not have"));
}

TEST_F(WallTime, WhatIsNoTimeIsRefused) {
  Zone("UTC");
  for (const char* text : {"", "noon", "25:00", "12", "12:60", "12:30 ", "2026-02-30T12:00",
                           "2026-03-02", "2026-03-02T25:00", "12:30:61"}) {
    const auto until = ParseUntil(text, kNoon);
    ASSERT_FALSE(until) << text;
    EXPECT_EQ(until.error().cause, Cause::kUsage);
  }
  EXPECT_THAT(ParseUntil("9999-01-01T00:00", kNoon).error().Text(), HasSubstr("30 years"));
  EXPECT_TRUE(ParseUntil("2056-01-01T00:00", kNoon));
  EXPECT_THAT(ParseUntil("2026-03-01T11:00", kNoon).error().Text(), HasSubstr("has passed"));
}

// --- the trigger -------------------------------------------------------------------------------

trial::TrialHeader TwoChannels() {
  trial::TrialHeader header;
  header.timing = trial::Timing::kArrival;
  header.channels = {
      {.name = "voltage", .role = trial::ChannelRole::kVoltage, .unit = "V"},
      {.name = "displacement", .role = trial::ChannelRole::kDisplacement, .unit = "m"},
      {.name = "AI 2", .role = trial::ChannelRole::kOther, .unit = ""}};
  return header;
}

struct WrittenTrigger {
  std::string text;
  std::size_t channel;
  TriggerKind kind;
  double threshold;
};

class Triggers : public ::testing::TestWithParam<WrittenTrigger> {};

TEST_P(Triggers, AreReadAndResolved) {
  const auto wish = ParseTrigger(GetParam().text);
  ASSERT_TRUE(wish) << wish.error().Text();
  const auto setup = ResolveTrigger(*wish, TwoChannels());
  ASSERT_TRUE(setup) << setup.error().Text();
  EXPECT_EQ(setup->channel, GetParam().channel);
  EXPECT_EQ(setup->kind, GetParam().kind);
  EXPECT_DOUBLE_EQ(setup->threshold, GetParam().threshold);
}

INSTANTIATE_TEST_SUITE_P(
    Written, Triggers,
    ::testing::Values(WrittenTrigger{"rising 0.1mm", 1, TriggerKind::kRising, 0.1e-3},
                      WrittenTrigger{"falling -20 um", 1, TriggerKind::kFalling, -20e-6},
                      WrittenTrigger{"voltage rising 1V", 0, TriggerKind::kRising, 1},
                      WrittenTrigger{"voltage  below 250mV", 0, TriggerKind::kBelow, 0.25},
                      WrittenTrigger{"displacement above 1mm", 1, TriggerKind::kAbove, 1e-3},
                      WrittenTrigger{"AI 2 above 3", 2, TriggerKind::kAbove, 3}));

TEST(Trigger, TheThresholdCountsFromTheTare) {
  trial::TrialHeader header = TwoChannels();
  header.metadata.tare_m = 2e-3;
  EXPECT_DOUBLE_EQ(ResolveTrigger(ParseTrigger("rising 0.1mm").value(), header)->threshold, 2.1e-3);
  EXPECT_DOUBLE_EQ(ResolveTrigger(ParseTrigger("voltage rising 1V").value(), header)->threshold, 1)
      << "of another channel it is no part";
}

TEST(Trigger, WhatIsNoneIsRefused) {
  for (const char* text :
       {"", "rising", "0.1mm", "up 1mm", "rising mm", "rising 0.1lb", "rising 0.1mm 5"}) {
    const auto wish = ParseTrigger(text);
    ASSERT_FALSE(wish) << text;
    EXPECT_EQ(wish.error().cause, Cause::kUsage);
    EXPECT_EQ(wish.error().where, "--trigger");
  }
}

TEST(Trigger, ChannelAndUnitMustBeTheSensors) {
  const auto absent = ResolveTrigger(ParseTrigger("current above 1A").value(), TwoChannels());
  ASSERT_FALSE(absent);
  EXPECT_THAT(absent.error().Text(), HasSubstr("the sensor has voltage, displacement, AI 2"));
  const auto unit = ResolveTrigger(ParseTrigger("rising 1V").value(), TwoChannels());
  ASSERT_FALSE(unit);
  EXPECT_EQ(unit.error().cause, Cause::kUsage);
  EXPECT_THAT(unit.error().Text(), HasSubstr("'V'"));
}

// --- all together ------------------------------------------------------------------------------

Result<RecordingPlan> Plan(const RecordingOptions& wanted, const std::string& sensor = "stream") {
  SensorOptions options;
  options.port = "p";
  options.sensor = sensor;
  return PlanRecording(wanted, options, kNoon);
}

TEST(RecordingPlan, HoldsWhatWasAsked) {
  const auto plan = Plan({.labels = {" subject = 3 ", "note=a=b", "empty="},
                          .samples = 500,
                          .duration_s = 1.5,
                          .trigger = "rising 0.1mm",
                          .pre_samples = 20,
                          .hold_off_s = 0.25,
                          .shots = 4,
                          .reconnect = "10s"});
  ASSERT_TRUE(plan) << plan.error().Text();
  EXPECT_EQ(plan->labels,
            (std::map<std::string, std::string>{{"subject", "3"}, {"note", "a=b"}, {"empty", ""}}));
  SystemClock clock;
  const auto limits = LimitsOf(*plan, TwoChannels(), clock);
  ASSERT_TRUE(limits);
  EXPECT_EQ(limits->readings, 500U);
  EXPECT_EQ(limits->duration_ns, 1'500'000'000);
  EXPECT_FALSE(limits->until_ns);
  EXPECT_EQ(limits->trigger->pre_samples, 20U);
  EXPECT_EQ(limits->trigger->hold_off_ns, 250'000'000);
  EXPECT_EQ(limits->trigger->shots, 4U);
  EXPECT_TRUE(plan->reconnects);
  EXPECT_EQ(plan->longest_away_ns, 10 * kNsPerS);
}

TEST(RecordingPlan, WaitsForEverWhereAsked) {
  const auto plan = Plan({.reconnect = "forever"});
  ASSERT_TRUE(plan);
  EXPECT_TRUE(plan->reconnects);
  EXPECT_FALSE(plan->longest_away_ns);
  EXPECT_FALSE(Plan({})->reconnects);
}

TEST(RecordingPlan, UntilBecomesAnInstantOfTheMonotonicClock) {
  SystemClock clock;
  RecordingPlan plan;
  plan.until = std::time(nullptr) + 100;
  const MonotonicNs before = clock.Now();
  const auto limits = LimitsOf(plan, TwoChannels(), clock);
  ASSERT_TRUE(limits && limits->until_ns);
  const double left_s = SecondsFromNs(*limits->until_ns - before);
  // the second of time() began up to 1 s ago; 5 s for a machine that stood still
  EXPECT_GT(left_s, 98.9);
  EXPECT_LT(left_s, 105);
}

struct WrongPlan {
  RecordingOptions options;
  std::string sensor;
  std::string text;
};

class WrongPlans : public ::testing::TestWithParam<WrongPlan> {};

TEST_P(WrongPlans, AreRefusedInOneSentence) {
  const auto plan = Plan(GetParam().options, GetParam().sensor);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().cause, Cause::kUsage);
  EXPECT_THAT(plan.error().Text(), HasSubstr(GetParam().text));
  EXPECT_NE(plan.error().remedy, "");
}

INSTANTIATE_TEST_SUITE_P(
    Options, WrongPlans,
    ::testing::Values(
        WrongPlan{{.labels = {"subject"}}, "stream", "'subject' is not KEY=VALUE"},
        WrongPlan{{.labels = {"=3"}}, "stream", "'=3' is not KEY=VALUE"},
        WrongPlan{{.labels = {" = 3"}}, "stream", "' = 3' is not KEY=VALUE"},
        WrongPlan{{.until = "soon"}, "stream", "--until: 'soon' is not a time of day"},
        WrongPlan{{.pre_samples = 5}, "stream", "--pre-samples: is part of a trigger"},
        WrongPlan{{.hold_off_s = 1}, "stream", "--hold-off: is part of a trigger"},
        WrongPlan{{.shots = 2}, "stream", "--shots: is part of a trigger"},
        WrongPlan{{.trigger = "rising 1mm", .shots = 2}, "stream", "needs an end for each shot"},
        WrongPlan{{.reconnect = "often"}, "stream", "--reconnect"},
        WrongPlan{{.reconnect = "0s"}, "stream", "--reconnect: must be an exact time, above 0"},
        WrongPlan{{.reconnect = "1s"}, "replay", "a replay cannot come back"},
        WrongPlan{{.reconnect = "1s"}, "pipe", "a pipe cannot come back"},
        WrongPlan{{.reconnect = "1s"}, "scene:x.toml", "a scene cannot come back"},
        WrongPlan{{.tare = true}, "replay", "a replay has the zero of its recording"}));

// --- where it goes -----------------------------------------------------------------------------

class Output : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(directory_); }
  void TearDown() override { fs::remove_all(directory_); }
  const fs::path directory_ =
      fs::path(::testing::TempDir()) / ("recording_options_test_" + std::to_string(::getpid()));
};

TEST_F(Output, ADirectoryNamesTheTrialAndNothingIsOverwritten) {
  const std::map<std::string, std::string> labels{{"subject", "3"}, {"condition", "a/b ö"}};
  const std::string first =
      NewTrialName(directory_, "2026-03-01T12:00:00.123Z", "keyence-il", labels);
  EXPECT_EQ(first, directory_ / "20260301T120000Z_keyence-il_condition-a_b____subject-3.bin");
  const std::ofstream made(first);
  const std::string second =
      NewTrialName(directory_, "2026-03-01T12:00:00.123Z", "keyence-il", labels);
  EXPECT_EQ(second, directory_ / "20260301T120000Z_keyence-il_condition-a_b____subject-3_2.bin");
  // a link to nowhere is taken, too
  fs::create_symlink("/no/such", second);
  EXPECT_THAT(NewTrialName(directory_, "2026-03-01T12:00:00.123Z", "keyence-il", labels),
              ::testing::EndsWith("_3.bin"));
}

TEST_F(Output, ALongLabelIsCut) {
  const std::string name = NewTrialName(directory_, "2026-03-01T12:00:00.123Z", "stream",
                                        {{"x", std::string(500, 'y')}});
  EXPECT_EQ(fs::path(name).filename().string().size(), 200U + 4U);
}

TEST_F(Output, IsCheckedBeforeTheRecording) {
  ForgetInputs();
  const auto check = [&](const std::string& output, bool overwrite = false) {
    const auto checked = CheckOutput({.output = output, .overwrite = overwrite});
    return checked ? std::string() : checked.error().Text();
  };
  const std::string there = directory_ / "there.bin";
  const std::ofstream made(there);
  EXPECT_EQ(check(directory_ / "new.bin"), "");
  EXPECT_EQ(check(directory_), "");
  EXPECT_EQ(check(directory_.string() + "/"), "");
  EXPECT_EQ(check(there, true), "");
  EXPECT_THAT(check(there), HasSubstr("already exists"));
  EXPECT_THAT(check(directory_ / "none/"), HasSubstr("is a directory that does not exist"));
  EXPECT_THAT(check(directory_ / "none/x.bin"), HasSubstr("lies in a directory"));
  EXPECT_THAT(check(directory_, true), HasSubstr("replaces nothing in a directory"));
  NoteInput(there);
  EXPECT_THAT(check(there, true), HasSubstr("is an input of this command"));
}

}  // namespace
}  // namespace haptometer::tools
