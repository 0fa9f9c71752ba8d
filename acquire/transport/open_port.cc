#include "acquire/transport/open_port.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <libserialport.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/descriptor.h"
#include "acquire/transport/port_list.h"

namespace haptometer::acquire {
namespace {

// what all ports have in common: bytes on a descriptor, which a derived class owns
class DescriptorPort : public Transport {
 public:
  DescriptorPort(int descriptor, std::string name, std::string source)
      : descriptor_(descriptor), name_(std::move(name)), source_(std::move(source)) {}

  ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) final {
    return ReadDescriptor(descriptor_, buffer, deadline);
  }
  Result<void> Write(std::string_view bytes, MonotonicNs deadline) override {
    return WriteDescriptor(descriptor_, bytes, deadline, name_);
  }
  std::string Source() const final { return source_; }
  const std::string& name() const final { return name_; }

 private:
  int descriptor_;
  std::string name_;
  std::string source_;
};

// 8 data bits, no parity, 1 stop bit, no flow control; old bytes are discarded
sp_return Configure(sp_port* port, int baud) {
  for (const sp_return done :
       {sp_set_baudrate(port, baud), sp_set_bits(port, 8), sp_set_parity(port, SP_PARITY_NONE),
        sp_set_stopbits(port, 1), sp_set_flowcontrol(port, SP_FLOWCONTROL_NONE),
        sp_flush(port, SP_BUF_BOTH)}) {
    if (done != SP_OK) return done;
  }
  return SP_OK;
}

// libserialport's port, closed and freed with it
struct SerialHandle {
  OwnedDescriptor lock{-1};  // held from before libserialport opens the port until the end
  sp_port* port = nullptr;
  bool is_open = false;
  int descriptor = -1;  // of the open port

  SerialHandle() = default;
  SerialHandle(const SerialHandle&) = delete;
  SerialHandle& operator=(const SerialHandle&) = delete;
  ~SerialHandle() {
    // exclusive use ends here, also where another descriptor is still open
    if (descriptor >= 0) ioctl(descriptor, TIOCNXCL);
    if (is_open) sp_close(port);
    sp_free_port(port);
  }
};

// a hardware port, with the latency timer of its USB adapter where it has one
class SerialPort final : public DescriptorPort {
 public:
  SerialPort(std::unique_ptr<SerialHandle> handle, std::string name, std::string source,
             std::string path, std::optional<MonotonicNs> latency_ns)
      : DescriptorPort(handle->descriptor, std::move(name), std::move(source)),
        handle_(std::move(handle)),
        path_(std::move(path)),
        latency_ns_(latency_ns) {}

  std::optional<MonotonicNs> LatencyTimer() const override { return latency_ns_; }
  Findings LatencyCost(MonotonicNs period_ns) const override {
    return latency_ns_ ? LatencyCostOf(path_, *latency_ns_, period_ns) : Findings();
  }

 private:
  std::unique_ptr<SerialHandle> handle_;
  std::string path_;
  std::optional<MonotonicNs> latency_ns_;  // of the adapter's timer, after the setting
};

// a virtual terminal, a socket or a pipe
class PlainPort : public DescriptorPort {
 public:
  PlainPort(OwnedDescriptor descriptor, std::string name, std::string source)
      : DescriptorPort(descriptor.get(), std::move(name), std::move(source)),
        owned_(std::move(descriptor)) {}
  bool IsHardware() const final { return false; }

 private:
  OwnedDescriptor owned_;
};

// a pseudo-terminal: no baud rate, no latency timer
Result<std::unique_ptr<Transport>> OpenTerminal(const std::string& path) {
  // O_NONBLOCK: open() must not wait for a carrier
  OwnedDescriptor descriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (descriptor.get() < 0) return std::unexpected(PortDoesNotOpen(path, errno));
  HAPTOMETER_TRY(LockPort(descriptor.get(), path));
  if (!MakeRaw(descriptor.get())) return std::unexpected(PortDoesNotOpen(path, errno));
  // bytes of an earlier user
  tcflush(descriptor.get(), TCIOFLUSH);
  return std::make_unique<PlainPort>(
      std::move(descriptor), path, fmt::format("virtual terminal {} (not a hardware port)", path));
}

// 0 once connected, else the errno
int ConnectBefore(int descriptor, const addrinfo& address, MonotonicNs deadline) {
  if (connect(descriptor, address.ai_addr, address.ai_addrlen) == 0) return 0;
  // a connection that is not immediate ends with POLLOUT, or by the deadline
  if (errno != EINPROGRESS) return errno;
  SystemClock clock;
  pollfd watched{.fd = descriptor, .events = POLLOUT, .revents = 0};
  const MonotonicNs wait_ns = deadline - clock.Now();
  if (wait_ns <= 0) return ETIMEDOUT;
  const timespec timeout = TimespecOf(wait_ns);
  const int ready = ppoll(&watched, 1, &timeout, nullptr);
  if (ready < 0) return errno;
  if (ready == 0) return ETIMEDOUT;
  // POLLOUT reports success and failure alike; SO_ERROR distinguishes them
  int error_number = 0;
  socklen_t size = sizeof error_number;
  getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error_number, &size);
  return error_number;
}

// A device that lost its power ends no connection: without an answer for a minute it is lost. The
// system asks on its own where nothing is sent, so a silent device that is there stays.
void LoseWhatIsSilent(int descriptor) {
  const int on = 1, idle_s = 20, interval_s = 8, probes = 5;
  const unsigned unanswered_ms = 60'000;
  setsockopt(descriptor, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
  setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, &interval_s, sizeof interval_s);
  setsockopt(descriptor, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
  setsockopt(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, &unanswered_ms, sizeof unanswered_ms);
}

Result<std::unique_ptr<Transport>> Connect(const std::string& host, const std::string& service) {
  // for all addresses of the host together
  constexpr MonotonicNs kConnectTimeoutNs = 5 * kNsPerS;
  const std::string name = fmt::format("{}:{}", host, service);
  SystemClock clock;
  const MonotonicNs deadline = clock.Now() + kConnectTimeoutNs;

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
    // a request is a few bytes: it is sent at once, without Nagle's delay
    const int on = 1;
    setsockopt(descriptor.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    LoseWhatIsSilent(descriptor.get());
    return std::make_unique<PlainPort>(
        std::move(descriptor), name,
        fmt::format("TCP connection {} (what is behind it is not known)", name));
  }
  return CannotAnswer(
      name, fmt::format("does not connect: {}", std::generic_category().message(error_number)),
      "check that the device is on and that address and port are right");
}

// "host:64000" and "[::1]:64000", but no path
bool IsNetworkName(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  // a path with a colon, such as /dev/serial/by-path/..., is no network name
  if (colon == std::string::npos || colon == 0 || name.find('/') != std::string::npos) return false;
  const std::string port = name.substr(colon + 1);
  return !port.empty() && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; });
}

constexpr int kMostPort = 65'535;

// the slaves of pseudo-terminals have the device numbers 136 to 143 (Linux,
// admin-guide/devices.txt)
bool IsPseudoTerminal(dev_t device) { return major(device) >= 136 && major(device) <= 143; }

}  // namespace

Result<std::unique_ptr<Transport>> OpenSerialPort(const std::string& path, const std::string& name,
                                                  int baud) {
  // open
  auto handle = std::make_unique<SerialHandle>();
  if (sp_get_port_by_name(path.c_str(), &handle->port) != SP_OK) {
    return CannotAnswer(name, "is not a serial port",
                        "look for the sensor's port with: ls /dev/serial/by-id/");
  }
  // exclusive use before any setting: sp_open() changes settings, also those of another user
  handle->lock = OwnedDescriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (handle->lock.get() < 0) return std::unexpected(PortDoesNotOpen(name, errno));
  HAPTOMETER_TRY(LockPort(handle->lock.get(), name));
  if (sp_open(handle->port, SP_MODE_READ_WRITE) != SP_OK) {
    return std::unexpected(PortDoesNotOpen(name, sp_last_error_code()));
  }
  handle->is_open = true;
  sp_get_port_handle(handle->port, &handle->descriptor);
  // further open() calls of other programs fail with EBUSY
  ioctl(handle->descriptor, TIOCEXCL);

  // settings
  if (Configure(handle->port, baud) != SP_OK) {
    return CannotAnswer(name, fmt::format("cannot be set to {} baud 8N1", baud),
                        "give a <baud> that the port and the sensor have");
  }
  // an FTDI adapter keeps bytes for up to 16 ms by default; the timer is read after the setting
  const bool is_low = AskForLowLatency(handle->descriptor);
  const auto latency_ns = LatencyTimerNs(path);
  return std::make_unique<SerialPort>(std::move(handle), name,
                                      fmt::format("device: serial port {}, {} baud 8N1{}", name,
                                                  baud, LatencyWords(latency_ns, is_low)),
                                      path, latency_ns);
}

NetworkName SplitNetworkName(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  std::string host = name.substr(0, colon);
  // [::1] without its brackets
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return {std::move(host), name.substr(colon + 1)};
}

std::optional<int> TcpPort(std::string_view text) {
  // 0 to 65535; nothing for other texts
  const std::optional<std::int32_t> port = ParseDigits(text);
  return port.value_or(0) <= kMostPort ? port : std::nullopt;
}

Result<PortKind> KindOfPort(const std::string& name) {
  if (IsNetworkName(name)) {
    const std::string port = SplitNetworkName(name).service;
    // port 0 cannot be connected to
    if (TcpPort(port).value_or(0) > 0) return PortKind::kNetwork;
    return Usage(name, fmt::format("{} is not a TCP port", port),
                 fmt::format("give HOST:PORT with a port from 1 to {}", kMostPort));
  }
  struct stat status{};
  if (stat(name.c_str(), &status) != 0) return std::unexpected(PortDoesNotOpen(name, errno));
  if (!S_ISCHR(status.st_mode)) {
    return CannotAnswer(name, "is not a port", "give a serial port such as /dev/ttyUSB0");
  }
  // everything that is a character device and no pseudo-terminal is opened as a serial port
  return IsPseudoTerminal(status.st_rdev) ? PortKind::kVirtualTerminal : PortKind::kSerial;
}

Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud) {
  HAPTOMETER_LET(const auto kind, KindOfPort(name));
  if (kind == PortKind::kNetwork) {
    const NetworkName parts = SplitNetworkName(name);
    return Connect(parts.host, parts.service);
  }
  if (kind == PortKind::kVirtualTerminal) return OpenTerminal(name);
  // libserialport finds ports by the kernel's names only, so links are followed first
  const std::unique_ptr<char, decltype(&std::free)> path(realpath(name.c_str(), nullptr),
                                                         &std::free);
  return OpenSerialPort(path ? path.get() : name, name, baud);
}

namespace {

// 1 MiB, the largest that Linux allows an unprivileged process by default (pipe(7))
constexpr int kPipeBytes = 1 << 20;
constexpr const char* kRemedy =
    "pipe samples into it, e.g. my_daq | acquire <sensor> pipe <rate> 10kHz <channels> "
    "displacement:m -o trial.bin";

// a pipe is read only
class InputPipe final : public PlainPort {
 public:
  using PlainPort::PlainPort;
  Result<void> Write(std::string_view /*bytes*/, MonotonicNs /*deadline*/) override {
    return Failed(name(), "takes no bytes");
  }
};

// the output of a process group of its own, which ends with it
class CommandPipe final : public PlainPort {
 public:
  CommandPipe(OwnedDescriptor descriptor, pid_t group, const std::string& command)
      : PlainPort(std::move(descriptor), command, fmt::format("piped in by: {}", command)),
        group_(group) {}
  CommandPipe(const CommandPipe&) = delete;
  CommandPipe& operator=(const CommandPipe&) = delete;
  ~CommandPipe() override {
    SystemClock clock;
    kill(-group_, SIGTERM);
    const MonotonicNs deadline = clock.Now() + kNsPerS;
    while (waitpid(group_, nullptr, WNOHANG) == 0) {
      if (clock.Now() >= deadline) kill(-group_, SIGKILL);
      clock.SleepUntil(clock.Now() + kLookEveryNs);
    }
  }
  Result<void> Write(std::string_view /*bytes*/, MonotonicNs /*deadline*/) override {
    return Failed(name(), "takes no bytes");
  }

 private:
  static constexpr MonotonicNs kLookEveryNs = 5'000'000;
  pid_t group_;
};

}  // namespace

Result<std::unique_ptr<Transport>> OpenCommandPipe(const std::string& command) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) {
    return Failed(command, fmt::format("no pipe: {}", std::strerror(errno)));
  }
  OwnedDescriptor from(ends[0]);
  const OwnedDescriptor to(ends[1]);
  (void)fcntl(from.get(), F_SETFL, O_NONBLOCK);
  (void)fcntl(from.get(), F_SETPIPE_SZ, kPipeBytes);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, to.get(), STDOUT_FILENO);
  // a group of its own: Ctrl-C at the terminal ends the verb, which then ends the group
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  sigset_t defaults;
  sigemptyset(&defaults);
  sigaddset(&defaults, SIGPIPE);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  std::string words[] = {"sh", "-c", command};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t process = 0;
  const int failure = posix_spawn(&process, "/bin/sh", &actions, &attributes, arguments, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    return Failed(command, fmt::format("does not start: {}", std::strerror(failure)));
  }
  return std::make_unique<CommandPipe>(std::move(from), process, command);
}

Result<std::unique_ptr<Transport>> OpenInputPipe(const std::string& path) {
  const bool is_stdin = path.empty() || path == "-";
  const std::string name = is_stdin ? "standard input" : path;
  // a named pipe must not wait here for its writer
  // a copy of descriptor 0, so that closing the port leaves standard input open
  OwnedDescriptor descriptor(is_stdin ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)
                                      : open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (descriptor.get() < 0 && is_stdin) return CannotAnswer(name, "is closed", kRemedy);
  if (descriptor.get() < 0) return std::unexpected(PortDoesNotOpen(name, errno));
  // a keyboard gives no samples: the user forgot the pipe
  if (isatty(descriptor.get()) != 0) return CannotAnswer(name, "is a terminal", kRemedy);
  struct stat status{};
  if (fstat(descriptor.get(), &status) == 0 && S_ISDIR(status.st_mode)) {
    return CannotAnswer(name, "is a directory", kRemedy);
  }
  // a longer pipe holds more rows while the disk is slow; a refusal leaves the default
  (void)fcntl(descriptor.get(), F_SETPIPE_SZ, kPipeBytes);
  return std::make_unique<InputPipe>(std::move(descriptor), name,
                                     fmt::format("piped in: {}", name));
}

}  // namespace haptometer::acquire
