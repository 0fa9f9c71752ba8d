#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "fit/skin/skin_fit.h"

namespace haptometer::tools {

/// Reads drive sweeps out of a comma-separated table with names in its first line; a contact area
/// is a sweep of its own.
///
///   frequency_hz
///   displacement_amplitude_m | _mm | _um, or displacement_rms_m | _mm | _um
///   current_amplitude_a | _ma, or current_rms_a | _ma; else voltage_amplitude_v, voltage_rms_v
///   phase_deg                                  (optional) displacement against that drive
///   displacement_standard_uncertainty_m | _um  (optional) of the displacement column, in its kind
///   contact_area_mm2                           (optional)
///
/// Two tables of this program have names of their own:
///   amplitude_m_per_a or _per_v, phase_rad   of analyze --sweep --response
///   drive.frequency_hz, skin_rms_m, current_rms_a, skin.contact_area_m2 (optional)   of sweep,
///     whose phase_rad is the current's and passed over
///
/// RMS values count as amplitudes over sqrt(2). Where current and voltage both stand, the current
/// is taken: it needs neither R nor L. Errors (Cause::kCannotAnswer): the file's; a missing column
/// or two for one quantity, named with what would do; a cell that is no finite number, with its
/// line; a response to a drive that was not recorded; a table of sweep that varies anything else.
[[nodiscard]] Result<std::vector<fit::SkinSweep>> ReadSkinSweeps(const std::string& path);

}  // namespace haptometer::tools
