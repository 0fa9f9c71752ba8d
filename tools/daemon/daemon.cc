#include "tools/daemon/daemon.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "acquire/transport/descriptor.h"
#include "base/text.h"
#include "tools/cli/terminal.h"
#include "tools/daemon/daemon_config.h"
#include "tools/daemon/sensor_loop.h"
#include "tools/daemon/status.h"

namespace haptometer::tools {
namespace {

constexpr MonotonicNs kWaitNs = kNsPerS / 10;  // for a client of the socket, and between two checks
// least interval between two status lines for systemd
constexpr MonotonicNs kTellEveryNs = kNsPerS;

using Loops = std::vector<std::unique_ptr<SensorLoop>>;

// set by the signal handler, cleared by Serve()
std::atomic<bool> rotation_asked{false};

extern "C" void OnHangUp(int /*signal*/) { rotation_asked.store(true); }

// SIGHUP begins new files, as of other services, so that closed ones can be moved; of a daemon that
// was started at a terminal it means that the terminal was closed, and ends it
void CatchHangUp() {
  if (isatty(STDIN_FILENO) == 1 || isatty(STDOUT_FILENO) == 1) return;
  struct sigaction action{};
  action.sa_handler = OnHangUp;
  sigaction(SIGHUP, &action, nullptr);
}

// Tells the service manager that started this process "READY=1\nSTATUS=..."; else does nothing. The
// datagram of sd_notify(3), whose form systemd keeps stable: libsystemd itself would load eight
// libraries at each start of the program.
void NotifyService(const std::string& assignments) {
  const char* const variable = std::getenv("NOTIFY_SOCKET");
  const std::string_view path = variable == nullptr ? "" : variable;
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof(address.sun_path)) return;
  address.sun_family = AF_UNIX;
  std::ranges::copy(path, address.sun_path);
  // a name in the abstract namespace begins with a zero byte, for which the variable has an @
  if (path.starts_with('@')) address.sun_path[0] = '\0';
  const acquire::OwnedDescriptor descriptor(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (descriptor.get() < 0) return;
  (void)sendto(descriptor.get(), assignments.data(), assignments.size(), MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&address),
               static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size()));
}

// within which time it wants a sign of life ("WATCHDOG=1"), where it does, by
// sd_watchdog_enabled(3)
std::optional<MonotonicNs> WatchdogInterval() {
  const char* const process = std::getenv("WATCHDOG_PID");
  // variables that the parent of this process was given are not meant for it
  if (process != nullptr && NumberFrom<pid_t>(process) != getpid()) return std::nullopt;
  const char* const variable = std::getenv("WATCHDOG_USEC");
  if (variable == nullptr) return std::nullopt;
  const auto interval_us = NumberFrom<MonotonicNs>(variable);
  if (!interval_us || *interval_us <= 0) return std::nullopt;
  return *interval_us * 1000;
}

// messages to systemd (sd_notify): ready, watchdog, status line
class Notices {
 public:
  Notices(const Loops& loops, Clock& clock)
      : loops_(loops), clock_(clock), watchdog_ns_(WatchdogInterval()) {}

  void Tell(const DaemonStatus& status) {
    TellReady(status);
    const MonotonicNs now_ns = clock_.Now();
    // twice per watchdog interval, and only while both threads of each sensor are alive
    if (watchdog_ns_ && now_ns >= next_alive_ns_ && AllAlive()) {
      NotifyService("WATCHDOG=1");
      next_alive_ns_ = now_ns + *watchdog_ns_ / 2;
    }
    if (now_ns < next_status_ns_) return;
    next_status_ns_ = now_ns + kTellEveryNs;
    std::string line = StatusLine(status);
    // an unchanged line is not sent again
    if (line == line_) return;
    NotifyService("STATUS=" + line);
    line_ = std::move(line);
  }

 private:
  // ready once each sensor is recorded or waited for
  void TellReady(const DaemonStatus& status) {
    if (is_ready_ ||
        std::ranges::count(status.sensors, LoopState::kStarting, &SensorStatus::state) > 0) {
      return;
    }
    is_ready_ = true;
    NotifyService("READY=1");
  }

  [[nodiscard]] bool AllAlive() const {
    return std::ranges::all_of(
        loops_, [this](const auto& loop) { return loop->IsAlive(*watchdog_ns_ / 2); });
  }

  const Loops& loops_;
  Clock& clock_;
  std::optional<MonotonicNs> watchdog_ns_;
  bool is_ready_ = false;
  MonotonicNs next_alive_ns_ = 0;
  MonotonicNs next_status_ns_ = 0;
  std::string line_;
};

// each loop's status is copied under its own lock
DaemonStatus StatusOf(const std::string& config_path, const Loops& loops) {
  DaemonStatus status{.config = config_path, .utc = UtcNow(), .sensors = {}};
  for (const auto& loop : loops) status.sensors.push_back(loop->Status());
  return status;
}

// the error of a loop that ended without a stop, which ends the daemon
std::optional<Error> Refusal(const Loops& loops) {
  for (const auto& loop : loops) {
    if (auto refused = loop->refused()) return refused;
  }
  return std::nullopt;
}

std::optional<Error> Serve(const std::string& config_path, const StatusSocket& socket,
                           const Loops& loops, Clock& clock) {
  Notices notices(loops, clock);
  while (!cli::Interrupted().load()) {
    // a wrong configuration of one sensor ends all: the service must not appear to run
    if (auto refused = Refusal(loops)) return refused;
    if (rotation_asked.exchange(false)) {
      for (const auto& loop : loops) loop->Rotate();
    }
    notices.Tell(StatusOf(config_path, loops));
    // the wait for a client sets the loop's period, kWaitNs
    socket.AnswerOne(kWaitNs, [&] { return StatusJson(StatusOf(config_path, loops)); });
  }
  return std::nullopt;
}

Result<void> CheckDirectory(const DaemonConfig& config, const std::string& config_path) {
  std::error_code error;
  if (std::filesystem::is_directory(config.trials.directory, error)) return {};
  return Usage(config_path + ": directory", config.trials.directory + " is not a directory",
               "make it, or name another");
}

// records until a signal comes; the exit status
Result<int> RunDaemon(const std::string& config_path, const std::string& command_line) {
  HAPTOMETER_LET(const auto config, ReadDaemonConfig(config_path));
  HAPTOMETER_TRY(CheckDirectory(config, config_path));
  cli::CatchInterrupts();
  CatchHangUp();
  // the socket before the sensors: a second daemon of this file ends here, before it opens a port
  HAPTOMETER_LET(
      const auto socket,
      StatusSocket::Listen(config.socket.empty() ? DefaultStatusSockets(config_path).front()
                                                 : config.socket));
  SystemClock clock;
  Loops loops;
  for (const DaemonSensor& sensor : config.sensors) {
    loops.push_back(std::make_unique<SensorLoop>(sensor, config, command_line, clock));
  }
  const auto refused = Serve(config_path, socket, loops, clock);

  // stop all first, then wait for each: the trials close at the same time
  NotifyService("STOPPING=1\nSTATUS=closing the trials");
  for (const auto& loop : loops) loop->Stop();
  loops.clear();
  if (refused) return std::unexpected(*refused);
  return 0;
}

namespace fs = std::filesystem;

constexpr MonotonicNs kAnswerWithinNs = 5 * kNsPerS;

// the sockets on which the requested daemon may answer: the only one, a socket, or a file's
Result<std::vector<std::string>> SocketsOf(const std::string& asked) {
  std::error_code error;
  // without a name exactly one daemon must run here
  if (asked.empty()) {
    auto found = StatusSockets();
    if (found.size() == 1) return found;
    if (found.empty()) {
      return CannotAnswer("--status", "no daemon runs here",
                          "start one with: acquire --daemon CONFIG.toml, or name its socket");
    }
    return Usage("--status", fmt::format("there are several: {}", fmt::join(found, ", ")),
                 "name one of them");
  }
  // not a regular file: a socket's path
  if (!fs::is_regular_file(asked, error)) return std::vector{asked};
  HAPTOMETER_LET(const auto config, ReadDaemonConfig(asked));
  if (!config.socket.empty()) return std::vector{config.socket};
  return DefaultStatusSockets(asked);
}

Result<DaemonStatus> Ask(const std::string& asked) {
  HAPTOMETER_LET(const auto sockets, SocketsOf(asked));
  std::error_code error;
  // the first path at which a socket exists; else the first, for the error message
  const auto there = std::ranges::find_if(
      sockets, [&](const std::string& path) { return fs::is_socket(path, error); });
  const std::string& path = there == sockets.end() ? sockets.front() : *there;
  HAPTOMETER_LET(const auto answer, AskStatus(path, kAnswerWithinNs));
  return ParseStatus(answer, path);
}

// whether only the `allowed` words are given, each possibly as --name=value
bool StandsAlone(int argc, const char* const* argv, const std::vector<std::string>& allowed) {
  return std::all_of(argv + 1, argv + argc, [&](const char* word) {
    const std::string text(word);
    return std::ranges::find(allowed, text) != allowed.end() ||
           std::ranges::find(allowed, text.substr(0, text.find('='))) != allowed.end();
  });
}

}  // namespace

void DeclareDaemon(cli::Options& options, DaemonOptions& wanted) {
  options.Text(
      "--daemon", &wanted.config, "CONFIG.toml",
      "Record the sensors of a configuration file until SIGTERM (docs/reference/daemon.md)");
  options.OptionalText("--status", &wanted.wants_status, &wanted.asked, "SOCKET|CONFIG.toml",
                       "Show the status of a running daemon");
}

Result<std::optional<int>> RunDaemonOptions(const DaemonOptions& wanted,
                                            const document::Outputs& outputs, int argc,
                                            const char* const* argv) {
  if (wanted.config.empty() && !wanted.wants_status) return std::nullopt;
  const std::string which = wanted.wants_status ? "--status" : "--daemon";
  std::vector<std::string> allowed{which, wanted.config, wanted.asked};
  if (wanted.wants_status) allowed.insert(allowed.end(), {"--json", "--all"});
  if (!StandsAlone(argc, argv, allowed)) {
    return Usage(which, "cannot be combined with other options",
                 "leave the other options out; CONFIG.toml states the rest");
  }
  if (!wanted.wants_status) {
    return RunDaemon(wanted.config, cli::CommandLine({argv, argv + argc}));
  }
  HAPTOMETER_LET(const auto status, Ask(wanted.asked));
  return document::Present(StatusDocument(status), outputs, argc, argv);
}

}  // namespace haptometer::tools
