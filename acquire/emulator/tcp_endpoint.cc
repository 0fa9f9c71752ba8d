#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "acquire/emulator/endpoint.h"
#include "acquire/transport/descriptor.h"
#include "acquire/transport/open_port.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr int kSendBuffer = 32 * 1024;  // the kernel doubles it: as much as a pseudo-terminal holds

struct HostPort {
  std::string host;
  std::string port;
};

Result<HostPort> Split(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
    return Usage("--tcp", "'" + address + "' is not HOST:PORT", "give 127.0.0.1:0, for example");
  }
  HostPort parts{address.substr(0, colon), address.substr(colon + 1)};
  // an IPv6 address wears brackets because of its own colons
  if (parts.host.starts_with('[') && parts.host.ends_with(']')) {
    parts.host = parts.host.substr(1, parts.host.size() - 2);
  }
  if (!TcpPort(parts.port)) {
    return Usage("--tcp", fmt::format("'{}': {} is no TCP port", address, parts.port),
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
  // the socket interface wants its addresses under the general type
  auto* general = reinterpret_cast<sockaddr*>(&address);
  if (getsockname(socket, general, &size) != 0 ||
      getnameinfo(general, size, host.data(), host.size(), port.data(), port.size(),
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {};
  }
  const std::string text = host.data();
  return (text.contains(':') ? "[" + text + "]" : text) + ":" + port.data();
}

class TcpEndpoint final : public Endpoint {
 public:
  explicit TcpEndpoint(OwnedDescriptor listener)
      : listener_(std::move(listener)), name_(BoundName(listener_.get())) {}

  [[nodiscard]] std::string name() const override { return name_; }

  [[nodiscard]] bool Wait(MonotonicNs longest_ns) override {
    // with a host only its socket is watched: the next one waits in the queue
    pollfd watched{.fd = HasHost() ? host_.get() : listener_.get(), .events = POLLIN, .revents = 0};
    const MonotonicNs wait_ns = std::max<MonotonicNs>(longest_ns, 0);
    timespec longest{};
    longest.tv_sec = wait_ns / kNsPerS;
    longest.tv_nsec = wait_ns % kNsPerS;
    if (ppoll(&watched, 1, &longest, nullptr) > 0 && !HasHost()) Accept();
    return HasHost();
  }

  [[nodiscard]] bool Read(std::string& bytes) override {
    std::array<char, 4096> buffer{};
    const ssize_t count = recv(host_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) host_ = OwnedDescriptor(-1);
    return HasHost();
  }

  [[nodiscard]] std::size_t Write(std::string_view bytes) override {
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
  setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (bind(listener.get(), address.ai_addr, address.ai_addrlen) != 0 ||
      listen(listener.get(), 1) != 0) {
    return OwnedDescriptor(-1);
  }
  return listener;
}

}  // namespace

Result<std::unique_ptr<Endpoint>> ListenTcp(const std::string& address) {
  const auto parts = Split(address);
  if (!parts) return std::unexpected(parts.error());
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int code = getaddrinfo(parts->host.c_str(), parts->port.c_str(), &hints, &found);
  if (code != 0) {
    return Usage("--tcp", "'" + address + "': " + gai_strerror(code),
                 "give 127.0.0.1:0, for example");
  }
  OwnedDescriptor listener = Listener(*found);
  const int reason = errno;
  freeaddrinfo(found);
  if (listener.get() < 0) {
    return Failed(address, std::string("cannot be listened on: ") + std::strerror(reason),
                  "give another port, or 0 for any free one");
  }
  return std::make_unique<TcpEndpoint>(std::move(listener));
}

}  // namespace haptometer::acquire::emulator
