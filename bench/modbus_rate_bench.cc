// How often ModbusSensor asks, against a bare libmodbus loop: the same server (libmodbus's own, on
// loopback TCP), blocks of requests in turn. `ratio` is the sensor's rate over the bare loop's; the
// bar is 0.9.
#include <benchmark/benchmark.h>
#include <modbus.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "acquire/sensor/modbus_sensor.h"
#include "acquire/transport/modbus_port.h"
#include "base/error.h"

namespace haptometer::acquire {
namespace {

constexpr int kRegisters = 2;
constexpr int kRequestsPerBlock = 2000;
const std::atomic<bool> kNeverStop{false};

/// Serves one connection after the other until it goes.
class Server {
 public:
  Server() : context_(modbus_new_tcp("127.0.0.1", 0)) {
    listener_ = modbus_tcp_listen(context_, 1);
    HAPTOMETER_CHECK(listener_ >= 0, "{}", modbus_strerror(errno));
    sockaddr_in address{};
    socklen_t size = sizeof address;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    mapping_ = modbus_mapping_new(0, 0, kRegisters, 0);
    thread_ = std::thread([this] { Serve(); });
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  ~Server() {
    shutdown(listener_, SHUT_RDWR);  // ends the accept
    thread_.join();
    close(listener_);
    modbus_mapping_free(mapping_);
    modbus_free(context_);
  }
  int port = 0;

 private:
  void Serve() {
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> request{};
    while (modbus_tcp_accept(context_, &listener_) >= 0) {
      int size = 0;
      while ((size = modbus_receive(context_, request.data())) >= 0) {
        if (size > 0) modbus_reply(context_, request.data(), size, mapping_);
      }
      modbus_close(context_);
    }
  }

  modbus_t* context_;
  modbus_mapping_t* mapping_ = nullptr;
  int listener_ = -1;
  std::thread thread_;
};

MonotonicNs BareBlock(int port) {
  modbus_t* context = modbus_new_tcp("127.0.0.1", port);
  HAPTOMETER_CHECK(modbus_connect(context) == 0, "{}", modbus_strerror(errno));
  modbus_set_slave(context, 1);
  std::array<std::uint16_t, kRegisters> registers{};
  SystemClock clock;
  const MonotonicNs begin_ns = clock.Now();
  for (int i = 0; i < kRequestsPerBlock; ++i) {
    const int read = modbus_read_registers(context, 0, kRegisters, registers.data());
    HAPTOMETER_CHECK(read == kRegisters, "{}", modbus_strerror(errno));
  }
  const MonotonicNs elapsed_ns = clock.Now() - begin_ns;
  modbus_close(context);
  modbus_free(context);
  return elapsed_ns;
}

MonotonicNs SensorBlock(int port) {
  SensorProfile profile{.name = "bench"};
  profile.transport = ModbusFraming::kTcp;
  profile.count = kRegisters;
  SystemClock clock;
  auto link = OpenModbusPort("127.0.0.1:" + std::to_string(port), profile.wire);
  HAPTOMETER_CHECK(link.has_value(), "{}", link.error().Text());
  ModbusSensor sensor(std::move(*link), {.profile = profile}, clock);
  HAPTOMETER_CHECK(sensor.Start(kNeverStop).has_value(), "no answer");
  Reading reading;
  const MonotonicNs begin_ns = sensor.Begin();
  for (int rows = 0; rows < kRequestsPerBlock;) {
    rows += sensor.Next(reading) == Outcome::kReading ? 1 : 0;
    benchmark::DoNotOptimize(reading.samples.data());
  }
  return clock.Now() - begin_ns;
}

void RequestRate(benchmark::State& state) {
  const Server server;
  MonotonicNs bare_ns = 0;
  MonotonicNs sensor_ns = 0;
  while (state.KeepRunning()) {
    bare_ns += BareBlock(server.port);
    sensor_ns += SensorBlock(server.port);
  }
  const double requests = static_cast<double>(state.iterations()) * kRequestsPerBlock;
  state.counters["bare_hz"] = requests / SecondsFromNs(bare_ns);
  state.counters["sensor_hz"] = requests / SecondsFromNs(sensor_ns);
  state.counters["ratio"] = static_cast<double>(bare_ns) / static_cast<double>(sensor_ns);
}
BENCHMARK(RequestRate)->UseRealTime();

}  // namespace
}  // namespace haptometer::acquire
