#include "base/clock.h"

#include <fmt/core.h>
#include <time.h>

#include <cmath>

namespace haptometer {

// rounded to the nearest ns
MonotonicNs NsFromSeconds(double seconds) {
  return std::llround(seconds * static_cast<double>(kNsPerS));
}

double SecondsFromNs(MonotonicNs ns) {
  return static_cast<double>(ns) / static_cast<double>(kNsPerS);
}

MonotonicNs SystemClock::Now() {
  timespec now{};
  // not changed by corrections of the time of day
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

void SystemClock::SleepUntil(MonotonicNs time) {
  timespec until{};
  until.tv_sec = time / kNsPerS;
  until.tv_nsec = time % kNsPerS;
  // absolute time: an interruption does not lengthen the sleep
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

std::string UtcNow() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  tm utc{};
  gmtime_r(&now.tv_sec, &utc);
  // ISO 8601, UTC, in ms
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900,
                     utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec,
                     now.tv_nsec / 1'000'000);
}

}  // namespace haptometer
