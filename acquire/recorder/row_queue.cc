#include "acquire/recorder/row_queue.h"

#include <chrono>
#include <utility>

namespace haptometer::acquire {

trial::Row RowBatch::RowOf(std::size_t row) const {
  const std::size_t channels = samples.size() / rows.size();
  trial::Row whole = rows[row];
  whole.samples = std::span(samples).subspan(row * channels, channels);
  return whole;
}

bool RowQueue::Push(const Reading& reading, MonotonicNs origin_ns) {
  const std::lock_guard lock(mutex_);
  if (given_up_ || batch_.rows.size() >= most_rows_) return false;
  batch_.rows.push_back({.index = reading.index,
                         .time_ns = reading.time_ns - origin_ns,
                         .reply_ns = reading.reply_ns - origin_ns,
                         .samples = {}});
  batch_.samples.insert(batch_.samples.end(), reading.samples.begin(), reading.samples.end());
  if (batch_.rows.size() == 1) arrived_.notify_one();
  return true;
}

void RowQueue::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  arrived_.notify_one();
}

bool RowQueue::Take(RowBatch& batch) {
  constexpr std::chrono::milliseconds kPatience(200);
  batch.rows.clear();
  batch.samples.clear();
  std::unique_lock lock(mutex_);
  arrived_.wait_for(lock, kPatience, [&] { return closed_ || !batch_.rows.empty(); });
  std::swap(batch, batch_);
  return !(closed_ && batch.rows.empty());
}

void RowQueue::GiveUp() {
  const std::lock_guard lock(mutex_);
  given_up_ = true;
}

}  // namespace haptometer::acquire
