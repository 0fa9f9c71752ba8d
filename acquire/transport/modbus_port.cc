#include "acquire/transport/modbus_port.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <modbus.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <span>
#include <utility>

#include "acquire/protocol/wire.h"
#include "acquire/transport/descriptor.h"
#include "acquire/transport/open_port.h"
#include "acquire/transport/port_list.h"

namespace haptometer::acquire {
namespace {

constexpr std::uint32_t kConnectTimeoutS = 5;
constexpr MonotonicNs kWriteTimeNs = kNsPerS;
constexpr std::size_t kTcpHeader = 6;         // bytes of MBAP that the length does not count
constexpr MonotonicNs kGraceNs = 20'000'000;  // an FTDI adapter hands bytes over every 16 ms

struct CloseAndFree {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};
using Context = std::unique_ptr<modbus_t, CloseAndFree>;

// libmodbus: EMBBADCRC for the CRC; other errors are wrong lengths
ModbusFault FaultOf(int error_number) {
  return error_number == EMBBADCRC ? ModbusFault::kCrc : ModbusFault::kLength;
}

// Modbus over libmodbus: it finds the ends of replies and checks the CRC.
class ModbusPort final : public ModbusLink {
 public:
  ModbusPort(Context context, OwnedDescriptor lock, std::string name, std::string source,
             MonotonicNs byte_ns, std::optional<MonotonicNs> latency_ns = std::nullopt)
      : lock_(std::move(lock)),
        context_(std::move(context)),
        descriptor_(modbus_get_socket(context_.get())),
        name_(std::move(name)),
        source_(std::move(source)),
        byte_ns_(byte_ns),
        latency_ns_(latency_ns) {}
  ModbusPort(const ModbusPort&) = delete;
  ModbusPort& operator=(const ModbusPort&) = delete;
  // other programs may open the port again
  ~ModbusPort() override { ioctl(descriptor_, TIOCNXCL); }

  bool Send(std::string_view frame) override {
    // of the request before: a new reply grows from 0
    seen_bytes_ = 0;
    if (framing() == ModbusFraming::kRtu) sent_.assign(frame);
    return WriteDescriptor(descriptor_, frame, clock_.Now() + kWriteTimeNs, name_).has_value();
  }

  // waits for the first byte, then for the rest of the reply at the baud rate of the wire
  ModbusReply Receive(std::size_t expected_bytes, MonotonicNs deadline) override {
    if (framing() == ModbusFraming::kTcp) return ReceiveTcp(deadline);
    const int events = WaitFor(descriptor_, POLLIN, deadline);
    if (events == 0) return {.arrival = ModbusArrival::kNothing};
    const int waiting = WaitingBytes();
    // readable without bytes: the port is gone
    if (waiting <= 0) return {.arrival = ModbusArrival::kGone};
    // a line that gave requests back gives this one back before the reply
    const bool is_echo_due = has_echo_ && !sent_.empty();
    if (is_echo_due) expected_bytes = sent_.size();
    // a reply whose rest is still on the wire at the deadline stays in the port, unless it has
    // stopped growing since the last look
    const auto missing =
        std::max<std::int64_t>(static_cast<std::int64_t>(expected_bytes) - waiting, 0);
    // time that the missing bytes need on the wire
    const MonotonicNs rest_ns = missing * byte_ns_;
    const bool has_grown = waiting != std::exchange(seen_bytes_, waiting);
    if (has_grown && clock_.Now() + rest_ns > deadline) {
      clock_.SleepUntil(deadline);
      return {.arrival = ModbusArrival::kNothing};
    }
    // until the rest has crossed the wire, but not behind the deadline; plus the adapter's delay
    const MonotonicNs longest_ns =
        std::min(rest_ns, std::max<MonotonicNs>(deadline - clock_.Now(), 0)) + kGraceNs;
    return is_echo_due ? TakeEcho(0, longest_ns) : Take(longest_ns);
  }

  std::size_t Flush() override {
    seen_bytes_ = 0;
    // libmodbus does not count what it discards on a serial port, and would read a socket that
    // never becomes silent without limit of time
    const int waiting = std::max(WaitingBytes(), 0);
    if (framing() == ModbusFraming::kRtu) {
      if (waiting > 0) tcflush(descriptor_, TCIOFLUSH);
      return static_cast<std::size_t>(waiting);
    }
    // TCP: only the bytes that wait now, so that the loop ends, and the reply that has begun
    std::array<char, 4096> dropped{};
    std::size_t flushed = 0;
    while (flushed < static_cast<std::size_t>(waiting)) {
      const ssize_t taken = recv(descriptor_, dropped.data(), dropped.size(), MSG_DONTWAIT);
      if (taken <= 0) break;
      flushed += static_cast<std::size_t>(taken);
    }
    return flushed + std::exchange(begun_bytes_, 0);
  }

  ModbusFraming framing() const override {
    return byte_ns_ > 0 ? ModbusFraming::kRtu : ModbusFraming::kTcp;
  }
  std::string Source() const override { return source_; }
  std::optional<MonotonicNs> LatencyTimer() const override { return latency_ns_; }
  const std::string& name() const override { return name_; }

 private:
  // below 0 where the port is gone
  int WaitingBytes() const {
    int waiting = 0;
    return ioctl(descriptor_, FIONREAD, &waiting) == 0 ? waiting : -1;
  }

  // TCP is a stream: a reply comes in pieces of any size, and its header says how long it is
  ModbusReply ReceiveTcp(MonotonicNs deadline) {
    std::size_t whole = TcpBytes();
    while (begun_bytes_ < whole) {
      const auto room = std::span(buffer_).subspan(begun_bytes_, whole - begun_bytes_);
      const ReadOutcome read = ReadDescriptor(
          descriptor_, {reinterpret_cast<char*>(room.data()), room.size()}, deadline);
      if (read.state == ReadState::kGone) return {.arrival = ModbusArrival::kGone};
      // what has come of it stays for the next call
      if (read.bytes == 0) {
        const auto fault = begun_bytes_ > 0 ? ModbusFault::kLength : ModbusFault::kNone;
        return {.arrival = ModbusArrival::kNothing, .fault = fault};
      }
      begun_bytes_ += read.bytes;
      whole = TcpBytes();
      if (whole > buffer_.size()) {
        // no Modbus, or out of step: nothing tells where the next reply begins
        Flush();
        return {.arrival = ModbusArrival::kDamaged, .fault = ModbusFault::kLength};
      }
    }
    begun_bytes_ = 0;
    return {.arrival = ModbusArrival::kFrame,
            .bytes = {reinterpret_cast<const char*>(buffer_.data()), whole}};
  }

  // Bytes of the reply that has begun, of its header before that is whole. More than a reply can
  // have where the header is none of Modbus: protocol 0, then 2 to 254 bytes.
  std::size_t TcpBytes() const {
    if (begun_bytes_ < kTcpHeader) return kTcpHeader;
    const std::size_t length = 256U * buffer_[4] + buffer_[5];
    const bool is_modbus = buffer_[2] == 0 && buffer_[3] == 0 && length >= 2;
    return is_modbus ? kTcpHeader + length : buffer_.size() + 1;
  }

  // RTU: the reply that has begun to come in, within `longest_ns`
  ModbusReply Take(MonotonicNs longest_ns) {
    seen_bytes_ = 0;
    buffer_.fill(0);
    // libmodbus takes seconds and microseconds
    const auto longest_us = static_cast<std::uint32_t>(longest_ns / 1000);
    modbus_set_response_timeout(context_.get(), longest_us / 1'000'000, longest_us % 1'000'000);
    const int bytes = modbus_receive_confirmation(context_.get(), buffer_.data());
    if (bytes > 0) {
      const std::string_view frame{reinterpret_cast<const char*>(buffer_.data()),
                                   static_cast<std::size_t>(bytes)};
      // a request is a sound frame where libmodbus takes its third byte for the right length
      if (!sent_.empty() && frame == sent_) return TakeEcho(frame.size(), 0);
      return {.arrival = ModbusArrival::kFrame, .bytes = frame};
    }
    // libmodbus ignores RTU frames of other slaves
    if (bytes == 0) return {.arrival = ModbusArrival::kDamaged, .fault = ModbusFault::kUnit};
    // errors of the frame; all others are errors of the connection
    const bool is_about_frame =
        errno == ETIMEDOUT || errno == EMBBADCRC || errno == EMBBADDATA || errno == EINTR;
    if (!is_about_frame) return {.arrival = ModbusArrival::kGone};
    const ModbusFault fault = FaultOf(errno);
    // libmodbus takes the third byte of a request, the upper one of its address, for the number of
    // bytes behind it, and leaves the rest in the port
    const std::size_t taken =
        std::min<std::size_t>(sent_.size(), errno == EMBBADDATA ? 3 : 5 + buffer_[2]);
    if (!sent_.empty() && Begins(taken)) {
      const auto rest = static_cast<MonotonicNs>(sent_.size() - taken);
      return TakeEcho(taken, rest * byte_ns_ + kGraceNs);
    }
    return {.arrival = ModbusArrival::kDamaged, .fault = fault};
  }

  // whether the first bytes that came are those of the request
  bool Begins(std::size_t bytes) const {
    return std::ranges::equal(std::span(buffer_).first(bytes), sent_.substr(0, bytes), {}, {},
                              [](char sent) { return static_cast<std::uint8_t>(sent); });
  }

  // the request that comes back, of which `taken` bytes are in the buffer; other bytes are damage
  ModbusReply TakeEcho(std::size_t taken, MonotonicNs longest_ns) {
    seen_bytes_ = 0;
    const MonotonicNs deadline = clock_.Now() + longest_ns;
    while (taken < sent_.size()) {
      const auto room = std::span(buffer_).subspan(taken, sent_.size() - taken);
      const ReadOutcome read = ReadDescriptor(
          descriptor_, {reinterpret_cast<char*>(room.data()), room.size()}, deadline);
      if (read.bytes == 0) break;
      taken += read.bytes;
    }
    has_echo_ = taken == sent_.size() && Begins(taken);
    sent_.clear();
    if (has_echo_) return {.arrival = ModbusArrival::kEcho};
    return {.arrival = ModbusArrival::kDamaged, .fault = ModbusFault::kLength};
  }

  SystemClock clock_;
  OwnedDescriptor lock_;
  Context context_;
  int descriptor_;
  std::string name_;
  std::string source_;
  MonotonicNs byte_ns_;  ///< of one character on the wire; 0: TCP
  std::optional<MonotonicNs> latency_ns_;
  std::size_t begun_bytes_ = 0;  ///< TCP: of the next reply, in the buffer
  int seen_bytes_ = 0;           ///< RTU: of a reply that has begun, at the last look
  std::string sent_;             ///< RTU: the last request, until it has come back
  bool has_echo_ = false;        ///< the request before came back
  std::array<std::uint8_t, kLongestModbusAdu> buffer_{};
};

Result<void> SetUp(modbus_t* context, const ModbusWire& wire, const std::string& name) {
  if (context == nullptr) return Failed(name, fmt::format("no Modbus: {}", modbus_strerror(errno)));
  // libmodbus reports errors and does not reconnect: ModbusSensor decides what follows
  modbus_set_error_recovery(context, MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_response_timeout(context, kConnectTimeoutS, 0);
  modbus_set_byte_timeout(context, 0, 0);  // the response timeout is for the whole reply
  if (modbus_set_slave(context, wire.slave) != 0) {
    return Usage("<slave>", fmt::format("{} is not an address on this wire", wire.slave),
                 "give 1 to 247");
  }
  return {};
}

// libmodbus waits with select(), which writes beyond its sets for large descriptors
Result<void> CheckDescriptor(modbus_t* context, const std::string& name) {
  if (modbus_get_socket(context) < FD_SETSIZE) return {};
  return Failed(name, "too many files are open in this program", "record fewer sensors at once");
}

Result<std::unique_ptr<ModbusLink>> OpenTcp(const std::string& name, const ModbusWire& wire) {
  const NetworkName parts = SplitNetworkName(name);
  Context context(modbus_new_tcp_pi(parts.host.c_str(), parts.service.c_str()));
  HAPTOMETER_TRY(SetUp(context.get(), wire, name));
  if (modbus_connect(context.get()) != 0) {
    return CannotAnswer(name, fmt::format("does not connect: {}", modbus_strerror(errno)),
                        "check that the device is on and that address and port are right");
  }
  HAPTOMETER_TRY(CheckDescriptor(context.get(), name));
  return std::make_unique<ModbusPort>(
      std::move(context), OwnedDescriptor(-1), name,
      fmt::format("Modbus TCP {} (what is behind it is not known)", name), 0);
}

// letter of libmodbus: N, E or O
char ParityLetter(Parity parity) {
  constexpr std::string_view kLetters = "NEO";
  return kLetters[static_cast<std::size_t>(parity)];
}

Result<std::unique_ptr<ModbusLink>> OpenRtu(const std::string& name, const ModbusWire& wire,
                                            bool is_virtual) {
  // exclusive use before its settings change, so that another user is not disturbed
  OwnedDescriptor lock(open(name.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (lock.get() < 0) return std::unexpected(PortDoesNotOpen(name, errno));
  HAPTOMETER_TRY(LockPort(lock.get(), name));

  // a pseudo-terminal has neither parity nor a second stop bit
  const char parity = is_virtual ? 'N' : ParityLetter(wire.parity);
  Context context(
      modbus_new_rtu(name.c_str(), wire.baud, parity, 8, is_virtual ? 1 : wire.stop_bits));
  HAPTOMETER_TRY(SetUp(context.get(), wire, name));
  if (modbus_connect(context.get()) != 0) return std::unexpected(PortDoesNotOpen(name, errno));
  HAPTOMETER_TRY(CheckDescriptor(context.get(), name));
  std::string source = fmt::format("virtual terminal {}, Modbus RTU (not a hardware port)", name);
  std::optional<MonotonicNs> latency_ns;
  if (!is_virtual) {
    const int descriptor = modbus_get_socket(context.get());
    ioctl(descriptor, TIOCEXCL);
    // timer after the setting; the kernel lists it by the port's own name, not by that of a link
    const bool is_low = AskForLowLatency(descriptor);
    std::error_code error;
    latency_ns = LatencyTimerNs(std::filesystem::canonical(name, error).string());
    source = fmt::format("device: serial port {}, Modbus RTU, {} baud 8{}{}{}", name, wire.baud,
                         parity, wire.stop_bits, LatencyWords(latency_ns, is_low));
  }
  // time of one character in ns; above 0 it marks RTU
  const MonotonicNs byte_ns = WireTimeNs(1, wire.baud, BitsPerCharacter(wire));
  auto port = std::make_unique<ModbusPort>(std::move(context), std::move(lock), name,
                                           std::move(source), byte_ns, latency_ns);
  // bytes of an earlier user
  port->Flush();
  return port;
}

}  // namespace

Result<std::unique_ptr<ModbusLink>> OpenModbusPort(const std::string& name,
                                                   const ModbusWire& wire) {
  // a host alone, which no path and no port is
  std::error_code error;
  const bool is_host = !name.empty() && name.find_first_of(":/") == std::string::npos &&
                       !std::filesystem::exists(name, error);
  // 502 is the registered port of Modbus TCP
  if (is_host) return OpenTcp(name + ":502", wire);
  HAPTOMETER_LET(const auto kind, KindOfPort(name));
  if (kind == PortKind::kNetwork) return OpenTcp(name, wire);
  return OpenRtu(name, wire, kind == PortKind::kVirtualTerminal);
}

}  // namespace haptometer::acquire
