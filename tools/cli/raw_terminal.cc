#include "tools/cli/raw_terminal.h"

#include <fmt/core.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <utility>

#include "base/text.h"
#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

constexpr char kEscape = '\x1b';
constexpr int kRestOfSequenceMs = 50;

// alternate screen, no cursor, no wrapping of lines; and back
constexpr std::string_view kBegin = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J";
constexpr std::string_view kEnd = "\x1b[?7h\x1b[?25h\x1b[?1049l";

constexpr std::array kFatal = {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGSEGV};
constexpr std::array kEnding = {SIGINT, SIGTERM, SIGHUP};

// the settings before; a signal handler reads them
termios settings_before;
volatile std::sig_atomic_t is_raw = 0;

// tcsetattr and write may be called by a signal handler (POSIX.1-2008, 2.4.3)
void RestoreSettings() {
  if (is_raw == 0) return;
  is_raw = 0;
  // a terminal that was closed takes neither
  const ssize_t written = write(STDOUT_FILENO, kEnd.data(), kEnd.size());
  static_cast<void>(written);
  static_cast<void>(tcsetattr(STDIN_FILENO, TCSAFLUSH, &settings_before));
}

extern "C" void OnFatalSignal(int signal) {
  RestoreSettings();
  // the handler was reset: the signal ends the process now
  static_cast<void>(raise(signal));
}

extern "C" void OnEndingSignal(int signal) { InterruptAsBy(signal); }

void CatchSignals() {
  struct sigaction fatal{};
  fatal.sa_handler = OnFatalSignal;
  fatal.sa_flags = static_cast<int>(SA_RESETHAND) | SA_NODEFER;
  for (const int signal : kFatal) sigaction(signal, &fatal, nullptr);
  struct sigaction ending{};
  ending.sa_handler = OnEndingSignal;
  for (const int signal : kEnding) sigaction(signal, &ending, nullptr);
  // stopped, it would leave the terminal as it is
  std::signal(SIGTSTP, SIG_IGN);
}

// bytes of the control sequence that `bytes` begins with: ESC [ ... letter, ESC O letter, or ESC
// and a character; 0 where its end is missing
std::size_t SequenceBytes(std::string_view bytes) {
  if (bytes.size() < 2) return 0;
  if (bytes[1] != '[' && bytes[1] != 'O') return 2;
  const auto end =
      std::find_if(bytes.begin() + 2, bytes.end(), [](char c) { return c >= '@' && c <= '~'; });
  return end == bytes.end() ? 0 : static_cast<std::size_t>(end - bytes.begin()) + 1;
}

// bytes that a character of this first byte has
std::size_t WantedBytes(char first) {
  const auto byte = static_cast<unsigned char>(first);
  return byte < 0xc0 ? 1 : byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4;
}

winsize SizeOfTerminal() {
  winsize size{};
  const bool is_known =
      ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0;
  return is_known ? size : winsize{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
}

bool HasInput(int timeout_ms) {
  pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  return poll(&input, 1, timeout_ms) == 1;
}

}  // namespace

std::vector<Key> TakeKeys(std::string& bytes, bool is_all) {
  std::vector<Key> keys;
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const char first = rest.front();
    if (first == kEscape) {
      const std::size_t sequence = SequenceBytes(rest);
      if (sequence == 0 && !is_all) break;
      if (rest.size() == 1) keys.push_back({Key::Kind::kEscape});
      rest.remove_prefix(sequence == 0 ? rest.size() : sequence);
      continue;
    }
    if (rest.size() < WantedBytes(first) && !is_all) break;
    const std::size_t size = std::max<std::size_t>(1, Utf8CharacterBytes(rest));
    const std::string_view character = rest.substr(0, size);
    rest.remove_prefix(size);
    if (first == '\r' || first == '\n') {
      keys.push_back({Key::Kind::kEnter});
    } else if (first == '\x7f' || first == '\b') {
      keys.push_back({Key::Kind::kBackspace});
    } else if (first == '\x03') {
      keys.push_back({Key::Kind::kInterrupt});
    } else if (IsPrintable(character)) {
      keys.push_back({Key::Kind::kText, std::string(character)});
    }
  }
  bytes.erase(0, bytes.size() - rest.size());
  return keys;
}

std::vector<std::string> WrappedTo(std::string_view line, std::size_t columns) {
  std::vector<std::string> rows;
  do {
    // as many characters as fit
    std::size_t bytes = 0;
    for (std::size_t left = columns; left > 0 && bytes < line.size(); --left) {
      bytes += std::max<std::size_t>(1, Utf8CharacterBytes(line.substr(bytes)));
    }
    // a row that is not the last ends at its last blank
    std::size_t next = bytes;
    if (bytes < line.size()) {
      const std::size_t blank = line.substr(0, bytes).rfind(' ');
      const bool is_within = blank != std::string_view::npos && blank > line.find_first_not_of(' ');
      if (is_within) bytes = blank;
      next = is_within ? blank + 1 : bytes;
    }
    rows.emplace_back(line.substr(0, bytes));
    line.remove_prefix(next);
  } while (!line.empty());
  return rows;
}

Result<std::unique_ptr<RawTerminal>> RawTerminal::Open() {
  const char* kind = std::getenv("TERM");
  const bool is_plain = kind == nullptr || *kind == '\0' || std::string_view(kind) == "dumb";
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0 || is_plain ||
      tcgetattr(STDIN_FILENO, &settings_before) != 0) {
    return Usage("", "a screen needs a terminal, and this is none",
                 "use session next, redo, reject and status in scripts");
  }
  termios raw = settings_before;
  cfmakeraw(&raw);
  raw.c_oflag = settings_before.c_oflag;
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  CatchSignals();
  is_raw = 1;
  if (tcsetattr(STDIN_FILENO, TCSAFLUSH, &raw) != 0) {
    is_raw = 0;
    return Failed("", "the terminal cannot be set up", "use session next");
  }
  std::unique_ptr<RawTerminal> terminal(new RawTerminal);
  terminal->Write(kBegin);
  return terminal;
}

RawTerminal::~RawTerminal() { Restore(); }

void RawTerminal::Restore() { RestoreSettings(); }

// a terminal that takes nothing must not keep the program from its end
void RawTerminal::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR && !Interrupted().load()) continue;
    if (written <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::vector<Key> RawTerminal::Keys() {
  std::vector<Key> keys;
  std::array<char, 256> typed{};
  while (HasInput(typed_.empty() ? 0 : kRestOfSequenceMs)) {
    const ssize_t got = read(STDIN_FILENO, typed.data(), typed.size());
    if (got < 0 && errno == EINTR) return keys;
    // readable, and nothing to read: the terminal was closed
    if (got <= 0) {
      InterruptAsBy(SIGHUP);
      return keys;
    }
    typed_.append(typed.data(), static_cast<std::size_t>(got));
    for (Key& key : TakeKeys(typed_, false)) keys.push_back(std::move(key));
    if (typed_.empty()) return keys;
  }
  // no rest came
  for (Key& key : TakeKeys(typed_, true)) keys.push_back(std::move(key));
  return keys;
}

void RawTerminal::Show(const std::vector<std::string>& lines) {
  const winsize size = SizeOfTerminal();
  std::string text = "\x1b[H";
  int left = size.ws_row;
  for (const std::string& line : lines) {
    for (const std::string& row : WrappedTo(Printable(line), size.ws_col)) {
      if (left-- == 0) break;
      text += fmt::format("{}{}\x1b[K", left + 1 == size.ws_row ? "" : "\r\n", row);
    }
    if (left < 0) break;
  }
  text += "\x1b[J";
  // the size is part of what is shown: another one may have damaged it
  const std::string with_size = fmt::format("{}x{}{}", size.ws_col, size.ws_row, text);
  if (with_size == shown_) return;
  shown_ = with_size;
  Write(text);
}

void RawTerminal::Bell() { Write("\a"); }

}  // namespace haptometer::cli
