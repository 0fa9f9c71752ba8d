#include "tools/plot/script.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <optional>
#include <system_error>

#include "base/text.h"

namespace haptometer::plot {
namespace {

// longest title or name in a drawing
constexpr std::size_t kMostCharacters = 1000;
constexpr std::size_t kMostTickBytes = 49;  // gnuplot's MAX_ID_LEN, 50, with the end
constexpr std::string_view kGoesOn = "…";

// beginning of printable `text` within both limits, with an ellipsis where it is cut
std::string Beginning(std::string_view text, std::size_t characters, std::size_t bytes) {
  std::size_t end = 0;        // of what there is room for
  std::size_t short_end = 0;  // of what there is room for with the ellipsis
  for (std::size_t count = 0; end < text.size() && count < characters; ++count) {
    const std::size_t next = end + Utf8CharacterBytes(text.substr(end));
    // a character of several bytes is not divided
    if (next > bytes) break;
    end = next;
    // room for the ellipsis after this character
    if (end + kGoesOn.size() <= bytes && count + 1 < characters) short_end = end;
  }
  if (end == text.size()) return std::string(text);
  return std::string(text.substr(0, short_end)) + std::string(kGoesOn);
}

// `text` with `replacement` for each `wanted`
std::string Replaced(std::string_view text, char wanted, std::string_view replacement) {
  std::string replaced;
  for (const char c : text) {
    if (c == wanted) {
      replaced += replacement;
    } else {
      replaced += c;
    }
  }
  return replaced;
}

// Ends the quote, adds a quote in double quotes, and begins a quote again. gnuplot 5.4 also reads a
// doubled quote, but not at the beginning of a text.
constexpr std::string_view kQuote = R"('."'".')";

}  // namespace

Quoted::Quoted(std::string_view text)
    : word_("'" + Replaced(Beginning(Printable(text), kMostCharacters, SIZE_MAX), '\'', kQuote) +
            "'") {}

Quoted Quoted::TickName(std::string_view text) {
  // % is a format in the name of a tick
  if (text.find('%') == std::string_view::npos) return Quoted(text);
  return Quoted(Replaced(Beginning(Printable(text), kMostCharacters, kMostTickBytes), '%', "%%"));
}

MemoryFile::MemoryFile(std::string_view content) : descriptor_(memfd_create("plot", MFD_CLOEXEC)) {
  // memfd: a file without a name, which ends with the process
  while (!content.empty()) {
    const ssize_t put = write(descriptor_, content.data(), content.size());
    if (put <= 0) break;  // no memory: gnuplot fails, and the plot is reported as missing
    content.remove_prefix(static_cast<std::size_t>(put));
  }
  lseek(descriptor_, 0, SEEK_SET);
}

MemoryFile::~MemoryFile() { close(descriptor_); }

// gnuplot opens the descriptor of this process by its path
std::string MemoryFile::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), descriptor_);
}

std::string MemoryFile::Content() const {
  std::string content;
  std::array<char, 4096> part{};
  for (off_t at = 0;;) {
    // pread: independent of the position in the file
    const ssize_t got = pread(descriptor_, part.data(), part.size(), at);
    if (got <= 0) return content;
    content.append(part.data(), static_cast<std::size_t>(got));
    at += got;
  }
}

namespace {

// interval of polls, 5 ms
constexpr MonotonicNs kLookEveryNs = 5'000'000;

// process id of the program, or the error
Result<pid_t> Start(const std::vector<std::string>& words, int input) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // the script is its standard input; its output and messages are discarded
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

// status of the process; nothing where it still runs at `deadline`
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
  HAPTOMETER_LET(const auto process, Start(words, script.descriptor()));
  const auto status = WaitUntil(process, SystemClock().Now() + longest_ns);
  if (status) return WIFEXITED(*status) && WEXITSTATUS(*status) == 0;
  // beyond the limit: ended, and its entry removed from the process table
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
  return Failed("",
                fmt::format("{} did not end within {:g} s", words[0], SecondsFromNs(longest_ns)));
}

}  // namespace haptometer::plot
