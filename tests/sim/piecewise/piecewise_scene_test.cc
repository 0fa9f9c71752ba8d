#include "sim/piecewise/piecewise_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/time_response.h"
#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tests/sim/reference/events_reference.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

using tests::AdapterScene;

void RunTo(PiecewiseMotion& motion, double outputs) {
  while (static_cast<double>(motion.index()) < outputs && !motion.stalled_at_s()) motion.Next();
}

Eigen::MatrixXd Samples(PiecewiseMotion& motion, Eigen::Index count) {
  Eigen::MatrixXd samples(motion.Positions().size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    samples.col(i) = motion.Positions();
    motion.Next();
  }
  return samples;
}

Eigen::MatrixXd SamplesOf(const Scene& scene, const PiecewiseEffects& effects, Eigen::Index count) {
  PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                         1e4);
  return Samples(motion, count);
}

Scene FromRest(Scene scene) {
  scene.start = Start::kRest;
  return scene;
}

TravelStops Rigid(double gap_m, double restitution) {
  return {.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = restitution};
}

TravelStops Compliant(double gap_m, double stiffness_n_per_m, double damping_n_s_per_m) {
  return {.gap_up_m = gap_m,
          .gap_down_m = gap_m,
          .stiffness_n_per_m = stiffness_n_per_m,
          .damping_n_s_per_m = damping_n_s_per_m};
}

Scene WithoutInductance(Scene scene) {
  scene.actuator.inductance_h = 0;
  return scene;
}

double LargestTravel(const Eigen::MatrixXd& samples) {
  return (samples.row(LinearModel::kMover) - samples.row(LinearModel::kCase)).cwiseAbs().maxCoeff();
}

TEST(PiecewiseScene, WithAStiffMoverTakesTheSameSteps) {
  for (Scene scene : {FromRest(AdapterScene()), FromRest(tests::DirectScene())}) {
    scene.actuator.stiffness_n_per_m = 1e11;
    for (const Scene& stiff : {scene, WithoutInductance(scene)}) {
      const LinearModel model = AssembleModel(stiff);
      const Eigen::VectorXd rest = Eigen::VectorXd::Zero(model.states());
      EXPECT_EQ(SamplesOf(stiff, {}, 100), UniformMotion(model, stiff.drive, rest, 0, 1e4, 100));
    }
  }
}

TEST(PiecewiseScene, EffectsThatAreNeverReachedLeaveNoTrace) {
  for (const Scene& linear : {FromRest(AdapterScene()), FromRest(tests::DirectScene()),
                              WithoutInductance(FromRest(AdapterScene())),
                              WithoutInductance(FromRest(tests::DirectScene()))}) {
    const Eigen::MatrixXd off = SamplesOf(linear, {}, 1000);
    const LinearModel model = AssembleModel(linear);
    EXPECT_EQ(off, UniformMotion(model, linear.drive, Eigen::VectorXd::Zero(model.states()), 0, 1e4,
                                 1000));
    const double travel_m = LargestTravel(off);
    // from far away to so near that every peak is looked at closely
    for (const double gap_m : {1.0, 1.1 * travel_m, 1.003 * travel_m}) {
      const PiecewiseEffects rigid{.stops = Rigid(gap_m, 0.5), .contact_loss = ContactLoss{100.0}};
      const PiecewiseEffects soft{.stops = Compliant(gap_m, 1e6, 1),
                                  .contact_loss = ContactLoss{1}};
      EXPECT_EQ(SamplesOf(linear, rigid, 1000), off) << gap_m;
      EXPECT_EQ(SamplesOf(linear, soft, 1000), off) << gap_m;
    }
  }
}

template <std::size_t count>
void ExpectReference(const PiecewiseEffects& effects, double duration_s,
                     const double (&events_s)[count], const double (&state)[7]) {
  const Scene scene = FromRest(AdapterScene());
  PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                         1e4, true);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(7);
  while (static_cast<double>(motion.index()) < duration_s * 1e4) {
    motion.Next();
    largest = largest.cwiseMax(motion.Positions().cwiseAbs());
  }
  ASSERT_EQ(motion.events().size(), count);
  for (std::size_t k = 0; k < count; ++k) {
    EXPECT_ABS(motion.events()[k].time_s, events_s[k], 1e-12, "the bar for events");
  }
  // 312.5 outputs: the end lies between two, so another rate gets there
  PiecewiseMotion even(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                       4096);
  RunTo(even, duration_s * 4096);
  const Eigen::VectorXd expected = Eigen::Map<const Eigen::VectorXd>(state, 7);
  const double worst = (even.Positions() - expected).cwiseAbs().cwiseQuotient(largest).maxCoeff();
  EXPECT_ABS(worst, 0, 1e-10, "each event passes its error on to the next");
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-12, "sums of exact integrals");
}

TEST(PiecewiseScene, StopsAgreeWithFiftyDigits) {
  ExpectReference({.stops = Rigid(0.3e-3, 0.5)}, 1.0 / 32, tests::kStopsEventsS,
                  tests::kStopsState);
}

TEST(PiecewiseScene, BreakingContactAgreesWithFiftyDigits) {
  ExpectReference({.contact_loss = ContactLoss{0.07}}, 1.0 / 32, tests::kContactEventsS,
                  tests::kContactState);
}

TEST(PiecewiseScene, StopsAndBreakingContactTogetherAgreeWithFiftyDigits) {
  ExpectReference({.stops = Rigid(0.3e-3, 0.5), .contact_loss = ContactLoss{0.07}}, 1.0 / 32,
                  tests::kBothEventsS, tests::kBothState);
}

// As the inductance goes, its motion becomes that without: events as well, in proportion to L/R.
TEST(PiecewiseScene, WithoutInductanceIsTheLimitOfASmallOne) {
  const PiecewiseEffects effects{.stops = Rigid(0.3e-3, 0), .contact_loss = ContactLoss{0.07}};
  const auto events = [&](double inductance_h) {
    Scene scene = FromRest(AdapterScene());
    scene.actuator.inductance_h = inductance_h;
    PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                           1e4);
    RunTo(motion, 200);
    return motion.events();
  };
  const std::vector<Event> without = events(0);
  EXPECT_GT(without.size(), 10U);
  // R/L of 3e9/s takes many short intervals
  const std::vector<double> inductances_h =
      tests::kIsSanitized ? std::vector{1e-5} : std::vector{1e-6, 1e-8};
  for (const double inductance_h : inductances_h) {
    const std::vector<Event> with = events(inductance_h);
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t k = 0; k < with.size(); ++k) {
      EXPECT_EQ(with[k].transition, without[k].transition);
      EXPECT_ABS(with[k].time_s, without[k].time_s, 30 * inductance_h / 27,
                 "the current lags by L/R, which each event passes on");
    }
  }
}

// The ledger's coil is R i^2 of the current that follows from speed and voltage.
TEST(PiecewiseScene, WithoutInductanceTheCurrentIsReported) {
  const Scene scene = WithoutInductance(FromRest(tests::DirectScene()));
  PiecewiseMotion motion(AssemblePiecewise(scene, {}), scene.drive, PiecewiseStartOf(scene), 1e4);
  RunTo(motion, 77);
  const double volt = 5 * std::sin(2 * std::numbers::pi * 225 * 77e-4);
  const double back_v =
      motion.x()(LinearModel::kCaseVelocity) - motion.x()(LinearModel::kMoverVelocity);
  EXPECT_REL(motion.CurrentA(), (volt - back_v) / 27, 1e-14, "rounding of a difference");
}

// mover and case alone in space, the mover approaching the upper stop
Scene Drifting() {
  Scene scene = tests::ConeScene();
  scene.actuator.stiffness_n_per_m = 0;
  scene.actuator.damping_n_s_per_m = 0;
  scene.actuator.force_constant_n_per_a = 0;
  scene.skin = {};
  scene.drive.amplitude_v = 0;
  return scene;
}

TEST(PiecewiseScene, AStiffStopIsHalfASine) {
  const Scene scene = Drifting();
  const double mass_kg = 1 / (1 / scene.actuator.moving_mass_kg + 1 / scene.actuator.case_mass_kg);
  constexpr double kSpeed = 0.7, kGap = 0.9e-3;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(5);
  x(LinearModel::kMoverVelocity) = kSpeed;
  for (double k = 1e4; k < 2e11; k *= 10) {
    for (const double ratio : {0.0, 0.1, 0.6}) {  // damping over critical
      const double c = 2 * ratio * std::sqrt(k * mass_kg);
      PiecewiseMotion motion(AssemblePiecewise(scene, {.stops = Compliant(kGap, k, c)}),
                             scene.drive, {.x = x}, 1e4, true);
      RunTo(motion, 30);
      // d = (v/w) e^(-s t) sin w t; k d + c d' = 0 at tan w t = -c w/(k - c s)
      const double s = c / (2 * mass_kg), w = std::sqrt(k / mass_kg - s * s);
      const double contact_s = std::atan2(c * w, -(k - c * s)) / w;
      const double rate = std::cos(w * contact_s) - s / w * std::sin(w * contact_s);
      ASSERT_EQ(motion.events().size(), ratio > 0 ? 3U : 2U) << k << ' ' << ratio;
      EXPECT_ABS(motion.events()[0].time_s, kGap / kSpeed, 1e-16, "uniform motion");
      EXPECT_REL(motion.events()[1].time_s - motion.events()[0].time_s, contact_s,
                 1e-12 + 1e-18 / contact_s, "of contacts of 1 ms to 0.2 us; an ulp of the times");
      const Eigen::VectorXd end = motion.Positions();
      EXPECT_REL(end(LinearModel::kMoverVelocity) - end(LinearModel::kCaseVelocity),
                 kSpeed * std::exp(-s * contact_s) * rate, 1e-11, "half a sine");
      EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-12, "sums of exact integrals");
    }
  }
}

// what a pad's damper takes is the stops', and nothing else takes any
TEST(PiecewiseScene, WhatADampedStopTakesIsTheStops) {
  const Scene scene = Drifting();
  const double mass_kg = 1 / (1 / scene.actuator.moving_mass_kg + 1 / scene.actuator.case_mass_kg);
  const double stiffness = 1e5;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(5);
  x(LinearModel::kMoverVelocity) = 0.7;
  for (const double side : {1.0, -1.0}) {
    const double damping = 2 * 0.3 * std::sqrt(stiffness * mass_kg);
    PiecewiseMotion motion(AssemblePiecewise(scene, {.stops = Compliant(1e-4, stiffness, damping)}),
                           scene.drive, {.x = side * x}, 1e4, true);
    RunTo(motion, 8);  // before it comes to the other stop
    ASSERT_EQ(motion.events().size(), 3U);
    const Eigen::VectorXd end = motion.Positions();
    const double speed = end(LinearModel::kMoverVelocity) - end(LinearModel::kCaseVelocity);
    const EnergyLedger ledger = motion.Ledger();
    const auto stops = static_cast<std::size_t>(SceneElement::kStop);
    EXPECT_REL(ledger.dissipated_j[stops], mass_kg * (0.49 - speed * speed) / 2, 1e-11,
               "the relative motion's energy");
    EXPECT_LT(std::abs(speed), 0.5);
    for (std::size_t k = 0; k < ledger.dissipated_j.size(); ++k) {
      EXPECT_EQ(ledger.dissipated_j[k] == 0, k != stops) << kSceneElements[k];
    }
  }
}

TEST(PiecewiseScene, NamesItsModes) {
  using Names = std::vector<std::string_view>;
  const auto names = [](const PiecewiseEffects& effects) {
    Names found;
    const PiecewiseLinearSystem system = AssemblePiecewise(AdapterScene(), effects);
    for (const Mode& mode : system.modes) found.push_back(mode.name);
    return found;
  };
  EXPECT_EQ(names({.stops = Rigid(1e-3, 0.5)}), (Names{"linear", "resting up", "resting down"}));
  EXPECT_EQ(names({.stops = Compliant(1e-3, 1e5, 0)}),
            (Names{"linear", "pressed up", "pressed down"}));
  EXPECT_EQ(names({.stops = Compliant(1e-3, 1e5, 1)}),
            (Names{"linear", "pressed up", "leaving up", "pressed down", "leaving down"}));
  EXPECT_EQ(names({.contact_loss = ContactLoss{0.07}}), (Names{"linear", "flight"}));
}

// 1e-13 of half the room between two stops, or of the gap to the only one
TEST(PiecewiseScene, BouncesEndBelowAPartOfTheTravel) {
  const auto heights = [](double up_m, double down_m) {
    std::vector<double> found;
    const PiecewiseLinearSystem system = AssemblePiecewise(
        AdapterScene(), {.stops = TravelStops{.gap_up_m = up_m, .gap_down_m = down_m}});
    for (const Transition& way : system.transitions) {
      if (way.bounce) found.push_back(way.bounce->rest_height);
    }
    return found;
  };
  const std::vector<double> two = heights(2e-4, 4e-4), up = heights(2e-4, TravelStops::kNone),
                            down = heights(TravelStops::kNone, 5e-4);
  ASSERT_EQ(two.size(), 2U);
  for (const double height_m : two) EXPECT_REL(height_m, 3e-17, 1e-14, "rounding");
  ASSERT_EQ(up.size(), 1U);
  EXPECT_REL(up[0], 2e-17, 1e-14, "rounding");
  ASSERT_EQ(down.size(), 1U);
  EXPECT_REL(down[0], 5e-17, 1e-14, "rounding");
}

TEST(PiecewiseScene, BeginsWhereTheSceneSays) {
  Scene scene = FromRest(AdapterScene());
  scene.initial = {.mover_m = 1,
                   .mover_m_per_s = 2,
                   .case_m = 3,
                   .case_m_per_s = 4,
                   .skin_m = 5,
                   .skin_m_per_s = 6,
                   .current_a = 7};
  const auto begin = [](const Scene& that) { return PiecewiseStartOf(that).x; };
  EXPECT_EQ(begin(scene), (Eigen::Vector<double, 7>(1, 2, 3, 4, 5, 6, 7)));
  EXPECT_EQ(begin(WithoutInductance(scene)), (Eigen::Vector<double, 6>(1, 2, 3, 4, 5, 6)));
  scene.adapter.reset();
  EXPECT_EQ(begin(scene), (Eigen::Vector<double, 5>(1, 2, 3, 4, 7)));
  EXPECT_EQ(begin(WithoutInductance(scene)), Eigen::Vector4d(1, 2, 3, 4));
  EXPECT_EQ(PiecewiseStartOf(scene).mode, 0U);
}

// xv - xa and Ks (xs - xg) + Bs (vs - vg), in flight the preload that is missing
TEST(PiecewiseScene, WatchesTravelAndForceInEveryMode) {
  for (Scene scene : {AdapterScene(), tests::DirectScene()}) {
    scene.finger.tones = {{.amplitude = 1e-5, .frequency_hz = 9}};
    const PiecewiseEffects effects{.stops = Rigid(1e-4, 0.5), .contact_loss = ContactLoss{0.07}};
    PiecewiseLinearSystem system = AssemblePiecewise(scene, effects);
    WatchTravelAndForce(scene, effects, system);
    const Eigen::Vector3d inputs(5, 2e-4, 0.3);
    const LinearModel model = AssembleModel(scene);
    ASSERT_EQ(system.modes.size(), 6U);
    for (std::size_t k = 0; k < system.modes.size(); ++k) {
      const Mode& mode = system.modes[k];
      Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(mode.a.rows(), 0.3, -1.7);
      if (k > 0) x(x.size() - 1) = 1;
      const Eigen::VectorXd at = mode.positions.size() > 0 ? mode.positions * x : x;
      const auto value = [&](const WatchedNumber& number) {
        const double feed = number.feed.size() > 0 ? number.feed.dot(inputs) : 0;
        return number.row.dot(x) + number.offset + feed;
      };
      ASSERT_EQ(mode.watched.size(), 2U);
      EXPECT_ABS(value(mode.watched[kWatchedTravel]),
                 at(LinearModel::kMover) - at(LinearModel::kCase), 1e-14, "rounding");
      const double force_n =
          scene.skin.stiffness_n_per_m * (at(model.skin()) - inputs(kFinger)) +
          scene.skin.damping_n_s_per_m * (at(model.skin_velocity()) - inputs(kFingerRate));
      EXPECT_REL(value(mode.watched[kWatchedForce]), k < 3 ? force_n : -0.07, 1e-13, "rounding");
    }
  }
}

TEST(PiecewiseScene, AStifferStopIsMoreLikeARigidOne) {
  const Scene scene = FromRest(AdapterScene());
  const Eigen::MatrixXd rigid = SamplesOf(scene, {.stops = Rigid(0.3e-3, 1)}, 120);
  double before = 1;
  for (const double k : {1e6, 1e8, 1e10}) {
    const Eigen::MatrixXd soft = SamplesOf(scene, {.stops = Compliant(0.3e-3, k, 0)}, 120);
    const double apart =
        (soft.row(4) - rigid.row(4)).cwiseAbs().maxCoeff() / rigid.row(4).cwiseAbs().maxCoeff();
    EXPECT_LT(apart, 0.2 * before) << k;  // the contact's duration: a tenth for each factor of 100
    before = apart;
  }
}

TEST(PiecewiseScene, EnergyClosesWhateverHappens) {
  for (const Scene& scene : {FromRest(AdapterScene()), FromRest(tests::DirectScene()),
                             WithoutInductance(FromRest(AdapterScene())),
                             WithoutInductance(FromRest(tests::DirectScene()))}) {
    const double travel_m = LargestTravel(SamplesOf(scene, {}, 500));
    const double gap_m = 0.6 * travel_m;
    std::vector<PiecewiseEffects> cases{{}};
    for (const auto& loss : {std::optional<ContactLoss>(), std::optional(ContactLoss{0.03})}) {
      for (const double e : {0.0, 0.5, 1.0}) {
        cases.push_back({.stops = Rigid(gap_m, e), .contact_loss = loss});
      }
      for (const double c : {0.0, 0.5}) {
        cases.push_back({.stops = Compliant(gap_m, 1e5, c), .contact_loss = loss});
      }
      cases.push_back({.contact_loss = loss});
    }
    for (const PiecewiseEffects& effects : cases) {
      PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive,
                             PiecewiseStartOf(scene), 1e4, true);
      RunTo(motion, 500);
      EXPECT_FALSE(motion.stalled_at_s().has_value());
      const EnergyLedger ledger = motion.Ledger();
      EXPECT_ABS(ledger.Imbalance(), 0, 1e-12, "sums of exact integrals");
      EXPECT_GE(ledger.impact_j, -1e-15);
      for (const double part_j : ledger.dissipated_j) EXPECT_GE(part_j, 0);
    }
  }
}

TEST(PiecewiseScene, TheRateOfOutputsDoesNotMatter) {
  const Scene scene = FromRest(AdapterScene());
  for (const TravelStops& stops : {Rigid(0.3e-3, 0.5), Compliant(0.3e-3, 1e5, 0.5)}) {
    const PiecewiseEffects effects{.stops = stops, .contact_loss = ContactLoss{0.07}};
    std::vector<std::vector<Event>> runs;
    for (const double rate_hz : {1e5, 1e4, 320.0, 40.0}) {
      PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive,
                             PiecewiseStartOf(scene), rate_hz);
      RunTo(motion, 0.025 * rate_hz);
      runs.push_back(motion.events());
    }
    EXPECT_GT(runs[0].size(), 10U);
    for (const std::vector<Event>& run : runs) {
      ASSERT_EQ(run.size(), runs[0].size());
      for (std::size_t k = 0; k < run.size(); ++k) {
        EXPECT_EQ(run[k].transition, runs[0][k].transition);
        EXPECT_ABS(run[k].time_s, runs[0][k].time_s, 1e-12, "the bar for events");
      }
    }
  }
}

TEST(PiecewiseScene, NothingPassesAStopOrPulls) {
  const Scene scene = FromRest(AdapterScene());
  const PiecewiseEffects effects{.stops = Rigid(0.3e-3, 0.3), .contact_loss = ContactLoss{0.03}};
  PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                         1e4);
  std::size_t visited = 0;
  for (int i = 0; i < 1000; ++i) {
    motion.Next();
    visited |= std::size_t{1} << motion.mode();
    const Eigen::VectorXd x = motion.Positions();
    EXPECT_LE(std::abs(x(LinearModel::kMover) - x(LinearModel::kCase)), 0.3e-3 * (1 + 1e-12));
    for (const Guard& guard : motion.system().modes[motion.mode()].guards) {
      EXPECT_GE(guard.row.dot(motion.x()) + guard.offset, -1e-15);
    }
  }
  EXPECT_FALSE(motion.stalled_at_s().has_value());
  EXPECT_GT(visited, 8U) << "also flights were visited";
}

// scenes and effects drawn over wide ranges
class RandomScenes {
 public:
  explicit RandomScenes(std::uint64_t seed) : engine_(seed) {}

  Scene NextScene() {
    Scene scene = FromRest(Chance(2) ? AdapterScene() : tests::DirectScene());
    scene.drive = {.amplitude_v = Between(0.5, 10), .frequency_hz = Between(20, 600)};
    scene.skin = {.stiffness_n_per_m = Between(200, 3000),
                  .damping_n_s_per_m = Chance(8) ? 0 : Between(0.1, 4)};
    scene.actuator.inductance_h = Chance(4) ? 0 : Between(1e-6, 1e-3);
    scene.actuator.damping_n_s_per_m = Between(1e-3, 1);
    return scene;
  }

  PiecewiseEffects NextEffects() {
    PiecewiseEffects effects;
    if (!Chance(4)) effects.stops = NextStops();
    if (!Chance(3)) effects.contact_loss = ContactLoss{Between(1e-3, 0.5)};
    return effects;
  }

 private:
  // once in so many
  bool Chance(std::uint64_t many) { return engine_() % many == 0; }
  // evenly over the decades
  double Between(double low, double high) {
    return low * std::pow(high / low, std::ldexp(static_cast<double>(engine_() >> 11U), -53));
  }
  TravelStops NextStops() {
    TravelStops stops{.gap_up_m = Between(2e-5, 1e-3), .gap_down_m = Between(2e-5, 1e-3)};
    if (Chance(2)) {
      stops.stiffness_n_per_m = Between(1e4, 1e11);
      stops.damping_n_s_per_m = Chance(2) ? 0 : Between(1e-2, 100);
    } else {
      stops.restitution = Chance(5) ? 0 : Between(0.05, 1);
    }
    return stops;
  }

  std::mt19937_64 engine_;
};

TEST(PiecewiseScene, RandomScenesKeepTheRules) {
  constexpr std::uint64_t kSeed = 20261121;
  RandomScenes random(kSeed);
  std::size_t with_events = 0;
  for (int i = 0; i < 80; ++i) {
    const Scene scene = random.NextScene();
    const PiecewiseEffects effects = random.NextEffects();
    PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                           1e4, true);
    while (motion.index() < 150 && !motion.stalled_at_s()) {
      motion.Next();
      for (const Guard& guard : motion.system().modes[motion.mode()].guards) {
        EXPECT_GE(guard.row.dot(motion.x()) + guard.offset, -1e-15) << "seed " << kSeed << ' ' << i;
      }
    }
    EXPECT_FALSE(motion.stalled_at_s().has_value()) << "seed " << kSeed << ' ' << i;
    EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-11, "R/L up to 3e7/s over 15 ms: eps R/L t");
    with_events += motion.events().empty() ? 0 : 1;
  }
  EXPECT_GT(with_events, 20U) << "at least a quarter with an effect active";
}

TEST(PiecewiseScene, SkinWithoutDampingSpringsBackAtOnce) {
  for (const double tremor_m : {0.0, 50e-6}) {
    Scene scene = FromRest(AdapterScene());
    scene.skin.damping_n_s_per_m = 0;
    if (tremor_m > 0) scene.finger.tones = {{.amplitude = tremor_m, .frequency_hz = 60}};
    PiecewiseMotion motion(AssemblePiecewise(scene, {.contact_loss = ContactLoss{0.07}}),
                           Excitation(scene.drive, scene.finger.tones), PiecewiseStartOf(scene),
                           OutputGrid{.rate_hz = 1e4}, true);
    while (motion.index() < 500) {
      motion.Next();
      // the force is 0 where contact ends and begins: no energy is lost, aloft neither
      const EnergyLedger ledger = motion.Ledger();
      EXPECT_ABS(ledger.impact_j, 0, 1e-12 * ledger.input_j, "differences of two energies");
    }
    EXPECT_GT(motion.events().size(), 10U);
    EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-12, "sums of exact integrals");
  }
}

}  // namespace
}  // namespace haptometer::sim
