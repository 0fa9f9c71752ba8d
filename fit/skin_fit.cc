#include "fit/skin_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tuple>
#include <utility>

#include "dsp/statistics/distributions.h"
#include "fit/fitted_logarithm.h"
#include "fit/skin_problem.h"

namespace haptometer::fit {
namespace {

using P = ContactParameter;
using Weights = std::vector<double>;

constexpr std::size_t kLeastPoints = 5;
constexpr std::size_t kLeastFrequencies = 4;
constexpr double kMostBlur = 1e-3;
constexpr double kMostMassShare = 0.25;

// a given number, and how the parameters answer to a share of it
struct Input {
  std::string name;
  double relative_standard_uncertainty = 0;
  Weights response;
};

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
                        "five are the least; 20 from 50 to 500 Hz are good");
  }
  std::size_t different = 1;
  for (std::size_t n = 0; n < points.size(); ++n) {
    if (auto good = CheckPoint(points[n], points.front(), name); !good) return good;
    if (n > 0 && points[n].frequency_hz > points[n - 1].frequency_hz) ++different;
  }
  if (different >= kLeastFrequencies) return {};
  return CannotAnswer(name, fmt::format("has {} different frequencies", different),
                      "stiffness, damping and mass part by frequency: sweep from 50 to 500 Hz");
}

// of the two polarities the one that fits better
std::vector<SkinStart> BestStarts(SkinProblem* problem, std::vector<std::string>* assumptions) {
  auto starts = StartSkin(*problem);
  if (!problem->has_phases()) return starts;
  problem->TurnPhases();
  auto turned = StartSkin(*problem);
  const bool is_better =
      !turned.empty() && (starts.empty() || turned.front().cost < starts.front().cost);
  if (is_better) {
    assumptions->emplace_back("the coil's polarity is free: the phases are turned by 180 degrees");
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
    const double difference = std::remainder(change[n] - below[n], 2 * std::numbers::pi);
    change[n] = difference / (2 * kStep) / solution.noise[groups.group_of[n]];
  }
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
    const double unit = problem.has_uncertainties()
                            ? *point.displacement_standard_uncertainty_m / point.displacement_m
                            : 1;
    change[n] = -1 / unit / solution.noise[0];
  }
  inputs.push_back(
      {"displacement over drive", 0, Response(solution.seen, solution.jacobian, change)});
  return inputs;
}

double InputVariance(const std::vector<Input>& inputs, const sim::ActuatorCovariance& covariance,
                     P parameter) {
  double variance = 0;
  for (std::size_t i = 0; i < covariance.size(); ++i) {
    for (std::size_t k = 0; k < covariance.size(); ++k) {
      variance += inputs[i].response[Index(parameter)] * covariance[i][k] *
                  inputs[k].response[Index(parameter)];
    }
  }
  return std::max(variance, 0.0);
}

FittedValue Logarithmic(const std::vector<double>& parameters, const GroupedSolution& solution,
                        const std::vector<Input>& inputs, const sim::ActuatorCovariance& covariance,
                        P parameter, std::string unit) {
  Weights weights(kContactParameters, 0.0);
  weights[Index(parameter)] = 1;
  FittedValue value = FromLogarithm(parameters[Index(parameter)], Variance(solution.seen, weights),
                                    InputVariance(inputs, covariance, parameter), std::move(unit));
  value.determined =
      value.determined && solution.solver.converged && Blur(solution.seen, weights) < kMostBlur;
  return value;
}

FittedValue Mass(double case_mass_kg, const std::vector<double>& parameters,
                 const GroupedSolution& solution, const std::vector<Input>& inputs,
                 const sim::ActuatorCovariance& covariance) {
  Weights weights(kContactParameters, 0.0);
  weights[Index(P::kMass)] = 1;
  FittedValue value;
  value.unit = "kg";
  value.value = parameters[Index(P::kMass)];
  const double variance = Variance(solution.seen, weights);
  value.standard_uncertainty = std::sqrt(variance);
  value.combined_standard_uncertainty =
      std::sqrt(variance + InputVariance(inputs, covariance, P::kMass));
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
  fit->coverage_95 = dsp::StudentCritical(std::max(fit->degrees_of_freedom, 1.0));
  fit->singular_values = solution.seen.singular_values;
  fit->converged = solution.solver.converged;
  fit->iterations = solution.solver.iterations;
  const auto& covariance = solution.seen.covariance;
  for (std::size_t i = 0; i < kContactParameters; ++i) {
    for (std::size_t k = 0; k < kContactParameters; ++k) {
      const double scale = std::sqrt(covariance[i * kContactParameters + i] *
                                     covariance[k * kContactParameters + k]);
      const std::size_t place = i * kContactParameters + k;
      fit->correlation[place] = scale > 0 ? covariance[place] / scale : 0;
    }
  }
  fit->model_m = problem.Amplitudes(parameters);
  for (const auto& point : problem.points()) {
    fit->frequencies_hz.push_back(point.frequency_hz);
    fit->measured_m.push_back(point.displacement_m);
  }
  fit->residuals = LookAtResiduals(solution.jacobian.residuals, fit->points);
}

void ExplainUndetermined(SkinFit* fit) {
  if (!fit->stiffness.determined) {
    fit->undetermined.emplace_back(
        "Ks: damping or mass carries the motion at these frequencies; sweep lower, and measure the "
        "phase against the current");
  }
  if (!fit->damping.determined) {
    fit->undetermined.emplace_back(
        "Bs: the sweep shows no width of a resonance; more points around the largest amplitude, or "
        "the phase against the current, would");
  }
  if (!fit->mass.determined) {
    fit->undetermined.emplace_back(
        "m: inertia is hidden behind stiffness and damping; sweep higher, where w^2 (Mc + m) "
        "exceeds w Bs");
  }
}

void AddDoubts(const SkinSweep& sweep, const SkinProblem& problem, SkinFit* fit) {
  const auto doubt = [fit](bool is_doubtful, std::string sentence) {
    if (is_doubtful) fit->doubts.push_back(std::move(sentence));
  };
  const auto usual = [&](const FittedValue& value, double least, double most, const char* name) {
    doubt(value.determined && (value.value < least || value.value > most),
          fmt::format("{} of {:.4g} {} is unlike skin's: check the units of displacement and drive",
                      name, value.value, value.unit));
  };
  usual(fit->stiffness, 30, 3e4, "Ks");
  usual(fit->damping, 0.02, 50, "Bs");
  double largest_m = 0, largest_drive = 0;
  for (const auto& point : problem.points()) {
    largest_m = std::max(largest_m, point.displacement_m);
    largest_drive = std::max(largest_drive, point.drive);
  }
  doubt(largest_m > 5e-3 || largest_m < 2e-8,
        fmt::format("a largest amplitude of {:.3g} m is unlike an actuator's on skin: is the "
                    "column in um or mm?",
                    largest_m));
  const bool is_current = sweep.drive == DriveQuantity::kCurrent;
  doubt(largest_drive > (is_current ? 2.0 : 50.0),
        fmt::format("a drive of {:.3g} {} is unlike an LRA's: is the column in {}?", largest_drive,
                    is_current ? "A" : "V", is_current ? "mA" : "mV"));
  doubt(
      problem.points().back().frequency_hz < 10 || problem.points().front().frequency_hz > 5000,
      fmt::format("frequencies from {:g} to {:g} Hz are unlike a haptic sweep's: are they in kHz?",
                  problem.points().front().frequency_hz, problem.points().back().frequency_hz));
  constexpr double kPoorly = 0.2;
  doubt(!fit->uncertainties_stated && fit->magnitude_noise > kPoorly,
        fmt::format("the amplitudes lie {:.0f} % off the model: is it this actuator, are amplitude "
                    "and drive both peak or both RMS, does the contact break?",
                    100 * fit->magnitude_noise));
  doubt(fit->uncertainties_stated && fit->magnitude_noise > 3,
        fmt::format("the amplitudes lie {:.2g} times their stated uncertainties off the model",
                    fit->magnitude_noise));
  std::ranges::move(
      DoubtResiduals(
          fit->residuals, fit->magnitude_noise, fit->frequencies_hz[fit->residuals.farthest],
          "the skin is no spring, damper and mass there, or the actuator's constants are "
          "another's"),
      std::back_inserter(fit->doubts));
  doubt(fit->mass.determined && fit->mass.value < -3 * fit->mass.combined_standard_uncertainty,
        fmt::format("an effective mass of {:.3g} g is negative: is the case's mass stated too "
                    "large?",
                    1e3 * fit->mass.value));
}

// a second solution within nine units of chi-square
void NameSecondSolution(const SkinProblem& problem, const std::vector<SkinStart>& starts,
                        SkinFit* fit) {
  if (starts.size() < 2) return;
  const double degrees = std::max(fit->degrees_of_freedom, 1.0);
  const double cost = std::max(starts[0].cost, 1e-24);
  constexpr double kNine = 9;
  if ((starts[1].cost - starts[0].cost) / cost * degrees > kNine) return;
  const auto& other = starts[1].parameters;
  fit->doubts.push_back(
      fmt::format("Ks {:.3g} N/m, Bs {:.3g} N s/m, m {:.2g} g fit nearly as well: {}",
                  std::exp(other[Index(P::kStiffness)]), std::exp(other[Index(P::kDamping)]),
                  1e3 * other[Index(P::kMass)],
                  problem.has_phases() ? "sweep further"
                                       : "measure the phase against the drive, or sweep further"));
}

}  // namespace

Result<SkinFit> FitSkin(const SkinSweep& sweep, const sim::StatedActuator& stated) {
  const auto actuator = sim::Complete(stated);
  if (!actuator) return std::unexpected(actuator.error());
  const auto points = Measured(sweep.points);
  if (auto good = CheckSweep(points, sweep.name); !good) return std::unexpected(good.error());
  SkinFit fit;
  fit.name = sweep.name;
  fit.area_m2 = sweep.area_m2;
  SkinProblem problem(*actuator, sweep.drive, points);
  const auto starts = BestStarts(&problem, &fit.assumptions);
  if (starts.empty()) {
    return CannotAnswer(sweep.name, "no skin under this actuator moves so",
                        "check the units of displacement and drive, and the actuator");
  }
  std::vector<double> parameters = starts.front().parameters;
  const auto solution = SolveGroups(problem.Whole(), problem.Groups(), {true, true, true},
                                    {true, true, false}, &parameters);
  fit.actuator_covariance = sim::RelativeCovariance(stated);
  const auto& covariance = fit.actuator_covariance;
  const auto inputs = Inputs(problem, covariance, parameters, solution);
  fit.stiffness = Logarithmic(parameters, solution, inputs, covariance, P::kStiffness, "N/m");
  fit.damping = Logarithmic(parameters, solution, inputs, covariance, P::kDamping, "N s/m");
  fit.mass = Mass(actuator->case_mass_kg, parameters, solution, inputs, covariance);
  for (const auto& input : inputs) {
    fit.influences.push_back(
        {input.name, input.relative_standard_uncertainty, input.response[Index(P::kStiffness)],
         input.response[Index(P::kDamping)], input.response[Index(P::kMass)] / 100});
  }
  Describe(problem, parameters, solution, &fit);
  SetIntervals(fit.coverage_95, {&fit.stiffness, &fit.damping, &fit.mass});
  ExplainUndetermined(&fit);
  NameSecondSolution(problem, starts, &fit);
  AddDoubts(sweep, problem, &fit);
  return fit;
}

}  // namespace haptometer::fit
