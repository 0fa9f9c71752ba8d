#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/impedance/impedance_model.h"

namespace haptometer::tools {

/// A sweep that an analyser, an LCR meter or a person has written.
struct ImpedanceTable {
  std::vector<fit::ImpedancePoint> points;  ///< (rows)
  /// "'Freq [kHz]' as the frequency in kHz, ...": what was taken as what; empty where the names are
  /// frequency_hz, impedance_ohm and phase_deg, or frequency, ohm and degrees.
  std::string columns;
};

/// Reads frequencies, and magnitudes with phases or real with imaginary parts, out of a table
/// (tools/study/text_table.h) with any of the names of docs/reference/fit-impedance.md.
///
/// A unit stands behind its name, in brackets, after a slash, a blank or an underscore: "|Z|
/// (ohm)", "Freq [kHz]", "theta/rad", "phase_deg". Upper and lower case are alike but for a leading
/// M, which is mega. A frequency without a unit is in Hz; the others need one.
///
/// Errors (Cause::kCannotAnswer), with the columns found: the table's, a quantity that is missing,
/// that two columns may be, or that has no unit or one that is not its own (dB); both pairs; a row
/// whose frequency or magnitude is not positive.
[[nodiscard]] Result<ImpedanceTable> ReadImpedanceTable(const std::string& path);

}  // namespace haptometer::tools
