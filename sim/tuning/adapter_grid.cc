#include "sim/tuning/adapter_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/linear/motor_source.h"

namespace haptometer::sim {
namespace {

using Complex = std::complex<double>;

// numbers of one area that all adapters share
struct AreaColumn {
  double stiffness_n_per_m = 0;   // Ks
  double variation_n_per_m = 0;   // v Ks
  double resistance_n_per_m = 0;  // w Bs
  double weight_square = 1;
};

struct Axes {
  std::vector<double> motor_side_mass_kg, stiffness_n_per_m, damping_n_s_per_m, contact_area_m2;
  std::vector<double> inertia_n_per_m{};  // Ma2 w^2
  std::vector<double> skin_side_mass_kg;
  std::vector<AreaColumn> columns{};
};

// best so far: weight^2 |Xs/Fc|^2 and where
struct Leader {
  double square = -1;
  Adapter adapter;
  std::size_t area = 0;
};

Axes AxesOf(const TuningProblem& problem, double omega, std::size_t values,
            const std::vector<double>& weights) {
  const AdapterBounds& bounds = problem.bounds;
  Axes axes{.motor_side_mass_kg = EqualSteps(bounds.motor_side_mass_kg, values),
            .stiffness_n_per_m = EqualSteps(bounds.stiffness_n_per_m, values),
            .damping_n_s_per_m = EqualSteps(bounds.damping_n_s_per_m, values),
            .contact_area_m2 = EqualSteps(bounds.contact_area_m2, problem.fixed_skin ? 1 : values),
            .skin_side_mass_kg = EqualSteps(bounds.skin_side_mass_kg, values)};
  axes.inertia_n_per_m.reserve(values);
  for (const double mass_kg : axes.skin_side_mass_kg) {
    axes.inertia_n_per_m.push_back(mass_kg * omega * omega);
  }
  axes.columns.reserve(values);
  for (const double area_m2 : axes.contact_area_m2) {
    const Skin skin = SkinOf(problem, area_m2);
    const double v = problem.skin_variation;
    const double weight = weights.empty() ? 1 : weights[axes.columns.size()];
    axes.columns.push_back({.stiffness_n_per_m = skin.stiffness_n_per_m,
                            .variation_n_per_m = v * skin.stiffness_n_per_m,
                            .resistance_n_per_m = omega * skin.damping_n_s_per_m * (1 + v),
                            .weight_square = weight * weight});
  }
  return axes;
}

// the masses beside the one that `wanted` = Ma2 w^2 asks for: their places, equal at the ends
struct Neighbours {
  std::size_t below, above;
};
Neighbours NeighboursOf(const std::vector<double>& inertia, double wanted) {
  const double last = static_cast<double>(inertia.size() - 1);
  const double width = inertia.back() - inertia.front();
  const double place = width > 0 ? (wanted - inertia.front()) / width * last : 0;
  const double below = std::floor(std::clamp(place, 0.0, last));
  const auto first = static_cast<std::size_t>(below);
  return {.below = first, .above = std::min(first + 1, inertia.size() - 1)};
}

// every area and skin-side mass for one motor side, spring and damper
void TryColumns(const Axes& axes, Complex D1, const Adapter& trunk, Complex ka, Leader& leader) {
  const Complex Z = D1 * ka / (D1 + ka);
  // |Xs / Fc|^2 = |ka / (D1 + ka)|^2 / |Ks + Z - Ma2 w^2 + j w Bs|^2
  const double through = std::norm(ka) / std::norm(D1 + ka);
  for (std::size_t area = 0; area < axes.columns.size(); ++area) {
    const AreaColumn& column = axes.columns[area];
    const double stiffness = column.stiffness_n_per_m + Z.real();
    const double resistance = column.resistance_n_per_m + Z.imag();
    const double above = column.weight_square * through;
    // the best Ma2 makes the real part zero: (Ks + Re Z) / w^2; the grid's two nearest are tried
    const Neighbours near = NeighboursOf(axes.inertia_n_per_m, stiffness);
    for (const std::size_t mass : {near.below, near.above}) {
      // the skin of the variation that is farthest from resonance
      const double detuning =
          std::abs(stiffness - axes.inertia_n_per_m[mass]) + column.variation_n_per_m;
      const double square = above / (detuning * detuning + resistance * resistance);
      if (!(square > leader.square)) continue;
      leader = {.square = square, .adapter = trunk, .area = area};
      leader.adapter.skin_side_mass_kg = axes.skin_side_mass_kg[mass];
    }
  }
}

Leader Search(const Axes& axes, const MotorSource& source) {
  const double w = source.omega_rad_per_s;
  Leader leader;
  for (const double Ma1 : axes.motor_side_mass_kg) {
    const Complex D1 = source.stiffness_n_per_m - (source.case_mass_kg + Ma1) * w * w;
    for (const double Ka : axes.stiffness_n_per_m) {
      for (const double Ba : axes.damping_n_s_per_m) {
        const Adapter trunk{
            .motor_side_mass_kg = Ma1, .stiffness_n_per_m = Ka, .damping_n_s_per_m = Ba};
        TryColumns(axes, D1, trunk, Complex(Ka, Ba * w), leader);
      }
    }
  }
  return leader;
}

}  // namespace

std::vector<double> EqualSteps(const Range& range, std::size_t values) {
  std::vector<double> steps;
  steps.reserve(values);
  for (std::size_t k = 0; k < values; ++k) {
    const double part = values == 1 ? 0 : static_cast<double>(k) / static_cast<double>(values - 1);
    steps.push_back(k + 1 == values && values > 1 ? range.upper : range.At(part));
  }
  return steps;
}

GridBest BestOnGrid(const TuningProblem& problem, std::size_t values_per_axis,
                    const std::vector<double>& area_weights) {
  HAPTOMETER_CHECK(values_per_axis >= 1 && !Fault(problem), "{} values an axis", values_per_axis);
  const MotorSource source = SourceOf(problem.actuator, problem.drive);
  const Axes axes = AxesOf(problem, source.omega_rad_per_s, values_per_axis, area_weights);
  HAPTOMETER_CHECK(area_weights.empty() || area_weights.size() == axes.columns.size(),
                   "{} weights for {} areas", area_weights.size(), axes.columns.size());
  const Leader leader = Search(axes, source);

  const double weight = std::sqrt(axes.columns[leader.area].weight_square);
  GridBest best{
      .point = {.adapter = leader.adapter, .contact_area_m2 = axes.contact_area_m2[leader.area]},
      // RMS from |Xs / Fc|^2: sqrt(square) |Fc| / sqrt(2)
      .score = std::sqrt(leader.square) * Abs(source.force_n) / std::numbers::sqrt2};
  best.skin_rms_m = weight > 0 ? best.score / weight : 0;
  best.points = axes.columns.size();
  for (int axis = 0; axis < 4; ++axis) best.points *= values_per_axis;
  return best;
}

}  // namespace haptometer::sim
