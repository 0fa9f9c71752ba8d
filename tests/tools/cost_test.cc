#include "tools/cost/cost.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "sim/scene/scene_file.h"
#include "sim/waveforms.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/simulate/scene_answer.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const std::string kFixtures = HAPTOMETER_FIXTURES;

Outcome Cost(const std::vector<std::string>& words) { return Captured(RunCost, "cost", words); }

json CostJson(std::vector<std::string> words) {
  words.emplace_back("--json");
  const Outcome outcome = Cost(words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return json::parse(outcome.out);
}

TEST(Ladders, HoldTheTableOfDocs) {
  const auto& rungs = ShippedRungs();
  const auto rung = std::ranges::find_if(rungs, [](const Rung& r) {
    return r.scene_class == SceneClass::kSmooth && r.method == "odeint dopri5" &&
           r.setting == "1e-9";
  });
  ASSERT_NE(rung, rungs.end());
  // a method that takes longer for fewer digits is no ladder: orders of magnitude of that row
  EXPECT_GT(rung->seconds, 1e-3);
  EXPECT_LT(rung->seconds, 0.1);
  EXPECT_LT(rung->worst_error, 1e-8);
  EXPECT_GT(rung->worst_error, 1e-11);
  // failures and runs with other outputs are no rungs
  for (const Rung& r : rungs) {
    EXPECT_TRUE(std::isfinite(r.rms_error)) << r.method;
    EXPECT_FALSE(r.setting.ends_with("outputs")) << r.setting;
  }
}

TEST(Ladders, TheCheapestRungIsWithinTheAccuracyAndNoneIsCheaper) {
  const auto& rungs = ShippedRungs();
  for (const double accuracy : {1e-2, 1e-6, 1e-9, 1e-12}) {
    for (std::size_t k = 0; k < kSceneClasses; ++k) {
      const auto scene_class = static_cast<SceneClass>(k);
      const Rung* const best =
          CheapestRung(rungs, scene_class, Simulated::kWaveform, accuracy, true);
      ASSERT_NE(best, nullptr) << accuracy << NameOf(scene_class);
      EXPECT_LE(best->worst_error, accuracy);
      for (const Rung& rung : rungs) {
        if (rung.scene_class != scene_class || !IsOwn(rung.method)) continue;
        EXPECT_TRUE(rung.worst_error > accuracy || rung.seconds >= best->seconds) << rung.method;
      }
    }
  }
  EXPECT_EQ(CheapestRung(rungs, SceneClass::kSmooth, Simulated::kWaveform, 1e-20, true), nullptr);
}

TEST(Ladders, TheScenesAreThoseOfTheScript) {
  // RMS of the skin's second half by tools/cost/scipy_ladders.py, DOP853 at 1e-10
  constexpr std::array kScipyRms_m{0.0001899534396834073, 5.378629309589482e-05,
                                   0.00036726615943275144, 9.314326615081092e-05};
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    const sim::EffectiveScene ladder = LadderScene(static_cast<SceneClass>(k));
    const auto waves =
        sim::PlayWaveforms(ladder, sim::BeginningOf(ladder), kLadderDurationS, kLadderRateHz);
    const Eigen::Index half = waves.rows() / 2;
    const double rms_m =
        waves.skin_m.tail(waves.rows() - half).norm() / std::sqrt(waves.rows() - half);
    EXPECT_REL(rms_m, kScipyRms_m[k], 1e-7, "DOP853's tolerance of a step, over 4000 steps");
  }
}

TEST(PriceOf, PredictsABoundOfTheErrorThatIsStated) {
  for (const auto& [file, duration_s] :
       {std::pair{"lra_adapter.toml", 0.5}, {"lra_stops.toml", 0.2}, {"lra_cone.toml", 0.3}}) {
    auto scene = sim::ReadSceneFile(kFixtures + "/" + file).value();
    scene.duration_s = duration_s;
    scene.tolerance = 1e-8;
    const auto price = PriceOf(scene, file);
    const auto answer = AnswerScene(scene, file);
    ASSERT_TRUE(price && answer) << file;
    const double stated = ErrorOfAll(*answer);
    EXPECT_GE(*price->predicted_error, stated) << file;
    // ten times the stated error, which grows in proportion or more slowly
    EXPECT_LE(*price->predicted_error, 100 * std::max(stated, 1e-15)) << file;
  }
}

// the adapter scene, its coil warming over a run or its spring stiffening in a steady motion
sim::Scene SmoothScene(sim::Effect effect) {
  auto scene = sim::ReadSceneFile(kFixtures + "/lra_adapter.toml").value();
  scene.effects.wishes[sim::PlaceOf(effect)] = sim::Wish::kOn;
  scene.effects.coil_heating =
      sim::CoilHeating{.heat_capacity_j_per_k = 0.05, .thermal_resistance_k_per_w = 60};
  scene.effects.stiffening = sim::StiffeningSpring{.cubic_n_per_m3 = 2e9};
  if (effect == sim::Effect::kCoilHeating) scene.duration_s = 1;
  return scene;
}

// the solver takes smaller tolerances until it keeps what is asked for, which a part of the run
// does not show: ten times the part's error, in proportion to the length, is above
TEST(PriceOf, OfASmoothMotionPredictsNoMoreThanIsAskedFor) {
  for (const auto& [effect, accuracy] : {std::pair{sim::Effect::kCoilHeating, 1e-4},
                                         {sim::Effect::kCoilHeating, 1e-7},
                                         {sim::Effect::kCoilHeating, 1e-8},
                                         {sim::Effect::kStiffening, 1e-5},
                                         {sim::Effect::kStiffening, 1e-7}}) {
    sim::Scene scene = SmoothScene(effect);
    scene.tolerance = accuracy;
    const auto price = PriceOf(scene, "smooth");
    const auto answer = AnswerScene(scene, "smooth");
    ASSERT_TRUE(price && answer) << accuracy;
    EXPECT_LE(*price->predicted_error, accuracy);
    EXPECT_GE(*price->predicted_error, ErrorOfAll(*answer)) << accuracy;
  }
}

// an effect that "auto" leaves out changes no number by more than half of what is asked for,
// however long the run is
TEST(PriceOf, OfAnEffectThatIsLeftOutIsWithinWhatIsAskedFor) {
  sim::Scene scene = SmoothScene(sim::Effect::kCoilHeating);
  scene.effects.wishes[sim::PlaceOf(sim::Effect::kCoilHeating)] = sim::Wish::kAuto;
  // R changes by 1e-5 within a second
  scene.effects.coil_heating->heat_capacity_j_per_k = 1e4;
  scene.tolerance = 2.5e-5;
  const auto price = PriceOf(scene, "warm");
  const auto answer = AnswerScene(scene, "warm");
  ASSERT_TRUE(price && answer);
  ASSERT_FALSE(answer->effects->on[sim::PlaceOf(sim::Effect::kCoilHeating)]);
  EXPECT_LE(*price->predicted_error, scene.tolerance);
  EXPECT_GE(*price->predicted_error, ErrorOfAll(*answer));
}

// rounding grows with the steps: 20 s of a coil that warms are known to 3e-11 by the least
// tolerance of the solver, its first sixteenth to 1e-11
TEST(PriceOf, DoesNotPromiseWhatTheLeastToleranceDoesNotReach) {
  sim::Scene scene = SmoothScene(sim::Effect::kCoilHeating);
  scene.duration_s = 20;
  scene.tolerance = sim::kLeastTolerance;
  const auto price = PriceOf(scene, "smooth");
  ASSERT_TRUE(price) << price.error().Text();
  EXPECT_GT(*price->predicted_error, sim::kLeastTolerance);
}

// what is solved whole states its error itself
TEST(PriceOf, OfALinearSteadyStateIsTheErrorThatIsStated) {
  const auto scene = sim::ReadSceneFile(kFixtures + "/lra_adapter.toml").value();
  const auto price = PriceOf(scene, "linear");
  const auto answer = AnswerScene(scene, "linear");
  ASSERT_TRUE(price && answer);
  EXPECT_EQ(*price->predicted_error, ErrorOfAll(*answer));
}

// no other program has solved the scene that is asked about
TEST(CostOfSimulation, NamesTheSceneThatAnErrorIsOf) {
  sim::Scene scene = SmoothScene(sim::Effect::kStiffening);
  scene.tolerance = 1e-6;
  const auto cost = CostOfSimulation(scene, Simulated::kSkinRms, "smooth", false);
  ASSERT_TRUE(cost) << cost.error().Text();
  ASSERT_GT(cost->methods.size(), 1U);
  for (const CostedMethod& method : cost->methods) {
    EXPECT_EQ(method.error_of, method.is_peer ? "the ladders' scene, smooth" : "this scene");
    EXPECT_TRUE(method.answers) << method.method;
  }
}

// the cell of a method's row that people read under a heading
const document::Value& CellOf(const document::Document& cost, std::string_view label) {
  const auto& items = cost.root.sections.at(0).sections.at(0).items;
  const auto item = std::ranges::find(items, label, &document::Item::label);
  HAPTOMETER_CHECK(item != items.end(), "no column {}", label);
  return item->value;
}

// a bound above the accuracy beside an answer within it would contradict itself
TEST(CostDocument, ShowsTheMeasuredErrorWhereThereIsOne) {
  constexpr std::string_view kError = "relative error, at most";
  CostAnswer answer{.question = "skin-rms", .subject = "a scene", .accuracy = 1e-6};
  answer.methods = {{.method = "exact", .predicted_error = 1.77e-6, .answers = false}};
  EXPECT_EQ(std::get<double>(CellOf(CostDocument(answer), kError)), 1.77e-6);
  answer.methods[0].measured_error = 4.7e-8;
  EXPECT_EQ(std::get<double>(CellOf(CostDocument(answer), kError)), 4.7e-8);
}

TEST(CostOfConstant, IsLimitedByTheScale) {
  // Kv is proportional to the mass: 0.01 g as limits of error of 1.4 g
  const double half = fit::kCoverage95 * 1e-5 / std::numbers::sqrt3 / 1.4e-3;
  const auto within =
      CostOfConstant(fit::Constant::kStiffness, std::string(kDefaultActuator), 1.1 * half);
  ASSERT_TRUE(within) << within.error().Text();
  EXPECT_TRUE(within->methods.front().answers);
  const auto beyond =
      CostOfConstant(fit::Constant::kStiffness, std::string(kDefaultActuator), 0.9 * half);
  ASSERT_TRUE(beyond);
  EXPECT_FALSE(beyond->methods.front().answers);
  EXPECT_EQ(beyond->methods.front().limited_by, "moving mass");
  EXPECT_REL(*beyond->methods.back().predicted_error, half, 0.01,
             "noise of 16 bits and a time base of 50 ppm beside the mass");
}

TEST(SortMethods, PutsAnswersFirstThenTheShortestRecording) {
  std::vector<CostedMethod> methods{{.method = "slow", .recording_s = 9, .answers = true},
                                    {.method = "no", .recording_s = 1},
                                    {.method = "quick", .recording_s = 2, .answers = true}};
  SortMethods(methods);
  EXPECT_EQ(methods[0].method, "quick");
  EXPECT_EQ(methods[1].method, "slow");
  EXPECT_EQ(methods[2].method, "no");
}

TEST(KnowledgeLimits, NoneIsZeroAndTheSkinMattersMost) {
  // doubling the skin changes more than 1 % of a mass
  const auto limits = KnowledgeLimits();
  for (const KnowledgeLimit& limit : limits) EXPECT_GT(limit.change, 1e-4) << limit.input;
  EXPECT_GT(limits.back().change, limits.front().change);
}

TEST(Cost, AnswersASceneWithItsOwnMethodAndThoseOfOthers) {
  const json cost = CostJson(
      {"skin-rms", "--scene", kFixtures + "/lra_adapter.toml", "--accuracy", "1e-6", "--measure"});
  const json& methods = cost.at("methods");
  // which one is the fastest is for this processor to say, so the row is found by its name
  const auto exact = std::ranges::find_if(
      methods, [](const json& method) { return method.at("method") == "exact phasors"; });
  ASSERT_NE(exact, methods.end());
  EXPECT_TRUE(exact->at("answers").get<bool>());
  EXPECT_GT(exact->at("measured_s").get<double>(), 0);
  EXPECT_LE(exact->at("measured_error").get<double>(), 1e-12);
  for (const json& method : methods) {
    EXPECT_LE(method.at("predicted_error").get<double>(), 1e-6) << method;
    EXPECT_GT(method.at("predicted_s").get<double>(), 0) << method;
  }
  EXPECT_GT(methods.size(), 4U);
}

TEST(Cost, OfARecordingIsTheLengthOfTheRoute) {
  const json cost =
      CostJson({"band-rms", "--sensor", "il-030", "--rms", "10um", "--accuracy", "1%"});
  const json& best = cost.at("methods").at(0);
  EXPECT_TRUE(best.at("answers").get<bool>());
  EXPECT_LE(best.at("predicted_error").get<double>(), 0.01);
  EXPECT_GT(best.at("recording_s").get<double>(), 0);
  for (const json& method : cost.at("methods")) {
    EXPECT_THAT(method.at("method").get<std::string>(), HasSubstr("IL-030"));
  }
}

TEST(Cost, OfTheChainHasMoreDigitsForMoreTime) {
  const json chain = CostJson({});
  double before_s = 0;
  for (const json& row : chain.at("simulations")) {
    EXPECT_GE(row.at("smooth_s").get<double>(), before_s);
    before_s = row.at("smooth_s").get<double>();
  }
  EXPECT_EQ(chain.at("recordings").size(), 3U);
  EXPECT_EQ(chain.at("constants").size(), 9U);
}

TEST(Cost, RefusesWhatAQuestionDoesNotLookAt) {
  const auto refused = [](const std::vector<std::string>& words, const char* part) {
    const Outcome outcome = Cost(words);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(part));
  };
  refused({"skin-rm"}, "is none of");
  refused({"km", "kv"}, "second question");
  refused({"km", "--scene", kFixtures + "/lra_adapter.toml"}, "--scene");
  refused({"skin-rms", "--actuator", "thesis-c10-100"}, "--actuator");
  refused({"skin-rms", "--rms", "10um"}, "--rms");
  refused({"km", "--measure"}, "--measure");
  refused({"km", "--accuracy", "30%"}, "25 %");
  refused({"waveform", "--accuracy", "1e-13"}, "1e-11");
  refused({"waveform", "--accuracy", "2"}, "2 lies outside 0 to 1;");
  refused({"--accuracy", "1e-3"}, "of a question");
  refused({"band-rms", "--sensor", "il-999"}, "no route");
}

}  // namespace
}  // namespace haptometer::tools
