#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "fit/skin/skin_fit.h"
#include "sim/linear/steady_state.h"
#include "tests/fit/bound.h"

namespace haptometer::tests {

// truth: what a contact of 78.5 mm2 has by the thesis's text, and a gram of skin
struct SkinTruth {
  double stiffness = 1861.7;
  double damping = 2.2189;
  double mass_kg = 1e-3;
};

struct SyntheticSweep {
  SkinTruth truth = {};
  std::vector<double> frequencies_hz;
  double magnitude_noise = 0;
  double phase_noise_rad = 0;  // 0: no phases
  fit::DriveQuantity drive = fit::DriveQuantity::kCurrent;
  bool states_uncertainty = false;
  unsigned seed = 1;
};

// displacement of the skin over current or voltage by sim's five states, the mass on the case
inline std::complex<double> SimResponse(const SkinTruth& truth, fit::DriveQuantity drive,
                                        double hz) {
  auto actuator = sim::ThesisC10100();
  actuator.case_mass_kg += truth.mass_kg;
  const sim::Skin skin{truth.stiffness, truth.damping};
  const auto model = sim::AssembleModel(actuator, {}, skin);
  const auto steady = sim::SolveSteadyState(model, {.amplitude_v = 1, .frequency_hz = hz}, skin);
  const std::complex<double> displacement = steady.phasors(model.skin());
  const bool by_current = drive == fit::DriveQuantity::kCurrent;
  return by_current ? displacement / steady.current_a : displacement;
}

inline std::vector<double> Spaced(double first, double last, int count) {
  std::vector<double> hertz;
  for (int k = 0; k < count; ++k) {
    hertz.push_back(first * std::pow(last / first, k / (count - 1.0)));
  }
  return hertz;
}

inline fit::SkinSweep Measure(const SyntheticSweep& sweep) {
  fit::SkinSweep measured{.name = "skin.csv", .area_m2 = {}, .drive = sweep.drive, .points = {}};
  std::mt19937_64 engine(sweep.seed);
  std::normal_distribution<double> noise;
  const double drive = sweep.drive == fit::DriveQuantity::kCurrent ? 0.1 : 3.0;
  for (const double hz : sweep.frequencies_hz) {
    const std::complex<double> response = SimResponse(sweep.truth, sweep.drive, hz);
    fit::SkinPoint point{.frequency_hz = hz,
                         .displacement_m = std::abs(response) * drive *
                                           std::exp(sweep.magnitude_noise * noise(engine)),
                         .drive = drive,
                         .phase_rad = {},
                         .displacement_standard_uncertainty_m = {}};
    if (sweep.phase_noise_rad > 0) {
      point.phase_rad = std::arg(response) + sweep.phase_noise_rad * noise(engine);
    }
    if (sweep.states_uncertainty) {
      point.displacement_standard_uncertainty_m = sweep.magnitude_noise * point.displacement_m;
    }
    measured.points.push_back(point);
  }
  return measured;
}

inline sim::StatedActuator Actuator() { return *sim::FindActuator("thesis-c10-100"); }

inline std::vector<double> Bounds(const SyntheticSweep& sweep) {
  const auto residuals = [&](const std::vector<double>& p) {
    std::vector<double> weighted;
    for (const double hz : sweep.frequencies_hz) {
      const std::complex<double> response =
          SimResponse({std::exp(p[0]), std::exp(p[1]), p[2]}, sweep.drive, hz);
      weighted.push_back(std::log(std::abs(response)) / sweep.magnitude_noise);
      if (sweep.phase_noise_rad > 0) {
        weighted.push_back(std::arg(response) / sweep.phase_noise_rad);
      }
    }
    return weighted;
  };
  const SkinTruth& truth = sweep.truth;
  return CramerRaoDeviations(residuals,
                             {std::log(truth.stiffness), std::log(truth.damping), truth.mass_kg},
                             {1e-3, 1e-3, 1e-6});
}

}  // namespace haptometer::tests
