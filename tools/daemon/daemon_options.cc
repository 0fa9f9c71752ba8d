#include "tools/daemon/daemon_options.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "base/clock.h"
#include "tools/cli/command_line.h"
#include "tools/cli/report.h"
#include "tools/daemon/daemon.h"
#include "tools/daemon/daemon_config.h"
#include "tools/daemon/status_report.h"
#include "tools/daemon/status_socket.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr MonotonicNs kAnswerWithinNs = 5 * kNsPerS;

// the sockets on which the daemon that is asked for may answer
Result<std::vector<std::string>> SocketsOf(const std::string& asked) {
  std::error_code error;
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
  if (!fs::is_regular_file(asked, error)) return std::vector{asked};
  const auto config = ReadDaemonConfig(asked);
  if (!config) return std::unexpected(config.error());
  if (!config->socket.empty()) return std::vector{config->socket};
  return DefaultStatusSockets(asked);
}

Result<DaemonStatus> Ask(const std::string& asked) {
  const auto sockets = SocketsOf(asked);
  if (!sockets) return std::unexpected(sockets.error());
  std::error_code error;
  const auto there = std::ranges::find_if(
      *sockets, [&](const std::string& path) { return fs::is_socket(path, error); });
  const std::string& path = there == sockets->end() ? sockets->front() : *there;
  const auto answer = AskStatus(path, kAnswerWithinNs);
  if (!answer) return std::unexpected(answer.error());
  return ParseStatus(*answer, path);
}

int ShowStatus(const cli::Options& options, const std::string& asked) {
  const auto status = Ask(asked);
  if (!status) return cli::ReportError(kVerb, status.error());
  cli::Print(options.json() ? StatusJson(*status) : StatusText(*status));
  return 0;
}

// whether nothing else was asked for: `allowed` words, each possibly as --name=value
bool StandsAlone(int argc, const char* const* argv, const std::vector<std::string>& allowed) {
  return std::all_of(argv + 1, argv + argc, [&](const char* word) {
    const std::string text(word);
    return std::ranges::find(allowed, text) != allowed.end() ||
           std::ranges::find(allowed, text.substr(0, text.find('='))) != allowed.end();
  });
}

}  // namespace

void DeclareDaemon(cli::Options& options, DaemonOptions& wanted) {
  options.Text("--daemon", &wanted.config, "CONFIG.toml",
               "Record several sensors until SIGTERM, as the file says (docs/daemon.md)");
  options.OptionalText("--status", &wanted.wants_status, &wanted.asked, "SOCKET|CONFIG.toml",
                       "Show what a running daemon is about");
}

std::optional<int> RunDaemonOptions(const cli::Options& options, const DaemonOptions& wanted,
                                    int argc, const char* const* argv) {
  if (wanted.config.empty() && !wanted.wants_status) return std::nullopt;
  const std::string which = wanted.wants_status ? "--status" : "--daemon";
  std::vector<std::string> allowed{which, wanted.config, wanted.asked};
  if (wanted.wants_status) allowed.emplace_back("--json");
  if (!StandsAlone(argc, argv, allowed)) {
    return cli::ReportError(kVerb, {Cause::kUsage, which, "stands alone",
                                    "leave the other options out; CONFIG.toml says the rest"});
  }
  if (wanted.wants_status) return ShowStatus(options, wanted.asked);
  const std::vector<std::string> words(argv, argv + argc);
  return RunDaemon(wanted.config, cli::CommandLine(words));
}

}  // namespace haptometer::tools
