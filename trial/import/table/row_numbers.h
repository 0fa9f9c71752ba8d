#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "trial/findings.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Whether a first column called `name` numbers the rows: "Sample", "No.", "Nr", "Index", "Point",
/// "#" and the like, or "", as pandas leaves it.
[[nodiscard]] bool IsRowNumberName(std::string_view name);

/// The numbers of the rows of a table without times: 1, 2, 3 ... or any even steps. Where they jump
/// by whole steps, rows are missing.
class RowNumbers {
 public:
  /// The number of the next row, which stands in `line`; NaN: none. Memory: only where the steps
  /// change.
  void Add(double number, std::size_t line);

  /// `whole`, all rows at one rate, divided where numbers jump, with time for the missing rows. The
  /// step is the most frequent one. Notes how many rows are missing; numbers that do not grow by
  /// whole steps, or jump at more than a tenth of the rows as times in whole units do, are a doubt,
  /// and change nothing.
  [[nodiscard]] std::vector<Stretch> Divide(const Stretch& whole, Findings* findings) const;

 private:
  // rows that follow the row before by the same step
  struct Run {
    std::size_t first_row = 0;
    std::size_t rows = 0;
    std::size_t line = 0;  // of its first row
    double step = 0;
  };
  [[nodiscard]] double UsualStep() const;

  std::vector<Run> runs_;
  std::size_t rows_ = 0;
  double last_ = 0;
  std::size_t bad_line_ = 0;  // the first whose number is not above the one before; 0: none
};

}  // namespace haptometer::trial
