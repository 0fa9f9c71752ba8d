#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer::tools {

/// What a sensor of the daemon is about.
enum class LoopState : std::uint8_t {
  kStarting,
  kWaitingForDevice,  ///< it has not answered yet
  kRecording,
  kAway,            ///< it was there, and is gone
  kWaitingForDisk,  ///< its trials are closed until there is room again
  kStopped,
};

/// "starting", "waiting for device", "recording", "away", "waiting for disk", "stopped".
[[nodiscard]] std::string_view Name(LoopState state);

/// One sensor as `acquire --status` shows it. Counts are since the daemon's start.
struct SensorStatus {
  std::string name{};
  std::string port{};
  std::string sensor{};  ///< "keyence-il", ...
  LoopState state = LoopState::kStarting;
  std::string since_utc{};  ///< when this state began
  std::string file{};       ///< that is being written; empty: none
  std::uint64_t readings = 0;
  std::optional<double> rate_hz{};  ///< of the last seconds; empty where nothing comes
  std::uint64_t bad = 0;
  std::uint64_t gaps = 0;
  std::uint64_t lost = 0;        ///< readings for which the disk was too slow
  std::uint64_t reconnects = 0;  ///< times it went away and came back
  std::uint64_t disk_waits = 0;  ///< times that trials were closed for want of room
  std::string last_error{};      ///< empty: none so far
};

struct DaemonStatus {
  std::string config{};  ///< the file's path
  std::string utc{};     ///< when this was said
  std::vector<SensorStatus> sensors{};
};

/// The JSON document of `acquire --status --json` (docs/daemon.md), with a line's end.
[[nodiscard]] std::string StatusJson(const DaemonStatus& status);

/// Reads it back. Errors (Cause::kCannotAnswer), naming `where`: no status of a daemon.
[[nodiscard]] Result<DaemonStatus> ParseStatus(std::string_view json, const std::string& where);

/// For people: one line a sensor, and its last error below it.
[[nodiscard]] std::string StatusText(const DaemonStatus& status);

/// For `systemctl status`, in one line: "2 of 3 recording; left: away".
[[nodiscard]] std::string StatusLine(const DaemonStatus& status);

}  // namespace haptometer::tools
