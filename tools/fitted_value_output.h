#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "fit/drop_test_fit.h"

namespace haptometer::tools {

/// "  Ka   8200.00 +- 0.51 N/m (standard uncertainty 0.26, of which statistical 0.26)" with a line
/// end; the 95 % interval is taken as even. "not determined" where it is not, with its limit where
/// there is one.
[[nodiscard]] std::string FittedLine(std::string_view name, const fit::FittedValue& value);

/// {value, standard_uncertainty, combined_standard_uncertainty, lower_95, upper_95, at_most_95,
/// unit, determined}; the numbers are null where it is not determined, at_most_95 where it is.
[[nodiscard]] nlohmann::ordered_json FittedJson(const fit::FittedValue& value);

/// A title and below it the sentences, a line each; nothing where there are none.
[[nodiscard]] std::string SentenceSection(std::string_view title,
                                          const std::vector<std::string>& sentences);

}  // namespace haptometer::tools
