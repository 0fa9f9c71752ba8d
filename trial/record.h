#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haptometer::trial {

/// What a sensor said of one value. Nothing is clamped or repaired: a value whose status is neither
/// kOk nor kRepeated is not a measurement, whatever number stands beside it.
enum class SampleStatus : std::uint8_t {
  kOk = 0,
  kRepeated = 1,     ///< the sensor handed out the same reading again
  kOver = 2,         ///< at or above the upper end of the range
  kUnder = 3,        ///< below the lower end of the range
  kInvalid = 4,      ///< no target, or settings just changed ("-99.998", "-----")
  kDeviceError = 5,  ///< the sensor reports a fault of its own ("+EE.EEE")
  kLate = 6,         ///< no answer before the deadline
  kClipped = 7,      ///< at a rail of the converter
  kBadFrame = 8,     ///< the bytes did not form a reading
};

inline constexpr std::size_t kSampleStatusCount = 9;

/// "ok", "repeated", "over", "under", "invalid", "device_error", "late", "clipped", "bad_frame".
[[nodiscard]] std::string_view Name(SampleStatus status);
[[nodiscard]] std::optional<SampleStatus> SampleStatusFromName(std::string_view name);

/// Whether the number beside `status` is a measurement (ok or repeated).
[[nodiscard]] constexpr bool IsMeasurement(SampleStatus status) {
  return status == SampleStatus::kOk || status == SampleStatus::kRepeated;
}

/// What a channel means to the tools.
enum class ChannelRole : std::uint8_t { kDisplacement, kVoltage, kCurrent, kTrigger, kOther };

/// "displacement", "voltage", "current", "trigger", "other".
[[nodiscard]] std::string_view Name(ChannelRole role);

/// One measured quantity over time, in SI units.
struct Channel {
  std::string name{};  ///< as the source calls it: "displacement", "CH1"
  ChannelRole role = ChannelRole::kOther;
  std::string unit{};                    ///< SI: "m", "V", "A"; "" where unknown
  std::vector<double> values{};          ///< (rows); NaN where there is no measurement
  std::vector<SampleStatus> statuses{};  ///< (rows)
  double range_min = -std::numeric_limits<double>::infinity();  ///< in `unit`
  double range_max = std::numeric_limits<double>::infinity();   ///< in `unit`
  double resolution = 0;  ///< one step of the source, in `unit`; 0 where unknown
};

/// Where a row's time comes from.
enum class Timing : std::uint8_t {
  kUniform,  ///< a clocked source: row with index n on the grid is at n / rate_hz
  kArrival,  ///< a free-running source: each row carries the time at which it arrived
  kPolled,   ///< each row was asked for: it carries the times of request and reply, and the reading
             ///< may be of any age between (also: rows whose own times lie on no grid)
};

/// "uniform", "arrival", "polled".
[[nodiscard]] std::string_view Name(Timing timing);

/// Rows that follow each other without a gap at one rate: row first_row + i is at
/// start_s + i / rate_hz.
struct Stretch {
  std::size_t first_row = 0;
  std::size_t rows = 0;
  double start_s = 0;
  double rate_hz = 0;
  /// How far a row's true time may lie from this straight line (one standard deviation); 0 for a
  /// clocked source whose times are exact, not rounded. A polled sensor's readings are of unknown
  /// age, so it is milliseconds there.
  double time_uncertainty_s = 0;
};

/// What a recording says of itself; every field is what the source knew, empty where it did not.
struct Metadata {
  std::string source;  ///< "device", "emulated device", "simulated", "imported", with detail
  std::string sensor;  ///< "keyence-il", "stream", ...
  std::string head;    ///< "IL-030"
  std::optional<double> sampling_s;  ///< the sensor's own sampling period
  std::optional<int> averages;       ///< raw samples averaged into one reading
  std::string hold;                  ///< "sample", "peak", ...
  std::optional<double> nominal_rate_hz;
  std::string laser_spot;  ///< "skin", "case", "mover"
  std::optional<double> drive_frequency_hz;
  std::optional<double> drive_amplitude_v;
  double tare_m = 0;  ///< subtracted by readers who ask for tared values; never applied
  std::string utc_start;
  std::string host;
  std::string command_line;
  std::map<std::string, std::string>
      labels;  ///< subject, condition, repeat, ...; the last word counts
  std::map<std::string, std::string> fields;  ///< further `key = value` of the source, as text
  std::vector<std::string> notes;
};

/// A measurement in memory: channels over rows, with a clean time base.
///
/// Invariants: every channel holds `rows` values and statuses; the stretches lie in order, do not
/// overlap and cover all rows; raw_times_s is empty or holds one time a row.
struct Record {
  std::size_t rows = 0;
  Timing timing = Timing::kUniform;  ///< how the source's times came
  std::vector<Channel> channels;
  std::vector<Stretch> stretches;
  std::vector<double> raw_times_s;  ///< (rows) as they arrived; empty for a clocked source
  /// Whether raw_times_s are the readings' own times, to their printed digits (an imported table
  /// whose times lie on no grid), and not those at which somebody asked or heard.
  bool times_are_known = false;
  Metadata metadata;

  /// The first channel with `role`, or nullptr.
  [[nodiscard]] const Channel* Find(ChannelRole role) const;
};

/// Time of row `row` in seconds on the clean time base. O(log stretches).
[[nodiscard]] double TimeOf(const Record& record, std::size_t row);

/// The number of the first displacement channel in metres: the one that a recording is about.
/// Nothing where there is none. `source` is what has channels: a record, or a trial's header.
template <typename Source>
[[nodiscard]] std::optional<std::size_t> DisplacementChannel(const Source& source) {
  const auto found = std::ranges::find_if(source.channels, [](const auto& channel) {
    return channel.role == ChannelRole::kDisplacement && channel.unit == "m";
  });
  if (found == source.channels.end()) return std::nullopt;
  return static_cast<std::size_t>(found - source.channels.begin());
}

}  // namespace haptometer::trial
