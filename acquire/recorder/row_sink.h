#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "base/clock.h"
#include "base/error.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

namespace haptometer::acquire {

/// Where a recording's rows go: one trial, or one after the other (TrialRotation).
/// Called by the writing thread alone, in the order of trial::TrialWriter, whose errors it hands
/// on.
class RowSink {
 public:
  virtual ~RowSink() = default;
  [[nodiscard]] virtual Result<void> Append(const trial::Row& row) = 0;
  [[nodiscard]] virtual Result<void> AddEvent(trial::Event event) = 0;
  [[nodiscard]] virtual Result<void> FlushIfDue() = 0;
  [[nodiscard]] virtual Result<void> Finish() = 0;
};

/// One trial.
class SingleTrial final : public RowSink {
 public:
  /// `writer` must outlive the sink.
  explicit SingleTrial(trial::TrialWriter& writer) : writer_(writer) {}
  [[nodiscard]] Result<void> Append(const trial::Row& row) override { return writer_.Append(row); }
  [[nodiscard]] Result<void> AddEvent(trial::Event event) override {
    return writer_.AddEvent(std::move(event));
  }
  [[nodiscard]] Result<void> FlushIfDue() override { return writer_.FlushIfDue(); }
  [[nodiscard]] Result<void> Finish() override {
    const auto totals = writer_.Finish();
    return totals ? Result<void>{} : std::unexpected(totals.error());
  }

 private:
  trial::TrialWriter& writer_;
};

/// When a trial is closed and the next one begun; where neither is set, never.
struct RotationLimits {
  std::optional<MonotonicNs> duration_ns{};  ///< by the rows' own times
  std::optional<std::uint64_t> bytes{};      ///< of rows, as stored
};

/// One trial after the other, without losing a row between them. Each is complete in itself: its
/// times count from its first row, its header says which part it is (`part`), when it began on the
/// recording's own clock (`part_start_s`) and which file it continues (`continues`).
class TrialRotation final : public RowSink {
 public:
  /// Names the file of part 1, 2, 3, ...
  using NamePart = std::function<std::string(std::uint64_t part)>;

  /// Begins part 1. `clock` must outlive the rotation. Errors: those of TrialWriter::Create.
  [[nodiscard]] static Result<std::unique_ptr<TrialRotation>> Begin(
      NamePart name, trial::TrialHeader header, RotationLimits limits, Clock& clock,
      trial::WriterOptions options = {});

  [[nodiscard]] Result<void> Append(const trial::Row& row) override;
  [[nodiscard]] Result<void> AddEvent(trial::Event event) override;
  [[nodiscard]] Result<void> FlushIfDue() override { return writer_->FlushIfDue(); }
  [[nodiscard]] Result<void> Finish() override;

  /// Begins the next part with the next row, whatever the limits say. Any thread.
  void RotateAtNextRow() { is_asked_.store(true); }

  /// The file that is being written. Any thread.
  [[nodiscard]] std::string file() const;

 private:
  TrialRotation(NamePart name, trial::TrialHeader header, RotationLimits limits, Clock& clock,
                trial::WriterOptions options);
  [[nodiscard]] Result<void> BeginPart(const trial::Row* first);
  [[nodiscard]] bool IsDue(const trial::Row& row);

  NamePart name_;
  trial::TrialHeader header_;
  RotationLimits limits_;
  Clock& clock_;
  trial::WriterOptions options_;
  std::uint64_t row_bytes_;
  std::optional<trial::TrialWriter> writer_;
  std::atomic<bool> is_asked_{false};  ///< to rotate
  mutable std::mutex file_mutex_;
  std::string file_;
  std::uint64_t part_ = 0;
  std::uint64_t rows_ = 0;    ///< of this part
  MonotonicNs start_ns_ = 0;  ///< of this part, on the recording's clock
  std::int64_t start_index_ = 0;
};

}  // namespace haptometer::acquire
