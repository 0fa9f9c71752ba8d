#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/transport/descriptor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/document/document.h"

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

/// What `acquire --status` prints.
[[nodiscard]] document::Document StatusDocument(const DaemonStatus& status);

/// The same as JSON, as it is sent over the socket (docs/reference/daemon.md): its provenance has
/// version and time of the daemon alone.
[[nodiscard]] std::string StatusJson(const DaemonStatus& status);

/// Reads it back. Errors (Cause::kCannotAnswer), naming `where`: no status of a daemon.
[[nodiscard]] Result<DaemonStatus> ParseStatus(std::string_view json, const std::string& where);

/// For `systemctl status`, in one line: "2 of 3 recording; left: away".
[[nodiscard]] std::string StatusLine(const DaemonStatus& status);

/// The Unix socket on which a daemon answers whoever connects with one text, then hangs up.
class StatusSocket {
 public:
  /// Listens at `path`; makes its directory (one level). A socket that nobody answers on is
  /// replaced: a killed daemon leaves one. Errors: Cause::kUsage for a path that is too long (107
  /// bytes) or no socket; Cause::kFailed when another daemon answers there, or it cannot be made.
  [[nodiscard]] static Result<StatusSocket> Listen(std::string path);
  ~StatusSocket();
  StatusSocket(StatusSocket&&) noexcept = default;
  StatusSocket& operator=(StatusSocket&&) = delete;
  StatusSocket(const StatusSocket&) = delete;
  StatusSocket& operator=(const StatusSocket&) = delete;

  /// Waits at most `longest_ns` for somebody, and answers with what `text` says then. Somebody who
  /// does not take it within a second is left alone.
  void AnswerOne(MonotonicNs longest_ns, const std::function<std::string()>& text) const;

 private:
  StatusSocket(acquire::OwnedDescriptor listener, std::string path, ino_t inode)
      : listener_(std::move(listener)), path_(std::move(path)), inode_(inode) {}

  acquire::OwnedDescriptor listener_;
  std::string path_;
  ino_t inode_;  // of the socket that was made there
};

/// What the daemon at `path` answers, within `longest_ns`. Errors (Cause::kCannotAnswer): nobody
/// listens there, it says nothing in time or more than a status is long.
[[nodiscard]] Result<std::string> AskStatus(const std::string& path, MonotonicNs longest_ns);

/// Where a daemon with this file answers unless the file says otherwise: NAME.sock, after the
/// file's name, in haptometer/ below $XDG_RUNTIME_DIR or, for the system's own, /run. The first is
/// this process's.
[[nodiscard]] std::vector<std::string> DefaultStatusSockets(const std::string& config_path);

/// All sockets in those directories.
[[nodiscard]] std::vector<std::string> StatusSockets();

}  // namespace haptometer::tools
