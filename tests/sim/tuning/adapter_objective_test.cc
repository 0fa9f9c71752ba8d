#include "sim/tuning/adapter_objective.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "sim/linear/steady_state.h"
#include "tests/residual.h"

namespace haptometer::sim {
namespace {

constexpr const char* kAllowance = "the stated allowance for rounding, 2.5e-11";

const AdapterPoint kPoint{.adapter = {.motor_side_mass_kg = 2e-3,
                                      .skin_side_mass_kg = 5e-3,
                                      .stiffness_n_per_m = 7000,
                                      .damping_n_s_per_m = 0.04},
                          .contact_area_m2 = 20e-6};

MotorSource SourceOf(const TuningProblem& problem) {
  return sim::SourceOf(problem.actuator, problem.drive);
}

SteadyState SteadyOf(const TuningProblem& problem, const Skin& skin) {
  return SolveSteadyState(AssembleModel(problem.actuator, kPoint.adapter, skin), problem.drive,
                          skin);
}

// each by the seven states
TEST(AdapterObjective, IsThatOfTheSteadyState) {
  const TuningProblem problem = ThesisProblem();
  const Skin skin = SkinOf(problem, kPoint.contact_area_m2);
  const SteadyState steady = SteadyOf(problem, skin);
  const auto value = [&](Objective objective, const ReceptorField& receptors = {}) {
    return ValueOf(objective, problem, SourceOf(problem), receptors, kPoint);
  };
  constexpr const char* kRounding = "rounding of two solutions, 2.5e-11 of the source's";
  EXPECT_REL(value(Objective::kSkinRms), steady.skin_rms_m, 1e-10, kRounding);
  const double w = 2 * std::numbers::pi * 225;
  EXPECT_REL(value(Objective::kSkinPower),
             skin.damping_n_s_per_m * std::pow(w * steady.skin_rms_m, 2), 1e-10, kRounding);
  EXPECT_REL(value(Objective::kRmsPerWatt), steady.skin_rms_m / steady.power_w, 1e-10, kRounding);
  for (const double edge_width_m : {0.0, 1e-3}) {
    const ReceptorField receptors{.edge_width_m = edge_width_m};
    const double radius_m = std::sqrt(20e-6 / std::numbers::pi);
    EXPECT_REL(value(Objective::kStimulus, receptors),
               StimulatedReceptors(receptors, radius_m) * steady.skin_rms_m, 1e-10, kRounding);
  }
}

// RMS and stimulus are those of the skin that moves least, here found by a search over all of them
TEST(AdapterObjective, OfSkinsThatVaryIsTheLeast) {
  TuningProblem problem = ThesisProblem();
  problem.skin_variation = 0.3;
  const Skin skin = SkinOf(problem, kPoint.contact_area_m2);
  double least_m = HUGE_VAL;
  for (int k = -10; k <= 10; ++k) {
    for (int i = -10; i <= 10; ++i) {
      const Skin other{.stiffness_n_per_m = skin.stiffness_n_per_m * (1 + 0.03 * k),
                       .damping_n_s_per_m = skin.damping_n_s_per_m * (1 + 0.03 * i)};
      least_m = std::min(least_m, SteadyOf(problem, other).skin_rms_m);
    }
  }
  EXPECT_REL(ValueOf(Objective::kSkinRms, problem, SourceOf(problem), {}, kPoint), least_m, 1e-10,
             "rounding of two solutions, 2.5e-11 of the source's");
}

TEST(AdapterObjective, IsKnownByItsName) {
  for (const Objective objective :
       {Objective::kSkinRms, Objective::kStimulus, Objective::kSkinPower, Objective::kRmsPerWatt}) {
    EXPECT_EQ(ObjectiveOf(Name(objective)), objective);
  }
  EXPECT_FALSE(ObjectiveOf("rms"));
  EXPECT_EQ(UnitOf(ObjectiveOf("skin-power").value()), "W");
  EXPECT_EQ(UnitOf(ObjectiveOf("rms-per-watt").value()), "m/W");
}

// |Fc| / (2 sqrt(b q)) of a lossless adapter; with a damper e the better t of the bracket
// (b + e) t + (q + e) / t - 2 e, here searched
TEST(MatchedLoad, BoundsTheSkinsRmsByTheBestTransformation) {
  for (const double damping : {0.0, 0.02, 0.5}) {
    TuningProblem problem = ThesisProblem();
    problem.bounds.damping_n_s_per_m = {damping, 1};
    const MotorSource source = SourceOf(problem);
    const double w = source.omega_rad_per_s, q = source.stiffness_n_per_m.imag();
    const double b = w * 0.75, e = w * damping;  // the least Bs of the skin's law
    double least = HUGE_VAL;
    for (int k = -40000; k <= 40000; ++k) {
      const double t = std::exp(k * 1e-4);
      least = std::min(least, (b + e) * t + (q + e) / t - 2 * e);
    }
    EXPECT_REL(MatchedLoadBound(Objective::kSkinRms, problem, source, {}),
               std::abs(source.force_n) / least / std::numbers::sqrt2, 2e-8,
               "steps of 1e-4 in ln t: 1e-8 / 2, more by what 2 e takes off");
  }
}

// the hardest of skins that vary has the largest damping
TEST(MatchedLoad, OfSkinsThatVaryIsThatOfTheMostDamped) {
  TuningProblem problem = ThesisProblem();
  problem.fixed_skin = Skin{.stiffness_n_per_m = 900, .damping_n_s_per_m = 1.2};
  problem.skin_variation = 0.25;
  TuningProblem damped = ThesisProblem();
  damped.fixed_skin = Skin{.stiffness_n_per_m = 900, .damping_n_s_per_m = 1.5};
  for (const Objective objective : {Objective::kSkinRms, Objective::kStimulus}) {
    EXPECT_REL(MatchedLoadBound(objective, problem, SourceOf(problem), {}),
               MatchedLoadBound(objective, damped, SourceOf(damped), {}), 1e-14,
               "1.25 times 1.2 N s/m");
  }
}

TEST(MatchedLoad, OfTheStimulusReachesEveryReceptorOfTheLargestContact) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.contact_area_m2 = {2e-6, 12e-6};
  const MotorSource source = SourceOf(problem);
  const double count = StimulatedReceptors({}, std::sqrt(12e-6 / std::numbers::pi));
  EXPECT_REL(MatchedLoadBound(Objective::kStimulus, problem, source, {}),
             count * MatchedLoadBound(Objective::kSkinRms, problem, source, {}), 1e-14, "rounding");
}

// a load Z takes w Im Z |Fc / (kc + Z)|^2 / 2, the most at the conjugate of kc turned round
TEST(MatchedLoad, OfTheSkinsPowerIsThatOfTheBestLoad) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem);
  const std::complex<double> kc = source.stiffness_n_per_m;
  double best_w = 0;
  for (int k = -50; k <= 50; ++k) {
    for (int i = -50; i <= 50; ++i) {
      const std::complex<double> load(-kc.real() + kc.imag() * 0.01 * k,
                                      kc.imag() * std::exp(0.01 * i));
      best_w = std::max(best_w, source.omega_rad_per_s * load.imag() *
                                    std::norm(source.force_n / (kc + load)) / 2);
    }
  }
  EXPECT_REL(MatchedLoadBound(Objective::kSkinPower, problem, source, {}), best_w, 1e-10,
             kAllowance);
}

// with lossless matching the case moves by Fc (z - j) / (2 q), |z| <= 1: the best z by search
TEST(MatchedLoad, OfTheRmsPerWattIsTheBestOfAllLoads) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem);
  const double q = source.stiffness_n_per_m.imag(), b = source.omega_rad_per_s * 0.75;
  double best = 0;
  for (int k = 0; k < 720; ++k) {
    for (int i = 0; i < 500; ++i) {
      const std::complex<double> z = std::polar(i / 500.0, 2 * std::numbers::pi * k / 720);
      const std::complex<double> case_m =
          source.force_n * (z - std::complex<double>(0, 1)) / (2 * q);
      const double skin_m = std::abs(source.force_n) * std::sqrt((1 - std::norm(z)) / (4 * q * b));
      best = std::max(best, skin_m / std::numbers::sqrt2 / ElectricalPower(source, case_m));
    }
  }
  const double bound = MatchedLoadBound(Objective::kRmsPerWatt, problem, source, {});
  EXPECT_LE(best, bound);
  EXPECT_REL(best, bound, 1e-4, "half a step of the search, 1e-3 and 4e-3, squared");
}

// between two steps Nr is the same; the pieces hold all areas, the upper end by itself
TEST(AreaPieces, AreThoseOfEqualCounts) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.contact_area_m2 = {2e-6, 60e-6};
  const std::vector<AreaPiece> pieces = PiecesOf(Objective::kStimulus, problem, {});
  ASSERT_GT(pieces.size(), 3U);
  EXPECT_EQ(pieces.front().problem.bounds.contact_area_m2.lower, 2e-6);
  EXPECT_EQ(pieces.back().problem.bounds.contact_area_m2.lower, 60e-6);
  EXPECT_EQ(pieces.back().problem.bounds.contact_area_m2.upper, 60e-6);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const auto [lower, upper] = pieces[k].problem.bounds.contact_area_m2;
    EXPECT_EQ(pieces[k].objective, Objective::kSkinRms);
    const double inside_m = std::sqrt((lower + upper) / 2 / std::numbers::pi);
    EXPECT_EQ(pieces[k].weight, StimulatedReceptors({}, inside_m)) << k;
    if (k + 1 == pieces.size()) continue;
    EXPECT_EQ(pieces[k + 1].problem.bounds.contact_area_m2.lower, upper);
    if (k + 2 < pieces.size()) {
      EXPECT_GT(pieces[k + 1].weight, pieces[k].weight) << "a step at each";
    }
  }
}

TEST(AreaPieces, AreOneWhereNothingSteps) {
  const TuningProblem problem = ThesisProblem();
  const ReceptorField soft{.edge_width_m = 1e-6};
  EXPECT_FALSE(HasSteps(Objective::kStimulus, soft));
  EXPECT_TRUE(HasSteps(Objective::kStimulus, {}));
  EXPECT_FALSE(HasSteps(Objective::kSkinRms, {}));
  for (const Objective objective : {Objective::kStimulus, Objective::kSkinPower}) {
    const auto pieces = PiecesOf(objective, problem, soft);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_EQ(pieces[0].objective, objective);
    EXPECT_EQ(pieces[0].weight, 1);
    EXPECT_EQ(pieces[0].problem.bounds.contact_area_m2.upper, kSkinAreaMaxM2);
  }
}

// a cost is |Fc / Xs|^2, over w Bs for the power
TEST(CostOfAnAdapter, MeansItsValueAndBack) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem);
  const Skin skin = SkinOf(problem, kPoint.contact_area_m2);
  const AdapterMotion motion = MotionOf(source, kPoint.adapter, skin);
  const double square = std::norm(source.force_n / motion.skin_m);
  const AreaPiece rms{.problem = problem, .objective = Objective::kSkinRms, .weight = 37};
  EXPECT_REL(ValueOfCost(rms, source, square), 37 * std::abs(motion.skin_m) / std::numbers::sqrt2,
             1e-14, "rounding");
  const AreaPiece power{.problem = problem, .objective = Objective::kSkinPower};
  const double b = source.omega_rad_per_s * skin.damping_n_s_per_m;
  EXPECT_REL(ValueOfCost(power, source, square / b),
             ValueOf(Objective::kSkinPower, problem, source, {}, kPoint), 1e-13, "rounding");
  for (const AreaPiece* piece : {&rms, &power}) {
    for (const double cost : {1e4, 3e7}) {
      EXPECT_REL(CostOfValue(*piece, source, ValueOfCost(*piece, source, cost)), cost, 1e-14,
                 "rounding");
    }
  }
}

}  // namespace
}  // namespace haptometer::sim
