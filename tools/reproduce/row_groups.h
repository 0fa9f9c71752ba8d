#pragma once

#include <vector>

#include "base/error.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_row.h"

namespace haptometer::tools {

// The rows of the thesis, computed anew from the model by each call, a function in the file of its
// name.

/// Table 2.3, and the ratio of 2.2.2.
[[nodiscard]] std::vector<ThesisRow> DisplacementRows(const ThesisModel& model);
/// Current, power, phase, and what the adapter saves (2.2.1, 2.2.2).
[[nodiscard]] std::vector<ThesisRow> ElectricalRows(const ThesisModel& model);
/// Table 2.4 by the grid and without steps; 4.1's power transfer.
[[nodiscard]] std::vector<ThesisRow> OptimumRows(const ThesisModel& model);
/// Resonance, Figures 2.4 and 2.5.
[[nodiscard]] std::vector<ThesisRow> FrequencyRows(const ThesisModel& model);
/// Figure 2.3.
[[nodiscard]] std::vector<ThesisRow> RiseRows(const ThesisModel& model);
/// Figures 2.6 and 2.7.
[[nodiscard]] std::vector<ThesisRow> ReceptorRows(const ThesisModel& model);
/// Weight and sag, prototypes as built, the gain at 175 Hz, power, travel, contact: what the model
/// says of chapter 3.
[[nodiscard]] std::vector<ThesisRow> PrototypeRows(const ThesisModel& model);

}  // namespace haptometer::tools
