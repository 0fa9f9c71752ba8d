#pragma once

#include <cstddef>
#include <span>

#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::trial {

/// One channel in packed rows: where its value and its status lie in a row, and what they mean.
///
///   value = raw scale + offset
struct RowColumn {
  Encoding encoding = Encoding::kI32;
  std::size_t row_bytes = 0;
  std::size_t value_at = 0;
  std::size_t status_at = 0;
  double scale = 1;
  double offset = 0;

  /// Values (NaN where there is no measurement) and statuses of the first rows at `rows`, as many
  /// as either span has. A status of a later version is kInvalid. Rows of up to eight bytes are
  /// decoded eight at a time where the processor knows AVX2, to the same values.
  void Decode(std::span<const std::byte> rows, std::span<double> values,
              std::span<SampleStatus> statuses) const;
};

}  // namespace haptometer::trial
