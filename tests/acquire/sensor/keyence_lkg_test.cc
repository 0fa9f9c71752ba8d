// An LK-G3001 on a manual clock: what its start finds, and what its values become.
#include "acquire/sensor/keyence/keyence_lkg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "acquire/emulator/lkg_unit.h"
#include "tests/acquire/device_transport.h"
#include "tests/acquire/il_series_emulated.h"
#include "tests/acquire/scripted_transport.h"
#include "tests/acquire/sensor_rows.h"
#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::acquire {
namespace {

using emulator::StillHead;
using ::testing::HasSubstr;
using trial::SampleStatus;

class KeyenceLkgTest : public ::testing::Test {
 protected:
  Result<void> StartEmulated(const emulator::LkgSetup& unit, const KeyenceLkgSetup& setup) {
    device_ = std::make_unique<emulator::LkgUnit>(unit);
    sensor_ = std::make_unique<KeyenceLkg>(
        std::make_unique<tests::DeviceTransport>(*device_, clock_), setup, clock_);
    return Start();
  }
  // a controller that gives these answers in turn, the last one for ever
  Result<void> StartScripted(std::vector<std::string> answers, const KeyenceLkgSetup& setup) {
    auto transport = std::make_unique<tests::ScriptedTransport>(
        clock_, [answers, next = std::size_t{0}](tests::ScriptedTransport& to,
                                                 const std::string& request) mutable {
          requests_.push_back(request);
          const std::string& answer = answers[std::min(next++, answers.size() - 1)];
          if (!answer.empty()) to.Send(answer, 5'000'000);
        });
    sensor_ = std::make_unique<KeyenceLkg>(std::move(transport), setup, clock_);
    return Start();
  }
  Result<void> Start() { return StartAndBegin(*sensor_); }
  Reading NextRow() { return NextRowOf(*sensor_); }

  ManualClock clock_;
  std::unique_ptr<emulator::Device> device_;
  std::unique_ptr<KeyenceLkg> sensor_;
  inline static std::vector<std::string> requests_;
};

TEST_F(KeyenceLkgTest, BothOutputsAreChannels) {
  ASSERT_TRUE(StartEmulated({.heads = {StillHead(1.234e-3), StillHead(-2e-3)}},
                            {.command = lkg::Command::kM0}));
  const auto& channels = sensor_->header().channels;
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[0].name, "displacement");
  EXPECT_EQ(channels[1].name, "displacement_OUT2");
  EXPECT_REL(channels[0].scale, 1e-7, 1e-15, "four decimals of a mm");
  EXPECT_EQ(sensor_->header().metadata.sensor, "keyence-lkg");
  const Reading row = NextRow();
  EXPECT_EQ(Counts(row.samples[0]), 12'340);
  EXPECT_EQ(Counts(row.samples[1]), -20'000);
}

TEST_F(KeyenceLkgTest, ItsModeIsLeftAsItIsFound) {
  const auto started = StartEmulated({.heads = {StillHead(0)}, .in_communication_mode = true}, {});
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(started.error().Text(),
              HasSubstr("refuses M1 with error 01: not in the controller's present mode; it was "
                        "left in communication mode"));
  requests_.clear();
  ASSERT_TRUE(StartScripted({"M1,+01.2345\r"}, {}));
  (void)NextRow();
  for (const std::string& request : requests_) EXPECT_EQ(request, "M1\r");
}

TEST_F(KeyenceLkgTest, SpecialValuesAreStatuses) {
  ASSERT_TRUE(StartScripted({"M1,+01.2345\r", "M1,+FFFFFFF\r", "M1,-FFFFFFF\r", "M1,XXXXXXXX\r",
                             "M1,--------\r", "ER,M1,99\r", "M1,+00.0001\r"},
                            {}));
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kOver);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kUnder);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kInvalid);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kInvalid);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kDeviceError);
  EXPECT_EQ(Counts(NextRow().samples[0]), 1);
}

TEST_F(KeyenceLkgTest, APointThatMovesIsFollowedWhereNoDigitIsLost) {
  ASSERT_TRUE(
      StartScripted({"M1,+01.2345\r", "M1,+012.345\r", "M1,-00001.2\r", "M1,+1.23456\r"}, {}));
  EXPECT_EQ(Counts(NextRow().samples[0]), 123'450);
  EXPECT_EQ(Counts(NextRow().samples[0]), -12'000);
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kBadFrame);
}

TEST_F(KeyenceLkgTest, WithoutANumberItAsksForTheDecimals) {
  EXPECT_THAT(StartScripted({"M1,XXXXXXXX\r"}, {}).error().Text(),
              HasSubstr("shows no number, so the place of its decimal point is not known; bring a "
                        "target into the range, or give <decimals>"));
  ASSERT_TRUE(StartScripted({"M1,XXXXXXXX\r", "M1,XXXXXXXX\r", "M1,+01.2345\r"}, {.decimals = 4}));
  EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kInvalid);
  EXPECT_EQ(Counts(NextRow().samples[0]), 12'345);
}

TEST_F(KeyenceLkgTest, SilenceAndGarbageAreToldApart) {
  EXPECT_THAT(StartScripted({""}, {}).error().Text(), HasSubstr("nothing answers at 9600 baud"));
  EXPECT_THAT(StartScripted({"\x80\x81\r"}, {}).error().Text(),
              HasSubstr("bytes come at 9600 baud, but no reply of an LK-G"));
}

TEST_F(KeyenceLkgTest, ANumberThatItsStepDoesNotHoldIsABadFrame) {
  // 10^9 steps of a micrometre are a kilometre
  for (const auto& [shown, counts] :
       {std::pair("M1,+1000000\r", 1'000'000'000), {"M1,-1000000\r", -1'000'000'000}}) {
    ASSERT_TRUE(StartScripted({"M1,+0000012\r", shown}, {.decimals = 3}));
    EXPECT_EQ(Counts(NextRow().samples[0]), counts);
  }
  for (const char* shown : {"M1,+1000001\r", "M1,-1000001\r"}) {
    ASSERT_TRUE(StartScripted({"M1,+0000012\r", shown}, {.decimals = 3}));
    EXPECT_EQ(RowStatus(NextRow()), SampleStatus::kBadFrame) << shown;
  }
}

TEST_F(KeyenceLkgTest, SaysWhatItsWireCarries) {
  // 3 + 12 characters of 10 bits at 9600 baud; both outputs have 3 + 21
  ASSERT_TRUE(StartScripted({"M1,+01.2345\r"}, {}));
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kLkgRate),
            "baud=9600 rate_hz=64 observable_hz=25");
  EXPECT_EQ(sensor_->header().metadata.nominal_rate_hz, std::nullopt);
  ASSERT_TRUE(StartScripted({"M0,+01.2345,+01.2345\r"}, {.command = lkg::Command::kM0}));
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kLkgRate),
            "baud=9600 rate_hz=40 observable_hz=15.625");
  ASSERT_TRUE(StartScripted({"M1,+01.2345\r"}, {.rate_hz = 12.8}));
  EXPECT_EQ(tests::NumbersOf(sensor_->Found(), FindingKind::kLkgRate),
            "baud=9600 rate_hz=12.8 observable_hz=5");
  EXPECT_EQ(sensor_->header().metadata.nominal_rate_hz, 12.8);
}

TEST_F(KeyenceLkgTest, TheSecondOutputAloneHasItsName) {
  ASSERT_TRUE(StartScripted({"M2,+0.12345\r"}, {.command = lkg::Command::kM2}));
  EXPECT_EQ(sensor_->header().channels.at(0).name, "displacement_OUT2");
  EXPECT_REL(sensor_->header().channels.at(0).scale, 1e-8, 1e-15, "five decimals of a mm");
  EXPECT_EQ(Counts(NextRow().samples[0]), 12'345);
}

TEST_F(KeyenceLkgTest, TheFirstNumberOfEitherOutputHasTheDecimals) {
  ASSERT_TRUE(StartScripted({"M0,XXXXXXXX,+012.345\r"}, {.command = lkg::Command::kM0}));
  EXPECT_REL(sensor_->header().channels.at(0).scale, 1e-6, 1e-15, "three decimals of a mm");
  const Reading row = NextRow();
  EXPECT_EQ(row.samples[0].status, SampleStatus::kInvalid);
  EXPECT_EQ(Counts(row.samples[1]), 12'345);
}

TEST_F(KeyenceLkgTest, ALineOfTheTimingInputIsNoReply) {
  ASSERT_TRUE(StartScripted({"M1,+01.2345\r", "G1,+09.9999\rM1,+00.0007\r"}, {}));
  EXPECT_EQ(Counts(NextRow().samples[0]), 7);
}

}  // namespace
}  // namespace haptometer::acquire
