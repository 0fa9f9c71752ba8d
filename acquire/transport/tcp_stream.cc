#include "acquire/transport/tcp_stream.h"

#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace haptometer::acquire {
namespace {

// 0 once connected, else the errno
int ConnectBefore(int descriptor, const addrinfo& address, MonotonicNs deadline) {
  if (connect(descriptor, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  SystemClock clock;
  pollfd watched{.fd = descriptor, .events = POLLOUT, .revents = 0};
  const MonotonicNs wait_ns = deadline - clock.Now();
  if (wait_ns <= 0) return ETIMEDOUT;
  const timespec timeout{.tv_sec = wait_ns / kNsPerS, .tv_nsec = wait_ns % kNsPerS};
  const int ready = ppoll(&watched, 1, &timeout, nullptr);
  if (ready < 0) return errno;
  if (ready == 0) return ETIMEDOUT;
  int error_number = 0;
  socklen_t size = sizeof error_number;
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error_number, &size);
  return error_number;
}

}  // namespace

TcpStream::TcpStream(OwnedDescriptor descriptor, std::string name)
    : descriptor_(std::move(descriptor)), name_(std::move(name)) {}

Result<std::unique_ptr<Transport>> TcpStream::Connect(const std::string& host,
                                                      const std::string& service,
                                                      MonotonicNs timeout_ns) {
  const std::string name = fmt::format("{}:{}", host, service);
  SystemClock clock;
  const MonotonicNs deadline = clock.Now() + timeout_ns;

  // the host's addresses
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int failed = getaddrinfo(host.c_str(), service.c_str(), &hints, &found); failed != 0) {
    return CannotAnswer(name, fmt::format("the host is not known: {}", gai_strerror(failed)),
                        "give HOST:PORT with a name or an address that exists");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, freeaddrinfo);

  // the first that takes the connection
  int error_number = 0;
  for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
    OwnedDescriptor descriptor(
        socket(at->ai_family, at->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, at->ai_protocol));
    error_number = descriptor.get() < 0 ? errno : ConnectBefore(descriptor.get(), *at, deadline);
    if (error_number != 0) continue;
    const int on = 1;
    setsockopt(descriptor.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return std::unique_ptr<Transport>(new TcpStream(std::move(descriptor), name));
  }
  return CannotAnswer(
      name, fmt::format("does not connect: {}", std::generic_category().message(error_number)),
      "check that the device is on and that address and port are right");
}

ReadOutcome TcpStream::Read(std::span<char> buffer, MonotonicNs deadline) {
  return ReadDescriptor(descriptor_.get(), buffer, deadline);
}

Result<void> TcpStream::Write(std::string_view bytes, MonotonicNs deadline) {
  return WriteDescriptor(descriptor_.get(), bytes, deadline, name_);
}

std::string TcpStream::Source() const {
  return fmt::format("TCP connection {} (what is behind it is not known)", name_);
}

}  // namespace haptometer::acquire
