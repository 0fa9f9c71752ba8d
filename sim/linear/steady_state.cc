#include "sim/linear/steady_state.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"
#include "sim/linear/complex_equations.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/scene_mode.h"
#include "sim/linear/time_response.h"
#include "sim/scene_run.h"

namespace haptometer::sim {
namespace {

using Complex = std::complex<double>;

// (j w I - A) X = b V in balanced units
struct PhasorSystem {
  double omega_rad_per_s = 0;
  Eigen::MatrixXd a;      // (n, n)
  Eigen::VectorXd right;  // (n): b V
  // the rounding errors of all three (linear_model.h), or empty
  Eigen::MatrixXd a_rest{};
  Eigen::VectorXd right_rest{};
  double omega_rest_rad_per_s = 0;

  [[nodiscard]] bool HasRests() const { return right_rest.size() > 0; }
};

PhasorSystem SystemOf(const LinearModel& model, const BalancedMatrix& balanced,
                      const SineDrive& drive) {
  const Eigen::Index n = model.states();
  // rows are divided and columns multiplied by the scale: states in balanced units
  PhasorSystem system{.omega_rad_per_s = 2 * std::numbers::pi * drive.frequency_hz,
                      .a = balanced.matrix,
                      .right = drive.amplitude_v * model.b.cwiseQuotient(balanced.scale)};
  if (model.a_rest.size() == 0) return system;
  system.a_rest =
      balanced.scale.cwiseInverse().asDiagonal() * model.a_rest * balanced.scale.asDiagonal();
  system.right_rest = drive.amplitude_v * model.b_rest.cwiseQuotient(balanced.scale);
  // fma gives the rounding error of the product with the amplitude
  for (Eigen::Index k = 0; k < n; ++k) {
    system.right_rest(k) +=
        std::fma(drive.amplitude_v, model.b(k) / balanced.scale(k), -system.right(k));
  }
  // beside a sharp resonance an ulp of w is seen as well as one of the stiffness
  system.omega_rest_rad_per_s = static_cast<double>(
      2 * std::numbers::pi_v<long double> * static_cast<long double>(drive.frequency_hz) -
      static_cast<long double>(system.omega_rad_per_s));
  return system;
}

// M = j w I - A
Eigen::MatrixXcd MatrixOf(const PhasorSystem& system) {
  Eigen::MatrixXcd matrix = -system.a.cast<Complex>();
  matrix.diagonal().array() += Complex(0, system.omega_rad_per_s);
  return matrix;
}

// b V - j w X + A X in 64 bits of mantissa, so that the refinement has digits to correct
Eigen::VectorXcd Residual(const PhasorSystem& system, const Eigen::VectorXcd& x) {
  const auto wide = [](double value) { return static_cast<long double>(value); };
  const long double w = wide(system.omega_rad_per_s) + wide(system.omega_rest_rad_per_s);
  Eigen::VectorXcd residual(x.size());
  for (Eigen::Index row = 0; row < x.size(); ++row) {
    long double re = wide(system.right(row)) + w * wide(x(row).imag());
    long double im = -w * wide(x(row).real());
    if (system.HasRests()) re += wide(system.right_rest(row));
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      long double a = wide(system.a(row, k));
      if (system.HasRests()) a += wide(system.a_rest(row, k));
      re += a * wide(x(k).real());
      im += a * wide(x(k).imag());
    }
    residual(row) = Complex(static_cast<double>(re), static_cast<double>(im));
  }
  return residual;
}

// |M|
Eigen::MatrixXd TermsOf(const PhasorSystem& system) {
  Eigen::MatrixXd terms = system.a.cwiseAbs();
  for (double& own : terms.diagonal()) own = Hypot(own, system.omega_rad_per_s);
  return terms;
}

// |residual| + eps (|M| |x| + |b V|): how far each equation may be off
Eigen::VectorXd EquationBound(const PhasorSystem& system, const Eigen::MatrixXd& terms,
                              const Eigen::VectorXcd& x, const Eigen::VectorXcd& x_rest) {
  double eps = std::numeric_limits<double>::epsilon();
  Eigen::VectorXcd residual = Residual(system, x);
  if (system.HasRests()) {
    // the numbers are good to long double: half an ulp each of at most six operations for an entry,
    // of its product and of nine sums
    constexpr double kLongUlps = 8;
    eps = kLongUlps * static_cast<double>(std::numeric_limits<long double>::epsilon());
    // what rounding x to double leaves over is no error of the equations, but of the sums of x
    residual -= MatrixOf(system) * x_rest;
  }
  return Magnitudes(residual) + eps * (terms * Magnitudes(x) + system.right.cwiseAbs());
}

// of a bound, what its second order may come to before it counts
constexpr double kNegligible = 1e-3;

// 1 / (1 - |G|), G = I - C M, by which |M^-1| b exceeds that of the computed inverse C; infinite
// where C is none. Rounding replaces a pivot that is below eps of what it is the difference of (the
// inertia of bodies that nothing holds, beside their springs, at microhertz), and a small residual
// does not show it.
double InverseFactor(const PhasorSystem& system, const Eigen::MatrixXd& terms,
                     const ComplexEquations& equations, const Eigen::MatrixXd& inverse_parts,
                     const Eigen::VectorXd& bound) {
  const Eigen::Index n = bound.size();
  const Eigen::VectorXd states =
      (inverse_parts.leftCols(n).cwiseAbs() + inverse_parts.rightCols(n).cwiseAbs())
          .lazyProduct(bound);
  // |M G M^-1| b is some eps |M| |C| b
  constexpr double kUlps = 8 * std::numeric_limits<double>::epsilon();
  if (((kUlps * terms.lazyProduct(states)).array() <= kNegligible * bound.array()).all()) return 1;
  // G y = C (b - M y) of y = C b
  PhasorSystem probe = system;
  probe.right = bound;
  probe.right_rest.setZero();
  const Eigen::VectorXcd y = equations.Solve(bound.cast<Complex>());
  const Eigen::VectorXd left = Magnitudes(equations.Solve(Residual(probe, y)));
  const double share =
      (left.array() == 0).select(0, left.cwiseQuotient(states)).maxCoeff<Eigen::PropagateNaN>();
  return share < 0.5 ? 1 / (1 - share) : HUGE_VAL;
}

// Sums of phasors, rows X + fixed, and bounds of their errors.
struct PhasorSums {
  Eigen::VectorXd values;  // magnitudes
  Eigen::VectorXd errors;

  [[nodiscard]] double Relative(Eigen::Index k) const {
    return errors(k) == 0 ? 0 : errors(k) / values(k);
  }
  // of the sum of squares of the last `count`, which have one sign: d(v^2) = 2 v dv
  [[nodiscard]] double RelativeOfSquares(Eigen::Index count) const {
    const double error = 2 * values.tail(count).dot(errors.tail(count));
    return error == 0 ? 0 : error / values.tail(count).squaredNorm();
  }
};

// |rows D M^-1| times the equations' bounds, and the rounding of the sums
PhasorSums SumsOf(const Eigen::MatrixXd& rows, const Eigen::VectorXd& fixed,
                  const Eigen::VectorXcd& phasors, const Eigen::MatrixXd& balanced_inverse,
                  const Eigen::VectorXd& equation_bound, const Eigen::VectorXd& term_ulps) {
  constexpr double kEps = std::numeric_limits<double>::epsilon();
  constexpr double kUlps = 8;  // of what becomes of the sum itself
  const Eigen::Index n = phasors.size();
  Eigen::VectorXcd sums = fixed.cast<Complex>();
  sums.real() += rows * phasors.real();
  sums.imag() += rows * phasors.imag();
  const Eigen::VectorXd terms = rows.cwiseAbs() * Magnitudes(phasors) + fixed.cwiseAbs();
  const Eigen::MatrixXd parts = rows * balanced_inverse;
  const Eigen::MatrixXd from =
      (parts.leftCols(n).cwiseAbs2() + parts.rightCols(n).cwiseAbs2()).cwiseSqrt();
  PhasorSums found{.values = Magnitudes(sums), .errors = from * equation_bound};
  found.errors += kEps * (terms.cwiseProduct(term_ulps) + kUlps * found.values);
  return found;
}

// The largest relative error of skin, case, travel, current and power.
double LargestError(const LinearModel& model, const SineDrive& drive,
                    const Eigen::VectorXcd& phasors, const Eigen::MatrixXd& balanced_inverse,
                    const Eigen::VectorXd& equation_bound) {
  const Eigen::Index n = model.states(), powers = model.power_rows.rows();
  enum { kSkin, kCase, kTravel, kCurrent, kPower };
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kPower + powers, n);
  Eigen::VectorXd fixed = Eigen::VectorXd::Zero(kPower + powers);
  rows(kSkin, model.skin()) = 1;
  rows(kCase, LinearModel::kCase) = 1;
  rows(kTravel, LinearModel::kMover) = 1;
  rows(kTravel, LinearModel::kCase) = -1;
  rows.row(kCurrent) = model.current_row;
  rows.bottomRows(powers) = model.power_rows.leftCols(n);
  fixed(kCurrent) = model.current_per_volt * drive.amplitude_v;
  fixed.tail(powers) = model.power_rows.col(n) * drive.amplitude_v;
  // constants of currents are rounded, and their products; without rests the equations' bounds,
  // which then are eps of all terms, hold that
  Eigen::VectorXd term_ulps = Eigen::VectorXd::Ones(kPower + powers);
  if (model.a_rest.size() > 0) term_ulps.tail(powers + 1).setConstant(3);
  const PhasorSums sums = SumsOf(rows, fixed, phasors, balanced_inverse, equation_bound, term_ulps);
  return std::max({sums.Relative(kSkin), sums.Relative(kCase), sums.Relative(kTravel),
                   sums.Relative(kCurrent), sums.RelativeOfSquares(powers)});
}

// e / (1 - e): the error relative to the true number, by that relative to the computed one
double OfTrue(double error) {
  if (error < kNegligible) return error;
  return error < 1 ? error / (1 - error) : HUGE_VAL;
}

// [X, V], on which the rows of the power act
Eigen::VectorXcd WithVoltage(const Eigen::VectorXcd& phasors, const SineDrive& drive) {
  Eigen::VectorXcd with(phasors.size() + 1);
  with << phasors, drive.amplitude_v;
  return with;
}

// RMS values, peaks, currents and power from the phasors
void Summarise(const LinearModel& model, const SineDrive& drive, const Skin& skin,
               SteadyState& steady) {
  const Eigen::VectorXcd& x = steady.phasors;
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  steady.current_a =
      (model.current_row.cast<Complex>() * x).value() + model.current_per_volt * drive.amplitude_v;
  const Eigen::VectorXd& mean = steady.mean;
  steady.mean_current_a = model.current_row.dot(mean) + model.current_per_volt * drive.offset_v;
  steady.mean_travel_m = mean(LinearModel::kMover) - mean(LinearModel::kCase);
  steady.mean_skin_force_n = skin.stiffness_n_per_m * mean(model.skin());
  // sqrt(mean^2 + abs(X)^2 / 2)
  const auto rms = [](double constant, const Complex& peak) {
    return constant == 0 ? Abs(peak) / std::numbers::sqrt2
                         : Hypot(constant, Abs(peak) / std::numbers::sqrt2);
  };
  steady.skin_rms_m = rms(mean(model.skin()), x(model.skin()));
  steady.case_rms_m = rms(mean(LinearModel::kCase), x(LinearModel::kCase));
  steady.mover_peak_m =
      // a constant part adds to the amplitude
      std::abs(steady.mean_travel_m) + Abs(x(LinearModel::kMover) - x(LinearModel::kCase));
  steady.current_rms_a = rms(steady.mean_current_a, steady.current_a);
  // a sum of squares of what is dissipated keeps its digits where v and i are at 90 degrees
  steady.power_w = drive.offset_v * steady.mean_current_a +
                   (model.power_rows.cast<Complex>() * WithVoltage(x, drive)).squaredNorm() / 2;
  steady.phase_rad = drive.amplitude_v < 0 ? Arg(-steady.current_a) : Arg(steady.current_a);
  // Ks xs + Bs vs = (Ks + j w Bs) Xs about its constant part
  const double force_n =
      Abs(Complex(skin.stiffness_n_per_m, omega * skin.damping_n_s_per_m) * x(model.skin()));
  steady.skin_force_peak_n = std::abs(steady.mean_skin_force_n) + force_n;
  steady.skin_force_least_n = steady.mean_skin_force_n - force_n;
}

}  // namespace

SteadyState SolveSteadyState(const LinearModel& model, const SineDrive& drive, const Skin& skin) {
  HAPTOMETER_CHECK(drive.frequency_hz > 0, "frequency_hz = {}", drive.frequency_hz);
  // balanced units, so that pivots and norms compare like with like
  const BalancedMatrix balanced = Balance(model.a);
  const PhasorSystem system = SystemOf(model, balanced, drive);

  // solve, then correct once by the residual
  const ComplexEquations equations(MatrixOf(system));
  Eigen::VectorXcd x = equations.Solve(system.right.cast<Complex>());
  const Eigen::VectorXcd first = x, correction = equations.Solve(Residual(system, x));
  x += correction;

  SteadyState steady;
  steady.phasors = balanced.scale.asDiagonal() * x;
  steady.mean = StaticState(model, drive.offset_v);
  Summarise(model, drive, skin, steady);

  // not finite where the matrix is singular, which OfTrue makes infinite
  const Eigen::MatrixXd terms = TermsOf(system), inverse_parts = equations.InverseParts();
  const Eigen::VectorXd bound = EquationBound(system, terms, x, correction - (x - first));
  const double first_order = LargestError(model, drive, steady.phasors,
                                          balanced.scale.asDiagonal() * inverse_parts, bound);
  const double error =
      OfTrue(first_order * InverseFactor(system, terms, equations, inverse_parts, bound));
  // without an amplitude all phasors are exactly 0
  steady.error_estimate = drive.amplitude_v == 0 ? 0 : error;
  return steady;
}

SteadyState SolveSteadyState(const Scene& scene) {
  SteadyState steady = SolveSteadyState(AssembleModel(scene), scene.drive, scene.skin);
  // an offset moves bodies that no spring holds without limit
  if (scene.drive.offset_v != 0 && !IsHeldInPlace(scene)) steady.error_estimate = HUGE_VAL;
  return steady;
}

bool IsHeldInPlace(const Scene& scene) {
  return scene.skin.stiffness_n_per_m > 0 || scene.grip.stiffness_n_per_m > 0 || scene.grip.holds;
}

Eigen::VectorXd StaticState(const LinearModel& model, double voltage_v) {
  if (voltage_v == 0) return Eigen::VectorXd::Zero(model.states());
  const BalancedMatrix balanced = Balance(model.a);
  // -A^-1 B V in balanced units, corrected once by the residual
  const Eigen::VectorXd push = -voltage_v * model.b.cwiseQuotient(balanced.scale);
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(balanced.matrix);
  Eigen::VectorXd x = factors.solve(push);
  x += factors.solve(push - balanced.matrix * x);
  // a state below its rounding, |A^-1| |A| |x|, is one that no force holds away from its place
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  const Eigen::VectorXd rounding =
      kRounding * factors.inverse().cwiseAbs() * (balanced.matrix.cwiseAbs() * x.cwiseAbs());
  x = (x.array().abs() <= rounding.array()).select(0, x);
  return balanced.scale.cwiseProduct(x);
}

double SkinRmsUncertainty(const Scene& scene) {
  constexpr double kStep = 1e-4;
  std::array<double, kActuatorSymbols.size()> gradient{};
  for (std::size_t place = 0; place < gradient.size(); ++place) {
    // d ln(RMS) / d ln(parameter) by central differences of kStep
    const auto logarithm = [&](double factor) {
      Scene moved = scene;
      moved.actuator = Scaled(scene.actuator, place, factor);
      return Log(SolveSteadyState(moved).skin_rms_m);
    };
    gradient[place] = (logarithm(Exp(kStep)) - logarithm(Exp(-kStep))) / (2 * kStep);
  }
  // u^2 = g' C g; rounding may put a zero below 0
  double square = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    for (std::size_t j = 0; j < gradient.size(); ++j) {
      square += gradient[i] * scene.actuator_covariance[i][j] * gradient[j];
    }
  }
  return std::sqrt(std::max(square, 0.0));
}

namespace {

// longest common period, in outputs, over which peaks are interpolated
constexpr double kMostPlayed = 1 << 20;
constexpr double kParts = 1e6;  // of a hertz that frequencies are written in

// one frequency's share of a sum of sines
struct TonePart {
  double frequency_hz = 0;
  Complex amplitude;  // Im(amplitude exp(j w t))
};

// x, v and a of a sum of sines at a time
MotionJet JetAt(const std::vector<TonePart>& parts, double mean, long double t_s) {
  MotionJet jet{.x = mean};
  for (const TonePart& part : parts) {
    const double w = 2 * std::numbers::pi * part.frequency_hz;
    const Eigen::Vector2d turn = DriveAt(part.frequency_hz, t_s);
    const Complex now = part.amplitude * Complex(turn[1], turn[0]);
    jet.x += now.imag();
    jet.v += w * now.real();
    jet.a -= w * w * now.imag();
  }
  return jet;
}

// what a sum of sines comes to over one period, a constant part included
ValueRange RangeOf(const std::vector<TonePart>& parts, double mean, double period_s,
                   double highest_hz) {
  // without a common period the sum of the amplitudes, which bounds it
  if (period_s == 0) {
    double sum = 0;
    for (const TonePart& part : parts) sum += Abs(part.amplitude);
    return {.least = mean - sum, .largest = mean + sum};
  }
  const auto count =
      static_cast<std::int64_t>(std::ceil(kOutputsPerPeriod * highest_hz * period_s));
  const long double step_s = static_cast<long double>(period_s) / static_cast<long double>(count);
  ValueRange range;
  // that of a quintic between each two outputs
  MotionJet before = JetAt(parts, mean, 0);
  for (std::int64_t k = 1; k <= count; ++k) {
    const MotionJet now = JetAt(parts, mean, step_s * static_cast<long double>(k));
    range.Include(HermiteQuintic(before, now, static_cast<double>(step_s)).Range());
    before = now;
  }
  return range;
}

// of all frequencies, which are the keys, in s; 0 where it has more than kMostPlayed outputs
double CommonPeriod(const std::map<double, Complex>& voltages) {
  std::int64_t common = 0;
  for (const auto& [frequency_hz, voltage] : voltages) {
    // frequencies must be whole microhertz, and exact as doubles
    const double parts = std::round(frequency_hz * kParts);
    if (parts < 1 || parts > 1e15 || parts / kParts != frequency_hz) return 0;
    // the greatest common divisor is the frequency of the common period
    common = std::gcd(common, static_cast<std::int64_t>(parts));
  }
  const double period_s = kParts / static_cast<double>(common);
  const double outputs = kOutputsPerPeriod * voltages.rbegin()->first * period_s;
  return outputs <= kMostPlayed ? period_s : 0;
}

// Adds the steady motions at one frequency after the other.
class SumOfTones {
 public:
  SumOfTones(const Scene& scene, double period_s)
      : scene_(scene), model_(AssembleModel(scene)), finger_(SceneMode(scene).finger) {
    steady_.start = StaticState(model_, scene.drive.offset_v);
    steady_.period_s = period_s;
    AddMean();
  }

  // a voltage and a motion of the finger
  void Add(double frequency_hz, Complex voltage_v, Complex finger_m) {
    const double w = 2 * std::numbers::pi * frequency_hz;
    Eigen::VectorXcd x = Eigen::VectorXcd::Zero(model_.states());
    Complex current_a = 0;
    if (voltage_v != 0.0) {
      // phasors per volt, times the voltage
      const SteadyState one = UnderUnit(model_, frequency_hz);
      x = one.phasors * voltage_v;
      current_a = one.current_a * voltage_v;
      steady_.power_w += std::norm(voltage_v) * one.power_w;
    }
    if (finger_m != 0.0) {
      const Eigen::VectorXcd moved = UnderFinger(frequency_hz, finger_m);
      const Complex induced_a = (model_.current_row.cast<Complex>() * moved).value();
      x += moved;
      current_a += induced_a;
      // the induced current flows through the source: Re(conj(V) I) / 2, W
      steady_.power_w += (std::conj(voltage_v) * induced_a).real() / 2;
    }
    // the skin is pressed by Xs - Xg: F = (Ks + j w Bs) (Xs - Xg)
    const Skin& tissue = scene_.skin;
    const Complex skin_m = x(model_.skin()), pressed_m = skin_m - finger_m;
    const Complex force_n =
        Complex(tissue.stiffness_n_per_m, w * tissue.damping_n_s_per_m) * pressed_m;
    // at t = 0 a state is Im(X)
    steady_.start += x.imag();
    // means of squares of different frequencies add, abs(X)^2 / 2 each
    skin_square_ += std::norm(skin_m) / 2;
    case_square_ += std::norm(x(LinearModel::kCase)) / 2;
    current_square_ += std::norm(current_a) / 2;
    // power from the finger, -Re(conj(j w Xg) F) / 2, and into the skin's damper, W
    steady_.power_w -= (std::conj(Complex(0, w) * finger_m) * force_n).real() / 2;
    steady_.skin_power_w += tissue.damping_n_s_per_m * w * w * std::norm(pressed_m) / 2;
    travel_.push_back({frequency_hz, x(LinearModel::kMover) - x(LinearModel::kCase)});
    force_.push_back({frequency_hz, force_n});
    highest_hz_ = std::max(highest_hz_, frequency_hz);
  }

  SteadyTones Take() {
    steady_.skin_rms_m = std::sqrt(skin_square_);
    steady_.case_rms_m = std::sqrt(case_square_);
    steady_.current_rms_a = std::sqrt(current_square_);
    // no steady motion: no peaks
    if (!(steady_.error_estimate < 1)) return steady_;
    const ValueRange travel_m =
        RangeOf(travel_, steady_.mean_travel_m, steady_.period_s, highest_hz_);
    const ValueRange force_n =
        RangeOf(force_, steady_.mean_skin_force_n, steady_.period_s, highest_hz_);
    steady_.mover_peak_m = travel_m.LargestMagnitude();
    steady_.skin_force_peak_n = force_n.LargestMagnitude();
    steady_.skin_force_least_n = force_n.least;
    return steady_;
  }

 private:
  SteadyState UnderUnit(const LinearModel& model, double frequency_hz) {
    SteadyState one =
        SolveSteadyState(model, {.amplitude_v = 1, .frequency_hz = frequency_hz}, scene_.skin);
    steady_.error_estimate = std::max(steady_.error_estimate, one.error_estimate);
    return one;
  }

  // the finger's position and its rate each act on the skin by their own column of inputs
  Eigen::VectorXcd UnderFinger(double frequency_hz, Complex finger_m) {
    Eigen::VectorXcd states = Eigen::VectorXcd::Zero(model_.states());
    const Complex rate = Complex(0, 2 * std::numbers::pi * frequency_hz) * finger_m;
    for (const Eigen::Index input : {0, 1}) {
      if (finger_.col(input).isZero(0)) continue;
      LinearModel pushed = model_;
      pushed.b = finger_.col(input);
      // the column's own rounding is that of all its phasors, within an ulp
      pushed.b_rest.setZero();
      states += (input == 0 ? finger_m : rate) * UnderUnit(pushed, frequency_hz).phasors;
    }
    return states;
  }

  // the constant part under the drive's offset
  void AddMean() {
    const double offset_v = scene_.drive.offset_v;
    if (offset_v == 0) return;
    if (!IsHeldInPlace(scene_)) steady_.error_estimate = HUGE_VAL;
    const Eigen::VectorXd& mean = steady_.start;
    const double current_a = model_.current_row.dot(mean) + model_.current_per_volt * offset_v;
    skin_square_ = mean(model_.skin()) * mean(model_.skin());
    case_square_ = mean(LinearModel::kCase) * mean(LinearModel::kCase);
    current_square_ = current_a * current_a;
    steady_.power_w = offset_v * current_a;
    steady_.mean_travel_m = mean(LinearModel::kMover) - mean(LinearModel::kCase);
    steady_.mean_skin_force_n = scene_.skin.stiffness_n_per_m * mean(model_.skin());
  }

  const Scene& scene_;
  LinearModel model_;
  Eigen::MatrixXd finger_;  // what its motion does (Mode::finger)
  double highest_hz_ = 0;
  SteadyTones steady_;
  double skin_square_ = 0, case_square_ = 0, current_square_ = 0;
  std::vector<TonePart> travel_, force_;
};

}  // namespace

SteadyTones Superpose(const Scene& scene) {
  const SineDrive drive = scene.drive;
  // tones of the same frequency add as phasors before they are squared
  std::map<double, Complex> fingers_m{{drive.frequency_hz, 0}};
  for (const Tone& tone : scene.finger.tones) {
    fingers_m[tone.frequency_hz] += Polar(tone.amplitude, tone.phase_rad);
  }
  SumOfTones sum(scene, 0);
  for (const auto& [frequency_hz, finger_m] : fingers_m) {
    const bool is_driven = frequency_hz == drive.frequency_hz;
    sum.Add(frequency_hz, is_driven ? drive.amplitude_v : 0, finger_m);
  }
  return sum.Take();
}

SteadyTones SolveSteadyTones(const Scene& scene) {
  HAPTOMETER_CHECK(scene.drive.kind == DriveKind::kTones && !scene.drive.tones.empty(),
                   "a drive of kind {}", Name(scene.drive.kind));
  // equal frequencies add as phasors here too; opposite ones may cancel to 0
  std::map<double, Complex> voltages;
  for (const Tone& tone : scene.drive.tones) {
    voltages[tone.frequency_hz] += Polar(tone.amplitude, tone.phase_rad);
  }
  SumOfTones sum(scene, CommonPeriod(voltages));
  for (const auto& [frequency_hz, voltage_v] : voltages) {
    if (voltage_v != 0.0) sum.Add(frequency_hz, voltage_v, 0);
  }
  return sum.Take();
}

}  // namespace haptometer::sim
