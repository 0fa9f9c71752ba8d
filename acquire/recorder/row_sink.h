#pragma once

#include <utility>

#include "base/error.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

namespace haptometer::acquire {

/// Where a recording's rows go: one trial, or one after the other (recorder/trial_rotation.h).
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

}  // namespace haptometer::acquire
