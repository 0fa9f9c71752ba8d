#pragma once

#include <string>
#include <vector>

#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// A curve over frequency.
struct FrequencyCurve {
  std::vector<double> hertz;  ///< ascending
  std::vector<double> values;
};

/// The points of a sweep and the fit through them.
[[nodiscard]] plot::Panel SweepPanel(std::string title, std::string label,
                                     const FrequencyCurve& measured, const FrequencyCurve& fitted,
                                     plot::LogAxes axes);

/// What a fit leaves of one quantity of a sweep.
struct SweepResiduals {
  std::string title;  ///< in the key; empty: not listed
  std::vector<double> values;
};

/// What a fit leaves at the points of a sweep, at most two quantities.
[[nodiscard]] plot::Panel SweepResidualPanel(std::string title, std::string label,
                                             const std::vector<double>& hertz,
                                             const std::vector<SweepResiduals>& residuals,
                                             plot::LogAxes axes);

}  // namespace haptometer::tools
