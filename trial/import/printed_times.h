#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "trial/import/stated_clock.h"
#include "trial/record.h"

namespace haptometer::trial {

/// The times of a table as they were printed, and what they say of the clock behind them.
class PrintedTimes {
 public:
  /// Room for `rows` times.
  void Reserve(std::size_t rows) { times_s_.reserve(rows); }

  /// Takes the next row's time: its text, and the seconds that it means; `factor`: seconds for one
  /// printed unit. Times must not fall.
  void Add(std::string_view printed, double time_s, double factor);

  /// Takes times as whole numbers of `factor` seconds, of which no digit is rounded.
  void AddCount(double time_s);

  [[nodiscard]] const std::vector<double>& times_s() const { return times_s_; }

  /// Times that are the same as the one before, as when too few digits are printed.
  [[nodiscard]] std::size_t repeated() const { return repeated_; }

  /// The rows by a clock that was stated beside them, where the printed digits explain how the
  /// times differ from it; it begins where it says, else at the start that fits the times best.
  /// Nothing where they do not, as when rows are missing.
  [[nodiscard]] std::optional<Stretch> By(const StatedClock& clock) const;

  /// Sets timing, stretches and raw times of `record`, whose rows are these (at least two).
  ///
  /// `timing`: kUniform for times that a clock made, others for times as they came. `stated`: the
  /// stretches that the file itself gives, used where they still describe the rows. Otherwise a
  /// grid where the printed digits explain the times (trial/import/printed_grid.h), else the mean
  /// line beside the times as they stand. False, and `record` is not to be used: times repeat and
  /// no grid explains it, or they lie closer than a rate can say.
  [[nodiscard]] bool Complete(Timing timing, std::vector<Stretch> stated, Record* record) &&;

 private:
  // how a time is rounded: places behind the point and digits that count
  struct Digits {
    int decimals = 0;
    int significant = 0;
  };
  [[nodiscard]] static Digits DigitsOf(std::string_view text);
  [[nodiscard]] bool Describe(std::span<const Stretch> stretches, Timing timing) const;
  [[nodiscard]] std::vector<Stretch> MeanLines(const Record& record) const;
  [[nodiscard]] double HalfDigit(double time_s) const;
  [[nodiscard]] std::vector<double> HalfDigits() const;

  std::vector<double> times_s_{};
  Digits most_{};  // a file prints a number of decimals or of digits, and drops zeros at the end
  double factor_ = 1;
  std::size_t repeated_ = 0;
  bool is_count_ = false;
};

}  // namespace haptometer::trial
