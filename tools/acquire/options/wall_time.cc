#include "tools/acquire/options/wall_time.h"

#include <fmt/core.h>
#include <time.h>

#include <optional>

#include "tools/longest_time.h"

namespace haptometer::tools {
namespace {

// all of `text` by one of strptime's pictures, into a copy of `start`
std::optional<std::tm> Read(const std::string& text, const char* picture, const std::tm& start) {
  std::tm time = start;
  const char* end = strptime(text.c_str(), picture, &time);
  if (end == nullptr || *end != '\0') return std::nullopt;
  return time;
}

// the instant; nothing where the calendar has no such time (30 February, an hour that is skipped)
std::optional<std::time_t> Instant(std::tm wall) {
  const std::tm asked = wall;
  wall.tm_isdst = -1;
  const std::time_t instant = std::mktime(&wall);
  const bool exists = wall.tm_mday == asked.tm_mday && wall.tm_hour == asked.tm_hour &&
                      wall.tm_min == asked.tm_min && wall.tm_sec == asked.tm_sec;
  if (instant == -1 || !exists) return std::nullopt;
  return instant;
}

// the same time of the next day; at noon no day has a gap
std::tm DayAfter(const std::tm& wall) {
  std::tm day = wall;
  ++day.tm_mday;
  day.tm_hour = 12;
  day.tm_isdst = -1;
  (void)std::mktime(&day);
  day.tm_hour = wall.tm_hour;
  day.tm_min = wall.tm_min;
  day.tm_sec = wall.tm_sec;
  return day;
}

std::unexpected<Error> NoSuchTime(const std::string& text) {
  return Usage("--until", fmt::format("'{}' is a time that the calendar here does not have", text),
               "write e.g. 17:30 or 2026-03-01T17:30");
}

}  // namespace

Result<std::time_t> ParseUntil(const std::string& text, std::time_t now) {
  std::tm today{};
  localtime_r(&now, &today);
  today.tm_sec = 0;
  for (const char* picture : {"%H:%M", "%H:%M:%S"}) {
    const auto wall = Read(text, picture, today);
    if (!wall) continue;
    auto instant = Instant(*wall);
    if (!instant || *instant <= now) instant = Instant(DayAfter(*wall));
    if (!instant) return NoSuchTime(text);
    return *instant;
  }
  for (const char* picture : {"%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M:%S"}) {
    const auto wall = Read(text, picture, std::tm{});
    if (!wall) continue;
    const auto instant = Instant(*wall);
    if (!instant) return NoSuchTime(text);
    if (*instant <= now) {
      return Usage("--until", fmt::format("'{}' has passed", text), "give a time that is to come");
    }
    if (std::difftime(*instant, now) > kLongestTimeS) {
      return Usage("--until", fmt::format("'{}' is beyond 30 years", text),
                   "leave it out to record until Ctrl-C");
    }
    return *instant;
  }
  return Usage("--until", fmt::format("'{}' is no time of day", text),
               "write HH:MM, HH:MM:SS or YYYY-MM-DDTHH:MM, in local time");
}

}  // namespace haptometer::tools
