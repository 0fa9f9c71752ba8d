#include "tools/plot/run_within.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <optional>
#include <system_error>

#include "tools/plot/memory_file.h"

namespace haptometer::plot {
namespace {

constexpr MonotonicNs kLookEveryNs = 5'000'000;

// the program's process, or why there is none
Result<pid_t> Start(const std::vector<std::string>& words, int input) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  const int failure =
      posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure == ENOENT) return Failed("", words[0] + " is not installed");
  if (failure != 0) {
    return Failed("", fmt::format("{} does not start: {}", words[0],
                                  std::generic_category().message(failure)));
  }
  return process;
}

// how it ended; nothing where it still runs at `deadline`
std::optional<int> WaitUntil(pid_t process, MonotonicNs deadline) {
  SystemClock clock;
  while (true) {
    int status = 0;
    const pid_t ended = waitpid(process, &status, WNOHANG);
    if (ended == process) return status;
    if (ended < 0 && errno != EINTR) return -1;
    const MonotonicNs now = clock.Now();
    if (now >= deadline) return std::nullopt;
    clock.SleepUntil(std::min(deadline, now + kLookEveryNs));
  }
}

}  // namespace

Result<bool> RunWithin(const std::vector<std::string>& words, const std::string& input,
                       MonotonicNs longest_ns) {
  const MemoryFile script(input);
  const auto process = Start(words, script.descriptor());
  if (!process) return std::unexpected(process.error());
  const auto status = WaitUntil(*process, SystemClock().Now() + longest_ns);
  if (status) return WIFEXITED(*status) && WEXITSTATUS(*status) == 0;
  kill(*process, SIGKILL);
  waitpid(*process, nullptr, 0);
  return Failed("",
                fmt::format("{} did not end within {:g} s", words[0], SecondsFromNs(longest_ns)));
}

}  // namespace haptometer::plot
