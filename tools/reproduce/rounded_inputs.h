#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/reproduce/thesis_model.h"
#include "tools/reproduce/thesis_row.h"

namespace haptometer::tools {

/// A row's number as a function of the model.
struct RowMeasure {
  std::string_view key;  ///< of its ThesisNumber
  std::function<double(const ThesisModel& model)> measure;
};

/// What becomes of rows when the printed inputs of the simulation are not their printed values but
/// numbers that round to them: one set of inputs for all the rows, sought so that each comes to
/// what is printed.
///
/// Inputs: Mv, Mc, Kv, Bv, Km, R, L (Table 2.1), Ma1, Ma2, Ka, Ba (Table 2.4), the ends of Ks and
/// Bs (2.1.1), each within half a unit of its last printed digit, stiffnesses within 50 N/m. Drive
/// and contact areas are settings and stay.
///
/// The search is that of Gauss and Newton within these bounds, from the printed values and then
/// from seven places spread over them, on the rows' distances from their printed intervals;
/// derivatives are differences over a thousandth of a bound. It is deterministic, and what it finds
/// is evaluated by the model itself. That it finds nothing is no proof that there is nothing. Cost:
/// at most 8 searches of 12 steps of 40 evaluations of each row.
///
/// @return one cause a row, in the order of `rows`, of kind kRounding, which names the inputs
[[nodiscard]] std::vector<CandidateCause> FromRoundedInputs(const ThesisModel& model,
                                                            std::span<const RowMeasure> rows);

/// Adds to each of `rows` that one of `measures` is of, and that is not reproduced, the cause that
/// is found for it alone.
void ExplainByRounding(const ThesisModel& model, const std::vector<RowMeasure>& measures,
                       std::vector<ThesisRow>* rows);

}  // namespace haptometer::tools
