#pragma once

#include <vector>

#include "fit/impedance/impedance_fit.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// Magnitudes and phases of a sweep with the fit, between the points too, and what the fit leaves
/// of both, in units of a point's noise. `points` are those of `fit`, in any order.
[[nodiscard]] std::vector<plot::Panel> ImpedancePanels(const fit::ImpedanceFit& fit,
                                                       std::vector<fit::ImpedancePoint> points);

}  // namespace haptometer::tools
