#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "acquire/transport/descriptor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::tools {

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
