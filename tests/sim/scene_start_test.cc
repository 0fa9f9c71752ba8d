// How a scene begins and what acts on it all the time: offsets, preloads, initial states, and the
// mountings of a drop test.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <string>

#include "sim/effective_scene.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/ring_down.h"
#include "sim/scene/scene_file.h"
#include "sim/scene_run.h"
#include "sim/sensor_model.h"
#include "sim/steady_run.h"
#include "tests/residual.h"
#include "tests/sim/ring_ratios.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr Eigen::Index kMover = LinearModel::kMover;
constexpr Eigen::Index kMoverVelocity = LinearModel::kMoverVelocity;
constexpr Eigen::Index kCase = LinearModel::kCase;
constexpr Eigen::Index kCaseVelocity = LinearModel::kCaseVelocity;

Scene SceneOf(const std::string& text) {
  const auto scene = ReadSceneText(text, "scene.toml");
  EXPECT_TRUE(scene.has_value()) << (scene ? "" : scene.error().Text());
  return scene.value_or(Scene{});
}

// the scene's motion with the effects that it calls for
std::unique_ptr<PiecewiseMotion> MotionIn(const EffectiveScene& scene, double rate_hz) {
  return std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene.scene, scene.piecewise),
                                           Excitation(scene.scene.drive, scene.scene.finger.tones),
                                           StartIn(scene), OutputGrid{.rate_hz = rate_hz}, true);
}

// ------------------------------------------------------------------------------------------ offset

void ExpectOhmAndTheSpring(Scene scene) {
  const SteadyState alone = SolveSteadyState(scene);
  scene.drive.offset_v = -1.7;
  const SteadyState both = SolveSteadyState(scene);
  const double current_a = -1.7 / scene.actuator.resistance_ohm;
  const double travel_m =
      -scene.actuator.force_constant_n_per_a * current_a / scene.actuator.stiffness_n_per_m;
  EXPECT_REL(both.mean_current_a, current_a, 1e-13, "Ohm's law; rounding");
  EXPECT_REL(both.mean_travel_m, travel_m, 1e-13, "the coil's force over Kv; rounding");
  EXPECT_EQ(both.mean(4), 0) << "the coil's forces cancel outside of the actuator";
  EXPECT_REL(both.mover_peak_m, alone.mover_peak_m + std::abs(travel_m), 1e-13, "rounding");
  EXPECT_REL(both.current_rms_a, std::hypot(alone.current_rms_a, current_a), 1e-13, "rounding");
  EXPECT_REL(both.power_w, alone.power_w + 1.7 * 1.7 / scene.actuator.resistance_ohm, 1e-13,
             "rounding");
  EXPECT_REL(both.skin_rms_m, alone.skin_rms_m, 1e-13, "rounding");
}

// with the current as a state and without
TEST(Offset, HoldsCurrentAndTravelWhereOhmAndTheSpringPutThem) {
  Scene scene = tests::AdapterScene();
  ExpectOhmAndTheSpring(scene);
  scene.actuator.inductance_h = 0;
  ExpectOhmAndTheSpring(scene);
}

void ExpectEachSquareToGrow(double inductance_h) {
  Scene scene = tests::ConeScene();
  scene.actuator.inductance_h = inductance_h;
  scene.drive.kind = DriveKind::kTones;
  scene.drive.tones = {{.amplitude = 2, .frequency_hz = 60}, {.amplitude = 1, .frequency_hz = 90}};
  const SteadyTones alone = SolveSteadyTones(scene);
  scene.drive.offset_v = 0.9;
  const SteadyTones both = SolveSteadyTones(scene);
  const double current_a = 0.9 / scene.actuator.resistance_ohm;
  EXPECT_REL(both.current_rms_a, std::hypot(alone.current_rms_a, current_a), 1e-13, "rounding");
  EXPECT_REL(both.power_w, alone.power_w + 0.9 * current_a, 1e-13, "rounding");
  EXPECT_GT(both.mover_peak_m, alone.mover_peak_m);
  EXPECT_LE(both.mover_peak_m,
            alone.mover_peak_m + current_a * scene.actuator.force_constant_n_per_a /
                                     scene.actuator.stiffness_n_per_m * (1 + 1e-12));

  Scene shaken = tests::ConeScene();
  shaken.actuator.inductance_h = inductance_h;
  shaken.finger.tones = {{.amplitude = 5e-5, .frequency_hz = 8}};
  const SteadyTones still = Superpose(shaken);
  shaken.drive.offset_v = 0.9;
  const SteadyTones pushed = Superpose(shaken);
  EXPECT_REL(pushed.current_rms_a, std::hypot(still.current_rms_a, current_a), 1e-13, "rounding");
  EXPECT_REL(pushed.power_w, still.power_w + 0.9 * current_a, 1e-12, "rounding");
}

TEST(Offset, OfTonesAndUnderTremorAddsToEachSquare) {
  ExpectEachSquareToGrow(130e-6);
  ExpectEachSquareToGrow(0);
}

TEST(Offset, IsAPulseThatDoesNotEnd) {
  for (const bool stopped : {false, true}) {
    EffectiveScene offset{.scene = tests::AdapterScene(), .piecewise = {}};
    offset.scene.start = Start::kRest;
    if (stopped) {
      offset.piecewise.stops =
          TravelStops{.gap_up_m = 5e-5, .gap_down_m = 5e-5, .restitution = 0.4};
    }
    EffectiveScene pulse = offset;
    offset.scene.drive = {.amplitude_v = 0, .frequency_hz = 100, .offset_v = 3.1};
    pulse.scene.drive = {.amplitude_v = 3.1, .kind = DriveKind::kPulse, .hold_s = 1};
    const auto one = MotionIn(offset, 16000), other = MotionIn(pulse, 16000);
    double apart = 0, largest = 0;
    for (int k = 0; k < 4000; ++k) {
      one->Next();
      other->Next();
      apart = std::max(apart, (one->Positions() - other->Positions()).cwiseAbs()(kMover));
      largest = std::max(largest, std::abs(one->Positions()(kMover)));
    }
    EXPECT_EQ(stopped, !one->events().empty());
    EXPECT_EQ(one->events().size(), other->events().size());
    EXPECT_ABS(apart / largest, 0, 1e-11, "rounding, carried through some impacts");
    EXPECT_LT(one->Ledger().Imbalance(), 1e-11);
  }
}

TEST(Offset, ARunFromTheSteadyMotionStaysInIt) {
  EffectiveScene scene{.scene = tests::ConeScene(), .piecewise = {}};
  scene.scene.drive.offset_v = 2.3;
  scene.scene.start = Start::kSteady;
  const SteadyState steady = SolveSteadyState(scene.scene);
  const SceneRun run = RunScene(scene, 20 / scene.scene.drive.frequency_hz);
  EXPECT_REL(run.skin_rms_m, steady.skin_rms_m, 1e-12, "a closed form; rounding of the sums");
  EXPECT_REL(run.current_rms_a, steady.current_rms_a, 1e-12, "rounding of the sums");
  EXPECT_REL(run.power_w, steady.power_w, 1e-12, "rounding of the sums");
  EXPECT_REL(run.mover_peak_m, steady.mover_peak_m, 1e-9, "a peak between 64 outputs");
  // and through stops that it just does not reach, on the side to which the offset pushes
  scene.scene.start.reset();
  scene.piecewise.stops = TravelStops{.gap_up_m = steady.mover_peak_m,
                                      .gap_down_m = steady.mover_peak_m * (1 + 1e-9),
                                      .restitution = 0.5};
  EXPECT_TRUE(SteadyMotionIsFree(scene, steady));
  // which the transient from rest does, and stays with them
  const SteadyRun settled = PlaySteady(scene);
  ASSERT_TRUE(settled.periodic.has_value());
  scene.window_periods = settled.periodic->drive_periods;
  scene.scene.start = Start::kRest;
  const SceneRun late = RunScene(scene, 2000 / scene.scene.drive.frequency_hz);
  EXPECT_REL(late.skin_rms_m, settled.run->skin_rms_m, 1e-9, "2000 periods of transient");
  scene.piecewise.stops->gap_down_m = steady.mover_peak_m * (1 - 1e-9);
  EXPECT_FALSE(SteadyMotionIsFree(scene, steady));
}

TEST(Offset, NeedsASpringToHaveASteadyState) {
  Scene scene = tests::ConeScene();
  scene.skin.stiffness_n_per_m = 0;
  EXPECT_LT(SolveSteadyState(scene).error_estimate, 1);
  scene.drive.offset_v = 1;
  EXPECT_FALSE(SolveSteadyState(scene).error_estimate < 1);
}

// ----------------------------------------------------------------------------------- initial state

TEST(InitialState, IsReadWithItsUnits) {
  const Scene scene = SceneOf(
      "[actuator]\nmodel = 'thesis-c10-100'\npreload_n = -0.25\n"
      "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n"
      "[drive]\nkind = 'sine'\namplitude_v = 1\nfrequency_hz = 225\noffset_v = -1.5\n"
      "[start]\nmover_m = '0.2mm'\nmover_m_per_s = -0.3\ncase_m = '-30um'\ncase_m_per_s = 0.1\n"
      "current_a = 0.02\n");
  EXPECT_EQ(scene.drive.offset_v, -1.5);
  EXPECT_EQ(scene.mover_preload_n, -0.25);
  const PiecewiseStart start = [&] {
    Scene rest = scene;
    rest.start = Start::kRest;
    return PiecewiseStartOf(rest);
  }();
  Eigen::VectorXd expected(5);
  expected << 0.2e-3, -0.3, -30e-6, 0.1, 0.02;
  EXPECT_TRUE(start.x.isApprox(expected, 1e-15)) << start.x.transpose();
}

TEST(InitialState, MomentumOfAnUnheldBodyStays) {
  for (const bool stopped : {false, true}) {
    EffectiveScene scene{.scene = tests::ConeScene(), .piecewise = {}};
    scene.scene.skin = {};
    scene.scene.start = Start::kRest;
    scene.scene.initial = {.mover_m_per_s = 0.5, .case_m = 3e-5, .case_m_per_s = -0.1};
    scene.scene.drive = {.amplitude_v = 2, .frequency_hz = 130, .offset_v = 0.7};
    if (stopped) {
      scene.piecewise.stops = TravelStops{.gap_up_m = 1e-4, .gap_down_m = 1e-4, .restitution = 0.6};
    }
    const double Mv = scene.scene.actuator.moving_mass_kg, Mc = scene.scene.actuator.case_mass_kg;
    const double momentum = Mv * 0.5 - Mc * 0.1;
    // A step's columns for the two positions cancel to some 16 roundings: the body that drifts
    // feels that part of its spring, relative to its distance from where it began.
    const double Kv = scene.scene.actuator.stiffness_n_per_m;
    const double per_m = 16 * std::numeric_limits<double>::epsilon() / 2 * Kv / 8000 / momentum;
    double distances_m = 0;
    const auto motion = MotionIn(scene, 8000);
    for (int k = 1; k <= 2000; ++k) {
      motion->Next();
      const Eigen::VectorXd x = motion->Positions();
      distances_m += x(kCase);
      const double bar = (k + 4) * 1e-15 + per_m * distances_m;
      EXPECT_REL(Mv * x(kMoverVelocity) + Mc * x(kCaseVelocity), momentum, bar,
                 "Newton's third law; rounding of the steps");
      EXPECT_REL(Mv * x(kMover) + Mc * x(kCase), Mc * 3e-5 + momentum * k / 8000, bar,
                 "the centre of mass moves uniformly; rounding of the steps");
    }
    EXPECT_EQ(stopped, !motion->events().empty());
  }
}

TEST(InitialState, RunsAndSensorsBeginThere) {
  Scene scene = tests::ConeScene();
  scene.drive.amplitude_v = 0;
  scene.start = Start::kRest;
  scene.initial = {.case_m = 4e-5};
  const auto sensed = MotionOf(scene, SensorTarget::kCase);
  EXPECT_ABS(sensed(0), 4e-5, 1e-19, "it is given");
  const auto motion = MotionIn({.scene = scene, .piecewise = {}}, 64 * 225);
  for (int k = 0; k < 640; ++k) motion->Next();
  EXPECT_ABS(sensed(10.0 / 225), motion->Positions()(kCase), 1e-15, "2e-11 of the amplitude");
}

// ------------------------------------------------------------------------------------- a held case

// The drop test: the case falls with the actuator in it and is stopped dead.
TEST(DropMounting, IsTheRingDownOfTheFit) {
  for (const double load_ohm : {0.0, 27.0, 60.0}) {
    for (const double inductance_h : {0.0, 130e-6, 2e-3}) {
      Scene scene = SceneOf(
          "[actuator]\nmodel = 'thesis-c10-100'\n"
          "[skin]\nstiffness_n_per_m = 600\ndamping_n_s_per_m = 0.75\n"
          "[drive]\nkind = 'sine'\namplitude_v = 0\nfrequency_hz = 225\n"
          "[mounting]\nkind = 'drop'\nheight_m = '12mm'\n[run]\nduration_s = 0.1\n");
      scene.actuator.inductance_h = inductance_h;
      scene.drive.source_resistance_ohm = load_ohm;
      const double blow_m_per_s = std::sqrt(2 * 9.80665 * 12e-3);
      const Actuator& actuator = scene.actuator;
      const RingDown<double> ring(
          {.stiffness_n_per_m = actuator.stiffness_n_per_m,
           .damping_n_s_per_m = actuator.damping_n_s_per_m,
           .force_constant_squared_n2_per_a2 = std::pow(actuator.force_constant_n_per_a, 2),
           .mass_kg = actuator.moving_mass_kg,
           .coil_resistance_ohm = actuator.resistance_ohm,
           .inductance_h = inductance_h,
           .load_ohm = load_ohm});
      const double rate_hz = 20000;
      const auto motion = MotionIn({.scene = scene, .piecewise = {}}, rate_hz);
      const double peak_m =
          blow_m_per_s / std::sqrt(actuator.stiffness_n_per_m / actuator.moving_mass_kg);
      const double peak_v = actuator.force_constant_n_per_a * blow_m_per_s;
      for (int k = 1; k <= 2000; ++k) {
        motion->Next();
        const double t_s = k / rate_hz;
        EXPECT_ABS(motion->Positions()(kMover) / peak_m,
                   DisplacementRatio(ring, t_s) * blow_m_per_s / peak_m, 1e-12,
                   "two closed forms; rounding");
        ASSERT_EQ(motion->Positions()(kCase), 0);
        // the load's voltage drives the current, against the coil's sense
        EXPECT_ABS(-load_ohm * motion->CurrentA() / peak_v,
                   VoltageRatio(ring, t_s) * peak_v / peak_v, 1e-12, "two closed forms; rounding");
      }
      EXPECT_LT(motion->Ledger().Imbalance(), 1e-11);
    }
  }
}

TEST(DropMounting, OfAFreeCaseIsTheRingDownOfBothMasses) {
  Scene scene = tests::ConeScene();
  scene.skin = {};
  scene.start = Start::kRest;
  scene.drive = {.amplitude_v = 0, .frequency_hz = 225, .source_resistance_ohm = 27};
  scene.initial = {.mover_m_per_s = 0.3, .case_m_per_s = -0.2};
  const Actuator& actuator = scene.actuator;
  const double mass_kg = actuator.moving_mass_kg * actuator.case_mass_kg /
                         (actuator.moving_mass_kg + actuator.case_mass_kg);
  const RingDown<double> ring(
      {.stiffness_n_per_m = actuator.stiffness_n_per_m,
       .damping_n_s_per_m = actuator.damping_n_s_per_m,
       .force_constant_squared_n2_per_a2 = std::pow(actuator.force_constant_n_per_a, 2),
       .mass_kg = mass_kg,
       .coil_resistance_ohm = actuator.resistance_ohm,
       .inductance_h = actuator.inductance_h,
       .load_ohm = 27});
  const auto motion = MotionIn({.scene = scene, .piecewise = {}}, 20000);
  const double peak_m = 0.5 / std::sqrt(actuator.stiffness_n_per_m / mass_kg);
  for (int k = 1; k <= 2000; ++k) {
    motion->Next();
    const Eigen::VectorXd x = motion->Positions();
    EXPECT_ABS((x(kMover) - x(kCase)) / peak_m, DisplacementRatio(ring, k / 20000.0) * 0.5 / peak_m,
               1e-12, "two closed forms; rounding");
  }
}

TEST(HeldCase, HasTheSteadyStateOfTheMoverAlone) {
  Scene scene = tests::ConeScene();
  scene.grip.holds = true;
  scene.drive.offset_v = 0.4;
  const SteadyState steady = SolveSteadyState(scene);
  const Actuator& a = scene.actuator;
  const double w = 2 * std::numbers::pi * scene.drive.frequency_hz;
  const std::complex<double> s(0, w);
  const std::complex<double> coil = a.resistance_ohm + a.inductance_h * s;
  const std::complex<double> mover =
      -a.force_constant_n_per_a * scene.drive.amplitude_v / coil /
      (a.moving_mass_kg * s * s + a.damping_n_s_per_m * s + a.stiffness_n_per_m +
       a.force_constant_n_per_a * a.force_constant_n_per_a * s / coil);
  EXPECT_REL(std::abs(steady.phasors(kMover)), std::abs(mover), 1e-13, "a closed form; rounding");
  EXPECT_EQ(steady.skin_rms_m, 0);
  EXPECT_LT(steady.error_estimate, 1e-12) << "rounding of the current and the mover";
  // stops limit it as they limit any other
  EffectiveScene stopped{.scene = scene, .piecewise = {}};
  stopped.piecewise.stops = TravelStops{
      .gap_up_m = std::abs(mover) * 0.8, .gap_down_m = std::abs(mover), .restitution = 0.5};
  const SteadyRun settled = PlaySteady(stopped);
  ASSERT_TRUE(settled.periodic.has_value());
  EXPECT_TRUE(settled.periodic->stable);
}

// ----------------------------------------------------------------------------------------- preload

TEST(MoverPreload, MovesTheMoverByForceOverStiffness) {
  Scene scene = tests::ConeScene();
  scene.mover_preload_n = 0.21;
  const double sag_m = 0.21 / scene.actuator.stiffness_n_per_m;
  EXPECT_REL(MoverSag(scene, false), sag_m, 1e-15, "Hooke's law");
  scene.effects.travel_stops = TravelStops{.gap_up_m = 2e-4, .gap_down_m = 3e-4, .restitution = 0};
  scene.effects.contact_loss = ContactLoss{0.05};
  EffectSet on;
  on.set(PlaceOf(Effect::kTravelStops)).set(PlaceOf(Effect::kContactLoss));
  const EffectiveScene effective = WithEffects(scene, on);
  EXPECT_REL(effective.piecewise.stops->gap_up_m, 2e-4 - sag_m, 1e-13, "Hooke's law");
  EXPECT_REL(effective.piecewise.stops->gap_down_m, 3e-4 + sag_m, 1e-13, "Hooke's law");
  EXPECT_REL(effective.piecewise.contact_loss->preload_n, 0.05 + 0.21, 1e-15, "forces add");
  EXPECT_FALSE(RestsOnStop(effective));
}

// A valve: a preload holds the mover at its stop, with N more than the spring takes. The coil lifts
// it when its current has risen to N/Km: t = -L/R ln(1 - N R/(Km V)) where the case is held.
TEST(MoverPreload, HoldsAValveUntilTheCoilLiftsIt) {
  Scene scene = tests::ConeScene();
  scene.grip.holds = true;
  scene.actuator.inductance_h = 5e-3;
  const Actuator& a = scene.actuator;
  const double gap_m = 5e-5, excess_n = 0.11;
  const double lift_v = excess_n / a.force_constant_n_per_a * a.resistance_ohm;
  for (const double side : {1.0, -1.0}) {
    scene.mover_preload_n = side * (a.stiffness_n_per_m * gap_m + excess_n);
    scene.effects.travel_stops =
        TravelStops{.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = 0.3};
    scene.start = Start::kRest;
    EffectSet on;
    on.set(PlaceOf(Effect::kInductance)).set(PlaceOf(Effect::kTravelStops));
    for (const double part : {0.999, 1.3}) {
      scene.drive = {.amplitude_v = 0, .frequency_hz = 100, .offset_v = side * part * lift_v};
      const EffectiveScene effective = WithEffects(scene, on);
      ASSERT_TRUE(RestsOnStop(effective));
      const auto motion = MotionIn(effective, 20000);
      const double rest_m = motion->Positions()(kMover);
      EXPECT_REL(rest_m, -side * excess_n / a.stiffness_n_per_m, 1e-12,
                 "the gap, from where preload and spring would be in balance");
      for (int k = 0; k < 400; ++k) motion->Next();
      if (part < 1) {
        EXPECT_TRUE(motion->events().empty());
        EXPECT_EQ(motion->Positions()(kMover), rest_m);
        continue;
      }
      ASSERT_FALSE(motion->events().empty());
      EXPECT_REL(motion->events()[0].time_s,
                 -a.inductance_h / a.resistance_ohm * std::log(1 - 1 / part), 1e-10,
                 "a closed form; the time of an event is good to 1e-12 s");
      EXPECT_LT(motion->Ledger().Imbalance(), 1e-11);
    }
  }
}

TEST(MoverPreload, RestsAsDeepInACompliantStopAsCarriesIt) {
  for (const bool stiffens : {false, true}) {
    Scene scene = tests::ConeScene();
    scene.drive.amplitude_v = 0;
    scene.start = Start::kRest;
    scene.mover_preload_n = 0.5;
    scene.effects.travel_stops = TravelStops{
        .gap_up_m = 5e-5, .gap_down_m = 5e-5, .stiffness_n_per_m = 2e4, .damping_n_s_per_m = 1};
    scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 3e10};
    EffectSet on;
    on.set(PlaceOf(Effect::kInductance)).set(PlaceOf(Effect::kTravelStops));
    if (stiffens) on.set(PlaceOf(Effect::kStiffening));
    const EffectiveScene effective = WithEffects(scene, on);
    const SceneRun run = RunScene(effective, 0.05);
    EXPECT_FALSE(run.stalled_at_s);
    EXPECT_TRUE(run.events.empty());
    // F = Kv d + K3 d^3 + k (d - gap), d from where the spring is at ease
    const double travel_m = run.mover_peak_m;
    const double d = MoverSag(scene, false, stiffens) - travel_m;
    const double force_n = 2800 * d + (stiffens ? 3e10 * d * d * d : 0) + 2e4 * (d - 5e-5);
    EXPECT_REL(force_n, 0.5, 1e-9, "statics; the peak between outputs");
  }
}

// F = Kv d + K3 d^3 + k (|d| - gap) to either side, where the cubic takes half of it: the first
// step of an iteration from the linear spring is a fifth off
TEST(MoverPreload, IsInBalanceToTheLastDigitsInACompliantStop) {
  for (const double side : {1.0, -1.0}) {
    Scene scene = tests::ConeScene();
    scene.start = Start::kRest;
    scene.mover_preload_n = 2 * side;
    scene.effects.travel_stops =
        TravelStops{.gap_up_m = 5e-5, .gap_down_m = 6e-5, .stiffness_n_per_m = 2e4};
    scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 3e12};
    EffectSet on;
    on.set(PlaceOf(Effect::kTravelStops)).set(PlaceOf(Effect::kStiffening));
    const EffectiveScene effective = WithEffects(scene, on);
    ASSERT_TRUE(RestsOnStop(effective));
    const double travel_m = MotionIn(effective, 1e4)->Positions()(kMover);
    const double d = side * (MoverSag(scene, false, true) + travel_m);
    const double gap_m = side > 0 ? 5e-5 : 6e-5;
    EXPECT_GT(d, gap_m);
    EXPECT_REL(2800 * d + 3e12 * d * d * d + 2e4 * (d - gap_m), 2.0, 1e-13,
               "some roundings of sums whose terms are 2 N");
  }
}

// a start that is stated is not moved to the stop on which the mover would rest
TEST(MoverPreload, LeavesAStatedStartWhereItIs) {
  Scene scene = tests::ConeScene();
  scene.start = Start::kRest;
  scene.mover_preload_n = 0.5;
  scene.effects.travel_stops = TravelStops{.gap_up_m = 5e-5, .gap_down_m = 5e-5};
  EffectSet on;
  on.set(PlaceOf(Effect::kTravelStops));
  for (double InitialState::* place : {&InitialState::mover_m, &InitialState::case_m}) {
    scene.initial = {};
    scene.initial.*place = -1e-5;
    const EffectiveScene effective = WithEffects(scene, on);
    ASSERT_TRUE(RestsOnStop(effective));
    const PiecewiseStart start = StartIn(effective);
    EXPECT_EQ(start.mode, 0U);
    EXPECT_EQ(start.x, PiecewiseStartOf(effective.scene).x);
  }
  scene.initial = {};
  EXPECT_NE(StartIn(WithEffects(scene, on)).mode, 0U) << "it rests at the stop";
}

}  // namespace
}  // namespace haptometer::sim
