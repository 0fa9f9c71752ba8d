#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kFixtures = HAPTOMETER_FIXTURES;

Outcome Tune(const std::vector<std::string>& words) { return Captured(RunTune, "tune", words); }

json Json(std::vector<std::string> words) {
  words.emplace_back("--json");
  const Outcome outcome = Tune(words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return json::parse(outcome.out);
}

TEST(TuneVerb, HasTheNumbersThatScriptsRelyOn) {
  const json answer = Json({});
  const json& best = answer.at("best");
  EXPECT_REL(best.at("motor_side_mass_kg").get<double>(), 0.25e-3, 1e-15, "its bound");
  EXPECT_REL(best.at("skin_side_mass_kg").get<double>(), tests::kRmsBestMa2, 1e-6, "flat");
  EXPECT_REL(best.at("stiffness_n_per_m").get<double>(), tests::kRmsBestKa, 1e-6, "flat");
  EXPECT_REL(best.at("damping_n_s_per_m").get<double>(), 0.01, 1e-15, "its bound");
  EXPECT_REL(best.at("contact_area_m2").get<double>(), 1e-6, 1e-15, "its bound");
  const double rms_m = answer.at("skin_rms_m").get<double>();
  EXPECT_REL(rms_m, tests::kRmsBest, 1e-12, "seven states against mpmath");
  EXPECT_GE(answer.at("upper_bound_m").get<double>(), rms_m);
  EXPECT_LT(answer.at("upper_bound_m").get<double>(), rms_m * (1 + 1e-5));
}

TEST(TuneVerb, ShowsGridRidgeAndWrongSprings) {
  const json answer = Json({});
  EXPECT_EQ(answer.at("grid").at("points").get<int>(), 3'200'000);
  EXPECT_REL(answer.at("grid").at("skin_rms_m").get<double>(), tests::kGridRmsM, 1e-11, "NumPy");
  EXPECT_EQ(answer.at("ridge").size(), 6U);
  ASSERT_EQ(answer.at("spring_off").size(), 2U);
  EXPECT_REL(answer.at("spring_off").at(0).at("factor").get<double>(), 0.95, 1e-15, "as stated");
  EXPECT_GT(answer.at("mover_peak_m").get<double>(), 0.8e-3);
}

TEST(TuneVerb, TakesActuatorAndDriveOfAScene) {
  const json thesis = Json({});
  const json scene = Json({kFixtures + "/lra_adapter.toml"});
  EXPECT_EQ(scene.at("best"), thesis.at("best"));
  const json half = Json({kFixtures + "/lra_adapter.toml", "--voltage", "2.5V"});
  EXPECT_REL(half.at("skin_rms_m").get<double>(), thesis.at("skin_rms_m").get<double>() / 2, 1e-12,
             "the model is linear");
  const json fixed = Json({kFixtures + "/lra_adapter.toml", "--skin", "scene"});
  EXPECT_TRUE(fixed.at("best").at("contact_area_m2").is_null());
  EXPECT_REL(fixed.at("skin_rms_m").get<double>(), tests::kRmsBest, 1e-12, "the same skin");
}

TEST(TuneVerb, KeepsWithinTheBoundsThatItIsGiven) {
  const json answer =
      Json({"--stiffness", "8200", "--motor-side-mass", "1g:2g", "--contact-area", "64mm2"});
  EXPECT_EQ(answer.at("best").at("stiffness_n_per_m").get<double>(), 8200);
  EXPECT_GE(answer.at("best").at("motor_side_mass_kg").get<double>(), 1e-3);
  EXPECT_REL(answer.at("best").at("contact_area_m2").get<double>(), 64e-6, 1e-15, "as stated");
}

TEST(TuneVerb, ChoosesAmongTheSpringsOfAList) {
  const json answer = Json({"--springs", "5000,8200,9300,11000"});
  EXPECT_EQ(answer.at("best").at("stiffness_n_per_m").get<double>(), 9300);
  ASSERT_EQ(answer.at("springs").size(), 4U);
  double largest = 0;
  for (const json& spring : answer.at("springs")) {
    largest = std::max(largest, spring.at("value").get<double>());
  }
  EXPECT_EQ(answer.at("objective").at("value").get<double>(), largest);
  EXPECT_LT(largest, tests::kRmsBest);
  EXPECT_TRUE(answer.at("grid").is_null());
  EXPECT_GE(answer.at("upper_bound_m").get<double>(), largest);
  EXPECT_LT(answer.at("upper_bound_m").get<double>(), largest * (1 + 1e-8));
  EXPECT_THAT(Tune({"--springs", "5000,8200"}).out, HasSubstr("with one of these springs gives"));
}

TEST(TuneVerb, ServesTheWorstOfSkinsThatVary) {
  const json answer = Json({"--skin-varies", "0.2"});
  EXPECT_LT(answer.at("objective").at("value").get<double>(),
            answer.at("skin_rms_m").get<double>());
  EXPECT_TRUE(answer.at("upper_bound_m").is_null());
  EXPECT_THAT(Tune({"--skin-varies", "0.2"}).out, HasSubstr("that moves least"));
}

TEST(TuneVerb, KeepsTheMoverWithinItsTravel) {
  const json answer = Json({"--mover-travel", "0.4mm"});
  EXPECT_REL(answer.at("skin_rms_m").get<double>(), tests::kLimitedBest, 1e-9, "mpmath");
  EXPECT_REL(answer.at("mover_peak_m").get<double>(), 0.4e-3, 1e-9, "the limit holds");
  EXPECT_EQ(answer.at("objective").at("proof"), "branch and bound");
  EXPECT_TRUE(answer.at("grid").is_null());
  EXPECT_TRUE(Json({}).at("mover_limit_m").is_null());
  EXPECT_THAT(Tune({"--mover-travel", "0.05mm"}).out, HasSubstr("keeps to the travel gives more"));
  const Outcome none = Tune({"--mover-travel", "1um"});
  EXPECT_EQ(none.status, 3);
  EXPECT_THAT(none.err, HasSubstr("no adapter found"));
}

// a run of 40 periods would be endless, or too many outputs
TEST(TuneVerb, TellsNoLatencyWhereARunIsTooLong) {
  for (const char* frequency : {"0.001Hz", "2MHz"}) {
    const Outcome told = Tune({"--frequency", frequency, "--stiffness", "9000"});
    EXPECT_EQ(told.status, 0) << frequency << told.err;
    EXPECT_THAT(told.out, HasSubstr("latency            none told")) << frequency;
  }
}

// simulate of the adapter that was found tells the same latency and the same verdict
TEST(TuneVerb, KeepsToALatencyThatSimulateConfirms) {
  const json answer = Json({"--latency", "2ms", "--contact-area", "1mm2", "--damping", "0.01"});
  const json& best = answer.at("best");
  const json& rise = answer.at("rise");
  EXPECT_LE(rise.at("latency_s").get<double>(), 2e-3);
  EXPECT_LT(answer.at("skin_rms_m").get<double>(), tests::kRmsBest);
  EXPECT_GT(answer.at("upper_bound_m").get<double>(), tests::kRmsBest);
  EXPECT_EQ(answer.at("latency_limit_s").get<double>(), 2e-3);
  EXPECT_TRUE(answer.at("grid").is_null());
  EXPECT_TRUE(answer.at("ridge").empty());
  EXPECT_FALSE(answer.at("latency_search").at("proved").get<bool>());
  EXPECT_GT(answer.at("latency_search").at("runs").get<int>(), 20);
  EXPECT_THAT(answer.at("assumptions").dump(), HasSubstr("searched, not proved ("));

  const std::string path = ::testing::TempDir() + "prompt.toml";
  std::ofstream(path) << "[actuator]\nmodel = \"thesis-c10-100\"\n[skin]\nstiffness_n_per_m = 600\n"
                      << "damping_n_s_per_m = 0.75\n[drive]\nkind = \"sine\"\namplitude_v = 5\n"
                      << "frequency_hz = 225\n[adapter]\n"
                      << "motor_side_mass_kg = " << best.at("motor_side_mass_kg")
                      << "\nskin_side_mass_kg = " << best.at("skin_side_mass_kg")
                      << "\nstiffness_n_per_m = " << best.at("stiffness_n_per_m")
                      << "\ndamping_n_s_per_m = " << best.at("damping_n_s_per_m") << '\n';
  const Outcome simulated =
      Captured(RunSimulate, "simulate", {path, "--duration", "0.5s", "--json"});
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  const json told = json::parse(simulated.out).at("rise");
  EXPECT_EQ(rise.at("run_s").get<double>(), 0.5);
  EXPECT_EQ(told.at("latency_s"), rise.at("latency_s"));
  EXPECT_EQ(told.at("verdict"), rise.at("verdict"));
}

TEST(TuneVerb, IsNotChangedByALatencyThatIsKept) {
  const json plain = Json({});
  const json kept = Json({"--latency", "25ms"});
  EXPECT_EQ(kept.at("best"), plain.at("best"));
  EXPECT_EQ(kept.at("skin_rms_m"), plain.at("skin_rms_m"));
  EXPECT_EQ(kept.at("upper_bound_m"), plain.at("upper_bound_m"));
  EXPECT_EQ(kept.at("rise"), plain.at("rise"));
  const Outcome told = Tune({"--latency", "25ms"});
  EXPECT_THAT(told.out, HasSubstr("of 25 ms allowed: below 25 ms"));
  EXPECT_THAT(told.out, HasSubstr("without the limit keeps to it"));
  EXPECT_THAT(told.out, ::testing::Not(HasSubstr("not proved")));
  EXPECT_TRUE(kept.at("latency_search").at("proved").get<bool>());
  EXPECT_TRUE(plain.at("latency_search").is_null());
  const Outcome none = Tune({"--latency", "0.001us", "--stiffness", "9000", "--contact-area",
                             "1mm2", "--damping", "0.01", "--motor-side-mass", "0.25g"});
  EXPECT_EQ(none.status, 3);
  EXPECT_THAT(none.err, HasSubstr("comes up within"));
  EXPECT_THAT(none.err, HasSubstr("runs, not proved"));
}

TEST(TuneVerb, SaysWhichEffectsOfTheSceneItLeavesOut) {
  const std::string scene = kFixtures + "/lra_stops.toml";
  const Outcome outcome = Tune({scene});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("gravity, travel_stops"));
  EXPECT_THAT(outcome.out, HasSubstr("of the scene left out"));
  EXPECT_THAT(outcome.out, HasSubstr("keep off the stops by --mover-travel"));
  const std::string limited = Tune({scene, "--mover-travel", "0.4mm"}).out;
  EXPECT_THAT(limited, HasSubstr("of the scene left out"));
  EXPECT_THAT(limited, ::testing::Not(HasSubstr("keep off the stops")));
  EXPECT_THAT(Tune({kFixtures + "/lra_adapter.toml"}).out, ::testing::Not(HasSubstr("left out")));
}

TEST(TuneVerb, DrawsTheOptimumAndTheRidge) {
  const std::string path = ::testing::TempDir() + "tune.svg";
  std::remove(path.c_str());
  EXPECT_EQ(Tune({"--plot", path}).status, 0);
  std::ifstream file(path);
  const std::string svg{std::istreambuf_iterator<char>(file), {}};
  for (const char* said :
       {"skin side", "the ridge: its best is 0.0", "mover travel / um", "chosen anew"}) {
    EXPECT_THAT(svg, HasSubstr(said));
  }
  EXPECT_EQ(Tune({"--plot", "tune.txt"}).status, 2);
}

TEST(TuneVerb, AnswersTheOtherObjectives) {
  const json stimulus = Json({"--objective", "stimulus"});
  EXPECT_REL(stimulus.at("stimulus_m").get<double>(), 45 * tests::kStimulusBest, 1e-12, "mpmath");
  EXPECT_TRUE(stimulus.at("upper_bound_m").is_null());
  EXPECT_LT(
      Json({"--objective", "stimulus", "--receptor-grid", "edge"}).at("stimulus_m").get<double>(),
      stimulus.at("stimulus_m").get<double>());
  const json power = Json({"--objective", "skin-power"});
  EXPECT_REL(power.at("skin_power_w").get<double>(), tests::kPowerBest, 1e-12, "mpmath");
  const json per_watt = Json({"--objective", "rms-per-watt"});
  EXPECT_REL(per_watt.at("objective").at("value").get<double>(), tests::kPerWattBest, 1e-12,
             "mpmath");
  EXPECT_TRUE(per_watt.at("grid").is_null());
}

TEST(TuneVerb, TellsPeopleTheProof) {
  const Outcome outcome = Tune({});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, HasSubstr("201.88526 um"));
  EXPECT_THAT(outcome.out, HasSubstr("no adapter within the bounds gives more"));
  EXPECT_THAT(outcome.out, HasSubstr("motor side 0.25* g"));
  EXPECT_THAT(outcome.out, HasSubstr("contact is kept whatever the force"));
}

TEST(TuneVerb, RefusesWhatItCannotMean) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> faults{
      {{"--stiffness", "9000:8000"}, "lower bound lies above"},
      {{"--stiffness", "many"}, "--stiffness"},
      {{"--skin-side-mass", "5"}, "--skin-side-mass"},
      {{"--skin-side-mass", "0g:1g"}, "must be above 0"},
      {{"--contact-area", "1:200"}, "between 1 and 100 mm2"},
      {{"--skin", "scene"}, "has no scene"},
      {{"--springs", "9000,stiff"}, "--springs"},
      {{"--voltage", "0"}, "drive nothing"},
      {{"--skin-varies", "1"}, "variation"},
      {{"--skin-varies", "0.1", "--objective", "skin-power"}, "skin-rms and stimulus only"},
      {{"--mover-travel", "0"}, "--mover-travel"},
      {{"--mover-travel", "1mm", "--objective", "rms-per-watt"}, "not answered for rms-per-watt"},
      {{"--mover-travel", "1mm", "--skin-varies", "0.1"}, "skins that vary"},
      {{"--latency", "0s"}, "must be above 0"},
      {{"--mover-travel", "-1mm"}, "longest travel to one side"},
      {{"--latency", "25ms", "--grid", "5"}, "neither travel nor latency"},
      {{"--latency", "25ms", "--objective", "stimulus"}, "skin-rms only"},
      {{"--latency", "25ms", "--skin-varies", "0.1"}, "skins that vary"},
      {{"--latency", "25ms", "--mover-travel", "1mm"}, "together with --mover-travel"},
      {{"--receptor-density", "1e9"}, "10 000 receptors"},
      {{kFixtures + "/lra_cone.toml", "--skin", "scene", "--objective", "stimulus"}, "area"},
      {{kFixtures + "/lra_cone.toml", kFixtures + "/lra_cone.toml"}, "second scene"}};
  for (const auto& [words, said] : faults) {
    const Outcome outcome = Tune(words);
    EXPECT_EQ(outcome.status, 2) << said;
    EXPECT_THAT(outcome.err, HasSubstr(said));
    EXPECT_EQ(outcome.out, "");
  }
}

}  // namespace
}  // namespace haptometer::tools
