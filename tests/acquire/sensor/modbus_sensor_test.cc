// A Modbus sensor on a scripted link and a manual clock: what may come, and what it means.
#include "acquire/sensor/modbus_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <utility>

#include "tests/acquire/scripted_modbus_device.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::EndsWith;
using ::testing::HasSubstr;
using trial::SampleStatus;
using Answer = ScriptedModbusDevice::Answer;

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
  for (const MonotonicNs longest_reply_ns : {kNsPerS, 3 * kNsPerS}) {
    SensorProfile profile = Plain();
    profile.longest_reply_ns = longest_reply_ns;
    Started(profile);
    EXPECT_EQ(NextStatus(), SampleStatus::kOk);
    // a byte each 10 ms for 10 s, and no reply
    device_->script = [](bool) { return Answer{.is_missing = true}; };
    for (int i = 0; i < 1000; ++i)
      device_->wire->Reply("?", kMs * (2 + MonotonicNs{10} * i), ModbusFault::kLength);
    Reading last = NextRow();
    EXPECT_EQ(RowStatus(last), SampleStatus::kBadFrame);
    // a second after the longest reply, with the next byte
    for (int row = 0; row < 2; ++row) {
      const Reading next = NextRow();
      EXPECT_EQ(RowStatus(next), SampleStatus::kBadFrame);
      EXPECT_EQ(next.reply_ns - last.reply_ns, longest_reply_ns + kNsPerS + 10 * kMs);
      last = next;
    }
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

TEST_F(ModbusSensorTest, RequestsThatComeBackAreNamedAndIgnored) {
  Started(Plain());
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kEcho));
  device_->wire->GiveRequestsBack();
  for (int row = 0; row < 3; ++row) EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kEcho), "echoes=3");
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kWireErrors));
}

TEST_F(ModbusSensorTest, AWireThatOnlySendsRequestsBackIsNamed) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.is_missing = true}; };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  device_->wire->GiveRequestsBack();
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(started.error().Text(),
              HasSubstr("sends each request back, and nothing answers to slave 1, function 03, 1 "
                        "registers from 0; check the wiring"));
}

TEST_F(ModbusSensorTest, EachRequestAtTheStartWaitsForTheLongestReply) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.is_missing = true}; };
  SensorProfile profile = Plain();
  profile.longest_reply_ns = 1500 * kMs;
  ModbusSensor sensor(device_->Link(), {profile, {}}, clock_);
  ASSERT_FALSE(sensor.Start(kNeverStop));
  EXPECT_EQ(clock_.Now(), 4500 * kMs);
}

TEST_F(ModbusSensorTest, AScaleRegisterOfZeroIsRefused) {
  const SensorProfile profile = BuiltInProfiles()[1];
  ASSERT_EQ(profile.name, "riftek-rf602");
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  ModbusSensor sensor(device_->Link(), {profile, {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(started.error().Text(), HasSubstr("register 5, which scales its values, holds 0"));
}

TEST_F(ModbusSensorTest, AnExceptionAtTheStartIsTold) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.exception = 2}; };
  ModbusSensor sensor(device_->Link(), {Plain(), {}}, clock_);
  const auto started = sensor.Start(kNeverStop);
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().Text(), HasSubstr("exception 02 (illegal data address)"));
}

TEST_F(ModbusSensorTest, TheAdviceOfAProfileIsTheRemedy) {
  // every request is answered by nothing, by an exception, by damage or by registers of 0
  const auto error = [&](const SensorProfile& profile, const Answer& answer,
                         ModbusFraming framing = ModbusFraming::kRtu) {
    device_ = std::make_unique<ScriptedModbusDevice>(clock_, framing, 1);
    device_->script = [&](bool) { return answer; };
    ModbusSensor sensor(device_->Link(), {profile, {}}, clock_);
    const auto started = sensor.Start(kNeverStop);
    return started ? std::string() : started.error().Text();
  };
  SensorProfile advised = Plain();
  advised.advice = "press the button";
  const Answer refused{.exception = 2};
  EXPECT_THAT(error(Plain(), refused), EndsWith("; give the <profile> of this sensor"));
  EXPECT_THAT(error(advised, refused), EndsWith("(illegal data address); press the button"));
  const Answer missing{.is_missing = true};
  EXPECT_THAT(error(Plain(), missing), EndsWith("in the profile, and A and B of the cable"));
  EXPECT_THAT(error(advised, missing), EndsWith("and A and B of the cable; press the button"));
  EXPECT_THAT(
      error(Plain(), missing, ModbusFraming::kTcp),
      EndsWith("nothing answers to slave 1, function 03, 1 registers from 0; check that the "
               "sensor is on, <slave> and the <profile>"));
  EXPECT_THAT(error(Plain(), {.fault = ModbusFault::kCrc}),
              HasSubstr("answers to slave 1, function 03, 1 registers from 0 come damaged (wrong "
                        "CRC); check"));
  SensorProfile scaled = Plain();
  scaled.scale_address = 5;
  EXPECT_THAT(error(scaled, {}), EndsWith("holds 0; check the <profile>"));
  scaled.advice = advised.advice;
  EXPECT_THAT(error(scaled, {}), EndsWith("holds 0; press the button"));
  // registers are named as the profile counts them
  SensorProfile from_one = Plain();
  from_one.address_base = from_one.address = from_one.value_address = 1;
  EXPECT_THAT(error(from_one, refused), HasSubstr("1 registers from 1 with exception 02"));
}

TEST_F(ModbusSensorTest, AScaleRegisterCountsFromTheBaseToo) {
  SensorProfile profile = Plain();
  profile.address_base = profile.address = profile.value_address = 1;
  profile.scale_address = 3;
  registers_[2] = 7;
  registers_[4] = 9;
  EXPECT_REL(Started(profile).header().channels.at(0).scale, 7 * profile.scale * profile.unit_m,
             1e-15, "two products");
}

TEST_F(ModbusSensorTest, ATcpProfileOnASerialPortIsADoubt) {
  SensorProfile tcp = Plain();
  tcp.transport = ModbusFraming::kTcp;
  EXPECT_EQ(NumbersOf(Started(tcp).Found(), FindingKind::kTcpProfile), "profile=plain");
  EXPECT_FALSE(Started(tcp, {}, ModbusFraming::kTcp).Found().Has(FindingKind::kTcpProfile));
  EXPECT_FALSE(Started(Plain()).Found().Has(FindingKind::kTcpProfile));
}

TEST_F(ModbusSensorTest, TheHeadIsMakerAndModelOrTheProfilesName) {
  EXPECT_EQ(Started(Plain()).header().metadata.head, "plain");
  SensorProfile named = Plain();
  named.maker = "Maker";
  named.model = "M1";
  EXPECT_EQ(Started(named).header().metadata.head, "Maker M1");
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

// --- how long nothing is asked ---

using Answer = ScriptedModbusDevice::Answer;

// The answer to the first reading of the recording is `answer`; checks are refused where there are
// none.
class ModbusPauses : public ModbusSensorTest {
 protected:
  // from the row's request, and from its reply, to the request of the next row
  struct Pause {
    MonotonicNs from_request_ns, from_reply_ns;
  };
  Pause After(const Answer& answer, bool has_checks, ModbusFraming framing = ModbusFraming::kRtu) {
    script_ = [=](bool is_reading) {
      return Answer{.exception = is_reading || has_checks ? 0 : 2};
    };
    Started(Plain(), {}, framing);
    int number = 0;
    device_->script = [this, answer, number](bool is_reading) mutable {
      return is_reading && ++number == 1 ? answer : script_(is_reading);
    };
    const Reading row = NextRow();
    EXPECT_NE(RowStatus(row), SampleStatus::kOk);
    const Reading next = NextRow();
    EXPECT_EQ(RowStatus(next), SampleStatus::kOk);
    return {next.time_ns - row.time_ns, next.time_ns - row.reply_ns};
  }
};

// a reading and a check, each answered after 2 ms and followed by a silent interval of 1.75 ms
constexpr MonotonicNs kTwoStepsNs = 7'500'000;

TEST_F(ModbusPauses, AfterAnExceptionTheWireIsSilentFor20MsAndTheStepsFollow) {
  EXPECT_EQ(After({.exception = 4}, true).from_reply_ns, 20 * kMs + kTwoStepsNs);
  EXPECT_EQ(After({.exception = 4}, false).from_reply_ns, 1'750'000) << "no step is known";
  EXPECT_EQ(After({.exception = 4}, false, ModbusFraming::kTcp).from_reply_ns, 0);
}

TEST_F(ModbusPauses, AfterDamageTheWireIsSilentFor20MsAndTheStepsFollow) {
  EXPECT_EQ(After({.fault = ModbusFault::kCrc}, true).from_reply_ns, 20 * kMs + kTwoStepsNs);
  // without a step no reply may come any more
  EXPECT_EQ(After({.fault = ModbusFault::kCrc}, false).from_request_ns, kNsPerS);
}

TEST_F(ModbusPauses, AfterSilenceTheLongestReplyIsWaitedFor) {
  EXPECT_EQ(After({.is_missing = true}, true).from_request_ns, kNsPerS + kTwoStepsNs);
  EXPECT_EQ(After({.is_missing = true}, false).from_request_ns, kNsPerS);
  // over TCP the identifier tells a late reply: half a second of patience
  EXPECT_EQ(After({.is_missing = true}, false, ModbusFraming::kTcp).from_request_ns, kNsPerS / 2);
}

TEST_F(ModbusSensorTest, ASecondBeginningWaitsForWhatWasAskedBefore) {
  script_ = [](bool is_reading) { return Answer{.exception = is_reading ? 0 : 2}; };
  Started(Plain());
  MonotonicNs asked_ns = 0;
  device_->script = [&](bool) {
    const bool is_first = asked_ns == 0;
    if (is_first) asked_ns = clock_.Now();
    return Answer{.is_missing = is_first};
  };
  Reading reading;
  EXPECT_EQ(sensor_->Next(reading), Outcome::kNothing);
  (void)sensor_->Begin();
  EXPECT_EQ(NextRow().time_ns - asked_ns, kNsPerS);
}

// --- what is thrown away ---

TEST_F(ModbusSensorTest, ASecondReplyIsCountedWithItsBytes) {
  // it comes before the next request, or while that one is answered
  for (const MonotonicNs again_after_ns : {kMs, 4 * kMs}) {
    Started(Plain());
    int number = 0;
    std::uint64_t twice = 0;
    device_->script = [&](bool is_reading) {
      ++number;
      const bool is_twice = is_reading && number > 70 && number < 290 && number % 5 == 0;
      twice += is_twice ? 1 : 0;
      return Answer{.after_ns = 9 * kMs, .again_after_ns = is_twice ? again_after_ns : 0};
    };
    for (int row = 0; row < 300; ++row) EXPECT_EQ(NextStatus(), SampleStatus::kOk);
    EXPECT_EQ(twice, 43U);
    EXPECT_EQ(sensor_->discarded_bytes(), 7 * twice) << "a frame of one register has 7 bytes";
    EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kSurplusReplies), "replies=43");
  }
}

TEST_F(ModbusSensorTest, AReplyToAnotherTransactionIsCountedWithItsBytes) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  int number = 0;
  device_->script = [&](bool) { return Answer{.off_by = ++number == 1 ? -1 : 0}; };
  EXPECT_EQ(NextStatus(), SampleStatus::kBadFrame);
  EXPECT_EQ(sensor_->discarded_bytes(), 11U) << "7 of the header and 4";
}

TEST_F(ModbusSensorTest, RepliesSoonerThanTheWireAreFound) {
  // 15 characters of 11 bits at 115200 baud are 1.432 ms
  Started(Plain());
  device_->script = [](bool) { return Answer{.after_ns = kMs}; };
  for (int row = 0; row < 5; ++row) (void)NextRow();
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kRepliesTooSoon),
            "too_soon=5 replies=5 wire_s=0.00143229 rate_hz=698.182");
}

TEST_F(ModbusSensorTest, AReplyIsHeldBelowNineTenthsOfTheFastestOnly) {
  Started(Plain());
  MonotonicNs after_ns = 10 * kMs;
  device_->script = [&](bool) { return Answer{.after_ns = after_ns}; };
  for (int row = 0; row < 64; ++row) EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  // 0.9 x 10 ms, and then 0.9 x 9 ms less 1 ns; a held reply is given after 1.5 x 10 ms
  after_ns = 9 * kMs;
  const Reading at_once = NextRow();
  after_ns = 8'099'999;
  const Reading held = NextRow();
  EXPECT_EQ(held.time_ns - at_once.time_ns, 9 * kMs + 1'750'000) << "and the silent interval";
  EXPECT_EQ(held.reply_ns - held.time_ns, 8'099'999);
  EXPECT_EQ(held.samples[0].raw.bits(), device_->readings);
  EXPECT_EQ(NextRow().time_ns - held.time_ns, 15 * kMs);
}

TEST_F(ModbusSensorTest, ARepliesTimeIsTooShortBelowItsWiresAlone) {
  Started(Plain());
  MonotonicNs after_ns = RtuExchangeNs(Plain());
  device_->script = [&](bool) { return Answer{.after_ns = after_ns}; };
  (void)NextRow();
  EXPECT_FALSE(sensor_->Found().Has(FindingKind::kRepliesTooSoon));
  --after_ns;
  (void)NextRow();
  EXPECT_EQ(NumbersOf(sensor_->Found(), FindingKind::kRepliesTooSoon),
            "too_soon=1 replies=2 wire_s=0.00143229 rate_hz=698.182");
}

// --- the channel ---

TEST_F(ModbusSensorTest, TheChannelIsThatOfTheProfile) {
  // (number x 0.5 + 3) cm, of 2 to 100
  SensorProfile profile = Plain();
  profile.unit_m = 1e-2;
  profile.scale = 0.5;
  profile.offset = 3;
  profile.least_number = 2;
  profile.most_number = 100;
  trial::ChannelFormat channel = Started(profile).header().channels.at(0);
  EXPECT_REL(channel.scale, 5e-3, 1e-15, "a product");
  EXPECT_REL(channel.offset, 0.03, 1e-15, "a product");
  EXPECT_REL(channel.resolution, 5e-3, 1e-15, "one count");
  EXPECT_REL(channel.range_min, 0.04, 1e-15, "a product and a sum");
  EXPECT_REL(channel.range_max, 0.53, 1e-15, "a product and a sum");
  // what the maker states comes first
  profile.resolution_m = 1e-4;
  profile.range_min_m = 0.05;
  profile.range_max_m = 0.5;
  channel = Started(profile).header().channels.at(0);
  EXPECT_EQ(channel.resolution, 1e-4);
  EXPECT_EQ(channel.range_min, 0.05);
  EXPECT_EQ(channel.range_max, 0.5);
}

TEST_F(ModbusSensorTest, AFallingChannelHasAStepAndNoRange) {
  SensorProfile profile = Plain();
  profile.scale = -2;
  profile.least_number = 2;
  const trial::ChannelFormat& channel = Started(profile).header().channels.at(0);
  EXPECT_REL(channel.scale, -2e-3, 1e-15, "a product");
  EXPECT_REL(channel.resolution, 2e-3, 1e-15, "one count");
  EXPECT_EQ(channel.range_min, trial::ChannelFormat{}.range_min);
}

TEST_F(ModbusSensorTest, TheLimitsOfTheNumberAreWithinTheRange) {
  SensorProfile profile = Plain();
  profile.count = 3;
  profile.value_address = 1;
  profile.type = RegisterType::kI16;
  profile.least_number = -2;
  profile.most_number = 100;
  registers_[1] = 50;
  Started(profile);
  for (const auto& [number, status] : {std::pair(-3, SampleStatus::kUnder),
                                       {-2, SampleStatus::kOk},
                                       {100, SampleStatus::kOk},
                                       {101, SampleStatus::kOver}}) {
    device_->registers[1] = static_cast<std::uint16_t>(number);
    const Reading reading = NextRow();
    EXPECT_EQ(RowStatus(reading), status) << number;
    EXPECT_EQ(Counts(reading), number);
  }
}

TEST_F(ModbusSensorTest, AStatusBitMayMeanAnError) {
  SensorProfile profile = Plain();
  profile.count = 2;
  profile.status_address = 1;
  profile.status_mask = 0x8000;
  profile.status_meaning = StatusMeaning::kDeviceError;
  registers_[1] = 0x7FFF;
  Started(profile);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
  device_->registers[1] = 0x8000;
  EXPECT_EQ(NextStatus(), SampleStatus::kDeviceError);
}

TEST_F(ModbusSensorTest, EqualReadingsWithinTheSensorsPeriodAreRepeated) {
  // polls are 3.75 ms apart: a reply after 2 ms and the silent interval; 10 ms are 2.67 of them
  SensorProfile profile = Plain();
  profile.count = 3;
  profile.value_address = 1;
  profile.fastest_rate_hz = 100;
  Started(profile);
  for (int row = 0; row < 9; ++row) {
    EXPECT_EQ(NextStatus(), row % 3 == 0 ? SampleStatus::kOk : SampleStatus::kRepeated) << row;
  }
}

TEST_F(ModbusSensorTest, TheNominalRateIsTheLeastOfWireSensorAndWish) {
  const auto nominal_hz = [&](std::optional<double> sensor_hz, std::optional<double> wish_hz,
                              ModbusFraming framing) {
    SensorProfile profile = Plain();
    profile.fastest_rate_hz = sensor_hz;
    return Started(profile, wish_hz, framing).header().metadata.nominal_rate_hz;
  };
  // 165 bits at 115200 baud and 3.5 ms
  EXPECT_REL(nominal_hz({}, {}, ModbusFraming::kRtu).value(), 1 / (165 / 115200.0 + 3.5e-3), 1e-6,
             "rounded to nanoseconds");
  EXPECT_EQ(nominal_hz(200, {}, ModbusFraming::kRtu), 200);
  EXPECT_EQ(nominal_hz(200, 50, ModbusFraming::kRtu), 50);
  EXPECT_EQ(nominal_hz({}, {}, ModbusFraming::kTcp), std::nullopt);
  EXPECT_EQ(nominal_hz(1000, {}, ModbusFraming::kTcp), 1000);
  EXPECT_EQ(nominal_hz({}, 300, ModbusFraming::kTcp), 300);
}

TEST_F(ModbusSensorTest, TheHeaderHasTheRequestOfTheWire) {
  SensorProfile profile = Plain();
  profile.address_base = 1;
  profile.address = 1;
  profile.value_address = 1;
  const auto& fields = Started(profile).header().metadata.fields;
  EXPECT_EQ(fields.at("modbus_address_on_the_wire"), "0");
  EXPECT_EQ(fields.at("modbus_count"), "1");
  EXPECT_EQ(fields.at("modbus_slave"), "1");
  EXPECT_EQ(fields.at("modbus_function"), "3");
  EXPECT_EQ(fields.at("modbus_value"), "u16 ABCD at 1");
}

}  // namespace
}  // namespace haptometer::acquire
