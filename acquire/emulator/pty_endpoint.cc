#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "acquire/emulator/endpoint.h"
#include "acquire/transport/descriptor.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kHostPollNs = 2'000'000;

timespec TimespecOf(MonotonicNs ns) {
  ns = std::max<MonotonicNs>(ns, 0);
  timespec time{};
  time.tv_sec = ns / kNsPerS;
  time.tv_nsec = ns % kNsPerS;
  return time;
}

struct Terminal {
  OwnedDescriptor master{-1};
  std::string path;
};

std::unexpected<Error> NoTerminal(std::string_view step) {
  return Failed("", "no pseudo-terminal: " + std::string(step) + ": " + std::strerror(errno),
                "is /dev/pts mounted? --tcp 127.0.0.1:0 does without");
}

// A new terminal whose host side is raw 8N1: no echo, no line editing, no flow control.
Result<Terminal> OpenTerminal() {
  Terminal terminal;
  terminal.master = OwnedDescriptor(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  const int master = terminal.master.get();
  if (master < 0) return NoTerminal("posix_openpt");
  if (grantpt(master) != 0 || unlockpt(master) != 0) return NoTerminal("unlockpt");
  std::array<char, 128> path{};
  if (ptsname_r(master, path.data(), path.size()) != 0) return NoTerminal("ptsname");
  terminal.path = path.data();

  // the settings outlive this descriptor; its closing makes the master report that nobody is there
  const OwnedDescriptor host(open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (host.get() < 0 || tcgetattr(host.get(), &settings) != 0) return NoTerminal("tcgetattr");
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  if (tcsetattr(host.get(), TCSANOW, &settings) != 0) return NoTerminal("tcsetattr");
  return terminal;
}

// Where the link at `link` points; empty when there is no link.
std::string LinkTarget(const std::string& link) {
  std::error_code code;
  const std::filesystem::path target = std::filesystem::read_symlink(link, code);
  return code ? "" : target.string();
}

std::unexpected<Error> NotLinked(const std::string& link) {
  return Failed(link, std::string("cannot be linked: ") + std::strerror(errno),
                "does its directory exist, and may you write there?");
}

// A link to `target` beside `link` under a name that nothing had: symlink() replaces nothing.
Result<std::string> LinkBeside(const std::string& target, const std::string& link) {
  constexpr int kMostTries = 1000;
  for (int tries = 0; tries < kMostTries; ++tries) {
    std::string name = link + "." + std::to_string(getpid()) + "-" + std::to_string(tries);
    if (symlink(target.c_str(), name.c_str()) == 0) return name;
    if (errno != EEXIST) break;
  }
  return NotLinked(link);
}

class PtyEndpoint final : public Endpoint {
 public:
  PtyEndpoint(Terminal terminal, std::string link)
      : terminal_(std::move(terminal)), link_(std::move(link)) {}
  PtyEndpoint(const PtyEndpoint&) = delete;
  PtyEndpoint& operator=(const PtyEndpoint&) = delete;
  ~PtyEndpoint() override {
    // somebody else may have put a link of theirs there in the meantime
    if (!link_.empty() && LinkTarget(link_) == terminal_.path) unlink(link_.c_str());
  }

  // The new link replaces an old one in one step, so that a host never finds none.
  Result<void> MakeLink() {
    if (link_.empty() || symlink(terminal_.path.c_str(), link_.c_str()) == 0) return {};
    if (errno != EEXIST) return NotLinked(link_);
    if (!LinkTarget(link_).starts_with("/dev/pts/")) {
      return Failed(link_, "exists and is no link to a terminal", "remove it or give another name");
    }
    const auto fresh = LinkBeside(terminal_.path, link_);
    if (!fresh) return std::unexpected(fresh.error());
    if (rename(fresh->c_str(), link_.c_str()) == 0) return {};
    const int failure = errno;
    unlink(fresh->c_str());
    errno = failure;
    return NotLinked(link_);
  }

  [[nodiscard]] std::string name() const override { return link_.empty() ? terminal_.path : link_; }

  [[nodiscard]] bool Wait(MonotonicNs longest_ns) override {
    // without a host the master is always "ready", so the wait is a short sleep
    pollfd master{.fd = terminal_.master.get(), .events = POLLIN, .revents = 0};
    const timespec longest =
        TimespecOf(host_there_ ? longest_ns : std::min(longest_ns, kHostPollNs));
    const timespec at_once{};
    ppoll(&master, host_there_ ? 1 : 0, &longest, nullptr);
    if (!host_there_) ppoll(&master, 1, &at_once, nullptr);
    const bool was_there = std::exchange(host_there_, (master.revents & POLLHUP) == 0);
    // what the last host left unread is not for the next one, who may have asked already: only what
    // goes to the host is dropped
    if (was_there && !host_there_) tcflush(terminal_.master.get(), TCOFLUSH);
    return host_there_;
  }

  [[nodiscard]] bool Read(std::string& bytes) override {
    std::array<char, 4096> buffer{};
    const ssize_t count = read(terminal_.master.get(), buffer.data(), buffer.size());
    if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
  }

  [[nodiscard]] std::size_t Write(std::string_view bytes) override {
    const ssize_t count = write(terminal_.master.get(), bytes.data(), bytes.size());
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  [[nodiscard]] Result<void> Unplug() override {
    // the old terminal hangs up when the new one replaces it; opened first, so its name differs
    auto fresh = OpenTerminal();
    if (!fresh) return std::unexpected(fresh.error());
    terminal_ = std::move(*fresh);
    host_there_ = false;
    return MakeLink();
  }

 private:
  Terminal terminal_;
  std::string link_;
  bool host_there_ = false;
};

}  // namespace

Result<std::unique_ptr<Endpoint>> OpenPty(const std::string& link) {
  auto terminal = OpenTerminal();
  if (!terminal) return std::unexpected(terminal.error());
  auto endpoint = std::make_unique<PtyEndpoint>(std::move(*terminal), link);
  if (auto linked = endpoint->MakeLink(); !linked) return std::unexpected(linked.error());
  return endpoint;
}

}  // namespace haptometer::acquire::emulator
