#pragma once

#include <cstddef>
#include <span>

#include "base/error.h"
#include "trial/record.h"

namespace haptometer::trial {

/// The rows of a recording, read by range: of a record in memory, or of a file far larger than it.
///
/// Threads may read at the same time.
class RowSource {
 public:
  virtual ~RowSource() = default;

  /// All of the record but its columns: rows, timing, stretches, metadata, and channels whose
  /// values and statuses are empty. Raw times are there only where they are known
  /// (Record::times_are_known).
  [[nodiscard]] virtual const Record& head() const = 0;

  /// Values (NaN where there is no measurement) and statuses of rows [first, first + size) of
  /// channel number `channel`; both spans have that size, within head().rows.
  /// Errors: the file cannot be read any more, or was cut shorter since (Cause::kFailed).
  [[nodiscard]] virtual Result<void> Read(std::size_t channel, std::size_t first,
                                          std::span<double> values,
                                          std::span<SampleStatus> statuses) const = 0;
};

/// All of `source` in memory: its head with the columns filled in. Errors: as RowSource::Read.
[[nodiscard]] Result<Record> ReadAllRows(const RowSource& source);

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
