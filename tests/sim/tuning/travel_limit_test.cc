#include "sim/tuning/travel_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "sim/linear/steady_state.h"
#include "sim/tuning/adapter_optimum.h"
#include "tests/residual.h"
#include "tests/sim/tuning/adapter_reference.h"
#include "tests/sim/tuning/limited_reference.h"

namespace haptometer::sim {
namespace {

TuningProblem Limited(double mover_limit_m) {
  TuningProblem problem = ThesisProblem();
  problem.mover_limit_m = mover_limit_m;
  return problem;
}

// by the seven states
double TravelOf(const TuningProblem& problem, const AdapterPoint& point) {
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  return SolveSteadyState(AssembleModel(problem.actuator, point.adapter, skin), problem.drive, skin)
      .mover_peak_m;
}

AdapterPoint Anywhere(const AdapterBounds& bounds, std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1);
  return {.adapter = {.motor_side_mass_kg = bounds.motor_side_mass_kg.At(part(random)),
                      .skin_side_mass_kg = bounds.skin_side_mass_kg.At(part(random)),
                      .stiffness_n_per_m = bounds.stiffness_n_per_m.At(part(random)),
                      .damping_n_s_per_m = bounds.damping_n_s_per_m.At(part(random))},
          .contact_area_m2 = AreaAt(bounds.contact_area_m2, part(random))};
}

TEST(MoverTravel, IsThatOfTheSevenStates) {
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  std::mt19937 random(4);
  for (int trial = 0; trial < 300; ++trial) {
    const AdapterPoint point = Anywhere(problem.bounds, random);
    const AdapterMotion motion =
        MotionOf(source, point.adapter, SkinOf(problem, point.contact_area_m2));
    EXPECT_REL(MoverTravel(source, motion.case_m), TravelOf(problem, point), 1e-11,
               "the source's allowance");
  }
}

// against a fine grid of masses, each solved by the seven states
TEST(TravelLimit, TakesTheNearestMassThatKeepsToIt) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> limits(0.05e-3, 1e-3), masses(-2e-3, 14e-3);
  int limited = 0, none = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const TuningProblem problem = Limited(limits(random));
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    AdapterPoint point = Anywhere(problem.bounds, random);
    const double wanted_kg = masses(random);
    const auto found = NearestWithinTravel(problem, source, point, wanted_kg);
    if (found) {
      point.adapter.skin_side_mass_kg = *found;
      EXPECT_LE(TravelOf(problem, point), problem.mover_limit_m * (1 + 1e-9));
      EXPECT_GE(*found, problem.bounds.skin_side_mass_kg.lower);
      EXPECT_LE(*found, problem.bounds.skin_side_mass_kg.upper);
      limited += std::abs(TravelOf(problem, point) / problem.mover_limit_m - 1) < 1e-9 ? 1 : 0;
    } else {
      ++none;
    }
    const double distance_kg = found ? std::abs(*found - wanted_kg) : HUGE_VAL;
    constexpr int kMasses = 200;
    for (int k = 0; k <= kMasses; ++k) {
      const double mass_kg = problem.bounds.skin_side_mass_kg.At(k / double{kMasses});
      point.adapter.skin_side_mass_kg = mass_kg;
      if (std::abs(mass_kg - wanted_kg) >= distance_kg * (1 - 1e-9)) continue;
      ASSERT_GT(TravelOf(problem, point), problem.mover_limit_m * (1 - 1e-9)) << trial << ' ' << k;
    }
  }
  EXPECT_GT(limited, 5) << "cases in which the limit holds";
  EXPECT_GT(none, 5) << "cases without any mass";
}

TEST(TravelLimit, OptimumIsThatOfThirtyDigits) {
  const TuningProblem problem = Limited(0.4e-3);
  const AdapterOptimum optimum = FindAdapterOptimum(Objective::kSkinRms, problem, {});
  EXPECT_REL(optimum.value, tests::kLimitedBest, 1e-11, "the limit is met to that");
  EXPECT_REL(optimum.point.adapter.stiffness_n_per_m, tests::kLimitedBestKa, 1e-6, "flat");
  EXPECT_REL(optimum.point.adapter.skin_side_mass_kg, tests::kLimitedBestMa2, 1e-6, "flat");
  EXPECT_LE(TravelOf(problem, optimum.point), 0.4e-3 * (1 + 1e-9));
  EXPECT_EQ(optimum.proof, Proof::kBranchAndBound);
  EXPECT_GT(optimum.upper_bound, optimum.value);
  EXPECT_LT(optimum.upper_bound / optimum.value - 1, 2e-9) << "the gap that was asked for";
}

TuningProblem ProblemOf(const tests::LimitedCase& limited) {
  TuningProblem problem = Limited(limited.limit_m);
  if (limited.amplitude_v > 0) problem.drive.amplitude_v = limited.amplitude_v;
  if (limited.frequency_hz > 0) problem.drive.frequency_hz = limited.frequency_hz;
  if (limited.skin_stiffness > 0) {
    problem.fixed_skin = Skin{limited.skin_stiffness, limited.skin_damping};
  }
  if (limited.least_skin_side_mass_kg > 0) {
    problem.bounds.skin_side_mass_kg.lower = limited.least_skin_side_mass_kg;
  }
  return problem;
}

// b ((Ka + p)^2 + (e + q)^2) = q (Ka^2 + e^2) + e (p^2 + q^2), solved for Ka: places off the
// lattice, which itself does not meet it
TEST(StartPlaces, LieOnTheRidgeWhereItIsWithinTheBounds) {
  const TuningProblem problem = Limited(0.3e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const double w = source.omega_rad_per_s, q = source.stiffness_n_per_m.imag();
  std::size_t by_spring = 0;
  for (const CubePlace& place : StartPlaces(problem, source)) {
    const auto [adapter, area_m2] = PointOf(problem.bounds, place);
    const double p = source.stiffness_n_per_m.real() -
                     (source.case_mass_kg + adapter.motor_side_mass_kg) * w * w;
    const double Ka = adapter.stiffness_n_per_m, e = adapter.damping_n_s_per_m * w;
    const double b = SkinOf(problem, area_m2).damping_n_s_per_m * w;
    const double left = b * ((Ka + p) * (Ka + p) + (e + q) * (e + q));
    const double right = q * (Ka * Ka + e * e) + e * (p * p + q * q);
    if (std::abs(left - right) > 1e-9 * right) continue;
    const double eighths = place[1] * 8;
    if (std::abs(eighths - std::round(eighths)) > 1e-6) ++by_spring;
  }
  EXPECT_GT(by_spring, 50U);
}

// limits from 0.05 to 1 mm, three objectives, other voltages, frequencies, skins and bounds
TEST(TravelLimit, OptimumIsThatOfManyStarts) {
  for (const tests::LimitedCase& limited : tests::kLimitedCases) {
    const TuningProblem problem = ProblemOf(limited);
    const AdapterPoint point = BestWithinTravel(limited.objective, problem, {}).point;
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    EXPECT_REL(ValueOf(limited.objective, problem, source, {}, point), limited.best, 2e-9,
               "SLSQP keeps to the limit to 1e-9")
        << limited.limit_m;
    EXPECT_LE(TravelOf(problem, point), limited.limit_m * (1 + 1e-9));
  }
}

// Whatever the boxes: what has not been proved by then is said. Against the program's own optimum
// and that of SciPy, which keeps to the limit to 1e-9.
TEST(TravelLimit, BoundIsNeverBelowTheOptimumAndComesUpToIt) {
  constexpr std::size_t kFew = 10, kEnough = 5000;
  for (const tests::LimitedCase& limited : tests::kLimitedCases) {
    const TuningProblem problem = ProblemOf(limited);
    LimitedBest best = BestWithinTravel(limited.objective, problem, {});
    for (const std::size_t most_boxes : {kFew, kEnough}) {
      const TravelBound bound =
          BoundWithinTravel(limited.objective, problem, {}, 1e-9, most_boxes, best);
      EXPECT_GE(bound.value, best.value) << limited.limit_m;
      EXPECT_GE(bound.value, limited.best * (1 - 2e-9)) << limited.limit_m;
      if (most_boxes == kFew) continue;
      EXPECT_LT(bound.value, best.value * (1 + 2.2e-9))
          << limited.limit_m << ": the gap that was asked for, and the allowances for rounding";
      EXPECT_LT(bound.boxes, kEnough) << limited.limit_m;
    }
  }
}

// A climb from elsewhere ends at another place of the flat summit, but at the same price.
TEST(TravelLimit, PriceDoesNotDependOnWhereTheClimbBegins) {
  const TuningProblem problem = Limited(0.05e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const LimitedBest best = BestWithinTravel(Objective::kSkinRms, problem, {});
  const LimitedClimb climb(Objective::kSkinRms, problem, source, {});
  const CubePlace summit = PlaceOf(problem.bounds, best.point);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> shift(-0.02, 0.02);
  for (int trial = 0; trial < 20; ++trial) {
    CubePlace start = summit;
    for (int axis = 0; axis < kCubeAxes; ++axis) start[axis] += shift(random);
    const LimitedSummit again =
        climb.From(start.cwiseMax(CubePlace::Zero()).cwiseMin(CubePlace::Ones()));
    EXPECT_REL(again.price, best.prices[0], 1e-12, "squares of the place's error of 1e-8");
  }
}

TEST(TravelLimit, BoundIsNoLooserThanTheCoilsWork) {
  for (const tests::LimitedCase& limited : tests::kLimitedCases) {
    const TuningProblem problem = ProblemOf(limited);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const AdapterOptimum optimum = FindAdapterOptimum(limited.objective, problem, {}, 1e-5, 10);
    EXPECT_LE(optimum.upper_bound, LimitedTravelBound(limited.objective, problem, source, {}));
    EXPECT_GE(optimum.upper_bound, optimum.value) << limited.limit_m;
  }
}

TEST(TravelLimit, CostsMoreTheTighterItIs) {
  double before = 0;
  for (const double limit_m : {0.03e-3, 0.07e-3, 0.15e-3, 0.4e-3, 0.7e-3}) {
    const TuningProblem problem = Limited(limit_m);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const AdapterPoint point = BestWithinTravel(Objective::kSkinRms, problem, {}).point;
    const double value = ValueOf(Objective::kSkinRms, problem, source, {}, point);
    EXPECT_GT(value, before) << limit_m;
    before = value;
  }
}

TEST(TravelLimit, OptimumIsExceededByNoPointThatKeepsToIt) {
  std::mt19937 random(6);
  const TuningProblem problem = Limited(0.4e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  int kept = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const AdapterPoint point = Anywhere(problem.bounds, random);
    const AdapterMotion motion =
        MotionOf(source, point.adapter, SkinOf(problem, point.contact_area_m2));
    if (MoverTravel(source, motion.case_m) > problem.mover_limit_m) continue;
    ++kept;
    ASSERT_LE(ValueOf(Objective::kSkinRms, problem, source, {}, point), tests::kLimitedBest);
  }
  EXPECT_GT(kept, 1000);
}

TEST(TravelLimit, ThatIsNotReachedChangesNothing) {
  const AdapterOptimum free = FindAdapterOptimum(Objective::kSkinRms, ThesisProblem(), {});
  const AdapterOptimum wide = FindAdapterOptimum(Objective::kSkinRms, Limited(1e-3), {});
  EXPECT_EQ(wide.value, free.value);
  EXPECT_EQ(wide.upper_bound, free.upper_bound);
  EXPECT_EQ(wide.proof, Proof::kBranchAndBound);
  EXPECT_EQ(FindAdapterOptimum(Objective::kSkinRms, Limited(1e-6), {}).value, 0) << "none";
}

// |Xs| is largest there, and falls alike to either side: Ma2 is in one square only
TEST(WantedMass, IsTheMiddleOfTheSkinsResonance) {
  std::mt19937 random(8);
  const TuningProblem problem = ThesisProblem();
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  for (int trial = 0; trial < 50; ++trial) {
    AdapterPoint point = Anywhere(problem.bounds, random);
    const double wanted_kg = WantedSkinSideMass(problem, source, point);
    const Skin skin = SkinOf(problem, point.contact_area_m2);
    const auto peak_m = [&](double kg) {
      point.adapter.skin_side_mass_kg = kg;
      return std::abs(MotionOf(source, point.adapter, skin).skin_m);
    };
    for (const double away_kg : {1e-4, 2e-3}) {
      EXPECT_REL(peak_m(wanted_kg + away_kg), peak_m(wanted_kg - away_kg), 1e-10,
                 "rounding, more at a light mass");
      EXPECT_LT(peak_m(wanted_kg + away_kg), peak_m(wanted_kg));
    }
  }
}

// the coil's work |F| T less the mover's own q T^2, most at T = |F| / (2 q), in the skin's damper:
// F = Km V / (R + j w L), q = w Bv + Im(Km^2 j w / (R + j w L))
TEST(LimitedTravelBound, IsTheCoilsWorkInTheSkinsDamper) {
  const double w = 2 * std::numbers::pi * 225;
  const std::complex<double> coil(27, w * 130e-6);
  const double F = std::abs(5.0 / coil);
  const double q = w * 0.0322 + (std::complex<double>(0, w) / coil).imag();
  const double longest_m = F / (2 * q);
  for (const double limit_m : {1e-5, 2e-4, longest_m * 0.99, longest_m * 1.5}) {
    const TuningProblem problem = Limited(limit_m);
    const MotorSource source = SourceOf(problem.actuator, problem.drive);
    const double T = std::min(limit_m, longest_m);
    const double power_w = w * (F * T - q * T * T) / 2;
    const double rms_m = std::sqrt(power_w / 0.75) / w;  // Bs w^2 rms^2, the least Bs
    const auto bound = [&](Objective objective) {
      return LimitedTravelBound(objective, problem, source, {});
    };
    constexpr const char* kAllowance = "the allowance of 2.5e-11 and 1e-11";
    EXPECT_REL(bound(Objective::kSkinPower), power_w, 1e-10, kAllowance);
    EXPECT_REL(bound(Objective::kSkinRms), rms_m, 1e-10, kAllowance);
    EXPECT_REL(bound(Objective::kStimulus), 49 * rms_m, 1e-10, "all receptors of 100 mm2");
    EXPECT_GE(bound(Objective::kSkinPower), power_w);
    EXPECT_GE(bound(Objective::kSkinRms), rms_m);
  }
}

// a bound by the coil's work alone, where the best is above it: what is allowed for rounding of the
// source, twice of a power, for the travel's difference, the limit and the steps of Nr
TEST(TravelLimit, BoundHasItsAllowances) {
  const TuningProblem problem = Limited(0.2e-3);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const double of_source =
      source.rounding_allowance * (1 + std::abs(source.free_travel_m) / problem.mover_limit_m);
  ASSERT_GT(of_source, 1e-11) << "seen by a double";
  const auto allowance = [&](Objective objective, const ReceptorField& receptors) {
    LimitedBest best{.value = 1e3, .prices = {}};
    double rough = 0;
    for (const AreaPiece& piece : PiecesOf(objective, problem, receptors)) {
      best.prices.push_back(-1);
      rough = std::max(rough, piece.weight * LimitedTravelBound(piece.objective, piece.problem,
                                                                source, receptors));
    }
    const TravelBound bound = BoundWithinTravel(objective, problem, receptors, 1e-9, 10, best);
    EXPECT_EQ(bound.boxes, 0U);
    return bound.value / rough - 1;
  };
  EXPECT_ABS(allowance(Objective::kSkinRms, {}), of_source + 1e-11, 1e-15, "rounding");
  EXPECT_ABS(allowance(Objective::kSkinPower, {}), 2 * of_source + 1e-11, 1e-15, "rounding");
  EXPECT_ABS(allowance(Objective::kStimulus, {}), of_source + 1e-11 + 1e-9, 1e-15, "rounding");
}

// Nine places an axis: evenly, by the logarithm of the mass that moves with the case where that
// is wide, and in steps of 8 from the upper end where the damping may be 0.
TEST(StartPlaces, OfTheLatticeAreThoseOfTheHeader) {
  const auto places_of = [](const TuningProblem& problem) {
    return StartPlaces(problem, SourceOf(problem.actuator, problem.drive));
  };
  TuningProblem problem = ThesisProblem();
  problem.bounds.damping_n_s_per_m.lower = 0;
  for (const double most_kg : {5e-3, 0.2}) {
    problem.bounds.motor_side_mass_kg = {0.25e-3, most_kg};
    const std::vector<CubePlace> places = places_of(problem);
    EXPECT_EQ(places.size(), 6561U + 2 * 729U + 2 * 729U) << "the lattice and two ridges";
    // the springs' ridge, then the masses': an end stands for a root beyond the bounds
    for (const auto& [begin, axis] : {std::pair{6561U, 1}, std::pair{6561U + 1458U, 0}}) {
      std::size_t at_ends = 0;
      for (std::size_t k = begin; k < begin + 1458; ++k) {
        EXPECT_GE(places[k][axis], 0);
        EXPECT_LE(places[k][axis], 1);
        at_ends += places[k][axis] == 0 ? 1 : 0;
      }
      EXPECT_GT(at_ends, 0U) << axis;
    }
    const double case_kg = problem.actuator.case_mass_kg;
    const double least_kg = 0.25e-3 + case_kg, ratio = (most_kg + case_kg) / least_kg;
    EXPECT_EQ(ratio > 20, most_kg > 0.1);
    for (std::size_t k = 0; k < 9; ++k) {
      const double part = static_cast<double>(k) / 8;
      const double wide = (least_kg * std::pow(ratio, part) - least_kg) / (most_kg - 0.25e-3);
      EXPECT_ABS(places[729 * k][0], ratio > 20 ? wide : part, 1e-13, "rounding") << k;
      EXPECT_EQ(places[81 * k][1], part);
      EXPECT_EQ(places[9 * k][2], k == 0 ? 0 : std::pow(8, static_cast<double>(k) - 8));
      EXPECT_EQ(places[k][3], part);
      EXPECT_EQ(places[k][4], 0);
    }
  }
  problem.bounds.damping_n_s_per_m.lower = 1e-3;
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_EQ(places_of(problem)[9 * k][2], static_cast<double>(k) / 8) << "away from 0";
  }
  // a number that is held has no ridge
  const auto count = [&](Range AdapterBounds::* held) {
    TuningProblem other = ThesisProblem();
    (other.bounds.*held).upper = (other.bounds.*held).lower;
    return places_of(other).size();
  };
  EXPECT_EQ(count(&AdapterBounds::stiffness_n_per_m), 729U + 2 * 81U);
  EXPECT_EQ(count(&AdapterBounds::motor_side_mass_kg), 729U + 2 * 81U);
}

// the same equation solved for p = Re kc - (Mc + Ma1) w^2: places on the lattice of Ka
TEST(StartPlaces, LieOnTheRidgeByTheirMassToo) {
  TuningProblem problem = ThesisProblem();
  problem.bounds.stiffness_n_per_m = {2000, 30000};
  problem.bounds.motor_side_mass_kg = {0.25e-3, 0.2};
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const double w = source.omega_rad_per_s, q = source.stiffness_n_per_m.imag();
  std::size_t by_mass = 0;
  for (const CubePlace& place : StartPlaces(problem, source)) {
    const double eighths = place[1] * 8;
    if (std::abs(eighths - std::round(eighths)) > 1e-12) continue;
    const auto [adapter, area_m2] = PointOf(problem.bounds, place);
    const double p = source.stiffness_n_per_m.real() -
                     (source.case_mass_kg + adapter.motor_side_mass_kg) * w * w;
    const double Ka = adapter.stiffness_n_per_m, e = adapter.damping_n_s_per_m * w;
    const double b = SkinOf(problem, area_m2).damping_n_s_per_m * w;
    const double left = b * ((Ka + p) * (Ka + p) + (e + q) * (e + q));
    const double right = q * (Ka * Ka + e * e) + e * (p * p + q * q);
    by_mass += std::abs(left - right) <= 1e-9 * right ? 1 : 0;
  }
  EXPECT_GT(by_mass, 100U);
}

// the view of a place against its motion: cost, the excess over the limit, and slopes by
// differences
TEST(LimitedClimb, HasTheCostsAndSlopesOfTheMotion) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> part(0.05, 0.95);
  TuningProblem problem = Limited(0.3e-3);
  problem.bounds.stiffness_n_per_m = {500, 5e5};  // wide: by its logarithm
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const ReceptorField soft{.edge_width_m = 1e-3};
  for (const Objective objective :
       {Objective::kSkinRms, Objective::kStimulus, Objective::kSkinPower, Objective::kRmsPerWatt}) {
    const LimitedClimb climb(objective, problem, source, soft);
    for (int trial = 0; trial < 10; ++trial) {
      CubePlace place;
      for (int axis = 0; axis < kCubeAxes; ++axis) place[axis] = part(random);
      const AdapterPoint point = PointOf(problem.bounds, place);
      const LimitedView view = climb.At(place);
      // w Bs |Xs|^2 and the others mean their value squared, the power its value
      const double value = ValueOf(objective, problem, source, soft, point);
      const double w = source.omega_rad_per_s;
      const double cost = objective == Objective::kSkinPower
                              ? std::log(std::norm(source.force_n) * w / (2 * value))
                              : std::log(std::norm(source.force_n) / (2 * value * value));
      EXPECT_ABS(view.cost, cost, 1e-9, "the logarithm's rounding, and the source's");
      EXPECT_ABS(view.excess, 2 * std::log(TravelOf(problem, point) / 0.3e-3), 1e-9, "the same");
      for (int axis = 0; axis < kCubeAxes; ++axis) {
        const CubePlace step = 1e-5 * CubePlace::Unit(axis);
        const LimitedView after = climb.At(place + step), before = climb.At(place - step);
        const double scale = 1e-4 * (1 + std::abs(view.cost_slopes[axis]));
        EXPECT_ABS(view.cost_slopes[axis], (after.cost - before.cost) / 2e-5, scale,
                   "1e-5 of a step, squared, near a resonance");
        EXPECT_ABS(view.excess_slopes[axis], (after.excess - before.excess) / 2e-5,
                   1e-4 * (1 + std::abs(view.excess_slopes[axis])), "the same");
      }
    }
  }
}

// where skins vary, the excess is the other end's cost less this one's
TEST(LimitedClimb, KnowsTheHardestSkin) {
  TuningProblem problem = ThesisProblem();
  problem.skin_variation = 0.2;
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const CubePlace place{0.3, 0.6, 0.2, 0.4, 0.5};
  const AdapterPoint point = PointOf(problem.bounds, place);
  const auto [softer, stiffer] = HardestSkins(problem, point.contact_area_m2);
  const auto cost = [&](const Skin& skin) {
    return std::log(std::norm(source.force_n / MotionOf(source, point.adapter, skin).skin_m));
  };
  const LimitedView low = LimitedClimb(Objective::kSkinRms, problem, source, {}, -1).At(place);
  const LimitedView high = LimitedClimb(Objective::kSkinRms, problem, source, {}, 1).At(place);
  EXPECT_ABS(low.cost, cost(softer), 1e-11, "rounding");
  EXPECT_ABS(high.cost, cost(stiffer), 1e-11, "rounding");
  EXPECT_ABS(low.excess, cost(stiffer) - cost(softer), 1e-11, "rounding");
  EXPECT_ABS(high.excess, -low.excess, 1e-11, "rounding");
}

}  // namespace
}  // namespace haptometer::sim
