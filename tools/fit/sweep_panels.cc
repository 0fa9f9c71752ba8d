#include "tools/fit/sweep_panels.h"

#include <fmt/core.h>

#include <array>
#include <utility>

#include "base/error.h"

namespace haptometer::tools {
namespace {

plot::Style SweepPoints(plot::Colour colour) { return plot::Points(colour, 0.4); }

}  // namespace

plot::Panel SweepPanel(std::string title, std::string label, const FrequencyCurve& measured,
                       const FrequencyCurve& fitted, plot::LogAxes axes) {
  return {std::move(title),
          "frequency / Hz",
          std::move(label),
          {{"sweep", SweepPoints(plot::kOrange), measured.hertz, measured.values},
           {"fit", plot::Lines(plot::kBlue), fitted.hertz, fitted.values}},
          axes};
}

plot::Panel SweepResidualPanel(std::string title, std::string label,
                               const std::vector<double>& hertz,
                               const std::vector<SweepResiduals>& residuals, plot::LogAxes axes) {
  constexpr std::array kColours{plot::kOrange, plot::kBlue};
  HAPTOMETER_CHECK(residuals.size() <= kColours.size(), "{} quantities", residuals.size());
  plot::Panel panel{std::move(title), "frequency / Hz", std::move(label), {}, axes};
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    panel.series.push_back(
        {residuals[k].title, SweepPoints(kColours[k]), hertz, residuals[k].values});
  }
  return panel;
}

}  // namespace haptometer::tools
