#include "sim/piecewise/motion_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "sim/effect_choice.h"
#include "sim/effective_scene.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene_run.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

Eigen::RowVectorXd Row(double first, double second) { return Eigen::RowVector2d(first, second); }

TEST(MotionError, BoundsBy64StandardDeviations) {
  MotionError error(2);
  EXPECT_EQ(error.Bound(Row(1, 1)), 0);
  error.Add(Eigen::Vector2d(3, -4));
  EXPECT_REL(error.Bound(Row(1, 0)), 64 * 3, 1e-15, "rounding");
  EXPECT_REL(error.Bound(Row(0, 1)), 64 * 4, 1e-15, "rounding");
  EXPECT_ABS(error.Bound(Row(4, 3)), 0, 1e-5, "one deviation; the root of rounding");
  EXPECT_REL(error.Bound(Row(2, -1)), 64 * 10, 1e-15, "rounding");
  // another one, independent of the first
  error.Add(Eigen::Vector2d(0, 5));
  EXPECT_REL(error.Bound(Row(2, -1)), 64 * std::hypot(10, 5), 1e-15, "rounding");
}

TEST(MotionError, IsTurnedByStepsAndMaps) {
  MotionError error(2);
  error.Add(Eigen::Vector2d(3, 4));
  Eigen::Matrix2d phi;
  phi << 2, 1, 0, -1;
  // to [10, -4], and rounding of each state by itself
  error.Step(phi, Eigen::Vector2d(0.5, 6));
  EXPECT_REL(error.Bound(Row(1, 0)), 64 * std::hypot(10, 0.5), 1e-15, "rounding");
  EXPECT_REL(error.Bound(Row(0, 1)), 64 * std::hypot(4, 6), 1e-15, "rounding");
  EXPECT_REL(error.Bound(Row(2, 5)), 64 * std::hypot(1, 30), 1e-14, "rounding");
  // to one coordinate, with an error of its own
  error.Map(Row(2, 5), Eigen::VectorXd::Constant(1, 7));
  const Eigen::RowVectorXd one = Eigen::RowVectorXd::Ones(1);
  EXPECT_REL(error.Bound(one), 64 * std::sqrt(1 + 900 + 49), 1e-14, "rounding");
  error.Add(Eigen::VectorXd::Constant(1, HUGE_VAL));
  EXPECT_EQ(error.Bound(one), HUGE_VAL);
}

// R = [1, 0; 0, -1/2], g' = -2, f+ - R f- = [3, 8]
class Impact {
 public:
  explicit Impact(double curvature) : curvature_(curvature) {}
  [[nodiscard]] EventJump Jump() const {
    return {.map = map_,
            .guard = guard_,
            .guard_rate = -2,
            .guard_curvature = curvature_,
            .guard_rounding = 1e-3,
            .rate_before = Eigen::Vector2d(1, 4),
            .rate_after = Eigen::Vector2d(4, 6),
            .step_of_state = {}};
  }

 private:
  double curvature_;
  Eigen::MatrixXd map_ = Eigen::Vector2d(1, -0.5).asDiagonal();
  Eigen::RowVectorXd guard_ = Eigen::RowVector2d(-1, 0);
};

TEST(MotionError, IsTurnedBySaltationWhereAnEventIsSure) {
  MotionError error(2);
  error.Add(Eigen::Vector2d(0.01, 0.03));
  const Impact impact(0);
  error.Event(impact.Jump());
  // S = R + [3, 8] [-1, 0] / -2 = [2.5, 0; 4, -0.5]; rounding of g by [3, 8] / -2
  EXPECT_REL(error.Bound(Row(1, 0)), 64 * std::hypot(0.025, 1.5e-3), 1e-14, "rounding");
  EXPECT_REL(error.Bound(Row(0, 1)), 64 * std::hypot(0.04 - 0.015, 4e-3), 1e-14, "rounding");
}

// the guard's error e over g'^2 / (2 |g''|): up to a twentieth the event is only moved
TEST(MotionError, NearAGrazeTheEventItselfIsUncertain) {
  // 2 e |g''| = 0.05 g'^2 at |g''| = 10
  constexpr double kDeviation = 0.05 * 4 / (2 * 64 * 10);
  for (const double sign : {1.0, -1.0}) {
    MotionError sure(2), unsure(2);
    for (MotionError* error : {&sure, &unsure}) error->Add(Eigen::Vector2d(kDeviation, 0));
    const Impact below(sign * 9.95), above(sign * 10.05);
    sure.Event(below.Jump());
    EXPECT_REL(sure.Bound(Row(1, 0)), 64 * std::hypot(2.5 * kDeviation, 1.5e-3), 1e-14,
               "S as above");
    EventJump jump = above.Jump();
    jump.step_of_state = Eigen::Vector2d(0, 0.2);
    unsure.Event(jump);
    // twice sqrt(2 e / |g''|) of the rates' jump, and all of the state's
    const double time_s = std::sqrt(2 * 64 * kDeviation / 10.05);
    EXPECT_REL(unsure.Bound(Row(1, 0)), std::hypot(64 * kDeviation, 2 * time_s * 3), 1e-14,
               "rounding");
    EXPECT_REL(unsure.Bound(Row(0, 1)), std::hypot(2 * time_s * 8, 0.2), 1e-14, "rounding");
  }
}

TEST(MotionError, OfAGuardThatDoesNotMoveIsThatOfTheStatesJump) {
  MotionError error(2);
  error.Add(Eigen::Vector2d(1, 2));
  const Impact impact(0);
  EventJump jump = impact.Jump();
  jump.guard_rate = 0;
  jump.step_of_state = Eigen::Vector2d(5, 0);
  error.Event(jump);
  EXPECT_REL(error.Bound(Row(1, 0)), std::hypot(64, 5), 1e-14, "rounding");
  EXPECT_REL(error.Bound(Row(0, 1)), 64, 1e-14, "rounding");
}

EffectSet With(std::initializer_list<Effect> effects) {
  EffectSet on;
  on.set(PlaceOf(Effect::kInductance));
  for (const Effect effect : effects) on.set(PlaceOf(effect));
  return on;
}

TravelStops Rigid(double gap_m, double restitution) {
  return {.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = restitution};
}

// the cone between narrow stops, with constants for every effect
Scene Narrow(double frequency_hz, double gap_m, double restitution) {
  Scene scene = tests::ConeScene();
  scene.start = Start::kRest;
  scene.drive.frequency_hz = frequency_hz;
  scene.effects.travel_stops = Rigid(gap_m, restitution);
  scene.effects.contact_loss = ContactLoss{0.008};
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 2.5e12};
  scene.effects.coil_heating = CoilHeating{
      .heat_capacity_j_per_k = 0.01, .thermal_resistance_k_per_w = 50, .resistance_per_k = 3.9e-3};
  scene.finger.tones = {{.amplitude = 4e-6, .frequency_hz = 11, .phase_rad = 0.4}};
  scene.effects.gravity_m_per_s2 = 9.80665;
  return scene;
}

double MomentumOf(const Scene& scene, const Eigen::VectorXd& positions) {
  return scene.actuator.moving_mass_kg * positions(LinearModel::kMoverVelocity) +
         CaseSideMass(scene) * positions(LinearModel::kCaseVelocity);
}

// whatever mover and case come to rest with against each other, in contact and in flight
TEST(PiecewiseScene, ComingToRestKeepsMomentumAndCentre) {
  for (const Scene& scene : {tests::AdapterScene(), tests::ConeScene()}) {
    const PiecewiseEffects effects{.stops = Rigid(7e-6, 0.6), .contact_loss = ContactLoss{0.03}};
    const PiecewiseLinearSystem system = AssemblePiecewise(scene, effects);
    int rests = 0;
    for (const Mode& mode : system.modes) {
      for (const Guard& guard : mode.guards) {
        const Transition& impact = system.transitions[guard.transition];
        if (!impact.bounce) continue;
        const Transition& rest = system.transitions[impact.bounce->rest_via];
        Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(rest.map.cols(), 1e-6, 9e-6);
        x.tail(1) << (mode.positions.size() > 0 ? 1 : x(x.size() - 1));
        const Eigen::VectorXd after = rest.map * x + rest.shift;
        const Eigen::MatrixXd& to = system.modes[rest.mode].positions;
        const Eigen::VectorXd before = mode.positions.size() > 0 ? mode.positions * x : x;
        EXPECT_REL(MomentumOf(scene, to * after), MomentumOf(scene, before), 1e-14, "rounding");
        const double speed = (to * after)(LinearModel::kMoverVelocity);
        EXPECT_REL(speed, (to * after)(LinearModel::kCaseVelocity), 1e-15, "together");
        ++rests;
      }
    }
    EXPECT_EQ(rests, 4) << "both stops, in contact and in flight";
  }
}

// speed after over speed before of a pad of k and c under a reduced mass, at any k of the same
// ratio
double RestitutionOf(double ratio) {
  const double turned = std::sqrt(1 - ratio * ratio);
  const double angle = std::atan2(2 * ratio * turned, -(1 - 2 * ratio * ratio));
  return -std::exp(-ratio / turned * angle) * (std::cos(angle) - ratio / turned * std::sin(angle));
}

// Rigid stops are what compliant ones come to as they stiffen, resting against them included:
// alone and with each effect that may push or pull meanwhile.
TEST(SceneRun, RigidStopsAreTheLimitOfStiffOnes) {
  constexpr double kRatio = 0.8;  // of critical damping
  const std::vector<EffectSet> cases{
      With({Effect::kTravelStops}),
      With({Effect::kTravelStops, Effect::kGravity}),
      With({Effect::kTravelStops, Effect::kContactLoss}),
      With({Effect::kTravelStops, Effect::kTremor}),
      With({Effect::kTravelStops, Effect::kStiffening}),
      With({Effect::kTravelStops, Effect::kCoilHeating}),
      With({Effect::kTravelStops, Effect::kStiffening, Effect::kGravity})};
  for (const EffectSet& on : cases) {
    Scene scene = Narrow(70, 2.4e-5, RestitutionOf(kRatio));
    scene.tolerance = 1e-5;
    const SceneRun rigid = RunScene(WithEffects(scene, on), 0.05);
    const bool rests = std::ranges::any_of(
        rigid.events, [](const EventCount& event) { return event.name.starts_with("rest"); });
    EXPECT_TRUE(rests) << on;
    double before = 1;
    for (const double k : {1e7, 1e9}) {
      const double mass_kg =
          1 / (1 / scene.actuator.moving_mass_kg + 1 / scene.actuator.case_mass_kg);
      scene.effects.travel_stops->stiffness_n_per_m = k;
      scene.effects.travel_stops->damping_n_s_per_m = 2 * kRatio * std::sqrt(k * mass_kg);
      const SceneRun soft = RunScene(WithEffects(scene, on), 0.05);
      const double apart = std::abs(soft.skin_rms_m / rigid.skin_rms_m - 1);
      EXPECT_LT(apart, 0.3 * before) << on << ' ' << k << ": a tenth, as the contact's duration";
      before = apart;
    }
    EXPECT_ABS(before, 0, 3e-4, "the contact's duration of a microsecond over the period's part");
  }
}

// The saltation matrix is the derivative of what happens, event by event, against differences.
TEST(SceneRun, ErrorsGrowByWhatPerturbationsGrowBy) {
  Scene scene = Narrow(150, 9e-5, 0.55);
  const EffectiveScene effective =
      WithEffects(scene, With({Effect::kTravelStops, Effect::kContactLoss}));
  const SceneRun run = RunScene(effective, 0.06);
  EXPECT_GE(run.events.size(), 2U) << "kinds";
  EffectiveScene moved = effective;
  moved.scene.drive.amplitude_v *= 1 + 1e-11;
  const SceneRun other = RunScene(moved, 0.06);
  // a perturbation of 1e-11 over rounding's share of it
  const double growth = Deviation(AskedQuantity::kSkinWaveform, other, run) / 1e-11;
  EXPECT_LT(growth * 0x1p-53, run.error_estimate);
  EXPECT_GT(growth * 1e-11, 0);
  EXPECT_LT(run.error_estimate, 1e-9);
}

// The same motion in other steps: rounding alone differs.
TEST(SceneRun, WhatOtherStepsGiveIsWithinTheStatedError) {
  for (const double restitution : {0.0, 0.3, 0.7, 0.95}) {
    for (const Effect effect : {Effect::kTravelStops, Effect::kContactLoss, Effect::kGravity}) {
      EffectiveScene scene = WithEffects(Narrow(110, 6e-6, restitution),
                                         With({Effect::kTravelStops, effect, Effect::kTremor}));
      const SceneRun run = RunScene(scene, 0.08);
      scene.outputs_rate_hz *= 3;
      const SceneRun other = RunScene(scene, 0.08);
      if (run.error_estimate > kLargestPredictedError) continue;
      EXPECT_LE(LargestDeviation(other, run), run.error_estimate + other.error_estimate)
          << restitution << ' ' << static_cast<int>(effect);
      EXPECT_LT(run.error_estimate, 1e-6) << restitution << ' ' << static_cast<int>(effect);
    }
  }
}

// a motion that forgets its beginning only by growing what is wrong with it
Scene Chaotic() {
  Scene scene = tests::DirectScene();
  scene.start = Start::kRest;
  scene.skin = {.stiffness_n_per_m = 1861.2, .damping_n_s_per_m = 2.2185};
  scene.effects.contact_loss = ContactLoss{0.02077};
  scene.effects[Effect::kContactLoss] = Wish::kOn;
  scene.duration_s = 0.6;
  return scene;
}

TEST(ChooseEffects, BeyondPredictionIsSaid) {
  Scene scene = Chaotic();
  scene.drive.amplitude_v = 4.9;
  const auto choice = ChooseEffects(scene);
  ASSERT_FALSE(choice);
  EXPECT_EQ(choice.error().kind, FindingKind::kBeyondPrediction);
  // until then it is known, as another one beside it shows
  const EffectSet on = With({Effect::kContactLoss});
  EffectiveScene effective = WithEffects(scene, on);
  const SceneRun run = RunScene(effective, 0.6);
  ASSERT_TRUE(run.known_until_s);
  EXPECT_GT(*run.known_until_s, 0.02);
  const double known_s = *run.known_until_s * 0.99;
  const SceneRun known = RunScene(effective, known_s);
  effective.outputs_rate_hz *= 2;
  const SceneRun other = RunScene(effective, known_s);
  EXPECT_LE(LargestDeviation(other, known), known.error_estimate);
  EXPECT_LT(known.error_estimate, 2 * scene.tolerance);
}

// The window's integrals are differences of those since t = 0. Where what the bodies began with has
// decayed, 1e-14 of all before it is what they are wrong by: of the case at 225 Hz, the skin at
// 400.
TEST(SceneRun, WhatHasDecayedIsRoundingOfTheWindow) {
  for (const double frequency_hz : {225.0, 400.0}) {
    Scene scene = tests::AdapterScene();
    scene.start = Start::kRest;
    scene.skin.damping_n_s_per_m = 3;
    scene.drive = {.amplitude_v = 1, .frequency_hz = frequency_hz};
    const LinearModel model = AssembleModel(scene);
    PiecewiseStart start{.x = Eigen::VectorXd::Zero(model.states())};
    start.x(frequency_hz > 300 ? model.skin() : Eigen::Index{LinearModel::kMover}) = 1;
    EffectiveScene effective = WithEffects(scene, With({}));
    const SceneRun run = RunScene(effective, 60 / frequency_hz, start);
    effective.window_periods = 50;
    const SceneRun before = RunScene(effective, 50 / frequency_hz, start);
    // integrals over 50 periods and the 10 of the window
    const auto rounding = [](double before_m, double window_m) {
      return 1e-14 * (1 + 5 * std::pow(before_m / window_m, 2));
    };
    const double of_skin = rounding(before.skin_rms_m, run.skin_rms_m);
    const double of_case = rounding(before.case_rms_m, run.case_rms_m);
    EXPECT_GT(frequency_hz > 300 ? of_skin / of_case : of_case / of_skin, 1.1);
    EXPECT_REL(run.error_estimate, std::max(of_skin, of_case), 1e-2, "the motion's own rounding");
  }
}

// beside a stop whose contact settles in 1e-11 s, reached or not
TEST(SceneRun, WhatAnyModeIsTooFastForIsRefused) {
  Scene scene = Narrow(180, 1, 0);
  scene.effects.travel_stops->stiffness_n_per_m = 1e6;
  for (const double damping_n_s_per_m : {1.0, 1e8}) {
    scene.effects.travel_stops->damping_n_s_per_m = damping_n_s_per_m;
    const SceneRun run = RunScene(WithEffects(scene, With({Effect::kTravelStops})), 0.01);
    EXPECT_EQ(run.stall_reason.has_value(), damping_n_s_per_m > 1);
    EXPECT_EQ(run.stalled_at_s.has_value(), damping_n_s_per_m > 1);
  }
}

// a pad that is pressed and left between two outputs
TEST(SceneRun, PeaksAndLeastForceAreLocated) {
  Scene scene = Narrow(180, 1.4e-4, 0);
  scene.adapter = tests::AdapterScene().adapter;
  scene.effects.travel_stops->stiffness_n_per_m = 3e7;
  for (const Effect other : {Effect::kGravity, Effect::kContactLoss, Effect::kTremor}) {
    EffectiveScene effective = WithEffects(scene, With({Effect::kTravelStops, other}));
    const SceneRun run = RunScene(effective, 0.05);
    EXPECT_GT(run.mover_peak_m, 1.4e-4 * 1.0005);
    effective.outputs_rate_hz *= 37;
    const SceneRun fine = RunScene(effective, 0.05);
    EXPECT_REL(run.mover_peak_m, fine.mover_peak_m, 1e-10, "located");
    EXPECT_REL(run.mover_peak_of_run_m, fine.mover_peak_of_run_m, 1e-10, "located");
    EXPECT_REL(run.skin_force_least_n, fine.skin_force_least_n, 1e-10, "located");
  }
}

// the solver's steps against the exact motion's
TEST(SceneRun, PeaksOfSmoothRunsAreLocated) {
  Scene scene = Narrow(180, 1.4e-4, 0);
  scene.adapter = tests::AdapterScene().adapter;
  scene.effects.travel_stops->stiffness_n_per_m = 3e7;
  scene.effects.coil_heating->resistance_per_k = 0;
  scene.tolerance = 1e-8;
  const SceneRun exact = RunScene(WithEffects(scene, With({Effect::kTravelStops})), 0.03);
  const SceneRun run =
      RunScene(WithEffects(scene, With({Effect::kTravelStops, Effect::kCoilHeating})), 0.03);
  EXPECT_REL(run.mover_peak_m, exact.mover_peak_m, 1e-8, "the tolerance");
  EXPECT_REL(run.skin_force_least_n, exact.skin_force_least_n, 1e-7, "the tolerance of a speed");
}

}  // namespace
}  // namespace haptometer::sim
