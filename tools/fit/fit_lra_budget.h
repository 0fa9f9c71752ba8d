#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::tools {

/// Kv, Bv and Km with their symbols, in this order.
[[nodiscard]] std::array<std::pair<std::string_view, const fit::FittedValue*>, 3> ConstantsOf(
    const fit::DropTestFit& fit);

/// A cause of uncertainty and its standard uncertainties in percent of Kv, Bv and Km; absent for
/// what is not determined.
struct BudgetRow {
  std::string cause;      ///< "moving mass 1.4 g +- 0.03 g"
  std::string_view type;  ///< "A", "B" (JCGM 100:2008); empty: of all causes together
  std::array<std::optional<double>, 3> percent;
};

/// What the records' noise makes (type A), what each given number makes (type B), what is not
/// determined, and all together. A cause that moves nothing is left out; without any determined
/// constant there is no row.
[[nodiscard]] std::vector<BudgetRow> BudgetOf(const fit::DropTestFit& fit);

/// Correlation coefficients of Kv, Bv and Km, all causes together; absent for what is not
/// determined.
[[nodiscard]] std::array<std::array<std::optional<double>, 3>, 3> CorrelationOf(
    const fit::DropTestFit& fit);

/// A percentage of a budget, two digits; "-" where it is absent or below 1e-6.
[[nodiscard]] std::string PercentText(const std::optional<double>& percent);

/// In the unit that people say: "1.4 g" of 0.0014 "kg".
[[nodiscard]] std::string InSpokenUnit(double value, const std::string& unit);

}  // namespace haptometer::tools
