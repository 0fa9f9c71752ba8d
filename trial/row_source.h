#pragma once

#include <cstddef>
#include <span>

#include "base/result.h"
#include "trial/record.h"

namespace haptometer::trial {

/// The rows of a recording, read by range: of a record in memory, or of a file far larger than it.
///
/// Threads may read at the same time.
class RowSource {
 public:
  virtual ~RowSource() = default;

  /// All of the record but its columns: rows, timing, stretches, metadata, and channels whose
  /// values and statuses are empty.
  [[nodiscard]] virtual const Record& head() const = 0;

  /// Values (NaN where there is no measurement) and statuses of rows [first, first + size) of
  /// channel number `channel`; both spans have that size, within head().rows.
  /// Errors: the file cannot be read any more, or was changed since (Cause::kFailed).
  [[nodiscard]] virtual Result<void> Read(std::size_t channel, std::size_t first,
                                          std::span<double> values,
                                          std::span<SampleStatus> statuses) const = 0;
};

/// A record in memory as a source of rows; the record must outlive it. No allocation in Read.
class RecordRows final : public RowSource {
 public:
  explicit RecordRows(const Record& record);

  [[nodiscard]] const Record& head() const override { return head_; }
  [[nodiscard]] Result<void> Read(std::size_t channel, std::size_t first, std::span<double> values,
                                  std::span<SampleStatus> statuses) const override;

 private:
  const Record& record_;
  Record head_;
};

}  // namespace haptometer::trial
