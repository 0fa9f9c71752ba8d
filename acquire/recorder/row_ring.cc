#include "acquire/recorder/row_ring.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace haptometer::acquire {

RowRing::RowRing(std::size_t bytes, std::size_t channels)
    : channels_(channels),
      capacity_(std::max<std::size_t>(1, bytes / (sizeof(Slot) + channels * 9))),
      slots_(std::make_unique_for_overwrite<Slot[]>(capacity_)),
      bits_(std::make_unique_for_overwrite<std::uint64_t[]>(capacity_ * channels)),
      status_(std::make_unique_for_overwrite<trial::SampleStatus[]>(capacity_ * channels)),
      front_(channels) {}

std::size_t RowRing::room() const {
  return events_waiting_.load(std::memory_order_acquire) < kMostEvents ? free_slots() : 0;
}

std::size_t RowRing::free_slots() const {
  return capacity_ -
         (pushed_.load(std::memory_order_relaxed) - popped_.load(std::memory_order_acquire));
}

bool RowRing::Push(const Reading& reading, MonotonicNs origin_ns) {
  if (free_slots() == 0) return false;
  const std::uint64_t pushed = pushed_.load(std::memory_order_relaxed);
  const std::size_t place = pushed % capacity_;
  slots_[place] = {.index = reading.index,
                   .time_ns = reading.time_ns - origin_ns,
                   .reply_ns = reading.reply_ns - origin_ns};
  for (std::size_t channel = 0; channel < channels_; ++channel) {
    bits_[place * channels_ + channel] = reading.samples[channel].raw.bits();
    status_[place * channels_ + channel] = reading.samples[channel].status;
  }
  pushed_.store(pushed + 1, std::memory_order_release);
  return true;
}

void RowRing::PushEvent(trial::Event event) {
  const std::lock_guard lock(events_mutex_);
  events_.emplace_back(pushed_.load(std::memory_order_relaxed), std::move(event));
  events_waiting_.store(events_.size(), std::memory_order_release);
}

bool RowRing::Wait() {
  constexpr std::chrono::milliseconds kNap(20);
  for (const bool is_last : {false, true}) {
    // closed first: what was pushed before it is seen after it
    const bool closed = closed_.load(std::memory_order_acquire);
    const bool rows = pushed_.load(std::memory_order_acquire) != popped_.load();
    if (rows || events_waiting_.load(std::memory_order_acquire) > 0) return true;
    if (closed) return false;
    if (!is_last) std::this_thread::sleep_for(kNap);
  }
  return true;
}

std::optional<trial::Event> RowRing::TakeEvent() {
  if (events_waiting_.load(std::memory_order_acquire) == 0) return std::nullopt;
  const std::lock_guard lock(events_mutex_);
  if (events_.front().first > popped_.load(std::memory_order_relaxed)) return std::nullopt;
  trial::Event event = std::move(events_.front().second);
  events_.pop_front();
  events_waiting_.store(events_.size(), std::memory_order_release);
  return event;
}

std::optional<trial::Row> RowRing::Front() {
  const std::uint64_t popped = popped_.load(std::memory_order_relaxed);
  if (pushed_.load(std::memory_order_acquire) == popped) return std::nullopt;
  const std::size_t place = popped % capacity_;
  for (std::size_t channel = 0; channel < channels_; ++channel) {
    front_[channel] = {trial::RawValue::Bits(bits_[place * channels_ + channel]),
                       status_[place * channels_ + channel]};
  }
  const Slot& slot = slots_[place];
  return trial::Row{
      .index = slot.index, .time_ns = slot.time_ns, .reply_ns = slot.reply_ns, .samples = front_};
}

void RowRing::Pop() {
  popped_.store(popped_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

}  // namespace haptometer::acquire
