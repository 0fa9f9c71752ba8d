#include "acquire/recorder/row_ring.h"

#include <algorithm>
#include <chrono>
#include <thread>

namespace haptometer::acquire {

RowRing::RowRing(std::size_t bytes, std::size_t channels)
    : channels_(channels),
      // bytes per row: slot, and 8 bytes of number and 1 of status per channel
      capacity_(std::max<std::size_t>(1, bytes / (sizeof(Slot) + channels * 9))),
      // allocated before the recording; push and pop of rows allocate nothing
      slots_(std::make_unique_for_overwrite<Slot[]>(capacity_)),
      bits_(std::make_unique_for_overwrite<std::uint64_t[]>(capacity_ * channels)),
      status_(std::make_unique_for_overwrite<trial::SampleStatus[]>(capacity_ * channels)),
      front_(channels) {}

// events have a bound too: beyond it no row is accepted
std::size_t RowRing::room() const {
  return events_waiting_.load(std::memory_order_acquire) < kMostEvents ? free_slots() : 0;
}

// one producer and one consumer: each reads its own counter relaxed, the other's with acquire
std::size_t RowRing::free_slots() const {
  return capacity_ -
         (pushed_.load(std::memory_order_relaxed) - popped_.load(std::memory_order_acquire));
}

// false where the ring is full; times relative to the beginning of the recording
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
  // release: the row is complete before the consumer can read it
  pushed_.store(pushed + 1, std::memory_order_release);
  return true;
}

void RowRing::PushEvent(trial::Event event) {
  const std::lock_guard lock(events_mutex_);
  // an event stands before the row that is pushed next
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
  // rows before the event have to be written first
  if (events_.front().first > popped_.load(std::memory_order_relaxed)) return std::nullopt;
  trial::Event event = std::move(events_.front().second);
  events_.pop_front();
  events_waiting_.store(events_.size(), std::memory_order_release);
  return event;
}

// front row, valid until Pop()
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

// release: the slot is free only after it has been read
void RowRing::Pop() {
  popped_.store(popped_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

}  // namespace haptometer::acquire
