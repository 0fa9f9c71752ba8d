#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/readings/faults.h"
#include "dsp/readings/raw_summary.h"
#include "dsp/readings/row_block.h"
#include "dsp/readings/segments.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// Rows of a channel that are read in one go: a multiple of kFaultBlockRows.
inline constexpr std::size_t kPassRows = std::size_t{1} << 16U;

/// A value that stands for "no reading", such as -99.998 mm, and what it means.
struct NoReadingCode {
  double value = 0;
  trial::SampleStatus status = trial::SampleStatus::kInvalid;
  std::size_t rows = 0;  ///< that hold it
};

/// The rows of a source with a place for each that is absent, and without those of a channel that
/// are no measurement.
///
/// Stretches on one clock, with a whole number of rows between them (to a tenth of one), are one
/// stretch, and so are those of a stream that counts its readings; absent rows have no value and
/// the status kLate. No more rows are added than there are.
class CleanRows final : public trial::RowSource {
 public:
  /// `source` must outlive it.
  CleanRows(const trial::RowSource& source, std::size_t channel);

  [[nodiscard]] const trial::Record& head() const override { return head_; }
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<trial::SampleStatus> statuses) const override;

  /// The row of the source, or the next one behind an absent row; its number of rows behind all.
  [[nodiscard]] std::size_t RowOf(std::size_t row) const;
  /// Whether the source has no such row.
  [[nodiscard]] bool IsAbsent(std::size_t row) const;
  /// Whether rows are absent.
  [[nodiscard]] bool AnyAbsent() const { return parts_.size() > 1 && head_.rows > source_rows_; }

  /// Values of the channel that are no measurement.
  void ExcludeValues(std::vector<NoReadingCode> codes) { codes_ = std::move(codes); }
  /// Rows of the channel that are no measurement, in order: kInvalid.
  void ExcludeRows(std::vector<RowRange> rows) { excluded_ = std::move(rows); }

 private:
  // rows of the source that follow each other
  struct Part {
    std::size_t first_row = 0;  // here
    std::size_t source_row = 0;
    std::size_t rows = 0;
  };
  [[nodiscard]] const Part& PartOf(std::size_t row) const;
  void Join(const std::vector<trial::Stretch>& stretches);
  void Exclude(std::size_t first, std::span<double> values,
               std::span<trial::SampleStatus> statuses) const;

  const trial::RowSource& source_;
  std::size_t channel_;
  std::size_t source_rows_;
  trial::Record head_;
  std::vector<Part> parts_;
  std::vector<NoReadingCode> codes_;
  std::vector<RowRange> excluded_;
};

/// A channel without its artifacts, and what was found of them. Rows count as `rows` counts them.
struct CleanChannel {
  std::unique_ptr<CleanRows> rows;
  Segments segments{};
  RawSummary summary{};  ///< of what is left
  Faults faults{};
  std::vector<NoReadingCode> codes{};
};

/// Takes artifacts out of channel number `channel`: absent rows, codes, spikes and held readings
/// become missing values, and what is left falls into segments (SplitAtHoles).
///
/// A code is the highest or the lowest value, or several of them, behind a gap that is larger than
/// all that the other values span, and
///   - its digits are four nines or more, the last one an eight or a nine ("-99.998", "999.99"), as
///     Keyence, Micro-Epsilon and others write, in whatever unit; or
///   - the gap is larger than 50 mm; or
///   - it is there three times and more, the others are not all alike, and the gap is ten times
///     what they span: a rail;
/// and less than half of the rows hold one.
/// Motion comes to its extremes through values between; two levels without noise, as of a square
/// wave, are no code, because what one leaves spans nothing.
/// `threads` blocks are read at a time and change nothing. Errors: as RowSource::Read.
/// Cost: one pass; one more where there are codes, and where there are spikes or held readings.
[[nodiscard]] Result<CleanChannel> Clean(const trial::RowSource& source, std::size_t channel,
                                         int threads = 1);

}  // namespace haptometer::dsp
