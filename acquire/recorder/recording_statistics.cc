#include "acquire/recorder/recording_statistics.h"

#include <algorithm>
#include <cmath>

namespace haptometer::acquire {

void IntervalStatistics::Add(MonotonicNs time_ns, std::uint64_t missing) {
  // the first reading has no interval
  if (!has_time_) {
    has_time_ = true;
    last_ns_ = time_ns;
    return;
  }
  const MonotonicNs interval_ns = time_ns - last_ns_;
  const double interval_s = SecondsFromNs(interval_ns);
  last_ns_ = time_ns;
  all_.Take(1 + missing, interval_ns);
  block_.Take(1 + missing, interval_ns);
  // a block of rows ends where one begins, or was none: its rows are spread over time
  if (interval_s > 0.5 * mean_s_ || 2 * block_.ns > begin_ns_) {
    // nothing tells how long the first block took
    const bool is_first_block = begin_ns_ == kNone && block_.places > 1;
    if (!is_first_block) whole_.Take(block_.places, block_.ns);
    block_ = {};
    begin_ns_ = interval_ns;
  }
  if (missing > 0) return;
  ++intervals_;
  // Welford: mean m and sum of squared deviations S of the intervals, in one pass
  const double deviation_s = interval_s - mean_s_;
  mean_s_ += deviation_s / static_cast<double>(intervals_);
  squares_s2_ += deviation_s * (interval_s - mean_s_);
}

void IntervalStatistics::Restart() {
  has_time_ = false;
  block_ = {};
  begin_ns_ = kNone;
}

bool IntervalStatistics::Explains(MonotonicNs time_ns, std::uint64_t missing) const {
  constexpr double kLongerS = 0.25;
  constexpr double kShorterS = 0.05;  // rows come in bursts
  if (missing == 0 || !has_time_) return true;
  if (intervals_ == 0) return false;
  const double explained_s = static_cast<double>(1 + missing) * mean_s_;
  const double interval_s = SecondsFromNs(time_ns - last_ns_);
  return interval_s <= explained_s + kLongerS && interval_s >= explained_s - kShorterS;
}

// rate = intervals / total time
std::optional<double> IntervalStatistics::RateHz() const {
  const Span& span = whole_.ns > 0 ? whole_ : all_;
  if (span.ns <= 0) return std::nullopt;
  return static_cast<double>(span.places) / SecondsFromNs(span.ns);
}

// standard deviation of the intervals, s = sqrt(S / (n - 1))
std::optional<double> IntervalStatistics::DeviationSeconds() const {
  if (intervals_ < 2) return std::nullopt;
  return std::sqrt(squares_s2_ / static_cast<double>(intervals_ - 1));
}

namespace {

// an interval above 8 usual ones is a gap
constexpr double kUsualIntervals = 8;
// arrival times: only a silence above 50 ms, and above 8 usual intervals, can be a gap
constexpr double kShortestSilenceNs = 50e6;
// arrival times: 0.5 s after a silence, the number of rows shows whether some are missing
constexpr MonotonicNs kVerdictAfterNs = 500'000'000;

}  // namespace

// mean of the intervals without gaps, in ns
double GapCounter::UsualIntervalNs() const {
  return static_cast<double>(usual_sum_ns_) /
         static_cast<double>(std::max<std::uint64_t>(usual_count_, 1));
}

void GapCounter::Add(const Reading& reading) {
  // uniform rows are numbered: a step of more than 1 is a gap
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
  // compared with the usual interval before this one is added
  const bool is_long =
      usual_count_ > 0 && static_cast<double>(interval_ns) > kUsualIntervals * UsualIntervalNs();
  // polled: one gap from the first long interval to the first usual one
  if (timing_ == trial::Timing::kPolled && is_long) {
    if (!in_gap_) ++gaps_;
    in_gap_ = true;
    return;
  }
  in_gap_ = false;
  usual_sum_ns_ += interval_ns;
  ++usual_count_;
  // arrivals without line numbers: delayed rows come in a burst after a silence, lost ones do not
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
    // the usual interval without this silence
    usual_before_ns_ =
        static_cast<double>(usual_sum_ns_ - interval_ns) / static_cast<double>(usual_count_ - 1);
    return;
  }
  // rows since the silence began: delayed rows increase them to the expected number
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
  // rows expected since the silence began, at the usual interval
  const double expected = static_cast<double>(now_ns - silence_begin_ns_) / usual_before_ns_;
  const double missing = expected - static_cast<double>(rows_since_);
  // a gap where at least half of the rows of the silence are missing
  return missing >= 0.5 * static_cast<double>(silence_ns_) / usual_before_ns_;
}

// a known gap, a shot or a reconnection begins here: no interval across it
void GapCounter::Restart() {
  gaps_ = gaps();
  silence_open_ = false;
  in_gap_ = false;
  has_last_ = false;
}

// the silence from the last row to the end may be a gap too
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

Tally::Tally(const Sensor& sensor, MonotonicNs origin_ns)
    : sensor_(sensor),
      timing_(sensor.header().timing),
      rate_hz_(sensor.header().rate_hz),
      origin_ns_(origin_ns),
      gaps_(timing_,
            sensor.header().metadata.fields.contains(std::string(trial::kLineNumbersField))) {}

// uniform: index / rate; else the time of the reading, from the beginning
MonotonicNs Tally::SinceBegin(const Reading& reading) const {
  if (timing_ != trial::Timing::kUniform) return reading.time_ns - origin_ns_;
  return NsFromSeconds(static_cast<double>(reading.index) / rate_hz_);
}

void Tally::Add(const Reading& reading) {
  ++summary_.readings;
  ++summary_.statuses[static_cast<std::size_t>(RowStatus(reading))];
  // rows with at least one measured value
  if (std::ranges::any_of(reading.samples, trial::IsMeasurement, &trial::Sample::status)) {
    ++summary_.measured;
  }
  const MonotonicNs time_ns = SinceBegin(reading);
  summary_.elapsed_s = SecondsFromNs(time_ns);
  // a gap that the sensor itself counts needs no estimate from the interval
  if (reading.lost_before > 0 || reading.follows_gap) {
    ++known_gaps_;
    gaps_.Restart();
  }
  // how much a gap without a number holds is not known
  const auto missing = static_cast<std::uint64_t>(reading.lost_before);
  if (reading.follows_gap || !intervals_.Explains(time_ns, missing)) intervals_.Restart();
  intervals_.Add(time_ns, missing);
  gaps_.Add(reading);
}

void Tally::Restart() {
  gaps_.Restart();
  intervals_.Restart();
}

// rows without room in the ring: one gap
void Tally::Lose(std::uint64_t rows) {
  summary_.lost += rows;
  ++known_gaps_;
  Restart();
}

void Tally::Leave() {
  summary_.is_away = true;
  ++known_gaps_;
}

void Tally::Return() {
  summary_.is_away = false;
  ++summary_.reconnects;
  Restart();
}

void Tally::Fire() {
  ++summary_.triggers;
  Restart();
}

void Tally::End(MonotonicNs since_begin_ns) {
  // an absent device has its gap already
  if (!summary_.is_away) gaps_.End(origin_ns_ + since_begin_ns);
}

RecordingSummary Tally::Summary() const {
  RecordingSummary summary = summary_;
  summary.gaps = gaps_.gaps() + known_gaps_;
  summary.rate_hz = intervals_.RateHz();
  summary.interval_sd_s = intervals_.DeviationSeconds();
  summary.discarded_bytes = sensor_.discarded_bytes();
  return summary;
}

}  // namespace haptometer::acquire
