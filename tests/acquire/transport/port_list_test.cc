// Serial ports by a device tree made for the test, and what a latency timer costs.

#include "acquire/transport/port_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr MonotonicNs kMs = 1'000'000;

// an FTDI adapter at ttyUSB0 and a board's own port at ttyS0
class DeviceTree : public ::testing::Test {
 protected:
  DeviceTree() {
    MakeLink(root_ / "sys/class/tty/ttyUSB0/device/driver", "/x/bus/usb-serial/drivers/ftdi_sio");
    MakeLink(root_ / "sys/class/tty/ttyS0/device/driver", "/x/bus/pnp/drivers/serial");
    MakeLink(root_ / "dev/serial/by-id/usb-Other-if00-port0", "../../ttyUSB1");
    MakeLink(root_ / "dev/serial/by-id/usb-FTDI_FT232R_A50285BI-if00-port0", "../../ttyUSB0");
    SetTimer("16\n");
  }
  ~DeviceTree() override { fs::remove_all(root_); }
  DeviceTree(const DeviceTree&) = delete;
  DeviceTree& operator=(const DeviceTree&) = delete;
  static void MakeLink(const fs::path& link, const fs::path& target) {
    fs::create_directories(link.parent_path());
    fs::create_symlink(target, link);
  }
  void SetTimer(const std::string& text) const {
    fs::create_directories(timer_.parent_path());
    std::ofstream(timer_) << text;
  }
  [[nodiscard]] DeviceRoots Roots() const {
    return {.sysfs = root_ / "sys", .devices = root_ / "dev"};
  }
  [[nodiscard]] std::optional<MonotonicNs> Timer() const {
    return LatencyTimerNs("/dev/ttyUSB0", root_ / "sys");
  }

  const fs::path root_ =
      fs::path(::testing::TempDir()) / ("device_tree_" + std::to_string(getpid()));
  const fs::path timer_ = root_ / "sys/bus/usb-serial/devices/ttyUSB0/latency_timer";
};

TEST_F(DeviceTree, TellsLinkDriverAndLatency) {
  PortInfo port{.path = "/dev/ttyUSB0"};
  AddDeviceTree(Roots(), &port);
  EXPECT_EQ(port.by_id, root_ / "dev/serial/by-id/usb-FTDI_FT232R_A50285BI-if00-port0");
  EXPECT_EQ(port.driver, "ftdi_sio");
  EXPECT_EQ(port.latency_ns, 16 * kMs);
}

TEST_F(DeviceTree, APortOfTheBoardHasNeitherLinkNorTimer) {
  PortInfo port{.path = "/dev/ttyS0"};
  AddDeviceTree(Roots(), &port);
  EXPECT_EQ(port.by_id, "");
  EXPECT_EQ(port.driver, "serial");
  EXPECT_FALSE(port.latency_ns);
}

TEST_F(DeviceTree, AnUnknownPortIsNothing) {
  PortInfo port{.path = "/dev/ttyACM7"};
  AddDeviceTree(Roots(), &port);
  EXPECT_EQ(port.by_id + port.driver, "");
  EXPECT_FALSE(port.latency_ns);
}

TEST_F(DeviceTree, ATimerIsANumberOfEightBits) {
  for (const char* text : {"", "x\n", "-1\n", "256\n", "99999999999999999999\n"}) {
    SetTimer(text);
    EXPECT_FALSE(Timer()) << text;
  }
  SetTimer("1\n");
  EXPECT_EQ(Timer(), kMs);
  SetTimer("255\n");
  EXPECT_EQ(Timer(), 255 * kMs);
}

TEST(PortList, ListsThisComputersPorts) {
  const auto ports = ListPorts();
  ASSERT_TRUE(ports) << ports.error().Text();
  for (const PortInfo& port : *ports) EXPECT_THAT(port.path, HasSubstr("/dev/"));
}

// an exchange of a DL-RS1A is 20.67 ms at 9600 baud and 8.17 ms at 38400: with 16 ms more 27.3 and
// 41.4 a second
TEST(LatencyTimer, CostsItsTimeInEveryExchange) {
  EXPECT_REL(PolledRateHz(20'666'667, 16 * kMs), 27.3, 2e-3, "three digits");
  EXPECT_REL(PolledRateHz(8'166'667, 16 * kMs), 41.4, 2e-3, "three digits");
  EXPECT_REL(PolledRateHz(8'166'667, 0), 122.4, 1e-3, "four digits");
}

TEST(LatencyTimer, IsSaidInWholeMillisecondsWhereItIsKnown) {
  EXPECT_EQ(LatencyWords(16 * kMs, true), ", latency timer 16 ms");
  EXPECT_EQ(LatencyWords(kMs, false), ", latency timer 1 ms");
  EXPECT_EQ(LatencyWords(std::nullopt, true), ", low latency");
  EXPECT_EQ(LatencyWords(std::nullopt, false), "");
}

TEST(LatencyTimer, CostsNothingUpToAMillisecond) {
  EXPECT_TRUE(LatencyCostOf("/dev/ttyUSB3", 0, 8 * kMs).list().empty());
  EXPECT_TRUE(LatencyCostOf("/dev/ttyUSB3", kMs, 8 * kMs).list().empty());
  EXPECT_FALSE(LatencyCostOf("/dev/ttyUSB3", kMs + 1, 8 * kMs).list().empty());
}

TEST(LatencyTimer, FindsTheCost) {
  const Findings found = LatencyCostOf("/dev/ttyUSB3", 16 * kMs, 8'166'667);
  EXPECT_THAT(NumbersOf(found, FindingKind::kLatencyTimer),
              HasSubstr("port=ttyUSB3 latency_s=0.016 rate_hz=41.37"));
  EXPECT_THAT(NumbersOf(found, FindingKind::kLatencyTimer), HasSubstr(" rate_at_1_ms_hz=109.0"));
  EXPECT_TRUE(LatencyCostOf("/dev/ttyUSB3", kMs, 8'166'667).list().empty());
  // an exchange of 8 ms: 100 a second with 2 ms more, 111.1 with 1 ms
  EXPECT_EQ(NumbersOf(LatencyCostOf("/dev/ttyUSB3", 2 * kMs, 8 * kMs), FindingKind::kLatencyTimer),
            "port=ttyUSB3 latency_s=0.002 rate_hz=100 rate_at_1_ms_hz=111.111");
}

}  // namespace
}  // namespace haptometer::acquire
