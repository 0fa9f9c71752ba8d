#include "sim/smooth/smooth_mode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "tests/residual.h"
#include "tests/sim/smooth_scenes.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

using Complex = std::complex<double>;

constexpr double kOmega = 2 * std::numbers::pi * 225;
constexpr CoilHeating kHeating{.heat_capacity_j_per_k = 1e-3, .thermal_resistance_k_per_w = 100};

// a coil by itself: Km = 0, so that nothing moves under 5 V at 225 Hz
Scene Coil() {
  Scene scene = tests::Alone();
  scene.drive = {.amplitude_v = 5, .frequency_hz = 225};
  return scene;
}

// V / |R + s L| at s = (0.1 + j) w
double CurrentScale(const Actuator& actuator) {
  return 5 / std::abs(actuator.resistance_ohm + Complex(0.1, 1) * kOmega * actuator.inductance_h);
}

TEST(SmoothMode, TheHighestFrequencyIsThatOfTheFastestTone) {
  ExcitationPiece piece;
  piece.terms = {{.kind = ExcitationTerm::Kind::kPolynomial}};
  EXPECT_EQ(HighestFrequencyHz(piece), 0);
  piece.terms.push_back({.frequency_hz = 40});
  piece.terms.push_back({.input = kFinger, .frequency_hz = 9});
  EXPECT_EQ(HighestFrequencyHz(piece), 40);
}

// (s I - A)^-1 (B u + w x0): of a coil the current, and what it warms in a radian
TEST(SmoothMode, ScalesOfACoilAreTheClosedForms) {
  const Scene scene = Coil();
  const SmoothSystem system = AssembleSmooth(scene, {}, {.heating = kHeating});
  const ExcitationPiece piece = Excitation(scene.drive).Piece(0);
  const SmoothMode mode(system, 0, piece, true);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(6);
  y(5) = -3;
  const Eigen::VectorXd scale = mode.ScaleFrom(y);
  const double R = scene.actuator.resistance_ohm, current = CurrentScale(scene.actuator);
  ASSERT_EQ(scale.size(), 6);
  EXPECT_EQ(scale.head(4).cwiseAbs().maxCoeff(), 0);
  EXPECT_REL(scale(4), current, 1e-13, "rounding");
  EXPECT_REL(scale(5), 3 + R * current * current / kOmega / 1e-3, 1e-13, "rounding");
  EXPECT_REL(mode.LastRise(scale), R * current * current * 100, 1e-13, "rounding");
  // what is there at the beginning decays or swings on: w i0 / |s + R/L|
  y(4) = 0.3;
  const double rate = R / scene.actuator.inductance_h;
  EXPECT_REL(mode.ScaleFrom(y)(4),
             current + kOmega * 0.3 / std::abs(Complex(0.1, 1) * kOmega + rate), 1e-13, "rounding");
}

// without inductance the current is V / R at once
TEST(SmoothMode, ScalesOfACoilWithoutInductanceAreItsVoltages) {
  Scene scene = Coil();
  scene.actuator.inductance_h = 0;
  const SmoothSystem system = AssembleSmooth(scene, {}, {.heating = kHeating});
  const SmoothMode mode(system, 0, Excitation(scene.drive).Piece(0), true);
  const Eigen::VectorXd scale = mode.ScaleFrom(Eigen::VectorXd::Zero(5));
  EXPECT_REL(mode.LastRise(scale), 25 / scene.actuator.resistance_ohm * 100, 1e-13, "rounding");
  EXPECT_REL(scale(4), 25 / scene.actuator.resistance_ohm / kOmega / 1e-3, 1e-13, "rounding");
}

TEST(SmoothMode, ACoilWithoutAWayOutHasNoLastRise) {
  SmoothSystem system = AssembleSmooth(Coil(), {}, {.heating = kHeating});
  system.heating->thermal_resistance_k_per_w = std::numeric_limits<double>::infinity();
  const SmoothMode mode(system, 0, Excitation(Coil().drive).Piece(0), false);
  EXPECT_EQ(mode.LastRise(Eigen::VectorXd::Ones(6)), 0);
}

// power over a radian and what is stored, the same of all energies; squares over a radian
TEST(SmoothMode, ScalesOfIntegralsAreThoseOfARadian) {
  const Scene scene = Coil();
  SmoothSystem system = AssembleSmooth(scene, {}, {.heating = kHeating});
  system.linear.squared_rows = {3 * Eigen::RowVectorXd::Unit(5, 4)};
  const ExcitationPiece piece = Excitation(scene.drive).Piece(0);
  const SmoothMode mode(system, 0, piece, true);
  const Eigen::VectorXd found = mode.IntegralScale(mode.ScaleFrom(Eigen::VectorXd::Zero(6)));
  const double R = scene.actuator.resistance_ohm, current = CurrentScale(scene.actuator);
  const double energy_j = (5 * current + R * current * current) / kOmega +
                          scene.actuator.inductance_h * current * current / 2;
  ASSERT_EQ(found.size(), 10) << "input, seven elements, a square and that of the current";
  for (Eigen::Index k = 0; k < 8; ++k) EXPECT_REL(found(k), energy_j, 1e-13, "rounding");
  EXPECT_REL(found(8), 9 * current * current / kOmega, 1e-13, "rounding");
  EXPECT_REL(found(9), current * current / kOmega, 1e-13, "rounding");
  const SmoothMode without(system, 0, piece, false);
  EXPECT_EQ(without.integrals(), 0);
  EXPECT_EQ(without.IntegralScale(found).size(), 0);
}

// every term by its magnitude, the finger's power against the skin's force among them
TEST(SmoothMode, ScalesOfIntegralsCountTheFinger) {
  Scene scene = tests::DirectScene();
  scene.finger.tones = {{.amplitude = 2e-4, .frequency_hz = 30}};
  const StiffeningSpring spring{.cubic_n_per_m3 = 3e9};
  const SmoothSystem system = AssembleSmooth(scene, {}, {.spring = spring});
  const ExcitationPiece piece = Excitation(scene.drive, scene.finger.tones).Piece(0);
  const SmoothMode mode(system, 0, piece, true);
  // magnitudes of [xv, vv, xa, va, i]
  const Eigen::VectorXd x = Eigen::Vector<double, 5>(3e-4, 0.4, 1e-4, 0.2, 0.15);
  const double Ks = scene.skin.stiffness_n_per_m, Bs = scene.skin.damping_n_s_per_m;
  const double finger_m = 2e-4, rate = finger_m * 2 * std::numbers::pi * 30;
  const Actuator& motor = scene.actuator;
  const auto half = [](double factor, double value) { return factor * value * value / 2; };
  const double power_w =
      5 * x(4) + rate * (Ks * (x(2) + finger_m) + Bs * (x(3) + rate)) +
      2 * (half(27, x(4)) + half(motor.damping_n_s_per_m, x(1) + x(3)) + half(Bs, x(3) + rate));
  const double stored_j = half(motor.inductance_h, x(4)) + half(motor.moving_mass_kg, x(1)) +
                          half(motor.case_mass_kg, x(3)) +
                          half(motor.stiffness_n_per_m, x(0) + x(2)) + half(Ks, x(2) + finger_m) +
                          spring.Energy(x(0) + x(2));
  EXPECT_REL(mode.IntegralScale(x)(0), power_w / kOmega + stored_j, 1e-13, "rounding");
}

// a ramp counts with what it comes to at its end, a polynomial with its value
TEST(SmoothMode, ScalesCountRampsAndOffsets) {
  const Scene scene = Coil();
  const SmoothSystem system = AssembleSmooth(scene, {}, {});
  ExcitationPiece piece = Excitation(scene.drive).Piece(0);
  piece.end_s = 0.02L;
  const auto current = [&] {
    return SmoothMode(system, 0, piece, false).ScaleFrom(Eigen::VectorXd::Zero(5))(4);
  };
  const double of_tone = current();
  piece.terms[0].kind = ExcitationTerm::Kind::kRampedTone;
  piece.terms[0].amplitude_per_s = -500;
  EXPECT_REL(current(), 3 * of_tone, 1e-13, "5 V, and 10 V more at the end");
  piece.terms[0].amplitude_per_s = 0;
  ExcitationTerm offset{.kind = ExcitationTerm::Kind::kPolynomial};
  offset.derivatives[0] = -5;
  piece.terms.push_back(offset);
  EXPECT_REL(current(), 2 * of_tone, 1e-13, "at the tone's pace");
}

// ---------------------------------------------------------------------------------------- the jets

// each number of a jet is the derivative of the one before along the solution
class Chain {
 public:
  Chain(SmoothSystem system, const Scene& scene, double rise_k)
      : system_(std::move(system)),
        mode_(system_, 0, Excitation(scene.drive).Piece(0), false),
        solver_(mode_, 1e-12) {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(mode_.states());
    y(LinearModel::kMover) = 2e-4;
    y(LinearModel::kCaseVelocity) = 0.1;
    if (system_.heating) y(mode_.states() - 1) = rise_k;
    Eigen::VectorXd scale = mode_.ScaleFrom(y);
    solver_.Begin({.y = std::move(y),
                   .scale = std::move(scale),
                   .integral_scale = Eigen::VectorXd(0),
                   .longest_step_s = 1e-3});
    // the coil's transient of some 5 us is over, and sine and cosine of the drive are both large
    while (solver_.end_s() < 3e-3) EXPECT_TRUE(solver_.Step());
  }

  // how far g^(k) over a short time is from the integral of g^(k+1), over the size of that
  [[nodiscard]] double Residual(std::size_t guard, std::size_t k) {
    constexpr double h = 1e-5;
    const double t = (solver_.begin_s() + solver_.end_s()) / 2;
    const auto jet = [&](double at) { return mode_.Jet(guard, at, solver_.At(at)); };
    const GuardJet begin = jet(t), middle = jet(t + h / 2), end = jet(t + h);
    const double by_simpson = (begin[k + 1] + 4 * middle[k + 1] + end[k + 1]) / 6;
    const double largest = std::max({std::abs(begin[k + 1]), std::abs(end[k + 1])});
    return std::abs((end[k] - begin[k]) / h - by_simpson) / largest;
  }

 private:
  SmoothSystem system_;
  SmoothMode mode_;
  SemilinearSolver solver_;
};

TEST(SmoothMode, JetsOfGapsAreDerivativesOfEachOther) {
  const PiecewiseEffects effects{.stops = tests::Rigid(1, 0.5)};
  const SmoothEffects smooth{.spring = StiffeningSpring{.cubic_n_per_m3 = 3e10, .sag_m = 1e-5},
                             .heating = kHeating};
  for (const double inductance_h : {130e-6, 0.0}) {
    Scene scene = tests::AdapterScene();
    scene.actuator.inductance_h = inductance_h;
    Chain chain(AssembleSmooth(scene, effects, smooth), scene, 60);
    for (const std::size_t guard : {0U, 1U}) {
      for (const std::size_t k : {0U, 1U, 2U}) {
        // g over 1e-5 s changes by 1e-6 m, of a step's polynomial of 1e-12 m
        EXPECT_LT(chain.Residual(guard, k), 1e-4) << guard << ' ' << k;
      }
    }
  }
}

// Of a coil as quick as the drive, R/L = 1350/s, which warms and cools within a period: 1000/s.
// What heat does to the current is then no small part of any derivative.
TEST(SmoothMode, JetsOfAWarmingCoilsCurrentAreDerivativesOfEachOther) {
  Scene scene = Coil();
  scene.actuator.inductance_h = 20e-3;
  const CoilHeating quick{.heat_capacity_j_per_k = 1e-5, .thermal_resistance_k_per_w = 100};
  SmoothSystem system = AssembleSmooth(scene, {}, {.heating = quick});
  system.linear.modes[0].guards = {{.row = Eigen::RowVectorXd::Unit(5, 4), .offset = 1}};
  Chain chain(std::move(system), scene, 60);
  for (const std::size_t k : {0U, 1U, 2U}) EXPECT_LT(chain.Residual(0, k), 1e-4) << k;
}

// with an input in it; its third derivative is left out
TEST(SmoothMode, JetsOfAFedGuardAreDerivativesOfEachOther) {
  Scene scene = Coil();
  scene.actuator.inductance_h = 20e-3;
  SmoothSystem system = AssembleSmooth(scene, {}, {});
  system.linear.modes[0].guards = {
      {.row = Eigen::RowVectorXd::Unit(5, 4), .offset = 1, .feed = Eigen::RowVector3d(0.03, 0, 0)}};
  Chain chain(std::move(system), scene, 0);
  for (const std::size_t k : {0U, 1U}) EXPECT_LT(chain.Residual(0, k), 1e-4) << k;
}

// 5 V at a quarter of the period; what is fed is what R0 sees of them, V / (1 + alpha theta)
TEST(SmoothMode, ValuesAreOfStatesInputsAndOffset) {
  Scene scene = Coil();
  scene.actuator.inductance_h = 0;
  SmoothSystem system = AssembleSmooth(scene, {}, {.heating = kHeating});
  const Eigen::RowVectorXd row = 3 * Eigen::RowVectorXd::Unit(4, LinearModel::kMover);
  const Eigen::RowVectorXd feed = Eigen::RowVector3d(0.5, 0, 0);
  system.linear.modes[0].guards = {{.row = row, .offset = 7, .feed = feed}};
  const SmoothMode mode(system, 0, Excitation(scene.drive).Piece(0), false);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(5);
  y(LinearModel::kMover) = 0.25;
  y(4) = 60;
  const double quarter_s = 0.25 / 225, cold_v = 5 / (1 + 3.93e-3 * 60);
  EXPECT_REL(mode.Current(quarter_s, y), cold_v / 27, 1e-14, "rounding");
  EXPECT_REL(mode.Value(0, quarter_s, y), 0.75 + 7 + 0.5 * cold_v, 1e-14, "rounding");
  EXPECT_REL(mode.Value(WatchedNumber{.row = row, .offset = 7, .feed = feed}, quarter_s, y),
             0.75 + 7 + 0.5 * 5, 1e-14, "rounding");
  EXPECT_REL(mode.Value(WatchedNumber{.row = row, .offset = 7}, quarter_s, y), 7.75, 1e-14,
             "rounding");
}

// the same heat without inductance, where the current follows voltage, speed and resistance
TEST(SmoothMode, JetsOfAWarmingMoversGapAreDerivativesOfEachOther) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = 0;
  const CoilHeating quick{.heat_capacity_j_per_k = 1e-5, .thermal_resistance_k_per_w = 100};
  Chain chain(AssembleSmooth(scene, {.stops = tests::Rigid(1, 0.5)}, {.heating = quick}), scene,
              60);
  for (const std::size_t k : {0U, 1U, 2U}) EXPECT_LT(chain.Residual(0, k), 1e-4) << k;
}

// of a speed, whose second derivative holds that of the temperature
TEST(SmoothMode, JetsOfAWarmingMoversSpeedAreDerivativesOfEachOther) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = 0;
  const CoilHeating quick{.heat_capacity_j_per_k = 1e-5, .thermal_resistance_k_per_w = 100};
  SmoothSystem system = AssembleSmooth(scene, {}, {.heating = quick});
  system.linear.modes[0].guards = {
      {.row = Eigen::RowVectorXd::Unit(6, LinearModel::kMoverVelocity), .offset = 1}};
  Chain chain(std::move(system), scene, 60);
  for (const std::size_t k : {0U, 1U}) EXPECT_LT(chain.Residual(0, k), 1e-4) << k;
}

TEST(SmoothMode, JetsOfTheContactForceAreDerivativesOfEachOther) {
  const PiecewiseEffects effects{.contact_loss = ContactLoss{100}};
  for (const Scene& scene : {tests::AdapterScene(), tests::ConeScene()}) {
    const SmoothEffects smooth{.spring = StiffeningSpring{.cubic_n_per_m3 = 3e10},
                               .heating = kHeating};
    Chain chain(AssembleSmooth(scene, effects, smooth), scene, 60);
    for (const std::size_t k : {0U, 1U, 2U}) EXPECT_LT(chain.Residual(0, k), 1e-4) << k;
  }
}

// in steps of a fifth of the resistance, by the nearest: the first at sqrt(1.2), 24.3 K of copper
TEST(SmoothMode, LinearisesTheCoilInStepsOfAFifth) {
  const SmoothSystem system = AssembleSmooth(Coil(), {}, {.heating = kHeating});
  SmoothMode mode(system, 0, Excitation(Coil().drive).Piece(0), false);
  const auto number = [&](double rise_k) {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(6);
    y(5) = rise_k;
    return mode.Linearise(y);
  };
  const auto rise_k = [](double power) { return (std::pow(1.2, power) - 1) / 3.93e-3; };
  EXPECT_EQ(number(0), 0);
  EXPECT_EQ(number(rise_k(0.499)), 0);
  EXPECT_EQ(number(rise_k(0.501)), 1);
  EXPECT_REL(-mode.linear().a(4, 4), 1.2 * 27 / 130e-6, 1e-13, "R/L of the linear part");
  EXPECT_EQ(number(rise_k(2.501)), 3);
  EXPECT_REL(-mode.linear().a(4, 4), 1.2 * 1.2 * 1.2 * 27 / 130e-6, 1e-13, "the same");
  EXPECT_EQ(number(std::nan("")), 0);
}

}  // namespace
}  // namespace haptometer::sim
