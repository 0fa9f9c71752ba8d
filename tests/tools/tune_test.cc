#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"
#include "tests/tools/captured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFixtures = HAPTOMETER_FIXTURES;

Outcome Tune(const std::vector<std::string>& words) { return Captured(RunTune, "tune", words); }

json Json(std::vector<std::string> words) {
  words.emplace_back("--json");
  const Outcome outcome = Tune(words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return json::parse(outcome.out);
}

std::vector<std::string> Kinds(const json& answer) {
  std::vector<std::string> kinds;
  for (const json& finding : answer.at("findings")) kinds.push_back(finding.at("kind"));
  return kinds;
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
    const json answer = Json({"--frequency", frequency, "--stiffness", "9000"});
    EXPECT_THAT(Kinds(answer), Contains("run-too-long")) << frequency;
    EXPECT_TRUE(answer.at("rise").is_null()) << frequency;
  }
}

// simulate of the adapter that was found tells the same latency and the same verdict
TEST(TuneVerb, KeepsToALatencyThatSimulateConfirms) {
  const json answer = Json({"--latency", "2.653ms", "--contact-area", "1mm2", "--damping", "0.01"});
  const json& best = answer.at("best");
  const json& rise = answer.at("rise");
  EXPECT_LE(rise.at("latency_s").get<double>() + rise.at("standard_uncertainty_s").get<double>(),
            2.653e-3);
  EXPECT_TRUE(rise.at("latency_below_s").is_null()) << "it is above its uncertainty";
  EXPECT_LT(answer.at("skin_rms_m").get<double>(), tests::kRmsBest);
  EXPECT_GT(answer.at("upper_bound_m").get<double>(), tests::kRmsBest);
  EXPECT_EQ(answer.at("latency_limit_s").get<double>(), 2.653e-3);
  EXPECT_TRUE(answer.at("grid").is_null());
  EXPECT_TRUE(answer.at("ridge").empty());
  EXPECT_FALSE(answer.at("latency_search").at("proved").get<bool>());
  EXPECT_GT(answer.at("latency_search").at("runs").get<int>(), 20);
  EXPECT_THAT(Kinds(answer), Contains("latency-searched"));

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
  for (const char* key :
       {"latency_s", "latency_below_s", "standard_uncertainty_s", "verdict", "rise_s"}) {
    EXPECT_EQ(told.at(key), rise.at(key)) << key;
  }
  const std::string said = Captured(RunSimulate, "simulate", {path, "--duration", "0.5s"}).out;
  EXPECT_THAT(said,
              HasSubstr(fmt::format(" {:.2f}(65) ms\n", rise.at("latency_s").get<double>() * 1e3)));
  EXPECT_THAT(said, HasSubstr("  note: the latency is below 25 ms"));
}

TEST(TuneVerb, IsNotChangedByALatencyThatIsKept) {
  const json plain = Json({});
  const json kept = Json({"--latency", "25ms"});
  EXPECT_EQ(kept.at("best"), plain.at("best"));
  EXPECT_EQ(kept.at("skin_rms_m"), plain.at("skin_rms_m"));
  EXPECT_EQ(kept.at("upper_bound_m"), plain.at("upper_bound_m"));
  EXPECT_EQ(kept.at("rise"), plain.at("rise"));
  EXPECT_THAT(Kinds(kept), Contains("latency-proved"));
  EXPECT_THAT(Kinds(kept), Not(Contains("latency-searched")));
  EXPECT_THAT(Tune({"--latency", "25ms"}).out, HasSubstr("  latency allowed              25 ms\n"));
  EXPECT_TRUE(kept.at("latency_search").at("proved").get<bool>());
  EXPECT_TRUE(plain.at("latency_search").is_null());
  const Outcome none = Tune({"--latency", "0.67ms", "--stiffness", "9000", "--contact-area", "1mm2",
                             "--damping", "0.01", "--motor-side-mass", "0.25g"});
  EXPECT_EQ(none.status, 3);
  EXPECT_THAT(none.err, HasSubstr("reaches 10 % within"));
  EXPECT_THAT(none.err, HasSubstr("runs, not proved"));
}

// a limit below what a run can tell is neither kept nor proved
TEST(TuneVerb, RefusesALatencyThatCannotBeTold) {
  for (const auto& [frequency, limit, least] :
       {std::tuple("60Hz", "0.1ms", "2.45ms"), std::tuple("100Hz", "0.1ms", "1.47ms"),
        std::tuple("5Hz", "0.1ms", "29.3ms")}) {
    const Outcome refused = Tune({"--frequency", frequency, "--latency", limit});
    EXPECT_EQ(refused.status, 3) << frequency;
    EXPECT_THAT(refused.err, HasSubstr("a --latency of 0.1 ms cannot be decided")) << frequency;
    const json kept = Json({"--frequency", frequency, "--latency", least});
    const json& rise = kept.at("rise");
    EXPECT_GE(rise.at("latency_s").get<double>(), 0) << frequency;
    EXPECT_LE(rise.at("latency_s").get<double>() + rise.at("standard_uncertainty_s").get<double>(),
              kept.at("latency_limit_s").get<double>())
        << frequency;
  }
  EXPECT_THAT(
      Tune({"--frequency", "60Hz", "--latency", "0.1ms"}).err,
      HasSubstr(
          "at 60 Hz the standard uncertainty of a latency is 2.45 ms; allow at least 2.45 ms"));
}

TEST(TuneVerb, TellsALatencyWithinItsUncertaintyAsBelow) {
  const std::vector<std::string> asked{"--frequency", "60Hz", "--contact-area", "1mm2"};
  const json rise = Json(asked).at("rise");
  EXPECT_EQ(rise.at("latency_s").get<double>(), 0);
  EXPECT_EQ(rise.at("latency_below_s"), rise.at("standard_uncertainty_s"));
  EXPECT_THAT(Tune(asked).out, ContainsRegex("\n  latency to 10 %, at most +2\\.45 ms\n"));
  // 0 or 29 ms, which is on either side of 25
  EXPECT_THAT(Tune({"--frequency", "5Hz", "--contact-area", "1mm2"}).out,
              HasSubstr("  note: the latency is too uncertain to be compared with 25 ms"));
}

TEST(TuneVerb, GivesTheSameReasonForNoLatencyWithALimitAndWithout) {
  const std::string reason =
      "rise and latency are not known: a run of 400 s has too many outputs to be examined";
  EXPECT_THAT(Tune({"--frequency", "0.1Hz"}).out, HasSubstr("  doubt: " + reason));
  const Outcome limited = Tune({"--frequency", "0.1Hz", "--latency", "1s"});
  EXPECT_EQ(limited.status, 3);
  EXPECT_THAT(limited.err, HasSubstr("at 0.1 Hz " + reason));
}

// the other spring comes up too late, but moves the skin less without the limit too
TEST(TuneVerb, KeepsTheProofOfTheBestSpringThatIsPrompt) {
  const std::string springs = "9100,12000";
  const json free = Json({"--springs", springs});
  const json kept = Json({"--springs", springs, "--latency", "4ms"});
  EXPECT_EQ(kept.at("best"), free.at("best"));
  EXPECT_EQ(kept.at("upper_bound_m"), free.at("upper_bound_m"));
  EXPECT_TRUE(kept.at("latency_search").at("proved").get<bool>());
  EXPECT_GT(kept.at("latency_search").at("runs").get<int>(), 2) << "the other needs a search";
}

TEST(TuneVerb, SaysWhereAWrongSpringBreaksTheTravel) {
  const json springs = Json({"--mover-travel", "0.4mm"}).at("spring_off");
  for (const json& spring : springs) {
    EXPECT_EQ(spring.at("keeps_mover_limit").get<bool>(),
              spring.at("mover_peak_m").get<double>() <= 0.4e-3);
  }
  EXPECT_FALSE(springs.at(1).at("keeps_mover_limit").get<bool>());
}

TEST(TuneVerb, SaysWhichEffectsOfTheSceneItLeavesOut) {
  const std::string scene = kFixtures + "/lra_stops.toml";
  const json answer = Json({scene});
  EXPECT_THAT(Kinds(answer), Contains("stops-left-out"));
  const json& findings = answer.at("findings");
  const auto left_out = std::ranges::find_if(
      findings, [](const json& of) { return of.at("kind") == "effects-left-out"; });
  ASSERT_NE(left_out, findings.end());
  EXPECT_EQ(left_out->at("numbers").at("effects"), "gravity, travel_stops, contact_loss");
  const json limited = Json({scene, "--mover-travel", "0.4mm"});
  EXPECT_THAT(Kinds(limited), Contains("effects-left-out"));
  EXPECT_THAT(Kinds(limited), Not(Contains("stops-left-out")));
  EXPECT_THAT(Kinds(Json({kFixtures + "/lra_adapter.toml"})), Not(Contains("effects-left-out")));
}

// the answer is of a skin at 1 mm2, the scene's is that of the bare case
TEST(TuneVerb, DoubtsASceneWhoseSkinItDoesNotUse) {
  const std::string scene = kFixtures + "/lra_direct.toml";
  EXPECT_THAT(Tune({scene}).out,
              HasSubstr("doubt: the scene's skin of 1861 N/m and 2.219 N s/m is not used: the "
                        "thesis's law gives 600 N/m and 0.75 N s/m at the answer's area; --skin "
                        "scene takes the scene's"));
  EXPECT_THAT(Kinds(Json({scene, "--skin", "scene"})), Not(Contains("scene-skin-unused")));
  // the law gives the scene's own skin there
  EXPECT_THAT(Kinds(Json({scene, "--contact-area", "78.5mm2"})),
              Not(Contains("scene-skin-unused")));
  EXPECT_THAT(Kinds(Json({kFixtures + "/lra_adapter.toml"})), Not(Contains("scene-skin-unused")));
  EXPECT_THAT(Kinds(Json({})), Not(Contains("scene-skin-unused")));
}

TEST(TuneVerb, DrawsTheOptimumAndTheRidge) {
  const std::string path = ::testing::TempDir() + "tune.svg";
  std::remove(path.c_str());
  EXPECT_EQ(Tune({"--plot", path}).status, 0);
  std::ifstream file(path);
  const std::string svg{std::istreambuf_iterator<char>(file), {}};
  for (const char* said :
       {"skin side", "the ridge: its best is 0.0", "mover travel / µm", "optimised again"}) {
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
  EXPECT_THAT(outcome.out, HasSubstr("thesis: 5 V at 225 Hz, largest skin displacement (RMS)\n"));
  EXPECT_THAT(outcome.out, HasSubstr("  largest value                201.885 um\n"));
  EXPECT_THAT(outcome.out, HasSubstr("no adapter within the bounds gives more"));
  EXPECT_THAT(outcome.out, HasSubstr("  mass on the motor's side     0.25 g, at a bound\n"));
}

TEST(TuneVerb, ShowsGridRidgeAndWrongSpringsToPeopleWhoAskForAll) {
  for (const char* said : {"best of a grid", "the ridge", "a spring that is off", "SHA-256"}) {
    EXPECT_THAT(Tune({kFixtures + "/lra_adapter.toml", "--all"}).out, HasSubstr(said));
    EXPECT_THAT(Tune({kFixtures + "/lra_adapter.toml"}).out, Not(HasSubstr(said)));
  }
}

TEST(TuneVerb, NamesTheSceneThatItRead) {
  const std::string scene = kFixtures + "/lra_adapter.toml";
  const json inputs = Json({scene}).at("provenance").at("inputs");
  ASSERT_EQ(inputs.size(), 1U);
  EXPECT_EQ(inputs.at(0).at("path"), scene);
  EXPECT_EQ(inputs.at(0).at("sha256").get<std::string>().size(), 64U);
}

TEST(TuneVerb, SaysWhatItFindsInSentences) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{}, "note: springs and dampers are linear at any travel"},
      {{}, "a preload of at least 0.3478 N"},
      {{}, "note: the skin follows the thesis's cube root of the contact's area"},
      {{kFixtures + "/lra_adapter.toml", "--skin", "scene"}, "note: the skin is the scene's"},
      {{"--latency", "25ms"}, "without the limit keeps to it, so that the upper bound is"},
      {{"--latency", "2.653ms", "--contact-area", "1mm2", "--damping", "0.01"},
       "searched, not proved ("},
      {{kFixtures + "/lra_stops.toml"},
       "these effects of the scene: gravity, travel_stops, contact_loss; check"},
      {{kFixtures + "/lra_stops.toml"}, "note: the stops are not modelled: limit the travel with"},
      {{"--frequency", "0.1Hz"},
       "doubt: rise and latency are not known: a run of 400 s has too many"}};
  for (const auto& [words, said] : cases) EXPECT_THAT(Tune(words).out, HasSubstr(said));
}

TEST(TuneVerb, RefusesWhatItCannotMean) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> faults{
      {{"--stiffness", "9000:8000"}, "the lower end of '9000:8000' lies above"},
      {{"--stiffness", "many"}, "--stiffness"},
      {{"--skin-side-mass", "5"}, "--skin-side-mass"},
      {{"--skin-side-mass", "0g:1g"}, "'0g' is not from 1e-09 kg to"},
      {{"--contact-area", "1:200"}, "between 1 and 100 mm2"},
      {{"--skin", "scene"}, "has no scene"},
      {{"--springs", "9000,stiff"}, "--springs"},
      {{"--voltage", "0"}, "'0' is not from 1e-09 V to"},
      {{"--skin-varies", "1"}, "'1' is not from 0 to below 1"},
      {{"--skin-varies", "0.1", "--objective", "skin-power"}, "skin-rms and stimulus only"},
      {{"--mover-travel", "0"}, "--mover-travel"},
      {{"--mover-travel", "1mm", "--objective", "rms-per-watt"}, "not answered for rms-per-watt"},
      {{"--mover-travel", "1mm", "--skin-varies", "0.1"}, "skins that vary"},
      {{"--stiffness", "1e300"}, "outside the possible range"},
      {{"--springs", "9000,1e-300"}, "outside the possible range"},
      {{"--voltage", "1e300"}, "outside the possible range"},
      {{"--frequency", "1e300"}, "outside the possible range"},
      {{"--frequency", "1e-10"}, "outside the possible range"},
      {{"--springs", "-5"}, "such as --springs"},
      {{"--voltage", "5(1)V"}, "has an uncertainty, which is not used here"},
      {{"--skin-varies", "20"}, "'20' is not from 0 to below 1"},
      {{"--springs", "9000", "--grid", "5"}, "the grid has no list of springs"},
      {{"--objective", "rms-per-watt", "--grid", "5"}, "not answered for rms-per-watt"},
      {{"--latency", "0s"}, "must be above 0"},
      {{"--latency", "25"}, "did you mean 25ms?"},
      {{"--latency", "soon"}, "--latency"},
      {{"--mover-travel", "-1mm"}, "'-1mm' is not above 0"},
      {{"--latency", "25ms", "--grid", "5"}, "without limits of travel and latency"},
      {{"--latency", "25ms", "--objective", "stimulus"}, "skin-rms only"},
      {{"--latency", "25ms", "--skin-varies", "0.1"}, "skins that vary"},
      {{"--latency", "25ms", "--mover-travel", "1mm"}, "cannot be combined with --mover-travel"},
      {{"--receptor-density", "1e9"}, "10 000 receptors"},
      {{kFixtures + "/lra_cone.toml", "--skin", "scene", "--objective", "stimulus"}, "area"},
      {{kFixtures + "/lra_cone.toml", "--skin", "scene", "--contact-area", "1mm2"},
       "--contact-area: changes nothing with --skin scene"},
      {{kFixtures + "/lra_cone.toml", "--skin", "scene", "--pad", "5mm"},
       "--pad: change nothing with --skin scene"},
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
