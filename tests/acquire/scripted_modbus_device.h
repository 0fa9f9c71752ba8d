#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/sensor/modbus_sensor.h"
#include "tests/acquire/scripted_modbus_link.h"
#include "tests/acquire/sensor_rows.h"

namespace haptometer::acquire {

/// A device with registers from 0, of which each request for a reading counts the first up by one;
/// the script says when it answers and how.
class ScriptedModbusDevice {
 public:
  struct Answer {
    MonotonicNs after_ns = 2'000'000;
    int exception = 0;
    ModbusFault fault = ModbusFault::kNone;
    int off_by = 0;  ///< added to the transaction identifier
    bool is_missing = false;
    MonotonicNs again_after_ns = 0;  ///< the reply comes twice
  };

  ScriptedModbusDevice(Clock& clock, ModbusFraming framing, std::uint16_t reading_count)
      : clock_(clock), framing_(framing), reading_count_(reading_count) {}

  std::unique_ptr<ModbusLink> Link() {
    auto link = std::make_unique<tests::ScriptedModbusLink>(
        clock_, framing_,
        [this](tests::ScriptedModbusLink& to, const std::string& frame) { Take(to, frame); });
    wire = link.get();
    return link;
  }

  std::function<Answer(bool is_reading)> script = [](bool) { return Answer{}; };
  std::vector<std::uint16_t> registers = std::vector<std::uint16_t>(16);
  std::uint16_t readings = 0;  ///< requests for one so far; the value of the reply
  tests::ScriptedModbusLink* wire = nullptr;

 private:
  void Take(tests::ScriptedModbusLink& to, const std::string& frame) {
    const ParsedAdu parsed = ParseAdu(framing_, frame);
    ASSERT_EQ(parsed.state, AduState::kWhole);
    const std::uint16_t address = RegisterAt(parsed.adu.data, 0);
    const std::uint16_t count = RegisterAt(parsed.adu.data, 1);
    const bool is_reading = address == 0 && count == reading_count_;
    if (is_reading) registers[0] = ++readings;
    const Answer answer = script(is_reading);
    // one request after the other, so answers come in order
    busy_until_ns_ = std::max(busy_until_ns_, clock_.Now()) + answer.after_ns;
    if (answer.is_missing) return;
    std::string data(1, static_cast<char>(2 * count));
    for (std::size_t i = address; i < std::size_t{address} + count; ++i) {
      data += static_cast<char>(registers[i] >> 8U);
      data += static_cast<char>(registers[i] & 0xFFU);
    }
    if (answer.exception != 0) data = static_cast<char>(answer.exception);
    std::string reply;
    AppendAdu(framing_,
              {.transaction = static_cast<std::uint16_t>(parsed.adu.transaction + answer.off_by),
               .unit = parsed.adu.unit,
               .function = static_cast<std::uint8_t>(parsed.adu.function |
                                                     (answer.exception != 0 ? 0x80U : 0U)),
               .data = data},
              reply);
    to.Reply(reply, busy_until_ns_ - clock_.Now(), answer.fault);
    if (answer.again_after_ns > 0) {
      to.Reply(reply, busy_until_ns_ - clock_.Now() + answer.again_after_ns, answer.fault);
    }
  }

  Clock& clock_;
  ModbusFraming framing_;
  std::uint16_t reading_count_;
  MonotonicNs busy_until_ns_ = 0;
};

/// A profile of one register, at 115200 baud.
inline SensorProfile Plain() {
  SensorProfile profile{.name = "plain"};
  profile.wire.baud = 115200;
  return profile;
}

/// A sensor at such a device, on a manual clock.
class ModbusSensorTest : public ::testing::Test {
 protected:
  ModbusSensor& Started(const SensorProfile& profile, std::optional<double> rate_hz = {},
                        ModbusFraming framing = ModbusFraming::kRtu) {
    device_ = std::make_unique<ScriptedModbusDevice>(clock_, framing, profile.count);
    device_->registers = registers_;
    if (script_) device_->script = script_;
    sensor_ =
        std::make_unique<ModbusSensor>(device_->Link(), ModbusSetup{profile, rate_hz}, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_TRUE(started) << started.error().Text();
    begin_ns_ = sensor_->Begin();
    return *sensor_;
  }
  Reading NextRow() { return NextRowOf(*sensor_); }
  trial::SampleStatus NextStatus() { return RowStatus(NextRow()); }
  std::uint64_t Faults(ModbusFault fault) {
    return sensor_->errors().faults[static_cast<std::size_t>(fault)];
  }
  ManualClock clock_;
  std::vector<std::uint16_t> registers_ = std::vector<std::uint16_t>(16);
  std::function<ScriptedModbusDevice::Answer(bool is_reading)> script_;  ///< of the start, too
  std::unique_ptr<ScriptedModbusDevice> device_;
  std::unique_ptr<ModbusSensor> sensor_;
  MonotonicNs begin_ns_ = 0;
};

}  // namespace haptometer::acquire
