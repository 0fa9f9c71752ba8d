#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "trial/record.h"

namespace haptometer::trial {

/// The times of a table as they were printed, and what they say of the clock behind them.
class PrintedTimes {
 public:
  /// Takes the next row's time: its text, and the seconds that it means; `factor`: seconds for one
  /// printed unit. Times must grow.
  void Add(std::string_view printed, double time_s, double factor);

  [[nodiscard]] const std::vector<double>& times_s() const { return times_s_; }

  /// Sets timing, stretches and raw times of `record`, whose rows are these.
  ///
  /// `timing`: kUniform for times that a clock made, others for times as they came. `stated`: the
  /// stretches that the file itself gives, used where they still describe the rows. Otherwise a
  /// grid where the printed digits explain the times (trial/import/printed_grid.h), else the mean
  /// line beside the times as they stand.
  void Complete(Timing timing, std::vector<Stretch> stated, Record* record) &&;

 private:
  // how a time is rounded: places behind the point and digits that count
  struct Digits {
    int decimals = 0;
    int significant = 0;
  };
  [[nodiscard]] static Digits DigitsOf(std::string_view text);
  [[nodiscard]] bool Describe(std::span<const Stretch> stretches, Timing timing) const;
  [[nodiscard]] std::vector<double> HalfDigits() const;

  std::vector<double> times_s_{};
  std::vector<Digits> digits_{};
  double factor_ = 1;
};

}  // namespace haptometer::trial
