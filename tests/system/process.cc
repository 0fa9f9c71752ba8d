#include "tests/system/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "base/error.h"

namespace haptometer::tests {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// appends what a pipe holds; false at its end
bool Drain(int fd, std::string& text) {
  char piece[4096];
  const ssize_t n = read(fd, piece, sizeof piece);
  if (n > 0) text.append(piece, static_cast<std::size_t>(n));
  return n > 0;
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments) {
  const std::string path = std::string(HAPTOMETER_PROGRAMS) + "/" + arguments.at(0);
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);

  int out[2];
  int err[2];
  HAPTOMETER_CHECK(pipe2(out, O_CLOEXEC) == 0 && pipe2(err, O_CLOEXEC) == 0, "pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], 1);
  posix_spawn_file_actions_adddup2(&actions, err[1], 2);
  const int failure = posix_spawn(&pid_, path.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  HAPTOMETER_CHECK(failure == 0, "{} does not start", path);
  close(out[1]);
  close(err[1]);
  out_fd_ = out[0];
  err_fd_ = err[0];
}

Process::~Process() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(out_fd_);
  close(err_fd_);
}

bool Process::ReadOnce(double until_s) {
  pollfd fds[2] = {{out_fd_, POLLIN, 0}, {err_fd_, POLLIN, 0}};
  const double wait_ms = std::max(0.0, (until_s - Now()) * 1000);
  if (poll(fds, 2, static_cast<int>(wait_ms)) <= 0) return false;
  bool open = false;
  if (fds[0].revents != 0) open = Drain(out_fd_, outcome_.out) || open;
  if (fds[1].revents != 0) open = Drain(err_fd_, outcome_.err) || open;
  return open;
}

std::optional<std::string> Process::WaitForLine(const std::string& prefix, double deadline_s) {
  const double until_s = Now() + deadline_s;
  while (true) {
    for (std::size_t begin = 0; begin < outcome_.out.size();) {
      const std::size_t end = outcome_.out.find('\n', begin);
      if (end == std::string::npos) break;
      const std::string line = outcome_.out.substr(begin, end - begin);
      if (line.starts_with(prefix)) return line.substr(prefix.size());
      begin = end + 1;
    }
    if (!ReadOnce(until_s)) return std::nullopt;
  }
}

bool Process::HasEnded() const {
  siginfo_t info{};
  // left for Wait to collect
  return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
         info.si_pid != 0;
}

::testing::AssertionResult Process::WaitUntil(const std::function<bool()>& holds,
                                              double deadline_s) {
  constexpr double kPauseS = 0.02;
  const double until_s = Now() + deadline_s;
  while (true) {
    // asked before: what holds at its end holds
    const bool has_ended = HasEnded();
    if (holds()) return ::testing::AssertionSuccess();
    if (has_ended || Now() > until_s) {
      while (ReadOnce(Now())) {
      }
      return ::testing::AssertionFailure()
             << (has_ended ? "the program has ended: " : "not in time: ") << outcome_.err;
    }
    ReadOnce(Now() + kPauseS);
    usleep(static_cast<useconds_t>(kPauseS * 1e6));
  }
}

::testing::AssertionResult Process::WaitForFile(const std::string& path, double deadline_s) {
  return WaitUntil([&] { return std::filesystem::exists(path); }, deadline_s);
}

void Process::CloseOutput() {
  // the number stays ours, at an end
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  dup3(nothing, out_fd_, O_CLOEXEC);
  close(nothing);
}

void Process::Signal(int signal) const { kill(pid_, signal); }

Outcome Process::Wait(double deadline_s) {
  const double until_s = Now() + deadline_s;
  while (ReadOnce(until_s)) {
  }
  // both pipes are at their end, or time is up
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(pid_, &status, WNOHANG)) == 0 && Now() < until_s) usleep(1000);
  if (ended == 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
    outcome_.status = -1;
  } else {
    outcome_.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  pid_ = -1;
  return outcome_;
}

Outcome RunProgram(const std::vector<std::string>& arguments) {
  return Process(arguments).Wait(60);
}

}  // namespace haptometer::tests
