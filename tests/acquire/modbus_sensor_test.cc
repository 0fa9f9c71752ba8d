// A Modbus sensor on a scripted link and a manual clock: every way in which a reply can come, or
// not.
#include "acquire/sensor/modbus_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "tests/acquire/scripted_modbus_link.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using tests::ScriptedModbusLink;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;
const std::atomic<bool> kNeverStop{false};

/// A device with registers from 0, of which each request for a reading counts the first up by one;
/// the script says when it answers and how.
class Device {
 public:
  struct Answer {
    MonotonicNs after_ns = 2 * kMs;
    int exception = 0;
    ModbusFault fault = ModbusFault::kNone;
    int off_by = 0;  ///< added to the transaction identifier
    bool is_missing = false;
  };

  Device(Clock& clock, ModbusFraming framing, std::uint16_t reading_count)
      : clock_(clock), framing_(framing), reading_count_(reading_count) {}

  std::unique_ptr<ModbusLink> Link() {
    auto link = std::make_unique<ScriptedModbusLink>(
        clock_, framing_,
        [this](ScriptedModbusLink& to, const std::string& frame) { Take(to, frame); });
    wire = link.get();
    return link;
  }

  std::function<Answer(bool is_reading)> script = [](bool) { return Answer{}; };
  std::vector<std::uint16_t> registers = std::vector<std::uint16_t>(16);
  std::uint16_t readings = 0;  ///< requests for one so far; the value of the reply
  ScriptedModbusLink* wire = nullptr;

 private:
  void Take(ScriptedModbusLink& to, const std::string& frame) {
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
  }

  Clock& clock_;
  ModbusFraming framing_;
  std::uint16_t reading_count_;
  MonotonicNs busy_until_ns_ = 0;
};

SensorProfile Plain() {
  SensorProfile profile{.name = "plain"};
  profile.wire.baud = 115200;
  return profile;
}

class ModbusSensorTest : public ::testing::Test {
 protected:
  ModbusSensor& Started(const SensorProfile& profile, std::optional<double> rate_hz = {},
                        ModbusFraming framing = ModbusFraming::kRtu) {
    device_ = std::make_unique<Device>(clock_, framing, profile.count);
    device_->registers = registers_;
    if (script_) device_->script = script_;
    sensor_ =
        std::make_unique<ModbusSensor>(device_->Link(), ModbusSetup{profile, rate_hz}, clock_);
    const auto started = sensor_->Start(kNeverStop);
    EXPECT_TRUE(started) << started.error().Text();
    begin_ns_ = sensor_->Begin();
    return *sensor_;
  }
  Reading NextRow() {
    Reading reading;
    for (int call = 0; call < 1000; ++call) {
      if (sensor_->Next(reading) == Outcome::kReading) return reading;
    }
    ADD_FAILURE() << "no row";
    reading.samples.resize(1);
    return reading;
  }
  SampleStatus NextStatus() { return RowStatus(NextRow()); }
  std::uint64_t Faults(ModbusFault fault) {
    return sensor_->errors().faults[static_cast<std::size_t>(fault)];
  }
  // rows until `late` of them came without a reading; each reading belongs to its request
  void ExpectNoneMisattributed(int late) {
    Reading reading;
    int bad = 0;
    int sound = 0;
    int wrong = 0;
    for (int call = 0; call < 1'000'000 && bad < late; ++call) {
      const Outcome outcome = sensor_->Next(reading);
      ASSERT_NE(outcome, Outcome::kGone) << "after " << bad << " bad rows";
      if (outcome != Outcome::kReading) continue;
      if (RowStatus(reading) != SampleStatus::kOk) {
        ++bad;
        continue;
      }
      ++sound;
      // the device's count when this row's request reached it is what this row must hold
      wrong += reading.samples[0].raw.bits() != device_->readings;
    }
    EXPECT_EQ(bad, late);
    EXPECT_GT(sound, late / 20);
    EXPECT_EQ(wrong, 0);
  }

  ManualClock clock_;
  std::vector<std::uint16_t> registers_ = std::vector<std::uint16_t>(16);
  std::function<Device::Answer(bool is_reading)> script_;  ///< of the start, too
  std::unique_ptr<Device> device_;
  std::unique_ptr<ModbusSensor> sensor_;
  MonotonicNs begin_ns_ = 0;
};

// --- the rule: a late reply is never the next reading ---

TEST_F(ModbusSensorTest, AThousandLateRtuRepliesAreNeverTheNextReading) {
  Started(Plain());
  // late by anything up to four times the wait after which no reply should come any more
  std::mt19937 random(7);
  std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 4000 * kMs);
  device_->script = [&](bool is_reading) {
    return Device::Answer{.after_ns = is_reading && random() % 2 == 0 ? late_ns(random) : 2 * kMs};
  };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusSensorTest, NorWhenChecksAreLateToo) {
  Started(Plain());
  std::mt19937 random(8);
  std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 4000 * kMs);
  device_->script = [&](bool) {
    return Device::Answer{.after_ns = random() % 3 == 0 ? late_ns(random) : 2 * kMs,
                          .exception = random() % 7 == 0 ? 6 : 0};
  };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusSensorTest, NorWithinTheLongestReplyWhenChecksAreRefusedOrIgnored) {
  for (const bool is_ignored : {false, true}) {
    std::mt19937 random(8);
    std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 950 * kMs);
    script_ = [&, is_ignored](bool is_reading) {
      return Device::Answer{.after_ns = random() % 3 == 0 ? late_ns(random) : 2 * kMs,
                            .exception = is_reading ? 0 : 2,
                            .is_missing = !is_reading && is_ignored};
    };
    Started(Plain());
    ExpectNoneMisattributed(1000);
    EXPECT_THAT(sensor_->Remarks(), Contains(HasSubstr("replies later than 1 s cannot be told")));
  }
}

TEST_F(ModbusSensorTest, AThousandLateTcpRepliesAreNeverTheNextReading) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  std::mt19937 random(9);
  std::uniform_int_distribution<MonotonicNs> late_ns(501 * kMs, 900 * kMs);
  device_->script = [&](bool) {
    return Device::Answer{.after_ns = random() % 8 == 0 ? late_ns(random) : 2 * kMs};
  };
  ExpectNoneMisattributed(1000);
  EXPECT_GT(Faults(ModbusFault::kTransaction), 100U);
}

TEST_F(ModbusSensorTest, WrongTransactionsAreNeverReadings) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  int number = 0;
  device_->script = [&](bool) { return Device::Answer{.off_by = ++number % 3 == 0 ? -1 : 0}; };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusSensorTest, APeerThatStaysOffByOneIsAConnectionLost) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  device_->script = [](bool) { return Device::Answer{.off_by = -1}; };
  Reading reading;
  int rows = 0;
  Outcome outcome = Outcome::kNothing;
  for (int call = 0; call < 1000 && outcome != Outcome::kGone; ++call) {
    outcome = sensor_->Next(reading);
    if (outcome != Outcome::kReading) continue;
    ++rows;
    EXPECT_EQ(RowStatus(reading), SampleStatus::kBadFrame);
  }
  EXPECT_EQ(outcome, Outcome::kGone);
  EXPECT_EQ(rows, 8);
}

TEST_F(ModbusSensorTest, ASilentDeviceIsAskedUntilItAnswers) {
  Started(Plain());
  int number = 0;
  device_->script = [&](bool) { return Device::Answer{.is_missing = ++number <= 5}; };
  for (int row = 0; row < 5; ++row) EXPECT_EQ(NextStatus(), SampleStatus::kLate);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
}

TEST_F(ModbusSensorTest, AfterSilenceAtTheStartOldRepliesAreNoReadings) {
  device_ = std::make_unique<Device>(clock_, ModbusFraming::kRtu, 1);
  int number = 0;
  device_->script = [&](bool) {
    return Device::Answer{.after_ns = ++number == 1 ? 1500 * kMs : 2 * kMs};
  };
  sensor_ = std::make_unique<ModbusSensor>(device_->Link(), ModbusSetup{Plain(), {}}, clock_);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  (void)sensor_->Begin();
  EXPECT_EQ(NextRow().samples[0].raw.bits(), device_->readings);
}

// --- what else may come ---

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
    return Device::Answer{.exception = is_reading && device_->readings == 3 ? 4 : 0,
                          .is_missing = is_reading && device_->readings == 2};
  };
  EXPECT_EQ(NextStatus(), SampleStatus::kLate);
  EXPECT_EQ(NextStatus(), SampleStatus::kDeviceError);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(Faults(ModbusFault::kTimeout), 1U);
  EXPECT_EQ(sensor_->errors().exceptions[4], 1U);
  EXPECT_THAT(sensor_->Remarks(),
              Contains(HasSubstr("1 timeout, 1 exception 04 (device failure)")));
}

TEST_F(ModbusSensorTest, DamageIsABadFrameCountedByKind) {
  Started(Plain());
  for (const auto fault : {ModbusFault::kCrc, ModbusFault::kLength, ModbusFault::kUnit}) {
    int number = 0;
    device_->script = [&](bool) {
      return Device::Answer{.fault = ++number == 1 ? fault : ModbusFault::kNone};
    };
    EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
    EXPECT_EQ(NextStatus(), SampleStatus::kOk);
    EXPECT_EQ(Faults(fault), 1U);
  }
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
  device_->script = [](bool) { return Device::Answer{.is_missing = true}; };
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
  for (int row = 1; row < 500; ++row) EXPECT_EQ(NextRow().time_ns, first_ns + row * 20 * kMs);
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
  device_ = std::make_unique<Device>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return Device::Answer{.is_missing = true}; };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(started.error().Text(),
              HasSubstr("nothing answers to slave 1, function 03, 1 registers from 0 at 115200 "
                        "baud, parity even; check that the sensor is on, --slave"));
}

TEST_F(ModbusSensorTest, AnExceptionAtTheStartIsTold) {
  device_ = std::make_unique<Device>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return Device::Answer{.exception = 2}; };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("exception 02 (illegal data address)"));
}

TEST_F(ModbusSensorTest, RemarksSayWhatTheWireAllows) {
  Started(Plain());
  EXPECT_THAT(sensor_->Remarks(),
              Contains(HasSubstr("at most 203 readings/s: motion up to 79.2 Hz")));
  EXPECT_THAT(sensor_->Remarks(), Contains(HasSubstr("20-500 Hz vibration cannot be observed")));
}

}  // namespace
}  // namespace haptometer::acquire
