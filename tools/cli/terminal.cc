#include "tools/cli/terminal.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iterator>

#include "base/text.h"

namespace haptometer::cli {
namespace {

// set by a signal handler
std::atomic<bool> interrupted{false};
std::atomic<int> which{0};
// where what is printed goes; nullptr: standard output and error
WithinProgram* within = nullptr;

// when the signal `which` came first, in ns of the monotonic clock
std::atomic<std::int64_t> since_ns{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
                  std::atomic<std::int64_t>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

// Of a terminal's Ctrl-C and of a program that signals the group and the process, one signal comes
// twice within milliseconds; a person needs longer than this for a second one.
constexpr std::int64_t kAgainNs = 300'000'000;

// clock_gettime may be called by a signal handler (POSIX.1-2008, 2.4.3)
std::int64_t MonotonicInHandler() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

extern "C" void OnSignal(int signal) {
  const std::int64_t now_ns = MonotonicInHandler();
  const bool is_first = !interrupted.load() || which.load() != signal;
  if (is_first) since_ns.store(now_ns);
  // asked for again: at once; a closed terminal asks nothing, kernel and shell both tell of it
  if (!is_first && signal != SIGHUP && now_ns - since_ns.load() >= kAgainNs) {
    std::signal(signal, SIG_DFL);
    static_cast<void>(raise(signal));
  }
  which.store(signal);
  interrupted.store(true);
}

// a character without special meaning in every shell
bool IsPlain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
         std::string_view("_-+=:,./@%").find(c) != std::string_view::npos;
}

// $'...' with all other characters in octal, which keeps control characters out of the terminal
std::string DollarQuoted(const std::string& word) {
  std::string quoted = "$'";
  for (const char c : word) {
    if (IsPlain(c) || c == ' ') {
      quoted += c;
    } else {
      fmt::format_to(std::back_inserter(quoted), "\\{:03o}", static_cast<unsigned char>(c));
    }
  }
  return quoted + "'";
}

std::string Quoted(const std::string& word) {
  if (!word.empty() && std::ranges::all_of(word, IsPlain)) return word;
  if (!IsPrintable(word)) return DollarQuoted(word);
  std::string quoted = "'";
  // a single quote ends the quoted text, stands escaped, and begins it again
  for (const char c : word) quoted += c == '\'' ? std::string(R"('\'')") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

// replaces <name> of a setting by `before` and its name: "--" for options, "" in a daemon's file
std::string WithOptions(std::string_view text, std::string_view before) {
  // settings that messages may name; another word in angle brackets is kept as it is
  constexpr std::array<std::string_view, 23> kSettings{
      "amplifiers", "averages", "baud",     "calibration", "channel",  "channels",
      "columns",    "decimals", "fault",    "format",      "label",    "overwrite",
      "port",       "profile",  "protocol", "rate",        "sampling", "scale",
      "segment",    "sensor",   "set",      "slave",       "tcp"};
  std::string said;
  while (!text.empty()) {
    const std::size_t begin = std::min(text.find('<'), text.size());
    const std::size_t end = std::min(text.find('>', begin), text.size());
    said += text.substr(0, begin);
    const std::string_view word =
        text.substr(std::min(begin + 1, end), end - std::min(begin + 1, end));
    const bool is_setting = std::ranges::find(kSettings, word) != kSettings.end();
    if (is_setting && end < text.size()) {
      said += before;
      said += word;
      text.remove_prefix(end + 1);
    } else {
      // no setting: only the bracket is passed on, since another one may begin behind it
      said += text.substr(begin, 1);
      text.remove_prefix(std::min(begin + 1, text.size()));
    }
  }
  return said;
}

int ReportError(std::string_view verb, const Error& error) {
  const std::string_view blank = verb.empty() ? "" : " ";
  PrintError(fmt::format("haptometer{}{}: {}\n", blank, verb, WithOptions(error.Text())));
  return ExitStatus(error.cause);
}

// rank: 0, then 3 (cannot answer), 2 (usage), 1 (failed), and above them signals (128 + number)
int WorseStatus(int a, int b) {
  const auto rank = [](int status) {
    if (status == 0) return 0;
    return status <= ExitStatus(Cause::kCannotAnswer) ? 4 - status : 4;
  };
  return rank(b) > rank(a) ? b : a;
}

int ReportErrors(std::string_view verb, const std::vector<Error>& errors) {
  int status = 0;
  for (const Error& error : errors) status = WorseStatus(status, ReportError(verb, error));
  return status;
}

// all text on stdout is made printable: file names must not control the terminal
void Print(std::string_view text) {
  if (within != nullptr) {
    within->output_ += PrintableLines(text);
  } else {
    fmt::print("{}", PrintableLines(text));
  }
}

// a closed standard descriptor would be given to the next file opened, and be written to
void HoldStandardStreams() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) < 0) static_cast<void>(open("/dev/null", O_PATH));
  }
}

// POLLERR on a pipe: its reader has closed it
bool IsUnread() {
  pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

// only the flush shows whether buffered output was written; its failure enters the status
int StatusWithOutput(int status, int failure) {
  const bool had_failed = std::ferror(stdout) != 0;
  if (std::fflush(stdout) != 0) {
    if (failure == 0) failure = errno;
  } else if (!had_failed) {
    return status;
  }
  // a reader that has closed the pipe (head) needs no message
  if (IsUnread()) return WorseStatus(status, kUnreadStatus);
  std::string what = "is not written whole";
  if (failure != 0) what += std::string(": ") + std::strerror(failure);
  return WorseStatus(status, ReportError("", {Cause::kFailed, "standard output", what, {}}));
}

void PrintError(const std::string& text) {
  if (within != nullptr) {
    within->errors_ += text;
  } else {
    std::fputs(text.c_str(), stderr);
  }
}

void Remark(std::string_view verb, std::string_view text) {
  PrintError(fmt::format("{}: {}\n", verb, Printable(text)));
}

WithinProgram::WithinProgram() {
  interrupted.store(false);
  which.store(0);
  within = this;
}

WithinProgram::~WithinProgram() { within = nullptr; }

bool IsWithinProgram() { return within != nullptr; }

void LeaveIfInterrupted() {
  if (interrupted.load()) throw Interruption();
}

void CatchInterrupts() {
  if (IsWithinProgram()) return;
  struct sigaction action{};
  action.sa_handler = OnSignal;
  // a closed terminal (SIGHUP) must not cost a recording its end
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before{};
    sigaction(signal, nullptr, &before);
    // nohup ignores SIGHUP, which stays ignored; shells ignore SIGINT of what they start behind
    // them
    const bool is_kept = signal == SIGHUP && before.sa_handler == SIG_IGN;
    if (!is_kept) sigaction(signal, &action, nullptr);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow further is an error like a full disk
}

void InterruptAsBy(int signal) {
  // an output that is not read any more follows a closed terminal, whose signal stays
  int none = 0;
  which.compare_exchange_strong(none, signal);
  interrupted.store(true);
}

const std::atomic<bool>& Interrupted() { return interrupted; }

int InterruptedStatus(int otherwise) { return interrupted.load() ? 128 + which.load() : otherwise; }

std::string CommandLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + Quoted(word);
  return line;
}

}  // namespace haptometer::cli
