// ModbusSensor through libmodbus on real pseudo-terminals and sockets, against our emulated unit
// with every fault and against libmodbus's own server.
#include "acquire/transport/modbus_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <modbus.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <future>
#include <thread>

#include "acquire/emulator/endpoint.h"
#include "acquire/emulator/modbus_unit.h"
#include "acquire/emulator/server.h"
#include "acquire/sensor/modbus_sensor.h"
#include "tests/acquire/pty_pair.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;

constexpr double kDistanceM = 0.0321;

// a float after two registers, status, timestamp: everything a profile can say, with short waits
SensorProfile Full() {
  SensorProfile profile{.name = "full"};
  profile.wire.baud = 115200;
  profile.function = 4;
  profile.address_base = 1;
  profile.address = 11;
  profile.count = 7;
  profile.value_address = 13;
  profile.type = RegisterType::kF32;
  profile.order = WordOrder::kCdab;
  profile.status_address = 12;
  profile.status_mask = 0x0004;
  profile.least_number = 1;
  profile.most_number = 1000;
  profile.timestamp_address = 16;
  profile.timestamp_count = 2;
  profile.response_timeout_ns = kNsPerS / 5;
  profile.longest_reply_ns = kNsPerS / 4;
  return profile;
}

/// An emulated unit on a pseudo-terminal or a socket, served by a thread.
class Emulation {
 public:
  Emulation(SensorProfile profile, ModbusFraming framing, const std::string& fault) {
    emulator::ModbusUnitSetup setup;
    setup.framing = framing;
    setup.head.head = emulator::HeadOf(profile);
    setup.head.head.sampling_s = 1e-6;  // a new reading each time
    setup.head.displacement = [](double) { return 0.0; };
    setup.standoff_m = kDistanceM;
    setup.profile = std::move(profile);
    if (!fault.empty()) setup.faults = *emulator::ParseFaultPlan(fault);
    device_ = std::make_unique<emulator::ModbusUnit>(std::move(setup));
    endpoint_ = framing == ModbusFraming::kRtu ? *emulator::OpenPty("")
                                               : *emulator::ListenTcp("127.0.0.1:0");
    port = endpoint_->name();
    thread_ = std::thread([this] {
      EXPECT_TRUE(emulator::Serve(*device_, *endpoint_, stop_, {}, [](const std::string&) {}));
    });
  }
  Emulation(const Emulation&) = delete;
  Emulation& operator=(const Emulation&) = delete;
  ~Emulation() {
    stop_ = true;
    thread_.join();
  }
  std::string port;

 private:
  std::unique_ptr<emulator::Device> device_;
  std::unique_ptr<emulator::Endpoint> endpoint_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A started sensor on `port`.
class Client {
 public:
  Client(const std::string& port, const SensorProfile& profile) {
    auto link = OpenModbusPort(port, profile.wire);
    EXPECT_TRUE(link) << link.error().Text();
    sensor = std::make_unique<ModbusSensor>(std::move(*link), ModbusSetup{profile, {}}, clock_);
    const auto started = sensor->Start(kNeverStop);
    EXPECT_TRUE(started) << started.error().Text();
    (void)sensor->Begin();
  }
  // the next row, or nothing when the connection is gone
  std::optional<Reading> NextRow() {
    Reading reading;
    const MonotonicNs deadline = tests::In(20);
    while (clock_.Now() < deadline) {
      const Outcome outcome = sensor->Next(reading);
      if (outcome == Outcome::kReading) return reading;
      if (outcome == Outcome::kGone) return std::nullopt;
    }
    ADD_FAILURE() << "no row in 20 s";
    return std::nullopt;
  }
  std::uint64_t Faults(ModbusFault fault) const {
    return sensor->errors().faults[static_cast<std::size_t>(fault)];
  }
  std::unique_ptr<ModbusSensor> sensor;

 private:
  SystemClock clock_;
};

// --- our own unit ---

struct FaultCase {
  const char* name;
  ModbusFraming framing;
  SampleStatus status;  ///< of the rows that it hits
  ModbusFault kind;     ///< under which it is counted; kNone: not on the wire
  int rows = 24;
};

class ModbusFaults : public ::testing::TestWithParam<FaultCase> {};

TEST_P(ModbusFaults, AreSeenAndNoOtherRowSuffers) {
  const FaultCase& fault = GetParam();
  SensorProfile profile = Full();
  if (fault.name == std::string("late")) profile.longest_reply_ns = 2 * kNsPerS;
  if (fault.framing == ModbusFraming::kTcp) profile.transport = ModbusFraming::kTcp;
  const Emulation emulation(profile, fault.framing, std::string(fault.name) + ":7");
  Client client(emulation.port, profile);
  const std::uint32_t expected = *BitsOf(kDistanceM * 1e3, RegisterType::kF32);
  int hits = 0;
  int sound = 0;
  for (int row = 0; row < fault.rows; ++row) {
    const auto reading = client.NextRow();
    ASSERT_TRUE(reading);
    const SampleStatus status = RowStatus(*reading);
    if (status == SampleStatus::kOk && reading->samples[0].raw.bits() == expected) {
      ++sound;
    } else {
      ++hits;
      // while the unit still sends the rest of a damaged answer, the next question may get none
      const bool is_expected = status == fault.status || (fault.kind == ModbusFault::kLength &&
                                                          status == SampleStatus::kLate);
      EXPECT_TRUE(is_expected) << "row " << row << ": " << trial::Name(status);
    }
  }
  EXPECT_GE(hits, 2);
  EXPECT_GE(sound, fault.rows / 3);
  if (fault.kind != ModbusFault::kNone) {
    EXPECT_GT(client.Faults(fault.kind), 0U);
  }
}

std::string NameOf(const ::testing::TestParamInfo<FaultCase>& info) {
  std::string name = info.param.name;
  std::erase(name, '-');
  return std::string(info.param.framing == ModbusFraming::kRtu ? "rtu" : "tcp") + "_" + name;
}

constexpr auto kRtu = ModbusFraming::kRtu;
constexpr auto kTcp = ModbusFraming::kTcp;

INSTANTIATE_TEST_SUITE_P(
    Rtu, ModbusFaults,
    ::testing::Values(FaultCase{"silent", kRtu, SampleStatus::kLate, ModbusFault::kTimeout},
                      FaultCase{"late", kRtu, SampleStatus::kLate, ModbusFault::kTimeout, 14},
                      FaultCase{"truncate", kRtu, SampleStatus::kBadFrame, ModbusFault::kLength},
                      FaultCase{"garbage", kRtu, SampleStatus::kBadFrame, ModbusFault::kNone},
                      FaultCase{"byte-gap", kRtu, SampleStatus::kBadFrame, ModbusFault::kLength},
                      FaultCase{"crc", kRtu, SampleStatus::kBadFrame, ModbusFault::kCrc},
                      FaultCase{"slave", kRtu, SampleStatus::kBadFrame, ModbusFault::kUnit},
                      FaultCase{"error", kRtu, SampleStatus::kDeviceError, ModbusFault::kNone},
                      FaultCase{"invalid", kRtu, SampleStatus::kInvalid, ModbusFault::kNone},
                      FaultCase{"over", kRtu, SampleStatus::kOver, ModbusFault::kNone},
                      // a float whose words are swapped is some other number: here 2.7e23
                      FaultCase{"word-order", kRtu, SampleStatus::kOver, ModbusFault::kNone}),
    NameOf);

INSTANTIATE_TEST_SUITE_P(
    Tcp, ModbusFaults,
    ::testing::Values(FaultCase{"silent", kTcp, SampleStatus::kLate, ModbusFault::kTimeout},
                      FaultCase{"truncate", kTcp, SampleStatus::kBadFrame, ModbusFault::kLength},
                      FaultCase{"slave", kTcp, SampleStatus::kBadFrame, ModbusFault::kUnit},
                      FaultCase{"transaction", kTcp, SampleStatus::kBadFrame,
                                ModbusFault::kTransaction},
                      FaultCase{"error", kTcp, SampleStatus::kDeviceError, ModbusFault::kNone},
                      FaultCase{"invalid", kTcp, SampleStatus::kInvalid, ModbusFault::kNone}),
    NameOf);

TEST(ModbusPort, EveryBuiltInSensorIsReadExactly) {
  for (const SensorProfile& profile : BuiltInProfiles()) {
    const Emulation emulation(profile, kRtu, "");
    Client client(emulation.port, profile);
    const auto reading = client.NextRow();
    ASSERT_TRUE(reading);
    const trial::ChannelFormat& channel = client.sensor->header().channels[0];
    const double distance_m =
        reading->samples[0].raw.Number(channel.encoding) * channel.scale + channel.offset;
    const double step_m = std::max(channel.resolution, kDistanceM * 0x1p-23);
    EXPECT_ABS(distance_m, kDistanceM, 0.5 * step_m, "half a step of what the register holds");
    EXPECT_EQ(RowStatus(*reading), SampleStatus::kOk) << profile.name;
  }
}

TEST(ModbusPort, AHangUpIsSeenAtOnce) {
  for (const ModbusFraming framing : {kRtu, kTcp}) {
    const Emulation emulation(Full(), framing, "disconnect:5");
    Client client(emulation.port, Full());
    int rows = 0;
    while (rows < 20 && client.NextRow()) ++rows;
    EXPECT_LT(rows, 6);
  }
}

TEST(ModbusPort, AFullPortIsWaitedFor) {
  const tests::PtyPair pair;
  auto link = OpenModbusPort(pair.path(), {});
  ASSERT_TRUE(link) << link.error().Text();
  // more than a terminal holds; the other end begins to read when it is full
  constexpr std::size_t kBytes = 200'000;
  std::atomic<bool> stop{false};
  std::size_t taken = 0;
  std::thread reader([&] {
    usleep(50'000);
    std::array<char, 4096> bytes{};
    while (!stop && taken < kBytes) {
      pollfd watched{.fd = pair.master(), .events = POLLIN, .revents = 0};
      if (poll(&watched, 1, 20) <= 0) continue;
      const ssize_t size = read(pair.master(), bytes.data(), bytes.size());
      if (size > 0) taken += static_cast<std::size_t>(size);
    }
  });
  const bool is_sent = (*link)->Send(std::string(kBytes, 'x'));
  if (!is_sent) stop = true;
  reader.join();
  EXPECT_TRUE(is_sent);
  EXPECT_EQ(taken, kBytes);
}

TEST(ModbusPort, AReplyThatStillGrowsIsLeftInThePort) {
  const tests::PtyPair pair;
  ModbusWire wire;
  wire.baud = 1200;
  auto link = OpenModbusPort(pair.path(), wire);
  ASSERT_TRUE(link) << link.error().Text();
  std::string reply;
  AppendAdu(kRtu, {.unit = 1, .function = 3, .data = std::string_view("\x02\x00\x05", 3)}, reply);
  pair.Send(reply);
  EXPECT_EQ((*link)->Receive(reply.size(), tests::In(10)).arrival, ModbusArrival::kFrame);
  // six more characters take 55 ms; at the second look nothing has been added
  pair.Send(reply.substr(0, 1));
  EXPECT_EQ((*link)->Receive(reply.size(), tests::In(0.005)).arrival, ModbusArrival::kNothing);
  const ModbusReply cut = (*link)->Receive(reply.size(), tests::In(0.005));
  EXPECT_EQ(cut.arrival, ModbusArrival::kDamaged);
  EXPECT_EQ(cut.fault, ModbusFault::kLength);
}

// An adapter with local echo: the request is there before the reply. The upper byte of the address
// is what libmodbus takes for a length.
TEST(ModbusPort, ARequestThatComesBackIsTakenOff) {
  for (const int address : {0x0000, 0x0003, 0x0007, 0x0300, 0x1000, 0xFF00}) {
    const tests::PtyPair pair;
    auto link = OpenModbusPort(pair.path(), {.baud = 115200, .parity = Parity::kNone});
    ASSERT_TRUE(link) << link.error().Text();
    const ReadRequest request{.address = static_cast<std::uint16_t>(address), .count = 2};
    std::string frame;
    AppendReadRequest(ModbusFraming::kRtu, request, frame);
    std::string reply;
    AppendAdu(ModbusFraming::kRtu, {.unit = 1, .function = 3, .data = "\x04\x12\x34\x56\x78"},
              reply);
    int sound = 0;
    for (int row = 0; row < 4; ++row) {
      (*link)->Flush();
      ASSERT_TRUE((*link)->Send(frame));
      ASSERT_EQ(pair.Receive(frame.size()), frame);
      // in pieces, as it comes over the wire
      pair.Send(frame.substr(0, 3));
      pair.Send(frame.substr(3));
      EXPECT_EQ((*link)->Receive(reply.size(), tests::In(1)).arrival, ModbusArrival::kEcho)
          << address << " row " << row;
      pair.Send(reply);
      const ModbusReply got = (*link)->Receive(reply.size(), tests::In(1));
      if (got.arrival == ModbusArrival::kFrame && got.bytes == reply) ++sound;
    }
    EXPECT_EQ(sound, 4) << address;
    // without echo again, the first reply is damaged and the next ones are sound
    for (int row = 0; row < 2; ++row) {
      (*link)->Flush();
      ASSERT_TRUE((*link)->Send(frame));
      ASSERT_EQ(pair.Receive(frame.size()), frame);
      pair.Send(reply);
      EXPECT_EQ((*link)->Receive(reply.size(), tests::In(1)).arrival,
                row == 0 ? ModbusArrival::kDamaged : ModbusArrival::kFrame);
    }
  }
}

// echo and reply may wait together when the adapter hands them over
TEST(ModbusPort, ASensorBehindAnAdapterWithEchoIsRead) {
  const tests::PtyPair pair;
  std::atomic<bool> stop{false};
  std::thread device([&] {
    while (!stop) {
      pollfd waiting{.fd = pair.master(), .events = POLLIN, .revents = 0};
      if (poll(&waiting, 1, 20) != 1) continue;
      const std::string frame = pair.Receive(8);
      // nobody has the port open
      if (frame.size() < 8) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        continue;
      }
      const ParsedAdu asked = ParseAdu(ModbusFraming::kRtu, frame);
      const auto count = RegisterAt(asked.adu.data, 1);
      std::string bytes = frame;
      AppendAdu(ModbusFraming::kRtu,
                {.unit = 1,
                 .function = 3,
                 .data = static_cast<char>(2 * count) + std::string(std::size_t{2} * count, '\1')},
                bytes);
      pair.Send(bytes);
    }
  });
  SensorProfile profile{.name = "plain"};
  profile.wire.baud = 115200;
  {
    Client client(pair.path(), profile);
    for (int row = 0; row < 5; ++row) {
      const auto reading = client.NextRow();
      ASSERT_TRUE(reading);
      EXPECT_EQ(reading->samples[0].status, SampleStatus::kOk);
      EXPECT_EQ(reading->samples[0].raw.Number(trial::Encoding::kI32), 0x0101);
    }
    EXPECT_TRUE(client.sensor->Found().Has(FindingKind::kEcho));
    EXPECT_FALSE(client.sensor->Found().Has(FindingKind::kWireErrors));
  }
  stop = true;
  device.join();
}

TEST(ModbusPort, APortThatIsInUseIsRefused) {
  const tests::PtyPair pair;
  const auto first = OpenModbusPort(pair.path(), {});
  ASSERT_TRUE(first) << first.error().Text();
  const auto second = OpenModbusPort(pair.path(), {});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().Text(), HasSubstr("is busy"));
}

TEST(ModbusPort, SaysWhatIsNotThere) {
  EXPECT_THAT(OpenModbusPort("/dev/no-such-port", {}).error().Text(), HasSubstr("is not there"));
  EXPECT_THAT(OpenModbusPort("/dev/null", {}).error().Text(), HasSubstr("does not open"));
  EXPECT_THAT(OpenModbusPort("127.0.0.1:1", {}).error().Text(), HasSubstr("does not connect"));
}

// --- TCP in pieces ---

/// A connection on which the test plays the device.
class TcpPeer {
 public:
  TcpPeer() : listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    auto opened = OpenModbusPort("127.0.0.1:" + std::to_string(ntohs(address.sin_port)), {});
    EXPECT_TRUE(opened) << opened.error().Text();
    link = std::move(*opened);
    peer_ = accept(listener_, nullptr, nullptr);
  }
  TcpPeer(const TcpPeer&) = delete;
  TcpPeer& operator=(const TcpPeer&) = delete;
  ~TcpPeer() {
    HangUp();
    close(listener_);
  }
  void Sends(std::string_view bytes) const {
    EXPECT_EQ(send(peer_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  }
  void HangUp() {
    if (peer_ >= 0) close(std::exchange(peer_, -1));
  }
  std::unique_ptr<ModbusLink> link;

 private:
  int listener_;
  int peer_ = -1;
};

// a reply to request 7 with the float of two registers
constexpr std::string_view kReply("\0\7\0\0\0\7\1\4\4\x7c\x37\x42\x8b", 13);

TEST(ModbusPort, ATcpReplyComesInAnyPieces) {
  for (std::size_t first = 1; first < kReply.size(); ++first) {
    TcpPeer peer;
    peer.Sends(kReply.substr(0, first));
    const ModbusReply part = peer.link->Receive(kReply.size(), tests::In(0.03));
    EXPECT_EQ(part.arrival, ModbusArrival::kNothing) << first;
    EXPECT_EQ(part.fault, ModbusFault::kLength) << first;
    // the rest later than any grace, and a second reply behind it
    peer.Sends(std::string(kReply.substr(first)) + std::string(kReply));
    for (int reply = 0; reply < 2; ++reply) {
      const ModbusReply whole = peer.link->Receive(kReply.size(), tests::In(5));
      EXPECT_EQ(whole.arrival, ModbusArrival::kFrame) << first;
      EXPECT_EQ(whole.bytes, kReply) << first;
    }
  }
}

TEST(ModbusPort, AByteAtATimeIsOneTcpReply) {
  TcpPeer peer;
  std::thread device([&] {
    for (const char& byte : kReply) {
      peer.Sends({&byte, 1});
      usleep(5000);
    }
  });
  const ModbusReply reply = peer.link->Receive(kReply.size(), tests::In(5));
  device.join();
  EXPECT_EQ(reply.arrival, ModbusArrival::kFrame);
  EXPECT_EQ(reply.bytes, kReply);
}

TEST(ModbusPort, AHeaderThatIsNoneOfModbusIsDamageAtOnce) {
  // 255 bytes, 1 byte, and another protocol
  for (const std::string_view header :
       {std::string_view("\0\7\0\0\0\xff", 6), std::string_view("\0\7\0\0\0\1", 6),
        std::string_view("\0\7\0\1\0\7", 6)}) {
    TcpPeer peer;
    peer.Sends(std::string(header) + "rest");
    const MonotonicNs late = tests::In(5);
    EXPECT_EQ(peer.link->Receive(kReply.size(), late).arrival, ModbusArrival::kDamaged);
    EXPECT_GT(late, tests::In(3)) << "not at the deadline";
    // what waits behind it goes with it
    peer.Sends(kReply);
    EXPECT_EQ(peer.link->Receive(kReply.size(), late).bytes, kReply);
  }
  // 254 bytes are allowed
  TcpPeer peer;
  const std::string longest = std::string("\0\7\0\0\0\xfe", 6) + std::string(254, 'x');
  peer.Sends(longest);
  EXPECT_EQ(peer.link->Receive(kReply.size(), tests::In(5)).bytes, longest);
}

TEST(ModbusPort, APartOfATcpReplyIsFlushedToo) {
  TcpPeer peer;
  peer.Sends(kReply.substr(0, 5));
  EXPECT_EQ(peer.link->Receive(kReply.size(), tests::In(0.03)).fault, ModbusFault::kLength);
  EXPECT_EQ(peer.link->Flush(), 5U);
  peer.Sends(kReply);
  EXPECT_EQ(peer.link->Receive(kReply.size(), tests::In(5)).bytes, kReply);
  peer.Sends(kReply.substr(0, 5));
  peer.HangUp();
  EXPECT_EQ(peer.link->Receive(kReply.size(), tests::In(5)).arrival, ModbusArrival::kGone);
}

// --- libmodbus's own server ---

/// libmodbus's server with input registers 0 to 9, of which the first two are a float in order
/// CDAB; served by a thread.
class LibmodbusServer {
 public:
  explicit LibmodbusServer(modbus_t* context) : context_(context) {
    mapping_ = modbus_mapping_new(0, 0, 0, 10);
    mapping_->tab_input_registers[0] = 0x7C37;
    mapping_->tab_input_registers[1] = 0x428B;
    modbus_set_slave(context_, 1);
  }
  LibmodbusServer(const LibmodbusServer&) = delete;
  LibmodbusServer& operator=(const LibmodbusServer&) = delete;
  ~LibmodbusServer() {
    stop_ = true;
    thread_.join();
    modbus_close(context_);
    modbus_free(context_);
    modbus_mapping_free(mapping_);
  }
  void Serve() {
    modbus_set_indication_timeout(context_, 0, 50'000);
    thread_ = std::thread([this] {
      std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
      while (!stop_) {
        const int size = modbus_receive(context_, request.data());
        if (size > 0) modbus_reply(context_, request.data(), size, mapping_);
      }
    });
  }

 private:
  modbus_t* context_;
  modbus_mapping_t* mapping_ = nullptr;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

void ExpectBaumersExample(const std::string& port) {
  SensorProfile profile{.name = "example"};
  profile.wire.parity = Parity::kNone;
  profile.wire.baud = 115200;
  profile.function = 4;
  profile.count = 2;
  profile.type = RegisterType::kF32;
  profile.order = WordOrder::kCdab;
  Client client(port, profile);
  // a server that the machine does not run for a second is late, and the row says so
  constexpr int kMostLate = 3;
  int answered = 0;
  for (int row = 0; row < 50 + kMostLate && answered < 50; ++row) {
    const auto reading = client.NextRow();
    ASSERT_TRUE(reading);
    if (RowStatus(*reading) == SampleStatus::kLate) continue;
    EXPECT_EQ(RowStatus(*reading), SampleStatus::kOk);
    EXPECT_EQ(reading->samples[0].raw.bits(), 0x428B7C37U);
    ++answered;
  }
  EXPECT_EQ(answered, 50);
}

TEST(ModbusPort, ReadsLibmodbussServerOverTcp) {
  modbus_t* context = modbus_new_tcp("127.0.0.1", 0);
  int listener = modbus_tcp_listen(context, 1);
  ASSERT_GE(listener, 0);
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ASSERT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  LibmodbusServer server(context);
  auto accepted = std::async(std::launch::async, [&] {
    modbus_tcp_accept(context, &listener);
    server.Serve();
  });
  ExpectBaumersExample("127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  accepted.get();
  close(listener);
}

TEST(ModbusPort, ReadsLibmodbussServerOverRtu) {
  // two terminals, joined by a thread as a null modem would
  const tests::PtyPair ours;
  const tests::PtyPair theirs;
  std::atomic<bool> stop{false};
  std::thread wire([&] {
    while (!stop) {
      std::array<pollfd, 2> watched{pollfd{.fd = ours.master(), .events = POLLIN, .revents = 0},
                                    pollfd{.fd = theirs.master(), .events = POLLIN, .revents = 0}};
      if (poll(watched.data(), watched.size(), 20) <= 0) continue;
      std::array<char, 512> bytes{};
      for (std::size_t from = 0; from < 2; ++from) {
        if ((watched[from].revents & POLLIN) == 0) continue;
        const ssize_t size = read(watched[from].fd, bytes.data(), bytes.size());
        if (size > 0) {
          EXPECT_EQ(write(watched[1 - from].fd, bytes.data(), static_cast<std::size_t>(size)),
                    size);
        }
      }
      usleep(200);  // a terminal that nobody has open reports a hang-up without pause
    }
  });
  {
    modbus_t* context = modbus_new_rtu(theirs.path().c_str(), 115200, 'N', 8, 1);
    LibmodbusServer server(context);
    EXPECT_EQ(modbus_connect(context), 0);
    server.Serve();
    ExpectBaumersExample(ours.path());
  }
  stop = true;
  wire.join();
}

}  // namespace
}  // namespace haptometer::acquire
