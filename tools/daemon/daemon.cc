#include "tools/daemon/daemon.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/report.h"
#include "tools/daemon/daemon_config.h"
#include "tools/daemon/sensor_loop.h"
#include "tools/daemon/service_notice.h"
#include "tools/daemon/status_socket.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "acquire";
constexpr MonotonicNs kWaitNs = kNsPerS / 10;  // for somebody who asks, and between two looks
constexpr MonotonicNs kTellEveryNs = kNsPerS;

using Loops = std::vector<std::unique_ptr<SensorLoop>>;

std::atomic<bool> rotation_asked{false};

extern "C" void OnHangUp(int /*signal*/) { rotation_asked.store(true); }

// SIGHUP begins new files, as services do: what is closed may be taken away
void CatchHangUp() {
  struct sigaction action{};
  action.sa_handler = OnHangUp;
  sigaction(SIGHUP, &action, nullptr);
}

// what systemd hears
class Notices {
 public:
  Notices(const Loops& loops, Clock& clock)
      : loops_(loops), clock_(clock), watchdog_ns_(WatchdogInterval()) {}

  void Tell(const DaemonStatus& status) {
    TellReady(status);
    const MonotonicNs now_ns = clock_.Now();
    if (watchdog_ns_ && now_ns >= next_alive_ns_ && AllAlive()) {
      NotifyService("WATCHDOG=1");
      next_alive_ns_ = now_ns + *watchdog_ns_ / 2;
    }
    if (now_ns < next_status_ns_) return;
    next_status_ns_ = now_ns + kTellEveryNs;
    std::string line = StatusLine(status);
    if (line == line_) return;
    NotifyService("STATUS=" + line);
    line_ = std::move(line);
  }

 private:
  // ready once every sensor is recorded or waited for
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

DaemonStatus StatusOf(const std::string& config_path, const Loops& loops) {
  DaemonStatus status{.config = config_path, .utc = UtcNow(), .sensors = {}};
  for (const auto& loop : loops) status.sensors.push_back(loop->Status());
  return status;
}

// why a loop ended by itself, if one did
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
    if (auto refused = Refusal(loops)) return refused;
    if (rotation_asked.exchange(false)) {
      for (const auto& loop : loops) loop->Rotate();
    }
    notices.Tell(StatusOf(config_path, loops));
    socket.AnswerOne(kWaitNs, [&] { return StatusJson(StatusOf(config_path, loops)); });
  }
  return std::nullopt;
}

Result<void> CheckDirectory(const DaemonConfig& config, const std::string& config_path) {
  std::error_code error;
  if (std::filesystem::is_directory(config.trials.directory, error)) return {};
  return Usage(config_path + ": directory", config.trials.directory + " is no directory",
               "make it, or name another");
}

}  // namespace

int RunDaemon(const std::string& config_path, const std::string& command_line) {
  const auto config = ReadDaemonConfig(config_path);
  if (!config) return cli::ReportError(kVerb, config.error());
  if (auto checked = CheckDirectory(*config, config_path); !checked) {
    return cli::ReportError(kVerb, checked.error());
  }
  cli::CatchInterrupts();
  CatchHangUp();
  const auto socket = StatusSocket::Listen(
      config->socket.empty() ? DefaultStatusSockets(config_path).front() : config->socket);
  if (!socket) return cli::ReportError(kVerb, socket.error());

  SystemClock clock;
  Loops loops;
  for (const DaemonSensor& sensor : config->sensors) {
    loops.push_back(std::make_unique<SensorLoop>(sensor, *config, command_line, clock));
  }
  const auto refused = Serve(config_path, *socket, loops, clock);

  // all at once, then each is waited for
  NotifyService("STOPPING=1\nSTATUS=closing the trials");
  for (const auto& loop : loops) loop->Stop();
  loops.clear();
  return refused ? cli::ReportError(kVerb, *refused) : 0;
}

}  // namespace haptometer::tools
