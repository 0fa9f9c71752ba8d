#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// Whether a row holds a measurement: its status says so and its value is a finite number.
[[nodiscard]] inline bool IsMeasured(double value, trial::SampleStatus status) {
  return trial::IsMeasurement(status) && std::isfinite(value);
}

/// Whether every status is kOk: the rule in a record, and told in a fraction of the time that a
/// look at each row takes.
[[nodiscard]] bool AllOk(std::span<const trial::SampleStatus> statuses);

/// Whether every value is a finite number.
[[nodiscard]] bool AllFinite(std::span<const double> values);

/// Calls visit(k, value, status) for each row first + k, k < size, of a channel.
/// Errors: as RowSource::Read. Memory: 2^16 rows.
template <typename Visit>
Result<void> ForEachValue(const trial::RowSource& source, std::size_t channel, std::size_t first,
                          std::size_t size, const Visit& visit) {
  std::vector<double> values(std::min(size, std::size_t{1} << 16U));
  std::vector<trial::SampleStatus> statuses(values.size());
  for (std::size_t done = 0; done < size; done += values.size()) {
    const std::size_t count = std::min(values.size(), size - done);
    HAPTOMETER_TRY(source.Read(channel, first + done, std::span(values).first(count),
                               std::span(statuses).first(count)));
    for (std::size_t k = 0; k < count; ++k) visit(done + k, values[k], statuses[k]);
  }
  return {};
}

/// Rows [begin, end).
struct RowRange {
  std::size_t begin = 0;
  std::size_t end = 0;

  [[nodiscard]] std::size_t rows() const { return end - begin; }
};

/// Rows [first_row, end_row) of a channel, and some on either side that help to judge them.
struct RowBlock {
  std::size_t first_row = 0;
  std::size_t end_row = 0;
  std::size_t record_rows = 0;  ///< of the whole record
  std::size_t held_first = 0;   ///< the row of held_values[0]
  std::span<const double> held_values;
  std::span<const trial::SampleStatus> held_statuses;
  bool all_ok = false;  ///< every row held is measured and says kOk

  [[nodiscard]] std::size_t rows() const { return end_row - first_row; }
  [[nodiscard]] std::size_t held_end() const { return held_first + held_values.size(); }
  /// The block's own rows.
  [[nodiscard]] std::span<const double> values() const {
    return held_values.subspan(first_row - held_first, rows());
  }
  [[nodiscard]] std::span<const trial::SampleStatus> statuses() const {
    return held_statuses.subspan(first_row - held_first, rows());
  }
  /// Whether rows [begin, end), held, are all measured and say kOk.
  [[nodiscard]] bool AllOkWithin(std::size_t begin, std::size_t end) const {
    return all_ok || (AllOk(held_statuses.subspan(begin - held_first, end - begin)) &&
                      AllFinite(held_values.subspan(begin - held_first, end - begin)));
  }
};

}  // namespace haptometer::dsp
