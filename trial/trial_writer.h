#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "trial/byte_io.h"
#include "trial/trial_format.h"

namespace haptometer::trial {

/// One row on its way to disk. Which of the times counts is said by the header's timing.
struct Row {
  std::int64_t index = 0;     ///< kUniform: place on the grid, larger than the last row's, >= 0
  std::int64_t time_ns = 0;   ///< kArrival: arrival; kPolled: request. Since the trial's start
  std::int64_t reply_ns = 0;  ///< kPolled: reply (or the deadline that passed)
  std::span<const Sample> samples{};  ///< one a channel, in the header's order
};

struct WriterOptions {
  /// Rows wait in memory at most this long, and this much is lost at most when the process dies.
  double flush_interval_s = 1;
  /// true: an existing file at the path is replaced.
  bool overwrite = false;
};

/// Writes one trial.bin: header, rows in blocks, events, closing totals. Append-only; whatever
/// moment the process dies at, every block that was flushed is read back (trial/trial_reader.h).
///
/// One thread at a time. Rows cost one copy each; the buffer is allocated once. After an error the
/// writer stays in error: every later call returns it again, and the file is cut behind its last
/// whole block. A file that another program cuts or deletes meanwhile is such an error; one that is
/// moved is written to the end.
class TrialWriter {
 public:
  /// Makes the file at `path`, writes its header and flushes it.
  ///
  /// Programmer's errors: no channel, more than kMaxChannels, a scale that is not finite, a uniform
  /// timing without a rate. Errors: Cause::kUsage when the file exists and options.overwrite is
  /// false, and for a text of the header that is not printable; Cause::kFailed when it cannot be
  /// made or written. `clock` must outlive the writer.
  [[nodiscard]] static Result<TrialWriter> Create(const std::string& path, TrialHeader header,
                                                  WriterOptions options, Clock& clock);

  /// The same into any sink; `name` stands for the path in messages.
  [[nodiscard]] static Result<TrialWriter> CreateIn(std::unique_ptr<ByteSink> sink,
                                                    std::string name, TrialHeader header,
                                                    WriterOptions options, Clock& clock);

  TrialWriter(TrialWriter&&) noexcept;
  TrialWriter& operator=(TrialWriter&&) noexcept;
  /// Does not finish the file: a trial that was not finished says so when it is read.
  ~TrialWriter();

  /// Adds a row. Writes when a block is full or the flush interval has passed.
  /// Programmer's errors: a wrong number of samples, an index that does not grow.
  /// Errors: Cause::kFailed, naming how many rows are safe.
  [[nodiscard]] Result<void> Append(const Row& row);

  /// Adds an event after the rows so far (event.row is filled in) and hands both to the system; the
  /// next flush syncs them.
  [[nodiscard]] Result<void> AddEvent(Event event);

  /// Flushes when the flush interval has passed since the last flush; call it while no rows come.
  [[nodiscard]] Result<void> FlushIfDue();

  /// Writes the rows that wait and syncs the file.
  [[nodiscard]] Result<void> Flush();

  /// Flushes, writes the closing totals, syncs and closes. The writer takes no more rows.
  [[nodiscard]] Result<TrialTotals> Finish();

  [[nodiscard]] const TrialHeader& header() const;
  [[nodiscard]] const TrialTotals& totals() const;

 private:
  struct State;
  explicit TrialWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Appends `event` to a trial that exists, finished or cut short: labels given later, a remark.
///
/// Nothing that the file holds is changed. event.row is filled in. Errors: as TrialReader::Open;
/// Cause::kCannotAnswer when the file may not be written; Cause::kFailed when it is still being
/// recorded or the disk is full. Cost: reads the file once; one sync.
[[nodiscard]] Result<void> AppendEvent(const std::string& path, Event event);

}  // namespace haptometer::trial
