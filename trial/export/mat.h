#pragma once

#include <memory>
#include <string>

#include "base/error.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A MATLAB file (version 5, no compression) that takes trials, a struct each: columns `time_s`,
/// one a channel (double, SI, NaN where there is no measurement) and `COLUMN_status` (uint8), named
/// as in a CSV; `raw_time_s` where the source's times lie on no grid; `stretches`; and the texts
/// `header_json`, `events_json` (a line an event). Values, statuses and times keep their bits and
/// the metadata is whole; what the source sent in counts is not kept.
class MatWriter {
 public:
  /// Makes the file at `path`, replacing one that is there. Errors (Cause::kFailed): it cannot be
  /// made.
  [[nodiscard]] static Result<MatWriter> Create(const std::string& path);

  MatWriter(MatWriter&&) noexcept;
  MatWriter& operator=(MatWriter&&) noexcept;
  ~MatWriter();

  /// Adds `recording` as the variable `name`, a MATLAB identifier of at most 63 characters that is
  /// new. Errors: Cause::kCannotAnswer for more than 2 GiB; Cause::kFailed when it is not written.
  [[nodiscard]] Result<void> Add(const std::string& name, const Recording& recording);

  /// Closes the file and checks by the lengths in it that all of it was written: libmatio looks at
  /// no write's outcome. Errors (Cause::kFailed): the disk is full.
  [[nodiscard]] Result<void> Close();

 private:
  struct State;
  explicit MatWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace haptometer::trial
