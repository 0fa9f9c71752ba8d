// The rule: a late reply of a Modbus device is never the next reading.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/acquire/scripted_modbus_device.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;

class ModbusLateReply : public ModbusSensorTest {
 protected:
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
};

TEST_F(ModbusLateReply, AThousandLateRtuRepliesAreNeverTheNextReading) {
  Started(Plain());
  // late by anything up to four times the wait after which no reply should come any more
  std::mt19937 random(7);
  std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 4000 * kMs);
  device_->script = [&](bool is_reading) {
    return ScriptedModbusDevice::Answer{
        .after_ns = is_reading && random() % 2 == 0 ? late_ns(random) : 2 * kMs};
  };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusLateReply, ADoubledReplyIsNotTheNextReading) {
  for (const MonotonicNs again_after_ns : {kMs, 4 * kMs, 7 * kMs}) {
    Started(Plain());
    int rows = 0;
    device_->script = [&](bool is_reading) {
      const bool is_twice = is_reading && rows > 70 && rows % 5 == 0;
      return ScriptedModbusDevice::Answer{.after_ns = 9 * kMs,
                                          .again_after_ns = is_twice ? again_after_ns : 0};
    };
    Reading reading;
    int wrong = 0;
    for (rows = 0; rows < 400;) {
      if (sensor_->Next(reading) != Outcome::kReading) continue;
      ++rows;
      ASSERT_TRUE(trial::IsMeasurement(RowStatus(reading)));
      wrong += reading.samples[0].raw.bits() != device_->readings;
    }
    EXPECT_EQ(wrong, 0) << again_after_ns;
    EXPECT_TRUE(sensor_->Found().Has(FindingKind::kSurplusReplies));
  }
}

TEST_F(ModbusLateReply, NorWhenChecksAreLateToo) {
  Started(Plain());
  std::mt19937 random(8);
  std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 4000 * kMs);
  device_->script = [&](bool) {
    return ScriptedModbusDevice::Answer{.after_ns = random() % 3 == 0 ? late_ns(random) : 2 * kMs,
                                        .exception = random() % 7 == 0 ? 6 : 0};
  };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusLateReply, NorWithinTheLongestReplyWhenChecksAreRefusedOrIgnored) {
  for (const bool is_ignored : {false, true}) {
    std::mt19937 random(8);
    std::uniform_int_distribution<MonotonicNs> late_ns(510 * kMs, 950 * kMs);
    script_ = [&, is_ignored](bool is_reading) {
      return ScriptedModbusDevice::Answer{.after_ns = random() % 3 == 0 ? late_ns(random) : 2 * kMs,
                                          .exception = is_reading ? 0 : 2,
                                          .is_missing = !is_reading && is_ignored};
    };
    Started(Plain());
    ExpectNoneMisattributed(1000);
    EXPECT_THAT(NumbersOf(sensor_->Found(), FindingKind::kNoCheckRequest),
                HasSubstr("longest_reply_s=1"));
  }
}

TEST_F(ModbusLateReply, AThousandLateTcpRepliesAreNeverTheNextReading) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  std::mt19937 random(9);
  std::uniform_int_distribution<MonotonicNs> late_ns(501 * kMs, 900 * kMs);
  device_->script = [&](bool) {
    return ScriptedModbusDevice::Answer{.after_ns = random() % 8 == 0 ? late_ns(random) : 2 * kMs};
  };
  ExpectNoneMisattributed(1000);
  EXPECT_GT(Faults(ModbusFault::kTransaction), 100U);
}

TEST_F(ModbusLateReply, WrongTransactionsAreNeverReadings) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  int number = 0;
  device_->script = [&](bool) {
    return ScriptedModbusDevice::Answer{.off_by = ++number % 3 == 0 ? -1 : 0};
  };
  ExpectNoneMisattributed(1000);
}

TEST_F(ModbusLateReply, APeerThatStaysOffByOneIsAConnectionLost) {
  Started(Plain(), {}, ModbusFraming::kTcp);
  device_->script = [](bool) { return ScriptedModbusDevice::Answer{.off_by = -1}; };
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

// a tare begins, a recording begins again: what is on its way stays so
TEST_F(ModbusLateReply, ALateReplyIsNeverTheFirstReadingOfASecondBeginning) {
  for (const bool has_checks : {true, false}) {
    for (const MonotonicNs late_ns : {600 * kMs, 900 * kMs, 950 * kMs}) {
      for (const bool row_is_awaited : {true, false}) {
        script_ = [=](bool is_reading) {
          return ScriptedModbusDevice::Answer{.exception = is_reading ? 0 : 2};
        };
        if (has_checks) script_ = nullptr;
        Started(Plain());
        int number = 0;
        device_->script = [&](bool is_reading) {
          return ScriptedModbusDevice::Answer{
              .after_ns = is_reading && ++number == 2 ? late_ns : 2 * kMs,
              .exception = is_reading || has_checks ? 0 : 2};
        };
        EXPECT_EQ(NextStatus(), SampleStatus::kOk);
        Reading reading;
        if (row_is_awaited) {
          EXPECT_EQ(NextStatus(), SampleStatus::kLate);
        } else {
          while (number < 2) EXPECT_EQ(sensor_->Next(reading), Outcome::kNothing);
        }
        const MonotonicNs begin_ns = sensor_->Begin();
        for (int row = 0; row < 3; ++row) {
          const Reading next = NextRow();
          EXPECT_GE(next.time_ns, begin_ns);
          EXPECT_EQ(RowStatus(next), SampleStatus::kOk);
          EXPECT_EQ(next.samples[0].raw.bits(), device_->readings)
              << has_checks << ' ' << late_ns << ' ' << row_is_awaited;
        }
      }
    }
  }
}

TEST_F(ModbusLateReply, ASilentDeviceIsAskedUntilItAnswers) {
  Started(Plain());
  int number = 0;
  device_->script = [&](bool) { return ScriptedModbusDevice::Answer{.is_missing = ++number <= 5}; };
  for (int row = 0; row < 5; ++row) EXPECT_EQ(NextStatus(), SampleStatus::kLate);
  EXPECT_EQ(NextStatus(), SampleStatus::kOk);
}

TEST_F(ModbusLateReply, AfterSilenceAtTheStartOldRepliesAreNoReadings) {
  device_ = std::make_unique<ScriptedModbusDevice>(clock_, ModbusFraming::kRtu, 1);
  int number = 0;
  device_->script = [&](bool) {
    return ScriptedModbusDevice::Answer{.after_ns = ++number == 1 ? 1500 * kMs : 2 * kMs};
  };
  sensor_ = std::make_unique<ModbusSensor>(device_->Link(), ModbusSetup{Plain(), {}}, clock_);
  ASSERT_TRUE(sensor_->Start(kNeverStop));
  (void)sensor_->Begin();
  EXPECT_EQ(NextRow().samples[0].raw.bits(), device_->readings);
}

}  // namespace
}  // namespace haptometer::acquire
