#include "acquire/recorder/gap_counter.h"

#include <algorithm>

namespace haptometer::acquire {
namespace {

constexpr double kUsualIntervals = 8;
constexpr double kShortestSilenceNs = 50e6;
constexpr MonotonicNs kVerdictAfterNs = 500'000'000;

}  // namespace

double GapCounter::UsualIntervalNs() const {
  return static_cast<double>(usual_sum_ns_) /
         static_cast<double>(std::max<std::uint64_t>(usual_count_, 1));
}

void GapCounter::Add(const Reading& reading) {
  if (timing_ == trial::Timing::kUniform) {
    if (has_last_ && reading.index != last_index_ + 1) ++gaps_;
    last_index_ = reading.index;
  } else if (has_last_) {
    AddInterval(reading.time_ns);
  }
  last_ns_ = reading.time_ns;
  has_last_ = true;
}

void GapCounter::AddInterval(MonotonicNs time_ns) {
  const MonotonicNs interval_ns = time_ns - last_ns_;
  const bool is_long =
      usual_count_ > 0 && static_cast<double>(interval_ns) > kUsualIntervals * UsualIntervalNs();
  if (timing_ == trial::Timing::kPolled && is_long) {
    if (!in_gap_) ++gaps_;
    in_gap_ = true;
    return;
  }
  in_gap_ = false;
  usual_sum_ns_ += interval_ns;
  ++usual_count_;
  if (timing_ == trial::Timing::kArrival && !is_numbered_) WatchSilence(time_ns, is_long);
}

void GapCounter::WatchSilence(MonotonicNs time_ns, bool is_long) {
  const MonotonicNs interval_ns = time_ns - last_ns_;
  if (!silence_open_) {
    if (!is_long || static_cast<double>(interval_ns) <= kShortestSilenceNs) return;
    silence_open_ = true;
    silence_begin_ns_ = last_ns_;
    silence_ns_ = interval_ns;
    rows_since_ = 1;
    usual_before_ns_ =
        static_cast<double>(usual_sum_ns_ - interval_ns) / static_cast<double>(usual_count_ - 1);
    return;
  }
  ++rows_since_;
  if (time_ns - silence_begin_ns_ - silence_ns_ < kVerdictAfterNs) return;
  silence_open_ = false;
  if (!SilenceWasGap(time_ns)) return;
  // a gap is no part of the usual interval
  ++gaps_;
  usual_sum_ns_ -= silence_ns_;
  --usual_count_;
}

bool GapCounter::SilenceWasGap(MonotonicNs now_ns) const {
  const double expected = static_cast<double>(now_ns - silence_begin_ns_) / usual_before_ns_;
  const double missing = expected - static_cast<double>(rows_since_);
  return missing >= 0.5 * static_cast<double>(silence_ns_) / usual_before_ns_;
}

void GapCounter::Restart() {
  gaps_ = gaps();
  silence_open_ = false;
  in_gap_ = false;
  has_last_ = false;
}

void GapCounter::End(MonotonicNs time_ns) {
  if (timing_ == trial::Timing::kUniform || !has_last_ || usual_count_ == 0) return;
  const auto silence_ns = static_cast<double>(time_ns - last_ns_);
  if (silence_ns <= std::max(kUsualIntervals * UsualIntervalNs(), kShortestSilenceNs)) return;
  Restart();
  ++gaps_;
}

std::uint64_t GapCounter::gaps() const {
  return gaps_ + (silence_open_ && SilenceWasGap(last_ns_) ? 1 : 0);
}

}  // namespace haptometer::acquire
