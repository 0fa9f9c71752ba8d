#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/fit/plan_drop_test.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kOpenFile = std::string(HAPTOMETER_FIXTURES) + "/impulse.csv";
const std::string kLoadedFile = std::string(HAPTOMETER_FIXTURES) + "/impulse_33ohm.csv";

Outcome Plan(const std::vector<std::string>& words) {
  return Captured(RunPlanDropTest, "plan-drop-test", words);
}

Outcome UsualPlan(const std::vector<std::string>& more) {
  std::vector<std::string> words{"--resistance", "27ohm", "--f0", "225Hz"};
  words.insert(words.end(), more.begin(), more.end());
  return Plan(words);
}

json PlanJson(std::vector<std::string> words, int status = 0) {
  words.emplace_back("--json");
  const Outcome outcome = Plan(words);
  EXPECT_EQ(outcome.status, status) << outcome.err;
  return json::parse(outcome.out);
}

TEST(FitPlan, TheIssuesLineGivesACardThatSaysWhatItAssumes) {
  const Outcome outcome = UsualPlan({"--want", "Km 2%"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* part : {"clamp the case", "weigh the moving mass", "trigger, single, at",
                           "best for Km", "Q 30 is assumed: state --guess", "8 bits"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
}

TEST(FitPlan, AnActuatorsFileNeedsNoGuess) {
  const json card = PlanJson({"--actuator", "thesis-c10-100"});
  const json& guesses = card.at("guesses");
  EXPECT_REL(guesses.at("natural_frequency_hz").get<double>(), 225.0790790, 1e-9, "its digits");
  EXPECT_REL(guesses.at("quality_factor").get<double>(), 61.48754619, 1e-9, "its digits");
  EXPECT_REL(card.at("ringing").at("open_decay_per_s").get<double>(), 11.5, 1e-12, "closed form");
  EXPECT_THAT(KindsOf(card), Not(Contains("quality-assumed")));
  EXPECT_THAT(KindsOf(card), Not(Contains("force-constant-assumed")));
}

TEST(FitPlan, WhatIsStatedIsUsed) {
  const json card = PlanJson({"--resistance",  "27ohm+-0.2ohm",
                              "--f0",          "225Hz",
                              "--moving-mass", "1.40(2)g",
                              "--load",        "33.0(3)ohm",
                              "--bits",        "12",
                              "--range",       "2V",
                              "--noise",       "1mV",
                              "--rate",        "20kHz",
                              "--length",      "0.3s",
                              "--taps",        "7",
                              "--guess",       "Q 60",
                              "--guess",       "Km 0.9N/A",
                              "--drop-height", "5mm",
                              "--time-scale",  "1+-1e-4"});
  EXPECT_REL(card.at("recorder").at("step_v").get<double>(), 2.0 / 4096, 1e-12, "exact");
  EXPECT_EQ(card.at("recorder").at("rate_hz"), 20'000);
  EXPECT_EQ(card.at("recorder").at("length_s"), 0.3);
  EXPECT_EQ(card.at("open_drops"), 7);
  EXPECT_EQ(card.at("load_ohm").at("value"), 33);
  EXPECT_TRUE(card.at("load_ohm").at("best_ohm").is_null());
  EXPECT_REL(card.at("ringing").at("open_amplitude_v").get<double>(),
             0.9 * std::sqrt(2 * 9.80665 * 0.005), 1e-12, "free fall");
  const json& km = card.at("relative_standard_uncertainty").at("Km");
  EXPECT_REL(km.at("from_mass").get<double>(), 0.02 / 1.4 / 2, 1e-9, "half of the mass's");
  EXPECT_REL(km.at("from_resistance").get<double>(), 0.2 / 60 / 2, 1e-9, "R + RL");
  EXPECT_REL(km.at("from_load").get<double>(), 0.3 / 60 / 2, 1e-9, "R + RL");
  EXPECT_REL(km.at("from_time_scale").get<double>(), 0.5e-4, 1e-9, "half of the time's");
  EXPECT_EQ(km.at("limited_by"), "moving mass");
  EXPECT_THAT(card.at("command").get<std::string>(),
              HasSubstr("--load 33ohm+-0.3ohm loaded*.csv --held --moving-mass 1.4g+-0.02g"));
  for (const std::string& kind : KindsOf(card)) EXPECT_FALSE(kind.ends_with("-assumed")) << kind;
}

TEST(FitPlan, AWishThatCannotBeReachedIsStatusThreeAndNamesTheLimit) {
  const Outcome by_mass = UsualPlan({"--moving-mass", "1.4g+-0.05g", "--want", "Kv 1%"});
  EXPECT_EQ(by_mass.status, 3);
  EXPECT_THAT(by_mass.out, HasSubstr("Kv to 1 % is not reached: 7 % is expected; the moving mass"));
  EXPECT_THAT(by_mass.out, HasSubstr("expected standard uncertainty")) << "the card comes too";
  const Outcome by_ohms = Plan({"--resistance", "27ohm+-2ohm", "--f0", "225Hz", "--moving-mass",
                                "1.4g", "--load", "27ohm", "--want", "Km 2%"});
  EXPECT_THAT(by_ohms.out, HasSubstr("the coil resistance prevents it"));
  const Outcome by_bits =
      UsualPlan({"--bits", "4", "--noise", "1mV", "--guess", "Km 0.3N/A", "--want", "Km 2%"});
  EXPECT_THAT(by_bits.out, HasSubstr("bits more would do"));
}

TEST(FitPlan, TooFewTapsAreToldHowManyWouldDo) {
  const std::vector<std::string> words{"--actuator", "thesis-c10-100", "--bits", "5",
                                       "--load",     "33ohm",          "--want", "Km 1%"};
  auto few = words;
  few.insert(few.end(), {"--taps", "1"});
  EXPECT_THAT(Plan(few).out, HasSubstr("open and"));
  const json card = PlanJson(words);
  EXPECT_TRUE(card.at("wishes")[0].at("reached").get<bool>());
  EXPECT_EQ(card.at("open_drops"), card.at("wishes")[0].at("open_drops_needed"));
  EXPECT_EQ(card.at("loaded_drops"), card.at("wishes")[0].at("loaded_drops_needed"));
  EXPECT_LE(card.at("relative_standard_uncertainty").at("Km").at("combined").get<double>(),
            0.01 / fit::kCoverage95);
}

// the printed command, with recordings in the place of its patterns
TEST(FitPlan, TheCommandIsOneThatFitLraTakes) {
  const json card = PlanJson({"--actuator", "thesis-c10-100", "--load", "33ohm"});
  std::istringstream line(card.at("command").get<std::string>());
  std::vector<std::string> words;
  for (std::string word; line >> word;) {
    words.push_back(word == "open*.csv" ? kOpenFile : word == "loaded*.csv" ? kLoadedFile : word);
  }
  ASSERT_GT(words.size(), 2U);
  EXPECT_EQ(words[1], "fit-lra");
  words.erase(words.begin(), words.begin() + 2);
  words.insert(words.end(), {"--json", "--require", "Km"});
  const Outcome fitted = Captured(RunFitLra, "fit-lra", words);
  EXPECT_EQ(fitted.status, 0) << fitted.err;
  EXPECT_REL(json::parse(fitted.out).at("parameters").at("Km").at("value").get<double>(), 1.0, 0.02,
             "the fixtures' noise");
}

TEST(FitPlan, FitLraStillAnswersWithTheVerbsDocument) {
  const std::vector<std::string> words{"--plan", "--actuator", "thesis-c10-100", "--json"};
  const json card = json::parse(Captured(RunFitLra, "fit-lra", words).out);
  EXPECT_EQ(card.at("recorder"), PlanJson({"--actuator", "thesis-c10-100"}).at("recorder"));
}

TEST(FitPlan, MistakesAreNamed) {
  const auto refused = [](const Outcome& outcome, const std::string& what) {
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(what));
  };
  refused(Plan({"--f0", "225Hz"}), "--resistance: is missing");
  refused(Plan({"--resistance", "27ohm"}), "--f0: is missing");
  refused(Plan({"--resistance", "inf", "--f0", "225Hz"}),
          "--resistance: 'inf' is not from 0.001 ohm");
  refused(Plan({"--resistance", "27ohm", "--f0", "225Hz", "--moving-mass", "1e-30g"}), "1e-12 to");
  refused(UsualPlan({"--drop-height", "20m"}), "'20m' is not from 1 um to 10 m");
  refused(UsualPlan({"--require", "Km"}), "--require");
  refused(UsualPlan({"--save", "a.toml"}), "--save");
  refused(UsualPlan({kOpenFile}), kOpenFile);
  refused(UsualPlan({"--free"}), "--free");
  refused(UsualPlan({"--want", "km 2%"}), "km is none of Kv, Bv, Km");
  refused(UsualPlan({"--want", "Km 2%, Kv 1%"}), "repeat the option: --want \"Km 2%\"");
  refused(UsualPlan({"--want", "Km 2,5%"}), "has a decimal comma; write a point: 2.5");
  refused(UsualPlan({"--want", "Km 2"}), "Km 2 is not a percentage");
  refused(UsualPlan({"--want", "Km 0%"}), "not above 0 %");
  refused(UsualPlan({"--guess", "R 27"}), "R is none of Q, Bv, Km");
  refused(UsualPlan({"--guess", "Q 0.4"}), "Q 0.4 is not from 2 to 1000");
  refused(UsualPlan({"--guess", "Km -1N/A"}), "--guess");
  refused(UsualPlan({"--range", "0.5V"}), "clips a ringing of 0.44 V");
  refused(UsualPlan({"--rate", "1kHz"}), "below 5 samples a period");
  refused(UsualPlan({"--length", "5ms"}), "below 2 periods");
  refused(UsualPlan({"--rebound", "2"}), "--rebound: '2' is not from 0 to 1");
  refused(UsualPlan({"--load", "open"}), "--load: 'open' is not from");
  refused(Captured(RunFitLra, "fit-lra", {kOpenFile, "--want", "Km 2%"}), "--want");
}

}  // namespace
}  // namespace haptometer::tools
