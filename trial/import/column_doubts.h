#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "trial/import/csv_column.h"

namespace haptometer::trial {

/// A sentence for each column whose unit the command line (`read`) states otherwise than the file
/// (`said`); none where their counts differ.
[[nodiscard]] std::vector<std::string> OverriddenUnits(const std::vector<CsvColumn>& said,
                                                       const std::vector<CsvColumn>& read);

/// The column, from 1 on, but for `except`, whose values in the first eight lines of `rows` grow in
/// steps equal to 5 %, as times do; 0: none. For a message about times that do not grow.
[[nodiscard]] std::size_t EvenColumn(std::string_view rows, char separator, std::size_t except);

}  // namespace haptometer::trial
