#pragma once

#include <cstddef>
#include <string>

/// The objects of one exported trial, by the names that they have in HDF5, MAT and NPY;
/// docs/reference/formats.md says what they hold. Beside them stand one column a channel, named as
/// in a CSV (trial/import/table/csv_header.h), and one with its statuses.
namespace haptometer::trial::objects {

inline constexpr const char* kTimes = "time_s";
inline constexpr const char* kArrivalTimes = "arrival_s";
/// The name of kArrivalTimes in files of version 0.1.0.
inline constexpr const char* kFormerArrivalTimes = "raw_time_s";
inline constexpr const char* kStretches = "stretches";
inline constexpr const char* kHeader = "header_json";
inline constexpr const char* kEvents = "events_json";
inline constexpr const char* kRemarks = "remarks";
inline constexpr const char* kRaw = "raw";
inline constexpr const char* kClosed = "closed";
inline constexpr const char* kTimesAreKnown = "times_are_known";
/// Numbers of one of the stretches: first_row, rows, start_s, rate_hz, time_uncertainty_s.
inline constexpr std::size_t kStretchNumbers = 5;

inline constexpr const char* kStatusEnding = "_status";
[[nodiscard]] inline std::string StatusName(const std::string& column) {
  return column + kStatusEnding;
}

}  // namespace haptometer::trial::objects
