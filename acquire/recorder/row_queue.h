#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "trial/trial_writer.h"

namespace haptometer::acquire {

/// Rows on their way from the reading to the writing thread, in flat arrays.
struct RowBatch {
  std::vector<trial::Row> rows;        ///< `samples` is not set; see RowOf
  std::vector<trial::Sample> samples;  ///< (rows x channels)

  /// Row `row` with its samples.
  [[nodiscard]] trial::Row RowOf(std::size_t row) const;
};

/// A bounded queue between the one thread that reads a sensor and the one that writes its trial.
///
/// Flushing to a slow disk takes seconds at times, and what the kernel keeps for a port meanwhile
/// is 0.7 s at 921600 baud (64 KiB) before it drops bytes. So the reader must never wait for the
/// disk: it only appends here, and the writer takes everything at once by a swap.
class RowQueue {
 public:
  explicit RowQueue(std::size_t most_rows) : most_rows_(most_rows) {}

  /// Adds a row whose times count from `origin_ns`. False when the queue is full, or the writer has
  /// given up.
  [[nodiscard]] bool Push(const Reading& reading, MonotonicNs origin_ns);

  /// No row comes any more.
  void Close();

  /// Takes all rows into `batch` (emptied first), waiting a fifth of a second for the first. False
  /// once the queue is closed and empty.
  [[nodiscard]] bool Take(RowBatch& batch);

  /// The writer cannot go on; Push() is false from now on.
  void GiveUp();

 private:
  const std::size_t most_rows_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  RowBatch batch_;
  bool closed_ = false;
  bool given_up_ = false;
};

}  // namespace haptometer::acquire
