#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "trial/import/table/stated_clock.h"
#include "trial/record.h"

namespace haptometer::trial {

/// The times of a table as they were printed, and what they say of the clock behind them.
///
/// A printed time lies within its resolution of the time that was meant: half a unit of its last
/// digit, and what a 32-bit float leaves out, in which many exporters keep times,
///   2^-24 (max |t| + (t_last - t_first)),
/// once for the time and once for the product of row and interval in front of an offset. The latter
/// counts
///   - where every row's digits are those of a 32-bit float, of the time or of the time since the
///     first row, in the printed unit or a power of a thousand of it; digits of other numbers
///     contradict that in the first rows (with 9 digits at most one number in six passes);
///   - where it is below a thousandth of the mean interval, whatever the digits.
/// So jitter above a thousandth of an interval is found unless the file holds 32-bit floats; there
/// it is found above 1.2e-7 to 2.4e-7 of the record's length (1 % of an interval up to some 40 000
/// rows). A missing or a doubled row is a whole interval and found in any case.
class PrintedTimes {
 public:
  /// Room for `rows` times.
  void Reserve(std::size_t rows) { times_s_.reserve(rows); }

  /// The times that are added, and times_s(), count from `origin_s`: a double has no digits left
  /// for the differences of times since 1970. What the others take and give counts from 0.
  void CountFrom(double origin_s) { origin_s_ = origin_s; }
  [[nodiscard]] double origin_s() const { return origin_s_; }

  /// Takes the next row's time: its text, and the seconds that it means; `factor`: seconds for one
  /// printed unit. Times must not fall.
  void Add(std::string_view printed, double time_s, double factor);

  /// Takes times as whole numbers of `factor` seconds, of which no digit is rounded.
  void AddCount(double time_s, double factor = 1);

  [[nodiscard]] const std::vector<double>& times_s() const { return times_s_; }

  /// Rows whose time is that of the row before, as when too few digits are printed.
  [[nodiscard]] const std::vector<std::size_t>& repeated() const { return repeated_; }

  /// The rows by a clock that was stated beside them, where their resolution explains how the
  /// times differ from it; it begins where it says, else at the start that fits the times best.
  /// Nothing where they do not, as when rows are missing.
  [[nodiscard]] std::optional<Stretch> By(const StatedClock& clock) const;

  /// Sets timing, stretches, raw times and `rows` of `record`, whose rows are these (at least two),
  /// and gives the rows that it left out, which the caller takes from the channels.
  ///
  /// `timing`: kUniform for times that a clock made, others for times as they came. `stated`: the
  /// stretches that the file itself gives, used where they still describe the rows. Otherwise a
  /// grid where their resolution explains the times (trial/import/table/printed_times.cc), else the
  /// mean line beside the times as they stand. Of times that repeat without a grid that explains
  /// it, at most one row in a hundred is left out: a row that was written twice, or two readings
  /// with one time. `has_copies`: times repeat because rows were written twice, so that a grid
  /// through them explains nothing. Nothing, and `record` is not to be used: more of them do, or
  /// times lie closer than a rate can say.
  [[nodiscard]] std::optional<std::vector<std::size_t>> Complete(Timing timing,
                                                                 std::vector<Stretch> stated,
                                                                 bool has_copies,
                                                                 Record* record) &&;

 private:
  // how a time is rounded: places behind the point and digits that count
  struct Digits {
    int decimals = 0;
    int significant = 0;
  };
  [[nodiscard]] static Digits DigitsOf(std::string_view text);
  [[nodiscard]] bool Describe(std::span<const Stretch> stretches, Timing timing) const;
  [[nodiscard]] std::vector<Stretch> MeanLines(const Record& record) const;
  [[nodiscard]] bool HasFewRepeated() const;
  // the printed times of one magnitude, and half a unit of their last place
  struct Decade {
    double from = 0, below = 0;
    double half_s = 0;
  };
  [[nodiscard]] double HalfDigit(double time_s, Decade* decade) const;
  [[nodiscard]] bool MayBeFloats(double scale, bool is_since_first) const;
  [[nodiscard]] double FloatRounding() const;
  [[nodiscard]] std::vector<double> Resolutions(double rounding_s) const;
  [[nodiscard]] std::optional<std::vector<Stretch>> Grid() const;
  void MoveToOrigin(Record* record) const;

  std::vector<double> times_s_{};
  double origin_s_ = 0;
  Digits most_{};  // a file prints a number of decimals or of digits, and drops zeros at the end
  double factor_ = 1;
  std::vector<std::size_t> repeated_{};
  bool is_count_ = false;
};

}  // namespace haptometer::trial
