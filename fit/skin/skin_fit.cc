#include "fit/skin/skin_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tuple>
#include <utility>

#include "dsp/statistics/distributions.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {

/// A sweep on the skin as least squares over ln Ks, ln Bs, m: residuals of the amplitudes (divided
/// by their relative standard uncertainties, or else by 1), then of the phases where they are
/// measured.
class SkinProblem {
 public:
  SkinProblem(sim::Actuator actuator, DriveQuantity drive, std::vector<SkinPoint> points);

  /// The problem; refers to this object.
  [[nodiscard]] LeastSquares Whole() const;
  [[nodiscard]] NoiseGroups Groups() const;
  /// The residuals with another actuator, for the response to its constants.
  [[nodiscard]] std::vector<double> ResidualsWith(const sim::Actuator& actuator,
                                                  const std::vector<double>& parameters) const;
  /// The amplitudes that the parameters give.
  [[nodiscard]] std::vector<double> Amplitudes(const std::vector<double>& parameters) const;

  /// What the rounding of displacements, drives and phases may move the parameters by.
  [[nodiscard]] std::vector<std::vector<double>> Rounding(const GroupedSolution& solution) const;

  [[nodiscard]] const std::vector<SkinPoint>& points() const { return points_; }
  [[nodiscard]] const sim::Actuator& actuator() const { return actuator_; }
  [[nodiscard]] bool has_phases() const { return has_phases_; }
  [[nodiscard]] bool has_uncertainties() const { return has_uncertainties_; }

  /// Of a magnitude's residual: the stated relative uncertainty, or 1.
  [[nodiscard]] double UnitOf(const SkinPoint& point) const;

  /// Turns all phases by pi: a coil's polarity is free.
  void TurnPhases();

 private:
  bool Evaluate(const sim::Actuator& actuator, std::span<const double> at,
                std::span<double> residuals, std::span<double> jacobian) const;
  [[nodiscard]] std::size_t Residuals() const;

  sim::Actuator actuator_;
  DriveQuantity drive_;
  std::vector<SkinPoint> points_;
  bool has_phases_;
  bool has_uncertainties_;
};

/// Solutions of the unweighted problem from the best cells of a grid (Ks 10 to 1e5 N/m, Bs 0.01 to
/// 100 N s/m, m 0 to 20 Mc), best first, those that differ by less than 1 % once.
struct SkinStart {
  std::vector<double> parameters;
  double cost = 0;
};
[[nodiscard]] std::vector<SkinStart> StartSkin(const SkinProblem& problem);

using Complex = std::complex<double>;
using P = ContactParameter;

ContactValue ContactAt(const sim::Actuator& actuator, DriveQuantity drive,
                       const std::vector<double>& parameters, double frequency_hz) {
  const double w = 2 * std::numbers::pi * frequency_hz;
  const double Mv = actuator.moving_mass_kg, Mc = actuator.case_mass_kg;
  const double Km = actuator.force_constant_n_per_a;
  const double Ks = std::exp(parameters[Index(P::kStiffness)]);
  const double Bs = std::exp(parameters[Index(P::kDamping)]);
  const double m = parameters[Index(P::kMass)];
  // complex stiffnesses, N/m: D of the mover's spring, T of skin and case
  const Complex D(actuator.stiffness_n_per_m, w * actuator.damping_n_s_per_m);
  const Complex T(Ks - w * w * (Mc + m), w * Bs);
  const Complex mover = D - w * w * Mv;

  // equations 2.2 and 2.3 for x = xa and y = xv - xa, per ampere
  const Complex denominator = T * mover - w * w * Mv * D;
  const Complex per_ampere = -w * w * Mv * Km / denominator;
  const Complex travel = (w * w * Mv * per_ampere - Km) / mover;
  // d ln(x/i)/dT
  Complex slope = -mover / denominator;
  ContactValue value{per_ampere, {}};
  if (drive == DriveQuantity::kVoltage) {
    // Z = R + j w L - j w Km y (ohm), y the mover's travel per ampere
    const Complex impedance =
        Complex(actuator.resistance_ohm, w * actuator.inductance_h) - Complex(0, w * Km) * travel;
    value.motion = per_ampere / impedance;
    // the impedance moves with x/i, and d ln(x/v) = d ln(x/i) - dZ/Z
    const Complex impedance_slope = -Complex(0, w * Km) * (w * w * Mv / mover) * per_ampere * slope;
    slope -= impedance_slope / impedance;
  }
  // by ln Ks, ln Bs and m: dT = Ks, j w Bs and -w^2
  value.logarithmic_slopes = {slope * Ks, slope * Complex(0, w * Bs), -slope * (w * w)};
  return value;
}

namespace {

double Wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

using Weights = std::vector<double>;

constexpr std::size_t kLeastPoints = 5;
constexpr std::size_t kLeastFrequencies = 4;
// see Blur (fit/identifiability.h)
constexpr double kMostBlur = 1e-3;
// standard uncertainty over Mc + m up to which the skin's mass is determined
constexpr double kMostMassShare = 0.25;

// a given number, and how the parameters answer to a share of it
struct Input {
  std::string name;
  double relative_standard_uncertainty = 0;
  Weights response;
};

// complete points by frequency; equal frequencies in an order that does not depend on the table's
std::vector<SkinPoint> Measured(const std::vector<SkinPoint>& points) {
  std::vector<SkinPoint> measured;
  measured.reserve(points.size());
  for (const auto& point : points) {
    const bool is_whole = std::isfinite(point.frequency_hz) &&
                          std::isfinite(point.displacement_m) && std::isfinite(point.drive) &&
                          std::isfinite(point.phase_rad.value_or(0)) &&
                          std::isfinite(point.displacement_standard_uncertainty_m.value_or(0));
    if (is_whole) measured.push_back(point);
  }
  std::ranges::sort(measured, {}, [](const SkinPoint& point) {
    return std::tuple(point.frequency_hz, point.displacement_m, point.drive, point.phase_rad);
  });
  return measured;
}

// positive numbers, and the same optional columns as in the first point
Result<void> CheckPoint(const SkinPoint& point, const SkinPoint& first, const std::string& name) {
  if (!(point.frequency_hz > 0 && point.displacement_m > 0 && point.drive > 0)) {
    return CannotAnswer(name,
                        fmt::format("has {:g} m under a drive of {:g} at {:g} Hz",
                                    point.displacement_m, point.drive, point.frequency_hz),
                        "frequencies, amplitudes and drives are positive");
  }
  if (point.phase_rad.has_value() != first.phase_rad.has_value() ||
      point.displacement_standard_uncertainty_m.has_value() !=
          first.displacement_standard_uncertainty_m.has_value()) {
    return CannotAnswer(name, "states phases or uncertainties for some points only",
                        "state them for all or for none");
  }
  if (point.displacement_standard_uncertainty_m.value_or(1) > 0) return {};
  return CannotAnswer(name, "states an uncertainty that is not positive", "leave the column out");
}

Result<void> CheckSweep(const std::vector<SkinPoint>& points, const std::string& name) {
  if (points.size() < kLeastPoints) {
    return CannotAnswer(name, fmt::format("holds only {} points", points.size()),
                        "at least five are needed; 20 from 50 to 500 Hz are good");
  }
  std::size_t different = 1;
  for (std::size_t n = 0; n < points.size(); ++n) {
    HAPTOMETER_TRY(CheckPoint(points[n], points.front(), name));
    if (n > 0 && points[n].frequency_hz > points[n - 1].frequency_hz) ++different;
  }
  if (different >= kLeastFrequencies) return {};
  return CannotAnswer(name, fmt::format("has {} different frequencies", different),
                      "stiffness, damping and mass differ in their dependence on frequency: sweep "
                      "from 50 to 500 Hz");
}

// of the two polarities the one that fits better
std::vector<SkinStart> BestStarts(SkinProblem* problem, Findings* findings) {
  auto starts = StartSkin(*problem);
  if (!problem->has_phases()) return starts;
  problem->TurnPhases();
  auto turned = StartSkin(*problem);
  const bool is_better =
      !turned.empty() && (starts.empty() || turned.front().cost < starts.front().cost);
  if (is_better) {
    findings->Note(FindingKind::kPolarityTurned);
    return turned;
  }
  problem->TurnPhases();
  return starts;
}

// the response to one of the actuator's numbers, by central differences
Weights ActuatorResponse(const SkinProblem& problem, const std::vector<double>& parameters,
                         const GroupedSolution& solution, std::size_t place) {
  constexpr double kStep = 1e-4;
  const NoiseGroups groups = problem.Groups();
  auto change =
      problem.ResidualsWith(sim::Scaled(problem.actuator(), place, 1 + kStep), parameters);
  const auto below =
      problem.ResidualsWith(sim::Scaled(problem.actuator(), place, 1 - kStep), parameters);
  for (std::size_t n = 0; n < change.size(); ++n) {
    // phases stand behind the magnitudes; their difference is taken between -pi and pi
    const double difference = change[n] - below[n];
    const bool is_phase = n >= problem.points().size();
    change[n] = (is_phase ? Wrapped(difference) : difference) / (2 * kStep) /
                solution.noise[groups.group_of[n]];
  }
  // -(J'J)^+ J' change: per relative change of that number
  return Response(solution.seen, solution.jacobian, change);
}

// the actuator's seven numbers, then the scale of the measurement
std::vector<Input> Inputs(const SkinProblem& problem, const sim::ActuatorCovariance& covariance,
                          const std::vector<double>& parameters, const GroupedSolution& solution) {
  std::vector<Input> inputs;
  inputs.reserve(sim::kActuatorSymbols.size() + 1);
  for (std::size_t k = 0; k < sim::kActuatorSymbols.size(); ++k) {
    inputs.push_back({std::string(sim::kActuatorSymbols[k]), std::sqrt(covariance[k][k]),
                      ActuatorResponse(problem, parameters, solution, k)});
  }
  // 1 % more displacement per drive is 0.01 less in the amplitudes' residuals
  std::vector<double> change(solution.jacobian.rows, 0.0);
  for (std::size_t n = 0; n < problem.points().size(); ++n) {
    const auto& point = problem.points()[n];
    change[n] = -1 / problem.UnitOf(point) / solution.noise[0];
  }
  inputs.push_back(
      {"displacement over drive", 0, Response(solution.seen, solution.jacobian, change)});
  return inputs;
}

// What the parameters depend on besides the points' noise.
struct Given {
  std::vector<Input> inputs;
  sim::ActuatorCovariance covariance{};       // relative, of the first seven
  std::vector<std::vector<double>> rounding;  // responses (fit/residuals.h)
};

// the weights of one parameter alone
Weights Alone(P parameter) {
  Weights weights(kContactParameters, 0.0);
  weights[Index(parameter)] = 1;
  return weights;
}

// g' C g (GUM 5.2.2): g responses of the parameter, C relative covariance of the actuator's numbers
double InputVariance(const Given& given, P parameter) {
  const auto& [inputs, covariance, rounding] = given;
  double variance = CovarianceBy(rounding, Alone(parameter), Alone(parameter));
  for (std::size_t i = 0; i < covariance.size(); ++i) {
    for (std::size_t k = 0; k < covariance.size(); ++k) {
      variance += inputs[i].response[Index(parameter)] * covariance[i][k] *
                  inputs[k].response[Index(parameter)];
    }
  }
  return std::max(variance, 0.0);
}

// the interval of a constant whose parameter has these variances
void SetInterval(const GroupedSolution& solution, P parameter, double variance,
                 double input_variance, FittedValue* value) {
  SetIntervals(
      ScatterCoverage(variance + input_variance, variance, DegreesOf(solution, Alone(parameter))),
      {value});
}

// Ks or Bs from its fitted logarithm
FittedValue Logarithmic(const std::vector<double>& parameters, const GroupedSolution& solution,
                        const Given& given, P parameter, std::string unit) {
  const double variance = Variance(solution.type_a, Alone(parameter));
  const double input_variance = InputVariance(given, parameter);
  FittedValue value =
      FromLogarithm(parameters[Index(parameter)], variance, input_variance, std::move(unit));
  SetInterval(solution, parameter, variance, input_variance, &value);
  value.determined = value.determined && solution.solver.converged &&
                     Blur(solution.seen, Alone(parameter)) < kMostBlur;
  return value;
}

// the skin's mass m is fitted itself, not as a logarithm: it may be 0 or negative
FittedValue Mass(double case_mass_kg, const std::vector<double>& parameters,
                 const GroupedSolution& solution, const Given& given) {
  FittedValue value;
  value.unit = "kg";
  value.value = parameters[Index(P::kMass)];
  const double variance = Variance(solution.type_a, Alone(P::kMass));
  const double input_variance = InputVariance(given, P::kMass);
  value.standard_uncertainty = std::sqrt(variance);
  value.combined_standard_uncertainty = std::sqrt(variance + input_variance);
  SetInterval(solution, P::kMass, variance, input_variance, &value);
  value.determined = solution.solver.converged && solution.seen.nullity == 0 &&
                     value.standard_uncertainty < kMostMassShare * (case_mass_kg + value.value);
  return value;
}

void Describe(const SkinProblem& problem, const std::vector<double>& parameters,
              const GroupedSolution& solution, SkinFit* fit) {
  fit->points = problem.points().size();
  fit->uncertainties_stated = problem.has_uncertainties();
  fit->magnitude_noise = solution.noise[0];
  if (problem.has_phases()) fit->phase_noise_rad = solution.noise[1];
  for (const double degrees : solution.degrees) fit->degrees_of_freedom += degrees;
  for (const P parameter : {P::kStiffness, P::kDamping, P::kMass}) {
    fit->coverage_95 =
        std::max(fit->coverage_95, dsp::StudentCritical(DegreesOf(solution, Alone(parameter))));
  }
  fit->singular_values = solution.seen.singular_values;
  fit->converged = solution.solver.converged;
  fit->iterations = solution.solver.iterations;
  std::ranges::copy(Correlations(solution.type_a), fit->correlation.begin());
  fit->model_m = problem.Amplitudes(parameters);
  for (const auto& point : problem.points()) {
    fit->frequencies_hz.push_back(point.frequency_hz);
    fit->measured_m.push_back(point.displacement_m);
  }
  fit->residuals = LookAtResiduals(solution.jacobian.residuals, fit->points);
}

void ExplainUndetermined(SkinFit* fit) {
  if (!fit->stiffness.determined) fit->findings.Refuse(FindingKind::kKsNotDetermined);
  if (!fit->damping.determined) fit->findings.Refuse(FindingKind::kBsNotDetermined);
  if (!fit->mass.determined) fit->findings.Note(FindingKind::kSkinMassNotDetermined);
}

// ranges (N/m, N s/m, m, A, V, Hz) of a skin under an actuator: values outside indicate wrong units
void DoubtUnits(const SkinSweep& sweep, const SkinProblem& problem, SkinFit* fit) {
  using enum FindingKind;
  Findings& findings = fit->findings;
  DoubtUnusual(kUnusualSkinStiffness, "stiffness_n_per_m", fit->stiffness,
               sim::kPlausibleSkinStiffnessNPerM, findings);
  DoubtUnusual(kUnusualSkinDamping, "damping_n_s_per_m", fit->damping,
               sim::kPlausibleSkinDampingNSPerM, findings);
  double largest_m = 0, largest_drive = 0;
  for (const auto& point : problem.points()) {
    largest_m = std::max(largest_m, point.displacement_m);
    largest_drive = std::max(largest_drive, point.drive);
  }
  DoubtUnusual(kUnusualAmplitude, "amplitude_m", largest_m, {2e-8, 5e-3}, findings);
  const bool is_current = sweep.drive == DriveQuantity::kCurrent;
  DoubtUnusual(kUnusualDrive, is_current ? "current_a" : "voltage_v", largest_drive,
               is_current ? sim::PlausibleRange{0, 2} : sim::kPlausibleDriveV, findings);
  const double lowest_hz = problem.points().front().frequency_hz;
  const double highest_hz = problem.points().back().frequency_hz;
  if (highest_hz < sim::kPlausibleDriveHz.least || lowest_hz > sim::kPlausibleDriveHz.most) {
    findings.Doubt(kUnusualFrequencies, {{"lowest_hz", lowest_hz}, {"highest_hz", highest_hz}});
  }
}

void AddDoubts(const SkinSweep& sweep, const SkinProblem& problem, SkinFit* fit) {
  using enum FindingKind;
  constexpr double kPoorly = 0.2;
  Findings& findings = fit->findings;
  DoubtUnits(sweep, problem, fit);
  // residuals of 20 % without stated uncertainties, or of three times the stated ones
  if (!fit->uncertainties_stated && fit->magnitude_noise > kPoorly) {
    findings.Doubt(kFarOffModel, {{"share", fit->magnitude_noise}});
  }
  if (fit->uncertainties_stated && fit->magnitude_noise > 3) {
    findings.Doubt(kBeyondStated, {{"ratio", fit->magnitude_noise}});
  }
  DoubtResiduals(fit->residuals, fit->magnitude_noise, fit->frequencies_hz[fit->residuals.farthest],
                 findings);
  if (fit->mass.determined && fit->mass.value < -3 * fit->mass.combined_standard_uncertainty) {
    findings.Doubt(kNegativeMass, {{"mass_kg", fit->mass.value}});
  }
}

// a second solution within nine units of chi-squared
void NameSecondSolution(const std::vector<SkinStart>& starts, SkinFit* fit) {
  if (starts.size() < 2) return;
  // costs are without weights: the best one's mean square per degree of freedom is the unit
  const double degrees = std::max(fit->degrees_of_freedom, 1.0);
  // data without noise have a cost of 0
  const double cost = std::max(starts[0].cost, 1e-24);
  constexpr double kNine = 9;
  if ((starts[1].cost - starts[0].cost) / cost * degrees > kNine) return;
  const auto& other = starts[1].parameters;
  fit->findings.Doubt(FindingKind::kSecondSolution,
                      {{"stiffness_n_per_m", std::exp(other[Index(P::kStiffness)])},
                       {"damping_n_s_per_m", std::exp(other[Index(P::kDamping)])},
                       {"mass_kg", other[Index(P::kMass)]}});
}

}  // namespace

Result<SkinFit> FitSkin(const SkinSweep& sweep, const sim::StatedActuator& stated) {
  HAPTOMETER_LET(const auto actuator, sim::Complete(stated));
  const auto points = Measured(sweep.points);
  HAPTOMETER_TRY(CheckSweep(points, sweep.name));
  SkinFit fit;
  fit.name = sweep.name;
  fit.area_m2 = sweep.area_m2;
  fit.is_simulated = sweep.is_simulated;
  SkinProblem problem(actuator, sweep.drive, points);
  // the coil's polarity is free: both signs of the phases are tried
  const auto starts = BestStarts(&problem, &fit.findings);
  if (starts.empty()) {
    return CannotAnswer(sweep.name, "no skin under this actuator has this motion",
                        "check the units of displacement and drive, and the actuator");
  }
  // weighted by the noise of magnitudes and phases; ln Ks and ln Bs are logarithms, m is not
  std::vector<double> parameters = starts.front().parameters;
  const auto solution = SolveGroups(problem.Whole(), problem.Groups(), {true, true, true},
                                    {true, true, false}, &parameters);
  fit.actuator_covariance = sim::RelativeCovariance(stated);
  // type B: the actuator's constants and the displacement's scale through the solution's response
  const Given given{Inputs(problem, fit.actuator_covariance, parameters, solution),
                    fit.actuator_covariance, problem.Rounding(solution)};
  fit.stiffness = Logarithmic(parameters, solution, given, P::kStiffness, "N/m");
  fit.damping = Logarithmic(parameters, solution, given, P::kDamping, "N s/m");
  fit.mass = Mass(actuator.case_mass_kg, parameters, solution, given);
  // per percent of an input: percent of Ks and of Bs, kg of m
  for (const auto& input : given.inputs) {
    fit.influences.push_back(
        {input.name, input.relative_standard_uncertainty, input.response[Index(P::kStiffness)],
         input.response[Index(P::kDamping)], input.response[Index(P::kMass)] / 100});
  }
  Describe(problem, parameters, solution, &fit);
  ExplainUndetermined(&fit);
  NameSecondSolution(starts, &fit);
  AddDoubts(sweep, problem, &fit);
  return fit;
}

namespace {

constexpr std::size_t kMostStarts = 4;

double Cost(const LeastSquares& problem, const std::vector<double>& at) {
  std::vector<double> residuals(problem.residuals);
  if (!problem.evaluate(at, residuals, {})) return HUGE_VAL;
  double cost = 0;
  for (const double residual : residuals) cost += residual * residual;
  return cost;
}

// whether two solutions differ by less than 1 % in Ks and Bs
bool AreAlike(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kAlike = 0.01;
  return std::abs(a[Index(P::kStiffness)] - b[Index(P::kStiffness)]) < kAlike &&
         std::abs(a[Index(P::kDamping)] - b[Index(P::kDamping)]) < kAlike;
}

}  // namespace

SkinProblem::SkinProblem(sim::Actuator actuator, DriveQuantity drive, std::vector<SkinPoint> points)
    : actuator_(actuator),
      drive_(drive),
      points_(std::move(points)),
      has_phases_(points_.front().phase_rad.has_value()),
      has_uncertainties_(points_.front().displacement_standard_uncertainty_m.has_value()) {}

double SkinProblem::UnitOf(const SkinPoint& point) const {
  return has_uncertainties_ ? *point.displacement_standard_uncertainty_m / point.displacement_m : 1;
}

std::size_t SkinProblem::Residuals() const { return points_.size() * (has_phases_ ? 2 : 1); }

bool SkinProblem::Evaluate(const sim::Actuator& actuator, std::span<const double> at,
                           std::span<double> residuals, std::span<double> jacobian) const {
  const std::vector<double> parameters(at.begin(), at.end());
  // T has the mass Mc + m, which is positive
  if (!(actuator.case_mass_kg + parameters[Index(P::kMass)] > 0)) return false;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    const SkinPoint& point = points_[n];
    const ContactValue model = ContactAt(actuator, drive_, parameters, point.frequency_hz);
    // magnitudes: ln(model/measured), in units of the stated relative uncertainty
    const double unit = UnitOf(point);
    residuals[n] = std::log(std::abs(model.motion) * point.drive / point.displacement_m) / unit;
    if (!std::isfinite(residuals[n])) return false;
    // phases: rad, in the rows behind the magnitudes
    const std::size_t phase = n + points_.size();
    if (has_phases_) residuals[phase] = Wrapped(std::arg(model.motion) - *point.phase_rad);
    if (jacobian.empty()) continue;
    // slopes of ln(x/i) = ln abs(x/i) + j arg(x/i)
    for (std::size_t k = 0; k < kContactParameters; ++k) {
      jacobian[n * kContactParameters + k] = model.logarithmic_slopes[k].real() / unit;
      if (has_phases_) {
        jacobian[phase * kContactParameters + k] = model.logarithmic_slopes[k].imag();
      }
    }
  }
  return true;
}

LeastSquares SkinProblem::Whole() const {
  return {
      Residuals(), kContactParameters,
      [this](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
        return Evaluate(actuator_, at, residuals, jacobian);
      }};
}

NoiseGroups SkinProblem::Groups() const {
  // group 0: magnitudes, with at least the stated noise; group 1: phases
  NoiseGroups groups{std::vector<std::size_t>(Residuals(), 0), {has_uncertainties_ ? 1.0 : 0.0}};
  if (!has_phases_) return groups;
  groups.least_noise.push_back(0);
  for (std::size_t n = points_.size(); n < Residuals(); ++n) groups.group_of[n] = 1;
  return groups;
}

std::vector<double> SkinProblem::ResidualsWith(const sim::Actuator& actuator,
                                               const std::vector<double>& parameters) const {
  std::vector<double> residuals(Residuals());
  const bool defined = Evaluate(actuator, parameters, residuals, {});
  if (!defined) std::ranges::fill(residuals, std::nan(""));
  return residuals;
}

std::vector<std::vector<double>> SkinProblem::Rounding(const GroupedSolution& solution) const {
  // residuals ln(model drive/displacement), then arg(model) - phase
  // drives are set, so that equal ones are exact
  TabulatedValues displacements;
  TabulatedValues phases{{}, {}, points_.size()};
  for (const auto& point : points_) {
    displacements.values.push_back(point.displacement_m);
    displacements.slopes.push_back(-1 / point.displacement_m / UnitOf(point));
    if (!has_phases_) continue;
    phases.values.push_back(*point.phase_rad);
    phases.slopes.push_back(-1);
  }
  std::vector<std::vector<double>> all;
  for (const auto* tabulated : {&displacements, &phases}) {
    auto responses = RoundingResponses(solution, Groups(), *tabulated);
    std::ranges::move(responses, std::back_inserter(all));
  }
  return all;
}

std::vector<double> SkinProblem::Amplitudes(const std::vector<double>& parameters) const {
  std::vector<double> amplitudes;
  amplitudes.reserve(points_.size());
  for (const auto& point : points_) {
    const auto model = ContactAt(actuator_, drive_, parameters, point.frequency_hz);
    amplitudes.push_back(std::abs(model.motion) * point.drive);
  }
  return amplitudes;
}

void SkinProblem::TurnPhases() {
  for (auto& point : points_) point.phase_rad = Wrapped(*point.phase_rad + std::numbers::pi);
}

std::vector<SkinStart> StartSkin(const SkinProblem& problem) {
  const LeastSquares whole = problem.Whole();
  std::vector<SkinStart> cells;
  constexpr int kStiffnesses = 14;  // 10 N/m to 82 kN/m
  constexpr int kDampings = 14;     // 0.01 to 82 N s/m
  for (int k = 0; k < kStiffnesses * kDampings; ++k) {
    // cells a factor of 2 apart; masses in units of Mc
    const double stiffness = std::ldexp(10.0, k / kDampings);
    const double damping = std::ldexp(0.01, k % kDampings);
    for (const double mass : {0.0, 1.0, 4.0, 20.0}) {
      std::vector<double> at{std::log(stiffness), std::log(damping),
                             mass * problem.actuator().case_mass_kg};
      const double cost = Cost(whole, at);
      if (std::isfinite(cost)) cells.push_back({std::move(at), cost});
    }
  }
  std::ranges::sort(cells, {}, &SkinStart::cost);
  std::vector<SkinStart> solutions;
  // the best cells of different neighbourhoods: every eighth of the best thirty-two
  constexpr std::size_t kStride = 8;
  for (std::size_t k = 0; k < cells.size() && k < kMostStarts * kStride; k += kStride) {
    SkinStart solution = cells[k];
    const auto report =
        Minimise(whole, std::vector<bool>(kContactParameters, true), &solution.parameters);
    if (!report.converged) continue;
    solution.cost = Cost(whole, solution.parameters);
    const bool known = std::ranges::any_of(solutions, [&](const SkinStart& other) {
      return AreAlike(other.parameters, solution.parameters);
    });
    if (!known) solutions.push_back(std::move(solution));
  }
  std::ranges::sort(solutions, {}, &SkinStart::cost);
  return solutions;
}

}  // namespace haptometer::fit
