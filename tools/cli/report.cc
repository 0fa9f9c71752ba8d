#include "tools/cli/report.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "base/text.h"

namespace haptometer::cli {

int ReportError(std::string_view verb, const Error& error) {
  const std::string_view blank = verb.empty() ? "" : " ";
  fmt::print(stderr, "haptometer{}{}: {}\n", blank, verb, error.Text());
  return ExitStatus(error.cause);
}

int WorseStatus(int a, int b) {
  const auto rank = [](int status) {
    if (status == 0) return 0;
    return status <= ExitStatus(Cause::kCannotAnswer) ? 4 - status : 4;
  };
  return rank(b) > rank(a) ? b : a;
}

void Print(std::string_view text) { fmt::print("{}", PrintableLines(text)); }

void HoldStandardStreams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) < 0) static_cast<void>(open("/dev/null", O_PATH));
  }
}

bool IsUnread() {
  pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

int StatusWithOutput(int status, int failure) {
  const bool had_failed = std::ferror(stdout) != 0;
  if (std::fflush(stdout) != 0) {
    if (failure == 0) failure = errno;
  } else if (!had_failed) {
    return status;
  }
  if (IsUnread()) return WorseStatus(status, kUnreadStatus);
  std::string what = "is not written whole";
  if (failure != 0) what += std::string(": ") + std::strerror(failure);
  return WorseStatus(status, ReportError("", {Cause::kFailed, "standard output", what, {}}));
}

void Remark(std::string_view verb, std::string_view text) {
  fmt::print(stderr, "{}: {}\n", verb, Printable(text));
}

}  // namespace haptometer::cli
