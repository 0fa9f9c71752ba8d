// The bounds in closed form where they have one: a mover whose case is held, its coil without
// inductance. It has two modes, p = -s +- j w, that a force excites by 1 / (2 m w) each.

#include "sim/effect_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kHuge = 1e30;
constexpr const char* kRoundedUp = "modes and amplitudes are each 1e-5 larger, for rounding";

// what a newton between mover and case, or a volt in the coil, moves at most
struct Reply {
  double travel_m = 0, current_a = 0;
};

class HeldMover {
 public:
  HeldMover() {
    scene_.actuator.inductance_h = 0;
    scene_.actuator.force_constant_n_per_a = 1e-6;  // nearly no feedback by the coil
    scene_.grip.holds = true;
    scene_.drive = {.amplitude_v = 0.5, .frequency_hz = 225};
    scene_.start = Start::kRest;
  }

  Scene& scene() { return scene_; }
  [[nodiscard]] double s() const {
    const Actuator& a = scene_.actuator;
    const double Km = a.force_constant_n_per_a;
    return (a.damping_n_s_per_m + Km * Km / a.resistance_ohm) / (2 * a.moving_mass_kg);
  }
  [[nodiscard]] double w0() const {
    return std::sqrt(scene_.actuator.stiffness_n_per_m / scene_.actuator.moving_mass_kg);
  }
  [[nodiscard]] double w() const { return std::sqrt(w0() * w0() - s() * s()); }

  // the integral of exp(-s t) |cos(w t + phase)| over whole half periods that hold the run: 2 / w
  // of the first, each further one exp(-pi s / w) of the one before
  [[nodiscard]] double LengthS() const {
    const double half_s = std::numbers::pi / w();
    double sum = 0;
    for (double begin_s = 0; begin_s < std::min(TimeS(), 40 / s()); begin_s += half_s) {
      sum += 2 / w() * std::exp(-s() * begin_s);
    }
    return std::min(sum, (1 - std::exp(-s() * TimeS())) / s());
  }

  // of a force: travel of both modes, and the current of their speeds |p| = w0
  [[nodiscard]] Reply ToForce() const {
    const double per_n = LengthS() / (scene_.actuator.moving_mass_kg * w());
    return {per_n, AmperePerSpeed() * w0() * per_n};
  }
  // of a voltage: the force Km v / R, and the current v / R itself
  [[nodiscard]] Reply ToVoltage() const {
    const Reply force = ToForce();
    return {AmperePerSpeed() * force.travel_m,
            1 / scene_.actuator.resistance_ohm + AmperePerSpeed() * force.current_a};
  }

 private:
  [[nodiscard]] double TimeS() const {
    const bool ends = scene_.duration_s && scene_.start == Start::kRest;
    return ends ? *scene_.duration_s : kInfinite;
  }
  [[nodiscard]] double AmperePerSpeed() const {
    return scene_.actuator.force_constant_n_per_a / scene_.actuator.resistance_ohm;
  }

  Scene scene_ = tests::ConeScene();
};

// a base of which the mover's peak and the current alone are small
SceneRun BaseOf(double peak_of_run_m, double peak_m, double current_rms_a, double power_w = kHuge) {
  SceneRun base;
  base.mover_peak_of_run_m = peak_of_run_m;
  base.mover_peak_m = peak_m;
  base.current_rms_a = current_rms_a;
  base.power_w = power_w;
  return base;
}

EffectSet With(Effect one, std::optional<Effect> other = {}) {
  EffectSet on;
  on.set(PlaceOf(one));
  if (other) on.set(PlaceOf(*other));
  return on;
}

double BoundOf(HeldMover& mover, const SceneRun& base, EffectSet on, Effect effect) {
  return BoundEffects(mover.scene(), on, base)[PlaceOf(effect)];
}
double SpringBound(HeldMover& mover, const SceneRun& base) {
  return BoundOf(mover, base, With(Effect::kStiffening), Effect::kStiffening);
}
double HeatBound(HeldMover& mover, const SceneRun& base) {
  return BoundOf(mover, base, With(Effect::kCoilHeating), Effect::kCoilHeating);
}

// a weak spring, K3 D^3 at the largest travel D: 10.5 half periods, a long run, and one without end
TEST(EffectBound, OfAWeakSpringIsItsForceTimesTheModesLengths) {
  HeldMover mover;
  mover.scene().effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 10};
  constexpr double kPeakOfRunM = 3e-4, kPeakM = 2e-4;
  const double half_s = std::numbers::pi / mover.w();
  for (const double halves : {0.4, 10.5, 300.0, 0.0}) {
    mover.scene().duration_s.reset();
    if (halves > 0) mover.scene().duration_s = halves * half_s;
    const double force_n = 10 * std::pow(kPeakOfRunM, 3);
    EXPECT_REL(SpringBound(mover, BaseOf(kPeakOfRunM, kPeakM, kHuge)),
               force_n * mover.ToForce().travel_m / kPeakM, 1e-4, kRoundedUp)
        << halves << " half periods";
  }
}

// a steady motion has no begin: its modes have their whole length
TEST(EffectBound, OfASteadyStartDoesNotEnd) {
  HeldMover mover;
  mover.scene().effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 10};
  mover.scene().start = Start::kSteady;
  mover.scene().duration_s = 0.01;
  EXPECT_REL(SpringBound(mover, BaseOf(3e-4, 3e-4, kHuge)),
             10 * 3e-4 * 3e-4 * mover.ToForce().travel_m, 1e-4, kRoundedUp);
}

// without ringing a mode's length is (1 - exp(-p T)) / p, and both count 1 / (m (p1 - p2))
TEST(EffectBound, OfAMoverThatDoesNotRing) {
  HeldMover mover;
  Actuator& actuator = mover.scene().actuator;
  actuator.damping_n_s_per_m = 8;
  mover.scene().effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 10};
  mover.scene().duration_s = 1e-3;
  const double s = mover.s(), root = std::sqrt(s * s - mover.w0() * mover.w0());
  const auto length_s = [](double p) { return (1 - std::exp(-p * 1e-3)) / p; };
  const double per_n =
      (length_s(s + root) + length_s(s - root)) / (2 * root * actuator.moving_mass_kg);
  EXPECT_REL(SpringBound(mover, BaseOf(3e-4, 3e-4, kHuge)), 10 * 3e-4 * 3e-4 * per_n, 1e-4,
             kRoundedUp);
}

// D = D0 + g K3 D^3; what the spring moves acts back on it by its slope 3 K3 D^2
TEST(EffectBound, OfAStrongSpringIsThatOfTheLargestTravelWithIt) {
  HeldMover mover;
  mover.scene().duration_s = 0.05;
  const double g = mover.ToForce().travel_m;
  for (const double gain : {0.1, 0.3, 0.6}) {
    const double D = 2e-4;
    const double K3 = gain / (3 * g * D * D);
    mover.scene().effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = K3};
    const double added_m = g * K3 * D * D * D;
    // of a reported peak of 4e-4 the bound takes off what the spring may change
    const double bound = added_m / (1 - gain) / (4e-4 - added_m);
    EXPECT_REL(SpringBound(mover, BaseOf(D - added_m, 4e-4, kHuge)), bound, 1e-3,
               "1e-5 over 1 - gain, some times");
  }
}

// D - g K3 D^3 is 2/3 D at most, at 3 g K3 D^2 = 1: beyond that no travel bounds itself
TEST(EffectBound, EndsWhereASpringLiftsAnyTravel) {
  HeldMover mover;
  mover.scene().duration_s = 0.05;
  mover.scene().effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 1e7};
  const double most_m = 2 / (3 * std::sqrt(3 * mover.ToForce().travel_m * 1e7));
  EXPECT_TRUE(std::isfinite(SpringBound(mover, BaseOf(0.995 * most_m, 1, kHuge))));
  EXPECT_TRUE(std::isinf(SpringBound(mover, BaseOf(1.005 * most_m, 1, kHuge))));
  // a number that all effects together may bring to 0 has no relative bound
  const double weak_m = 0.1 * most_m;
  const double change_m = mover.ToForce().travel_m * 1e7 * std::pow(weak_m, 3);
  EXPECT_TRUE(std::isfinite(SpringBound(mover, BaseOf(weak_m, 1.02 * change_m, kHuge))));
  EXPECT_TRUE(std::isinf(SpringBound(mover, BaseOf(weak_m, 0.98 * change_m, kHuge))));
}

// each gap by itself, within 1e-3
TEST(EffectBound, EndsWhereEitherStopMayBeReached) {
  HeldMover mover;
  Scene& scene = mover.scene();
  scene.duration_s = 0.05;
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 10};
  const auto bound = [&](double gap_up_m, double gap_down_m) {
    scene.effects.travel_stops = TravelStops{.gap_up_m = gap_up_m, .gap_down_m = gap_down_m};
    return BoundOf(mover, BaseOf(2e-4, 2e-4, kHuge),
                   With(Effect::kStiffening, Effect::kTravelStops), Effect::kStiffening);
  };
  EXPECT_TRUE(std::isfinite(bound(2.002e-4, 2.002e-4)));
  EXPECT_TRUE(std::isinf(bound(1.998e-4, 1)));
  EXPECT_TRUE(std::isinf(bound(1, 1.998e-4)));
}

// a coil that adds a = h / (1 - h) of its resistance, h = alpha R I^2 min(Rth, T / C): I = I0 + a
// I, and a change of the current acts back on it by 4 a
TEST(EffectBound, OfAHotCoilIsWhatItsResistanceTakesFromTheCurrent) {
  HeldMover mover;
  Scene& scene = mover.scene();
  const double R = scene.actuator.resistance_ohm, alpha = 4e-3;
  struct Case {
    double thermal_resistance_k_per_w, heat_capacity_j_per_k, h;
    bool is_steady;
  };
  for (const Case& of : {Case{20, 1e-3, 0.05, false}, Case{1e3, 5e-3, 0.05, false},
                         Case{20, 1e3, 0.02, true}, Case{20, 1e-3, 0.12, false}}) {
    scene.duration_s = 0.1;
    scene.start = of.is_steady ? Start::kSteady : Start::kRest;
    scene.effects.coil_heating =
        CoilHeating{of.heat_capacity_j_per_k, of.thermal_resistance_k_per_w, alpha};
    // from cold no more than 0.1 s of heat
    const double k_per_w =
        of.is_steady ? of.thermal_resistance_k_per_w
                     : std::min(of.thermal_resistance_k_per_w, 0.1 / of.heat_capacity_j_per_k);
    const double I = std::sqrt(of.h / (alpha * R * k_per_w)), a = of.h / (1 - of.h);
    scene.drive.amplitude_v = I * (1 - a) * R;
    const double rms_a = 3 * I;
    EXPECT_REL(HeatBound(mover, BaseOf(1e3, kHuge, rms_a)), a * I / (1 - 4 * a) / (rms_a - a * I),
               3e-4, "1e-5 over 1 - 4 a, some times")
        << of.h;
  }
}

// A steady motion's current is that of its phasor, without what would decay from rest. The voltage
// that the resistance takes acts on it by b = 1/R and by the mover's speed: I = I0 + a R b I.
TEST(EffectBound, OfASteadyCurrentHasNoTransient) {
  HeldMover mover;
  Scene& scene = mover.scene();
  scene.actuator.force_constant_n_per_a = 0.3;
  scene.start = Start::kSteady;
  scene.drive.offset_v = -0.2;
  const double R = scene.actuator.resistance_ohm, alpha = 4e-3, h = 0.01, a = h / (1 - h);
  const double gain = a * R * mover.ToVoltage().current_a;
  const double I = (std::abs(SolveSteadyState(scene).current_a) + 0.2 / R) / (1 - gain);
  scene.effects.coil_heating = CoilHeating{.heat_capacity_j_per_k = 1,
                                           .thermal_resistance_k_per_w = h / (alpha * R * I * I),
                                           .resistance_per_k = alpha};
  EXPECT_REL(HeatBound(mover, BaseOf(1e3, kHuge, 3 * I)), gain / (1 - 4 * gain) / (3 - gain), 1e-3,
             "1e-5 over one less the gain, some times");
}

// without a voltage the current is what the start's place and speed induce
TEST(EffectBound, OfAStartIsThatOfTheCurrentThatItInduces) {
  HeldMover mover;
  Scene& scene = mover.scene();
  scene.actuator.force_constant_n_per_a = 0.3;
  scene.duration_s = 0.03;
  scene.drive.amplitude_v = 0;
  scene.initial = {.mover_m = 2e-4, .mover_m_per_s = 0.1};
  const double R = scene.actuator.resistance_ohm, alpha = 4e-3, h = 0.01, a = h / (1 - h);
  // each mode by |v - p x| / (2 w), whose speed |p| = w0 induces Km / R of it
  const double modes_m =
      std::abs(0.1 + std::complex<double>(mover.s(), mover.w()) * 2e-4) / mover.w();
  const double gain = a * R * mover.ToVoltage().current_a;
  const double I = 0.3 / R * mover.w0() * modes_m / (1 - gain);
  scene.effects.coil_heating = CoilHeating{.heat_capacity_j_per_k = 1e-9,
                                           .thermal_resistance_k_per_w = h / (alpha * R * I * I),
                                           .resistance_per_k = alpha};
  EXPECT_REL(HeatBound(mover, BaseOf(1e3, kHuge, 3 * I)), gain / (1 - 4 * gain) / (3 - gain), 1e-3,
             "1e-5 over one less the gain, some times");
}

// where h comes to a fifth the resistance's feedback, 4 h / (1 - h), comes to 1
TEST(EffectBound, EndsWhereACoilHeatsByAFifth) {
  HeldMover mover;
  Scene& scene = mover.scene();
  scene.effects.coil_heating =
      CoilHeating{.heat_capacity_j_per_k = 1, .thermal_resistance_k_per_w = 20};
  const double R = scene.actuator.resistance_ohm;
  const auto bound = [&](double h) {
    const double I = std::sqrt(h / (CoilHeating::kCopperPerK * R * 20));
    scene.drive.amplitude_v = I * (1 - h / (1 - h)) * R;
    return HeatBound(mover, BaseOf(1e3, kHuge, 1));
  };
  EXPECT_TRUE(std::isfinite(bound(0.1985)));
  EXPECT_TRUE(std::isinf(bound(0.2015)));
}

// the power of the source changes by |v| times what the current does
TEST(EffectBound, OfThePowerIsTheVoltageTimesTheCurrents) {
  HeldMover mover;
  Scene& scene = mover.scene();
  const double R = scene.actuator.resistance_ohm, h = 0.01, a = h / (1 - h);
  scene.effects.coil_heating = CoilHeating{
      .heat_capacity_j_per_k = 1, .thermal_resistance_k_per_w = 20, .resistance_per_k = 4e-3};
  const double I = std::sqrt(h / (4e-3 * R * 20));
  scene.drive.amplitude_v = I * (1 - a) * R;
  const double all_w = scene.drive.amplitude_v * a * I;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_REL(HeatBound(mover, BaseOf(1e3, kHuge, kHuge, sign * 7 * all_w)),
               all_w / (1 - 4 * a) / (6 * all_w), 1e-4, kRoundedUp);
  }
}

// the largest current of a base: the steady one and what decays of the start, or what the
// largest voltage can drive
double LargestCurrentOf(HeldMover& mover) {
  const Scene& scene = mover.scene();
  Scene steadily = scene;
  const SteadyState steady = SolveSteadyState(steadily);
  const std::complex<double> mover_m = steady.phasors(0);
  const std::complex<double> s(0, 2 * std::numbers::pi * scene.drive.frequency_hz);
  const double x = mover_m.imag(), v = (s * mover_m).imag();
  // x(0) and v(0) excite each mode by |v - p x| / (2 w), whose speeds drive the current
  const double mode_m =
      std::abs(v + std::complex<double>(mover.s(), mover.w()) * x) / (2 * mover.w());
  const double per_speed = scene.actuator.force_constant_n_per_a / scene.actuator.resistance_ohm;
  return std::min(std::abs(steady.current_a) + 2 * per_speed * mover.w0() * mode_m,
                  mover.ToVoltage().current_a * scene.drive.amplitude_v);
}

// Spring and coil together: what one changes acts back through both, by the inverse of one less
// their gains, here solved for travel and current by elimination.
TEST(EffectBound, OfTwoEffectsActsBackThroughBoth) {
  HeldMover mover;
  Scene& scene = mover.scene();
  scene.actuator.force_constant_n_per_a = 0.6;
  scene.duration_s = 0.03;
  const double R = scene.actuator.resistance_ohm;
  const Reply by_n = mover.ToForce(), by_v = mover.ToVoltage();
  scene.drive.amplitude_v = 0.7;
  const double I0 = LargestCurrentOf(mover), D0 = 2e-4;
  const double K3 = 0.25 / (3 * by_n.travel_m * D0 * D0);
  const double k_per_w = 0.03 / (4e-3 * R * by_v.current_a * R * I0 * I0);
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = K3};
  scene.effects.coil_heating = CoilHeating{.heat_capacity_j_per_k = 1e-9,
                                           .thermal_resistance_k_per_w = k_per_w,
                                           .resistance_per_k = 4e-3};
  double D = D0, I = I0, added_ohm = 0;
  for (int k = 0; k < 500; ++k) {
    const double h = 4e-3 * R * I * I * k_per_w;
    added_ohm = R * h / (1 - h);
    const double force_n = K3 * D * D * D, volt = added_ohm * I;
    D = D0 + by_n.travel_m * force_n + by_v.travel_m * volt;
    I = I0 + by_n.current_a * force_n + by_v.current_a * volt;
  }
  const double slope_n_per_m = 3 * K3 * D * D, slope_ohm = 4 * added_ohm;
  const double own_m = by_n.travel_m * K3 * D * D * D, own_a = by_n.current_a * K3 * D * D * D;
  // m = own_m + g_tt m + g_tc a,  a = own_a + g_ct m + g_cc a, by repeated substitution
  double m = own_m, a = own_a;
  for (int k = 0; k < 2000; ++k) {
    const double before_m = m;
    m = own_m + by_n.travel_m * slope_n_per_m * before_m + by_v.travel_m * slope_ohm * a;
    a = own_a + by_n.current_a * slope_n_per_m * before_m + by_v.current_a * slope_ohm * a;
  }
  const EffectSet both = With(Effect::kStiffening, Effect::kCoilHeating);
  EXPECT_REL(BoundOf(mover, BaseOf(D0, 1, kHuge), both, Effect::kStiffening), m / (1 - (D - D0)),
             1e-3, "1e-5 over one less the gain, some times");
  EXPECT_REL(BoundOf(mover, BaseOf(D0, kHuge, 5), both, Effect::kStiffening), a / (5 - (I - I0)),
             1e-3, "1e-5 over one less the gain, some times");
}

// a finger's steady motion is superposed: its amplitudes at skin, case, mover and coil
TEST(EffectBound, OfAToneOfTremorIsItsAmplitudes) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = 0;  // an effect of its own
  scene.finger.tones = {{.amplitude = 2e-6, .frequency_hz = 30}};
  Scene still = scene;
  still.drive = {.amplitude_v = 0, .frequency_hz = 1};
  const SteadyTones tone = Superpose(still);
  const double root = std::numbers::sqrt2;
  const auto bound = [&](const SceneRun& base) {
    return BoundEffects(scene, With(Effect::kTremor), base)[PlaceOf(Effect::kTremor)];
  };
  SceneRun base = BaseOf(1e-4, kHuge, kHuge);
  base.skin_rms_m = base.case_rms_m = kHuge;
  const auto part = [](double change, double value) { return change / (value - change); };
  SceneRun one = base;
  one.skin_rms_m = 5e-6;
  EXPECT_REL(bound(one), part(root * tone.skin_rms_m, 5e-6), 1e-10, "sqrt(2) of one tone's RMS");
  one = base;
  one.case_rms_m = 7e-6;
  EXPECT_REL(bound(one), part(root * tone.case_rms_m, 7e-6), 1e-10, "sqrt(2) of one tone's RMS");
  one = base;
  one.mover_peak_m = 9e-6;
  EXPECT_REL(bound(one), part(tone.mover_peak_m, 9e-6), 1e-10, "its peak");
  one = base;
  one.current_rms_a = 0.1;
  EXPECT_REL(bound(one), part(root * tone.current_rms_a, 0.1), 1e-10, "sqrt(2) of one tone's RMS");
}

// A bare finger that shakes an adapter, and the modes of its scene as Eigen has them.
class ShakenAdapter {
 public:
  explicit ShakenAdapter(std::vector<Tone> tones) {
    scene_.actuator.inductance_h = 0;  // an effect of its own
    scene_.finger.tones = std::move(tones);
    Scene still = scene_;
    still.drive = {.amplitude_v = 0, .frequency_hz = 1};
    tremor_ = Superpose(still);
    model_ = AssembleModel(scene_);
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(model_.a);
    poles_ = solver.eigenvalues();
    modes_ = solver.eigenvectors();
    parts_ = modes_.inverse();
  }

  Scene& scene() { return scene_; }
  [[nodiscard]] const SteadyTones& tremor() const { return tremor_; }
  [[nodiscard]] const LinearModel& model() const { return model_; }
  [[nodiscard]] Eigen::RowVectorXd SkinForce() const {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(model_.states());
    row(model_.skin()) = scene_.skin.stiffness_n_per_m;
    row(model_.skin_velocity()) = scene_.skin.damping_n_s_per_m;
    return row;
  }

  // the sum over the modes of what x excites of each and what of it the row shows
  [[nodiscard]] double Decaying(const Eigen::RowVectorXd& row, const Eigen::VectorXd& x) const {
    return Shown(row, x).sum();
  }
  // the same of an input without end: the integral of exp(-s t) |cos(w t)| from a peak on
  [[nodiscard]] double Driven(const Eigen::RowVectorXd& row, const Eigen::VectorXd& x) const {
    const Eigen::VectorXd shown = Shown(row, x);
    double sum = 0;
    for (Eigen::Index k = 0; k < shown.size(); ++k) {
      const double s = -poles_(k).real(), w = std::abs(poles_(k).imag());
      const double ringing_s =
          w > 0 ? 2 / w / (1 - std::exp(-s * std::numbers::pi / w)) : kInfinite;
      sum += shown(k) * std::min(1 / s, ringing_s);
    }
    return sum;
  }

  [[nodiscard]] double FingerSpeed() const {
    double m_per_s = 0;
    for (const Tone& tone : scene_.finger.tones) {
      m_per_s += 2 * std::numbers::pi * tone.frequency_hz * tone.amplitude;
    }
    return m_per_s;
  }

 private:
  [[nodiscard]] Eigen::VectorXd Shown(const Eigen::RowVectorXd& row,
                                      const Eigen::VectorXd& x) const {
    const Eigen::VectorXcd seen = (row.cast<std::complex<double>>() * modes_).transpose();
    const Eigen::VectorXcd excited = parts_ * x.cast<std::complex<double>>();
    return seen.cwiseAbs().cwiseProduct(excited.cwiseAbs());
  }

  Scene scene_ = tests::AdapterScene();
  SteadyTones tremor_;
  LinearModel model_;
  Eigen::VectorXcd poles_;
  Eigen::MatrixXcd modes_, parts_;
};

// a base of which no number is small
SceneRun LargeBase() {
  SceneRun base = BaseOf(1e-4, kHuge, kHuge);
  base.skin_rms_m = base.case_rms_m = kHuge;
  return base;
}

// of the source |v| di; of the finger, at its largest speed, what its tremor's force is and what
// the drive's can be
TEST(EffectBound, OfATremorsPowerIsThatOfSourceAndFinger) {
  for (const std::vector<Tone>& tones :
       {std::vector<Tone>{{2e-6, 30, 0}}, std::vector<Tone>{{2e-6, 30, 0}, {1e-6, 80, 1}}}) {
    ShakenAdapter shaken(tones);
    const SteadyTones& tremor = shaken.tremor();
    const double largest_over_rms = std::sqrt(2 * static_cast<double>(tones.size()));
    const double source_w = 5 * largest_over_rms * tremor.current_rms_a;
    const double shaking_w = shaken.FingerSpeed() * tremor.skin_force_peak_n;
    const double driven_w =
        shaken.FingerSpeed() * 5 * shaken.Driven(shaken.SkinForce(), shaken.model().b);
    const double all_w = source_w + shaking_w + driven_w;
    EXPECT_GT(driven_w, 0.1 * all_w) << "it counts";
    SceneRun base = LargeBase();
    base.power_w = -7 * all_w;
    EXPECT_REL(BoundEffects(shaken.scene(), With(Effect::kTremor), base)[PlaceOf(Effect::kTremor)],
               1.0 / 6, 1e-4, kRoundedUp);
  }
}

// a spring beside a finger that moves: it takes its own force from the finger, not the drive's
TEST(EffectBound, OfASpringsPowerIsThatOfItsForceOnAFingerThatMoves) {
  ShakenAdapter shaken({{2e-6, 300, 0}});
  Scene& scene = shaken.scene();
  scene.effects.stiffening = StiffeningSpring{.cubic_n_per_m3 = 10};
  Eigen::VectorXd push = Eigen::VectorXd::Zero(shaken.model().states());
  push(LinearModel::kMoverVelocity) = -1 / scene.actuator.moving_mass_kg;
  push(LinearModel::kCaseVelocity) =
      1 / (scene.actuator.case_mass_kg + scene.adapter->motor_side_mass_kg);
  const double force_n = 10 * std::pow(1e-4 + shaken.tremor().mover_peak_m, 3);
  const double source_w = 5 * force_n * shaken.Driven(shaken.model().current_row, push);
  const double finger_w = shaken.FingerSpeed() * force_n * shaken.Driven(shaken.SkinForce(), push);
  EXPECT_GT(finger_w, 1e-3 * source_w) << "more than the tolerance";
  SceneRun base = LargeBase();
  base.power_w = 1e6;
  const EffectSet both = With(Effect::kStiffening, Effect::kTremor);
  EXPECT_REL(BoundEffects(scene, both, base)[PlaceOf(Effect::kStiffening)],
             (source_w + finger_w) / 1e6, 1e-4, "1e-5 of the modes, three times that of a travel");
}

// the amplitudes of n tones add up to sqrt(2 n) of their RMS together, and from rest their begin
// decays beside them
TEST(EffectBound, OfSomeTonesOfTremorIsTheirSumAndItsTransient) {
  ShakenAdapter shaken({{2e-6, 30, 0.3}, {1e-6, 80, 1}, {5e-7, 200, 2}});
  const SteadyTones& tremor = shaken.tremor();
  const Eigen::Index n = shaken.model().states();
  const Eigen::RowVectorXd skin = Eigen::RowVectorXd::Unit(n, shaken.model().skin());
  const Eigen::RowVectorXd motor = Eigen::RowVectorXd::Unit(n, LinearModel::kCase);
  const Eigen::RowVectorXd travel = Eigen::RowVectorXd::Unit(n, LinearModel::kMover) - motor;
  for (const bool ends : {false, true}) {
    if (ends) {
      shaken.scene().duration_s = 0.05;
      shaken.scene().start = Start::kRest;
    }
    // what the number with this value is bounded by, over the value less itself
    const auto expect = [&](double SceneRun::* number, double steady, double decaying) {
      const double change = steady + (ends ? decaying : 0);
      SceneRun base = LargeBase();
      base.*number = 3 * change;
      const EffectBounds bounds = BoundEffects(shaken.scene(), With(Effect::kTremor), base);
      EXPECT_REL(bounds[PlaceOf(Effect::kTremor)], 0.5, 1e-4, kRoundedUp);
    };
    const double factor = std::sqrt(6.0);
    expect(&SceneRun::skin_rms_m, factor * tremor.skin_rms_m, shaken.Decaying(skin, tremor.start));
    expect(&SceneRun::case_rms_m, factor * tremor.case_rms_m, shaken.Decaying(motor, tremor.start));
    expect(&SceneRun::mover_peak_m, tremor.mover_peak_m, shaken.Decaying(travel, tremor.start));
    expect(&SceneRun::current_rms_a, factor * tremor.current_rms_a,
           shaken.Decaying(shaken.model().current_row, tremor.start));
  }
}

// the skin's least force, less what tremor and transients take from it, is the end of contact
TEST(EffectBound, EndsWhereTremorMayLiftTheSkin) {
  ShakenAdapter shaken({{2e-6, 30, 0.3}});
  Scene& scene = shaken.scene();
  const Eigen::RowVectorXd force = shaken.SkinForce();
  SceneRun base = LargeBase();
  base.skin_force_least_n = -0.1;
  for (const bool ends : {false, true}) {
    if (ends) {
      scene.duration_s = 0.05;
      scene.start = Start::kRest;
    }
    // a run from rest has the tremor's transient, the way to a steady motion the drive's
    Scene driven = scene;
    driven.finger.tones.clear();
    const Eigen::VectorXd begin =
        ends ? shaken.tremor().start : Eigen::VectorXd(SolveSteadyState(driven).phasors.imag());
    const double lifted_n = 0.1 + shaken.tremor().skin_force_peak_n + shaken.Decaying(force, begin);
    const auto bound = [&](double preload_n) {
      scene.effects.contact_loss = ContactLoss{preload_n};
      const EffectSet on = With(Effect::kTremor, Effect::kContactLoss);
      return BoundEffects(scene, on, base)[PlaceOf(Effect::kTremor)];
    };
    EXPECT_TRUE(std::isfinite(bound(1.001 * lifted_n))) << ends;
    EXPECT_TRUE(std::isinf(bound(0.999 * lifted_n))) << ends;
  }
}

// without an end the way from rest to the steady motion is of the motion too
TEST(EffectBound, EndsWhereTheWayToTheSteadyMotionMayReachAStop) {
  ShakenAdapter shaken({{2e-6, 30, 0.3}});
  Scene& scene = shaken.scene();
  Scene driven = scene;
  driven.finger.tones.clear();
  const Eigen::Index n = shaken.model().states();
  const Eigen::RowVectorXd travel = Eigen::RowVectorXd::Unit(n, LinearModel::kMover) -
                                    Eigen::RowVectorXd::Unit(n, LinearModel::kCase);
  const double most_m = 1e-4 + shaken.tremor().mover_peak_m +
                        shaken.Decaying(travel, SolveSteadyState(driven).phasors.imag());
  const auto bound = [&](double gap_m) {
    scene.effects.travel_stops = TravelStops{.gap_up_m = gap_m, .gap_down_m = gap_m};
    const EffectSet on = With(Effect::kTremor, Effect::kTravelStops);
    return BoundEffects(scene, on, LargeBase())[PlaceOf(Effect::kTremor)];
  };
  EXPECT_TRUE(std::isfinite(bound(1.001 * most_m)));
  EXPECT_TRUE(std::isinf(bound(0.999 * most_m)));
}

}  // namespace
}  // namespace haptometer::sim
