#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::tools {

/// A mass in kg as people say it.
[[nodiscard]] fit::FittedValue InGrams(fit::FittedValue kilograms);

/// A value and its 95 % interval, each for a cell: "8200.00" and "+- 0.51", of a lopsided one both
/// ends, "0.72 to 1.25". "not determined" and, where there is one, the upper limit.
struct FittedCells {
  std::string value;
  std::string interval;
};
[[nodiscard]] FittedCells CellsOf(const fit::FittedValue& value);

/// "  Ka   8200.00 +- 0.51 N/m" with a line end; of a lopsided interval both ends, "1.00, 0.72 to
/// 1.25 N/A". "at most" and the limit, or "not determined", where it is not.
[[nodiscard]] std::string FittedLine(std::string_view name, const fit::FittedValue& value);

/// {value, standard_uncertainty, combined_standard_uncertainty, lower_95, upper_95, at_most_95,
/// unit, determined}; the numbers are null where it is not determined, at_most_95 where it is.
[[nodiscard]] nlohmann::ordered_json FittedJson(const fit::FittedValue& value);

/// A title and below it the sentences, a line each; nothing where there are none.
[[nodiscard]] std::string SentenceSection(std::string_view title,
                                          const std::vector<std::string>& sentences);

}  // namespace haptometer::tools
