#pragma once

#include <string>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/impedance/impedance_fit.h"
#include "tools/document/document.h"
#include "tools/fit/drop_records.h"

namespace haptometer::tools {

/// "open", "33 ohm".
[[nodiscard]] std::string LoadText(double load_ohm);

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
[[nodiscard]] std::vector<document::Figure> FitLraFigures(
    const fit::DropTestFit& fit, const std::vector<fit::ImpulseRecord>& records,
    const std::vector<fit::LeftOutDrop>& left_out);

/// Drops that could not be fitted at all, a panel each; the title says why.
[[nodiscard]] std::vector<document::Figure> UnfittedFigures(
    const std::vector<fit::LeftOutDrop>& drops);

/// Magnitudes and phases of a sweep with the fit, between the points too, and what the fit leaves
/// of both, in units of a point's noise.
[[nodiscard]] std::vector<plot::Panel> ImpedancePanels(const fit::ImpedanceFit& fit);

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
