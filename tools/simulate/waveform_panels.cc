#include "tools/simulate/waveform_panels.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "dsp/spectrum/welch.h"

namespace haptometer::tools {
namespace {

constexpr double kUm = 1e-6;  // in metres
constexpr double kMa = 1e-3;  // in amperes
constexpr double kShownPeriods = 10;
constexpr double kLeastShown = 1e-6;  // of the largest amplitude in the spectrum
constexpr double kShownPart = 0.125;  // of the rate

// rows `first` on, in units of `unit`
plot::Series Curve(std::string title, plot::Colour colour, const Eigen::VectorXd& values,
                   double unit, Eigen::Index first, double rate_hz) {
  plot::Series series{.title = std::move(title), .style = plot::Lines(colour), .x = {}, .y = {}};
  for (Eigen::Index row = first; row < values.size(); ++row) {
    series.x.push_back(static_cast<double>(row) / rate_hz);
    series.y.push_back(values(row) / unit);
  }
  return series;
}

plot::Panel MotionPanel(const sim::Waveforms& waves, std::string title, Eigen::Index first) {
  const Eigen::VectorXd travel_m = waves.mover_m - waves.case_m;
  return {std::move(title),
          "time / s",
          "displacement / um",
          {Curve("mover in its case", plot::kGrey, travel_m, kUm, first, waves.rate_hz),
           Curve("skin", plot::kBlue, waves.skin_m, kUm, first, waves.rate_hz)}};
}

plot::Panel ElectricalPanel(const sim::Waveforms& waves) {
  return {"at the coil",
          "time / s",
          "voltage / V, current / 10 mA",
          {Curve("voltage", plot::kGrey, waves.voltage_v, 1, 0, waves.rate_hz),
           Curve("current", plot::kOrange, waves.current_a, 10 * kMa, 0, waves.rate_hz)}};
}

Result<plot::Panel> SpectrumPanel(const sim::Waveforms& waves) {
  const auto spectrum =
      dsp::WelchSpectrum({waves.skin_m.data(), static_cast<std::size_t>(waves.rows())},
                         {.rate_hz = waves.rate_hz,
                          .segment_size = static_cast<std::size_t>(waves.rows()),
                          .detrend = dsp::Detrend::kNothing});
  if (!spectrum) return std::unexpected(spectrum.error());
  const std::vector<double> amplitudes_m = dsp::AmplitudeSpectrum(*spectrum);
  const double least_m = kLeastShown * std::ranges::max(amplitudes_m);
  plot::Series series{.title = {}, .style = plot::Lines(plot::kBlue), .x = {}, .y = {}};
  for (std::size_t k = 1; k < amplitudes_m.size(); ++k) {
    const double frequency_hz = static_cast<double>(k) * spectrum->grid.resolution_hz;
    if (frequency_hz > kShownPart * waves.rate_hz) break;
    series.x.push_back(frequency_hz);
    series.y.push_back(amplitudes_m[k] >= least_m && least_m > 0
                           ? amplitudes_m[k] / kUm
                           : std::numeric_limits<double>::quiet_NaN());
  }
  plot::Panel panel{
      fmt::format("spectrum of the skin, {:.3g} Hz apart (Hann)", spectrum->grid.resolution_hz),
      "frequency / Hz",
      "amplitude / um",
      {std::move(series)}};
  panel.log_axes = least_m > 0 ? plot::LogAxes::kY : plot::LogAxes::kNone;
  return panel;
}

}  // namespace

Result<std::vector<plot::Panel>> WaveformPanels(const sim::Waveforms& waves,
                                                const sim::Scene& scene) {
  std::vector<plot::Panel> panels{MotionPanel(waves, "the run", 0)};
  const double highest_hz = sim::HighestFrequencyHz(scene.drive);
  const auto shown =
      highest_hz > 0
          ? static_cast<Eigen::Index>(std::ceil(kShownPeriods * waves.rate_hz / highest_hz))
          : waves.rows();
  if (2 * shown < waves.rows() && sim::IsLasting(scene.drive)) {
    panels.push_back(MotionPanel(waves, "its end", waves.rows() - shown - 1));
  }
  panels.push_back(ElectricalPanel(waves));
  auto spectrum = SpectrumPanel(waves);
  if (!spectrum) return std::unexpected(spectrum.error());
  panels.push_back(std::move(*spectrum));
  return panels;
}

}  // namespace haptometer::tools
