#include "acquire/emulator/endpoint.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/open_port.h"

namespace haptometer::acquire::emulator {
namespace {

// without a host the master is always ready: interval at which a host is searched
constexpr MonotonicNs kHostPollNs = 2'000'000;

// the emulator's side of a pseudo-terminal, and the path of the host's side
struct Terminal {
  OwnedDescriptor master{-1};
  std::string path;
};

std::unexpected<Error> NoTerminal(std::string_view step) {
  return Failed("", "no pseudo-terminal: " + std::string(step) + ": " + std::strerror(errno),
                "is /dev/pts mounted? <tcp> 127.0.0.1:0 does without");
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

  // settings outlive this descriptor; closing it makes the master report that no host is connected
  const OwnedDescriptor host(open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (host.get() < 0) return NoTerminal("tcgetattr");
  if (!MakeRaw(host.get())) return NoTerminal("tcsetattr");
  return terminal;
}

// Where the link at `link` points; empty when there is no link.
std::string LinkTarget(const std::string& link) {
  std::error_code code;
  const std::filesystem::path target = std::filesystem::read_symlink(link, code);
  return code ? "" : target.string();
}

// the error of symlink() or rename(), from errno
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

// A pseudo-terminal as the serial port of the emulated unit.
class PtyEndpoint final : public Endpoint {
 public:
  PtyEndpoint(Terminal terminal, std::string link)
      : terminal_(std::move(terminal)), link_(std::move(link)) {}
  PtyEndpoint(const PtyEndpoint&) = delete;
  PtyEndpoint& operator=(const PtyEndpoint&) = delete;
  ~PtyEndpoint() override {
    // another program may have put its own link there in the meantime
    if (!link_.empty() && LinkTarget(link_) == terminal_.path) unlink(link_.c_str());
  }

  // The new link replaces an old one in one step, so that a host never finds none.
  Result<void> MakeLink() {
    // no link is requested, or the name is free
    if (link_.empty() || symlink(terminal_.path.c_str(), link_.c_str()) == 0) return {};
    if (errno != EEXIST) return NotLinked(link_);
    // other files are never replaced
    if (!LinkTarget(link_).starts_with("/dev/pts/")) {
      return Failed(link_, "exists and is not a link to a terminal",
                    "remove it or give another name");
    }
    // link beside it, then rename(): the change is atomic
    HAPTOMETER_LET(const auto fresh, LinkBeside(terminal_.path, link_));
    if (rename(fresh.c_str(), link_.c_str()) == 0) return {};
    // the errno of rename() is the one to report
    const int failure = errno;
    unlink(fresh.c_str());
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
    // POLLHUP on the master: no process holds the host's side open
    const bool was_there = std::exchange(host_there_, (master.revents & POLLHUP) == 0);
    // bytes that the last host did not read are discarded; requests of the next host, which may be
    // here already, are not: only the direction to the host is flushed
    if (was_there && !host_there_) tcflush(terminal_.master.get(), TCOFLUSH);
    return host_there_;
  }

  [[nodiscard]] bool Read(std::string& bytes) override {
    // read errors are those of an absent host: Wait() reports it
    std::array<char, 4096> buffer{};
    const ssize_t count = read(terminal_.master.get(), buffer.data(), buffer.size());
    if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
  }

  [[nodiscard]] std::size_t Write(std::string_view bytes) override {
    // a full buffer accepts nothing now; the caller tries again
    const ssize_t count = write(terminal_.master.get(), bytes.data(), bytes.size());
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  [[nodiscard]] Result<void> Unplug() override {
    // the old terminal hangs up when the new one replaces it; opened first, so its name differs
    HAPTOMETER_LET(auto fresh, OpenTerminal());
    terminal_ = std::move(fresh);
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
  HAPTOMETER_LET(auto terminal, OpenTerminal());
  auto endpoint = std::make_unique<PtyEndpoint>(std::move(terminal), link);
  HAPTOMETER_TRY(endpoint->MakeLink());
  return endpoint;
}

namespace {

constexpr int kSendBuffer = 32 * 1024;  // the kernel doubles it: as much as a pseudo-terminal holds

// HOST:PORT as two names; port 0 takes any free one
Result<NetworkName> Split(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
    return Usage("<tcp>", "'" + address + "' is not HOST:PORT", "give 127.0.0.1:0, for example");
  }
  NetworkName parts = SplitNetworkName(address);
  if (!TcpPort(parts.service)) {
    return Usage("<tcp>", fmt::format("'{}': {} is not a TCP port", address, parts.service),
                 "give a port from 1 to 65535, or 0 for any free one");
  }
  return parts;
}

// HOST:PORT as the system bound it.
std::string BoundName(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  // the socket interface requires addresses under the general type
  auto* general = reinterpret_cast<sockaddr*>(&address);
  if (getsockname(socket, general, &size) != 0 ||
      getnameinfo(general, size, host.data(), host.size(), port.data(), port.size(),
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {};
  }
  const std::string text = host.data();
  // IPv6 addresses in brackets
  return (text.contains(':') ? "[" + text + "]" : text) + ":" + port.data();
}

// A TCP port that serves one host at a time.
class TcpEndpoint final : public Endpoint {
 public:
  explicit TcpEndpoint(OwnedDescriptor listener)
      : listener_(std::move(listener)), name_(BoundName(listener_.get())) {}

  [[nodiscard]] std::string name() const override { return name_; }

  [[nodiscard]] bool Wait(MonotonicNs longest_ns) override {
    // with a host only its socket is watched: the next one waits in the queue
    pollfd watched{.fd = HasHost() ? host_.get() : listener_.get(), .events = POLLIN, .revents = 0};
    const timespec longest = TimespecOf(longest_ns);
    if (ppoll(&watched, 1, &longest, nullptr) > 0 && !HasHost()) Accept();
    return HasHost();
  }

  [[nodiscard]] bool Read(std::string& bytes) override {
    std::array<char, 4096> buffer{};
    const ssize_t count = recv(host_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    // 0 bytes: the host closed; other errors than "nothing there" end the connection too
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) host_ = OwnedDescriptor(-1);
    return HasHost();
  }

  [[nodiscard]] std::size_t Write(std::string_view bytes) override {
    // MSG_NOSIGNAL: a host that is gone gives an error, not SIGPIPE
    const ssize_t count =
        send(host_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  [[nodiscard]] Result<void> Unplug() override {
    host_ = OwnedDescriptor(-1);
    return {};
  }

 private:
  [[nodiscard]] bool HasHost() const { return host_.get() >= 0; }

  void Accept() {
    host_ =
        OwnedDescriptor(accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    // bytes leave when they are due, not when a packet is full
    const int on = 1;
    setsockopt(host_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(host_.get(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  }

  OwnedDescriptor listener_;
  OwnedDescriptor host_{-1};
  std::string name_;
};

// A socket that listens on `address`, invalid with errno set where that fails.
OwnedDescriptor Listener(const addrinfo& address) {
  OwnedDescriptor listener(
      socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (listener.get() < 0) return listener;
  const int on = 1;
  // the port can be bound again at once after the program has ended
  setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(listener.get(), address.ai_addr, address.ai_addrlen) != 0 ||
      listen(listener.get(), 1) != 0) {
    return OwnedDescriptor(-1);
  }
  return listener;
}

}  // namespace

Result<std::unique_ptr<Endpoint>> ListenTcp(const std::string& address) {
  HAPTOMETER_LET(const auto parts, Split(address));
  // addresses on which a server can listen, port as a number
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int code = getaddrinfo(parts.host.c_str(), parts.service.c_str(), &hints, &found);
  if (code != 0) {
    return Usage("<tcp>", "'" + address + "': " + gai_strerror(code),
                 "give 127.0.0.1:0, for example");
  }
  OwnedDescriptor listener = Listener(*found);
  // freeaddrinfo() may change errno
  const int reason = errno;
  freeaddrinfo(found);
  if (listener.get() < 0) {
    return Failed(address, std::string("cannot be listened on: ") + std::strerror(reason),
                  "give another port, or 0 for any free one");
  }
  return std::make_unique<TcpEndpoint>(std::move(listener));
}

}  // namespace haptometer::acquire::emulator
