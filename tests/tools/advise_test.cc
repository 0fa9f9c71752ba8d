// What `acquire --advise` answers: lengths against the closed form, limits, order, command line.
#include "tools/acquire/advise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/acquire/advise_document.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using acquire::FindingKind;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

Route Named(const std::string& name, const RouteQuestion& question) {
  const auto routes = AdviseRoutes(question);
  const auto found = std::ranges::find_if(
      routes, [&](const Route& route) { return route.name.starts_with(name); });
  EXPECT_NE(found, routes.end()) << name;
  return found == routes.end() ? Route{} : *found;
}

const std::string kAnalog = "IL-030, analog output and a DAQ, 0.33 ms, 1 average";

// q, B, shares as the header has them, for an unaveraged IL-030: S = 2 s^2 T behind the hold
double HalfInterval(const RouteQuestion& question, double window_s) {
  const double density = 2 * 121e-12 * 0.33e-3;
  const double power = question.rms_m * question.rms_m;
  const double wide_hz = 2 * 16;  // 217-233 and 442-458 Hz
  const double beside_s = 128 / (4.16 * 16);
  const double noise =
      (density * density * wide_hz * (1 + window_s / beside_s) + 2 * power * density) /
      (4 * power * power * window_s);
  const double ends = 1e-4 * (1 + density * 480 / power) / std::numbers::sqrt3;
  return 1.959963984540054 * std::sqrt(noise + ends * ends);
}

TEST(AdviseRoutes, TheLengthOfAnAnalogOutputIsThatOfTheClosedForm) {
  for (const double accuracy : {0.005, 0.01, 0.02}) {
    // fast enough that its samples are the hold
    const RouteQuestion question{.accuracy = accuracy, .daq_rate_hz = 1e6};
    const Route route = Named(kAnalog, question);
    ASSERT_TRUE(route.answers);
    // 12 periods of 20 Hz are the filter's
    const double window_s = *route.record_s - 0.6;
    EXPECT_REL(*route.predicted_relative_uncertainty, HalfInterval(question, window_s), 1e-4,
               "a triangle summed at 330 points, and its square root");
    EXPECT_LE(*route.predicted_relative_uncertainty, accuracy);
    EXPECT_GT(HalfInterval(question, window_s - 0.2), accuracy * 0.997);
  }
}

TEST(AdviseRoutes, AShortLengthIsThatOfTheShortestWindow) {
  const Route route = Named(kAnalog, {.rms_m = 1e-3});
  ASSERT_TRUE(route.answers);
  EXPECT_REL(*route.record_s, 2.6, 1e-12, "40 and 12 periods of 20 Hz");
  EXPECT_EQ(route.limited_by, RouteLimit::kShortestWindow);
  EXPECT_LT(*route.predicted_relative_uncertainty, 0.001);
}

TEST(AdviseRoutes, WhatNoLengthImprovesIsAnObstacle) {
  const Route calibrated = Named(kAnalog, {.accuracy = 0.01, .calibration = 0.006});
  EXPECT_FALSE(calibrated.answers);
  EXPECT_EQ(calibrated.limited_by, RouteLimit::kCalibration);
  EXPECT_EQ(calibrated.reason.kind, FindingKind::kFloorTooHigh);
  EXPECT_GT(*calibrated.floor, 1.96 * 0.006 * 0.999);
  // 0.4 % leaves room for noise
  const Route better = Named(kAnalog, {.accuracy = 0.01, .calibration = 0.004});
  EXPECT_TRUE(better.answers);
  EXPECT_GT(*better.record_s, *Named(kAnalog, {.accuracy = 0.01}).record_s);
  // far below the noise, what lies beside the drive is known as from 1.92 s only
  const Route faint = Named(kAnalog, {.rms_m = 1e-6, .accuracy = 0.01});
  EXPECT_FALSE(faint.answers);
  EXPECT_EQ(faint.limited_by, RouteLimit::kNoise);
}

TEST(AdviseRoutes, SlowWiresAreForSlowBands) {
  const Route fast = Named("IL-030 through a DL-RS1A, 38400", {});
  EXPECT_FALSE(fast.answers);
  EXPECT_EQ(fast.limited_by, RouteLimit::kWire);
  EXPECT_EQ(fast.reason.kind, FindingKind::kRateTooLow);
  const RouteQuestion slow{
      .lower_hz = 0.5, .upper_hz = 10, .drive_hz = 2, .rms_m = 100e-6, .accuracy = 0.02};
  const Route route = Named("IL-030 through a DL-RS1A, 38400", slow);
  ASSERT_TRUE(route.answers);
  // (pi 2 Hz 7 ms)^2 / 6
  EXPECT_REL(route.unseen, 3.224e-4, 1e-3, "four digits");
  EXPECT_GE(*route.record_s, 52 / 0.5 - 0.1);
  // 8 Hz on both sides of 2 Hz are the band
  EXPECT_TRUE(route.needs_floor);
  EXPECT_FALSE(Named(kAnalog, {}).needs_floor);
  // of a drive at 10 Hz an age of 7 ms takes 0.8 % alone
  RouteQuestion quick = slow;
  quick.drive_hz = 10;
  quick.accuracy = 0.007;
  const Route aged = Named("IL-030 through a DL-RS1A, 38400", quick);
  EXPECT_FALSE(aged.answers);
  EXPECT_EQ(aged.limited_by, RouteLimit::kAge);
}

TEST(AdviseRoutes, TimesOfReadingsMustBeKnown) {
  // 48 readings/s show 18.9 Hz; 20.7 ms of exchange over sqrt(12) are 6 ms, of 100 ms / 18
  const RouteQuestion question{
      .lower_hz = 2, .upper_hz = 18, .drive_hz = 4, .rms_m = 100e-6, .accuracy = 0.02};
  const Route route = Named("IL-030 through a DL-RS1A, 9600", question);
  EXPECT_FALSE(route.answers);
  EXPECT_EQ(route.reason.kind, FindingKind::kReadingsTooOld);
  EXPECT_EQ(route.limited_by, RouteLimit::kAge);
}

TEST(AdviseRoutes, AveragingThatLeavesTooLittleIsRefused) {
  const Route route = Named("IL-030, analog output and a DAQ, 0.33 ms, 4", {});
  EXPECT_FALSE(route.answers);
  EXPECT_EQ(route.limited_by, RouteLimit::kAveraging);
  EXPECT_EQ(route.reason.kind, FindingKind::kAveragingTooLong);
  // sinc(225 Hz 4 * 0.33 ms)
  const double x = std::numbers::pi * 225 * 4 * 0.33e-3;
  EXPECT_REL(route.gain, std::sin(x) / x, 1e-12, "the same");
}

TEST(AdviseRoutes, ALengthNeedsTheNoise) {
  const std::string lines = "lines of 9 characters sent without request, 921600";
  const Route unknown = Named(lines, {});
  EXPECT_TRUE(unknown.answers);
  EXPECT_FALSE(unknown.record_s.has_value());
  EXPECT_EQ(unknown.reason.kind, FindingKind::kNoiseNotStated);
  const Route known = Named(lines, {.noise_rms_m = 0.5e-6});
  ASSERT_TRUE(known.record_s.has_value());
  // 50 nm in the band are nothing beside 10 um: the shortest window does
  EXPECT_EQ(known.limited_by, RouteLimit::kShortestWindow);
}

TEST(AdviseRoutes, AnswersComeFirstThenShortRecords) {
  for (const RouteQuestion& question :
       {RouteQuestion{}, RouteQuestion{.accuracy = 0.001, .noise_rms_m = 2e-6},
        RouteQuestion{.lower_hz = 0.5, .upper_hz = 10, .drive_hz = 3, .rms_m = 50e-6}}) {
    const auto routes = AdviseRoutes(question);
    for (std::size_t k = 1; k < routes.size(); ++k) {
      const Route& a = routes[k - 1];
      const Route& b = routes[k];
      EXPECT_GE(a.answers, b.answers);
      if (a.answers && b.answers && b.record_s) {
        ASSERT_TRUE(a.record_s.has_value());
        EXPECT_LE(*a.record_s, *b.record_s);
      }
      EXPECT_EQ(b.record_s.has_value(), b.predicted_relative_uncertainty.has_value());
    }
  }
}

TEST(AdviseRoutes, ADaqRateThatFoldsIsToldFromOneThatDoesNot) {
  EXPECT_TRUE(Named(kAnalog, {}).images.empty());
  const Route folded = Named(kAnalog, {.daq_rate_hz = 3000});
  ASSERT_FALSE(folded.images.empty());
  EXPECT_REL(folded.images.front().folded_hz, 194.69697, 1e-6, "eight digits");
  ASSERT_TRUE(folded.better_daq_rate_hz.has_value());
  EXPECT_TRUE(Named(kAnalog, {.daq_rate_hz = *folded.better_daq_rate_hz}).images.empty());
  // a DAQ below 2.56 times the corner cannot observe it
  EXPECT_EQ(Named(kAnalog, {.daq_rate_hz = 1000}).limited_by, RouteLimit::kSampling);
}

const std::vector<std::string> kAsked{"--advise", "--drive",    "225Hz",      "--rms", "10um",
                                      "--band",   "20Hz-500Hz", "--accuracy", "1%"};

TEST(AdviseVerb, EndsWithTheCommand) {
  const Outcome outcome = Captured(RunAcquire, "acquire", kAsked);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("half of the 95 % interval"),
                                 HasSubstr("coverage factor 1.96"), HasSubstr("cannot: ")));
  const std::string last = outcome.out.substr(outcome.out.rfind("  record with"));
  EXPECT_THAT(last, AllOf(HasSubstr("acquire --sensor pipe"), HasSubstr("--averaging 100"),
                          HasSubstr("--duration"), HasSubstr("-o trial.bin"),
                          HasSubstr("haptometer analyze trial.bin --band 20-500Hz\n")));
}

TEST(AdviseVerb, WarnsOfADaqRateThatFolds) {
  std::vector<std::string> words = kAsked;
  for (const char* word : {"--daq-rate", "3kHz", "--json"}) words.emplace_back(word);
  const Json document = Json::parse(Captured(RunAcquire, "acquire", words).out);
  const auto& findings = document["findings"];
  const auto fold = std::ranges::find_if(
      findings, [](const Json& finding) { return finding["kind"] == "images-fold"; });
  ASSERT_NE(fold, findings.end());
  EXPECT_EQ((*fold)["severity"], "doubt");
  EXPECT_REL((*fold)["numbers"]["folded_hz"].get<double>(), 194.69697, 1e-6, "eight digits");
  EXPECT_EQ(document["routes"][0]["answers"], true);
}

TEST(AdviseVerb, WithoutAnAnswerHasTheStatusOfData) {
  const Outcome outcome = Captured(
      RunAcquire, "acquire",
      {"--advise", "--drive", "225Hz", "--rms", "0.5um", "--accuracy", "0.1%", "--noise", "20um"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("no way reaches +-0.1 %; the least interval at any length"));
}

TEST(AdviseVerb, RefusesWhatCannotBeMeant) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"--advise", "--rms", "10um"}, "--drive"},
      {{"--advise", "--drive", "225Hz"}, "--rms"},
      {{"--advise", "--drive", "900Hz", "--rms", "1um"}, "--drive"},
      {{"--advise", "--drive", "225Hz", "--rms", "0um"}, "--rms"},
      {{"--advise", "--drive", "225Hz", "--rms", "1um", "--accuracy", "30%"}, "--accuracy"},
      {{"--advise", "--drive", "225Hz", "--rms", "1um", "--band", "500-20Hz"}, ""},
      {{"--drive", "225Hz", "--port", "x"}, "--drive"}};
  for (const auto& [words, where] : wrong) {
    const Outcome outcome = Captured(RunAcquire, "acquire", words);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(where));
  }
}

}  // namespace
}  // namespace haptometer::tools
