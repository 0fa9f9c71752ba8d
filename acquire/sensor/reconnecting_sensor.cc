#include "acquire/sensor/reconnecting_sensor.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kSliceNs = 100'000'000;  // how long Next() waits at most

// whether rows of both have the same meaning: timing, channels, encoding, scale
bool SendsTheSame(const trial::TrialHeader& a, const trial::TrialHeader& b) {
  return a.timing == b.timing && a.rate_hz == b.rate_hz &&
         std::ranges::equal(a.channels, b.channels,
                            [](const trial::ChannelFormat& x, const trial::ChannelFormat& y) {
                              return x.name == y.name && x.encoding == y.encoding &&
                                     x.scale == y.scale && x.offset == y.offset;
                            });
}

// whether both average alike, as far as both are known: a trial states one gain for all of its rows
bool AveragesTheSame(const trial::Metadata& a, const trial::Metadata& b) {
  const auto is_other = [](const auto& one, const auto& other) {
    return one && other && *one != *other;
  };
  const bool is_other_head = !a.head.empty() && !b.head.empty() && a.head != b.head;
  return !is_other(a.averages, b.averages) && !is_other(a.sampling_s, b.sampling_s) &&
         !is_other_head;
}

}  // namespace

ReconnectingSensor::ReconnectingSensor(Open open, std::optional<MonotonicNs> longest_away_ns,
                                       Clock& clock)
    : open_(std::move(open)), longest_away_ns_(longest_away_ns), clock_(clock) {}

Result<void> ReconnectingSensor::Start(const std::atomic<bool>& stop) {
  stop_ = &stop;
  HAPTOMETER_LET(auto opened, open_());
  HAPTOMETER_TRY(opened->Start(stop));
  sensor_ = std::move(opened);
  // the header of the recording remains that of the first connection
  header_ = sensor_->header();
  return {};
}

Findings ReconnectingSensor::Found() const { return sensor_ ? sensor_->Found() : last_found_; }

MonotonicNs ReconnectingSensor::Begin() { return sensor_ ? sensor_->Begin() : clock_.Now(); }

Outcome ReconnectingSensor::Next(Reading& reading) {
  if (!sensor_) return TryAgain();
  const Outcome outcome = sensor_->Next(reading);
  if (outcome != Outcome::kGone) return outcome;
  LetGo();
  return Outcome::kAway;
}

// counters and findings of the lost sensor are kept
void ReconnectingSensor::LetGo() {
  discarded_before_ += sensor_->discarded_bytes();
  last_found_ = sensor_->Found();
  sensor_.reset();
  away_since_ns_ = clock_.Now();
  // pauses between attempts start again at their shortest
  pause_.Reset();
  next_try_ns_ = away_since_ns_ + pause_.Next();
}

Outcome ReconnectingSensor::TryAgain() {
  const MonotonicNs now = clock_.Now();
  // the longest permitted absence is over
  if (longest_away_ns_ && now - away_since_ns_ >= *longest_away_ns_) return Outcome::kGone;
  if (now < next_try_ns_) {
    clock_.SleepUntil(std::min(next_try_ns_, now + kSliceNs));
    return Outcome::kNothing;
  }
  auto opened = open_();
  Result<void> started = opened ? (*opened)->Start(*stop_) : std::unexpected(opened.error());
  // another device at the port would give rows with another meaning
  if (started && !SendsTheSame((*opened)->header(), header_)) {
    started = CannotAnswer("", "what came back sends other channels", "plug in the same device");
  }
  // the same device with other settings: its rows belong into another trial
  if (started && !AveragesTheSame((*opened)->header().metadata, header_.metadata)) {
    last_refusal_ = "what came back has another averaging, sampling period or head";
    last_found_.Doubt(FindingKind::kOtherSettings);
    return Outcome::kGone;
  }
  if (!started) {
    last_refusal_ = started.error().Text();
    next_try_ns_ = clock_.Now() + pause_.Next();
    return Outcome::kNothing;
  }
  sensor_ = std::move(*opened);
  last_refusal_.clear();
  (void)sensor_->Begin();  // times are the clock's own, and count from the first beginning
  return Outcome::kBack;
}

std::uint64_t ReconnectingSensor::discarded_bytes() const {
  return discarded_before_ + (sensor_ ? sensor_->discarded_bytes() : 0);
}

}  // namespace haptometer::acquire
