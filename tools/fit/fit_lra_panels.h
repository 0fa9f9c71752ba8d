#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "tools/fit/fit_lra_input.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {

/// Panels that belong together, and what a reader should see in them.
struct FitFigure {
  std::string caption;
  std::vector<plot::Panel> panels;
};

/// A figure a record and one of the poles.
///
/// A record: its samples (grey: not used) under the fit with the impact and the fit's begin marked,
/// the same close to the impact, the residual in units of the noise before the impact (of its own
/// RMS where nothing precedes it), the spectra of record and residual. The poles: decay rate over
/// damped frequency with the 95 % region of both together, a panel for each pole that records
/// share, and the starts of those records; a record that does not oscillate has none.
///
/// `left_out` and, where the fit has not converged, all records are drawn without any fit, and the
/// title says why. However long a record is, a panel holds 6000 points of it. `records` are those
/// of `fit`. Memory: 16 B a sample.
[[nodiscard]] std::vector<FitFigure> FitLraFigures(const fit::DropTestFit& fit,
                                                   const std::vector<fit::ImpulseRecord>& records,
                                                   const std::vector<LeftOutDrop>& left_out);

/// Drops that could not be fitted at all, a panel each; the title says why.
[[nodiscard]] std::vector<FitFigure> UnfittedFigures(const std::vector<LeftOutDrop>& drops);

/// All panels of `figures` one below the other. Errors: see plot::DrawPanels.
[[nodiscard]] Result<void> DrawFigures(const std::string& path,
                                       const std::vector<FitFigure>& figures);

}  // namespace haptometer::tools
