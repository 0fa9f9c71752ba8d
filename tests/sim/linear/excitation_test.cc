#include "sim/linear/excitation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <vector>

#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_scene.h"
#include "tests/repetitions.h"
#include "tests/residual.h"
#include "tests/sim/reference/linear_reference.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

using tests::AdapterScene;

constexpr double kTwoPi = 2 * std::numbers::pi;

// derivatives above 0 rise to their bounds at the piece's end
TEST(ExcitationPiece, SignalsStayWithinTheirBounds) {
  const ExcitationPiece piece{
      .begin_s = 0,
      .end_s = 0.5L,
      .terms = {
          {.kind = ExcitationTerm::Kind::kPolynomial, .degree = 3, .derivatives = {1, 2, 3, 4}}}};
  Eigen::VectorXd at_end;
  FillSignals(piece, piece.end_s, at_end);
  const Eigen::VectorXd largest = LargestSignals(piece);
  ASSERT_EQ(largest.size(), 4);
  for (Eigen::Index k = 0; k < 4; ++k) {
    EXPECT_REL(largest[k], at_end[k], 1e-15, "the same sum") << k;
  }
}

TEST(ExcitationPiece, TonesAreBoundedByOneAndRampsByTheirLength) {
  const ExcitationTerm tone{.amplitude = 7, .frequency_hz = 50};
  ExcitationTerm ramped = tone;
  ramped.kind = ExcitationTerm::Kind::kRampedTone;
  const Eigen::VectorXd largest =
      LargestSignals({.begin_s = 1, .end_s = 1.25L, .terms = {ramped, tone}});
  Eigen::VectorXd expected(6);
  expected << 1, 0, 0.25, 0, 1, 0;
  EXPECT_EQ(largest, expected);
}

// amplitudes of tones and the degree of a polynomial stand in the matrices, phases do not
TEST(SameShape, AsksForWhatTheMatricesHold) {
  using Kind = ExcitationTerm::Kind;
  const auto same = [](const ExcitationTerm& one, const ExcitationTerm& other) {
    return SameShape({.terms = {one}}, {.terms = {other}});
  };
  const ExcitationTerm tone{
      .kind = Kind::kRampedTone, .amplitude = 1, .amplitude_per_s = 2, .frequency_hz = 3};
  ExcitationTerm other = tone;
  other.phase_rad = other.origin_s = 0.5;
  EXPECT_TRUE(same(tone, other));
  (other = tone).kind = Kind::kTone;
  EXPECT_FALSE(same(tone, other));
  (other = tone).input = kFinger;
  EXPECT_FALSE(same(tone, other));
  (other = tone).amplitude = 1.01;
  EXPECT_FALSE(same(tone, other));
  (other = tone).amplitude_per_s = 2.01;
  EXPECT_FALSE(same(tone, other));
  (other = tone).frequency_hz = 3.01;
  EXPECT_FALSE(same(tone, other));
  EXPECT_FALSE(SameShape({.terms = {tone}}, {.terms = {tone, tone}}));
  const ExcitationTerm cubic{.kind = Kind::kPolynomial, .degree = 3, .derivatives = {1, 2, 3, 4}};
  (other = cubic).derivatives = {4, 3, 2, 1};
  EXPECT_TRUE(same(cubic, other));
  other.degree = 2;
  EXPECT_FALSE(same(cubic, other));
}

Scene WithDrive(Scene scene, Drive drive) {
  scene.start = Start::kRest;
  scene.drive = std::move(drive);
  return scene;
}

Drive Burst(double start_s) {
  return {.amplitude_v = 5,
          .frequency_hz = 225,
          .kind = DriveKind::kBurst,
          .start_s = start_s,
          .rise_s = 0.0071,
          .hold_s = 0.0213,
          .fall_s = 0.0051};
}

Drive Pulse(double start_s, double hold_s) {
  return {.amplitude_v = 3, .kind = DriveKind::kPulse, .start_s = start_s, .hold_s = hold_s};
}

Drive Chirp(double tolerance) {
  return {.amplitude_v = 2,
          .frequency_hz = 50,
          .kind = DriveKind::kChirp,
          .start_s = 1e-3,
          .end_frequency_hz = 400,
          .duration_s = 0.03,
          .hold_tolerance = tolerance};
}

PiecewiseMotion Motion(const Scene& scene, const PiecewiseEffects& effects, double rate_hz) {
  return {AssemblePiecewise(scene, effects), Excitation(scene.drive, scene.finger.tones),
          PiecewiseStartOf(scene), OutputGrid{.rate_hz = rate_hz}, true};
}

Eigen::MatrixXd Samples(const Scene& scene, const PiecewiseEffects& effects, double rate_hz,
                        Eigen::Index count) {
  PiecewiseMotion motion = Motion(scene, effects, rate_hz);
  Eigen::MatrixXd samples(motion.Positions().size(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    samples.col(i) = motion.Positions();
    motion.Next();
  }
  return samples;
}

Eigen::MatrixXd Samples(const Scene& scene, double rate_hz, Eigen::Index count) {
  return Samples(scene, {}, rate_hz, count);
}

// largest difference of any state over its largest value
double Apart(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other) {
  const Eigen::VectorXd largest = other.cwiseAbs().rowwise().maxCoeff();
  return (one - other).cwiseAbs().rowwise().maxCoeff().cwiseQuotient(largest).maxCoeff();
}

TEST(CubicsOf, AChirpWhoseFrequencyRisesWithinAPeriodCountsItsRate) {
  // w = 200 pi, a = 180 pi / 0.0105 s: 6 a w^2 is nearly w^4, and the bound asks for 310.0977
  const Drive chirp{.frequency_hz = 10,
                    .kind = DriveKind::kChirp,
                    .end_frequency_hz = 100,
                    .duration_s = 0.0105,
                    .hold_tolerance = 1e-9};
  EXPECT_EQ(CubicsOf(chirp), 311);
}

// a bound of |v^(4)| over the amplitude, with w the larger frequency and a the rate of its change
double FourthDerivative(const Drive& chirp) {
  const double w = kTwoPi * std::max(chirp.frequency_hz, chirp.end_frequency_hz);
  const double a = kTwoPi * (chirp.end_frequency_hz - chirp.frequency_hz) / chirp.duration_s;
  return std::pow(w, 4) + 6 * std::abs(a) * w * w + 3 * a * a;
}

TEST(CubicsOf, AreAsManyAsTheToleranceAsksForAndTheSameInEachMillisecond) {
  for (const double tolerance : {1e-5, 1e-8}) {
    Drive chirp = Chirp(tolerance);
    const auto least = [&] {
      return chirp.duration_s * std::pow(FourthDerivative(chirp) / (384 * tolerance), 0.25);
    };
    // 30 ms
    EXPECT_EQ(std::fmod(CubicsOf(chirp), 30), 0);
    EXPECT_GE(CubicsOf(chirp), least());
    EXPECT_LT(CubicsOf(chirp), least() + 31);
    chirp.duration_s = 0.0304;
    EXPECT_EQ(CubicsOf(chirp), std::ceil(least()));
    std::swap(chirp.frequency_hz, chirp.end_frequency_hz);
    EXPECT_EQ(CubicsOf(chirp), std::ceil(least())) << "downwards";
  }
}

TEST(Excitation, AChirpsErrorIsThatOfItsCubics) {
  for (const double tolerance : {1e-5, 1e-8}) {
    Drive chirp = Chirp(tolerance);
    chirp.amplitude_v = -2;
    const double step_s = chirp.duration_s / CubicsOf(chirp);
    EXPECT_REL(Excitation(chirp, {}).voltage_error_v(),
               2 * FourthDerivative(chirp) * std::pow(step_s, 4) / 384, 1e-13,
               "h^4/384 max |v^(4)|, rounding");
  }
  EXPECT_EQ(Excitation(Burst(0), {}).voltage_error_v(), 0);
}

TEST(Excitation, OfOneToneIsTheSine) {
  const Scene sine = WithDrive(AdapterScene(), AdapterScene().drive);
  const Scene tone = WithDrive(AdapterScene(), {.kind = DriveKind::kTones,
                                                .tones = {{.amplitude = 5, .frequency_hz = 225}}});
  EXPECT_EQ(Samples(tone, 1e4, 500), Samples(sine, 1e4, 500));
  const LinearModel model = AssembleModel(sine);
  EXPECT_EQ(Samples(sine, 1e4, 500),
            UniformMotion(model, sine.drive, Eigen::VectorXd::Zero(7), 0, 1e4, 500));
}

TEST(Excitation, TonesSuperpose) {
  const std::vector<Tone> tones{{1, 40, 0.3}, {2, 225, -1}, {0.5, 333, 2}};
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(7, 300);
  for (const Tone& tone : tones) {
    sum +=
        Samples(WithDrive(AdapterScene(), {.kind = DriveKind::kTones, .tones = {tone}}), 1e4, 300);
  }
  const Scene all = WithDrive(AdapterScene(), {.kind = DriveKind::kTones, .tones = tones});
  EXPECT_ABS(Apart(Samples(all, 1e4, 300), sum), 0, 1e-12, "rounding of 300 products");
}

// x' = A x + b v with constant v, from rest, as one exponential
Eigen::VectorXd AfterStep(const LinearModel& model, double volt, double t_s) {
  const Eigen::Index n = model.states();
  if (t_s <= 0) return Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(n + 1, n + 1);
  g.topLeftCorner(n, n) = model.a;
  g.topRightCorner(n, 1) = volt * model.b;
  return MatrixExponential(t_s * g).topRightCorner(n, 1);
}

TEST(Excitation, APulseIsAStepLessALaterOne) {
  for (const double inductance_h : {130e-6, 0.0}) {
    Scene scene = WithDrive(AdapterScene(), Pulse(1.234e-3, 4.567e-3));
    scene.actuator.inductance_h = inductance_h;
    const LinearModel model = AssembleModel(scene);
    for (const double rate_hz : {317.0, 1e4}) {  // pieces end anywhere in a step, or two in one
      const Eigen::MatrixXd samples = Samples(scene, rate_hz, 10);
      const Eigen::VectorXd largest = samples.cwiseAbs().rowwise().maxCoeff();
      for (Eigen::Index i = 0; i < samples.cols(); ++i) {
        const double t_s = static_cast<double>(i) / rate_hz;
        const Eigen::VectorXd expected =
            AfterStep(model, 3, t_s - 1.234e-3) - AfterStep(model, 3, t_s - 1.234e-3 - 4.567e-3);
        const double worst = (samples.col(i) - expected)
                                 .cwiseAbs()
                                 .cwiseQuotient(largest.cwiseMax(1e-30))
                                 .maxCoeff();
        EXPECT_ABS(worst, 0, 1e-11, "rounding of times, R/L 2e5/s");
      }
    }
  }
}

TEST(Excitation, ABurstAgreesWithFiftyDigits) {
  const Scene scene = WithDrive(AdapterScene(), Burst(0.0031));
  PiecewiseMotion motion = Motion(scene, {}, 1000);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(7);
  std::vector<Eigen::VectorXd> states;
  while (motion.index() < 50) {
    motion.Next();
    largest = largest.cwiseMax(motion.Positions().cwiseAbs());
    if (motion.index() % 5 == 0) states.push_back(motion.Positions());
  }
  ASSERT_EQ(states.size(), std::size(tests::kBurstStates));
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Eigen::VectorXd expected = Eigen::Map<const Eigen::VectorXd>(tests::kBurstStates[k], 7);
    EXPECT_ABS((states[k] - expected).cwiseAbs().cwiseQuotient(largest).maxCoeff(), 0, 1e-12,
               "the bar for linear scenes");
  }
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-11, "sums of exact integrals");
}

TEST(Excitation, ALaterBurstIsTheSameLater) {
  const Eigen::MatrixXd early = Samples(WithDrive(AdapterScene(), Burst(0)), 1e4, 300);
  const Eigen::MatrixXd late = Samples(WithDrive(AdapterScene(), Burst(0.0123)), 1e4, 423);
  EXPECT_EQ(late.leftCols(123).cwiseAbs().maxCoeff(), 0);
  EXPECT_ABS(Apart(late.rightCols(300), early), 0, 1e-12, "rounding of times");
}

TEST(Excitation, TheRateOfOutputsDoesNotMatter) {
  for (const Drive& drive : {Burst(0.00123), Pulse(1.234e-3, 4.567e-3), Chirp(1e-8)}) {
    const Scene scene = WithDrive(AdapterScene(), drive);
    const Eigen::MatrixXd fine = Samples(scene, 9600, 241);
    const Eigen::MatrixXd coarse = Samples(scene, 600, 16);
    for (Eigen::Index i = 0; i < 16; ++i) {
      const Eigen::VectorXd largest = fine.cwiseAbs().rowwise().maxCoeff();
      EXPECT_ABS((fine.col(16 * i) - coarse.col(i)).cwiseAbs().cwiseQuotient(largest).maxCoeff(), 0,
                 1e-11, "rounding of products");
    }
  }
}

// v at any time out of the pieces
double VoltageAt(const Excitation& excitation, double t_s) {
  for (std::size_t k = 0; k < excitation.size(); ++k) {
    const ExcitationPiece piece = excitation.Piece(k);
    if (static_cast<long double>(t_s) >= piece.end_s) continue;
    Eigen::VectorXd w;
    FillSignals(piece, static_cast<long double>(t_s), w);
    return (ShapeOf(piece).rows * w)(kVoltage);
  }
  return 0;
}

TEST(Excitation, AChirpIsHeldWithinItsStatedError) {
  for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
    const Drive drive = Chirp(tolerance);
    const Excitation excitation(drive, {});
    EXPECT_LE(excitation.voltage_error_v(), tolerance * drive.amplitude_v * (1 + 1e-9));
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
      const double s = 0.03 * i / 400, t_s = drive.start_s + s;
      const double cycles = 50 * s + 350 * s * s / (2 * 0.03);
      worst = std::max(worst, std::abs(VoltageAt(excitation, t_s) - 2 * std::sin(kTwoPi * cycles)));
    }
    EXPECT_LE(worst, excitation.voltage_error_v() + 1e-12);
    EXPECT_GE(worst, 0.2 * excitation.voltage_error_v()) << "no waste";
  }
}

TEST(Excitation, AChirpConverges) {
  const Eigen::MatrixXd best = Samples(WithDrive(AdapterScene(), Chirp(1e-11)), 1e4, 400);
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    const Eigen::MatrixXd held = Samples(WithDrive(AdapterScene(), Chirp(tolerance)), 1e4, 400);
    EXPECT_LE(Apart(held, best), 10 * tolerance);
  }
}

Drive Sampled(double rate_hz, double (*voltage)(double), std::size_t count) {
  auto samples = std::make_shared<VoltageSamples>();
  samples->rate_hz = rate_hz;
  for (std::size_t k = 0; k < count; ++k) {
    samples->voltages_v.push_back(voltage(static_cast<double>(k) / rate_hz));
  }
  return {.kind = DriveKind::kSamples, .samples = samples};
}

TEST(Excitation, SamplesAreJoinedByLines) {
  const auto sine = [](double t_s) { return 5 * std::sin(kTwoPi * 225 * t_s); };
  const Eigen::MatrixXd exact = Samples(WithDrive(AdapterScene(), AdapterScene().drive), 1e4, 200);
  double before = 1;
  for (const double rate_hz : {1e4, 2e4, 44100.0, 1.6e5}) {
    const auto count = static_cast<std::size_t>(0.021 * rate_hz);
    const double apart =
        Apart(Samples(WithDrive(AdapterScene(), Sampled(rate_hz, sine, count)), 1e4, 200), exact);
    const double w_h = kTwoPi * 225 / rate_hz;
    EXPECT_LE(apart, w_h * w_h / 4) << "h^2/8 max|u''|, twice for the transients";
    EXPECT_LT(apart, before);
    before = apart;
  }
}

// what follows the last knot is no further interval
TEST(Excitation, IsItsOffsetBeforeAndAfterWhatItHolds) {
  Drive chirp = Chirp(1e-6);
  chirp.offset_v = 0.7;
  // from 1 ms to 31 ms, by more than 500 cubics
  const Excitation excitation(chirp, {});
  for (const double t_s : {0.0, 0.9999e-3, 0.031001, 0.03102, 1.0}) {
    EXPECT_EQ(VoltageAt(excitation, t_s), 0.7) << t_s;
  }
  EXPECT_GT(std::abs(VoltageAt(excitation, 0.0309) - 0.7), 0.1);
}

// parts that last for no time are no pieces, which a motion would have to step over
TEST(Excitation, HasNoPieceWithoutLength) {
  EXPECT_EQ(Excitation(Pulse(0, 0.1), {}).size(), 2U);
  EXPECT_EQ(Excitation(Pulse(0, 0), {}).size(), 1U);
  EXPECT_EQ(Excitation(Pulse(1e-3, 0), {}).size(), 2U);
  Drive burst = Burst(1e-3);
  EXPECT_EQ(Excitation(burst, {}).size(), 5U);
  burst.start_s = 0;
  EXPECT_EQ(Excitation(burst, {}).size(), 4U);
  burst.rise_s = 0;
  EXPECT_EQ(Excitation(burst, {}).size(), 3U);
  burst.fall_s = 0;
  EXPECT_EQ(Excitation(burst, {}).size(), 2U);
  burst.hold_s = 0;
  EXPECT_EQ(Excitation(burst, {}).size(), 1U);
}

TEST(Excitation, SamplesEndWithTheLastOne) {
  auto samples = std::make_shared<VoltageSamples>();
  samples->rate_hz = 1000;
  samples->voltages_v = {1, 3, -2};
  const Excitation excitation({.kind = DriveKind::kSamples, .samples = samples, .offset_v = 0.5},
                              {});
  EXPECT_EQ(excitation.size(), 3U);
  EXPECT_REL(VoltageAt(excitation, 0.25e-3), 0.5 + 1.5, 1e-14, "a quarter of the way from 1 to 3");
  EXPECT_REL(VoltageAt(excitation, 1.75e-3), 0.5 - 0.75, 1e-13, "three quarters from 3 to -2");
  for (const double t_s : {2.001e-3, 2.9e-3, 0.1}) EXPECT_EQ(VoltageAt(excitation, t_s), 0.5);
}

Scene Shaken(Scene scene) {
  scene.start = Start::kRest;
  scene.finger.tones = {{.amplitude = 30e-6, .frequency_hz = 9, .phase_rad = 0.4},
                        {.amplitude = 20e-6, .frequency_hz = 160}};
  return scene;
}

TEST(Finger, MovesTheSkinAsItsPhasorSays) {
  Scene scene = AdapterScene();
  scene.start = Start::kRest;
  scene.drive.amplitude_v = 0;
  scene.finger.tones = {{.amplitude = 40e-6, .frequency_hz = 100, .phase_rad = 0.7}};
  const Mode mode = SceneMode(scene);
  using Complex = std::complex<double>;
  const Complex jw(0, kTwoPi * 100);
  const Eigen::MatrixXcd m = jw * Eigen::MatrixXcd::Identity(7, 7) - mode.a;
  const Eigen::VectorXcd force =
      (mode.finger.col(0).cast<Complex>() + jw * mode.finger.col(1).cast<Complex>()) *
      std::polar(40e-6, 0.7);
  const Eigen::VectorXcd phasor = m.inverse() * force;
  // a second later all transients are gone; a whole number of periods
  const Eigen::MatrixXd samples = Samples(scene, 100, 101);
  const Eigen::VectorXd expected = phasor.imag();
  EXPECT_ABS((samples.col(100) - expected).cwiseAbs().cwiseQuotient(phasor.cwiseAbs()).maxCoeff(),
             0, 1e-11, "e^-41 and rounding");
}

// A finger that moves under a skin as stiff as a rod takes the contact with it.
TEST(Finger, TakesAStiffSkinWithIt) {
  Scene scene = Shaken(AdapterScene());
  scene.drive.amplitude_v = 0;
  scene.skin.stiffness_n_per_m = 1e8;
  scene.finger.tones = {{.amplitude = 30e-6, .frequency_hz = 9}};
  PiecewiseMotion motion = Motion(scene, {}, 1000);
  const Eigen::Index skin = AssembleModel(scene).skin();
  while (motion.index() < 100) motion.Next();
  EXPECT_ABS(motion.Positions()(skin), motion.Inputs()(kFinger), 2e-7, "start from rest, 9 Hz");
}

std::vector<PiecewiseEffects> SomeEffects() {
  const TravelStops rigid{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0};
  const TravelStops soft{.gap_up_m = 0.3e-3,
                         .gap_down_m = 0.25e-3,
                         .stiffness_n_per_m = 1e5,
                         .damping_n_s_per_m = 0.5};
  return {{},
          {.stops = rigid},
          {.stops = soft},
          {.contact_loss = ContactLoss{0.07}},
          {.stops = rigid, .contact_loss = ContactLoss{0.07}}};
}

std::vector<Scene> SomeScenes() {
  std::vector<Scene> scenes;
  for (Scene scene : {AdapterScene(), tests::DirectScene()}) {
    for (const double inductance_h : {130e-6, 0.0}) {
      scene.actuator.inductance_h = inductance_h;
      for (const Drive& drive :
           {AdapterScene().drive, Burst(0.00123), Pulse(1.2345e-3, 0.0123), Chirp(1e-6)}) {
        scenes.push_back(WithDrive(scene, drive));
        scenes.push_back(Shaken(scenes.back()));
        scenes.back().drive.source_resistance_ohm = 3;
        scenes.back().grip = {.stiffness_n_per_m = 300, .damping_n_s_per_m = 0.2};
      }
    }
  }
  return scenes;
}

TEST(Excitation, EnergyClosesWhateverHappens) {
  std::size_t events = 0, place = 0;
  for (const Scene& scene : SomeScenes()) {
    // one in eight where each takes ten times as long
    if (tests::kIsSanitized && place++ % 8 != 0) continue;
    for (const PiecewiseEffects& effects : SomeEffects()) {
      PiecewiseMotion motion = Motion(scene, effects, 1e4);
      while (motion.index() < 200 && !motion.stalled_at_s()) motion.Next();
      EXPECT_FALSE(motion.stalled_at_s().has_value());
      EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-11, "sums of exact integrals");
      for (const Guard& guard : motion.system().modes[motion.mode()].guards) {
        const double feed = guard.feed.size() > 0 ? guard.feed.dot(motion.Inputs()) : 0;
        EXPECT_GE(guard.row.dot(motion.x()) + feed + guard.offset, -1e-14);
      }
      events += motion.events().size();
    }
  }
  EXPECT_GT(events, tests::kIsSanitized ? 20U : 200U);
}

TEST(Excitation, EffectsThatAreNeverReachedLeaveNoTrace) {
  const PiecewiseEffects never{
      .stops = TravelStops{.gap_up_m = 1, .gap_down_m = 1, .restitution = 0.5},
      .contact_loss = ContactLoss{100}};
  std::size_t place = 0;
  for (const Scene& scene : SomeScenes()) {
    if (tests::kIsSanitized && place++ % 8 != 0) continue;
    for (const double rate_hz : {1e4, 317.0}) {
      EXPECT_EQ(Samples(scene, never, rate_hz, 60), Samples(scene, {}, rate_hz, 60));
    }
  }
}

TEST(Excitation, EventsDoNotDependOnTheRateOfOutputs) {
  for (const Drive& drive : {Burst(0.00123), Chirp(1e-6)}) {
    const Scene scene = Shaken(WithDrive(AdapterScene(), drive));
    std::vector<std::vector<Event>> runs;
    for (const double rate_hz : {1e4, 320.0}) {
      PiecewiseMotion motion = Motion(scene, {.contact_loss = ContactLoss{0.03}}, rate_hz);
      while (static_cast<double>(motion.index()) < 0.025 * rate_hz) motion.Next();
      runs.push_back(motion.events());
    }
    EXPECT_GT(runs[0].size(), 2U);
    ASSERT_EQ(runs[0].size(), runs[1].size());
    for (std::size_t k = 0; k < runs[0].size(); ++k) {
      EXPECT_ABS(runs[0][k].time_s, runs[1][k].time_s, 1e-12, "the bar for events");
    }
  }
}

TEST(Grip, StandsBesideTheSkinWithoutAnAdapter) {
  Scene held = tests::DirectScene();
  held.grip = {.stiffness_n_per_m = 500, .damping_n_s_per_m = 0.3};
  Scene stiffer = tests::DirectScene();
  stiffer.skin.stiffness_n_per_m += 500;
  stiffer.skin.damping_n_s_per_m += 0.3;
  const Eigen::MatrixXd difference = AssembleModel(held).a - AssembleModel(stiffer).a;
  EXPECT_ABS(difference.cwiseAbs().maxCoeff(), 0, 2e-9, "rounding of 4e6 1/s2");
}

TEST(SourceResistance, AddsToTheCoils) {
  Scene scene = AdapterScene();
  scene.drive.source_resistance_ohm = 5;
  Scene other = AdapterScene();
  other.actuator.resistance_ohm += 5;
  EXPECT_EQ(AssembleModel(scene).a, AssembleModel(other).a);
}

}  // namespace
}  // namespace haptometer::sim
