#include "tools/compare/compare.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tests/tools/found.h"
#include "tools/compare/measured.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFixtures = HAPTOMETER_FIXTURES;
const std::string kCone = kFixtures + "/lra_cone.toml";
const std::string kAdapter = kFixtures + "/lra_adapter.toml";

// scenes without a run have no rise
constexpr std::size_t kRiseAt = static_cast<std::size_t>(Compared::kRise);

ComparedScene SceneOf(const std::string& path, const std::vector<std::string>& words) {
  auto inputs = ReadInputs(words);
  EXPECT_TRUE(inputs.has_value()) << inputs.error().Text();
  auto scene = ComparedScene::Read(path, *inputs);
  EXPECT_TRUE(scene.has_value()) << scene.error().Text();
  return *std::move(scene);
}

Propagation PropagationOf(const ComparedScene& scene, bool with_rise = false) {
  MeasuredNumbers measured{.upper_hz = 500};
  if (with_rise) measured.numbers[kRiseAt] = dsp::Estimate{};
  auto propagation = Propagate(scene, measured);
  EXPECT_TRUE(propagation.has_value()) << propagation.error().Text();
  return *std::move(propagation);
}

// what a rig would measure of the scene: its numbers with noise
OfCompared<dsp::Estimate> Measured(const ComparedScene& truth, const Eigen::VectorXd& steps,
                                   double share, std::mt19937_64* random, bool with_rise = false) {
  const auto scene = truth.At(steps);
  const auto numbers = SimulatedOf(scene.value(), "truth", with_rise);
  OfCompared<dsp::Estimate> measured{};
  std::normal_distribution<double> normal;
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    const double value = (*numbers)[k].value;
    if (!std::isfinite(value)) continue;
    // a phase near 0 has an uncertainty of its own
    const double u = k == static_cast<std::size_t>(Compared::kPhase) ? 0.002 : share * value;
    // how a rise is found is uncertain too, and drawn
    const double spread = std::hypot(u, (*numbers)[k].uncertainty);
    measured[k] = {value + (random == nullptr ? 0 : spread * normal(*random)), u};
  }
  return measured;
}

std::vector<std::string> KeysIn(const ComparedScene& scene, const std::vector<std::size_t>& set) {
  std::vector<std::string> keys;
  for (const std::size_t k : set) keys.push_back(scene.inputs()[k].key);
  return keys;
}

class CompareVerb : public tests::TemporaryFiles {};

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// --- the equations ---

// one quantity y = a x1 + b x2 of independent inputs: all in closed form
TEST(CompareEquations, OfOneQuantityAreClosedForms) {
  const double a = 3, b = -4, u = 12, d = 26;
  const Agreement agreement =
      Agree(Eigen::VectorXd::Constant(1, d), Eigen::VectorXd::Constant(1, u * u),
            Eigen::RowVector2d(a, b), Eigen::Matrix2d::Identity());
  const double variance = a * a + b * b + u * u;  // 169
  EXPECT_REL(agreement.variance(0), variance, 1e-15, "rounding");
  EXPECT_REL(agreement.chi_squared, d * d / variance, 1e-15, "rounding");
  EXPECT_REL(agreement.adjustment(0), a * d / variance, 1e-15, "rounding");
  EXPECT_REL(agreement.adjustment(1), b * d / variance, 1e-15, "rounding");
  EXPECT_REL(agreement.explained(0), a * a / variance, 1e-15, "rounding");
  // each alone explains all: both pulls are the zeta score, with the sign of the slope
  EXPECT_REL(agreement.pull(0), d / 13, 1e-15, "rounding");
  EXPECT_REL(agreement.pull(1), -d / 13, 1e-15, "rounding");
  EXPECT_REL(agreement.correlation(0, 1), -1, 1e-15, "one quantity tells no two apart");
}

// V = I: pulls are projections, and two inputs at an angle are correlated by its cosine
TEST(CompareEquations, OfTwoInputsAtAnAngle) {
  const double angle = 0.3;
  const double tiny = 1e-6;  // steps far below the measured uncertainty, so that V is its own
  Eigen::Matrix2d changes;
  changes << 1, std::cos(angle), 0, std::sin(angle);
  const Agreement agreement = Agree(Eigen::Vector2d(2, 0), Eigen::Vector2d(1, 1), changes * tiny,
                                    Eigen::Matrix2d::Identity() / tiny);
  EXPECT_REL(agreement.pull(0), 2, 1e-9, "tiny^2");
  EXPECT_REL(agreement.pull(1), 2 * std::cos(angle), 1e-9, "tiny^2");
  EXPECT_REL(agreement.correlation(0, 1), std::cos(angle), 1e-9, "tiny^2");
}

// correlated inputs: with C = F F^T any factor gives the same numbers
TEST(CompareEquations, DoNotDependOnTheFactorOfC) {
  Eigen::MatrixXd sensitivity(3, 2);
  sensitivity << 1, -2, 0.5, 1, 3, 0.2;
  Eigen::Matrix2d factor, turn;
  factor << 1, 0, 0.8, 0.6;
  turn << std::cos(1), -std::sin(1), std::sin(1), std::cos(1);
  const Eigen::Vector3d d(1, 2, -1), own(0.1, 0.2, 0.3);
  const Agreement one = Agree(d, own, sensitivity * factor, factor);
  const Agreement other = Agree(d, own, sensitivity * factor * turn, factor * turn);
  EXPECT_LT((one.variance - other.variance).norm(), 1e-14);
  EXPECT_LT((one.pull - other.pull).norm(), 1e-13);
  EXPECT_LT((one.correlation - other.correlation).norm(), 1e-13);
  // S C S^T, written out
  const Eigen::MatrixXd c = factor * factor.transpose();
  const Eigen::MatrixXd v = sensitivity * c * sensitivity.transpose();
  EXPECT_LT((one.variance - v.diagonal() - own).norm(), 1e-14);
}

// a perfectly known quantity beside one that copies it: V is singular but for 1e-17
TEST(CompareEquations, EndureQuantitiesThatSayTheSame) {
  const Agreement agreement =
      Agree(Eigen::Vector2d(1, 1), Eigen::Vector2d(1e-30, 1e-30),
            Eigen::MatrixXd::Constant(2, 1, 0.5), Eigen::MatrixXd::Identity(1, 1));
  EXPECT_REL(agreement.pull(0), 2, 1e-9, "one direction is left");
}

// y = amplitude: S = y / V of a linear scene, so u(y)/y = u(V)/V, exactly
TEST(CompareScene, PropagatesTheVoltageExactly) {
  const ComparedScene scene = SceneOf(kCone, {"drive.amplitude_v=5+-0.1"});
  const Propagation propagation = PropagationOf(scene);
  const double rms_m = propagation.at[0].value;
  EXPECT_REL(rms_m, 46.1001664e-6, 1e-8, "the digits that the fixture states");
  EXPECT_REL(propagation.changes(0, 0), rms_m * 0.1 / 5, 1e-11, "rounding of a difference");
  const auto power = static_cast<Eigen::Index>(Compared::kPower);
  EXPECT_REL(propagation.changes(power, 0), propagation.at[4].value * 2 * 0.1 / 5, 1e-11,
             "P ~ V^2, whose central difference is exact");
  EXPECT_ABS(propagation.curvature(power, 0), propagation.at[4].value * 0.02 * 0.02, 1e-13, "V^2");
  EXPECT_ABS(propagation.changes(1, 0), 0, 1e-15, "the tone does not depend on it");
}

// a phase beside +-pi
// a measurement at the tone holds nothing of it
TEST(CompareScene, LeavesOutWhatAnOffsetAdds) {
  const ComparedScene scene = SceneOf(kCone, {"drive.amplitude_v=5+-0.1"});
  const auto plain = scene.At(Eigen::VectorXd::Zero(1));
  ASSERT_TRUE(plain);
  sim::Scene offset = *plain;
  offset.drive.offset_v = 1;
  const auto without = SimulatedOf(*plain, "cone", false);
  const auto with = SimulatedOf(offset, "cone", false);
  ASSERT_TRUE(without && with);
  for (const Compared quantity : {Compared::kRms, Compared::kCurrent, Compared::kPower}) {
    const auto k = static_cast<std::size_t>(quantity);
    EXPECT_REL((*with)[k].value, (*without)[k].value, 1e-12, "a difference of like numbers");
  }
}

TEST(CompareNumbers, AverageAcrossPi) {
  OfCompared<dsp::Estimate> one{}, other{};
  const auto phase = static_cast<std::size_t>(Compared::kPhase);
  one[phase] = dsp::Estimate{3.1, 0.01};
  other[phase] = dsp::Estimate{-3.1, 0.01};
  const auto mean = MeanOf(std::array{one, other});
  ASSERT_TRUE(mean[phase]);
  EXPECT_ABS(std::remainder(mean[phase]->value - std::numbers::pi, 2 * std::numbers::pi), 0, 1e-12,
             "halfway between them");
  EXPECT_LT(mean[phase]->uncertainty, 0.1);
}

TEST(CompareScene, TakesPhasesWithinPi) {
  EXPECT_ABS(DeviationOf(Compared::kPhase, 3.1, -3.1), 6.2 - 2 * std::numbers::pi, 1e-15,
             "rounding");
  EXPECT_EQ(DeviationOf(Compared::kRms, 3.1, -3.1), 6.2);
}

// --- bars ---

struct Scores {
  double sum = 0, squares = 0;
  void Add(double z) { sum += z, squares += z * z; }
};

// mean and standard deviation of zeta over trials whose inputs are drawn from their uncertainties
TEST_F(CompareVerb, ZetaIsStandardNormalOnSimulatedTruth) {
  constexpr int kSeeds = 800;
  // a run from rest, which has a rise
  const ComparedScene scene =
      SceneOf(File("run.toml", TextOf(kAdapter) + "[run]\nduration_s = 0.12\nstart = \"rest\"\n"),
              {"skin.stiffness_n_per_m=500:700", "skin.damping_n_s_per_m=0.75+-0.03",
               "drive.amplitude_v=5+-0.05", "drive.frequency_hz=225+-0.1",
               "adapter.stiffness_n_per_m=8200+-40", "actuator.resistance_ohm=27+-0.3",
               "actuator.force_constant_n_per_a=1.0+-0.02"});
  const Propagation propagation = PropagationOf(scene, true);
  std::mt19937_64 random(19);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-std::numbers::sqrt3, std::numbers::sqrt3);
  std::array<Scores, kComparedCount> scores{};
  std::vector<Scores> pulls(scene.inputs().size());
  for (int seed = 0; seed < kSeeds; ++seed) {
    Eigen::VectorXd steps(static_cast<Eigen::Index>(scene.inputs().size()));
    for (Eigen::Index j = 0; j < steps.size(); ++j) {
      // the one range is rectangular, of standard deviation 1
      const bool is_range =
          scene.inputs()[static_cast<std::size_t>(j)].key == "skin.stiffness_n_per_m";
      steps(j) = is_range ? uniform(random) : normal(random);
    }
    const auto result = Compare(Measured(scene, steps, 0.002, &random, true), scene, propagation);
    ASSERT_EQ(result.quantities.size(), 6U);
    for (const ComparedQuantity& one : result.quantities) {
      scores[static_cast<std::size_t>(one.quantity)].Add(one.Zeta());
    }
    for (std::size_t j = 0; j < pulls.size(); ++j) {
      pulls[j].Add(result.agreement.pull(static_cast<Eigen::Index>(j)));
    }
  }
  const auto check = [&](const Scores& one, const std::string& what) {
    const double mean = one.sum / kSeeds;
    const double sd = std::sqrt(one.squares / kSeeds - mean * mean);
    std::printf("%-34s mean %6.3f, sd %.3f\n", what.c_str(), mean, sd);
    // of 800 normal scores: 0 +- 0.035 and 1 +- 0.025
    EXPECT_LT(std::abs(mean), 0.1) << what;
    EXPECT_GT(sd, 0.9) << what;
    EXPECT_LT(sd, 1.1) << what;
  };
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    check(scores[k], std::string(KeyOf(static_cast<Compared>(k), scene.target()).name));
  }
  for (std::size_t j = 0; j < pulls.size(); ++j) check(pulls[j], scene.inputs()[j].key);
}

// each input 5 % wrong in its turn, all else as stated: it is the first, or in the first's set
TEST(CompareBars, AWrongInputIsFirstOrInTheSetOfTheFirst) {
  const std::vector<std::pair<std::string, double>> inputs{{"skin.stiffness_n_per_m", 600},
                                                           {"skin.damping_n_s_per_m", 0.75},
                                                           {"drive.amplitude_v", 5},
                                                           {"adapter.skin_side_mass_kg", 4.35e-3},
                                                           {"adapter.stiffness_n_per_m", 8200},
                                                           {"actuator.moving_mass_kg", 1.4e-3},
                                                           {"actuator.stiffness_n_per_m", 2800},
                                                           {"actuator.resistance_ohm", 27},
                                                           {"actuator.damping_n_s_per_m", 0.0322},
                                                           {"actuator.force_constant_n_per_a", 1}};
  for (const std::string& path : {kCone, kAdapter}) {
    for (const auto& [wrong, true_value] : inputs) {
      if (path == kCone && wrong.starts_with("adapter")) continue;
      for (const double factor : {0.95, 1.05}) {
        std::vector<std::string> words;
        for (const auto& [key, value] : inputs) {
          if (path == kCone && key.starts_with("adapter")) continue;
          const double stated = key == wrong ? value * factor : value;
          const char* unit = key.ends_with("_kg") ? "kg" : "";
          words.push_back(
              fmt::format("{0}={1:.9g}{3}+-{2:.9g}{3}", key, stated, 0.01 * value, unit));
        }
        const ComparedScene scene = SceneOf(path, words);
        const auto place =
            std::ranges::find(scene.inputs(), wrong, &ComparedInput::key) - scene.inputs().begin();
        // the truth lies that many standard uncertainties away
        Eigen::VectorXd steps =
            Eigen::VectorXd::Zero(static_cast<Eigen::Index>(scene.inputs().size()));
        steps(place) = (1 - factor) / 0.01;
        const Propagation propagation = PropagationOf(scene);
        auto result = Compare(Measured(scene, steps, 0.001, nullptr), scene, propagation);
        FindCauses(scene, propagation, result);
        const auto& first = result.sets.front();
        std::printf("%-10s %-32s x %.2f: set of %zu%s, pull %.2f\n",
                    path == kCone ? "cone" : "adapter", wrong.c_str(), factor, first.size(),
                    scene.inputs()[first.front()].key == wrong ? ", first" : "",
                    result.agreement.pull(static_cast<Eigen::Index>(first.front())));
        EXPECT_THAT(KeysIn(scene, first), Contains(wrong)) << path << " x " << factor;
        if (first.size() == 1) {
          EXPECT_EQ(scene.inputs()[first.front()].key, wrong);
        }
      }
    }
  }
}

// the factors of J. Lindsay, 2013, p. 29: what compare.md says of them
TEST(CompareBars, ThesisFactorsReadAsThePageSays) {
  const auto score = [](double measured, double simulated, double share) {
    const double u = std::hypot(share * measured, share * simulated);
    const Agreement agreement =
        Agree(Eigen::VectorXd::Constant(1, measured - simulated),
              Eigen::VectorXd::Constant(1, u * u), Eigen::MatrixXd(1, 0), Eigen::MatrixXd(0, 0));
    return std::sqrt(agreement.chi_squared) / 2;
  };
  EXPECT_NEAR(score(4.25, 4.40, 0.1), 0.12, 0.005);
  EXPECT_NEAR(score(3.26, 2.28, 0.1), 1.23, 0.005);
  EXPECT_NEAR(score(3.26, 2.28, 0.15), 0.82, 0.005);
}

// --- reading ---

json TrialJson() {
  return {{"trials",
           {{{"file", "a.bin"},
             {"answered", true},
             {"reasons", json::array()},
             {"data_source", {"device"}},
             {"band", {{"lower_hz", 20}, {"upper_hz", 500}}},
             {"band_rms_m", 46e-6},
             {"band_rms_standard_uncertainty_m", 0.3e-6},
             {"tone_frequency_hz", 225.0},
             {"tone_frequency_standard_uncertainty_hz", 0.01},
             {"onset", nullptr},
             {"electrical", nullptr}}}},
          {"findings", json::array()}};
}

Outcome Answer(const std::vector<std::string>& words) {
  return Captured(RunCompare, "compare", words);
}

TEST_F(CompareVerb, TakesTheActuatorsCovarianceWithItsCorrelations) {
  const std::string path =
      File("correlated.toml",
           "[actuator]\nmoving_mass_kg = \"1.400(28)g\"\ncase_mass_kg = 0.6e-3\n"
           "stiffness_n_per_m = \"2800(56)\"\ndamping_n_s_per_m = 0.0322\n"
           "force_constant_n_per_a = 1.0\nresistance_ohm = 27\ninductance_h = 130e-6\n"
           "[actuator.correlation]\nMv_Kv = 1.0\n"
           "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n"
           "[drive]\nkind = \"sine\"\namplitude_v = 5\nfrequency_hz = 225\n");
  const ComparedScene scene = SceneOf(path, {});
  ASSERT_EQ(scene.inputs().size(), 2U);
  EXPECT_EQ(scene.inputs()[0].key, "actuator.moving_mass_kg");
  EXPECT_REL(scene.inputs()[1].value.standard_uncertainty, 56, 1e-12, "as stated");
  const Eigen::MatrixXd& factor = scene.factor();
  const Eigen::MatrixXd correlation = factor * factor.transpose();
  EXPECT_LT((correlation - Eigen::MatrixXd::Constant(2, 2, 1)).norm(), 1e-12);
  // of rank 1: one column changes both alike, so that f0 stays
  EXPECT_LT(factor.col(1).norm(), 1e-7);
}

constexpr const char* kOnSkin =
    "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n"
    "[drive]\nkind = \"sine\"\namplitude_v = 5\nfrequency_hz = 225\n";
constexpr const char* kActuator =
    "moving_mass_kg = \"1.400(28)g\"\ncase_mass_kg = 0.6e-3\nstiffness_n_per_m = \"2800(56)\"\n"
    "damping_n_s_per_m = 0.0322\nforce_constant_n_per_a = 1.0\nresistance_ohm = 27\n"
    "inductance_h = 130e-6\n[correlation]\nMv_Kv = 0.97\n";

// an actuator from a file: what is stated of a number replaces what the file says of it
TEST_F(CompareVerb, TakesAnInputInThePlaceOfTheActuatorsFile) {
  const std::string path =
      File("scene.toml",
           fmt::format("[actuator]\nfile = \"{}\"\n{}", File("actuator.toml", kActuator), kOnSkin));
  const ComparedScene scene = SceneOf(path, {"actuator.stiffness_n_per_m=2900+-29"});
  ASSERT_EQ(KeysIn(scene, {0, 1}),
            (std::vector<std::string>{"actuator.stiffness_n_per_m", "actuator.moving_mass_kg"}));
  EXPECT_LT((scene.factor() - Eigen::Matrix2d::Identity()).norm(), 1e-15) << "no correlation";
  const auto stated = scene.At(Eigen::Vector2d::Zero());
  EXPECT_REL(stated->actuator.stiffness_n_per_m, 2900, 1e-15, "as stated");
  EXPECT_REL(stated->actuator.moving_mass_kg, 1.4e-3, 1e-15, "of the file");
  const auto changed = scene.At(Eigen::Vector2d(1, 0));
  EXPECT_REL(changed->actuator.stiffness_n_per_m, 2900 * std::exp(0.01), 1e-12, "by a factor");
  // the built-in actuator too; a number that no actuator has is refused
  const std::string model =
      File("model.toml", std::string("[actuator]\nmodel = \"thesis-c10-100\"\n") + kOnSkin);
  const std::string result = File("r.json", TrialJson().dump());
  const auto input = [&](const char* word) { return Answer({result, model, "--input", word}); };
  EXPECT_THAT(input("actuator.resistance_ohm=27+-1").out, HasSubstr("27.0(10)"));
  EXPECT_THAT(input("actuator.stiffness_n_per_m=-5+-1").err, HasSubstr("-5 is outside 1e-09"));
}

TEST_F(CompareVerb, SaysWhichInputsItMovesTogether) {
  const std::string path =
      File("scene.toml",
           fmt::format("[actuator]\nfile = \"{}\"\n{}", File("actuator.toml", kActuator), kOnSkin));
  json trials = TrialJson();
  trials["trials"][0]["band_rms_m"] = 90e-6;
  const std::string result = File("r.json", trials.dump());
  const std::string said =
      "actuator.moving_mass_kg, actuator.stiffness_n_per_m are correlated: where one explains "
      "most at a value, the others are moved with it";
  EXPECT_THAT(Answer({result, path}).out, HasSubstr(said));
  // alone it has nothing to be moved with
  EXPECT_THAT(Answer({result, path, "--input", "actuator.stiffness_n_per_m=2800+-56"}).out,
              AllOf(HasSubstr("explains most at"), Not(HasSubstr("are correlated"))));
}

TEST_F(CompareVerb, TakesRepeatsAsOneMeasurement) {
  json trials = TrialJson();
  trials["trials"].push_back(trials["trials"][0]);
  trials["trials"][1]["band_rms_m"] = 48e-6;
  trials["trials"][1]["band_rms_standard_uncertainty_m"] = 0.5e-6;
  const std::vector<std::string> files{File("r.json", trials.dump())};
  const auto measured = ReadMeasured(files);
  ASSERT_TRUE(measured.has_value()) << measured.error().Text();
  // u^2 = s^2/n + mean of u^2: s^2 = 2, n = 2, mean of 0.09 and 0.25, um^2
  EXPECT_REL(measured->numbers[0]->value, 47e-6, 1e-14, "rounding");
  EXPECT_REL(measured->numbers[0]->uncertainty, std::sqrt(1 + 0.17) * 1e-6, 1e-12, "rounding");
  EXPECT_EQ(measured->sources.size(), 1U);
  EXPECT_FALSE(measured->is_calibrated);
}

TEST_F(CompareVerb, DoubtsRepeatsOfDifferentSubjectsOrConditions) {
  const auto labelled = [&](const std::string& name, const std::vector<std::string>& labels) {
    const std::string path = directory_ / name;
    std::filesystem::copy_file(kFixtures + "/recorded_trial.bin", path);
    std::vector<std::string> words{"label", path};
    words.insert(words.end(), labels.begin(), labels.end());
    EXPECT_EQ(Captured(RunTrial, "trial", words).status, 0);
    return path;
  };
  const std::string one = labelled("1.bin", {"subject=3", "condition=stock", "repeat=1"});
  const std::string again = labelled("2.bin", {"subject=3", "condition=stock", "repeat=2"});
  const std::string other = labelled("3.bin", {"subject=3", "condition=ia1", "repeat=1"});
  EXPECT_THAT(Answer({one, other, again, kAdapter}).out,
              AllOf(HasSubstr("but their conditions are ia1, stock: compare those of one condition "
                              "at a time"),
                    Not(HasSubstr("their subjects"))));
  EXPECT_THAT(KindsOf(json::parse(Answer({one, again, kAdapter, "--json"}).out)),
              Not(Contains("labels-differ")));
}

// a mean of trials that differ so much agrees with nearly everything
TEST_F(CompareVerb, DoubtsRepeatsThatAreNone) {
  json trials = TrialJson();
  trials["trials"].push_back(trials["trials"][0]);
  trials["trials"][1]["band_rms_m"] = 5.5e-6;
  const std::string both = File("both.json", trials.dump());
  const Outcome doubted = Answer({both, kCone, "--json"});
  EXPECT_EQ(doubted.status, 3);
  EXPECT_THAT(KindsOf(json::parse(doubted.out)), Contains("repeats-differ"));
  EXPECT_TRUE(json::parse(doubted.out).at("agrees").is_null());
  EXPECT_THAT(Answer({both, kCone}).out,
              AllOf(HasSubstr("more than twice the smallest, beyond their uncertainties, of skin "
                              "displacement (RMS)"),
                    Not(HasSubstr("at most 1)  yes"))));
  // within their uncertainties, or below twice
  trials["trials"][1]["band_rms_standard_uncertainty_m"] = 25e-6;
  EXPECT_THAT(KindsOf(json::parse(Answer({File("u.json", trials.dump()), kCone, "--json"}).out)),
              Not(Contains("repeats-differ")));
  trials["trials"][1]["band_rms_standard_uncertainty_m"] = 1e-8;
  trials["trials"][1]["band_rms_m"] = 24e-6;
  EXPECT_THAT(KindsOf(json::parse(Answer({File("near.json", trials.dump()), kCone, "--json"}).out)),
              Not(Contains("repeats-differ")));
}

TEST_F(CompareVerb, SaysThatAnAdjustedValueIsOutsideItsRange) {
  json trials = TrialJson();
  const std::string agreeing = File("agrees.json", trials.dump());
  trials["trials"][0]["band_rms_m"] = 5e-6;
  const std::string weak = File("weak.json", trials.dump());
  const auto answer = [](const std::string& file, const std::string& input) {
    return Answer({file, kCone, "--input", "skin.stiffness_n_per_m=" + input}).out;
  };
  EXPECT_THAT(answer(weak, "1000:3000"),
              HasSubstr("outside of the range that is stated, by more than its uncertainty: "
                        "skin.stiffness_n_per_m"));
  EXPECT_THAT(answer(agreeing, "1200:2500"), Not(HasSubstr("outside of the range")));
}

TEST_F(CompareVerb, DoubtsUnusualNumbersOfTheScene) {
  const std::string trial = File("trial.json", TrialJson().dump());
  EXPECT_THAT(Answer({trial, kCone}).out, Not(HasSubstr("is unusual")));
  EXPECT_THAT(Answer({trial, kCone, "--input", "skin.stiffness_n_per_m=600000+-1"}).out,
              HasSubstr("doubt: skin.stiffness_n_per_m = 600000 is unusual"));
}

TEST_F(CompareVerb, HasTheNumbersThatScriptsRelyOn) {
  const Outcome outcome = Answer(
      {File("r.json", TrialJson().dump()), kCone, "--json", "--uncertainty", "band_rms_m=1%"});
  EXPECT_EQ(outcome.status, 2) << "the quantity's name is skin_rms_m";
  const std::string result = File("s.json", TrialJson().dump());
  const Outcome good = Answer({result, kCone, "--json", "--uncertainty", "skin_rms_m=1%"});
  EXPECT_EQ(good.status, 0) << good.err;
  const json answer = json::parse(good.out);
  ASSERT_EQ(answer.at("quantities").size(), 2U);
  const json& rms = answer.at("quantities").at(0);
  EXPECT_EQ(rms.at("key"), "skin_rms_m");
  EXPECT_EQ(rms.at("measured"), 46e-6);
  const double u = std::hypot(0.3e-6, 0.46e-6);
  EXPECT_REL(rms.at("measured_uncertainty").get<double>(), u, 1e-12, "root of the squares");
  EXPECT_EQ(rms.at("simulated_uncertainty"), 0);
  EXPECT_REL(rms.at("normalized_error").get<double>(),
             (46e-6 - rms.at("simulated").get<double>()) / (2 * u), 1e-12, "E_n, k = 2");
  EXPECT_REL(rms.at("smallest_deviation").get<double>(), 2 * u, 1e-12, "k = 2");
  EXPECT_THAT(KindsOf(answer), Contains("inputs-exact"));
}

TEST_F(CompareVerb, NamesWhatWouldExplainADifference) {
  json trials = TrialJson();
  trials["trials"][0]["band_rms_m"] = 50e-6;
  const std::string result = File("r.json", trials.dump());
  const Outcome outcome = Answer({result, kCone, "--input", "drive.amplitude_v=5+-0.1", "--input",
                                  "actuator.resistance_ohm=27+-0.5"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.out, HasSubstr("expanded uncertainties: skin displacement (RMS)"));
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("would explain it: one of "),
                                 HasSubstr(", which cannot be distinguished")));
  // a tone that is off is none of theirs
  trials["trials"][0]["tone_frequency_hz"] = 226;
  const std::string off = File("off.json", trials.dump());
  EXPECT_THAT(Answer({off, kCone, "--input", "drive.amplitude_v=5+-0.1"}).out,
              HasSubstr("no stated input explains it alone"));
}

TEST_F(CompareVerb, DoubtsAQuantityThatIsNotLinear) {
  // the adapter's resonance lies within the spring's uncertainty
  const std::string result = File("r.json", TrialJson().dump());
  EXPECT_THAT(Answer({result, kAdapter, "--input", "adapter.stiffness_n_per_m=8200+-800"}).out,
              HasSubstr("does not depend linearly on adapter.stiffness_n_per_m"));
  EXPECT_THAT(Answer({result, kAdapter, "--input", "drive.amplitude_v=5+-0.1"}).out,
              Not(HasSubstr("linearly")));
}

// 2500 standard uncertainties away
TEST_F(CompareVerb, FindsAnInputThatIsFarOff) {
  std::string scene = TextOf(kAdapter);
  const std::string frequency = "frequency_hz = 225";
  ASSERT_NE(scene.find(frequency), std::string::npos);
  scene.replace(scene.find(frequency), frequency.size(), "frequency_hz = 200");
  const json answer =
      json::parse(Answer({kFixtures + "/recorded_trial.bin", File("far.toml", scene), "--input",
                          "drive.frequency_hz=200+-0.01", "--json"})
                      .out);
  EXPECT_THAT(KindsOf(answer), AllOf(Contains("explained-by"), Not(Contains("not-explained"))));
  EXPECT_ABS(answer["inputs"][0]["explaining_value"].get<double>(), 225, 0.02,
             "the tone of the trial is 224.995(2) Hz");
}

TEST_F(CompareVerb, NamesNoInputThatCannotExplainTheDifference) {
  // a spring that is 10 % too stiff: no damping of the skin makes up for it, not even none
  std::string scene = TextOf(kAdapter);
  const std::string spring = "stiffness_n_per_m = 2800";
  ASSERT_NE(scene.find(spring), std::string::npos);
  scene.replace(scene.find(spring), spring.size(), "stiffness_n_per_m = 3080");
  const auto outcome =
      Answer({kFixtures + "/recorded_trial.bin", File("stiff.toml", scene), "--input",
              "actuator.stiffness_n_per_m=3080+-30", "--input", "skin.damping_n_s_per_m=0.75+-0.01",
              "--input", "drive.frequency_hz=225+-0.01", "--json"});
  const json answer = json::parse(outcome.out);
  for (const json& input : answer["inputs"]) {
    if (input["key"] != "skin.damping_n_s_per_m") continue;
    EXPECT_GE(input["explaining_value"].get<double>(), 0) << "a damping below 0 is refused";
  }
  std::string causes;
  for (const json& finding : answer["findings"]) {
    if (finding["kind"] == "explained-by") causes = finding["text"];
  }
  EXPECT_EQ(causes, "a wrong value would explain it: actuator.stiffness_n_per_m");
}

// --- study compare ---

TEST_F(CompareVerb, AStudyRefusesAWrongInputBeforeItsTrials) {
  // an analysis of this one would be told of first
  const std::string trials = directory_ / "trials";
  std::filesystem::create_directory(trials);
  std::ofstream(trials + "/1_a_1.bin") << "no trial";
  const auto refused = [&](const std::vector<std::string>& further) {
    std::vector<std::string> words{"compare", trials, "--pattern",
                                   "{subject}_{condition}_{repeat}"};
    words.insert(words.end(), further.begin(), further.end());
    const Outcome outcome = Captured(RunStudy, "study", words);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(refused({kAdapter, "--input", "drive.amplitud_v=5+-1"}),
              HasSubstr("--input drive.amplitud_v"));
  EXPECT_THAT(refused({kAdapter, "--input", "a:drive.amplitude_v=5"}),
              HasSubstr("has no uncertainty"));
  EXPECT_THAT(refused({"--condition", "a=" + kAdapter, "--input", "a:drive.amplitud_v=5+-1"}),
              HasSubstr("--input drive.amplitud_v"));
  EXPECT_THAT(refused({"--condition", "stock"}), HasSubstr("write e.g. adapter=adapter.toml"));
}

TEST_F(CompareVerb, AStudyNamesItsOwnOptionForAnotherBand) {
  const std::string trials = directory_ / "trials";
  std::filesystem::create_directory(trials);
  std::filesystem::copy_file(kFixtures + "/recorded_trial.bin", trials + "/1_a_1.bin");
  std::string scene = TextOf(kAdapter);
  const std::string frequency = "frequency_hz = 225";
  scene.replace(scene.find(frequency), frequency.size(), "frequency_hz = 600");
  const Outcome outcome = Captured(
      RunStudy, "study",
      {"compare", trials, File("high.toml", scene), "--pattern", "{subject}_{condition}_{repeat}"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_THAT(outcome.err, HasSubstr("outside of the 20 to 500 Hz that the measured RMS is of; "
                                     "give another --band\n"));
}

TEST_F(CompareVerb, RefusesMistakesInOneLine) {
  const std::string good = File("good.json", TrialJson().dump());
  json refused = TrialJson();
  refused["trials"][0]["answered"] = false;
  refused["trials"][0]["reasons"] = {"no drive above the noise"};
  const std::string none = File("none.json", refused.dump());
  json limited = TrialJson();
  limited["trials"][0]["band_rms_m"] = nullptr;
  const std::string limit = File("limit.json", limited.dump());
  const std::string other = File("other.json", R"({"skin_rms_m": 1, "findings": []})");
  const std::string broken = File("broken.json", "{\"trials\": [");
  struct Case {
    std::vector<std::string> words;
    int status;
    std::string said;
  };
  const std::vector<Case> cases{
      {{}, 2, "has no trial and no scene"},
      {{good}, 2, "put the scene.toml last"},
      {{kCone}, 2, "put a trial before the scene"},
      {{kCone, good}, 2, "stands behind the scene"},
      {{kCone, good, kCone}, 2, "is a second scene"},
      {{none, kCone}, 3, "a.bin: no drive above the noise"},
      {{limit, kCone}, 3, "a.bin: has an upper limit in place of an RMS"},
      {{other, kCone}, 3, "is no result of analyze"},
      {{broken, kCone}, 3, "is no result of analyze"},
      {{"absent.bin", kCone}, 3, "absent.bin"},
      {{good, "absent.toml"}, 3, "absent.toml"},
      {{good, kCone, "--input", "skin.stifness_n_per_m=600+-5"}, 2, "is not known"},
      {{good, kCone, "--input", "skin.stiffness_n_per_m=600"}, 2, "has no uncertainty"},
      {{good, kCone, "--input", "skin.stiffness_n_per_m=700:600"}, 2, "is not a range"},
      {{good, kCone, "--input", "skin.stiffness_n_per_m"},
       2,
       "is not KEY=VALUE; write e.g. skin.stiffness_n_per_m=600+-50"},
      {{good, kCone, "--uncertainty", "1%"}, 2, "write e.g. current_rms_a=1%"},
      {{good, kCone, "--input", "drive.amplitude_v=5+-0.1mm"}, 2, "--input drive.amplitude_v"},
      {{good, kCone, "--input", "skin.stiffness_n_per_m=600+-700"}, 2, "must not be negative"},
      {{good, kCone, "--input", "drive.frequency_hz=600+-1"}, 3, "outside of the 20 to 500 Hz"},
      {{good, kCone, "--uncertainty", "current_rms_a=1%"}, 3, "is not measured"},
      {{good, kCone, "--input", "drive.amplitude_v=5+-1", "--input", "drive.amplitude_v=6+-1"},
       2,
       "--input: drive.amplitude_v is given twice"},
      {{good, kFixtures + "/lra_burst.toml"}, 3, "and has no duration; give duration_s in [run]\n"},
      {{good, kCone, "--uncertainty", "skin_rms_m=0%"}, 2, "must be above 0"}};
  for (const Case& one : cases) {
    const Outcome outcome = Answer(one.words);
    const std::string what = fmt::format("{}", fmt::join(one.words, " "));
    EXPECT_EQ(outcome.status, one.status) << what << ": " << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(one.said)) << what;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << what << ": " << outcome.err;
  }
}

}  // namespace
}  // namespace haptometer::tools
