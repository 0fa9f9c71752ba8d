#include "tools/fit/fit_impedance_panels.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <tuple>

#include "tools/fit/sweep_panels.h"

namespace haptometer::tools {
namespace {

using fit::ImpedanceFit;

constexpr double kDegrees = 180 / std::numbers::pi;

// the fit between the points too
struct ModelCurves {
  FrequencyCurve ohm;
  FrequencyCurve degrees;
};

ModelCurves CurvesOf(const ImpedanceFit& fit) {
  constexpr int kPlaces = 1000;
  ModelCurves curves;
  for (int k = 0; k <= kPlaces; ++k) {
    const double hertz =
        fit.lowest_hz * std::pow(fit.highest_hz / fit.lowest_hz, static_cast<double>(k) / kPlaces);
    const auto value = fit::ImpedanceAt(fit.parameters, hertz).ohm;
    for (FrequencyCurve* curve : {&curves.ohm, &curves.degrees}) curve->hertz.push_back(hertz);
    curves.ohm.values.push_back(std::abs(value));
    curves.degrees.values.push_back(kDegrees * std::arg(value));
  }
  return curves;
}

}  // namespace

std::vector<plot::Panel> ImpedancePanels(const ImpedanceFit& fit,
                                         std::vector<fit::ImpedancePoint> points) {
  std::ranges::sort(points, {}, [](const fit::ImpedancePoint& point) {
    return std::tuple(point.frequency_hz, point.ohm.real(), point.ohm.imag());
  });
  FrequencyCurve ohm;
  FrequencyCurve degrees;
  std::vector<SweepResiduals> left{{"magnitude", {}}, {"phase", {}}};
  for (std::size_t n = 0; n < points.size(); ++n) {
    ohm.values.push_back(std::abs(points[n].ohm));
    degrees.values.push_back(kDegrees * std::arg(points[n].ohm));
    ohm.hertz.push_back(points[n].frequency_hz);
    const std::complex<double> ratio = std::log(points[n].ohm / fit.model[n].ohm);
    left[0].values.push_back(ratio.real() / std::max(fit.magnitude_noise, 1e-300));
    left[1].values.push_back(ratio.imag() / std::max(fit.phase_noise_rad, 1e-300));
  }
  degrees.hertz = ohm.hertz;
  const ModelCurves model = CurvesOf(fit);
  const std::string noise =
      fmt::format("residual in units of a point's noise: {:.2g} %, {:.2g} deg",
                  100 * fit.magnitude_noise, kDegrees * fit.phase_noise_rad);
  constexpr auto kX = plot::LogAxes::kX;
  return {SweepPanel("", "|Z| / ohm", ohm, model.ohm, kX),
          SweepPanel("", "phase / deg", degrees, model.degrees, kX),
          SweepResidualPanel(noise, "residual / noise", ohm.hertz, left, kX)};
}

}  // namespace haptometer::tools
