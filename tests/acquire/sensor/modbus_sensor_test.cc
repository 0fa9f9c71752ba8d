// A Modbus sensor on a scripted link and a manual clock: what may come, and what it means.
#include "acquire/sensor/modbus_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/acquire/scripted_modbus_device.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;

// --- what else may come ---

TEST_F(ModbusSensorTest, TheHeaderHasTheAdaptersTimer) {
  EXPECT_EQ(Started(Plain()).header().metadata.fields.at("latency_timer_s"), "0.016");
}

TEST_F(ModbusSensorTest, ARowHasTheTimesOfRequestAndReply) {
  Started(Plain());
  const Reading reading = NextRow();
  EXPECT_EQ(RowStatus(reading), SampleStatus::kOk);
  EXPECT_EQ(reading.reply_ns - reading.time_ns, 2 * kMs);
  // the silent interval lies between a reply and the next request
  EXPECT_GE(NextRow().time_ns - reading.reply_ns, 1'750'000);
}

TEST_F(ModbusSensorTest, AMissingReplyIsLateAndAnExceptionADeviceError) {
  Started(Plain());
  device_->script = [&](bool is_reading) {
    return ScriptedModbusDevice::Answer{.exception = is_reading && device_->readings == 3 ? 4 : 0,
                                        .is_missing = is_reading && device_->readings == 2};
  };
  EXPECT_EQ(NextStatus(), SampleStatus::kLate);
  EXPECT_EQ(NextStatus(), SampleStatus::kDeviceError);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(Faults(ModbusFault::kTimeout), 1U);
  EXPECT_EQ(sensor_->errors().exceptions[4], 1U);
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kWireErrors),
            "errors=1 timeout, 1 exception 04 (device failure)");
}

TEST_F(ModbusSensorTest, DamageIsABadFrameCountedByKind) {
  Started(Plain());
  for (const auto fault : {ModbusFault::kCrc, ModbusFault::kLength, ModbusFault::kUnit}) {
    int number = 0;
    device_->script = [&](bool) {
      return ScriptedModbusDevice::Answer{.fault = ++number == 1 ? fault : ModbusFault::kNone};
    };
    EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
    EXPECT_EQ(NextStatus(), SampleStatus::kOk);
    EXPECT_EQ(Faults(fault), 1U);
  }
}

TEST_F(ModbusSensorTest, AWireThatNeverFallsSilentGivesBadRows) {
  Started(Plain());
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  for (int i = 0; i < 1000; ++i)
    device_->wire->Reply("?", kMs * (1 + MonotonicNs{10} * i), ModbusFault::kLength);
  int bad = 0;
  const MonotonicNs until_ns = clock_.Now() + 9 * kNsPerS;
  while (clock_.Now() < until_ns) bad += NextStatus() == SampleStatus::kBadFrame ? 1 : 0;
  EXPECT_GE(bad, 4) << "9 s of it";
}

TEST_F(ModbusSensorTest, AHangUpEndsIt) {
  Started(Plain());
  device_->wire->HangUp();
  Reading reading;
  EXPECT_EQ(sensor_->Next(reading), Outcome::kGone);
}

TEST_F(ModbusSensorTest, NextWaitsATenthOfASecondAtMost) {
  SensorProfile profile = Plain();
  profile.response_timeout_ns = profile.longest_reply_ns = 3 * kNsPerS;
  Started(profile, 0.2);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.is_missing = true}; };
  Reading reading;
  for (int call = 0; call < 200; ++call) {
    const MonotonicNs before_ns = clock_.Now();
    (void)sensor_->Next(reading);
    ASSERT_LE(clock_.Now() - before_ns, 100 * kMs);
  }
}

TEST_F(ModbusSensorTest, TheRateIsAGridThatDoesNotDrift) {
  Started(Plain(), 50);
  (void)NextRow();  // behind the start's silent interval
  const MonotonicNs first_ns = NextRow().time_ns;
  for (int row = 1; row < 500; ++row)
    EXPECT_EQ(NextRow().time_ns, first_ns + MonotonicNs{20} * row * kMs);
}

// the next poll is due long after the last reply's timeout
TEST_F(ModbusSensorTest, ARateBelowTheTimeoutsGivesNoLateRows) {
  Started(Plain(), 0.5);
  (void)NextRow();
  const MonotonicNs first_ns = NextRow().time_ns;
  for (int row = 1; row < 5; ++row) {
    const Reading reading = NextRow();
    EXPECT_EQ(RowStatus(reading), SampleStatus::kOk);
    EXPECT_EQ(reading.time_ns, first_ns + MonotonicNs{2000} * row * kMs);
  }
  EXPECT_EQ(Faults(ModbusFault::kTimeout), 0U);
}

TEST(ModbusErrors, AreAllInWords) {
  ModbusErrors errors;
  for (std::size_t fault = 1; fault < kModbusFaultCount; ++fault) errors.faults[fault] = fault;
  errors.exceptions[2] = 9;
  EXPECT_EQ(InWords(errors),
            "1 timeout, 2 wrong CRC, 3 wrong length, 4 wrong slave, 5 wrong function, "
            "6 wrong transaction, 9 exception 02 (illegal data address)");
}

// --- what the registers mean ---

TEST_F(ModbusSensorTest, AScaleRegisterIsReadOnce) {
  // RIFTEK RF602: D S / 16384 mm
  SensorProfile profile = BuiltInProfiles()[1];
  ASSERT_EQ(profile.name, "riftek-rf602");
  registers_[5] = 50;
  registers_[6] = 0x4000;
  Started(profile);
  const Reading reading = NextRow();
  const trial::ChannelFormat& channel = sensor_->header().channels[0];
  EXPECT_EQ(RowStatus(reading), SampleStatus::kOk);
  EXPECT_REL(reading.samples[0].raw.Number(channel.encoding) * channel.scale, 50e-3, 1e-15,
             "16384 counts are the end of the range; one rounding a product");
  device_->registers[6] = 0;
  EXPECT_EQ(NextStatus(), SampleStatus::kInvalid);
  device_->registers[6] = 16385;
  EXPECT_EQ(NextStatus(), SampleStatus::kOver);
}

TEST_F(ModbusSensorTest, AFloatIsKeptAsItWasSentEvenANan) {
  SensorProfile profile = Plain();
  profile.type = RegisterType::kF32;
  profile.order = WordOrder::kCdab;
  profile.count = 3;
  profile.value_address = 1;
  registers_[1] = 0x7C37;
  registers_[2] = 0x428B;
  Started(profile);
  Reading reading = NextRow();
  EXPECT_EQ(reading.samples[0].raw.bits(), 0x428B7C37U);
  EXPECT_EQ(RowStatus(reading), SampleStatus::kOk);
  device_->registers[1] = 0x2345;
  device_->registers[2] = 0x7F81;  // a signalling NaN
  reading = NextRow();
  EXPECT_EQ(reading.samples[0].raw.bits(), 0x7F812345U);
  EXPECT_EQ(RowStatus(reading), SampleStatus::kInvalid);
}

TEST_F(ModbusSensorTest, UnsignedDoubleWordsAreExact) {
  SensorProfile profile = Plain();
  profile.type = RegisterType::kU32;
  profile.count = 3;
  profile.value_address = 1;
  registers_[1] = 0xFFFF;
  registers_[2] = 0xFFFE;
  Started(profile);
  EXPECT_EQ(NextRow().samples[0].raw.Number(trial::Encoding::kF64), 4294967294.0);
}

TEST_F(ModbusSensorTest, StatusBitsAndTimestampsBecomeStatuses) {
  SensorProfile profile = Plain();
  profile.count = 4;
  profile.status_address = 1;
  profile.status_mask = 0x0002;
  profile.timestamp_address = 2;
  profile.timestamp_count = 2;
  Started(profile);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(NextStatus(), SampleStatus::kRepeated);
  device_->registers[3] = 1;
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  device_->registers[1] = 0x0001;  // not in the mask
  device_->registers[3] = 2;
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  device_->registers[1] = 0x0003;
  EXPECT_EQ(NextStatus(), SampleStatus::kInvalid);
}

// --- the start ---

TEST_F(ModbusSensorTest, SilenceAtTheStartSaysWhatToCheck) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  int requests = 0;
  device_->script = [&](bool) {
    ++requests;
    return ScriptedModbusDevice::Answer{.is_missing = true};
  };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(requests, 3) << "each waits for the longest reply";
  EXPECT_THAT(started.error().Text(),
              HasSubstr("nothing answers to slave 1, function 03, 1 registers from 0 at 115200 "
                        "baud, parity even; check that the sensor is on, <slave>"));
}

TEST_F(ModbusSensorTest, AnExceptionAtTheStartIsTold) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.exception = 2}; };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("exception 02 (illegal data address)"));
}

TEST_F(ModbusSensorTest, FindsWhatTheWireAllows) {
  Started(Plain());
  const std::string rate = NumbersOf(sensor_->Found(), FindingKind::kRegistersRate);
  EXPECT_THAT(rate, ::testing::AllOf(HasSubstr(" rate_hz=202."), HasSubstr(" observable_hz=79.")));
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kRegistersTooSlow),
            "rate_hz=285.714 needed_hz=1280");
  // the same profile over TCP has no RTU wire
  Started(Plain(), {}, ModbusFraming::kTcp);
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kRegistersRate));
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kRegistersTooSlow));
}

}  // namespace
}  // namespace haptometer::acquire
